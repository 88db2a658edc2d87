"""The simulated robot before its tray, as a program sees it: puts objects, waits for detections, asks the truth."""

import math
import threading
import time

import numpy

import grasp_scene as scene
from ros_session import Stalled

from extperfc.robot_description import quaternion_of_rotation

PARKING = {"cube": (-1.5, 1.5), "sphere": (-1.2, 1.5), "cone": (-0.9, 1.5)}  # on the side table
PARKING_TOP_M = 0.7
OPTICAL_FRAME = "camera_color_optical_frame"


def matrix(pose):
    """4 x 4 of a geometry_msgs/Pose."""
    x, y, z, w = pose.orientation.x, pose.orientation.y, pose.orientation.z, pose.orientation.w
    result = numpy.eye(4)
    result[:3, :3] = [[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
                      [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
                      [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]]
    result[:3, 3] = (pose.position.x, pose.position.y, pose.position.z)
    return result


class GraspRobot:
    """One per process; call after rospy.init_node. `alive()` returns True while the simulation runs."""

    def __init__(self, alive):
        import geometry_msgs.msg
        import rospy
        import tf2_ros
        import vision_msgs.msg

        self.rospy = rospy
        self.alive = alive
        self.geometry = geometry_msgs.msg
        self.lock = threading.Lock()
        self.names = {}     # topic: class names
        self.truth = None   # vision_msgs/Detection3DArray
        self.found = None
        self.tf = tf2_ros.Buffer()
        self.listener = tf2_ros.TransformListener(self.tf)
        rospy.Subscriber("sim/truth/vision_info", vision_msgs.msg.VisionInfo, self._on_info, "truth")
        rospy.Subscriber("vision_info", vision_msgs.msg.VisionInfo, self._on_info, "found")
        rospy.Subscriber("sim/truth/objects", vision_msgs.msg.Detection3DArray, self._on_truth, queue_size=2)
        rospy.Subscriber("detections_3d", vision_msgs.msg.Detection3DArray, self._on_found, queue_size=2)

    def _on_info(self, message, key):
        self.names[key] = self.rospy.get_param(message.database_location, [])

    def _on_truth(self, message):
        with self.lock:
            self.truth = message

    def _on_found(self, message):
        with self.lock:
            self.found = message

    def now(self):
        return self.rospy.Time.now().to_sec()

    def wait(self, condition, what, real_s=90.0):
        deadline = time.monotonic() + real_s
        while not condition():
            if not self.alive() or self.rospy.is_shutdown():
                raise Stalled("the simulation ended")
            if time.monotonic() > deadline:
                raise Stalled(f"waited {real_s:.0f} s for {what}")
            time.sleep(0.02)

    def sleep(self, seconds):
        """Of simulated time."""
        end = self.now() + seconds
        self.wait(lambda: self.now() >= end, "simulated time", 60 + 20 * seconds)

    def ready(self):
        """Waits until everything was heard once."""
        self.wait(lambda: self.now() > 0 and self.truth is not None and "truth" in self.names, "the simulator's truth")
        self.wait(lambda: self.found is not None and "found" in self.names, "detections")

    def camera(self):
        """(width, height, focal length, cx, cy) [px] and map_T_camera."""
        import sensor_msgs.msg
        info = self.rospy.wait_for_message("camera/color/camera_info", sensor_msgs.msg.CameraInfo, 30)
        self.wait(lambda: self.tf.can_transform("map", OPTICAL_FRAME, self.rospy.Time(0)), "tf of the camera")
        return (info.width, info.height, info.K[0], info.K[2], info.K[5]), self.transform("map", OPTICAL_FRAME)

    def transform(self, target, source):
        """target_T_source now, 4 x 4."""
        found = self.tf.lookup_transform(target, source, self.rospy.Time(0), self.rospy.Duration(5)).transform
        pose = self.geometry.Pose()
        pose.position.x, pose.position.y, pose.position.z = found.translation.x, found.translation.y, found.translation.z
        pose.orientation = found.rotation
        return matrix(pose)

    def pose(self, position, yaw=0.0):
        result = self.geometry.Pose()
        result.position.x, result.position.y, result.position.z = map(float, position)
        result.orientation.z, result.orientation.w = math.sin(yaw / 2), math.cos(yaw / 2)
        return result

    # The simulator.

    def move_body(self, name, position, yaw=0.0):
        self._move_body(name, self.pose(position, yaw))

    def move_body_to(self, name, map_T_body):
        """The same to a 4 x 4."""
        pose = self.pose(map_T_body[:3, 3])
        o = pose.orientation
        o.x, o.y, o.z, o.w = quaternion_of_rotation(map_T_body[:3, :3])
        self._move_body(name, pose)

    def _move_body(self, name, pose):
        import extperfc.srv
        request = extperfc.srv.MoveBodyRequest(name=name, pose=pose)
        answer = self.rospy.ServiceProxy("sim/move_body", extperfc.srv.MoveBody)(request)
        if not answer.success:
            raise Stalled(f"sim/move_body {name}: {answer.message}")

    def park(self, shape):
        self.move_body(shape, scene.body_position(shape, scene.PlacePose(*PARKING[shape], PARKING_TOP_M, 0.0)))

    def park_all(self):
        """Parks all objects."""
        for shape in scene.SHAPES:
            self.park(shape)

    def put(self, shape, place_pose):
        """Moves tray and object to the place pose and parks the other objects. Waits until the object rests."""
        self.park_all()
        under = place_pose.top - scene.TRAY_SIZE[2]
        self.move_body("tray", (*scene.TRAY_XY, under))
        self.move_body("column", (*scene.COLUMN_XY, under - scene.COLUMN_HEIGHT))
        self.move_body(shape, scene.body_position(shape, place_pose) + (0, 0, 5e-4), place_pose.yaw)
        self.sleep(1.0)
        off = numpy.linalg.norm(self.true_pose(shape)[:3, 3] - scene.body_position(shape, place_pose))
        if off > 0.005:
            raise Stalled(f"the {shape} does not stand where it was put, but {off:.3f} m off")

    def true_pose(self, shape):
        """map_T_body of the first object of this class, 4 x 4."""
        with self.lock:
            for detection in self.truth.detections:
                if self.names["truth"][detection.results[0].id] == shape:
                    return scene.body_of(shape, matrix(detection.bbox.center))
        raise Stalled(f"no {shape} in sim/truth/objects")

    def save_image(self, topic, file, seconds):
        """The next image of a topic, as a PNG. Raises rospy.ROSException when none comes in time (real)."""
        import cv2
        import sensor_msgs.msg

        from extperfc.calibrate.messages import image_of_message
        message = self.rospy.wait_for_message(topic, sensor_msgs.msg.Image, seconds)
        cv2.imwrite(str(file), image_of_message(message))

    # Detection.

    def wait_detected(self, shape, true_middle, within_m=0.15, seconds=5.0):
        """The first estimate of the object that is newer than this call (vision_msgs/BoundingBox3D), None: not found in time;
        and the simulated time that it took. The truth is used only to distinguish the object from false detections."""
        begin = self.now()
        self.wait(lambda: self.now() > begin, "simulated time")
        while self.now() < begin + seconds:
            with self.lock:
                message = self.found
            if message.header.stamp.to_sec() > begin:
                for detection in message.detections:
                    if self.names["found"][detection.results[0].id] != shape:
                        continue
                    if numpy.linalg.norm(matrix(detection.bbox.center)[:3, 3] - true_middle) < within_m:
                        return detection.bbox, self.now() - begin
            time.sleep(0.02)
        return None, self.now() - begin

    def from_tip(self, shape):
        """Distance [m] of the object's origin from the nearer gripper's tip."""
        body = self.true_pose(shape)[:3, 3]
        return min(numpy.linalg.norm(self.transform("map", f"{side}_gripper")[:3, 3] - body) for side in ("left", "right"))
