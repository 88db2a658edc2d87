"""The translator's connections as real nodes see them: one per topic and node. Two masters at two ports of this host."""

import pathlib
import re
import subprocess
import sys
import unittest
import xmlrpc.client

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "translator"))

from harness import eras, processes  # noqa: E402
from harness.session import NAME, STRING, Session  # noqa: E402

SESSION = None
TOOL = processes.REPO / "tools" / "extperfc-translate"
REFERENCE, STAMPED = "/robot/joint_states", "sensor_msgs/JointState"

PARAMETERS = {
    "clocks": {"reference_topics": [REFERENCE], "shift_stamps": True},
    "diagnostics": {"period_s": 0.2, "topic_period_s": 0.2},
    "topics": {"deny": ["/to_be_killed"]},  # another translator's
    "services": {"deny": ["/translator_to_kill.*"]},
    "robot": {"hosts": ["127.0.0.1 known-robot"]},
}


def setUpModule():
    global SESSION
    SESSION = Session(one_host=True)
    unittest.addModuleCleanup(SESSION.close)
    SESSION.start("robot_python", "workstation_cpp", "workstation_python")
    SESSION.translate(**PARAMETERS)


def status(*arguments, **environment):
    """What the tool prints of the running translator."""
    return subprocess.run([TOOL, "status", *arguments], capture_output=True, text=True, timeout=60,
                          env={**SESSION.workstation.environment(), **environment})


def status_text():
    done = status("--node", NAME + "_home")
    assert done.returncode == 0, done.stderr
    return done.stdout


def numbers(node, topic):
    """Of the numbered messages that it heard."""
    kind = SESSION.era_of(node.name).message(STAMPED)
    return [int(eras.from_hex(kind, text).name[0]) for _, text in node.heard("message", topic)
            if eras.from_hex(kind, text).name]


class ReferenceTopic(unittest.TestCase):
    def test_every_message_of_a_rospy_publisher_arrives(self):
        """The clock's measurement and the route want the same topic; rospy keeps one connection per caller id."""
        source, target = SESSION.start("robot_python", "workstation_cpp")
        source.send("advertise", REFERENCE, STAMPED, 0)
        target.send("subscribe", REFERENCE, STAMPED)
        empty = eras.to_hex(SESSION.message("robot", STAMPED))

        def arrived():
            source.send("publish", REFERENCE, empty)
            return target.heard("message", REFERENCE)
        processes.wait_until(arrived, 20, "a first message")
        count = 600
        source.send("number", REFERENCE, 100, count)
        source.wait_for("repeated", REFERENCE, seconds=20)
        processes.wait_until(lambda: count - 1 in numbers(target, REFERENCE), 10,
                             lambda: f"the last message; heard {len(numbers(target, REFERENCE))} of {count}")
        self.assertEqual(list(range(count)), numbers(target, REFERENCE))
        with xmlrpc.client.ServerProxy(SESSION.robot.ask("lookupNode", "/robot_python")) as node:
            rows = [row for row in node.getBusInfo("/test")[2] if row[4] == REFERENCE]
        self.assertEqual([NAME], [row[1] for row in rows], "one connection")
        text = status_text()
        self.assertIn(f"clock source: topic {REFERENCE}", text)
        self.assertIn("stamps: shifted", text)
        self.assertNotIn("stamps are not shifted", text)
        self.assertNotIn("PROBLEM", next(line for line in text.splitlines() if REFERENCE + " [" in line))

    def test_connection_that_ends_again_and_again_is_a_problem(self):
        topic = "/flapping"
        source, target, watcher = SESSION.start("robot_python_flaps", "workstation_cpp", "workstation_python")
        watcher.send("subscribe", "/diagnostics", "diagnostic_msgs/DiagnosticArray")
        source.send("advertise", topic, STRING, 0)
        target.send("subscribe", topic, STRING)

        def shown():
            source.send("hang_up", topic)
            return "again and again" in status_text()
        processes.wait_until(shown, 30, status_text)
        self.assertRegex(status_text(), rf"{topic} \[.*PROBLEM: {topic}: publisher http://\S+: the connection ends again")
        processes.wait_until(lambda: any(b"again and again" in bytes.fromhex(text[1:]) for _, text in
                                         watcher.heard("message", "/diagnostics")), 10, "diagnostics")
        self.assertIn("again and again", SESSION.translator.log.read_text())
        SESSION.end_node("robot_python_flaps")


class StatusTool(unittest.TestCase):
    def test_prints_lines(self):
        text = status_text()
        self.assertTrue(text.startswith("link: "), text)
        self.assertNotIn("\\n", text)
        for line in ("robot side master: " + SESSION.robot.uri,
                     "workstation side master: " + SESSION.workstation.uri, "topics:", "services:"):
            self.assertIn(line, text)

    def test_the_masters_uri_may_be_given(self):
        done = status("--node", NAME[1:] + "_home", "--master", SESSION.workstation.uri,
                      ROS_MASTER_URI="http://127.0.0.1:9")
        self.assertEqual(0, done.returncode, done.stderr)

    def test_errors_name_what_is_missing(self):
        for arguments, environment, expected in (
                ((), {}, rf"no translator /translator at {SESSION.workstation.uri}; give one of these with --node: "
                         rf".*{NAME}_home"),
                (("--master", SESSION.robot.uri), {}, "no translator is running: roslaunch extperfc translator.launch"),
                ((), {"ROS_MASTER_URI": "http://127.0.0.1:9"}, "no master at http://127.0.0.1:9.*--master"),
                (("--timeout", "0"), {}, "--timeout")):
            done = status(*arguments, **environment)
            self.assertEqual(2, done.returncode, done.stdout)
            self.assertRegex(done.stderr, expected)
        self.assertIn("--node", status("--help").stdout)

    def test_leaves_nothing_at_the_master(self):
        status_text()
        self.assertNotIn("extperfc_translate_status", str(SESSION.workstation.ask("getSystemState")))


class Ends(unittest.TestCase):
    def end(self, name, kill):
        """Has a node heard, with its log, and ends it; returns its URI and its topic."""
        topic, target = "/of_" + name, SESSION.node("workstation_python")
        source = SESSION.node(name)
        source.send("advertise", topic, STRING, 0)
        target.send("subscribe", topic, STRING)
        SESSION.flow(source, target, topic, "alive")
        uri = SESSION.robot.ask("lookupNode", "/" + name)
        processes.wait_until(lambda: {"/rosout", topic} <= self.topics_from(uri), 20, "it is heard")
        SESSION.end_node(name, kill=kill)
        processes.wait_until(lambda: not self.topics_from(uri), 20, "its end is noticed")
        return uri, topic

    def topics_from(self, uri):
        with xmlrpc.client.ServerProxy(SESSION.robot.ask("lookupNode", NAME)) as node:
            return {row[4] for row in node.getBusInfo("/test")[2] if row[1] == uri}

    def warnings(self, uri):
        return [line for line in SESSION.translator.log.read_text().splitlines() if "WARN" in line and uri in line]

    def test_nodes_that_end_are_no_problem(self):
        """Every node publishes /rosout: its end is an ordinary event."""
        SESSION.node("workstation_python").send("subscribe", "/rosout", "rosgraph_msgs/Log")
        ended = [self.end(f"robot_{language}_ends", kill=False)[0] for language in ("cpp", "python")]
        # One that is killed stays on its master's list: its own topics are a problem, its log is none.
        uri, topic = self.end("robot_cpp_dies", kill=True)
        processes.wait_until(lambda: self.warnings(uri), 20, "its topic is missed")
        self.assertEqual([], [line for line in self.warnings(uri) if topic not in line])
        for uri in ended:
            self.assertEqual([], self.warnings(uri))

    def test_rosnode_kill_ends_the_translator_whichever_of_its_nodes_is_named(self):
        """As rosnode does it: shutdown() of the node's own API."""
        topic, name = "/to_be_killed", "/translator_to_kill"
        SESSION.node("robot_python").send("advertise", topic, STRING, 0)
        SESSION.node("workstation_cpp").send("subscribe", topic, STRING)
        for side, ending in ((SESSION.robot, ""), (SESSION.workstation, ""), (SESSION.workstation, "_home")):
            with self.subTest(master=side.name, node=name + ending):
                translator = SESSION.another_translator(name, {"topics": {"allow": [topic]},
                                                                  "services": {"allow": []}})
                self.addCleanup(translator.end)
                processes.wait_until(lambda: side.ask("lookupNode", name + ending, quiet=True), 20, "its node")
                with xmlrpc.client.ServerProxy(side.ask("lookupNode", name + ending)) as node:
                    self.assertEqual(1, node.shutdown("/rosnode", "user request")[0])
                processes.wait_until(lambda: not translator.alive(), 10, translator.log_tail)
                self.assertEqual(0, translator.process.returncode, translator.log_tail())
                for master in (SESSION.robot, SESSION.workstation):
                    self.assertEqual(set(), {node for node in SESSION.names(master) if node.startswith(name)})


class Advice(unittest.TestCase):
    def test_a_name_without_an_address_names_the_parameter(self):
        """A publisher advertises a name that this machine does not resolve."""
        topic = "/unresolved"
        SESSION.node("workstation_cpp").send("subscribe", topic, STRING)
        SESSION.robot.ask("registerPublisher", topic, STRING, "http://robot-without-address.invalid:1234/")
        self.addCleanup(SESSION.robot.ask, "unregisterPublisher", topic, "http://robot-without-address.invalid:1234/")
        expected = rf"robot-without-address\.invalid.*add it to the parameter {NAME}_home/robot/hosts"
        processes.wait_until(lambda: re.search(expected, SESSION.translator.log.read_text()), 20,
                             SESSION.translator.log_tail)


if __name__ == "__main__":
    unittest.main()
