"""bringup.launch beside a robot with a master of its own, whose definitions are Indigo's: the translator is between them.

The robot is the simulated Baxter with base, lidar and camera, and a node that is compiled with Indigo's definitions. That what
the simulator publishes is the same in Indigo is a test, too.
"""

import json
import os
import pathlib
import signal
import subprocess
import sys
import time
import unittest

import rospy
from baxter_core_msgs.msg import HeadPanCommand
from sensor_msgs.msg import BatteryState, JointState
from vision_msgs.msg import Detection3DArray

import extperfc.arm
from extperfc.health.processes import ProcessTable
from nav_robot import NavRobot
from pose_errors import Pose
from robot_health import Listener, named, runs
from ros_session import RosSession
from simulated_robot import DEADLINE_S, Supervised
from translated_robot import LAUNCH_FILE, RobotSide

from harness import eras, network, processes  # noqa: E402 (translated_robot adds its place)

PARTS = {"robot_state_publisher", "translator", "cloud_to_scan", "detector", "box_depth", "mapper", "navigator", "cmd_vel_mux", "arm"}
GOAL = Pose(0.1, 1.1, 0.0)  # free floor beside the start
RETURN_LIMIT_S = 5.0  # what is aimed at, printed beside the measured time
HEAD_RAD = 0.4


class TranslatedRobot(Supervised, unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = processes.Folder()
        cls.addClassCleanup(cls.folder.close)
        side = RobotSide(network.OneHost().robot, cls.folder.path)
        cls.addClassCleanup(side.close)
        side.start()
        cls.robot = side.master
        cls.indigo = processes.Puppet("battery", "indigo", "cpp", cls.robot)
        cls.addClassCleanup(cls.indigo.end)
        cls.session = RosSession(os.path.join(cls.folder.path, "launch.log"))
        cls.addClassCleanup(cls.session.close)
        cls.session.launch(None, LAUNCH_FILE, robot_master=cls.robot.uri)
        cls.session.join("test_bringup_translated")
        cls.addClassCleanup(rospy.signal_shutdown, "the tests are over")
        cls.listener, cls.begin = Listener(topics=()), time.monotonic()

    def test_1_comes_up_complete(self):
        self.wait(lambda: self.listener.complete, "a complete robot")
        print(f"\ncomplete after {time.monotonic() - self.begin:.1f} s", file=sys.stderr)
        self.assertEqual(PARTS, {value.key for value in self.listener.summary.values})

    def test_2_the_robot_speaks_indigo(self):
        """What the simulator publishes has Indigo's definition, or the robot here would not be one of Indigo's."""
        command = [processes.PROGRAMS / "extperfc-translate", "check", "--config", processes.REPO / "config" / "translate", "--json",
                   "--all", "--robot", self.robot.uri, "--to-set", "indigo"]
        answer = subprocess.run(command, capture_output=True, text=True, timeout=60, check=False)
        verdicts = {entry["robot_type"]: entry["verdict"] for entry in json.loads(answer.stdout)["types"] if entry["robot_md5"]}
        self.assertLessEqual({"sensor_msgs/JointState", "nav_msgs/Odometry", "sensor_msgs/PointCloud2", "sensor_msgs/Image",
                              "control_msgs/FollowJointTrajectoryActionResult"}, set(verdicts))
        self.assertLessEqual(set(verdicts.values()), {"same", "pass"}, verdicts)

    def test_3_detections_of_the_robots_images(self):
        found = []
        subscriber = rospy.Subscriber("detections_3d", Detection3DArray, found.append)
        self.addCleanup(subscriber.unregister)
        self.wait(lambda: any(message.detections for message in found), "a detected object")

    def test_4_it_drives(self):
        robot = NavRobot(self.session.alive)
        robot.ready()
        drive = robot.drive(GOAL, limit_s=60, real_s=DEADLINE_S)
        self.assertTrue(drive.reached, drive.text)
        self.assertGreater(drive.driven_m, 0.5)

    def test_5_it_moves_an_arm_and_its_head(self):
        arm = extperfc.arm.Arm("left")
        states = []
        subscriber = rospy.Subscriber("robot/joint_states", JointState, states.append, queue_size=1)
        self.addCleanup(subscriber.unregister)
        publisher = rospy.Publisher("robot/head/command_head_pan", HeadPanCommand, queue_size=1)
        arm.move_to("neutral")

        def pan():
            publisher.publish(target=HEAD_RAD, speed_ratio=1.0, enable_pan_request=1)
            joints = dict(zip(states[-1].name, states[-1].position)) if states else {}
            return abs(joints.get("head_pan", 0.0) - HEAD_RAD) < 0.05
        self.wait(pan, "the head")

    def test_6_an_indigo_message_arrives_as_noetics(self):
        kind = eras.Era(processes.ERAS / "indigo").message("sensor_msgs/BatteryState")
        heard = []
        subscriber = rospy.Subscriber("battery", BatteryState, heard.append)
        self.addCleanup(subscriber.unregister)
        self.indigo.wait_ready()
        self.indigo.send("advertise", "/battery", "sensor_msgs/BatteryState", 1)
        self.indigo.send("publish", "/battery", eras.to_hex(kind(voltage=24.5)))
        self.wait(lambda: heard, "the battery")
        self.assertEqual(24.5, heard[0].voltage)

    def test_7_a_killed_translator_comes_back(self):
        count, begin = len(self.listener.messages), time.monotonic()
        os.kill(ProcessTable(os.environ["ROS_MASTER_URI"]).scan()["/translator"].pid, signal.SIGKILL)
        self.wait(lambda: any(named(message.message, "missing", "translator") for message in self.listener.since(count)),
                  "the translator to be named as missing")
        self.wait(lambda: runs(self.listener.summary.message, "translator"), "the translator to run again")
        print(f"translator: back after {time.monotonic() - begin:.1f} s (aim: {RETURN_LIMIT_S:.0f} s)", file=sys.stderr)
        robot = NavRobot(self.session.alive)
        robot.ready()
        drive = robot.drive(Pose(-0.4, 1.1, 0.0), limit_s=60, real_s=DEADLINE_S)
        self.assertTrue(drive.reached, drive.text)

    def test_8_no_frame_came_twice(self):
        """The robot publishes its joints' frames, and so might robot_state_publisher here."""
        self.assertNotIn("TF_REPEATED_DATA", pathlib.Path(self.session.log_file).read_text(errors="replace"))


if __name__ == "__main__":
    unittest.main()
