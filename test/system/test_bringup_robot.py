"""bringup.launch with a folder of another robot: a small differential base with one arm that has nothing of a Baxter."""

import math
import os
import pathlib
import tempfile
import unittest

import rospy
from diagnostic_msgs.msg import DiagnosticStatus
from geometry_msgs.msg import PolygonStamped, PoseStamped, Twist
from nav_msgs.msg import Odometry

from nav_robot import NavRobot
from pose_errors import Pose
from ros_session import RosSession
from sim_robot import planar

import extperfc.arm
from extperfc.msg import ArmCode

FOLDER = pathlib.Path(__file__).resolve().parent / "small_robot"
GOAL = Pose(0.0, 2.35, math.pi / 2)  # before a pillar to the left, which a base without sideways motion reaches by rotating
MAX_ERROR_M = 0.15
PILLAR_SIZE, PILLAR = (0.6, 0.6, 0.3), (0.0, 3.0, 0.15)  # on which a cube stands, see small_robot_node.py
CUBE_M, PLACE, PLACED_M = 0.04, (-0.1, 2.9, 0.32), 0.01
ANSWER_S = 60.0
RADIUS_M = 0.22


class SmallRobot(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.session = RosSession(os.path.join(folder.name, "log"))
        self.addCleanup(self.session.close)
        self.session.launch("extperfc", "bringup.launch", robot="small_robot", robot_folder=FOLDER, rviz="false", scan="false",
                            cameras="false")
        self.session.join("test_bringup_robot", simulated=False)
        self.addCleanup(rospy.signal_shutdown, "the test is over")
        self.summary, self.pose, self.footprint, self.cube, self.sideways = None, None, None, None, []
        rospy.Subscriber("truth/cube", PoseStamped, lambda message: setattr(self, "cube", message.pose.position))
        rospy.Subscriber("diagnostics_toplevel_state", DiagnosticStatus, lambda message: setattr(self, "summary", message))
        rospy.Subscriber("odom", Odometry, lambda message: setattr(self, "pose", planar(message.pose.pose)))
        rospy.Subscriber("cmd_vel", Twist, lambda message: self.sideways.append(message.linear.y))
        rospy.Subscriber("move_base/local_costmap/footprint", PolygonStamped, lambda message: setattr(self, "footprint", message))

    def test_comes_up_drives_and_grasps(self):
        robot = NavRobot(self.session.alive)
        robot.wait(lambda: self.summary and self.summary.level == DiagnosticStatus.OK, "a complete robot", 60)
        self.assertEqual({"robot_state_publisher", "mapper", "navigator", "cmd_vel_mux", "arm", "small_robot"},
                         {value.key for value in self.summary.values})
        self.drive(robot)
        self.grasp(robot)

    def drive(self, robot):
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

    def grasp(self, robot):
        arm = extperfc.arm.Arm("both")  # all of them: one
        self.assertEqual((("claw",), "base_footprint"), (arm.sides, arm.hands.frame))
        self.assertEqual({"swing", "lean", "bend", "roll", "nod", "twist"}, set(arm.joints))
        with self.assertRaisesRegex(ValueError, "must be claw$"):
            extperfc.arm.Arm("left")
        robot.wait(lambda: self.cube, "the cube's place", 30)
        stood = (self.cube.x, self.cube.y, self.cube.z)
        arm.scene.add_box("pillar", PILLAR_SIZE, PILLAR, frame="odom")
        arm.scene.add_box("cube", [CUBE_M] * 3, (*stood, 0.0, 0.0, 0.0), frame="odom")
        arm.move_to("neutral", timeout=ANSWER_S)
        picked = arm.pick("cube", place_at=PLACE, frame="odom", timeout=ANSWER_S)
        self.assertEqual(("cube", "claw"), (picked.object, picked.arm))
        robot.wait(lambda: self.cube.z > stood[2] + 0.05, "the lifted cube", 10)
        arm.place(PLACE, frame="odom", timeout=ANSWER_S)
        robot.wait(lambda: abs(self.cube.z - PLACE[2]) < PLACED_M, "the cube on the pillar", 10)
        self.assertLess(math.hypot(self.cube.x - PLACE[0], self.cube.y - PLACE[1]), PLACED_M)
        with self.assertRaises(extperfc.arm.ArmError) as caught:
            arm.place(PLACE, frame="odom", timeout=ANSWER_S)
        self.assertEqual(ArmCode.NOTHING_HELD, caught.exception.code)
        arm.tuck(timeout=ANSWER_S)


if __name__ == "__main__":
    unittest.main()
