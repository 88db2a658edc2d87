"""tools/extperfc-translate as a user calls it."""

import importlib.util
import json
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import time
import unittest
import xmlrpc.client

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "tools" / "lib"))
from ros_session import free_port  # noqa: E402

REPO = pathlib.Path(__file__).resolve().parents[2]
TOOL = REPO / "tools" / "extperfc-translate"
DATA = REPO / "test" / "data" / "translate"
MARKER = {"indigo": "18326976df9d29249efc939e00342cde", "noetic": "4048c9de2a16f4ae8e0538085ebf1b97"}
MASTER = "import sys, rosmaster.main as main; main.rosmaster_main(['--core', '-p', sys.argv[1]])"
# A node with the markers of one of the two releases. The robot side subscribes to images.
NODE = """
import sys, rospy
from sensor_msgs.msg import Image
from std_srvs.srv import Trigger, TriggerResponse
from visualization_msgs.msg import Marker
class RobotMarker(Marker):
    _md5sum = '18326976df9d29249efc939e00342cde'
    _full_text = Marker._full_text.replace('uint8 DELETEALL=3\\n', '')
robot = sys.argv[1] == 'robot'
rospy.init_node('node', disable_signals=True)
kept = [rospy.Publisher('/marker', RobotMarker if robot else Marker, queue_size=1),
        rospy.Service('/trigger', Trigger, lambda request: TriggerResponse()),
        rospy.Subscriber('/image', Image, print) if robot else rospy.Publisher('/image', Image, queue_size=1)]
print('ready', flush=True)
sys.stdin.read()
"""


def translate(*arguments, **environment):
    return subprocess.run([TOOL, *map(str, arguments)], capture_output=True, text=True, timeout=120,
                          env={**os.environ, **environment})


def rows_of(file):
    return [line.split() for line in (DATA / file).read_text().splitlines() if not line.startswith("#")]


class TranslateTool(unittest.TestCase):
    def setUp(self):
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.folder = pathlib.Path(temporary.name)

    def run_tool(self, *arguments, status=0):
        done = translate(*arguments)
        self.assertEqual(status, done.returncode, done.stdout + done.stderr)
        return done.stdout

    def write(self, name, text):
        file = self.folder / name
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text)
        return file

    def test_check_shows_exactly_what_differs_between_indigo_and_noetic(self):
        found = json.loads(self.run_tool("check", "--from-set", "indigo", "--to-set", "noetic", "--json"))
        self.assertEqual(sorted(map(tuple, rows_of("indigo_noetic_differences.txt"))),
                         sorted((row["robot_type"], row["kind"], row["robot_md5"], row["workstation_md5"], row["verdict"])
                                for row in found["types"]))
        self.assertEqual((69, 12, 57, 0, 0), (len(found["types"]), *(found["counts"][key] for key in (
            "pass", "convert", "needs a rule", "unknown"))))
        self.assertTrue(found["renamed"])
        for row in found["renamed"]:
            self.assertEqual(row["robot_type"].replace("multimaster_msgs_fkie", "fkie_multimaster_msgs"),
                             row["workstation_type"])

    def test_check_shows_what_differs_between_baxter_releases(self):
        for before, after in (("0.7.0", "1.0.0"), ("1.1.1", "1.2.0")):
            found = json.loads(self.run_tool("check", "--from-set", f"baxter_sdk_{before}", "--to-set",
                                             f"baxter_sdk_{after}", "--json"))
            expected = {(row[0], row[3], row[4]) for row in rows_of("baxter_sdk_differences.txt")
                        if (row[1], row[2]) == (before, after) and "-" not in row[3:]}
            self.assertEqual(expected, {(row["robot_type"], row["robot_md5"], row["workstation_md5"]) for row in found["types"]})

    def test_check_prints_a_table_of_at_most_100_columns(self):
        table = self.run_tool("check", "--from-set", "indigo", "--to-set", "noetic", "--all", "--fields")
        self.assertEqual([], [line for line in table.splitlines() if len(line) > 100])
        self.assertRegex(table, r"visualization_msgs/Marker +msg +18326976 4048c9de pass +constants only\n")
        self.assertRegex(table, r"sensor_msgs/BatteryState +msg +476f837f 4ddae7f0 convert +by rule\n"
                                r" +rule: temperature cell_temperature\n")
        self.assertRegex(table, r"std_msgs/Header +msg +2176deca 2176deca same\n")
        self.assertIn("69 differ: 12 pass, 57 convert, 0 need a rule, 0 unknown;", table)

    def test_check_of_trees_names_what_needs_a_rule(self):
        self.write("robot/my_msgs/msg/Name.msg", "string name\nint32 common\n")
        self.write("workstation/my_msgs/msg/Name.msg", "float64 name\nint32 common\n")
        self.write("robot/my_msgs/msg/Grown.msg", "geometry_msgs/Point p\n")
        self.write("workstation/my_msgs/msg/Grown.msg", "geometry_msgs/Point p\nint8 more\n")
        self.write("workstation/my_msgs/msg/Bad.msg", "what\n")
        done = translate("check", "--from-tree", self.folder / "robot", "--from-set", "indigo",
                         "--to-tree", self.folder / "workstation", "--to-set", "noetic")
        self.assertEqual(1, done.returncode, done.stdout + done.stderr)
        self.assertRegex(done.stdout, r"my_msgs/Name +msg +\w{8} \w{8} needs a rule\n +robot to workstation: ")
        self.assertIn("field name: string does not become float64", done.stdout)
        self.assertRegex(done.stdout, r"my_msgs/Grown +msg +\w{8} \w{8} convert +by name\n")
        self.assertIn("2 differ: 0 pass, 1 convert, 1 need a rule, 0 unknown", done.stdout)
        self.assertIn("Bad.msg: my_msgs/Bad line 1", done.stderr)

    def test_show_prints_the_plan_as_text(self):
        shown = self.run_tool("show", "sensor_msgs/BatteryState", "--from", "indigo", "--to", "4ddae7f0")
        self.assertIn("  + ", shown)
        self.assertIn("plan: convert", shown)
        self.assertIn("rule temperature: always nan", shown)
        self.assertEqual([], [line for line in shown.splitlines() if len(line) > 110])
        service = self.run_tool("show", "controller_manager_msgs/SwitchController", "--from", "indigo", "--to", "noetic")
        self.assertIn("request: ", service)
        self.assertIn("response, back: ", service)
        action = self.run_tool("show", "moveit_msgs/Pickup", "--from", "noetic", "--to", "indigo")
        for part in ("goal: ", "result, back: ", "feedback, back: "):
            self.assertIn(part, action)
        self.assertIn("plan: pass", self.run_tool("show", "visualization_msgs/Marker", "--from", MARKER["indigo"],
                                                  "--to", MARKER["noetic"]))

    def test_md5(self):
        self.assertEqual(MARKER["indigo"] + "\n", self.run_tool("md5", "visualization_msgs/Marker", "--set", "indigo"))
        self.assertEqual([MARKER[name] + " msg " + name for name in ("indigo", "noetic")],
                         self.run_tool("md5", "visualization_msgs/Marker").splitlines())
        self.assertEqual("f5aa574f57e5d9cf7d466d5913039489\n", self.run_tool("md5", "moveit_msgs/Pickup", "--set", "indigo"))
        self.assertEqual("5e857dedf71d6f337975e15a1e7cfdd8\n",
                         self.run_tool("md5", "controller_manager_msgs/SwitchController", "--set", "indigo"))
        file = self.write("Reply.srv", "int64 a\nint64 b\n---\nint64 sum\n")
        self.assertEqual("6a2e34150c00229791cc89ff309fff21\n", self.run_tool("md5", "my_msgs/Reply", "--file", file))
        self.assertEqual(self.run_tool("md5", "control_msgs/FollowJointTrajectory", "--set", "noetic"),
                         self.run_tool("md5", "control_msgs/FollowJointTrajectory", "--tree", REPO / "interfaces"))

    def test_export_and_store_bring_the_same_definitions_back(self):
        self.run_tool("export", "indigo", self.folder / "tree")
        self.assertTrue((self.folder / "tree" / "moveit_msgs" / "action" / "Pickup.action").is_file())
        self.assertFalse((self.folder / "tree" / "moveit_msgs" / "msg" / "PickupGoal.msg").exists())
        self.run_tool("store", self.folder / "config" / "definitions", "--set", f"again={self.folder / 'tree'}")
        shipped = (REPO / "config" / "translate" / "definitions" / "sets" / "indigo.txt").read_text()
        self.assertEqual(shipped, (self.folder / "config" / "definitions" / "sets" / "again.txt").read_text())
        few = self.run_tool("export", "noetic", self.folder / "few", "--package", "control_msgs")
        self.assertEqual(["control_msgs"], [each.name for each in (self.folder / "few").iterdir()], few)

    def start(self, program, argument, **environment):
        process = subprocess.Popen([sys.executable, "-c", program, argument], text=True, stdin=subprocess.PIPE,
                                   stdout=subprocess.PIPE, stderr=subprocess.DEVNULL,
                                   env={**os.environ, "ROS_IP": "127.0.0.1", "ROS_HOME": str(self.folder), **environment})
        self.addCleanup(lambda: (process.kill(), process.communicate()))
        return process

    def start_side(self, name):
        port = free_port()
        uri = f"http://127.0.0.1:{port}"
        self.start(MASTER, str(port))
        deadline = time.monotonic() + 30
        while time.monotonic() < deadline:
            try:
                with xmlrpc.client.ServerProxy(uri) as master:
                    master.getPid("/test")
                break
            except OSError:
                time.sleep(0.05)
        node = self.start(NODE, name, ROS_MASTER_URI=uri)
        self.assertEqual("ready\n", node.stdout.readline())
        return uri

    @unittest.skipUnless(importlib.util.find_spec("rosmaster"), "needs rosmaster and rospy")
    def test_check_asks_running_masters(self):
        robot, workstation = self.start_side("robot"), self.start_side("workstation")
        done = translate("check", "--robot", robot, "--workstation", workstation, "--json", "--all")
        self.assertEqual(1, done.returncode, done.stdout + done.stderr)
        rows = {row["robot_type"]: row for row in json.loads(done.stdout)["types"]}
        self.assertEqual(("pass", *MARKER.values(), "/marker"), tuple(
            rows["visualization_msgs/Marker"][key] for key in ("verdict", "robot_md5", "workstation_md5", "robot_where")))
        self.assertEqual(("same", "srv"), (rows["std_srvs/Trigger"]["verdict"], rows["std_srvs/Trigger"]["kind"]))
        self.assertEqual("unknown", rows["sensor_msgs/Image"]["verdict"])
        self.assertIn("there is no publisher", rows["sensor_msgs/Image"]["reasons"][0])
        self.run_tool("check", "--robot", robot, "--from-set", "indigo", "--workstation", workstation)
        for uri in (robot, workstation):  # nothing stays behind
            with xmlrpc.client.ServerProxy(uri) as master:
                self.assertNotIn("extperfc_translate_check", str(master.getSystemState("/test")))

    def commands_of_the_guide(self):
        """Every command line of the tool in docs/translator.md: in blocks, and within the text."""
        text = (REPO / "docs" / "translator.md").read_text()
        blocks = [line.split("#")[0].strip() for block in text.split("```")[1::2] for line in block.splitlines()]
        spans = [span for block in text.split("```")[::2] for span in re.findall(r"`([^`\n]+)`", block)]
        return sorted({line for line in blocks + spans if "extperfc-translate" in line})

    @unittest.skipUnless(importlib.util.find_spec("rosmaster"), "needs rosmaster and rospy")
    def test_the_guides_commands_work_as_they_are_written(self):
        """In the repository's folder, as after its first line; only the masters' addresses are this test's."""
        commands = self.commands_of_the_guide()
        self.assertTrue(all(command.startswith("tools/extperfc-translate ") for command in commands), commands)
        self.assertEqual({"check", "status"}, {command.split()[1] for command in commands})
        robot, workstation = self.start_side("robot"), self.start_side("workstation")
        for command in commands:
            if command.split()[1] == "status":
                continue  # needs a running translator: test_translator_connections.py
            line = command.replace("http://011310P0018.local:11311", robot).replace("http://localhost:11311", workstation)
            done = subprocess.run(line, shell=True, cwd=REPO, capture_output=True, text=True, timeout=120, check=False)
            self.assertEqual(0, done.returncode, f"{line}\n{done.stdout}{done.stderr}")
            self.assertIn(" differ: ", done.stdout)
            self.assertIn("0 need a rule, 0 unknown", done.stdout)

    def test_check_without_arguments_compares_the_shipped_sets(self):
        self.assertEqual(self.run_tool("check", "--from-set", "indigo", "--to-set", "noetic"), self.run_tool("check"))

    def test_errors_name_what_is_wrong(self):
        file = self.write("Wrong.msg", "int32 a\nint32 a\n")
        rules = self.write("rules.yaml", "rules: 3\n")
        for arguments, text in (
                (["frobnicate"], "no subcommand 'frobnicate'"),
                (["md5"], "give a type"),
                (["md5", "a/B", "--colour"], "unknown option --colour"),
                (["check", "--jsn"], 'unknown option --jsn, did you mean "--json"?'),
                (["md5", "a/B", "--set"], "--set needs a value"),
                (["md5", "a/B", "c/D"], "unexpected argument c/D"),
                (["md5", "a/B", "--set", "melodic"], "no set 'melodic'; there are: baxter_sdk_0.7.0"),
                (["md5", "no_msgs/Such", "--set", "indigo"], "no set has the type no_msgs/Such"),
                (["md5", "a/B", "--file", file], "line 2: field a appears twice"),
                (["md5", "a/B", "--tree", "/no/such"], "/no/such"),
                (["check", "--to-set", "noetic"], "--from-set SET"),
                (["check", "--from-set", "indigo"], "--to-set SET"),
                (["status", "--nod", "/x"], 'unknown option --nod, did you mean "--node"?'),
                (["status", "--master", "http://127.0.0.1:9"], "no master at http://127.0.0.1:9"),
                (["check", "--robot", "http://127.0.0.1:9", "--workstation", "http://127.0.0.1:9"], "http://127.0.0.1:9"),
                (["check", "--robot", "http://127.0.0.1:9", "--timeout", "soon"], "--timeout must be a number"),
                (["check", "--from-set", "indigo", "--to-set", "noetic", "--rules", rules], "rules.yaml"),
                (["show", "sensor_msgs/Image", "--from", "indigo"], "give a type and both sides"),
                (["show", "sensor_msgs/Image", "--from", "indigo", "--to", "123456"], "has no version 123456; there are"),
                (["export", "indigo"], "export SET DIR"),
                (["store", self.folder / "x", "--set", "nothing"], "NAME=TREE")):
            done = translate(*arguments)
            self.assertEqual(2, done.returncode, (arguments, done.stdout))
            self.assertIn(text, done.stderr, arguments)
        broken = translate("md5", "a/B", EXTPERFC_TRANSLATE_CONFIG=str(self.folder))
        self.assertEqual(2, broken.returncode)
        self.assertIn("no folder 'definitions'", broken.stderr)

    def test_help(self):
        for arguments in ([], *([name] for name in ("check", "show", "md5", "export", "status", "store"))):
            for option in ("--help", "-h"):
                self.assertIn("extperfc-translate", self.run_tool(*arguments, option))


if __name__ == "__main__":
    unittest.main()
