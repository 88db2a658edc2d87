"""What is special to rospy: it never connects again by itself. Two masters at two ports of this host."""

import pathlib
import signal
import sys
import time
import unittest
import xmlrpc.client

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "translator"))

from harness import processes  # noqa: E402
from harness.session import NAME, STRING, Session  # noqa: E402

SESSION = None

PARAMETERS = {"profiles": [{"pattern": "/command.*", "max_age_s": 0.3, "queue": 1, "priority": "control"}]}


def setUpModule():
    global SESSION
    SESSION = Session(one_host=True)
    unittest.addModuleCleanup(SESSION.close)
    SESSION.start("robot_python", "workstation_python", "workstation_cpp")
    SESSION.translate(**PARAMETERS)


def subscribers(master, topic):
    """Caller ids that the translator sends a topic to, as its own slave API reports."""
    with xmlrpc.client.ServerProxy(master.ask("lookupNode", NAME)) as node:
        _, _, rows = node.getBusInfo("/test")
    return [row[1] for row in rows if row[2] == "o" and row[4] == topic]


class Rospy(unittest.TestCase):
    def begin(self, source, target, topic):
        source.send("advertise", topic, STRING, 0)
        target.send("subscribe", topic, STRING)
        SESSION.flow(source, target, topic, "at_first")

    def test_listener_whose_connection_was_given_up_is_called_back(self):
        """It stood still for longer than commands live; its connection ended meanwhile."""
        topic = "/command_large"
        source, target = SESSION.start("workstation_cpp", "robot_python_stops")
        self.begin(source, target, topic)
        # Before the large ones: not in the middle of a long line of its output.
        target.process.send_signal(signal.SIGSTOP)
        try:
            source.send("repeat", topic, 50, 1_000_000, SESSION.string("x" * 400_000))
            processes.wait_until(lambda: not subscribers(SESSION.robot, topic), 20, "the translator gives it up")
        finally:
            target.process.send_signal(signal.SIGCONT)
        source.send("stop", topic)
        SESSION.flow(source, target, topic, "again")
        SESSION.end_node("robot_python_stops")

    def test_listener_that_is_killed_and_started_again_hears(self):
        topic = "/command_to_mortal"
        source, target = SESSION.start("workstation_python", "robot_python_mortal")
        self.begin(source, target, topic)
        SESSION.end_node("robot_python_mortal", kill=True)
        target = SESSION.node("robot_python_mortal")
        target.send("subscribe", topic, STRING)
        SESSION.flow(source, target, topic, "second_life")
        self.assertEqual(["/robot_python_mortal"], subscribers(SESSION.robot, topic))
        SESSION.end_node("robot_python_mortal")

    def test_listener_that_unsubscribed_is_left_alone(self):
        topic = "/command_unwanted"
        source, target = SESSION.start("workstation_cpp", "robot_python")
        self.begin(source, target, topic)
        target.send("unsubscribe", topic)
        processes.wait_until(lambda: not subscribers(SESSION.robot, topic), 20, "it leaves")
        heard = len(target.heard("message", topic))
        target.send("subscribe", topic, STRING)
        SESSION.flow(source, target, topic, "wanted_again")
        self.assertGreater(len(target.heard("message", topic)), heard)
        self.assertEqual(1, len(subscribers(SESSION.robot, topic)), "one connection, not two")

    def test_talker_that_is_replaced_while_the_translator_stands_still(self):
        """Same name, other process: the master's notification waits, or is lost."""
        topic = "/state_of_mortal"
        source, target = SESSION.start("robot_python_talker", "workstation_python")
        self.begin(source, target, topic)
        SESSION.translator.process.send_signal(signal.SIGSTOP)
        try:
            SESSION.end_node("robot_python_talker", kill=True)
            source = SESSION.node("robot_python_talker")
            source.send("advertise", topic, STRING, 0)
            time.sleep(1.0)  # it stands still
        finally:
            SESSION.translator.process.send_signal(signal.SIGCONT)
        SESSION.flow(source, target, topic, "second_talker")
        SESSION.end_node("robot_python_talker", kill=True)

    def test_reloading_rules_brings_everybody_back(self):
        """All connections end and begin anew, both ways, also when rospy sees the end after the call."""
        robot, workstation = SESSION.start("robot_python", "workstation_python")
        streams = [(robot, workstation, "/reloaded_to_workstation"), (workstation, robot, "/reloaded_to_robot"),
                   (workstation, robot, "/command_reloaded")]
        for stream in streams:
            self.begin(*stream)
        for life in range(3):
            workstation.send("call", f"{NAME}_home/reload_rules", "std_srvs/Trigger", "x")
            self.assertEqual("ok", workstation.wait_for("response", f"{NAME}_home/reload_rules", life + 1)[life][0])
            for stream in streams:
                SESSION.flow(*stream, f"life_{life}")


if __name__ == "__main__":
    unittest.main()
