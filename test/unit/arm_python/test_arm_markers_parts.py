"""What rviz is shown of goals and planned motions, and what the menu does."""

import pathlib
import threading
import time
import types
import unittest

import numpy
import rospy
from sensor_msgs.msg import JointState
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint
from visualization_msgs.msg import InteractiveMarkerControl, Marker

import extperfc.srv
from extperfc import robot_description as rd
from extperfc.arm import goals
from extperfc.arm.errors import ArmError, ClientCode
from extperfc.arm.hands import BAXTER
from extperfc.arm_markers import arm_goal, commands, ghost, goal, player
from extperfc.msg import ArmCode

URDF = pathlib.Path(__file__).resolve().parents[3] / "urdf" / "mobile_baxter.urdf"
ROBOT = rd.RobotDescription.from_file(URDF)
TIPS = {side: BAXTER[side].tip for side in BAXTER.names}
WAIT_S = 30.0


def wait_until(condition):
    deadline = time.monotonic() + WAIT_S
    while not condition():
        assert time.monotonic() < deadline, "waited in vain"
        time.sleep(0.005)


class Ghosts(unittest.TestCase):
    def test_markers_are_where_the_links_are(self):
        robot = rd.RobotDescription("""<robot name="r"><link name="a"/><link name="b">
          <collision><origin xyz="0 0 0.5"/><geometry><cylinder radius="0.1" length="1"/></geometry></collision>
          <collision><geometry><sphere radius="0.2"/></geometry></collision></link>
          <link name="c"><visual><geometry><mesh filename="/x/y.stl" scale="2 2 2"/></geometry></visual></link>
          <joint name="j" type="prismatic"><parent link="a"/><child link="b"/><axis xyz="1 0 0"/><limit lower="0" upper="9"/></joint>
          <joint name="k" type="fixed"><parent link="b"/><child link="c"/></joint></robot>""")
        cylinder, sphere, mesh = ghost.Ghost(robot, robot.links_below(["j"]), "g").markers({"j": 3.0}, (1, 0, 0, 0.5))
        self.assertEqual((Marker.CYLINDER, Marker.SPHERE, Marker.MESH_RESOURCE), (cylinder.type, sphere.type, mesh.type))
        self.assertEqual((3.0, 0.5), (cylinder.pose.position.x, cylinder.pose.position.z))
        self.assertEqual((0.2, 0.2, 1.0), (cylinder.scale.x, cylinder.scale.y, cylinder.scale.z))
        self.assertEqual((0.4, 2.0), (sphere.scale.x, mesh.scale.z))
        self.assertEqual("file:///x/y.stl", mesh.mesh_resource)
        self.assertEqual({("a", "g")}, {(m.header.frame_id, m.ns) for m in (cylinder, sphere, mesh)})

    def test_an_arm_and_its_removal(self):
        made = ghost.Ghost(ROBOT, ROBOT.links_below(["left_s0"]), "left")
        shown, gone = made.markers({}, (0, 1, 0, 0.5)), made.removals()
        self.assertEqual([m.id for m in shown], [m.id for m in gone])
        self.assertEqual(len(shown), len({m.id for m in shown}))
        self.assertTrue(all(m.action == Marker.DELETE and m.header.frame_id for m in gone))


class Views(unittest.TestCase):
    def solver(self, with_collisions, without):
        def solve(avoid_collisions):
            code = with_collisions if avoid_collisions else without
            if isinstance(code, Exception):
                raise code
            return extperfc.srv.SolveArmIkResponse(code, f"said {code}", JointState(name=["left_s0"], position=[0.5]))
        return solve

    def test_three_ways(self):
        last = {"left_s0": 9.0}
        self.assertEqual(({"left_s0": 0.5}, True, ""), goal.view_of(self.solver(0, 0), last)[:3])
        self.assertEqual(({"left_s0": 0.5}, False, "said 5"), goal.view_of(self.solver(ArmCode.GOAL_IN_COLLISION, 0), last)[:3])
        far = self.solver(ArmCode.GOAL_UNREACHABLE, ArmCode.GOAL_UNREACHABLE)
        self.assertEqual((last, False, "said 8"), goal.view_of(far, last)[:3])

    def test_no_node(self):
        error = ArmError(ClientCode.NOT_RUNNING, "no service")
        self.assertEqual(({}, False, "no service"), goal.view_of(self.solver(error, error), {})[:3])


class NewestOnly(unittest.TestCase):
    def test_what_came_meanwhile_is_left_out(self):
        done, go = [], threading.Event()

        def work(item):
            done.append(item)
            go.wait(WAIT_S)
        newest = goal.Newest(work, 1000.0)
        newest.put(1)
        wait_until(lambda: done == [1])
        for item in (2, 3, 4):
            newest.put(item)
        go.set()
        wait_until(lambda: len(done) == 2)
        newest.end()
        self.assertEqual([1, 4], done)

    def test_rate(self):
        stamps, newest = [], None
        newest = goal.Newest(lambda _: stamps.append(time.monotonic()), 20.0)
        end = time.monotonic() + 0.4
        while time.monotonic() < end:
            newest.put(0)
            time.sleep(0.001)
        newest.end()
        self.assertGreaterEqual(len(stamps), 2)
        self.assertTrue(all(b - a >= 0.049 for a, b in zip(stamps, stamps[1:])), stamps)


class GoalMarkers(unittest.TestCase):
    def test_six_degrees_of_freedom(self):
        made = goal.goal_marker("left", goals.pose_stamped((1, 2, 3), "base"))
        self.assertEqual(("left", "base", 3), (made.name, made.header.frame_id, made.pose.position.z))
        axes = {InteractiveMarkerControl.MOVE_AXIS: [], InteractiveMarkerControl.ROTATE_AXIS: []}
        for control in made.controls:
            if control.interaction_mode in axes:
                q = control.orientation
                axes[control.interaction_mode].append(rd.rotation_of_quaternion(q.x, q.y, q.z, q.w)[:, 0])
        for directions in axes.values():
            self.assertAlmostEqual(1.0, abs(numpy.linalg.det(numpy.array(directions))))
        self.assertEqual(7, len({control.name for control in made.controls}))

    def test_long_text_is_broken_between_words(self):
        text = "no joint values bring the tool there: it is 0.21 m out of reach"
        lines = arm_goal.wrapped(text, 20).split("\n")
        self.assertTrue(all(len(line) <= 20 for line in lines))
        self.assertEqual(text, " ".join(lines))
        self.assertEqual("", arm_goal.wrapped(""))


class ArmGoals(unittest.TestCase):
    """A goal of the left arm whose questions are answered here."""

    def setUp(self):
        self.published, self.asked, self.code, self.go = [], [], 0, threading.Event()
        self.go.set()
        self.goal = arm_goal.ArmGoal("left", BAXTER, ROBOT, "base", lambda array: self.published.extend(array.markers),
                                     lambda: {"left_s0": 0.1, "right_s0": 0.2}, 1000.0, self.answer)
        self.addCleanup(self.goal.end)

    def answer(self, **fields):
        self.asked.append(fields)
        self.go.wait(WAIT_S)
        return extperfc.srv.SolveArmIkResponse(self.code, "too far" if self.code else "",
                                               JointState(name=["left_s0"], position=[0.7]))

    def texts(self):
        return [m.text for m in self.published if m.type == Marker.TEXT_VIEW_FACING and m.action == Marker.ADD]

    def test_asks_of_the_dragged_pose_near_the_last_solution(self):
        pose = goals.pose_stamped((0.7, 0.3, 0.1), "base")
        for times in (1, 2):
            self.goal.drag(pose)
            wait_until(lambda: len(self.asked) == times)
            wait_until(lambda: len([m for m in self.published if m.ns == "left_goal" and m.id == 0]) == times)
        self.assertEqual(("left_arm", pose), (self.asked[0]["group"], self.asked[0]["goal"].pose))
        self.assertEqual([[0.1], [0.7]], [fields["seed"].position for fields in self.asked])

    def test_an_answer_that_comes_after_settling_is_not_shown(self):
        self.go.clear()
        self.goal.drag(goals.pose_stamped((0.7, 0.3, 0.1), "base"))
        wait_until(lambda: self.asked)
        self.goal.settle()
        self.go.set()
        self.goal.end()
        self.assertFalse([m for m in self.published if m.ns == "left_goal" and m.action == Marker.ADD])

    def test_settled_goals_show_nothing(self):
        self.code = ArmCode.GOAL_UNREACHABLE
        self.goal.drag(goals.pose_stamped((3, 0, 0), "base"))
        wait_until(lambda: "too far" in self.texts())
        settled = self.goal.settle()
        numpy.testing.assert_allclose(goals.matrix_of_pose(settled), ROBOT.link_poses({"left_s0": 0.1}, "base")["left_gripper"],
                                      atol=1e-9)
        self.assertEqual({Marker.DELETE}, {m.action for m in self.published[-3:]})
        self.goal.say("there")
        self.assertEqual("there", self.texts()[-1])


def trajectory(names, *points):
    return JointTrajectory(joint_names=list(names), points=[
        JointTrajectoryPoint(positions=list(positions), time_from_start=rospy.Duration(time_s)) for time_s, positions in points])


class Players(unittest.TestCase):
    def test_between_points(self):
        motion = player.Motion(trajectory(["left_s0", "left_s1"], (0, (0, 0)), (2, (1, 0)), (3, (1, -1))))
        self.assertEqual(3.0, motion.duration_s)
        for time_s, expected in ((-1, (0, 0)), (0, (0, 0)), (0.5, (0.25, 0)), (2, (1, 0)), (2.5, (1, -0.5)), (9, (1, -1))):
            found = motion.at(time_s)
            numpy.testing.assert_allclose([found["left_s0"], found["left_s1"]], expected, err_msg=str(time_s))

    def test_what_is_no_motion_is_refused(self):
        for wrong in (trajectory(["a"]), trajectory(["a"], (0, (0, 0))), trajectory(["a"], (1, (0,)), (0, (1,)))):
            with self.assertRaises(ValueError):
                player.Motion(wrong)

    def test_line_of_the_tool(self):
        """Turning s0 alone moves the tool on a circle about the shoulder's axis."""
        motion = player.Motion(trajectory(["left_s0"], (0, (0,)), (1, (1,))))
        lines = player.tool_lines(ROBOT, TIPS, motion, {}, 11)
        self.assertEqual(["left"], list(lines))
        axis = ROBOT.link_poses({})["left_upper_shoulder"][:3, 3]
        radii = numpy.linalg.norm((lines["left"] - axis)[:, :2], axis=1)
        numpy.testing.assert_allclose(radii, radii[0], atol=1e-9)
        self.assertEqual(11, len(lines["left"]))
        self.assertGreater(numpy.linalg.norm(lines["left"][-1] - lines["left"][0]), 0.5)

    def test_plays_again_and_again_until_cleared(self):
        published, lock = [], threading.Lock()

        def publish(array):
            with lock:
                published.append(array.markers)
        shown = player.PathPlayer(ROBOT, TIPS, publish, lambda: True, dict, pause_s=0.0)
        self.addCleanup(shown.end)
        shown.show(trajectory(["left_s0", "right_s0"], (0, (0, 0)), (0.15, (1, 1))))
        wait_until(lambda: len(published) > 4)
        shown.clear()
        wait_until(lambda: published[-1][0].action == Marker.DELETE)
        first, last = published[0], published[-1]
        self.assertEqual({(m.ns, m.id) for m in first}, {(m.ns, m.id) for m in last})
        self.assertEqual({Marker.DELETE}, {m.action for m in last})
        self.assertEqual(2, len([m for m in first if m.type == Marker.LINE_STRIP]))
        with self.assertRaisesRegex(ValueError, "does not have"):
            shown.show(trajectory(["knee"], (0, (0,))))

    def test_ends_when_the_robot_is_there(self):
        published, now = [], {"left_s0": 0.0}
        shown = player.PathPlayer(ROBOT, TIPS, lambda array: published.append(array.markers), lambda: True, lambda: dict(now))
        self.addCleanup(shown.end)
        shown.show(trajectory(["left_s0"], (0, (0,)), (0.1, (1,))))
        wait_until(lambda: len(published) > 2)
        self.assertEqual(Marker.ADD, published[-1][0].action)
        now["left_s0"] = 0.99
        wait_until(lambda: published[-1][0].action == Marker.DELETE)

    def test_nothing_is_sent_while_nobody_looks(self):
        published, asked = [], []
        shown = player.PathPlayer(ROBOT, TIPS, published.append, lambda: asked.append(1) and False, dict)
        shown.show(trajectory(["left_s0"], (0, (0,)), (1, (1,))))
        wait_until(lambda: len(asked) >= 2)
        shown.end()
        self.assertTrue(all(m.action == Marker.DELETE for array in published for m in array.markers))


class FakeArm:
    def __init__(self, error=None):
        self.calls, self.error, self.go = [], error, threading.Event()
        self.go.set()

    def answer(self, *call):
        self.calls.append(call)
        self.go.wait(WAIT_S)
        if self.error:
            raise self.error
        return types.SimpleNamespace(duration_s=2.0, planning_time_s=0.01, message="")

    def plan(self, goal, linear):
        return self.answer("plan", goal, linear)

    def move_to(self, goal, linear=False):
        return self.answer("move_to", goal, linear)

    def execute(self, plan):
        return self.answer("execute", plan)

    def stop(self):
        self.calls.append(("stop",))


class Menus(unittest.TestCase):
    def setUp(self):
        self.said, self.moved = {"left": [], "right": []}, []
        shown = {side: types.SimpleNamespace(pose=f"pose of {side}", say=lambda text, good=True, side=side:
                                             self.said[side].append((text, good))) for side in self.said}
        self.arms = {which: FakeArm() for which in (*BAXTER.names, "both")}
        self.commands = commands.Commands(self.arms, shown, self.moved.append)

    def last(self, side):
        return self.said[side][-1] if self.said[side] else ("", True)

    def idle(self):
        wait_until(lambda: not self.commands._busy.locked())

    def test_plan_then_execute_once(self):
        self.commands.set_linear(True)
        self.commands.plan("left")
        wait_until(lambda: "2.0 s" in self.last("left")[0])
        self.idle()
        self.assertEqual([("plan", "pose of left", True)], self.arms["left"].calls)
        self.commands.execute("left")
        wait_until(lambda: self.last("left") == ("there", True))
        self.assertEqual(["left"], self.moved)
        self.idle()
        self.commands.execute("left")
        wait_until(lambda: self.last("left")[0] == "no plan yet")
        self.assertEqual(2, len(self.arms["left"].calls))

    def test_both(self):
        self.commands.plan_and_execute("both")
        wait_until(lambda: self.last("left")[0] == self.last("right")[0] == "there")
        self.assertEqual([("move_to", {"left": "pose of left", "right": "pose of right"}, False)], self.arms["both"].calls)

    def test_failure_is_shown_in_red_and_nothing_is_planned(self):
        self.arms["right"].error = ArmError(ArmCode.PLANNING_TIMEOUT, "no path")
        self.commands.plan("right")
        wait_until(lambda: self.last("right") == ("PLANNING_TIMEOUT: no path", False))
        self.assertFalse(self.moved)
        self.idle()
        self.commands.execute("right")
        wait_until(lambda: self.last("right")[0] == "no plan yet")

    def test_one_at_a_time_but_stop_always(self):
        self.arms["left"].go.clear()
        self.commands.go_to("left", "neutral")
        wait_until(lambda: self.arms["left"].calls)
        self.commands.plan("right")
        self.assertEqual(("busy: stop it, or wait", False), self.last("right"))
        self.commands.stop("right")
        wait_until(lambda: self.arms["both"].calls == [("stop",)])
        self.arms["left"].go.set()
        wait_until(lambda: self.last("left") == ("there", True))
        self.assertEqual([("move_to", "neutral", False)], self.arms["left"].calls)
        self.assertFalse(self.arms["right"].calls)


if __name__ == "__main__":
    unittest.main()
