"""The translator when masters, nodes and networks fail, and when peers are hostile."""

import pathlib
import random
import struct
import sys
import time
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "translator"))

from harness import eras, processes, raw_peer  # noqa: E402
from harness.session import NAME, STRING, Session  # noqa: E402

SESSION = None
MAX_STALE_OF_FOUR_CUTS = 1  # a translator that does not watch the carrier delivers three
MAX_AGE_S = 0.3

PARAMETERS = {
    "profiles": [
        {"pattern": "/command.*", "max_age_s": MAX_AGE_S, "queue": 1, "priority": "control"},
        {"pattern": "/shifted.*", "lazy": False},
    ],
}


def setUpModule():
    global SESSION
    SESSION = Session()
    unittest.addModuleCleanup(SESSION.close)
    SESSION.start("robot_cpp", "workstation_cpp", "robot_python", "workstation_python")
    SESSION.translate(**PARAMETERS)


class Faults(unittest.TestCase):
    def flow(self, source, target, topic, text, seconds=20):
        source.send("advertise", topic, STRING, 0)
        target.send("subscribe", topic, STRING)
        SESSION.flow(source, target, topic, text, seconds)

    def serve(self, server, client, client_master, name, seconds=20):
        server.send("serve", name, "std_srvs/Trigger", "x0100000000")
        processes.wait_until(lambda: client_master.nodes(2, name), seconds, f"{name} at {client_master.name}")
        client.send("call", name, "std_srvs/Trigger", "x")
        self.assertEqual(["ok", "x0100000000"], client.wait_for("response", name)[0][:2])

    def latch(self, source, target, topic, text, seconds=20):
        source.send("advertise", topic, STRING, 1)
        source.send("publish", topic, SESSION.string(text))
        target.send("subscribe", topic, STRING)
        processes.wait_until(lambda: text in target.texts(topic), seconds, f"{text} at {target.name}")

    def restart_master(self, side):
        """What both sides had goes on, and what comes afterwards works without help."""
        other = "workstation" if side == "robot" else "robot"
        master = SESSION.master_of(side)
        before = SESSION.start(f"{side}_cpp", f"{other}_cpp")
        for index, (source, target) in enumerate((before, before[::-1])):
            self.flow(source, target, f"/{side}_master/before_{index}", "before")
        master.kill()
        for index, (source, target) in enumerate((before, before[::-1])):
            topic = f"/{side}_master/before_{index}"
            source.send("publish", topic, SESSION.string("without_master"))
            processes.wait_until(lambda: "without_master" in target.texts(topic), 5, "a message without a master")
        master.start()
        processes.wait_until(lambda: NAME in SESSION.names(master), 15, "the translator, registered again")
        mine, theirs = SESSION.start(f"{side}_cpp_after_{side}", f"{other}_python")
        for index, (source, target) in enumerate(((mine, theirs), (theirs, mine))):
            self.flow(source, target, f"/{side}_master/after_{index}", "after")
            self.latch(source, target, f"/{side}_master/latched_{index}", "kept")
        self.serve(mine, theirs, SESSION.master_of(other), f"/{side}_master/served_here")
        self.serve(theirs, mine, master, f"/{side}_master/served_there")
        if side == "workstation":  # where the translator has its own node, with its reports
            processes.wait_until(lambda: f"{NAME}_home" in master.nodes(0, "/diagnostics"), 10, "reports again")
        # What was known before the restart is still offered to those who come after it.
        mine.send("subscribe", f"/{side}_master/before_1", STRING)
        self.flow(before[1], mine, f"/{side}_master/before_1", "to_the_newcomer")
        SESSION.end_node(f"{side}_cpp_after_{side}")

    def test_robot_master_restarts(self):
        self.restart_master("robot")

    def test_workstation_master_restarts(self):
        self.restart_master("workstation")

    def test_publisher_is_killed_and_comes_back(self):
        topic = "/killed"
        target = SESSION.node("workstation_python")
        self.flow(SESSION.node("robot_cpp_mortal"), target, topic, "first_life")
        SESSION.end_node("robot_cpp_mortal", kill=True)
        self.flow(SESSION.node("robot_cpp_mortal"), target, topic, "second_life")
        self.latch(SESSION.node("robot_cpp_mortal"), target, topic + "_latched", "third")
        SESSION.end_node("robot_cpp_mortal", kill=True)

    def test_no_stale_command_after_an_outage(self):
        """Commands go on while the network is away: what is delivered later is young, and soon flows again."""
        if not SESSION.separate:
            self.skipTest("needs network namespaces: run as root")
        cable = SESSION.network.robot_cable
        for seconds in (0.8, 1.0, 4.0):
            with self.subTest(outage_s=seconds):
                self.outage(f"_lost_{int(10 * seconds)}", seconds, cable.cut, cable.mend)

    def test_no_stale_command_after_a_cable_was_pulled(self):
        """The kernel keeps packets for a neighbour that it cannot ask for its address, and sends them afterwards. One that it
        took in the moment of the cut, before the translator heard of it, can come late; it is rare (docs/translator.md)."""
        if not SESSION.separate:
            self.skipTest("needs network namespaces: run as root")
        cable, stale = SESSION.network.robot_cable, []
        for seconds in (0.8, 1.0, 2.0, 3.0):
            with self.subTest(outage_s=seconds):
                self.outage(f"_pulled_{int(10 * seconds)}", seconds, cable.pull, cable.plug, stale)
        self.assertLessEqual(len(stale), MAX_STALE_OF_FOUR_CUTS, f"ages of commands that came late: {stale}")

    def outage(self, name, seconds, begin, end, stale=None):
        """`stale`: takes the ages of commands that come late; without it there must be none."""
        workstation, robot = SESSION.start("workstation_cpp", "robot_cpp")
        # What a node behind the cut keeps in its own queue is its own: only commands to there are the translator's
        # to drop.
        streams = [(workstation, robot, "/command_to_robot" + name), (workstation, robot, "/plain_to_robot" + name),
                   (robot, workstation, "/plain_to_workstation" + name)]
        for source, target, topic in streams:
            target.send("subscribe", topic, "std_msgs/Float64")
            source.send("advertise", topic, "std_msgs/Float64", 0)
            source.send("stream", topic, 100, 1_000_000)
        for source, target, topic in streams:
            target.wait_for("message", topic, 50)
        begin()
        time.sleep(seconds)  # the outage itself
        before = [len(target.heard("message", topic)) for _, target, topic in streams]
        end()
        mended = time.time()
        for (source, target, topic), count in zip(streams, before):
            with self.subTest(topic):
                target.wait_for("message", topic, count + 200, seconds=20)
                after = target.heard("message", topic)[count:]
                if topic.startswith("/command"):
                    late = [age for age in target.ages(topic, count) if age >= MAX_AGE_S + 0.3]
                    if stale is None:
                        self.assertEqual([], late, topic)
                    else:
                        stale += late
                self.assertLess(after[0].heard_at - mended, 8.0, f"{topic} flows again")
        self.serve(robot, SESSION.node("workstation_python"), SESSION.workstation, "/served_after_outage" + name)
        for source, _, topic in streams:
            source.send("stop", topic)

    def test_rospy_hears_commands_again_after_an_outage(self):
        """It gives up a connection that ends, for good: the translator has to call it back."""
        if not SESSION.separate:
            self.skipTest("needs network namespaces: run as root")
        source, listener = SESSION.start("workstation_cpp", "robot_python")
        topic = "/command_to_rospy"
        listener.send("subscribe", topic, "std_msgs/Float64")
        source.send("advertise", topic, "std_msgs/Float64", 0)
        source.send("stream", topic, 100, 1_000_000)
        listener.wait_for("message", topic, 50)
        for seconds in (1.0, 4.0):
            with self.subTest(outage_s=seconds):
                SESSION.network.robot_cable.cut()
                time.sleep(seconds)  # the outage itself
                count = len(listener.heard("message", topic))
                SESSION.network.robot_cable.mend()
                mended = time.time()
                listener.wait_for("message", topic, count + 200, seconds=20)
                after = listener.heard("message", topic)[count:]
                self.assertLess(after[0].heard_at - mended, 8.0)
                ages = listener.ages(topic, count)
                self.assertLess(max(ages), MAX_AGE_S + 0.5, sorted(ages)[-5:])
        source.send("stop", topic)

    def test_publisher_replaced_during_an_outage(self):
        """The master's notification is lost; the translator's connection to the dead one looks alive."""
        if not SESSION.separate:
            self.skipTest("needs network namespaces: run as root")
        topic, target = "/replaced", SESSION.node("workstation_python")
        self.flow(SESSION.node("robot_cpp_replaced"), target, topic, "before")
        for life, seconds in enumerate((0.0, 3.2)):
            with self.subTest(outage_s=seconds):
                SESSION.network.robot_cable.cut()
                cut = time.monotonic()
                SESSION.end_node("robot_cpp_replaced", kill=True)
                source = SESSION.node("robot_cpp_replaced")
                source.send("advertise", topic, STRING, 0)
                time.sleep(max(0.0, cut + seconds - time.monotonic()))  # the outage itself
                SESSION.network.robot_cable.mend()
                self.flow(source, target, topic, f"life_{life}")
        SESSION.end_node("robot_cpp_replaced")

    def test_slow_network_that_loses_packets(self):
        """Images want twenty times what a cable carries, which drops the rest: commands that come are young."""
        if not SESSION.separate:
            self.skipTest("needs network namespaces: run as root")
        command, images, kind = "/command_slow", "/images_slow", "sensor_msgs/Image"
        source, plain, rospy_node = SESSION.start("workstation_cpp", "robot_cpp", "robot_python")
        image = eras.to_hex(SESSION.message("workstation", kind, width=100, height=333, step=300, data=bytes(100_000)))
        for node in (plain, rospy_node):
            node.send("subscribe", command, "std_msgs/Float64")
        plain.send("subscribe", images, kind)
        source.send("advertise", command, "std_msgs/Float64", 0)
        source.send("advertise", images, kind, 0)
        source.send("stream", command, 50, 1_000_000)
        source.send("repeat", images, 10, 1_000_000, image)
        listeners = [(plain, command), (rospy_node, command), (plain, images)]
        for node, topic in listeners:
            node.wait_for("message", topic, 20)
        SESSION.network.robot_cable.slow(400)
        time.sleep(6.0)  # it is slow
        before = [len(node.heard("message", topic)) for node, topic in listeners]
        SESSION.network.robot_cable.mend()
        for (node, topic), count in zip(listeners, before):
            node.wait_for("message", topic, count + 50, seconds=20)
        for topic in (command, images):
            source.send("stop", topic)
        for node in (plain, rospy_node):
            ages = node.ages(command)
            self.assertLess(max(ages), MAX_AGE_S + 0.7, f"{node.name}: {sorted(ages)[-5:]}")

    def test_stopped_subscriber_costs_nobody_else(self):
        """Its queue is bounded, the others hear everything, and it hears the newest when it goes on."""
        kind, topic, count, waiting = "sensor_msgs/Image", "/images", 150, 10
        source, well = SESSION.start("robot_cpp", "workstation_cpp")
        stopped = SESSION.node("workstation_cpp_stopped")
        for node in (well, stopped):
            node.send("subscribe", topic, kind)
        source.send("advertise", topic, kind, 0)
        image = eras.to_hex(SESSION.message("robot", kind, width=500, height=500, step=1000, data=bytes(500_000)))

        def both_hear():
            source.send("publish", topic, image)
            return well.heard("message", topic) and stopped.heard("message", topic)
        processes.wait_until(both_hear, 15, "the first image at both")
        before_mb, heard = SESSION.translator.memory_mb(), len(well.heard("message", topic))
        stopped.process.send_signal(19)
        try:
            for sent in range(waiting, count + 1, waiting):  # no more at a time than may wait: a busy machine loses none
                source.send("repeat", topic, 50, waiting, image)
                well.wait_for("message", topic, heard + sent, seconds=20)
            self.assertLess(SESSION.translator.memory_mb() - before_mb, 40, "10 images of 0.5 MB may wait")
        finally:
            stopped.process.send_signal(18)
        got = len(stopped.heard("message", topic))
        source.send("publish", topic, image)
        stopped.wait_for("message", topic, got + 1)
        SESSION.end_node("workstation_cpp_stopped")

    def test_hostile_bytes(self):
        """Garbage, lies about lengths and half messages at every port: nothing falls, nothing leaks."""
        source, target = SESSION.start("robot_cpp", "workstation_cpp")
        self.flow(source, target, "/hostile_workstation", "before")
        self.flow(target, source, "/hostile_robot", "before")
        for side in ("robot", "workstation"):
            master = SESSION.master_of(side)
            uri = master.ask("lookupNode", NAME)
            files = SESSION.translator.open_files()
            for address in raw_peer.address_of(uri), raw_peer.topic_address(master.place, uri, f"/hostile_{side}"):
                for content in raw_peer.hostile_contents(random.Random(7)):
                    raw_peer.throw(master.place, address, content)
            self.assertTrue(SESSION.translator.alive(), SESSION.translator.log_tail())
            processes.wait_until(lambda: SESSION.translator.open_files() <= files + 4, 10,
                                 lambda: f"{files} open files before, {SESSION.translator.open_files()} after")
        self.assertLess(SESSION.translator.memory_mb(), 300)
        self.flow(source, target, "/hostile_workstation", "after")
        self.flow(target, source, "/hostile_robot", "after")

    def test_strangers_get_the_reason(self):
        """An unknown definition: the refusal names the type, its MD5 and what to do."""
        source, target = SESSION.start("robot_cpp", "workstation_cpp")
        self.flow(source, target, "/strange", "before")
        uri = SESSION.workstation.ask("lookupNode", NAME)
        place = SESSION.workstation.place
        with raw_peer.connect(place, raw_peer.topic_address(place, uri, "/strange")) as stream:
            stream.sendall(raw_peer.header(topic="/strange", type="std_msgs/String", md5sum="1" * 32,
                                           callerid="/stranger"))
            refusal = raw_peer.read_header(stream)["error"]
        for text in ("std_msgs/String", "1" * 32, "definitions"):
            self.assertIn(text, refusal)

    def test_action_server_is_killed_and_comes_back(self):
        name, kind = "/mortal", "control_msgs/FollowJointTrajectory"
        client = SESSION.node("workstation_cpp")
        client.send("action_client", name, kind)
        goal = eras.to_hex(SESSION.message("workstation", kind + "Goal"))
        result = eras.to_hex(SESSION.message("robot", kind + "Result"))
        for life in (1, 2):
            server = SESSION.node("robot_python_server")
            server.send("action_server", name, kind)
            client.send("wait_server", name, 20)
            self.assertEqual(["1"], client.wait_for("connected", name, life, seconds=25)[-1])

            answered, begin, sent_at = 0, time.monotonic(), 0.0
            while len(client.heard("done", name)) < life:  # a goal for the dead server may be lost: send another
                self.assertLess(time.monotonic() - begin, 15, "no result")
                if time.monotonic() - sent_at > 3:
                    client.send("send_goal", name, goal)
                    sent_at = time.monotonic()
                if len(server.heard("goal", name)) > answered:
                    server.send("succeed", name, result, "well")
                    answered += 1
                time.sleep(0.02)
            SESSION.end_node("robot_python_server", kill=True)

    def test_publishers_that_lie(self):
        """A publisher whose messages end early or are absurdly long loses its connection, not the others theirs."""
        source, target = SESSION.start("robot_cpp", "workstation_cpp")
        self.flow(source, target, "/liar", "before")
        md5 = "992ce8a1687cec8c8bd883ec73ca41d1"
        with raw_peer.FakePublisher(SESSION.robot, "/liar", "std_msgs/String", md5) as liar:
            for body in (struct.pack("<I", 0xfffffff0), struct.pack("<II", 4, 1000),
                         struct.pack("<II", 8, 0xffffffff) + b"abcd", struct.pack("<I", 100) + b"short"):
                liar.greet(body)
        self.assertTrue(SESSION.translator.alive())
        self.flow(source, target, "/liar", "after")

    def test_versions_that_do_not_convert_are_reported(self):
        """No silence: the subscriber's and the publisher's types differ and no rule joins them."""
        topic = "/no_way"
        robot, workstation = SESSION.start("robot_cpp", "workstation_cpp")
        listener = SESSION.node("workstation_python")
        listener.send("subscribe", "/diagnostics", "diagnostic_msgs/DiagnosticArray")
        robot.send("advertise", topic, "std_msgs/Float64", 0)
        workstation.send("subscribe", topic, "std_msgs/String")
        kind = SESSION.era_of("workstation").message("diagnostic_msgs/DiagnosticArray")

        def report():
            for _, content in listener.heard("message", "/diagnostics")[-5:]:
                for status in eras.from_hex(kind, content).status:
                    everything = status.name + status.message + "".join(v.key + v.value for v in status.values)
                    if topic in everything and status.level > b"\0"[0]:
                        return everything
            return None
        reported = processes.wait_until(report, 20, "a report about it on /diagnostics")
        self.assertIn("std_msgs/Float64", reported)
        self.assertIn("std_msgs/String", reported)


class Clocks(unittest.TestCase):
    """The robot's clock is 100 s ahead; its stamps are known from a topic."""
    AHEAD_S = 100.0

    def test_stamps_are_shifted_in_both_directions(self):
        if not SESSION.separate:
            self.skipTest("needs the session of its own")
        second = SESSION.another_translator("/translator_clock", {
            "topics": {"allow": ["/shift/.*"]}, "services": {"allow": []},
            "clocks": {"shift_stamps": True, "reference_topics": ["/shift/states"]}})
        try:
            self.reference()
        finally:
            second.end()

    def reference(self):
        kind = "sensor_msgs/JointState"
        robot, workstation = SESSION.start("robot_cpp", "workstation_cpp")
        for source, target, topic in ((robot, workstation, "/shift/states"), (workstation, robot, "/shift/back")):
            source.send("advertise", topic, kind, 0)
            target.send("subscribe", topic, kind)

        def send(node, side, topic, stamp):
            message = SESSION.message(side, kind, name=["a"])
            message.header.stamp.secs, message.header.stamp.nsecs = int(stamp), int(stamp % 1 * 1e9)
            node.send("publish", topic, eras.to_hex(message))

        def stamps(node, side, topic):
            read = SESSION.era_of(side).message(kind)
            return [(e.heard_at, eras.from_hex(read, e[1]).header.stamp.to_sec()) for e in node.heard("message", topic)]

        def shifted():
            send(robot, "robot", "/shift/states", time.time() + self.AHEAD_S)
            return any(abs(at - stamp) < 0.3 for at, stamp in stamps(workstation, "workstation", "/shift/states")[-3:])
        processes.wait_until(shifted, 20, "a stamp of the robot side in the workstation side's time")

        def shifted_back():
            send(workstation, "workstation", "/shift/back", time.time())
            send(workstation, "workstation", "/shift/back", 0)
            return any(abs(stamp - at - self.AHEAD_S) < 0.3 for at, stamp in stamps(robot, "robot", "/shift/back")[-4:])
        processes.wait_until(shifted_back, 20, "a stamp of the workstation side in the robot side's time")
        processes.wait_until(lambda: 0.0 in [stamp for _, stamp in stamps(robot, "robot", "/shift/back")], 20,
                             "a stamp of 0, which is none and stays none")


if __name__ == "__main__":
    unittest.main()
