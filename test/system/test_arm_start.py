"""The arm node before a robot whose clock is off: what it sends to the trajectory servers, and what it shows first."""

import pathlib
import sys
import tempfile
import threading
import time
import unittest

REPO = pathlib.Path(__file__).resolve().parents[2]
sys.path[:0] = [str(REPO / "src"), str(REPO / "tools" / "lib")]

import actionlib  # noqa: E402
import rospy  # noqa: E402
import yaml  # noqa: E402
from control_msgs.msg import FollowJointTrajectoryAction  # noqa: E402
from ros_session import RosSession  # noqa: E402
from sensor_msgs.msg import JointState  # noqa: E402
from trajectory_msgs.msg import JointTrajectory  # noqa: E402

import extperfc.arm  # noqa: E402

NEUTRAL = {"s0": 0.0, "s1": -0.55, "e0": 0.0, "e1": 0.75, "w0": 0.0, "w1": 1.26, "w2": 0.0}
ROBOT_AHEAD_S = 7.0    # the robot's clock before ours
LAUNCH = """<launch>
  <param name="robot_description" textfile="{urdf}"/>
  <include file="$(find extperfc)/launch/arm.launch"><arg name="config" value="{config}"/></include>
</launch>
"""
CLOCK_ERROR_S = 0.05   # of what its joint states tell of it on a busy machine


class Server:
    """A trajectory server that notes when a goal came, by the robot's clock, and says that it was reached."""

    def __init__(self, side):
        self.goals, self.shown_before = [], []
        self.server = actionlib.SimpleActionServer(f"robot/limb/{side}/follow_joint_trajectory",
                                                   FollowJointTrajectoryAction, self.follow, auto_start=False)
        self.shown = lambda: 0
        self.server.start()

    def follow(self, goal):
        self.goals.append((rospy.get_time() + ROBOT_AHEAD_S, goal.trajectory))
        self.shown_before.append(self.shown())
        self.server.set_succeeded()


class ArmStart(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(folder.cleanup)
        config = yaml.safe_load((REPO / "config" / "arm.yaml").read_text())
        config["execution"]["robot_state"] = False
        config_file = pathlib.Path(folder.name) / "arm.yaml"
        config_file.write_text(yaml.safe_dump(config))
        session = RosSession(str(pathlib.Path(folder.name) / "log"))
        cls.addClassCleanup(session.close)
        launch_file = pathlib.Path(folder.name) / "robot_and_arm.launch"
        launch_file.write_text(LAUNCH.format(urdf=REPO / "urdf" / "mobile_baxter.urdf", config=config_file))
        session.launch(None, launch_file)
        session.join("test_arm_start", simulated=False)
        cls.addClassCleanup(rospy.signal_shutdown, "the tests are over")
        cls.delay_s = config["execution"]["start_delay_s"]
        cls.servers = {side: Server(side) for side in ("left", "right")}
        cls.joints = rospy.Publisher("robot/joint_states", JointState, queue_size=1)
        done = threading.Event()
        cls.addClassCleanup(done.set)
        threading.Thread(target=cls.publish_joints, args=(done,), daemon=True).start()
        cls.both, cls.left = (extperfc.arm.Arm(side, wait_s=60) for side in ("both", "left"))

    @classmethod
    def publish_joints(cls, done):
        names = [f"{side}_{joint}" for side in ("left", "right") for joint in NEUTRAL]
        while not done.wait(0.02):
            message = JointState(name=names, position=list(NEUTRAL.values()) * 2)
            message.header.stamp = rospy.Time.now() + rospy.Duration(ROBOT_AHEAD_S)
            cls.joints.publish(message)

    def setUp(self):
        self.shown = []
        display = rospy.Subscriber("arm/display_trajectory", JointTrajectory, self.shown.append)
        self.addCleanup(display.unregister)
        deadline = time.monotonic() + 20
        while display.get_num_connections() == 0:
            self.assertLess(time.monotonic(), deadline, "nothing publishes arm/display_trajectory")
            time.sleep(0.01)
        for server in self.servers.values():
            server.goals.clear()
            server.shown_before.clear()

    def test_servers_that_move_together_start_at_one_time_of_the_robots_clock(self):
        self.both.move_to({"left_w2": 0.3, "right_w2": 0.3}, timeout=60)
        (came_left, left), (came_right, right) = (self.servers[side].goals[0] for side in ("left", "right"))
        self.assertEqual(left.header.stamp, right.header.stamp)
        start = left.header.stamp.to_sec()
        self.assertGreater(start, max(came_left, came_right) - CLOCK_ERROR_S, "the goals came after their start")
        self.assertLess(start, min(came_left, came_right) + self.delay_s + CLOCK_ERROR_S)

    def test_a_single_server_starts_at_once(self):
        self.left.move_to({"w2": 0.3}, timeout=60)
        self.assertTrue(self.servers["left"].goals[0][1].header.stamp.is_zero())
        self.assertEqual([], self.servers["right"].goals)

    def test_a_plan_is_shown_before_it_is_executed(self):
        def wait_for_display():
            """How many trajectories were shown, once one of this test has come or two seconds have passed."""
            deadline = time.monotonic() + 2
            while not any(self.is_new(shown) for shown in self.shown) and time.monotonic() < deadline:
                time.sleep(0.01)
            return sum(self.is_new(shown) for shown in self.shown)

        self.servers["left"].shown = wait_for_display
        self.addCleanup(setattr, self.servers["left"], "shown", lambda: 0)
        self.left.move_to({"w2": -0.4}, timeout=60)
        self.assertEqual([1], self.servers["left"].shown_before)

    @staticmethod
    def is_new(shown):
        """Whether it leads to this test's goal (the topic is latched: an older one comes too)."""
        return abs(dict(zip(shown.joint_names, shown.points[-1].positions))["left_w2"] + 0.4) < 1e-3


if __name__ == "__main__":
    unittest.main()
