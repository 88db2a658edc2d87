"""What a user of the arm node does in a grasp trial: waits until the node has found an object, picks, places."""

import collections
import time

import numpy

import extperfc.arm
import grasp_scene as scene
from grasp_robot import matrix
from ros_session import Stalled

ANSWER_S = 60.0   # [s] of real time for the node to come up
ACTION_S = 180.0  # simulated seconds after which an action that has not answered is cancelled
NO_ANSWER = "no answer"

# code: of extperfc/ArmCode or ClientCode, None without an answer; seconds: of simulated time
Status = collections.namedtuple("Status", "code message seconds")


def size_of(scene_object):
    """Extent [m] along the axes of an object of one primitive (extperfc/SceneObject)."""
    primitive = scene_object.primitives[0]
    d = primitive.dimensions
    if primitive.type == primitive.BOX:
        return tuple(d)
    if primitive.type == primitive.SPHERE:
        return (2 * d[0],) * 3
    return 2 * d[1], 2 * d[1], d[0]  # cylinder or cone: height, radius


def pose_at(shape, place_pose):
    """Of the object's centre, in the frame map."""
    return (*scene.middle(shape, place_pose), 0.0, 0.0, place_pose.yaw)


class GraspArms:
    """The arms of a GraspRobot, by the package's own Python client."""

    def __init__(self, robot):
        self.robot = robot
        self.arms = extperfc.arm.Arm("both", wait_s=ANSWER_S)
        self.scene = self.arms.scene
        self._support = None  # place_pose of the last show_support()

    def act(self, begin_motion):
        """Status of a motion that `begin_motion` returns; cancelled when it does not answer in time."""
        begin = self.robot.now()
        try:
            motion = begin_motion()
            while not motion.done:
                if not self.robot.alive():
                    raise Stalled("the simulation ended")
                if self.robot.now() > begin + ACTION_S:
                    motion.cancel()
                    return Status(None, NO_ANSWER, self.robot.now() - begin)
                time.sleep(0.02)
            result = motion.result()
        except extperfc.arm.ArmError as error:
            return Status(error.code, error.message, self.robot.now() - begin)
        return Status(0, result.message, self.robot.now() - begin)

    def move_home(self):
        """Both arms to the pose neutral, out of the image."""
        return self.act(lambda: self.arms.move_to("neutral", wait=False))

    def open_grippers(self):
        """Both, one after the other; the first time calibrates them."""
        try:
            self.arms.open(timeout=ANSWER_S)
        except extperfc.arm.ArmError as error:
            raise Stalled(f"the grippers do not open: {error}") from None

    def show_support(self, place_pose):
        """Clears the node's scene, then adds tray and column. The node has to find the objects itself."""
        self._support = place_pose
        under = place_pose.top - scene.TRAY_SIZE[2]
        self.scene.clear()
        self.scene.add_box("tray", scene.TRAY_SIZE, (*scene.TRAY_XY, under + scene.TRAY_SIZE[2] / 2), frame="map")
        self.scene.add_cylinder("column", scene.COLUMN_DIAMETER / 2, scene.COLUMN_HEIGHT,
                                (*scene.COLUMN_XY, under - scene.COLUMN_HEIGHT / 2), frame="map")

    def forget_objects(self):
        """Clears what the node has found. Call when an object was removed without a gripper."""
        if self._support:
            self.show_support(self._support)

    def place_of(self, scene_object):
        """map_T_thing of an extperfc/SceneObject, 4 x 4."""
        return self.robot.transform("map", scene_object.pose.header.frame_id) @ matrix(scene_object.pose.pose)

    def found(self):
        """{name: extperfc/SceneObject} of what has a label: what the node has found."""
        return {name: scene_object for name, scene_object in self.scene.objects.items() if scene_object.label}

    def wait_found(self, shape, true_middle, within_m=0.15, seconds=5.0):
        """(the object of this class in the node's scene, None: not in time; simulated time that it took; names of all other
        found objects). The truth is used only to select the object of the class."""
        begin = self.robot.now()
        while True:
            scene_objects = self.found()
            for name, scene_object in scene_objects.items():
                near = numpy.linalg.norm(self.place_of(scene_object)[:3, 3] - true_middle) < within_m
                if scene_object.label == shape and near:
                    return scene_object, self.robot.now() - begin, sorted(scene_objects.keys() - {name})
            if self.robot.now() > begin + seconds:
                return None, self.robot.now() - begin, sorted(scene_objects)
            if not self.robot.alive():
                raise Stalled("the simulation ended")
            time.sleep(0.05)

    def pick(self, shape, lift_m, place_at):
        """By its class, with the arm that reaches it better and can place it at the place pose."""
        return self.act(lambda: self.arms.pick(shape, lift=lift_m, place_at=pose_at(shape, place_at), any_yaw=True,
                                               frame="map", wait=False))

    def place(self, shape, place_pose):
        """At the place pose, with any yaw."""
        return self.act(lambda: self.arms.place(pose_at(shape, place_pose), any_yaw=True, frame="map", wait=False))
