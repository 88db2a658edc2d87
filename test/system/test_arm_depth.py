"""What the simulated depth camera sees as an obstacle to the arms: the node's scene is empty."""

import math
import pathlib
import random
import sys
import time
import unittest

REPO = pathlib.Path(__file__).resolve().parents[2]
sys.path[:0] = [str(REPO / "src"), str(REPO / "tools" / "lib")]

import grasp_scene as scene  # noqa: E402
import rospy  # noqa: E402
import simulated_robot  # noqa: E402
from grasp_robot import GraspRobot  # noqa: E402
from visualization_msgs.msg import Marker  # noqa: E402

import extperfc.arm  # noqa: E402
from extperfc.msg import ArmCode  # noqa: E402

SEED = 3
WAIT_S = 30.0       # of real time for images to have an effect: they are rare on a busy machine
ANSWER_S = 120.0    # of real time for a motion
PLACE_XY = (0.62, 0.24)     # over the tray, where the left arm reaches
ABOVE_M = 0.12              # of the tool over the tray
ROTATION = (0.0, 2.0, -0.6)  # roll, pitch, yaw of the gripper: ahead, somewhat down and to the right


class ArmDepth(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.session = simulated_robot.launch(cls, "test_arm_depth", "sim_grasp.launch", depth="true", seed=SEED)
        cls.robot = GraspRobot(cls.session.alive)
        cls.robot.ready()
        cls.voxels = None
        rospy.Subscriber("arm/depth_voxels", Marker, lambda message: setattr(cls, "voxels", message), queue_size=1)
        cls.left = extperfc.arm.Arm("left", wait_s=60)
        cls.place_pose = scene.draw_place_pose(random.Random(SEED), "cube", 0.45, *cls.robot.camera())
        cls.above = (*PLACE_XY, cls.place_pose.top + ABOVE_M, *ROTATION)

    def setUp(self):
        self.robot.put("cube", self.place_pose)
        self.robot.park("cube")
        self.wait_free(self.above)
        self.left.move_to("neutral", timeout=ANSWER_S)

    def wait(self, condition, what):
        deadline = time.monotonic() + WAIT_S
        while not condition():
            self.assertLess(time.monotonic(), deadline, f"{what}; launch log: {self.session.errors()}")
            time.sleep(0.1)

    def wait_free(self, goal):
        """For a path to it."""
        deadline = time.monotonic() + WAIT_S
        while (error := self.refused(goal)) is not None:
            self.assertLess(time.monotonic(), deadline, f"{error}; launch log: {self.session.errors()}")
            time.sleep(0.1)

    def refused(self, goal):
        """The error of planning there, None: there is a path."""
        try:
            self.left.plan(goal, frame="map", timeout=ANSWER_S)
        except extperfc.arm.ArmError as error:
            return error
        return None

    def stand_column(self, x, y, top):
        self.robot.move_body("column", (x, y, top - scene.COLUMN_HEIGHT))

    def heights_of_voxels_near(self, x, y, within_m=0.05):
        """In the frame map."""
        if self.voxels is None:
            return []
        to_map = self.robot.transform("map", self.voxels.header.frame_id)
        points = [(to_map @ (p.x, p.y, p.z, 1.0))[:3] for p in self.voxels.points]
        return [p[2] for p in points if math.hypot(p[0] - x, p[1] - y) < within_m]

    def test_the_tray_is_seen_and_kept_clear_of(self):
        x, y = self.above[:2]
        self.wait(lambda: self.heights_of_voxels_near(x, y), "no voxels at the tray")
        self.assertAlmostEqual(self.place_pose.top, max(self.heights_of_voxels_near(x, y)), delta=0.03)
        error = self.refused((x, y, self.place_pose.top - 0.02, *ROTATION))
        self.assertIsNotNone(error, "the hand may go through the tray")
        self.assertEqual(ArmCode.GOAL_IN_COLLISION, error.code, error.message)
        self.assertIn("depth", error.message)
        self.left.move_to(self.above, frame="map", timeout=ANSWER_S)
        self.assertTrue(self.left.check().free)

    def test_what_becomes_known_is_no_obstacle_of_this_kind_at_once(self):
        x, y = self.above[:2]
        within = (x, y, self.place_pose.top - 0.02, *ROTATION)
        self.addCleanup(self.left.scene.clear)
        for _ in range(5):  # images arrive ten times a second
            self.left.scene.clear()
            self.wait(lambda: self.heights_of_voxels_near(x, y), "no voxels at the tray")
            self.wait(lambda: "depth" in str(self.refused(within)), "the hand may go through the tray")
            self.left.scene.add_box("tray", scene.TRAY_SIZE,
                                     (*scene.TRAY_XY, self.place_pose.top - scene.TRAY_SIZE[2] / 2), frame="map")
            error = self.refused(within)
            self.assertIn("tray", str(error))
            self.assertNotIn("depth", str(error))

    def test_what_comes_into_the_way_stops_a_motion(self):
        motion = self.left.move_to(self.above, frame="map", wait=False, velocity_scale=0.15, replans=0)
        deadline = time.monotonic() + ANSWER_S
        while motion.feedback is None or motion.feedback.executed < 0.1:
            self.assertFalse(motion.done)
            self.assertLess(time.monotonic(), deadline, "it does not begin to move")
            time.sleep(0.01)
        self.stand_column(*self.above[:2], self.above[2] + 0.1)
        with self.assertRaises(extperfc.arm.ArmError) as caught:
            motion.wait(ANSWER_S)
        self.assertEqual(ArmCode.PATH_BLOCKED, caught.exception.code, caught.exception.message)
        self.assertIn("depth", caught.exception.message)
        self.assertTrue(self.left.check().free)

    def test_what_has_gone_is_forgotten(self):
        self.stand_column(*self.above[:2], self.above[2] + 0.1)
        self.wait(lambda: self.refused(self.above), "the column is not seen")
        self.stand_column(*scene.COLUMN_XY, self.place_pose.top - scene.TRAY_SIZE[2])
        self.wait_free(self.above)
        self.left.move_to(self.above, frame="map", timeout=ANSWER_S)


if __name__ == "__main__":
    unittest.main()
