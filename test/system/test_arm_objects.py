"""Detected objects in the arm node's scene, with a program that says what a detector would."""

import math
import pathlib
import sys
import tempfile
import threading
import time
import unittest

REPO = pathlib.Path(__file__).resolve().parents[2]
sys.path[:0] = [str(REPO / "src"), str(REPO / "tools" / "lib")]

import diagnostic_msgs.msg  # noqa: E402
import geometry_msgs.msg  # noqa: E402
import numpy  # noqa: E402
import rospy  # noqa: E402
import simulated_robot  # noqa: E402
import vision_msgs.msg  # noqa: E402
import yaml  # noqa: E402

import extperfc.arm  # noqa: E402
from extperfc.arm import robot_state  # noqa: E402
from extperfc.msg import ArmCode  # noqa: E402

AHEAD = (0.70, 0.25, 0.30, math.pi, 0.0, 0.0)  # the left gripper looks down, in the frame `base`
CLASSES = ["cube", "sphere", "cone", "book"]
MAX_AGE_S = 3.0
CONFIRM = 3
OPTICAL = (0.5, -0.5, 0.5, -0.5)  # x y z w of a camera that looks along the x axis
SMALL = (0.04, 0.04, 0.04)


def detection(label, position, size=SMALL, orientation=(0.0, 0.0, 0.0, 1.0), score=0.9):
    """vision_msgs/Detection3D; label: a class, or a number for one."""
    made = vision_msgs.msg.Detection3D()
    index = CLASSES.index(label) if isinstance(label, str) else label
    made.results = [vision_msgs.msg.ObjectHypothesisWithPose(id=index, score=score)]
    made.bbox.center.position = geometry_msgs.msg.Point(*position)
    made.bbox.center.orientation = geometry_msgs.msg.Quaternion(*orientation)
    made.bbox.size = geometry_msgs.msg.Vector3(*size)
    return made


class Detector:
    """Says the same again and again, ten times a second, until told otherwise."""

    def __init__(self):
        rospy.set_param("/fake_detector/classes", CLASSES)
        self._info = rospy.Publisher("vision_info", vision_msgs.msg.VisionInfo, queue_size=1, latch=True)
        self._info.publish(vision_msgs.msg.VisionInfo(database_location="/fake_detector/classes"))
        self._detections = rospy.Publisher("detections_3d", vision_msgs.msg.Detection3DArray, queue_size=5)
        self._says = None
        self._done = threading.Event()
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._thread.start()

    def wait_heard(self):
        deadline = time.monotonic() + 30
        while not (self._info.get_num_connections() and self._detections.get_num_connections()):
            if time.monotonic() > deadline:
                raise AssertionError("nobody listens to detections_3d and vision_info")
            time.sleep(0.02)

    def send(self, *detections, frame="base"):
        message = vision_msgs.msg.Detection3DArray(detections=list(detections))
        message.header.stamp, message.header.frame_id = rospy.Time.now(), frame
        self._detections.publish(message)

    def say(self, says):
        """A function that gives the detections of now, or None."""
        self._says = says

    def _run(self):
        while not self._done.wait(0.1):
            says = self._says
            if says is not None:
                self.send(*says())

    def close(self):
        self._done.set()
        self._thread.join()


class ArmObjects(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(folder.cleanup)
        config = yaml.safe_load((REPO / "config" / "arm.yaml").read_text())
        config["objects"].update(enabled=True, confirm=CONFIRM, max_age_s=MAX_AGE_S)
        file = pathlib.Path(folder.name) / "arm.yaml"
        file.write_text(yaml.safe_dump(config))
        cls.session = simulated_robot.launch(cls, "test_arm_objects", "sim_arm.launch", world="empty", markers="false",
                                             start_pose="neutral", config=str(file))
        cls.status = {}  # values of the latest diagnostics, by status
        rospy.Subscriber("/diagnostics", diagnostic_msgs.msg.DiagnosticArray, cls.on_diagnostics, queue_size=20)
        cls.left = extperfc.arm.Arm("left", wait_s=60)
        cls.left.joints  # noqa: B018  waits for the robot
        cls.detector = Detector()
        cls.addClassCleanup(cls.detector.close)
        cls.detector.wait_heard()

    @classmethod
    def on_diagnostics(cls, message):
        for status in message.status:
            for name in ("objects", "arms"):
                if status.name.endswith(": " + name):
                    cls.status[name] = dict({value.key: value.value for value in status.values}, message=status.message,
                                            level=status.level, stamp=time.monotonic())

    def setUp(self):
        self.addCleanup(self.detector.say, None)
        self.left.scene.clear()
        deadline = time.monotonic() + 20
        while True:
            try:
                return self.move_quickly("neutral")
            except extperfc.arm.ArmError as error:
                self.assertIn(error.code, (ArmCode.NO_JOINT_STATES, ArmCode.ROBOT_NOT_ENABLED, ArmCode.CONTROLLER_MISSING),
                              str(error))
                self.assertLess(time.monotonic(), deadline, str(error))
                time.sleep(0.1)

    def move_quickly(self, goal):
        """A motion during which nothing else happens."""
        simulated_robot.set_pace(simulated_robot.QUICK)
        try:
            self.left.move_to(goal, frame="base", timeout=60)
        finally:
            simulated_robot.set_pace(1.0)

    def wait(self, condition, what, seconds=15):
        deadline = time.monotonic() + seconds
        while not condition():
            self.assertLess(time.monotonic(), deadline, f"{what}; diagnostics: {self.status.get('objects')}")
            time.sleep(0.02)

    def names(self):
        return sorted(self.left.scene.objects)

    def diagnostics_of(self, name):
        """Diagnostics that are newer than this call."""
        begin = time.monotonic()
        self.wait(lambda: self.status.get(name, {"stamp": 0})["stamp"] > begin, f"no diagnostics of {name}")
        return self.status[name]

    def position(self, name):
        """Of an object of the scene, in the frame `base`."""
        pose = self.left.scene.objects[name].pose
        found = robot_state.frames().lookup("base", pose.header.frame_id, 10).transform
        x, y, z, w = found.rotation.x, found.rotation.y, found.rotation.z, found.rotation.w
        rotation = numpy.array([[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
                            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
                            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]])
        at = pose.pose.position
        return rotation @ (at.x, at.y, at.z) + (found.translation.x, found.translation.y, found.translation.z)

    def near(self, wanted, found, within_m):
        self.assertLess(float(numpy.linalg.norm(numpy.subtract(wanted, found))), within_m, f"{wanted} {found}")

    def appears(self, name):
        self.wait(lambda: name in self.left.scene.objects, f"{name} is not in the scene")

    def test_an_object_joins_after_some_detections(self):
        for _ in range(CONFIRM - 1):
            self.detector.send(detection("cone", (0.8, 0.3, 0.0), (0.06, 0.12, 0.07), OPTICAL))
            time.sleep(0.1)
        self.wait(lambda: self.diagnostics_of("objects")["objects waiting for objects/confirm or objects/max_objects"] == "1",
                  "the detections do not arrive")
        self.assertEqual([], self.names())
        self.detector.send(detection("cone", (0.8, 0.3, 0.0), (0.06, 0.12, 0.07), OPTICAL))
        self.appears("cone_1")
        found = self.left.scene.objects["cone_1"]
        self.assertEqual("cone", found.label)
        self.near((0.8, 0.3, 0.0), self.position("cone_1"), 1e-3)
        # Along a camera's axes y is the height and z the depth; it stands.
        self.assertEqual([found.primitives[0].CONE], [primitive.type for primitive in found.primitives])
        numpy.testing.assert_allclose(found.primitives[0].dimensions, (0.12, 0.035), atol=1e-9)
        self.assertAlmostEqual(0.0, found.pose.pose.orientation.x, delta=1e-3)
        self.assertAlmostEqual(0.0, found.pose.pose.orientation.y, delta=1e-3)
        # Each kind has its shape, and jitter changes nothing.
        count = iter(range(10 ** 6))
        self.detector.say(lambda: [detection("cone", (0.8, 0.3, 0.001 * (next(count) % 2)), (0.06, 0.12, 0.07), OPTICAL),
                                   detection("sphere", (0.8, 0.0, 0.0)), detection("book", (0.8, -0.3, 0.0), (0.2, 0.1, 0.03)),
                                   detection("book", (0.5, -0.6, 0.0), (0.2, 0.1, 0.03))])
        self.appears("book_2")
        self.assertEqual(["book_1", "book_2", "cone_1", "sphere_1"], self.names())
        objects = self.left.scene.objects
        numpy.testing.assert_allclose(objects["sphere_1"].primitives[0].dimensions, (0.02,), atol=1e-9)
        numpy.testing.assert_allclose(objects["book_1"].primitives[0].dimensions, (0.2, 0.1, 0.03), atol=1e-9)
        before = self.diagnostics_of("arms")["changes of the scene"]
        for _ in range(2):
            self.assertEqual(before, self.diagnostics_of("arms")["changes of the scene"])

    def test_an_object_that_moves_and_one_that_goes(self):
        place = [0.8, 0.3, 0.0]
        self.detector.say(lambda: [detection("cube", place), detection("sphere", (0.8, -0.3, 0.0))])
        self.appears("cube_1")
        place[0] = 0.83
        self.wait(lambda: abs(self.position("cube_1")[0] - 0.83) < 0.006, "it does not follow")
        self.detector.say(lambda: [detection("sphere", (0.8, -0.3, 0.0))])
        began = rospy.Time.now()
        self.wait(lambda: "cube_1" not in self.left.scene.objects, "it does not go")
        self.assertGreater((rospy.Time.now() - began).to_sec(), MAX_AGE_S - 0.5)
        self.assertEqual(["sphere_1"], self.names())

    def test_what_cannot_be_is_ignored(self):
        nan = math.nan
        self.detector.say(lambda: [
            detection("cube", (0.8, 0.3, 0.0), (nan, 0.04, 0.04)), detection("cube", (0.8, 0.2, 0.0), (0.04, 0.0, 0.04)),
            detection("cube", (0.8, 0.1, 0.0), (0.04, 0.04, -1.0)), detection("cube", (nan, 0.1, 0.0)),
            detection("cube", (0.8, 0.0, 0.0), orientation=(nan, 0.0, 0.0, 1.0)), detection("cube", (0.9, 0.0, 0.0), score=nan),
            detection("cube", (0.9, 0.1, 0.0), (math.inf,) * 3), detection(99, (0.9, 0.2, 0.0)), detection(-1, (0.9, 0.3, 0.0)),
            detection("cube", (0.9, 0.4, 0.0), score=0.2), detection("cube", (0.9, 0.5, 0.0), (0.1, 0.1, 0.4)), vision_msgs.msg.Detection3D(), detection("sphere", (0.8, -0.3, 0.0))])
        self.appears("sphere_1")
        values = self.diagnostics_of("objects")
        self.assertEqual(["sphere_1"], self.names())
        for reason, minimum in (("invalid pose, size or score", 8 * CONFIRM), ("class without a name", 2 * CONFIRM),
                              ("below objects/min_score", CONFIRM), ("above objects/largest_m", CONFIRM)):
            self.assertGreaterEqual(int(values["ignored: " + reason]), minimum, reason)
        # An unknown frame and an empty frame.
        self.detector.say(None)
        for frame, text in (("atlantis", "atlantis"), ("", "no frame")):
            def refused(frame=frame, text=text):
                self.detector.send(detection("cube", (0.8, 0.3, 0.0)), frame=frame)
                return text in self.diagnostics_of("objects")["message"]
            self.wait(refused, f"the frame '{frame}' is no error", 20)
            self.assertEqual(diagnostic_msgs.msg.DiagnosticStatus.ERROR, self.status["objects"]["level"])
        self.detector.say(lambda: [detection("cube", (0.8, 0.3, 0.0))])
        self.appears("cube_1")
        self.assertEqual(diagnostic_msgs.msg.DiagnosticStatus.OK, self.diagnostics_of("objects")["level"])

    def test_it_blocks_the_path(self):
        goal = self.left.solve_ik(AHEAD, frame="base")
        motion = self.left.move_to({name[5:]: value for name, value in goal.items()}, wait=False, velocity_scale=0.15, replans=0)
        self.wait(lambda: motion.feedback is not None and motion.feedback.executed > 0.1, "it does not begin to move")
        self.assertFalse(motion.done)
        self.detector.say(lambda: [detection("cube", AHEAD[:3], (0.15, 0.15, 0.15))])
        with self.assertRaises(extperfc.arm.ArmError) as caught:
            motion.wait(20)
        self.assertEqual(ArmCode.PATH_BLOCKED, caught.exception.code, caught.exception.message)
        self.assertIn("cube_1", caught.exception.message)
        self.assertTrue(self.left.check().free)

    def test_a_held_object_is_not_duplicated(self):
        self.move_quickly(AHEAD)
        tool = lambda: self.left.tool_pose("base").pose.position  # noqa: E731
        in_hand = lambda: detection("cube", (tool().x + 0.01, tool().y, tool().z - 0.06))  # noqa: E731
        self.detector.say(lambda: [in_hand()])
        self.appears("cube_1")
        fingers = ("l_gripper_l_finger", "l_gripper_r_finger", "l_gripper_l_finger_tip", "l_gripper_r_finger_tip",
                   "left_gripper_base", "left_hand")
        self.left.scene.attach("cube_1", "left_gripper", fingers)
        seen = set()
        motion = self.left.move_to("neutral", wait=False)
        while not motion.done:
            seen.update(self.names())
            time.sleep(0.02)
        motion.wait(30)
        self.assertEqual({"cube_1"}, seen)
        # Another one is another one.
        self.detector.say(lambda: [in_hand(), detection("cube", (0.9, -0.5, -0.2))])
        self.appears("cube_2")
        self.assertEqual("left_gripper", self.left.scene.objects["cube_1"].link)
        # Let go it is the same again, and moves when it is seen elsewhere.
        self.left.scene.detach("cube_1")
        where = tool()
        self.detector.say(lambda: [detection("cube", (where.x, where.y, where.z - 0.09)), detection("cube", (0.9, -0.5, -0.2))])
        self.wait(lambda: abs(self.position("cube_1")[2] - (where.z - 0.09)) < 0.006, "it does not move after the release")
        self.assertEqual(["cube_1", "cube_2"], self.names())

    def test_the_target_of_a_pick_stays_where_it_is(self):
        place = [0.70, 0.25, 0.05]
        self.detector.say(lambda: [detection("cube", place)])
        self.appears("cube_1")
        before = self.position("cube_1")
        motion = self.left.pick("cube", wait=False)
        self.wait(lambda: motion.done or (motion.feedback is not None and motion.feedback.stage == "approaching"), "no approach")
        self.assertFalse(motion.done)
        place[0] += 0.03  # as when the gripper hides half of it
        while not motion.done:
            now = self.left.scene.objects
            self.assertEqual(["cube_1"], sorted(now))
            if not motion.done:
                self.near(before, self.position("cube_1"), 1e-3)
            time.sleep(0.02)
        # There is nothing between the fingers of this simulation. Afterwards detections count again, where no gripper is.
        with self.assertRaises(extperfc.arm.ArmError) as caught:
            motion.wait(10)
        self.assertEqual(ArmCode.GRASP_MISSED, caught.exception.code, caught.exception.message)
        self.left.move_to("neutral", timeout=60)
        self.wait(lambda: abs(self.position("cube_1")[0] - place[0]) < 0.006, "it stays for ever")

    def test_the_robot_itself_is_no_object(self):
        self.move_quickly(AHEAD)
        tool = self.left.tool_pose("base").pose.position
        self.detector.say(lambda: [detection("cube", (tool.x, tool.y, tool.z + 0.05), (0.09, 0.09, 0.09)),
                                   detection("sphere", (0.8, -0.3, 0.0))])
        self.appears("sphere_1")
        self.wait(lambda: int(self.diagnostics_of("objects")["ignored: at the robot"]) > CONFIRM, "the gripper is not ignored")
        self.assertEqual(["sphere_1"], self.names())
        self.left.move_to("neutral", timeout=60)  # and nothing holds it there
        self.appears("cube_1")

    def test_what_a_user_put_there_wins(self):
        self.detector.say(lambda: [detection("cube", (0.8, 0.3, 0.0))])
        self.appears("cube_1")
        self.left.scene.add_box("cube_1", (0.06, 0.06, 0.06), (0.82, 0.3, 0.0), frame="base", label="cube")
        begin = rospy.Time.now()
        self.wait(lambda: (rospy.Time.now() - begin).to_sec() > 1.0, "the time stands still")
        self.assertEqual(["cube_1"], self.names())
        numpy.testing.assert_allclose(self.left.scene.objects["cube_1"].primitives[0].dimensions, (0.06, 0.06, 0.06))
        self.near((0.82, 0.3, 0.0), self.position("cube_1"), 1e-3)
        # Without it what is seen comes again.
        self.left.scene.remove("cube_1")
        self.wait(lambda: "cube_1" in self.left.scene.objects and
                  self.left.scene.objects["cube_1"].primitives[0].dimensions[0] < 0.05, "it does not come again")


if __name__ == "__main__":
    unittest.main()
