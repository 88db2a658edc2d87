"""The camera's pose is found from views with errors, wrong views are left out, and views that do not determine it are
refused."""

import math
import pathlib
import sys
import unittest

import numpy

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
import synthetic  # noqa: E402

from extperfc import robot_description as rd  # noqa: E402
from extperfc.calibrate import motions, result, solver  # noqa: E402

FOCAL = synthetic.CAMERA.focal
TRUTH = solver.Unknowns(synthetic.PARENT_T_CAMERA, synthetic.CARRIER_T_BOARD)


def errors(pose):
    """(mm, degrees) from the truth."""
    difference = result.pose_difference(synthetic.PARENT_T_CAMERA, pose)
    return 1000 * numpy.linalg.norm(difference[:3]), math.degrees(numpy.linalg.norm(difference[3:]))


class Accuracy(unittest.TestCase):
    def test_exact_views_give_the_exact_pose(self):
        found = solver.solve(synthetic.observations(10, 1, sigma_px=0.0), FOCAL)
        self.assertLess(errors(found.unknowns.parent_T_camera)[0], 1e-3)
        board = result.pose_difference(synthetic.CARRIER_T_BOARD, found.unknowns.carrier_T_board)
        self.assertLess(numpy.abs(board).max(), 1e-6)

    def test_corners_that_are_off_by_a_third_of_a_pixel_give_a_pose_within_a_millimetre(self):
        for seed in (1, 2):
            with self.subTest(seed=seed):
                found = solver.solve(synthetic.observations(15, seed, sigma_px=0.3), FOCAL)
                off_mm, off_degrees = errors(found.unknowns.parent_T_camera)
                self.assertLess(off_mm, 1.0)
                self.assertLess(off_degrees, 0.1)
                self.assertAlmostEqual(0.3, found.scales.corner_px, delta=0.05)

    def test_the_errors_of_the_robot_are_estimated(self):
        found = solver.solve(synthetic.observations(25, 4, sigma_px=0.1, robot_m=0.002, robot_rad=0.003), FOCAL)
        self.assertTrue(0.0012 < found.scales.robot_m < 0.0028, found.scales)
        self.assertTrue(0.0018 < found.scales.robot_rad < 0.0042, found.scales)
        self.assertLess(errors(found.unknowns.parent_T_camera)[0], 3.0)

    def test_a_camera_on_the_hand_that_sees_a_board_on_the_table_is_the_same_problem(self):
        hand_T_camera = rd.transform((0.04, 0.01, 0.02), rd.rotation_of_rpy(0.1, -0.05, 1.6))
        base_T_board = rd.transform((0.7, 0.1, -0.1), rd.rotation_of_rpy(3.0, 0.1, 0.4))
        random, observations = numpy.random.default_rng(8), []
        for i in range(15):
            camera_T_board = synthetic.view_pose(random)
            base_T_hand = base_T_board @ rd.inverse(camera_T_board) @ rd.inverse(hand_T_camera)
            pixels = synthetic.CAMERA.project(synthetic.BOARD.points(), camera_T_board) + random.normal(0, 0.2, (54, 2))
            observations.append(solver.observe(f"view {i}", rd.inverse(base_T_hand), synthetic.BOARD.points(),
                                               synthetic.CAMERA.rays(pixels)))
        found = solver.solve(observations, FOCAL, "base").unknowns
        self.assertLess(1000 * numpy.linalg.norm((found.parent_T_camera - hand_T_camera)[:3, 3]), 1.0)
        self.assertLess(1000 * numpy.linalg.norm((found.carrier_T_board - base_T_board)[:3, 3]), 1.0)

    def test_the_refinement_is_nearer_to_the_truth_than_each_closed_form_on_average(self):
        refined, closed = [], {}
        for seed in range(3):
            found = solver.solve(synthetic.observations(12, seed, sigma_px=0.5), FOCAL)
            refined.append(errors(found.unknowns.parent_T_camera)[0])
            for name, unknowns in found.closed_forms.items():
                closed.setdefault(name, []).append(errors(unknowns.parent_T_camera)[0])
        self.assertGreaterEqual(len(closed), 5)
        for name, values in closed.items():
            with self.subTest(name):
                self.assertLess(numpy.mean(refined), numpy.mean(values))

    def test_the_said_uncertainty_is_that_of_the_errors(self):
        squares = []
        for seed in range(5):
            observations = synthetic.observations(10, 100 + seed, sigma_px=0.2, robot_m=0.001, robot_rad=0.001)
            found = result.calibrate_observations(observations, FOCAL)
            difference = result.pose_difference(synthetic.PARENT_T_CAMERA, found.parent_T_camera)
            squares.append((difference ** 2 / numpy.diag(found.covariance)).mean())
        self.assertTrue(0.25 < numpy.median(squares) < 3.0, squares)

    def test_derivatives_are_those_of_the_residuals(self):
        seen, step = synthetic.observations(1, 1)[0], 1e-6
        moved = solver.Unknowns(TRUTH.parent_T_camera @ rd.transform((0.01, 0, -0.01)), TRUTH.carrier_T_board)
        before, by_unknowns, by_carrier = solver.linearized(moved, seen, FOCAL)
        for column in range(6):
            values = numpy.zeros(6)
            values[column] = step
            small = rd.transform(values[:3], rd.rotation_about(numpy.eye(3)[column % 3], values[3:].sum()))
            changes = ((by_unknowns[:, column], solver.Unknowns(moved.parent_T_camera @ small,
                                                                moved.carrier_T_board), seen),
                       (by_unknowns[:, 6 + column], solver.Unknowns(moved.parent_T_camera,
                                                                    moved.carrier_T_board @ small),
                        seen), (by_carrier[:, column], moved,
                                solver.Observation(seen.name, seen.parent_T_carrier @ small, seen.points, seen.rays,
                                                   seen.camera_T_board)))
            for derivative, unknowns, observation in changes:
                numeric = (solver.residuals(unknowns, observation, FOCAL).ravel() - before) / step
                self.assertLess(numpy.abs(numeric - derivative).max(), 1e-3 * numpy.abs(derivative).max())


class WrongViews(unittest.TestCase):
    def test_views_with_a_wrong_pose_of_the_robot_are_left_out(self):
        observations = synthetic.observations(20, 5, sigma_px=0.2)
        random, wrong = numpy.random.default_rng(1), (3, 8, 9, 15)
        for i in wrong:
            seen = observations[i]
            pose = synthetic.disturbed(seen.parent_T_carrier, random, 0.03, 0.05)
            observations[i] = solver.Observation(seen.name, pose, seen.points, seen.rays, seen.camera_T_board)
        found = solver.solve(observations, FOCAL)
        self.assertEqual([i not in wrong for i in range(20)], found.used)
        self.assertLess(errors(found.unknowns.parent_T_camera)[0], 1.0)

    def test_a_wrong_corner_does_little_harm(self):
        observations = synthetic.observations(15, 6, sigma_px=0.2)
        for seen in observations[:5]:
            seen.rays[7] += 0.05  # 30 px
        self.assertLess(errors(solver.solve(observations, FOCAL).unknowns.parent_T_camera)[0], 1.0)

    def test_a_board_that_slips_is_refused(self):
        random = numpy.random.default_rng(2)
        observations = [
            synthetic.observation(f"view {i}", synthetic.view_pose(random), random, robot_m=0.06, robot_rad=0.3)
            for i in range(14)
        ]
        with self.assertRaisesRegex((solver.SolverError, motions.DegenerateError), "slip"):
            result.calibrate_observations(observations, FOCAL)


class Degenerate(unittest.TestCase):
    def refused(self, poses, text):
        random = numpy.random.default_rng(3)
        observations = [synthetic.observation(f"view {i}", pose, random) for i, pose in enumerate(poses)]
        with self.assertRaisesRegex(motions.DegenerateError, text):
            solver.solve(observations, FOCAL, "left_gripper")

    def test_too_few_views(self):
        random = numpy.random.default_rng(4)
        self.refused([synthetic.view_pose(random) for _ in range(7)], r"1 more views \(7 of 8\)")

    def test_translations_only(self):
        random = numpy.random.default_rng(5)
        self.refused([synthetic.view_pose(random, 0.01, axis=(0, 0, 1)) for _ in range(20)],
                     "rotate left_gripper: .* only shifted")

    def test_rotations_about_one_axis_only(self):
        random = numpy.random.default_rng(6)
        self.refused([synthetic.view_pose(random, 0.6, axis=(0, 1, 0)) for _ in range(20)],
                     "rotate left_gripper about its [xyz] axis too")


class Guidance(unittest.TestCase):
    def test_the_axis_that_is_missing_is_named(self):
        poses = [rd.transform((0, 0, 0.01 * i), rd.rotation_about((0, 0, 1), 0.2 * i)) for i in range(-6, 7)]
        poses += [
            pose @ rd.transform(rotation=rd.rotation_about((0, 1, 0), 0.05 * i)) for i, pose in enumerate(poses[:4])
        ]
        text = motions.missing(motions.diversity(poses), "left_gripper")[0]
        self.assertRegex(text, "rotate left_gripper about its x axis too: .*its z axis")

    def test_diverse_views_need_nothing(self):
        random = numpy.random.default_rng(7)
        poses = [synthetic.carrier_pose(synthetic.view_pose(random)) for _ in range(15)]
        pixels = [numpy.array([[0, 0], [639, 0], [639, 479], [0, 479]])]
        self.assertEqual([], motions.missing(motions.diversity(poses, pixels, (640, 480)), "left_gripper"))
        corner = [numpy.array([[0, 0], [100, 0], [100, 100], [0, 100]])]
        self.assertRegex(
            motions.missing(motions.diversity(poses, corner, (640, 480)), "left_gripper")[0],
            "other parts of the image")

    def test_views_that_are_alike_add_nothing(self):
        self.assertFalse(motions.is_new(rd.transform((0.01, 0, 0)), [numpy.eye(4)]))
        self.assertTrue(motions.is_new(rd.transform((0.1, 0, 0)), [numpy.eye(4)]))
        self.assertTrue(motions.is_new(rd.transform(rotation=rd.rotation_about((1, 0, 0), 0.3)), [numpy.eye(4)]))


if __name__ == "__main__":
    unittest.main()
