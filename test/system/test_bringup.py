"""bringup.launch: the whole robot in the simulator comes up, and what is killed or hangs is named and comes back."""

import os
import pathlib
import signal
import subprocess
import sys
import time
import unittest

import rospy
from extperfc.health.processes import ProcessTable
from roslaunch.config import ROSLaunchConfig
from roslaunch.xmlloader import XmlLoader

import simulated_robot
from nav_robot import NavRobot
from pose_errors import Pose
from robot_health import NODES, Listener, named, runs

REPO = pathlib.Path(__file__).resolve().parents[2]
START_LIMIT_S = 20.0   # what is aimed at; printed beside the measured times, the deadlines below are for any machine
RETURN_LIMIT_S = 5.0
DEADLINE_S = 90.0
HANGS = "/navigation_manager"
GOAL = Pose(0.1, 1.1, 0.0)  # free floor beside the start, where the simulator and the mapper began anew


class Bringup(simulated_robot.Supervised, unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        begin = time.monotonic()
        cls.session = simulated_robot.launch(cls, "test_bringup", "bringup.launch", separate_master=True)
        cls.addClassCleanup(rospy.signal_shutdown, "the tests are over")
        cls.listener = Listener()
        cls.table = ProcessTable(os.environ["ROS_MASTER_URI"])
        cls.wait(lambda: cls.listener.complete, "a complete robot")
        cls.start_s = time.monotonic() - begin

    def disturb(self, node, number):
        """Sends a signal to a node's process; returns how many summaries came before."""
        count = len(self.listener.messages)
        os.kill(self.table.scan()[node].pid, number)
        return count

    def test_1_comes_up_complete(self):
        print(f"\ncomplete after {self.start_s:.1f} s (aim: {START_LIMIT_S:.0f} s)", file=sys.stderr)
        parts = {value.key for value in self.listener.summary.values}
        self.assertEqual({part for parts, _ in NODES.values() for part in parts}, parts)
        self.wait(lambda: any(status.name == "/Navigation/navigator/navigator: navigator" for status in self.listener.tree),
                  "the tree of diagnostics")
        levels = {status.name: status.level for status in self.listener.tree}
        for name in levels:
            above = name.rsplit("/", 1)[0]
            self.assertTrue(above == "" or above in levels, f"{name} has no branch")

    def test_2_what_is_killed_is_named_and_comes_back(self):
        for node, (parts, topic) in NODES.items():
            with self.subTest(node):
                begin = time.monotonic()
                count = self.disturb(node, signal.SIGKILL)
                self.wait(lambda: all(any(named(message.message, "missing", part) for message in self.listener.since(count))
                                      for part in parts), f"{parts} to be named as missing")
                noticed = time.monotonic()
                self.wait(lambda: all(runs(self.listener.summary.message, part) for part in parts), f"{parts} to run again")
                returned = time.monotonic()
                self.wait(lambda: self.listener.works(topic, noticed, DEADLINE_S), f"{topic or 'arm/get_scene'} to work")
                print(f"{node}: named after {noticed - begin:.1f} s, back after {returned - begin:.1f} s (aim: "
                      f"{RETURN_LIMIT_S:.0f} s), works after {time.monotonic() - begin:.1f} s", file=sys.stderr)

    def test_3_health_itself_comes_back(self):
        begin = time.monotonic()
        count = self.disturb("/health", signal.SIGKILL)
        self.wait(lambda: self.listener.since(count), "a summary of the next health node")
        self.wait(lambda: not self.listener.summary.message.startswith(("missing", "silent", "starting")), "all parts")
        print(f"/health: back after {time.monotonic() - begin:.1f} s (aim: {RETURN_LIMIT_S:.0f} s)", file=sys.stderr)

    def test_4_a_manager_that_hangs_is_ended_and_comes_back(self):
        parts, _ = NODES[HANGS]
        before = self.table.scan()[HANGS]
        begin = time.monotonic()
        count = self.disturb(HANGS, signal.SIGSTOP)
        self.wait(lambda: any(named(message.message, "silent", part) for message in self.listener.since(count)
                              for part in parts), f"{parts} to be named as silent")
        self.wait(lambda: not self.table.alive(before), f"the end of {HANGS}")
        self.wait(lambda: all(runs(self.listener.summary.message, part) for part in parts), f"{parts} to run again")
        print(f"{HANGS}, stopped: back after {time.monotonic() - begin:.1f} s", file=sys.stderr)

    def test_5_a_restarted_master_gets_back_what_it_knew(self):
        count = len(self.listener.messages)
        self.session.kill_master()
        self.wait(lambda: any(message.message == "no ROS master" for message in self.listener.since(count)), "the master to be missed")
        self.session.start_master()
        begin = time.monotonic()
        self.wait(lambda: self.listener.complete, "a complete robot")
        print(f"ROS master: what it knew is back after {time.monotonic() - begin:.1f} s", file=sys.stderr)
        for command in ("rosparam get /navigator/max_vel_x", "rosservice call /arm/get_scene", "rostopic echo -n1 /scan/header"):
            subprocess.run(command.split(), check=True, timeout=DEADLINE_S, stdout=subprocess.DEVNULL)
        self.disturb("/navigation_manager", signal.SIGKILL)  # the next one needs the parameters
        self.wait(lambda: not runs(self.listener.summary.message, "navigator"), "the navigator to end")
        self.wait(lambda: self.listener.complete, "a complete robot")

    def test_6_after_all_that_it_drives(self):
        robot = NavRobot(self.session.alive)
        robot.ready()
        drive = robot.drive(GOAL, limit_s=60, real_s=DEADLINE_S)
        self.assertTrue(drive.reached, drive.text)
        self.assertGreater(drive.driven_m, 0.5)


class Arguments(unittest.TestCase):
    """What the arguments start, without starting it."""

    @staticmethod
    def loaded(*arguments):
        config = ROSLaunchConfig()
        XmlLoader().load(str(REPO / "launch" / "bringup.launch"), config, argv=["rviz:=false", *arguments], verbose=False)
        return config

    def nodes(self, *arguments):
        return {f"{node.namespace}{node.name}" for node in self.loaded(*arguments).nodes}

    def parameters(self, *arguments):
        return {name: parameter.value for name, parameter in self.loaded(*arguments).params.items()}

    def test_every_part_can_be_left_out(self):
        everything = self.nodes()
        for argument, gone in (("navigation", {"/navigation_manager", "/navigator", "/cmd_vel_mux"}),
                               ("arms", {"/arm_manager", "/arm"}), ("cameras", {"/camera_manager", "/detector", "/box_depth"}),
                               ("slam", {"/mapping_manager", "/mapper"}), ("scan", {"/lidar_manager", "/cloud_to_scan"}),
                               ("mux", {"/cmd_vel_mux"}), ("health", {"/health"})):
            with self.subTest(argument):
                self.assertEqual(gone, everything - self.nodes(f"{argument}:=false"))

    def test_what_runs_is_supervised(self):
        for arguments in ((), ("map:=/tmp/map.yaml", "track:=true"), ("exploration:=true", "mux:=false"),
                          ("robot:=baxter", "robot_master:=http://127.0.0.1:1", "cameras:=false")):
            with self.subTest(arguments):
                started = self.parameters(*arguments)["/health/started"].split(",")
                parts = {name for name in self.nodes(*arguments) if not name.endswith("_manager")}
                self.assertEqual(parts - {"/health"}, {"/" + name for name in started})

    def test_with_a_map_the_robot_localizes(self):
        nodes = self.nodes("map:=/tmp/map.yaml")
        self.assertLess({"/map_server", "/localizer"}, nodes)
        self.assertNotIn("/mapper", nodes)

    def test_a_real_robot_has_a_translator_and_no_simulator(self):
        nodes = self.nodes("robot:=baxter", "robot_master:=http://127.0.0.1:1")
        self.assertIn("/translator", nodes)
        self.assertNotIn("/simulator", nodes)
        self.assertNotIn("/translator", self.nodes("robot:=baxter"))
        parameters = self.parameters("robot:=baxter", "robot_master:=http://127.0.0.1:1")
        self.assertEqual("http://127.0.0.1:1", parameters["/translator/robot/master_uri"])
        self.assertEqual(["/rethink"], parameters["/translator/parameters/robot_to_workstation"])


if __name__ == "__main__":
    unittest.main()
