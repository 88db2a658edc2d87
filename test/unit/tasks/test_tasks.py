"""Leaves and recipes of behaviour trees, with a robot that is made up."""

import math
import pathlib
import re
import sys
import threading
import types
import unittest
from unittest import mock

REPO = pathlib.Path(__file__).resolve().parents[3]
sys.path.insert(0, str(REPO / "src"))

try:
    import py_trees
except ModuleNotFoundError:
    raise unittest.SkipTest("py_trees is not installed: tools/setup fetches it") from None

import geometry_msgs.msg  # noqa: E402
import numpy  # noqa: E402
import rospy  # noqa: E402
import sensor_msgs.msg  # noqa: E402
import std_msgs.msg  # noqa: E402
import vision_msgs.msg  # noqa: E402

from extperfc import tasks  # noqa: E402
from extperfc.arm import ArmError  # noqa: E402
from extperfc.arm.goals import pose_stamped  # noqa: E402
from extperfc.msg import ArmCode, PickResult  # noqa: E402
from extperfc.tasks import arm_leaves, around, base_leaves, find, search  # noqa: E402
from extperfc.tasks.arm_leaves import between_fingers  # noqa: E402
from extperfc.tasks.solids import Solids  # noqa: E402

RUNNING, SUCCESS, FAILURE, INVALID = (py_trees.common.Status.RUNNING, py_trees.common.Status.SUCCESS,
                                      py_trees.common.Status.FAILURE, py_trees.common.Status.INVALID)


class Clock:
    """ROS time that a test moves on."""

    def __init__(self, test):
        self.seconds = 100.0
        patched = mock.patch.object(rospy.Time, "now", lambda: rospy.Time.from_sec(self.seconds))
        patched.start()
        test.addCleanup(patched.stop)


class MadeUpMotion:
    def __init__(self, result=None, error=None, ticks=1):
        self._result, self._error, self._ticks = result, error, ticks
        self.cancelled, self.feedback = False, types.SimpleNamespace(stage="approaching")

    @property
    def done(self):
        self._ticks -= 1
        return self._ticks < 0

    def result(self):
        if self._error:
            raise self._error
        return self._result

    def cancel(self):
        self.cancelled = True


class MotionLeaf(tasks.ActionLeaf):
    def __init__(self, motion):
        super().__init__("motion")
        self.made_up = motion

    def motion(self):
        if isinstance(self.made_up, Exception):
            raise self.made_up
        return self.made_up


def tick(leaf):
    leaf.tick_once()
    return leaf.status


class Leaves(unittest.TestCase):
    def test_an_action_runs_and_succeeds(self):
        leaf = MotionLeaf(MadeUpMotion(types.SimpleNamespace(message="there"), ticks=1))
        self.assertEqual((RUNNING, "approaching"), (tick(leaf), leaf.feedback_message))
        self.assertEqual((SUCCESS, "there"), (tick(leaf), leaf.feedback_message))

    def test_its_failure_is_a_message(self):
        leaf = MotionLeaf(MadeUpMotion(error=ArmError(ArmCode.NO_GRASP, "none can be reached"), ticks=0))
        self.assertEqual(FAILURE, tick(leaf))
        self.assertIn("none can be reached", leaf.feedback_message)

    def test_a_goal_that_cannot_be_sent_fails(self):
        for error in (ArmError(ArmCode.INTERNAL, "no server"), ValueError("no server"), KeyError("no server")):
            leaf = MotionLeaf(error)
            self.assertEqual(FAILURE, tick(leaf))
            self.assertIn("no server", leaf.feedback_message)

    def test_a_tree_that_leaves_it_cancels_it(self):
        motion = MadeUpMotion(ticks=5)
        leaf = MotionLeaf(motion)
        tick(leaf)
        leaf.stop(INVALID)
        self.assertTrue(motion.cancelled)

    def test_what_has_ended_is_not_cancelled(self):
        motion = MadeUpMotion(types.SimpleNamespace(message=""), ticks=0)
        leaf = MotionLeaf(motion)
        tick(leaf)
        leaf.stop(INVALID)
        self.assertFalse(motion.cancelled)

    def test_waits_by_ros_time(self):
        clock, leaf = Clock(self), tasks.Wait(2.0)
        self.assertEqual(RUNNING, tick(leaf))
        clock.seconds += 1.9
        self.assertEqual(RUNNING, tick(leaf))
        clock.seconds += 0.2
        self.assertEqual(SUCCESS, tick(leaf))
        with self.assertRaises(ValueError):
            tasks.Wait(-1.0)

    def test_says_what_stands_on_the_blackboard(self):
        tasks.write("what", types.SimpleNamespace(distance_m=0.5))
        with mock.patch.object(tasks.Say, "_publisher", mock.Mock()) as publisher, mock.patch.object(rospy, "loginfo"):
            self.assertEqual(SUCCESS, tick(tasks.Say("{d:.2f} m", d=tasks.Key("what", "distance_m"))))
            publisher.publish.assert_called_once_with("0.50 m")
            self.assertEqual(FAILURE, tick(tasks.Say("{d}", d=tasks.Key("never written"))))

    def test_a_goal_of_the_base_is_a_pose_of_the_map(self):
        pose = base_leaves.planar_pose((1.0, 2.0, math.pi / 2), "map")
        self.assertEqual(("map", 1.0, 2.0), (pose.header.frame_id, pose.pose.position.x, pose.pose.position.y))
        self.assertAlmostEqual(math.sqrt(0.5), pose.pose.orientation.z)


class MadeUpFrames:
    """The camera is 1 m above the origin of every other frame and looks down."""

    def matrix(self, target, source, _wait_s, stamp=None):
        del stamp
        if source == "nowhere":
            raise ArmError(ArmCode.UNKNOWN_FRAME, "no transform")
        frame_T_camera = numpy.array([[1.0, 0, 0, 0], [0, -1, 0, 0], [0, 0, -1, 1], [0, 0, 0, 1]])
        if target == source:
            return numpy.eye(4)
        return frame_T_camera if source == find.DEPTH_FRAME else numpy.linalg.inv(frame_T_camera)


class Finding(unittest.TestCase):
    def setUp(self):
        self.clock = Clock(self)
        with mock.patch.object(rospy, "Subscriber"):
            self.source = find._Detections()
        self.source._names = {0: "cube", 1: "sphere"}
        for patched in (mock.patch.object(tasks.Find, "_detections", self.source),
                        mock.patch.object(find.robot_state, "frames", MadeUpFrames)):
            patched.start()
            self.addCleanup(patched.stop)

    def see(self, *objects, frame=find.DEPTH_FRAME, score=0.9):
        """A message of (class, x, y, z) in the frame."""
        self.clock.seconds += 0.1
        message = vision_msgs.msg.Detection3DArray(header=std_msgs.msg.Header(frame_id=frame, stamp=rospy.Time.now()))
        for index, x, y, z in objects:
            one = vision_msgs.msg.Detection3D(results=[vision_msgs.msg.ObjectHypothesisWithPose(id=index, score=score)])
            one.bbox.center.position = geometry_msgs.msg.Point(x, y, z)
            one.bbox.center.orientation.w = 1.0
            one.bbox.size = geometry_msgs.msg.Vector3(0.04, 0.05, 0.06)
            message.detections.append(one)
        self.source._on_detections(message)

    def test_median_of_detections_of_one_object(self):
        leaf = tasks.Find("cube", "it", confirm=3, frame="odom")
        self.see((0, 0.9, 0.9, 0.4))  # before the leaf began: does not count
        self.assertEqual(RUNNING, tick(leaf))
        for x in (0.10, 0.11, 0.14):
            self.see((0, x, 0.0, 0.4), (1, 0.12, 0.0, 0.4), (0, -0.5, 0.0, 0.4 + x))
        self.assertEqual(SUCCESS, tick(leaf))
        found = tasks.read(tasks.Key("it"))
        self.assertEqual(("cube", 3, "odom"), (found.label, found.detections, found.pose.header.frame_id))
        self.assertAlmostEqual(0.11, found.pose.pose.position.x)
        self.assertAlmostEqual(0.6, found.pose.pose.position.z)
        self.assertAlmostEqual(math.hypot(0.11, 0.4), found.distance_m)
        self.assertEqual((0.04, 0.05, 0.06), found.size)

    def test_only_near_a_place(self):
        leaf = tasks.Find("cube", "it", confirm=1, frame="odom", near=(0.5, 0.0, 0.6), near_m=0.1)
        tick(leaf)
        self.see((0, 0.0, 0.0, 0.4))
        self.assertEqual(RUNNING, tick(leaf))
        self.see((0, 0.45, 0.0, 0.4))
        self.assertEqual(SUCCESS, tick(leaf))

    def test_near_what_was_found_and_not_near_what_does_not_count(self):
        tasks.write("first", found_at(0.5, 0.0, 0.6))
        leaf = tasks.Find("cube", "it", confirm=1, frame="odom", near=tasks.Key("first"), near_m=0.1)
        tick(leaf)
        self.see((0, 0.3, 0.0, 0.4))
        self.assertEqual(RUNNING, tick(leaf))
        self.see((0, 0.45, 0.0, 0.4))
        self.assertEqual(SUCCESS, tick(leaf))
        leaf = tasks.Find("cube", "it", confirm=1, frame="odom", near_m=0.1)
        leaf.ignored.append((0.5, 0.0, 0.6))
        tick(leaf)
        self.see((0, 0.45, 0.0, 0.4))
        self.assertEqual(RUNNING, tick(leaf))
        self.see((0, 0.3, 0.0, 0.4))
        self.assertEqual(SUCCESS, tick(leaf))

    def test_only_what_is_small_and_sure_enough(self):
        for options in ({"max_size_m": 0.05}, {"min_score": 0.95}):
            leaf = tasks.Find("cube", "it", confirm=1, timeout_s=math.inf, **options)
            tick(leaf)
            self.see((0, 0.0, 0.0, 0.4))
            self.assertEqual(RUNNING, tick(leaf), options)
        self.see((0, 0.0, 0.0, 0.4), score=0.96)
        self.assertEqual(SUCCESS, tick(leaf))

    def test_detections_without_a_transform_do_not_count_and_time_ends(self):
        leaf = tasks.Find("cube", "it", confirm=1, timeout_s=3.0)
        tick(leaf)
        self.see((0, 0.0, 0.0, 0.4), frame="nowhere")
        self.assertEqual(RUNNING, tick(leaf))
        self.clock.seconds += 3.0
        self.assertEqual(FAILURE, tick(leaf))
        self.assertIn("no cube was seen 1 times within 3 s", leaf.feedback_message)


class Fingers(unittest.TestCase):
    def test_they_close_across_the_view_and_the_tool_comes_from_the_side(self):
        random = numpy.random.default_rng(1)
        kept = 0
        for number in range(400):
            rotation = numpy.linalg.qr(random.normal(size=(3, 3)))[0]
            rotation *= numpy.sign(numpy.linalg.det(rotation))
            view = random.normal(size=3) if number % 4 else rotation[:, 2] + 0.02 * random.normal(size=3)
            view /= numpy.linalg.norm(view)
            changed = between_fingers(rotation, view)
            numpy.testing.assert_allclose(changed.T @ changed, numpy.eye(3), atol=1e-9)
            self.assertAlmostEqual(1.0, numpy.linalg.det(changed))
            self.assertAlmostEqual(0.0, changed[:, 1] @ view)
            self.assertGreaterEqual(changed[:, 1] @ rotation[:, 1], -1e-9, "the smaller rotation")
            off = math.acos(rotation[:, 2] @ view)
            self.assertGreater(math.acos(changed[:, 2] @ view), min(off, arm_leaves.SIDEWAYS_RAD) - 0.02)
            if off > arm_leaves.SIDEWAYS_RAD and math.sin(off) > 0.1:
                kept += 1
                numpy.testing.assert_allclose(changed[:, 2], rotation[:, 2], atol=1e-9)
        self.assertGreater(kept, 100)

    def test_a_tool_from_above_leans_away_from_a_camera_that_looks_down(self):
        down = numpy.array([[1.0, 0, 0], [0, -1, 0], [0, 0, -1]])
        view = numpy.array([0.64, 0.0, -0.77]) / math.hypot(0.64, 0.77)
        approach = between_fingers(down, view)[:, 2]
        self.assertLess(approach[0], -0.3, "its hand is beyond the object, seen from the camera")
        self.assertLess(approach[2], -0.7, "still from above")


class MadeUpArm:
    """Picks and places succeed unless a test says otherwise; what was asked for is kept."""

    def __init__(self):
        self.asked, self.failures, self.side, self.sides = [], {}, "left", ["left", "right"]
        self.stood = geometry_msgs.msg.PoseStamped()
        self.stood.pose.position.x = 0.7
        objects = {"cube_1": types.SimpleNamespace(label="cube", pose=self.stood, link="")}
        self.scene = types.SimpleNamespace(objects=objects, remove=objects.pop)
        self.between_fingers, self.slips_at = False, None  # slips_at: what the arms do when the object slips out of the gripper

    def _act(self, name, what, result):
        self.asked.append((name, what))
        if name == self.slips_at:
            self.between_fingers = False
        errors = self.failures.get(name, [])
        error = errors.pop(0) if errors else None
        return MadeUpMotion(result, ArmError(ArmCode.NO_GRASP, error) if error else None, ticks=1)

    def move_to(self, goal, **_):
        return self._act("move", goal, types.SimpleNamespace(message=""))

    def pick(self, what, **_):
        self.scene.objects["cube_1"].link, self.between_fingers = "left_gripper", True
        return self._act("pick", what, PickResult(object="cube_1", arm="left"))

    def place(self, pose, **_):
        return self._act("place", pose_stamped(pose).pose.position.x, types.SimpleNamespace(message=""))

    def close(self, **_):
        return self.between_fingers


class Recipes(unittest.TestCase):
    def setUp(self):
        self.arm, self.clock = MadeUpArm(), Clock(self)
        found = mock.patch.object(tasks.Find, "update", lambda leaf: SUCCESS)
        for patched in (mock.patch.object(arm_leaves, "_arm", lambda side: self.arm), found,
                        mock.patch.object(find, "_Detections", mock.Mock()), mock.patch.object(rospy, "loginfo"),
                        mock.patch.object(rospy, "Publisher", mock.Mock())):
            patched.start()
            self.addCleanup(patched.stop)
        tasks.Say._publisher = None

    def run_tree(self, root):
        return tasks.run(root, period_s=0.0, alive=lambda: True)

    def test_a_pick_that_fails_once_is_tried_again(self):
        self.arm.failures["pick"] = ["slipped"]
        self.assertEqual((True, ""), self.run_tree(tasks.pick_up("cube")))
        self.assertEqual(["move", "pick", "move", "pick"], [name for name, _ in self.arm.asked])
        self.assertIs(self.arm.stood, tasks.read(tasks.Key("held_from")))

    def test_a_pick_that_fails_twice_fails_with_its_reason(self):
        self.arm.failures["pick"] = ["slipped", "slipped again"]
        done, why = self.run_tree(tasks.pick_up("cube"))
        self.assertFalse(done)
        self.assertIn("slipped again", why)

    def test_beside_a_wall_one_arm_makes_room(self):
        self.arm.failures["move"] = ["the right elbow touches a wall", None, "the right elbow touches a wall"]
        self.assertEqual((True, ""), self.run_tree(tasks.pick_up("cube")))
        self.assertEqual(["move", "move", "move", "pick"], [name for name, _ in self.arm.asked], "both, left, right")

    def test_between_walls_the_arms_stay_and_it_is_picked_all_the_same(self):
        self.arm.failures["move"] = 3 * ["both elbows touch a wall"]
        self.assertEqual((True, ""), self.run_tree(tasks.pick_up("cube")))
        self.assertEqual([*3 * ["move"], "pick"], [name for name, _ in self.arm.asked], "both, left, right")

    def test_what_is_carried_comes_near_to_the_body_as_far_as_there_is_room(self):
        for failures in range(4):
            with self.subTest(failures):
                self.arm.failures["move"], self.arm.asked[:] = failures * ["it touches a wall"], []
                tasks.write("held", types.SimpleNamespace(arm="left"))
                self.assertEqual((True, ""), self.run_tree(tasks.carry()))
                self.assertEqual(min(failures + 1, 3), len(self.arm.asked))

    def test_what_cannot_be_put_down_is_put_back(self):
        self.arm.failures["place"] = ["none can be reached"]
        self.assertTrue(self.run_tree(tasks.pick_up("cube"))[0])
        done, why = self.run_tree(tasks.put_down((0.5, 0.0, 0.1)))
        self.assertEqual([("place", 0.5), ("place", 0.7)], self.arm.asked[-2:])
        self.assertFalse(done, "it is not where it was wanted")
        self.assertIn("none can be reached", why)

    def test_what_can_be_put_down_is_not_put_back(self):
        self.assertTrue(self.run_tree(tasks.pick_up("cube"))[0])
        self.assertTrue(self.run_tree(tasks.put_down((0.5, 0.0, 0.1)))[0])
        self.assertEqual(("place", 0.5), self.arm.asked[-1])

    def test_what_cannot_be_placed_from_here_is_placed_from_elsewhere(self):
        self.assertTrue(self.run_tree(tasks.pick_up("cube"))[0])
        self.arm.failures["place"] = ["none can be reached"]
        for leaf in (tasks.Approach, tasks.SeeAround, tasks.SeeSupport):
            patched = mock.patch.multiple(leaf, setup=lambda leaf, **_: None, update=lambda leaf: SUCCESS)
            patched.start()
            self.addCleanup(patched.stop)
        self.assertEqual((True, ""), self.run_tree(tasks.bring((2.0, 0.5, 0.7))))
        self.assertEqual(["move", "place", "move", "place"], [name for name, _ in self.arm.asked[2:]])

    def test_what_was_lost_is_not_brought(self):
        self.assertTrue(self.run_tree(tasks.pick_up("cube"))[0])
        self.arm.scene.objects.clear()
        done, why = self.run_tree(tasks.bring((2.0, 0.5, 0.7)))
        self.assertFalse(done)
        self.assertIn("no gripper holds cube_1 any more", why)
        self.assertEqual(["move", "pick"], [name for name, _ in self.arm.asked], "the arms stay, and the base")

    def test_what_slips_out_before_the_drive_is_noticed_there_and_leaves_the_scene(self):
        self.assertTrue(self.run_tree(tasks.pick_up("cube"))[0])
        self.arm.slips_at = "move"
        done, why = self.run_tree(tasks.bring((2.0, 0.5, 0.7), attempts=1))
        self.assertFalse(done)
        self.assertIn("cube_1 slipped out of the left gripper", why)
        self.assertEqual(["move", "pick", "move"], [name for name, _ in self.arm.asked], "the base stays")
        self.assertEqual({}, self.arm.scene.objects)


def found_at(x, y, z):
    pose = geometry_msgs.msg.PoseStamped()
    pose.pose.position = geometry_msgs.msg.Point(x, y, z)
    return find.Found("cube", pose, (0.05, 0.05, 0.05), 1.0, 5)


class Driving(unittest.TestCase):
    """Search and Approach, with a base that is where it was sent and an object that is seen when it was sent somewhere so many
    times."""

    def setUp(self):
        self.clock, self.sent, self.failing, self.seen_at, self.real = Clock(self), [], set(), (), True
        self.blind_at = ()  # in the count of poses that it was sent to: from there it is not seen from near
        self.images = 1  # with each tick
        cells = numpy.zeros((80, 80), numpy.int8)
        cells[[0, -1], :] = cells[:, [0, -1]] = 100
        no_tops = types.SimpleNamespace(squares=frozenset)
        for patched in (mock.patch.object(search, "newest_map", lambda: search.Grid(cells, 0.05, (-2.0, -2.0))),
                        mock.patch.object(search, "base_pose", lambda frame: self.sent[-1] if self.sent else (0.0, 0.0, 0.0)),
                        mock.patch.object(search.Lidar, "of", lambda frame: no_tops),
                        mock.patch.object(tasks.GoTo, "motion", lambda leaf: self.drive(leaf.pose)),
                        mock.patch.object(rospy, "logwarn"), mock.patch.object(rospy, "loginfo"),
                        mock.patch.object(tasks.Find, "setup", lambda leaf, **_: None),
                        mock.patch.object(tasks.Find, "begin", lambda leaf: setattr(leaf, "images", 0)),
                        mock.patch.object(tasks.Find, "step", lambda leaf: self.find(leaf))):
            patched.start()
            self.addCleanup(patched.stop)

    def drive(self, pose):
        """In place of GoTo.motion."""
        self.sent.append(pose)
        error = ArmError(ArmCode.INTERNAL, "no_path") if len(self.sent) in self.failing else None
        return MadeUpMotion(types.SimpleNamespace(message=""), error, ticks=1)

    def find(self, leaf):
        """In place of Find.step: from afar, and from near."""
        leaf.images += self.images
        if leaf.near is not None:
            if not self.real or len(self.sent) in self.blind_at:
                raise ValueError("it is a book")
            return True
        seen = len(self.sent) in self.seen_at and not any(math.dist(place, self.object_at()) < 0.01 for place in leaf.ignored)
        if seen:
            tasks.write("it", found_at(*self.object_at()))
        return seen or None

    def object_at(self):
        return 0.1 * len(self.sent), 0.0, 0.7

    def run_leaf(self, leaf, seconds=600):
        for _ in range(10 * seconds):
            if tick(leaf) != RUNNING:
                return
            self.clock.seconds += 0.1
        self.fail("it does not end")

    def search(self, free=lambda x, y: True, **arguments):
        with self.plans(free):
            leaf = tasks.Search("cube", "it", **arguments)
        self.run_leaf(leaf)
        return leaf

    def test_it_looks_until_the_object_is_seen(self):
        self.seen_at = (3,)
        leaf = self.search(from_near=False)
        self.assertEqual((SUCCESS, 3), (leaf.status, len(self.sent)))

    def test_what_was_seen_is_looked_at_from_near(self):
        self.seen_at = (3,)
        leaf = self.search()
        self.assertEqual((SUCCESS, 4), (leaf.status, len(self.sent)))
        self.assertAlmostEqual(0.72, math.dist(self.sent[-1][:2], (0.3, 0.0)))

    def test_what_is_not_seen_from_one_near_place_is_looked_at_from_another(self):
        self.seen_at, self.blind_at = (3,), (4,)
        leaf = self.search()
        self.assertEqual((SUCCESS, 5), (leaf.status, len(self.sent)))
        self.assertAlmostEqual(0.72, math.dist(self.sent[-1][:2], (0.3, 0.0)))
        self.assertGreater(math.dist(self.sent[-1][:2], self.sent[-2][:2]), search.AGAIN_M)

    def test_what_is_none_from_near_does_not_count_and_the_search_goes_on(self):
        self.seen_at, self.real = (3,), False
        leaf = self.search()
        self.assertEqual(FAILURE, leaf.status)
        self.assertGreater(len(self.sent), 5)
        self.assertIn("what it saw at 1 places was none from near", leaf.feedback_message)

    def test_what_cannot_be_approached_does_not_count(self):
        self.seen_at = (2,)
        leaf = self.search(free=lambda x, y: math.dist((x, y), (0.2, 0.0)) > 0.86)
        self.assertEqual(FAILURE, leaf.status)
        self.assertIn("what it saw at 1 places", leaf.feedback_message)

    def test_all_views_without_it_are_a_failure_that_counts(self):
        self.failing = {2}
        leaf = self.search(free=lambda x, y: x > -1.0)
        self.assertEqual(FAILURE, leaf.status)
        number, failed = (int(digits) for digits in re.findall(r"\d+", leaf.feedback_message))
        self.assertGreater(failed, 1)
        self.assertEqual(len(self.sent), number - failed + 1, "the one that was sent and did not arrive")

    def test_a_limit_to_its_views(self):
        leaf = self.search(max_views=3)
        self.assertEqual((FAILURE, 3), (leaf.status, len(self.sent)))

    def test_a_slow_detector_gets_more_time_and_a_silent_one_is_not_waited_for(self):
        times = []
        for self.images in (1, 0.25, 0):
            self.sent, begin = [], self.clock.seconds
            self.search(max_views=3)
            times.append((self.clock.seconds - begin) / 3)
        self.assertTrue(1.0 < times[0] < 1.5 and 3.0 < times[1] < 4.0 and 10.0 < times[2] < 11.0, times)

    def test_what_moves_is_cancelled_with_it(self):
        for seen_at, sent in (((), 1), ((0,), 1)):
            self.sent, self.seen_at = [], seen_at
            with self.plans(lambda x, y: True):
                leaf = tasks.Search("cube", "it")
            motion = MadeUpMotion(ticks=1000)
            with mock.patch.object(tasks.GoTo, "motion", lambda leaf, motion=motion: self.sent.append(leaf.pose) or motion):
                for _ in range(3):
                    tick(leaf)
                leaf.stop(INVALID)
            self.assertEqual((sent, True), (len(self.sent), motion.cancelled), seen_at)

    def plans(self, free):
        """In place of the service make_plan: straight plans to goals for which free(x, y) is true."""
        def plan(start, goal, tolerance):
            del tolerance
            at = goal.pose.position
            found = types.SimpleNamespace(poses=[start, goal] if free(at.x, at.y) else [])
            return types.SimpleNamespace(plan=found)
        return mock.patch.object(search, "Service", lambda *_: plan)

    def test_the_nearest_place_before_a_point_that_can_be_reached(self):
        with self.plans(lambda x, y: x < 1.5):
            leaf = tasks.Approach((2.0, 0.0, 0.7))
            self.run_leaf(leaf)
        self.assertEqual((SUCCESS, 1), (leaf.status, len(self.sent)))
        x, y, yaw = leaf._tried[0]
        self.assertLess(x, 1.5)
        self.assertAlmostEqual(0.0, math.remainder(math.atan2(-y, 2.0 - x) - yaw, 2 * math.pi), places=9)
        self.assertAlmostEqual(0.72, math.hypot(2.0 - x, y))

    def test_no_place_before_it_is_a_failure(self):
        with self.plans(lambda x, y: False):
            leaf = tasks.Approach((2.0, 0.0, 0.7))
            self.assertEqual(FAILURE, tick(leaf))
        self.assertIn("no plan to a place before (2.00, 0.00)", leaf.feedback_message)

    def test_the_next_place_when_one_is_not_reached(self):
        self.failing = {1}
        with self.plans(lambda x, y: True):
            leaf = tasks.Approach((2.0, 0.0, 0.7))
            self.run_leaf(leaf)
        self.assertEqual((SUCCESS, 2, 2), (leaf.status, len(self.sent), len(set(leaf._tried))))

    def test_what_is_seen_from_nearer_counts_for_the_next_place(self):
        self.failing = {1}
        with self.plans(lambda x, y: not self.sent or math.hypot(2.0 - x, y) > 0.8):
            leaf = tasks.Approach((2.0, 0.0, 0.7))
            self.run_leaf(leaf)
        distances = [math.hypot(2.0 - x, y) for x, y, _ in leaf._tried]
        numpy.testing.assert_allclose([0.72, 0.85], distances)

    def test_who_comes_again_stands_elsewhere(self):
        with self.plans(lambda x, y: True):
            leaf = tasks.Approach((2.0, 0.0, 0.7))
            stood = []
            for _ in range(3):
                self.run_leaf(leaf)
                stood.append(leaf._tried[0])
            self.assertEqual(3, len(set(stood)))
            leaf.point = (2.0, 3.0, 0.7)
            self.run_leaf(leaf)
            self.assertEqual([leaf._tried[0]], leaf._stood)

    def test_beside_a_wall_is_no_place_for_arms(self):
        with self.plans(lambda x, y: True), mock.patch.object(search.Lidar, "of") as lidar:
            wall = (6.0, 0.1, 2.2), (2.0, 0.45, 1.1)
            lidar.return_value.boxes = lambda at, near_m, far_m: [wall] if near_m <= math.dist(at, (2.0, 0.4)) <= far_m else []
            leaf = tasks.Approach((2.0, 0.0, 0.7), clear_m=0.9)
            self.run_leaf(leaf)
            self.assertLess(leaf._tried[0][1], -0.4)
            stood = leaf._tried[0]
            self.run_leaf(leaf)
            self.assertGreater(math.dist(stood[:2], leaf._tried[0][:2]), search.AGAIN_M, "elsewhere, not a hand's breadth aside")

    def test_what_is_ahead_is_not_beside(self):
        wall = (0.1, 4.0, 2.2), (1.05, 0.0, 1.1)
        self.assertEqual(math.inf, search.beside_m((0.0, 0.0, 0.0), wall))
        for yaw in (math.pi / 2, -math.pi / 2, math.pi):
            self.assertAlmostEqual(1.0, search.beside_m((0.0, 0.0, yaw), wall))
        self.assertEqual(0.0, search.beside_m((1.05, 0.0, 0.0), wall))

    def test_a_point_that_is_never_reached(self):
        self.failing = set(range(100))
        with self.plans(lambda x, y: True):
            leaf = tasks.Approach((2.0, 0.0, 0.7), attempts=4)
            self.run_leaf(leaf)
        self.assertEqual((FAILURE, 4), (leaf.status, len(self.sent)))
        self.assertIn("the last of 4 places", leaf.feedback_message)


class Clouds(unittest.TestCase):
    """Tables in clouds of the lidar."""

    def setUp(self):
        place = numpy.eye(4)
        place[:3, 3] = (10.0, 0.0, 0.4)
        self.known = True

        def matrix(target, source, wait_s, stamp):
            self.assertEqual(("map", "velodyne"), (target, source))
            if not self.known:
                raise ArmError(ArmCode.INTERNAL, "not yet")
            return place

        for patched in (mock.patch.object(rospy, "Subscriber"),
                        mock.patch.object(search.robot_state, "frames", lambda: types.SimpleNamespace(matrix=matrix))):
            patched.start()
            self.addCleanup(patched.stop)
        self.tops = search.Lidar("map")

    def hear(self, at, height=0.3, stamp=1.0):
        """A square of 0.6 m at (at, 0), seen at a height above the lidar."""
        x, y = numpy.meshgrid(numpy.arange(at, at + 0.6, 0.05), numpy.arange(0.0, 0.6, 0.05))
        points = numpy.zeros(x.size, numpy.dtype({"names": ["x", "y", "z", "ring"], "formats": ["<f4", "<f4", "<f4", "<u2"],
                                                  "offsets": [0, 4, 8, 16], "itemsize": 22}))
        points["x"], points["y"], points["z"] = x.ravel(), y.ravel(), height
        cloud = sensor_msgs.msg.PointCloud2(height=1, width=x.size, point_step=22, data=points.tobytes())
        cloud.header.frame_id, cloud.header.stamp = "velodyne", rospy.Time.from_sec(stamp)
        cloud.fields = [sensor_msgs.msg.PointField(name, offset, sensor_msgs.msg.PointField.FLOAT32, 1)
                        for name, offset in (("x", 0), ("y", 4), ("z", 8))]
        self.tops._on_cloud(cloud)

    def test_they_are_in_the_map(self):
        self.hear(2.0)
        squares = self.tops.squares()
        self.assertGreaterEqual(len(squares), 16)
        self.assertTrue(all(119 <= i <= 126 and -1 <= j <= 6 for i, j in squares), squares)

    def test_the_robot_is_no_table(self):
        self.hear(0.1)
        self.assertEqual(set(), self.tops.squares())

    def test_one_cloud_a_second_and_another_after_time_ran_back(self):
        self.hear(2.0, height=3.0, stamp=100.0)
        self.hear(2.0, stamp=100.5)
        self.assertEqual(set(), self.tops.squares())
        self.hear(2.0, stamp=1.0)
        self.assertTrue(self.tops.squares())

    def test_without_a_place_in_the_map_it_waits(self):
        self.known = False
        self.hear(2.0)
        self.assertEqual(set(), self.tops.squares())


class Around(unittest.TestCase):
    """What a lidar has seen around the robot, as boxes of the arms' scene."""

    @staticmethod
    def wall(x0, x1, y, low, high):
        x, z = numpy.meshgrid(numpy.arange(x0, x1, 0.02), numpy.arange(low, high, 0.05))
        return numpy.column_stack([x.ravel(), numpy.full(x.size, y), z.ravel()])

    def test_walls_go_on_and_cabinets_end(self):
        solids = Solids()
        solids.add(self.wall(0.0, 1.0, 1.02, 0.3, 1.5))
        solids.add(self.wall(0.0, 1.0, -1.03, 0.3, 0.9))
        boxes = solids.boxes((0.5, 0.0), 0.5, 1.3)
        self.assertEqual(2, len(boxes))
        (low_size, low_middle), (tall_size, tall_middle) = boxes
        numpy.testing.assert_allclose((1.0, 0.05, 0.9), low_size, atol=0.11)
        numpy.testing.assert_allclose((1.0, 0.05, 2.2), tall_size, atol=1e-9)
        numpy.testing.assert_allclose((0.5, 1.025, 1.1), tall_middle, atol=1e-9)
        self.assertAlmostEqual(low_size[2] / 2, low_middle[2])

    def test_tables_and_single_points_are_none(self):
        solids = Solids()
        x, y = numpy.meshgrid(numpy.arange(0.0, 1.0, 0.02), numpy.arange(0.0, 1.0, 0.02))
        solids.add(numpy.column_stack([x.ravel(), y.ravel(), numpy.full(x.size, 0.7)]))
        solids.add(numpy.array([(0.6, 0.6, 1.9), (numpy.nan, 0.0, 1.0), (3.0, 3.0, 1.0), (3.0, 3.0, 1.9)]))
        self.assertEqual(1, len(solids.boxes((0.5, 0.5), 0.0, 9.0)), "where something stands above the table")
        self.assertEqual([], solids.boxes((0.5, 0.5), 0.0, 9.0, lambda x, y: x < 2))

    def test_they_replace_what_was_around_before(self):
        known = {"around_0": 1, "around_7": 1, "support": 1, "cube_1": 1}
        added = []
        made_up = types.SimpleNamespace(objects=known, remove=lambda name: removed.append(name),
                                        add_box=lambda name, size, middle, frame: added.append((name, middle[:2], frame)))
        removed = []
        lidar = search.Lidar.__new__(search.Lidar)
        lidar._solids, lidar._tops, lidar._lock = Solids(), types.SimpleNamespace(squares=lambda: {(5, 0)}), threading.Lock()
        for x in (1.2, 0.41, 2.0):  # the robot itself, what carries the table, a post
            lidar._solids.add(self.wall(x + 0.01, x + 0.02, 0.01, 0.3, 1.5))
        with mock.patch.object(around, "scene", lambda: made_up), mock.patch.object(search.Lidar, "of", lambda frame: lidar), \
                mock.patch.object(around, "base_pose", lambda frame: (1.0, 0.0, 0.3)):
            leaf = tasks.SeeAround()
            self.assertEqual(SUCCESS, tick(leaf))
        self.assertEqual(["around_0", "around_7"], removed)
        self.assertEqual([("around_0", (2.025, 0.025), "map")], [(n, tuple(round(v, 3) for v in m), f) for n, m, f in added])


class Running(unittest.TestCase):
    def setUp(self):
        patched = mock.patch.object(rospy, "Publisher")
        self.publisher = patched.start().return_value
        self.addCleanup(patched.stop)

    def test_the_tree_is_published_when_it_changes(self):
        tasks.run(MotionLeaf(MadeUpMotion(types.SimpleNamespace(message=""), ticks=5)), period_s=0.0, alive=lambda: True)
        self.assertEqual(2, self.publisher.publish.call_count)

    def test_what_is_active_is_cancelled_at_the_end_of_the_program(self):
        motion = MadeUpMotion(ticks=1000)
        ticks = iter([True, True, False])
        self.assertEqual((False, "stopped"), tasks.run(MotionLeaf(motion), period_s=0.0, alive=lambda: next(ticks)))
        self.assertTrue(motion.cancelled)
        other = MadeUpMotion(ticks=1000)

        def interrupt(_):
            raise KeyboardInterrupt

        with self.assertRaises(KeyboardInterrupt):
            tasks.run(MotionLeaf(other), period_s=0.0, alive=lambda: True, on_tick=interrupt)
        self.assertTrue(other.cancelled)

    def test_a_failure_is_that_of_the_leaf(self):
        leaf = MotionLeaf(MadeUpMotion(error=ArmError(ArmCode.NO_GRASP, "none"), ticks=0))
        done, why = tasks.run(py_trees.composites.Sequence("all", True, [leaf]), period_s=0.0, alive=lambda: True)
        self.assertFalse(done)
        self.assertIn("motion: ", why)


if __name__ == "__main__":
    unittest.main()
