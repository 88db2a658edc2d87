"""Services, actions, parameters and ROS' own tools across the translator."""

import itertools
import math
import pathlib
import subprocess
import sys
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "translator"))

from harness import eras, processes  # noqa: E402
from harness.session import NAME, Session, both_directions  # noqa: E402

SESSION = None
LANGUAGES = ("cpp", "python")

PARAMETERS = {
    "parameters": {"robot_to_workstation": ["/robot_info", "/both_ways"],
                   "workstation_to_robot": ["/tuning", "/both_ways"]},
}


def setUpModule():
    global SESSION
    SESSION = Session()
    unittest.addModuleCleanup(SESSION.close)
    SESSION.start(*(f"{side}_{language}" for side in ("robot", "workstation") for language in LANGUAGES))
    SESSION.translate(**PARAMETERS)


class Services(unittest.TestCase):
    TYPES = ("baxter_core_msgs/SolvePositionIK", "controller_manager_msgs/SwitchController",
             "gazebo_msgs/GetModelState", "std_srvs/Trigger")

    def test_every_type_in_both_directions_between_cpp_and_python(self):
        calls = []
        cases = itertools.product(self.TYPES, both_directions(), LANGUAGES)
        for seed, (kind, (server, client), language) in enumerate(cases):
            name = f"/services/{server}_{language}/{kind.split('/')[1]}"
            response = eras.RandomContent(seed).message(SESSION.era_of(server).service(kind)._response_class)
            SESSION.node(f"{server}_{language}").send("serve", name, kind, eras.to_hex(response))
            calls.append((name, kind, server, client, language, response))
        for name, kind, server, client, language, response in calls:
            processes.wait_until(lambda: SESSION.master_of(client).nodes(2, name), 15, f"{name} at {client}")
            for index, calling in enumerate(LANGUAGES):
                with self.subTest(service=name, caller=f"{client}_{calling}"):
                    service = SESSION.era_of(client).service(kind)
                    request = eras.RandomContent(index).message(service._request_class)
                    node = SESSION.node(f"{client}_{calling}")
                    node.send("call", name, kind, eras.to_hex(request))
                    answer = node.wait_for("response", name)[0]
                    self.assertEqual("ok", answer[0], answer)
                    self.check_response(response, eras.from_hex(service._response_class, answer[1]))
                    asked = SESSION.node(f"{server}_{language}").wait_for("request", name, index + 1)[index][0]
                    served = SESSION.era_of(server).service(kind)
                    self.check_request(request, eras.from_hex(served._request_class, asked))

    def check_response(self, given, got):
        self.assertTrue(eras.same_value(eras.without_seq(given), eras.without_seq(got)), f"{given}\n{got}")
        if hasattr(got, "result_type") and not hasattr(given, "result_type"):
            self.assertEqual([2 if valid else 0 for valid in given.isValid], list(got.result_type))

    def check_request(self, given, got):
        self.assertTrue(eras.same_value(given, got), f"{given}\n{got}")
        if hasattr(got, "start_asap") and not hasattr(given, "start_asap"):
            self.assertEqual((False, 0.0), (got.start_asap, got.timeout))
        if hasattr(got, "seed_mode") and not hasattr(given, "seed_mode"):
            self.assertEqual((0, []), (got.seed_mode, got.seed_angles))

    def test_the_server_s_error_reaches_the_caller(self):
        for server, client in both_directions():
            name, kind = f"/fails_at_{server}", "gazebo_msgs/GetModelState"
            SESSION.node(f"{server}_python").send("serve", name, kind, "-")
            processes.wait_until(lambda: SESSION.master_of(client).nodes(2, name), 15, f"{name} at {client}")
            for calling in LANGUAGES:
                node = SESSION.node(f"{client}_{calling}")
                node.send("call", name, kind, eras.to_hex(SESSION.era_of(client).service(kind)._request_class()))
                answer = node.wait_for("response", name)[0]
                self.assertEqual("failed", answer[0])
            self.assertIn("has no answer", " ".join(answer))

    def test_a_server_that_went_is_gone(self):
        name, kind = "/goes", "std_srvs/Trigger"
        SESSION.node("robot_cpp").send("serve", name, kind, "x0100000000")
        processes.wait_until(lambda: SESSION.workstation.nodes(2, name), 15, f"{name} at the workstation side")
        SESSION.node("robot_cpp").send("unserve", name)
        processes.wait_until(lambda: not SESSION.workstation.nodes(2, name), 15, f"no {name} at the workstation side")

    def test_a_dead_server_is_an_error_and_no_wait(self):
        name, kind = "/dies", "std_srvs/Trigger"
        SESSION.node("robot_cpp_dying").send("serve", name, kind, "x0100000000")
        processes.wait_until(lambda: SESSION.workstation.nodes(2, name), 15, f"{name} at the workstation side")
        SESSION.end_node("robot_cpp_dying", kill=True)
        SESSION.node("workstation_python").send("call", name, kind, "x")
        self.assertEqual("failed", SESSION.node("workstation_python").wait_for("response", name, seconds=10)[0][0])


class Actions(unittest.TestCase):
    TYPES = ("control_msgs/FollowJointTrajectory", "moveit_msgs/Pickup")

    def test_goal_feedback_result_and_cancel(self):
        cases = []
        for kind, direction, serving, calling in itertools.product(self.TYPES, both_directions(), LANGUAGES, LANGUAGES):
            server, client = direction
            serves, calls = f"{server}_{serving}", f"{client}_{calling}"
            name = f"/actions/{serves}/{calls}/{kind.split('/')[1]}"
            cases.append((name, kind, server, SESSION.node(serves), client, SESSION.node(calls)))
        for name, kind, _, server, _, client in cases:
            server.send("action_server", name, kind)
            client.send("action_client", name, kind)
            client.send("wait_server", name, 20)
        for case in cases:
            with self.subTest(case[0]):
                self.goal_with_result(*case)
                self.goal_that_is_cancelled(*case)

    def goal_with_result(self, name, kind, server_side, server, client_side, client):
        self.assertEqual(["1"], client.wait_for("connected", name, seconds=25)[0], "the client does not see its server")
        goal = self.random(client_side, kind, "Goal", 1)
        client.send("send_goal", name, eras.to_hex(goal))
        self.check(goal, server_side, kind, "Goal", server.wait_for("goal", name)[0][0])
        self.wait_until_active(client, name, 1)
        feedback = self.random(server_side, kind, "Feedback", 2)
        server.send("feedback", name, eras.to_hex(feedback))
        self.check(feedback, client_side, kind, "Feedback", client.wait_for("feedback", name)[0][0])
        result = self.random(server_side, kind, "Result", 3)
        server.send("succeed", name, eras.to_hex(result), "done_well")
        state, got, text = client.wait_for("done", name)[0]
        self.assertEqual(("SUCCEEDED", "done_well"), (state, text))
        self.check(result, client_side, kind, "Result", got)

    def goal_that_is_cancelled(self, name, kind, server_side, server, client_side, client):
        client.send("send_goal", name, eras.to_hex(self.random(client_side, kind, "Goal", 4)))
        server.wait_for("goal", name, 2)
        self.wait_until_active(client, name, 2)
        client.send("cancel", name)
        server.wait_for("preempt", name)
        server.send("preempted", name, eras.to_hex(self.random(server_side, kind, "Result", 5)), "stopped")
        self.assertEqual(["PREEMPTED", "stopped"], client.wait_for("done", name, 2)[1][::2])

    @staticmethod
    def wait_until_active(client, name, count):
        """actionlib's Python client misses the transition when the answer is there before send_goal() has returned."""
        if client.language == "cpp":
            client.wait_for("active", name, count)

    @staticmethod
    def random(side, kind, part, seed):
        content = eras.RandomContent(seed, longest=1)
        return eras.leave_shapes_where_they_are(content.message(SESSION.era_of(side).message(kind + part)))

    def check(self, given, side, kind, part, text):
        got = eras.from_hex(SESSION.era_of(side).message(kind + part), text)
        self.assertTrue(eras.same_value(given, got), f"{given}\n{got}")

    def test_goal_ids_and_stamps_are_unchanged(self):
        name, kind = "/ids", "moveit_msgs/Pickup"
        server, client, robot, workstation = SESSION.start("robot_cpp", "workstation_cpp",
                                                           "robot_python", "workstation_python")
        server.send("action_server", name, kind)
        client.send("action_client", name, kind)
        goal = name + "/goal"
        for node in (robot, workstation):
            node.send("subscribe", goal, kind + "ActionGoal")
        client.send("wait_server", name, 20)
        self.assertEqual(["1"], client.wait_for("connected", name, seconds=25)[0])
        processes.wait_until(lambda: {"/robot_python", "/workstation_python"} <= set(
            SESSION.robot.nodes(1, goal) + SESSION.workstation.nodes(1, goal)), 5, "listeners")

        def both_heard():
            client.send("send_goal", name, eras.to_hex(self.random("workstation", kind, "Goal", 1)))
            return robot.heard("message", goal) and workstation.heard("message", goal)
        processes.wait_until(both_heard, 10, "a goal at both sides")
        ids = [{(m.goal_id.id, m.goal_id.stamp.to_nsec()) for m in (
            eras.from_hex(SESSION.era_of(side).message(kind + "ActionGoal"), text)
            for _, text in node.heard("message", goal))} for side, node in (("robot", robot), ("workstation", workstation))]
        self.assertTrue(ids[0] & ids[1], ids)

    def test_all_five_topics_have_one_caller(self):
        """What actionlib's connection monitor wants."""
        name, kind = "/five", "control_msgs/FollowJointTrajectory"
        SESSION.node("workstation_python").send("action_server", name, kind)
        for index, part in ((1, "goal"), (1, "cancel"), (0, "status"), (0, "feedback"), (0, "result")):
            processes.wait_until(lambda: NAME in SESSION.robot.nodes(index, f"{name}/{part}"), 10, part)


class Parameters(unittest.TestCase):
    VALUES = {"name": "baxter", "count": 7, "rate": 2.5, "on": True, "list": [1, "two"], "nested": {"deep": {"x": 1.5}}}

    def test_prefixes_cross(self):
        for source, target, prefix in (("robot", "workstation", "/robot_info"), ("workstation", "robot", "/tuning")):
            for name, value in self.VALUES.items():
                SESSION.master_of(source).ask("setParam", f"{prefix}/{name}", value)
            for name, value in self.VALUES.items():
                self.until_param(target, f"{prefix}/{name}", value)

    def test_a_value_does_not_come_back(self):
        """The prefix is bridged in both directions, and Indigo's master also notifies the node that made a change."""
        self.set_and_see("robot", "workstation", 1)
        self.set_and_see("workstation", "robot", 2)
        for value in range(3, 23):
            SESSION.robot.ask("setParam", "/both_ways/value", value)
        self.until_param("workstation", "/both_ways/value", 22)
        self.set_and_see("workstation", "robot", 99)
        self.until_param("workstation", "/both_ways/value", 99)
        self.set_and_see("robot", "workstation", 100)

    def set_and_see(self, source, target, value):
        SESSION.master_of(source).ask("setParam", "/both_ways/value", value)
        self.until_param(target, "/both_ways/value", value)

    def until_param(self, side, name, value):
        get = lambda: SESSION.master_of(side).ask("getParam", name, quiet=True)
        processes.wait_until(lambda: get() == value, 10, lambda: f"{name} at {side}: {get()}, not {value}")

    def test_other_parameters_stay(self):
        SESSION.robot.ask("setParam", "/private_value", 1)
        SESSION.robot.ask("setParam", "/robot_info/last", "here")
        self.until_param("workstation", "/robot_info/last", "here")
        self.assertFalse(SESSION.workstation.ask("hasParam", "/private_value"))


class Tools(unittest.TestCase):
    """ROS' own command-line programs on names that come from the other side."""

    def run_at(self, side, *command, seconds=15):
        master = SESSION.master_of(side)
        environment = master.environment()
        era = {"robot": "indigo", "workstation": "noetic"}[side]
        environment["PYTHONPATH"] = f"{processes.ERAS / era / 'python'}:{environment.get('PYTHONPATH', '')}"
        return subprocess.run(master.place.command(command), env=environment, capture_output=True, text=True,
                              timeout=seconds)

    def test_rostopic_echo(self):
        for source, target in both_directions():
            topic, kind = f"/echo/from_{source}", "control_msgs/JointControllerState"
            node = SESSION.node(f"{source}_cpp")
            node.send("advertise", topic, kind, 1)
            node.send("publish", topic, eras.to_hex(SESSION.message(source, kind, set_point=4.25)))
            processes.wait_until(lambda: NAME in SESSION.master_of(target).nodes(0, topic), 10, topic)
            done = self.run_at(target, "rostopic", "echo", "-n", "1", topic)
            self.assertIn("set_point: 4.25", done.stdout, done.stderr)
            self.assertEqual(target == "workstation", "antiwindup" in done.stdout)

    def test_rosservice_call(self):
        name, kind = "/by_hand", "gazebo_msgs/GetModelState"
        response = SESSION.era_of("robot").service(kind)._response_class(success=True, status_message="found")
        SESSION.node("robot_cpp").send("serve", name, kind, eras.to_hex(response))
        processes.wait_until(lambda: SESSION.workstation.nodes(2, name), 10, name)
        done = self.run_at("workstation", "rosservice", "call", name, "{model_name: box}")
        self.assertIn('status_message: "found"', done.stdout, done.stderr)
        self.assertIn("header:", done.stdout)

    def test_the_translator_s_own_services(self):
        robot, workstation = SESSION.start("robot_cpp", "workstation_cpp")
        kind, topic = "control_msgs/JointControllerState", "/reload"
        robot.send("advertise", topic, kind, 1)
        robot.send("publish", topic, eras.to_hex(SESSION.message("robot", kind, set_point=1.0)))
        workstation.send("subscribe", topic, kind)
        workstation.wait_for("message", topic)
        done = self.run_at("workstation", "rosservice", "call", NAME + "_home/reload_rules")
        self.assertIn("success: True", done.stdout, done.stderr)
        # Plans are made anew and roscpp's subscribers are called back: they hear the latched message again.
        workstation.wait_for("message", topic, 2)
        done = self.run_at("workstation", "rosservice", "call", NAME + "_home/status")
        for text in (topic, kind, "c0d034a7", "convert"):
            self.assertIn(text, done.stdout, done.stderr)

    def test_rosbag_record(self):
        """A recorder takes any version: it gets the one of its side, with its definition."""
        topic, kind = "/recorded", "sensor_msgs/BatteryState"
        node = SESSION.node("robot_cpp")
        node.send("advertise", topic, kind, 1)
        node.send("publish", topic, eras.to_hex(SESSION.message("robot", kind, voltage=12.5)))
        bag = SESSION.folder.path / "recorded.bag"
        processes.wait_until(lambda: NAME in SESSION.workstation.nodes(0, topic), 10, topic)
        done = self.run_at("workstation", "rosbag", "record", "-O", bag, "-l", "1", topic)
        self.assertTrue(bag.exists(), done.stdout + done.stderr)
        import rosbag
        with rosbag.Bag(str(bag)) as recorded:
            info = recorded.get_type_and_topic_info()
            self.assertEqual({kind: "4ddae7f048e32fda22cac764685e3974"}, info.msg_types)
            (_, message, _), = recorded.read_messages()
            self.assertEqual(12.5, message.voltage)
            self.assertTrue(math.isnan(message.temperature))


if __name__ == "__main__":
    unittest.main()
