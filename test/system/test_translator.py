"""The translator between two masters: Indigo-era nodes at one, Noetic-era nodes at the other."""

import itertools
import math
import pathlib
import sys
import time
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "translator"))

from harness import eras, processes  # noqa: E402
from harness.session import NAME, Session, both_directions  # noqa: E402

SESSION = None
LANGUAGES = ("cpp", "python")

PARAMETERS = {
    "topics": {"allow": [".*"], "deny": ["/denied/.*"]},
    "profiles": [
        {"pattern": "/slash/.*", "frame_slash": "strip"},
        {"pattern": "/exact", "queue": 1000},
        {"pattern": "/limited", "max_rate_hz": 10.0},
        {"pattern": "/one_way/.*", "directions": "robot_to_workstation"},
    ],
}


def setUpModule():
    global SESSION
    SESSION = Session()
    unittest.addModuleCleanup(SESSION.close)
    SESSION.start(*(f"{side}_{language}" for side in ("robot", "workstation") for language in LANGUAGES))
    SESSION.translate(**PARAMETERS)


def random_message(kind, seed):
    """Random content that has a meaning where a rule asks for one: see the rules in config/translate."""
    message = eras.RandomContent(seed).message(kind)
    if kind._type == "baxter_core_msgs/HeadPanCommand":
        if hasattr(message, "speed"):
            message.speed = seed % 101
        else:
            message.speed_ratio = (seed % 101) / 100
    return eras.leave_shapes_where_they_are(message)


def check_workstation(test, robot, workstation):
    """What Noetic has and Indigo has not."""
    kind = workstation._type
    if kind == "control_msgs/JointControllerState":
        test.assertIs(workstation.antiwindup, False)
    if kind == "sensor_msgs/BatteryState":
        test.assertTrue(math.isnan(workstation.temperature))
        test.assertEqual([], list(workstation.cell_temperature))
    if kind == "moveit_msgs/MotionPlanRequest":
        test.assertEqual(("", "", 0.0, []), (
            workstation.pipeline_id, workstation.cartesian_speed_limited_link, workstation.max_cartesian_speed,
            workstation.reference_trajectories))
    if kind == "baxter_core_msgs/HeadPanCommand":
        test.assertAlmostEqual(robot.speed / 100, workstation.speed_ratio, places=5)
        test.assertEqual(1, workstation.enable_pan_request)
    if kind == "baxter_core_msgs/SEAJointState":
        test.assertEqual((robot.position, robot.velocity, robot.effort),
                         (workstation.actual_position, workstation.actual_velocity, workstation.actual_effort))
        test.assertEqual(([], 0.0), (list(workstation.commanded_position), workstation.hystState))
    if kind == "baxter_core_msgs/EndpointState":
        test.assertEqual(("base", 0), (workstation.header.frame_id, workstation.header.stamp.to_nsec()))


def check_robot(test, workstation, robot):
    """What changed its name or unit on the way back."""
    if robot._type == "baxter_core_msgs/HeadPanCommand":
        test.assertEqual(round(workstation.speed_ratio * 100), robot.speed)
    if robot._type == "baxter_core_msgs/SEAJointState":
        test.assertEqual((workstation.actual_position, workstation.actual_velocity, workstation.actual_effort),
                         (robot.position, robot.velocity, robot.effort))


class Topics(unittest.TestCase):
    TYPES = ("baxter_core_msgs/EndpointState", "baxter_core_msgs/HeadPanCommand", "baxter_core_msgs/JointCommand",
             "baxter_core_msgs/SEAJointState", "control_msgs/JointControllerState", "moveit_msgs/MotionPlanRequest",
             "sensor_msgs/BatteryState", "sensor_msgs/JointState", "visualization_msgs/Marker")

    def test_every_type_in_both_directions_between_cpp_and_python(self):
        """Latched, so that nothing needs to be sent twice; every publisher is heard by both languages."""
        sent = {}
        cases = itertools.product(self.TYPES, both_directions(), LANGUAGES)
        for seed, (kind, (source, target), language) in enumerate(cases):
            topic = f"/types/{source}_{language}/{kind.split('/')[1]}"
            message = random_message(SESSION.era_of(source).message(kind), seed)
            sent[topic, kind, target] = message
            publisher = SESSION.node(f"{source}_{language}")
            publisher.send("advertise", topic, kind, 1)
            publisher.send("publish", topic, eras.to_hex(message))
            for hearing in LANGUAGES:
                SESSION.node(f"{target}_{hearing}").send("subscribe", topic, kind)
        for (topic, kind, target), message in sent.items():
            for hearing in LANGUAGES:
                with self.subTest(topic=topic, hears=f"{target}_{hearing}"):
                    heard = SESSION.node(f"{target}_{hearing}").wait_for("message", topic)
                    self.assertEqual(NAME, heard[0][0])
                    got = eras.from_hex(SESSION.era_of(target).message(kind), heard[0][1])
                    expected = eras.from_hex(type(message), eras.to_hex(message))
                    same = eras.same_value(eras.without_seq(expected), eras.without_seq(got))
                    self.assertTrue(same, f"{expected}\n{got}")
                    (check_workstation if target == "workstation" else check_robot)(self, expected, got)

    def test_speed_of_the_head_is_a_percentage_or_a_ratio(self):
        kind = "baxter_core_msgs/HeadPanCommand"
        for source, target, fields, expected in (
                ("robot", "workstation", {"target": 1.0, "speed": 50}, {"speed_ratio": 0.5}),
                ("workstation", "robot", {"target": 1.0, "speed_ratio": 0.5}, {"speed": 50})):
            topic = f"/head/from_{source}"
            SESSION.node(f"{source}_cpp").send("advertise", topic, kind, 1)
            SESSION.node(f"{source}_cpp").send("publish", topic, eras.to_hex(SESSION.message(source, kind, **fields)))
            SESSION.node(f"{target}_cpp").send("subscribe", topic, kind)
            heard = SESSION.node(f"{target}_cpp").wait_for("message", topic)
            got = eras.from_hex(SESSION.era_of(target).message(kind), heard[0][1])
            for name, value in expected.items():
                self.assertEqual(value, getattr(got, name))

    def test_several_versions_on_one_topic(self):
        """An Indigo-era node that runs at the workstation's master hears and is heard as well as its neighbours."""
        kind, topic, back = "control_msgs/JointControllerState", "/versions", "/versions_back"
        stranger = SESSION.foreign("workstation_cpp")
        for node in (stranger, SESSION.node("workstation_cpp"), SESSION.node("workstation_python")):
            node.send("subscribe", topic, kind)
        message = SESSION.message("robot", kind, set_point=3.5, i_clamp=0.25)
        SESSION.node("robot_cpp").send("advertise", topic, kind, 1)
        SESSION.node("robot_cpp").send("publish", topic, eras.to_hex(message))
        for node, era in ((stranger, "robot"), (SESSION.node("workstation_cpp"), "workstation"),
                          (SESSION.node("workstation_python"), "workstation")):
            heard = node.wait_for("message", topic)
            got = eras.from_hex(SESSION.era_of(era).message(kind), heard[0][1])
            self.assertEqual((3.5, 0.25), (got.set_point, got.i_clamp))
        SESSION.node("robot_python").send("subscribe", back, kind)
        for node, era, value in ((stranger, "robot", 1.0), (SESSION.node("workstation_cpp"), "workstation", 2.0)):
            node.send("advertise", back, kind, 1)
            node.send("publish", back, eras.to_hex(SESSION.message(era, kind, set_point=value)))
        heard = SESSION.node("robot_python").wait_for("message", back, 2)
        values = {eras.from_hex(SESSION.era_of("robot").message(kind), text).set_point for _, text in heard}
        self.assertEqual({1.0, 2.0}, values)

    def test_latched_messages_reach_late_subscribers(self):
        topic, kind = "/late", "std_msgs/String"
        robot, first, second = SESSION.start("robot_cpp", "workstation_cpp", "workstation_python")
        robot.send("advertise", topic, kind, 1)
        robot.send("publish", topic, eras.to_hex(SESSION.message("robot", kind, data="one")))
        first.send("subscribe", topic, kind)
        first.wait_for("message", topic)
        robot.send("publish", topic, eras.to_hex(SESSION.message("robot", kind, data="two")))
        first.wait_for("message", topic, 2)
        second.send("subscribe", topic, kind)
        heard = second.wait_for("message", topic)
        self.assertEqual("two", eras.from_hex(SESSION.era_of("workstation").message(kind), heard[0][1]).data)

    def test_static_transforms_of_several_nodes(self):
        """Each latches its own message on one topic: a late subscriber must get all of them."""
        kind = "tf2_msgs/TFMessage"
        for source, target in both_directions():
            children = set()
            for language in LANGUAGES:
                child = f"{source}_{language}_link"
                children.add(child)
                node = SESSION.node(f"{source}_{language}")
                node.send("advertise", "/tf_static", kind, 1)
                node.send("publish", "/tf_static", eras.to_hex(SESSION.message(source, kind, transforms=[
                    {"header": {"frame_id": "base"}, "child_frame_id": child, "transform": {"rotation": {"w": 1.0}}}])))
            for language in LANGUAGES:
                node = SESSION.node(f"{target}_{language}")
                node.send("subscribe", "/tf_static", kind)
                processes.wait_until(lambda: children <= self.children(node, target), 15,
                                     lambda: f"{node.name} heard of {self.children(node, target)} of {children}")

    @staticmethod
    def children(node, side):
        kind = SESSION.era_of(side).message("tf2_msgs/TFMessage")
        return {transform.child_frame_id for _, text in node.heard("message", "/tf_static")
                for transform in eras.from_hex(kind, text).transforms}

    def test_transforms(self):
        kind = "tf2_msgs/TFMessage"
        for source, target in both_directions():
            node = SESSION.node(f"{target}_cpp")
            node.send("subscribe", "/tf", kind)
            SESSION.node(f"{source}_cpp").send("advertise", "/tf", kind, 0)
            SESSION.node(f"{source}_cpp").send("repeat", "/tf", 20, 100, eras.to_hex(SESSION.message(
                source, kind, transforms=[{"header": {"frame_id": "odom"}, "child_frame_id": f"{source}_base",
                                           "transform": {"rotation": {"w": 1.0}}}])))
            processes.wait_until(lambda: any(f"{source}_base" in bytes.fromhex(text[1:]).decode("latin1") for _, text
                                             in node.heard("message", "/tf")), 10, f"a transform at {target}")

    def test_transforms_under_their_old_name(self):
        """tf/tfMessage and tf2_msgs/TFMessage are one type with two names."""
        robot, workstation = SESSION.start("robot_python", "workstation_cpp")
        workstation.send("subscribe", "/tf_renamed", "tf2_msgs/TFMessage")
        robot.send("advertise", "/tf_renamed", "tf/tfMessage", 1)
        robot.send("publish", "/tf_renamed", eras.to_hex(SESSION.message("robot", "tf/tfMessage", transforms=[
            {"header": {"frame_id": "odom"}, "child_frame_id": "renamed", "transform": {"rotation": {"w": 1.0}}}])))
        heard = workstation.wait_for("message", "/tf_renamed")[0][1]
        got = eras.from_hex(SESSION.era_of("workstation").message("tf2_msgs/TFMessage"), heard)
        self.assertEqual("renamed", got.transforms[0].child_frame_id)

    def test_rate_limit(self):
        topic, kind = "/limited", "std_msgs/Float64"
        robot, workstation = SESSION.start("robot_cpp", "workstation_cpp")
        workstation.send("subscribe", topic, kind)
        robot.send("advertise", topic, kind, 0)
        processes.wait_until(lambda: "/workstation_cpp" in SESSION.workstation.nodes(1, topic) and
                             NAME in SESSION.robot.nodes(1, topic), 10, topic)
        begin = time.monotonic()
        robot.send("stream", topic, 200, 400)
        robot.wait_for("repeated", topic)
        seconds = time.monotonic() - begin
        processes.wait_until(lambda: len(workstation.heard("message", topic)) >= 5, 5, "some of them")
        self.assertLessEqual(len(workstation.heard("message", topic)), 10 * seconds + 2)

    def test_both_sides_publish_one_topic(self):
        """Everybody hears every message exactly once."""
        topic, kind, count = "/exact", "std_msgs/String", 100
        speakers = [(side, SESSION.node(f"{side}_cpp")) for side in ("robot", "workstation")]
        listeners = [(side, SESSION.node(f"{side}_python")) for side in ("robot", "workstation")]
        for _, node in listeners:
            node.send("subscribe", topic, kind)
        for _, node in speakers:
            node.send("advertise", topic, kind, 0)
        self.warm_up(topic, kind, speakers, listeners)
        for index in range(count):
            for side, node in speakers:
                node.send("publish", topic, SESSION.string(f"{side}_{index}"))
        for side, node in speakers:
            node.send("publish", topic, SESSION.string(f"{side}_end"))
        expected = sorted(f"{side}_{index}" for side, _ in speakers for index in range(count))
        for side, node in listeners:
            self.until_heard(node, topic, {"robot_end", "workstation_end"})
            counted = [text for text in node.texts(topic) if not text.startswith("warm") and not text.endswith("end")]
            self.assertEqual(expected, sorted(counted))

    def warm_up(self, topic, kind, speakers, listeners):
        """Sends until everybody hears everybody: connections take their time."""
        def all_connected():
            for side, node in speakers:
                node.send("publish", topic, SESSION.string(f"warm_{side}"))
            return all({f"warm_{side}" for side, _ in speakers} <= set(node.texts(topic)) for _, node in listeners)
        processes.wait_until(all_connected, 15, lambda: str([set(node.texts(topic)) for _, node in listeners]))

    def until_heard(self, node, topic, texts, seconds=10):
        processes.wait_until(lambda: texts <= set(node.texts(topic)), seconds,
                             lambda: f"{texts} at {node.name}, heard {node.texts(topic)[-5:]}")

    def test_two_translators_do_not_answer_each_other(self):
        topic, kind, count = "/twice", "std_msgs/String", 20
        second = SESSION.another_translator("/translator_2", {"topics": {"allow": [topic]}, "services": {"allow": []}})
        try:
            speakers = [(side, SESSION.node(f"{side}_cpp")) for side in ("robot", "workstation")]
            listeners = [(side, SESSION.node(f"{side}_python")) for side in ("robot", "workstation")]
            for _, node in listeners:
                node.send("subscribe", topic, kind)
            for _, node in speakers:
                node.send("advertise", topic, kind, 0)
            self.warm_up(topic, kind, speakers, listeners)
            for _, node in listeners:  # both of them are at work
                processes.wait_until(
                    lambda: {NAME, "/translator_2"} <= {who for who, _ in node.heard("message", topic)} or
                    self.warm_up(topic, kind, speakers, listeners), 15, "both translators")
            for index in range(count):
                for side, node in speakers:
                    node.send("publish", topic, SESSION.string(f"{side}_{index}"))
            for side, node in speakers:
                node.send("publish", topic, SESSION.string(f"{side}_end"))
            for side, node in listeners:
                self.until_heard(node, topic, {"robot_end", "workstation_end"})
            # What went around would come again and again: the last message's second copy is the end of it.
            for side, node in listeners:
                other = "robot" if side == "workstation" else "workstation"
                processes.wait_until(lambda: node.texts(topic).count(f"{other}_end") == 2, 10, "both copies")
                for index in range(count):
                    self.assertEqual(1, node.texts(topic).count(f"{side}_{index}"), "heard directly, once")
                    self.assertEqual(2, node.texts(topic).count(f"{other}_{index}"), "once from each translator")
        finally:
            second.end()

    def test_what_is_not_allowed_stays(self):
        """/denied by the filter, /one_way by its direction, /clock unless asked for. /bridged shows when to check."""
        robot, workstation = SESSION.start("robot_python", "workstation_python")
        for topic, kind in (("/denied/a", "std_msgs/String"), ("/clock", "rosgraph_msgs/Clock"),
                            ("/bridged/1", "std_msgs/String")):
            robot.send("advertise", topic, kind, 0)
            workstation.send("subscribe", topic, kind)
        for topic in ("/one_way/a", "/bridged/2"):
            workstation.send("advertise", topic, "std_msgs/String", 0)
            robot.send("subscribe", topic, "std_msgs/String")
        processes.wait_until(lambda: NAME in SESSION.workstation.nodes(0, "/bridged/1"), 10,
                             "/bridged/1 at the workstation's master")
        processes.wait_until(lambda: NAME in SESSION.robot.nodes(0, "/bridged/2"), 10,
                             "/bridged/2 at the robot's master")
        for master, topic in ((SESSION.workstation, "/denied/a"), (SESSION.workstation, "/clock"),
                              (SESSION.robot, "/one_way/a")):
            self.assertNotIn(NAME, master.nodes(0, topic), topic)
        for node, topic in ((robot, "/clock"), (workstation, "/clock")):
            node.send("unadvertise" if node is robot else "unsubscribe", topic)

    def test_leading_slash_of_frames(self):
        for source, target in both_directions():
            topic, kind = f"/slash/from_{source}", "sensor_msgs/JointState"
            SESSION.node(f"{source}_cpp").send("advertise", topic, kind, 1)
            SESSION.node(f"{source}_cpp").send("publish", topic, eras.to_hex(
                SESSION.message(source, kind, header={"frame_id": "/base"}, name=["/kept"])))
            SESSION.node(f"{target}_cpp").send("subscribe", topic, kind)
            heard = SESSION.node(f"{target}_cpp").wait_for("message", topic)
            got = eras.from_hex(SESSION.era_of(target).message(kind), heard[0][1])
            self.assertEqual(("base", ["/kept"]), (got.header.frame_id, got.name))

    def test_warnings_of_the_robot_are_heard(self):
        robot, workstation = SESSION.start("robot_python", "workstation_python")
        workstation.send("subscribe", "/rosout", "rosgraph_msgs/Log")
        robot.send("subscribe", "/rosout", "rosgraph_msgs/Log")
        kind = SESSION.era_of("workstation").message("rosgraph_msgs/Log")

        def heard(node):
            return {log.msg for log in (eras.from_hex(kind, text) for _, text in node.heard("message", "/rosout"))}

        def warned():
            robot.send("log", "info", "only_information")
            robot.send("log", "warn", "a_warning")
            workstation.send("log", "error", "of_the_workstation_side")
            return "a_warning" in heard(workstation)
        processes.wait_until(warned, 15, "the warning at the workstation side")
        self.assertNotIn("only_information", heard(workstation))
        self.assertNotIn("of_the_workstation_side", heard(robot))


class OneHost(unittest.TestCase):
    """Both masters on this host at two ports, as on a computer that simulates the robot."""

    def test_topics_and_services(self):
        session = Session(one_host=True)
        try:
            robot, workstation = session.start("robot_cpp", "workstation_python")
            kind = "control_msgs/JointControllerState"
            for source, target, side in ((robot, workstation, "robot"), (workstation, robot, "workstation")):
                source.send("advertise", f"/from_{side}", kind, 1)
                source.send("publish", f"/from_{side}", eras.to_hex(session.message(side, kind, set_point=1.5)))
                target.send("subscribe", f"/from_{side}", kind)
            robot.send("serve", "/trigger", "std_srvs/Trigger", "x0100000000")
            session.translate()
            for node, topic, side in ((workstation, "/from_robot", "workstation"), (robot, "/from_workstation", "robot")):
                got = eras.from_hex(session.era_of(side).message(kind), node.wait_for("message", topic)[0][1])
                self.assertEqual(1.5, got.set_point)
            processes.wait_until(lambda: session.workstation.nodes(2, "/trigger"), 10,
                                 "/trigger at the workstation's master")
            workstation.send("call", "/trigger", "std_srvs/Trigger", "x")
            self.assertEqual("ok", workstation.wait_for("response", "/trigger")[0][0])
        finally:
            session.close()


if __name__ == "__main__":
    unittest.main()
