"""Two robots of bringup.launch in one ROS system: neither hears what is the other's."""

import math
import os
import pathlib
import tempfile
import time
import unittest

import rosgraph
import rospy
from diagnostic_msgs.msg import DiagnosticStatus
from geometry_msgs.msg import PoseStamped, Twist
from nav_msgs.msg import OccupancyGrid, Odometry

from ros_session import RosSession

FOLDER = pathlib.Path(__file__).resolve().parent
ROBOTS = ("first", "second")
GOAL_X_M, NEAR_M = 1.5, 0.15
DEADLINE_S = 90.0


class Robot:
    """What is heard of one."""

    def __init__(self, name):
        self.summary, self.place, self.map, self.commands = None, None, None, 0
        rospy.Subscriber(f"{name}/diagnostics_toplevel_state", DiagnosticStatus, lambda message: setattr(self, "summary", message))
        rospy.Subscriber(f"{name}/odom", Odometry, lambda message: setattr(self, "place", message.pose.pose.position))
        rospy.Subscriber(f"{name}/map", OccupancyGrid, lambda message: setattr(self, "map", message))
        rospy.Subscriber(f"{name}/cmd_vel", Twist, self._on_command)
        self.goals = rospy.Publisher(f"{name}/move_base_simple/goal", PoseStamped, queue_size=1)

    def _on_command(self, twist):
        self.commands += max(abs(twist.linear.x), abs(twist.angular.z)) > 1e-6

    @property
    def complete(self):
        return self.summary is not None and self.summary.level == DiagnosticStatus.OK and self.map is not None


class TwoRobots(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.session = RosSession(os.path.join(folder.name, "log"))
        self.addCleanup(self.session.close)
        self.session.launch(None, FOLDER / "two_robots.launch", robot="small_robot", robot_folder=FOLDER / "small_robot")
        self.session.join("test_two_robots", simulated=False)
        self.addCleanup(rospy.signal_shutdown, "the test is over")
        self.first, self.second = map(Robot, ROBOTS)

    def wait(self, condition, what):
        deadline = time.monotonic() + DEADLINE_S
        while not condition():
            if time.monotonic() > deadline or not self.session.alive():
                self.fail(f"waited for {what}: {self.first.summary}, {self.second.summary}, {self.session.errors()}")
            time.sleep(0.05)

    def test_one_drives_and_the_other_stands(self):
        self.wait(lambda: self.first.complete and self.second.complete, "two complete robots")
        self.wait(lambda: self.first.goals.get_num_connections() > 0, "the first navigator")
        goal = PoseStamped()
        goal.header.frame_id = "map"
        goal.pose.position.x, goal.pose.orientation.w = GOAL_X_M, 1.0
        self.first.goals.publish(goal)
        self.wait(lambda: math.hypot(self.first.place.x - GOAL_X_M, self.first.place.y) < NEAR_M, "the first robot at its goal")
        self.assertGreater(self.first.commands, 10)
        self.assertEqual(0, self.second.commands)
        self.assertEqual((0.0, 0.0), (self.second.place.x, self.second.place.y))
        published = {topic for topic, _ in rosgraph.Master("/test_two_robots").getPublishedTopics("/")}
        self.assertLessEqual({f"/{name}/{topic}" for name in ROBOTS for topic in ("tf", "tf_static", "map", "odom")}, published)
        self.assertFalse(published & {"/tf", "/tf_static", "/map", "/odom", "/cmd_vel", "/scan"})


if __name__ == "__main__":
    unittest.main()
