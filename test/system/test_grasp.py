"""The simulated robot before its tray: what the detector finds is picked and placed, and what goes wrong is said."""

import pathlib
import random
import sys
import time
import unittest

REPO = pathlib.Path(__file__).resolve().parents[2]
sys.path[:0] = [str(REPO / "src"), str(REPO / "tools" / "lib")]

import grasp_scene as scene  # noqa: E402
import numpy  # noqa: E402
import rospy  # noqa: E402
import simulated_robot  # noqa: E402
from grasp_arms import GraspArms  # noqa: E402
from grasp_robot import GraspRobot  # noqa: E402
from trajectory_msgs.msg import JointTrajectory  # noqa: E402

import extperfc.arm  # noqa: E402
from extperfc.msg import ArmCode  # noqa: E402

try:
    from extperfc import tasks
except ModuleNotFoundError:
    tasks = None  # py_trees could not be fetched

SEED = 5
LIFT_M = 0.10
FOUND_S = 20.0      # of simulated time for the node to find the cube: images are rare on a busy machine
ANSWER_S = 120.0    # of real time for an action


class Grasp(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.session = simulated_robot.launch(cls, "test_grasp", "sim_grasp.launch", objects="true", seed=SEED)
        cls.robot = GraspRobot(cls.session.alive)
        cls.robot.ready()
        cls.arms = GraspArms(cls.robot)
        cls.arms.open_grippers()
        rng, camera = random.Random(SEED), cls.robot.camera()
        cls.place_pose = scene.draw_place_pose(rng, "cube", 0.4, *camera)
        cls.other = scene.draw_other(rng, cls.place_pose)

    def setUp(self):
        """The cube stands on the tray, and the node has found it."""
        self.robot.park("cube")
        self.arms.arms.move_to("neutral", timeout=ANSWER_S)
        self.robot.put("cube", self.place_pose)
        self.arms.show_support(self.place_pose)
        scene_object, _, others = self.arms.wait_found("cube", scene.middle("cube", self.place_pose), seconds=FOUND_S)
        self.assertIsNotNone(scene_object, f"the cube is not in the scene, but {others}; launch log: {self.session.errors()}")
        self.cube = scene_object

    def fails(self, code, motion):
        with self.assertRaises(extperfc.arm.ArmError) as caught:
            motion.wait(ANSWER_S)
        self.assertEqual(extperfc.arm.errors.NAMES[code], caught.exception.name, caught.exception.message)

    def held(self):
        return [name for name, scene_object in self.arms.scene.objects.items() if scene_object.link]

    def test_a_cube_that_the_detector_finds_is_picked_and_placed(self):
        off = self.arms.place_of(self.cube)[:3, 3] - scene.middle("cube", self.place_pose)
        self.assertLess(abs(off).max(), 0.01)
        before = self.robot.true_pose("cube")[2, 3]
        goal = (*scene.middle("cube", self.other), 0.0, 0.0, self.other.yaw)
        pick = self.arms.arms.pick
        self.fails(ArmCode.UNKNOWN_FRAME, pick("cube", place_at=goal, frame="nowhere", wait=False))
        self.fails(ArmCode.NO_GRASP, pick("cube", place_at=(5.0, 0.0, 1.0), frame="map", wait=False))
        shown = []
        display = rospy.Subscriber("arm/display_trajectory", JointTrajectory, shown.append)
        self.addCleanup(display.unregister)
        picked = pick("cube", lift=LIFT_M, place_at=goal, frame="map", timeout=ANSWER_S)
        self.assertGreaterEqual(len(shown), 3, "motions to the object, along the grasp and up are shown")
        shown.clear()
        self.robot.sleep(1.0)
        rise = self.robot.true_pose("cube")[2, 3] - before
        self.assertTrue(scene.is_held(rise, LIFT_M, self.robot.from_tip("cube")), f"it rose by {rise:.3f} m")
        self.assertEqual([picked.object], self.held())
        self.arms.arms.place(goal, frame="map", timeout=ANSWER_S)
        self.assertGreaterEqual(len(shown), 3, "motions to the place, down and back are shown")
        self.robot.sleep(1.0)
        pose = self.robot.true_pose("cube")
        self.assertTrue(scene.is_placed("cube", pose[:3, 3], pose[:3, :3], self.other), f"\n{pose}\n{self.other}")
        self.assertGreater(self.robot.from_tip("cube"), 0.05)
        self.assertEqual([], self.held())

    @unittest.skipIf(tasks is None, "py_trees is not installed: tools/setup fetches it")
    def test_a_task_shows_the_cube_and_puts_it_back_where_no_other_place_can_be_reached(self):
        done, why = tasks.run(tasks.pick_up("cube", frame="map"), alive=self.session.alive)
        self.assertTrue(done, why)
        found = tasks.read(tasks.Key("found"))
        (_, map_T_camera), middle = self.robot.camera(), scene.middle("cube", self.place_pose)
        self.assertAlmostEqual(numpy.linalg.norm(middle - map_T_camera[:3, 3]), found.distance_m, delta=0.01)
        done, why = tasks.run(tasks.show(0.3), alive=self.session.alive)
        self.assertTrue(done, why)
        shown = numpy.linalg.inv(map_T_camera) @ self.robot.true_pose("cube")
        self.assertLess(numpy.linalg.norm(shown[:3, 3] - (0.0, 0.0, 0.3)), 0.09, "on the camera's axis")
        box, _ = self.robot.wait_detected("cube", self.robot.true_pose("cube")[:3, 3], seconds=FOUND_S)
        self.assertIsNotNone(box, "it is not seen in the gripper")
        done, why = tasks.run(tasks.put_down((5.0, 0.0, 1.0), frame="map"), alive=self.session.alive)
        self.assertFalse(done, "nothing can be placed there")
        self.assertIn("place: ", why)
        self.robot.sleep(1.0)
        pose = self.robot.true_pose("cube")
        self.assertTrue(scene.is_placed("cube", pose[:3, 3], pose[:3, :3], self.place_pose), f"\n{pose}\n{self.place_pose}")
        self.assertEqual([], self.held())

    def wait_stage(self, motion, stage):
        deadline = time.monotonic() + ANSWER_S
        while motion.feedback is None or motion.feedback.stage != stage:
            self.assertFalse(motion.done)
            self.assertLess(time.monotonic(), deadline, f"not {stage}")
            time.sleep(0.01)

    def test_a_cube_that_comes_along_from_its_place_is_reported(self):
        goal = (*scene.middle("cube", self.other), 0.0, 0.0, self.other.yaw)
        picked = self.arms.arms.pick("cube", lift=LIFT_M, place_at=goal, frame="map", timeout=ANSWER_S)
        tip = f"{picked.arm}_gripper"
        tip_T_cube = numpy.linalg.inv(self.robot.transform("map", tip)) @ self.robot.true_pose("cube")
        motion = self.arms.arms.place(goal, frame="map", wait=False)
        self.wait_stage(motion, "checking")
        while not motion.done:
            self.robot.move_body_to("cube", self.robot.transform("map", tip) @ tip_T_cube)
            time.sleep(0.01)
        self.fails(ArmCode.NOT_RELEASED, motion)
        self.assertEqual([picked.object], self.held())
        self.arms.arms.place(goal, frame="map", timeout=ANSWER_S)
        self.assertEqual([], self.held())

    def test_a_cube_that_is_taken_away_is_reported(self):
        motion = self.arms.arms.pick("cube", lift=LIFT_M, wait=False)
        self.wait_stage(motion, "approaching")
        self.robot.park("cube")
        self.fails(ArmCode.GRASP_MISSED, motion)
        self.assertEqual([], self.held())
        self.fails(ArmCode.UNKNOWN_OBJECT, self.arms.arms.pick("sphere", wait=False))

    def test_a_cube_that_is_lost_on_the_way_is_not_placed(self):
        goal = (*scene.middle("cube", self.other), 0.0, 0.0, self.other.yaw)
        self.arms.arms.pick("cube", lift=LIFT_M, place_at=goal, frame="map", timeout=ANSWER_S)
        self.robot.park("cube")
        self.fails(ArmCode.OBJECT_LOST, self.arms.arms.place(goal, frame="map", wait=False))
        self.assertEqual([], self.held())
        self.fails(ArmCode.NOTHING_HELD, self.arms.arms.place(goal, frame="map", wait=False))


if __name__ == "__main__":
    unittest.main()
