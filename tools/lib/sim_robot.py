"""The simulated robot with a localizer, as a program sees it: moves it and compares the pose it believes with the truth."""

import math
import threading
import time

import cv2
import numpy

from pose_errors import Pose, Track, compose, error, inverse
from ros_session import Stalled

MIN_CLEARANCE_M = 0.65  # of the robot's middle to what stands around; its corners are 0.57 m away


def planar(pose):
    """The Pose of a geometry_msgs/Pose."""
    q = pose.orientation
    return Pose(pose.position.x, pose.position.y, math.atan2(2 * (q.w * q.z + q.x * q.y), 1 - 2 * (q.y * q.y + q.z * q.z)))


def towards(here, goal, speed_m_s):
    """Velocity (vx, vy, wz) in the robot's own frame to a point, facing it; a holonomic base turns while it drives."""
    dx, dy = goal[0] - here.x, goal[1] - here.y
    away, bearing = math.hypot(dx, dy), math.remainder(math.atan2(dy, dx) - here.yaw, 2 * math.pi)
    speed = min(speed_m_s, 1.5 * away) * max(0.0, math.cos(bearing))
    return speed * math.cos(bearing), speed * math.sin(bearing), max(-1.0, min(1.0, 2.0 * bearing))


def wander(here, clearance_at, yaw_sign):
    """Velocity of a robot that drives in slight bows where there is room ahead and rotates where there is not."""
    ahead = [(here.x + ahead_m * math.cos(here.yaw), here.y + ahead_m * math.sin(here.yaw)) for ahead_m in (0.2, 0.4, 0.6)]
    if all(clearance_at(x, y) > MIN_CLEARANCE_M for x, y in ahead):
        return 0.5, 0.0, 0.2 * yaw_sign
    return 0.0, 0.0, 0.8 * yaw_sign


class SimRobot:
    """One per process; call after rospy.init_node."""

    def __init__(self):
        import geometry_msgs.msg
        import nav_msgs.msg
        import rospy
        import sensor_msgs.msg

        self.rospy = rospy
        self.messages = geometry_msgs.msg
        self.lock = threading.Lock()
        self.truth, self.odometry, self.map_T_odom = Track(), Track(), Track()
        self.map = None
        self.distances = None
        self.scan = None
        self.command = None  # true pose -> velocity
        self.last_update_s = None
        self.updates = 0
        self.twist = rospy.Publisher("cmd_vel", geometry_msgs.msg.Twist, queue_size=1)
        self.initialpose = rospy.Publisher("initialpose", geometry_msgs.msg.PoseWithCovarianceStamped, queue_size=1)
        rospy.Subscriber("sim/truth/map", nav_msgs.msg.OccupancyGrid, self._on_map)
        rospy.Subscriber("odom", nav_msgs.msg.Odometry, self._on_odometry, queue_size=200)
        rospy.Subscriber("scan", sensor_msgs.msg.LaserScan, self._on_scan, queue_size=1)
        rospy.Subscriber("amcl_pose", geometry_msgs.msg.PoseWithCovarianceStamped, self._on_pose, queue_size=50)
        rospy.Subscriber("sim/truth/odom", nav_msgs.msg.Odometry, self._on_truth, queue_size=200)

    def _on_map(self, message):
        self.map = message

    def _on_scan(self, message):
        self.scan = message

    def _on_odometry(self, message):
        with self.lock:
            self.odometry.add(message.header.stamp.to_sec(), planar(message.pose.pose))

    def _on_pose(self, message):
        """The localizer's correction of odometry holds from this scan on."""
        stamp = message.header.stamp.to_sec()
        deadline = time.monotonic() + 2.0
        while time.monotonic() < deadline:  # odometry of the scan's time may still be on its way
            with self.lock:
                odom_T_base = self.odometry.at(stamp)
                if odom_T_base is not None:
                    self.map_T_odom.add(stamp, compose(planar(message.pose.pose), inverse(odom_T_base)))
                    self.last_update_s = stamp
                    self.updates += 1
                    return
            time.sleep(0.005)

    def _on_truth(self, message):
        here = planar(message.pose.pose)
        with self.lock:
            self.truth.add(message.header.stamp.to_sec(), here)
            command = self.command
        if command is None:
            return
        velocity = self.messages.Twist()
        velocity.linear.x, velocity.linear.y, velocity.angular.z = command(here)
        self.twist.publish(velocity)

    def now(self):
        """Time [s] of the latest true pose."""
        with self.lock:
            return self.truth.stamps[-1] if self.truth.stamps else 0.0

    def pose(self):
        with self.lock:
            return self.truth.poses[-1]

    def move(self, command):
        """Drives by `command(true pose)` from now on; None stops."""
        with self.lock:
            self.command = command

    def wait(self, condition, what, real_s=60.0):
        """Until the condition holds. Raises Stalled after `real_s` seconds of real time."""
        deadline = time.monotonic() + real_s
        while not condition():
            if time.monotonic() > deadline or self.rospy.is_shutdown():
                raise Stalled(f"waited {real_s:.0f} s for {what}")
            time.sleep(0.01)

    def wait_until(self, stamp_s, real_s=120.0):
        self.wait(lambda: self.now() >= stamp_s, f"the simulated time {stamp_s:.1f} s", real_s)

    def ready(self):
        """Waits until everything was heard once and the localizer has a pose."""
        self.wait(lambda: self.map is not None and self.now() > 0 and self.scan is not None,
                  "the simulator's map, truth and scan")
        self.wait(lambda: self.last_update_s is not None, "the localizer's first pose")

    def drive(self, waypoints, speed_m_s, near_m=0.3, real_s=120.0):
        """Along straight lines from point to point, by the true pose."""
        rest = list(waypoints)

        def command(here):
            while rest and math.hypot(rest[0][0] - here.x, rest[0][1] - here.y) < near_m:
                rest.pop(0)
            return towards(here, rest[0], speed_m_s) if rest else (0.0, 0.0, 0.0)

        self.move(command)
        try:
            self.wait(lambda: not rest, f"the robot to come to {waypoints[-1]}", real_s)
        finally:
            self.move(None)

    def errors(self, from_s, to_s):
        """Stamps and errors (metres, radians) of the believed pose at every true one between two times.

        Believed is what map -> odom said last, composed with odometry. A pose that was not there yet is an error of
        infinity.
        """
        stamps, found = [], []
        with self.lock:
            for stamp, true in zip(self.truth.stamps, self.truth.poses):
                if not from_s <= stamp <= to_s:
                    continue
                odom_T_base, map_T_odom = self.odometry.at(stamp), self.map_T_odom.before(stamp)
                if odom_T_base is None:
                    continue
                stamps.append(stamp)
                found.append(error(compose(map_T_odom, odom_T_base), true) if map_T_odom else (math.inf, math.pi))
        return stamps, found

    def error_now(self):
        _, found = self.errors(self.now() - 0.5, self.now())
        return found[-1] if found else (math.inf, math.pi)

    def put(self, pose):
        """Takes the robot elsewhere: a kidnapping, of which odometry knows nothing. Returns when that was [s]."""
        import extperfc.srv
        request = extperfc.srv.MoveBodyRequest(name="robot")
        request.pose.position.x, request.pose.position.y = pose.x, pose.y
        request.pose.orientation.z, request.pose.orientation.w = math.sin(pose.yaw / 2), math.cos(pose.yaw / 2)
        answer = self.rospy.ServiceProxy("sim/move_body", extperfc.srv.MoveBody)(request)
        if not answer.success:
            raise Stalled("sim/move_body: " + answer.message)
        self.wait(lambda: error(self.pose(), pose)[0] < 0.5, "the robot to be where it was put")
        return self.now()

    def set_true_pose(self):
        """Gives the localizer the true pose, as a person would by rviz's arrow."""
        here = self.pose()
        message = self.messages.PoseWithCovarianceStamped()
        message.header.frame_id = "map"
        message.header.stamp = self.rospy.Time.from_sec(self.now())
        message.pose.pose.position.x, message.pose.pose.position.y = here.x, here.y
        message.pose.pose.orientation.z, message.pose.pose.orientation.w = math.sin(here.yaw / 2), math.cos(here.yaw / 2)
        message.pose.covariance[0] = message.pose.covariance[7] = 0.01
        message.pose.covariance[35] = 0.01
        self.initialpose.publish(message)

    def clearance(self):
        """Distance [m] of each cell of the true map to what is not free."""
        if self.distances is None:
            info = self.map.info
            cells = numpy.array(self.map.data, numpy.int8).reshape(info.height, info.width)
            self.distances = info.resolution * cv2.distanceTransform((cells == 0).astype(numpy.uint8), cv2.DIST_L2, 5)
        return self.distances

    def clearance_at(self, x, y):
        """The same at a point of the map; 0 outside."""
        info, distances = self.map.info, self.clearance()
        column = int((x - info.origin.position.x) / info.resolution)
        row = int((y - info.origin.position.y) / info.resolution)
        return float(distances[row, column]) if 0 <= row < info.height and 0 <= column < info.width else 0.0

    def free_places(self):
        """Middles of cells of the true map with room for the robot, as an array of (x, y)."""
        info = self.map.info
        rows, columns = numpy.nonzero(self.clearance() > MIN_CLEARANCE_M)
        origin = info.origin.position
        return numpy.stack([origin.x + (columns + 0.5) * info.resolution, origin.y + (rows + 0.5) * info.resolution], 1)
