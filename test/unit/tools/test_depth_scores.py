"""References, statistics and inverse kinematics of tools/trial_depth."""

import pathlib
import tempfile
import unittest

import depth_scores as scores
import numpy
import sim_arm
from grasp_scene import SHAPES

from extperfc import robot_description as rd

REPO = pathlib.Path(__file__).resolve().parents[3]
AHEAD = numpy.array([0.0, 0, 1])


class Rays(unittest.TestCase):
    def test_the_surface_is_half_an_object_before_its_middle(self):
        at = rd.transform((0, 0, 0.5))
        self.assertAlmostEqual(0.5 - SHAPES["sphere"].width / 2, scores.ray_hits("sphere", at, AHEAD))
        self.assertAlmostEqual(0.5 - SHAPES["cube"].width / 2, scores.ray_hits("cube", at, AHEAD))
        cone, upright = SHAPES["cone"], rd.rotation_of_rpy(-numpy.pi / 2, 0, 0)  # z of the cone up in the image
        self.assertAlmostEqual(0.5 - cone.width / 4, scores.ray_hits("cone", rd.transform((0, 0, 0.5), upright), AHEAD))
        self.assertAlmostEqual(0.5 - cone.height / 2, scores.ray_hits("cone", at, AHEAD), msg="the base")

    def test_hits_lie_on_the_surface_from_anywhere(self):
        random = numpy.random.default_rng(1)
        cone = SHAPES["cone"]
        for _ in range(200):
            pose = rd.transform(
                random.uniform(-0.02, 0.02, 3) + (0, 0, 0.4), rd.rotation_of_rpy(*random.uniform(-3, 3, 3)))
            for shape, gap in (("sphere", lambda p: numpy.linalg.norm(p) - SHAPES["sphere"].width / 2),
                               ("cube",
                                lambda p: numpy.abs(p).max() - SHAPES["cube"].width / 2), ("cone", lambda p: max(
                                    numpy.hypot(p[0], p[1]) -
                                    (0.5 - p[2] / cone.height) * cone.width / 2, -p[2] - cone.height / 2))):
                hit = scores.ray_hits(shape, pose, AHEAD)
                if hit is not None:
                    point = numpy.linalg.inv(pose) @ (0, 0, hit, 1)
                    self.assertAlmostEqual(0.0, gap(point[:3]), places=9, msg=shape)

    def test_a_ray_beside_an_object_hits_nothing(self):
        for shape in SHAPES:
            self.assertIsNone(scores.ray_hits(shape, rd.transform((0.2, 0, 0.5)), AHEAD))


class Statistics(unittest.TestCase):
    def setUp(self):
        self.measures = [scores.Measure("cube", "truth", kind, r, r + e, r)
                         for kind in scores.KINDS for r, e in ((0.5, 0.01), (1.0, -0.03), (0.1, 0.5))]
        self.seen = [scores.Seen("cube", "truth", r, 2, 1, 1) for r in (0.5, 1.0, 0.1)]

    def test_errors_are_those_of_the_definitions(self):
        found = scores.statistics(self.measures[:2])
        self.assertEqual(2, found["n"])
        for key, value in {
                "mean_m": -0.01,
                "mean_abs_m": 0.02,
                "rms_m": 0.0005**0.5,
                "max_m": 0.03,
                "mean_percent": 2.5
        }.items():
            self.assertAlmostEqual(value, found[key], msg=key)
        self.assertIsNone(scores.statistics([]))

    def test_near_objects_stand_apart(self):
        text = "\n".join(scores.table(self.measures, self.seen, 0.2))
        self.assertRegex(text, r"cube +4 +2 +2 +-10\.0 +20\.0 +22\.4 +30\.0 +2\.50")
        self.assertIn("at 0.100 m, nearer than the camera measures", text)
        self.assertIn("mean error 500 mm", text)
        self.assertNotIn("network", text)

    def test_files_hold_every_estimate(self):
        with tempfile.TemporaryDirectory() as folder:
            file = pathlib.Path(folder) / "depth.csv"
            scores.write_csv(self.measures, file)
            self.assertEqual(1 + 6, len(file.read_text().splitlines()))
            scores.plot(self.measures, 0.2, file.with_suffix(".png"))
            self.assertGreater(file.with_suffix(".png").stat().st_size, 5000)
        self.assertEqual(2, len(scores.as_dict(self.measures, self.seen, 0.2)["summary"]))


class Kinematics(unittest.TestCase):
    def setUp(self):
        self.robot = rd.RobotDescription.from_file(REPO / "urdf" / "mobile_baxter.urdf")

    def test_inverse_kinematics_come_to_the_pose_within_the_limits(self):
        random = numpy.random.default_rng(2)
        for side in ("left", "right"):
            arm = sim_arm.ArmKinematics(self.robot, side)
            for _ in range(5):
                goal = arm.neutral + random.uniform(-0.3, 0.3, 7)
                pose, _ = arm.forward(goal)
                found = arm.solve(pose, random)
                self.assertIsNotNone(found)
                self.assertLess(numpy.abs(arm.forward(found)[0] - pose).max(), 2e-3)
                self.assertTrue((found >= arm.lower).all() and (found <= arm.upper).all())

    def test_poses_out_of_reach_have_no_solution(self):
        arm = sim_arm.ArmKinematics(self.robot, "left")
        self.assertIsNone(arm.solve(rd.transform((3.0, 0, 0)), numpy.random.default_rng(3), tries=2))


if __name__ == "__main__":
    unittest.main()
