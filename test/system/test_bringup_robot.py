"""bringup.launch with a folder of another robot: a small differential base that has nothing of a Baxter."""

import math
import os
import pathlib
import tempfile
import unittest

import rospy
from diagnostic_msgs.msg import DiagnosticStatus
from geometry_msgs.msg import PolygonStamped, Twist
from nav_msgs.msg import Odometry

from demo import wait_for_master
from nav_robot import NavRobot
from pose_errors import Pose
from ros_session import RosSession
from sim_robot import planar

FOLDER = pathlib.Path(__file__).resolve().parent / "small_robot"
GOAL = Pose(1.5, 2.2, 0.0)  # to the left, which a base without sideways motion reaches by rotating
MAX_ERROR_M = 0.15
RADIUS_M = 0.22


class SmallRobot(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.session = RosSession(os.path.join(folder.name, "log"))
        self.addCleanup(self.session.close)
        self.session.launch("extperfc", "bringup.launch", robot="small_robot", robot_folder=FOLDER, rviz="false", scan="false",
                            cameras="false", arms="false")
        wait_for_master(self.session)
        rospy.init_node("test_bringup_robot", disable_signals=True)
        self.addCleanup(rospy.signal_shutdown, "the test is over")
        self.summary, self.pose, self.footprint, self.sideways = None, None, None, []
        rospy.Subscriber("diagnostics_toplevel_state", DiagnosticStatus, lambda message: setattr(self, "summary", message))
        rospy.Subscriber("odom", Odometry, lambda message: setattr(self, "pose", planar(message.pose.pose)))
        rospy.Subscriber("cmd_vel", Twist, lambda message: self.sideways.append(message.linear.y))
        rospy.Subscriber("move_base/local_costmap/footprint", PolygonStamped, lambda message: setattr(self, "footprint", message))

    def test_comes_up_and_drives(self):
        robot = NavRobot(self.session.alive)
        robot.wait(lambda: self.summary and self.summary.level == DiagnosticStatus.OK, "a complete robot", 60)
        self.assertEqual({"robot_state_publisher", "mapper", "navigator", "cmd_vel_mux", "small_robot"},
                         {value.key for value in self.summary.values})
        robot.wait(lambda: robot.goal_publisher.get_num_connections() > 0, "the navigator", 30)
        goal = robot.send(GOAL)
        robot.wait(lambda: goal in robot.states, "the end of the drive", 90)
        self.assertEqual(3, robot.states[goal][0], robot.states[goal][1])
        self.assertLess(math.hypot(self.pose.x - GOAL.x, self.pose.y - GOAL.y), MAX_ERROR_M)
        self.assertGreater(len(self.sideways), 10)
        self.assertEqual({0.0}, set(self.sideways))
        robot.wait(lambda: self.footprint, "the footprint", 30)
        here = self.footprint.polygon.points
        across = max(math.hypot(a.x - b.x, a.y - b.y) for a in here for b in here)
        self.assertLess(across, 2.2 * RADIUS_M, "not the Baxter's footprint")


if __name__ == "__main__":
    unittest.main()
