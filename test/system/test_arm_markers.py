"""tools/arm_markers and the Python client, against a stand-in for the arm node."""

import os
import pathlib
import signal
import subprocess
import sys
import tempfile
import threading
import time
import unittest

REPO = pathlib.Path(__file__).resolve().parents[2]
sys.path[:0] = [str(REPO / "src"), str(REPO / "tools" / "lib")]

import rospy  # noqa: E402
from ros_session import RosSession  # noqa: E402
from std_msgs.msg import String  # noqa: E402
from visualization_msgs.msg import InteractiveMarkerFeedback, InteractiveMarkerInit, Marker, MarkerArray  # noqa: E402

import extperfc.arm  # noqa: E402

URDF = REPO / "urdf" / "mobile_baxter.urdf"
UNREACHABLE, COLLIDING = "out of reach", "collides with the table"


PROGRAM = """
import time
import extperfc.arm
arm = extperfc.arm.Arm("left", wait_s=20)
motion = arm.move_to("neutral", wait=False, velocity_scale=0.02)
motion.when_done(lambda _: print("ended", flush=True))
while motion.feedback is None:
    time.sleep(0.01)
print("moving", flush=True)
if {wait}:
    motion.wait()
"""


class Scene:
    """What rviz would show, from marker arrays."""

    def __init__(self, topic):
        self.shown, self.changed = {}, threading.Condition()
        rospy.Subscriber(topic, MarkerArray, self.on_markers, queue_size=100)

    def on_markers(self, message):
        with self.changed:
            for marker in message.markers:
                key = (marker.ns, marker.id)
                if marker.action == Marker.DELETE:
                    self.shown.pop(key, None)
                else:
                    self.shown[key] = marker
            self.changed.notify_all()

    def of(self, namespace):
        return [marker for (ns, _), marker in self.shown.items() if ns == namespace]

    def wait(self, condition, what, seconds=20.0):
        with self.changed:
            if not self.changed.wait_for(condition, seconds):
                texts = [m.text for m in self.shown.values() if m.text]
                raise AssertionError(f"waited {seconds} s for {what}; shown: {sorted({k[0] for k in self.shown})} {texts}")

    def text(self, side):
        return " ".join(marker.text for marker in self.of(f"{side}_text")).replace("\n", " ")


def heed_signals():
    """For a child: whoever runs the tests may ignore these, as nohup and the background of a shell do, and children would too."""
    for number in (signal.SIGINT, signal.SIGHUP):
        signal.signal(number, signal.SIG_DFL)


class ArmMarkers(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(cls.folder.cleanup)
        session = RosSession(os.path.join(cls.folder.name, "log"))
        cls.addClassCleanup(session.close)
        cls.start(["roscore", "-p", str(session.port)])
        cls.wait_for(lambda: not subprocess.run(["rosparam", "get", "/run_id"], capture_output=True).returncode, "the master")
        cls.start([sys.executable, str(REPO / "test" / "system" / "fake_arm_node.py"), str(URDF), "--tf"])
        cls.wait_for(lambda: not subprocess.run(["rosparam", "get", "/robot_description"], capture_output=True).returncode,
                     "the fake node")
        cls.start([str(REPO / "tools" / "arm_markers")])
        rospy.init_node("test_arm_markers", disable_signals=True)
        cls.goal, cls.path = Scene("arm/goal_ghost"), Scene("arm/planned_path")
        cls.feedback = rospy.Publisher("arm/goals/feedback", InteractiveMarkerFeedback, queue_size=10)
        cls.markers = {}
        rospy.Subscriber("arm/goals/update_full", InteractiveMarkerInit, lambda message: cls.markers.update(
            {marker.name: marker for marker in message.markers}) if not cls.markers else None)
        cls.wait_for(lambda: cls.markers, "the markers")
        cls.wait_for(lambda: cls.feedback.get_num_connections() == 1, "the node to listen")
        cls.left = extperfc.arm.Arm("left", wait_s=20)

    @classmethod
    def start(cls, command):
        process = subprocess.Popen(command, stdin=subprocess.DEVNULL)

        def end():
            process.terminate()
            try:
                process.wait(10)
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()
        cls.addClassCleanup(end)

    @staticmethod
    def wait_for(condition, what, seconds=30):
        deadline = time.monotonic() + seconds
        while not condition():
            if time.monotonic() > deadline:
                raise AssertionError(f"waited {seconds} s for {what}")
            time.sleep(0.05)

    def drag(self, side, dx=0.0, dy=0.0, dz=0.0):
        """From where the marker was at first."""
        message = InteractiveMarkerFeedback(client_id="test", marker_name=side, event_type=InteractiveMarkerFeedback.POSE_UPDATE)
        message.header.frame_id = self.markers[side].header.frame_id
        at, first = message.pose, self.markers[side].pose
        at.orientation = first.orientation
        at.position.x, at.position.y, at.position.z = first.position.x + dx, first.position.y + dy, first.position.z + dz
        self.feedback.publish(message)

    def choose(self, side, *titles):
        """An entry of the menu."""
        entries, parent = self.markers[side].menu_entries, 0
        for title in titles:
            parent, = [entry.id for entry in entries if entry.parent_id == parent and entry.title.split("] ")[-1] == title]
        self.feedback.publish(InteractiveMarkerFeedback(
            client_id="test", marker_name=side, event_type=InteractiveMarkerFeedback.MENU_SELECT, menu_entry_id=parent))

    def test_1_goals_are_where_the_grippers_are(self):
        self.assertEqual({"left", "right"}, set(self.markers))
        for side, sign in (("left", 1), ("right", -1)):
            at = self.markers[side].pose.position
            for expected, found in zip((0.579711, sign * 0.183294, 0.1137), (at.x, at.y, at.z)):
                self.assertAlmostEqual(expected, found, places=4)
            self.assertEqual("base", self.markers[side].header.frame_id)

    def test_2_dragging_shows_a_green_arm_or_says_why_not(self):
        def dragged():  # again and again, since the marker's server hears nobody in its first second
            self.drag("left", dz=0.1)
            return self.goal.of("left_goal")
        self.wait_for(dragged, "a ghost")
        self.assertEqual("", self.goal.text("left"))
        parts = self.goal.of("left_goal")
        self.assertTrue(all(part.color.g > part.color.r for part in parts))
        self.assertTrue(all(part.mesh_resource.startswith("package://") for part in parts if part.type == Marker.MESH_RESOURCE))
        self.drag("left", dz=-0.5)
        self.goal.wait(lambda: COLLIDING in self.goal.text("left"), COLLIDING)
        self.assertTrue(all(part.color.r > part.color.g for part in self.goal.of("left_goal")))
        self.drag("left", dx=3.0)
        self.goal.wait(lambda: UNREACHABLE in self.goal.text("left"), UNREACHABLE)
        self.drag("left", dz=0.1)
        self.goal.wait(lambda: not self.goal.text("left"), "no complaint")
        self.assertFalse(self.goal.of("right_goal"))

    def test_3_plan_shows_a_path_and_execute_moves_there(self):
        self.drag("left", dz=0.1)
        self.choose("left", "Plan")
        self.goal.wait(lambda: "path of" in self.goal.text("left"), "the plan's message")
        self.path.wait(lambda: self.path.of("ghost") and self.path.of("tool"), "the path")
        line, = self.path.of("tool")
        self.assertEqual("base_footprint", line.header.frame_id)
        first = self.markers["left"].pose.position
        self.assertAlmostEqual(first.z + 0.6309 + 0.1, line.points[-1].z, delta=2e-3)
        before = self.path.of("ghost")[-1].pose
        self.path.wait(lambda: self.path.of("ghost")[-1].pose != before, "the ghost to move")
        self.choose("left", "Execute the plan")
        self.goal.wait(lambda: self.goal.text("left") == "there", "the arrival")
        self.path.wait(lambda: not self.path.shown, "the path to vanish")
        self.assertFalse(self.goal.of("left_goal"))

    def test_4_both_arms(self):
        self.drag("right", dz=0.1)
        self.drag("left", dz=-0.05)
        self.choose("right", "Plan and execute both arms")
        self.goal.wait(lambda: (self.goal.text("left"), self.goal.text("right")) == ("there", "there"), "both arms to be there")

    def test_5_failures_are_told(self):
        self.drag("right", dz=-0.6)
        self.goal.wait(lambda: COLLIDING in self.goal.text("right"), COLLIDING)
        self.choose("right", "Plan and execute")
        self.goal.wait(lambda: "GOAL_IN_COLLISION" in self.goal.text("right"), "the failure")
        self.choose("right", "Move to", "tuck")
        self.goal.wait(lambda: "INVALID_REQUEST: no state tuck" in self.goal.text("right"), "the failure")
        self.choose("right", "Goal to where the tool is")
        self.goal.wait(lambda: not self.goal.text("right") and not self.goal.of("right_goal"), "nothing to show")

    def test_6_grippers(self):
        self.choose("left", "Close gripper")
        self.goal.wait(lambda: self.goal.text("left") == "closed, empty", "the gripper")

    def test_7_client(self):
        neutral = {"left_s0": 0, "left_s1": -0.55, "left_e0": 0, "left_e1": 0.75, "left_w0": 0, "left_w1": 1.26, "left_w2": 0}
        self.assertEqual("there", self.left.move_to("neutral", timeout=30).message)
        self.wait_for(lambda: all(abs(self.left.joints[n] - v) < 1e-6 for n, v in neutral.items()), "the joints")
        joints = self.left.solve_ik((0.646258, 0.84126, 0.162618, 0.0, 1.5708, 0.7854))
        self.assertEqual(set(neutral), set(joints))
        with self.assertRaisesRegex(extperfc.arm.ArmError, "GOAL_UNREACHABLE"):
            self.left.move_to((3, 0, 0, 0, 0, 0), timeout=30)

    def test_8_client_cancels(self):
        slow = {"velocity_scale": 0.02}  # half a minute
        self.left.move_to("neutral", timeout=30)
        with self.assertRaises(extperfc.arm.ArmError) as caught:
            self.left.move_to("untuck", timeout=0.3, **slow)
        self.assertEqual("TIMEOUT", caught.exception.name)
        motion = self.left.move_to("untuck", wait=False, **slow)
        motion.cancel()
        with self.assertRaisesRegex(extperfc.arm.ArmError, "CANCELLED"):
            motion.wait(20)
        motion = self.left.move_to("untuck", wait=False, **slow)
        self.wait_for(lambda: motion.feedback is not None, "the motion to begin")
        self.left.stop()
        with self.assertRaisesRegex(extperfc.arm.ArmError, "CANCELLED: stopped before the end"):
            motion.wait(20)

    def test_8_three_numbers_and_level_tools_by_tf(self):
        self.left.move_to("neutral", timeout=30)
        self.wait_for(lambda: abs(self.left.tool_pose().pose.position.y - 0.84126) < 1e-4, "the tool's frame")
        before = self.left.tool_pose()
        at = before.pose.position
        self.left.move_to((at.x, at.y, at.z + 0.1), timeout=30)
        self.wait_for(lambda: abs(self.left.tool_pose().pose.position.z - at.z - 0.1) < 2e-3, "10 cm higher")
        rotation = (extperfc.arm.matrix_of_pose(before).T @ extperfc.arm.matrix_of_pose(self.left.tool_pose()))[:3, :3]
        self.assertGreater(rotation.trace(), 2.999)  # 0.02 rad
        axis = self.left.keep_level()[0].axis
        up = extperfc.arm.matrix_of_pose(self.left.tool_pose())[:3, :3] @ (axis.x, axis.y, axis.z)
        self.assertAlmostEqual(1.0, up[2], places=6)

    def test_8_motions_end_with_the_program(self):
        """However it ends: by Ctrl-C, by being ended, with its terminal, or by coming to its last line."""
        ends, heard = [], threading.Condition()

        def on_end(message):
            with heard:
                ends.append(message.data)
                heard.notify_all()
        subscriber = rospy.Subscriber("motion_ended", String, on_end)
        self.wait_for(lambda: subscriber.get_num_connections() == 1, "a connection")
        for number, wait in ((signal.SIGINT, True), (signal.SIGTERM, True), (signal.SIGHUP, True), (None, False)):
            ends.clear()
            self.left.move_to("untuck", timeout=30)
            with heard:
                self.assertTrue(heard.wait_for(lambda: ends, 20))
                ends.clear()
            program = subprocess.Popen([sys.executable, "-c", PROGRAM.format(wait=wait)], stdout=subprocess.PIPE, text=True,
                                       stderr=subprocess.DEVNULL, preexec_fn=heed_signals)
            with self.subTest(number), program:
                self.assertEqual("moving", program.stdout.readline().strip())
                if number is not None:
                    program.send_signal(number)
                program.wait(20)
                with heard:
                    self.assertTrue(heard.wait_for(lambda: ends, 20))
                self.assertEqual(["cancelled"], ends)

    def test_9_what_does_not_run_is_named(self):
        with self.assertRaises(extperfc.arm.ArmError) as caught:
            extperfc.arm.Arm("left", namespace="nowhere", wait_s=0.3).move_to("neutral")
        self.assertEqual("NOT_RUNNING", caught.exception.name)
        self.assertRegex(caught.exception.message, "no action /nowhere/move_arm after 0.3 s: .*roslaunch")


if __name__ == "__main__":
    unittest.main()
