"""The surface below an object, in points of a depth camera."""

import pathlib
import sys
import types
import unittest
from unittest import mock

import numpy

REPO = pathlib.Path(__file__).resolve().parents[3]
sys.path.insert(0, str(REPO / "src"))

try:
    from py_trees.common import Status

    from extperfc.tasks import search, support
except ModuleNotFoundError as error:
    raise unittest.SkipTest(f"{error.name} is not installed: tools/setup fetches it") from None


def plane(x0, x1, y0, y1, z, step=0.01):
    x, y = numpy.meshgrid(numpy.arange(x0, x1, step), numpy.arange(y0, y1, step))
    return numpy.column_stack([x.ravel(), y.ravel(), numpy.full(x.size, z)])


class Surface(unittest.TestCase):
    """A table of 0.5 x 0.8 m with a cube of 45 mm; the floor, and a shelf beside it."""

    def setUp(self):
        rng = numpy.random.default_rng(4)
        table = plane(0.6, 1.1, -0.4, 0.4, 0.70)
        table = table[numpy.abs(table[:, :2] - (0.75, 0.1)).max(axis=1) > 0.025]
        cube = numpy.vstack([plane(0.73, 0.775, 0.08, 0.125, 0.745, 0.003)])
        self.points = numpy.vstack([table, cube, plane(0.3, 1.5, -1, 1, 0.0), plane(0.9, 1.1, 0.2, 0.4, 0.55)])
        self.points = self.points + rng.normal(0, 0.002, self.points.shape)
        self.place = numpy.array([0.75, 0.1, 0.7225])

    def test_it_is_where_the_table_is_and_a_little_lower(self):
        size, middle = support.surface_below(self.points, self.place)
        numpy.testing.assert_allclose((0.5, 0.8, support.THICK_M), size, atol=0.03)
        numpy.testing.assert_allclose((0.85, 0.0), middle[:2], atol=0.02)
        top = middle[2] + size[2] / 2
        self.assertTrue(0.692 < top < 0.700, top)

    def test_it_ends_where_nothing_is_seen(self):
        size, middle = support.surface_below(self.points[self.points[:, 1] < 0.2], self.place)
        self.assertAlmostEqual(0.2, middle[1] + size[1] / 2, delta=0.02)

    def test_no_surface_is_an_error_that_names_the_place(self):
        with self.assertRaisesRegex(ValueError, r"no surface is seen below \(0.75, 0.10, 0.72\), but 0 points"):
            support.surface_below(self.points[self.points[:, 2] < 0.3], self.place)
        with self.assertRaises(ValueError):
            support.surface_below(numpy.zeros((0, 3)), self.place)


class Points(unittest.TestCase):
    def test_pixels_lie_where_the_camera_sees_them(self):
        depth = numpy.zeros((480, 640), numpy.uint16)
        depth[240, 321], depth[30, 300] = 1500, 1000
        found = support.points_of(depth, types.SimpleNamespace(K=(600.0, 0, 321.0, 0, 500.0, 240.0, 0, 0, 1)))
        numpy.testing.assert_allclose([[-21 / 600, -210 / 500, 1.0], [0, 0, 1.5]], found, atol=1e-9)


class Leaf(unittest.TestCase):
    def setUp(self):
        self.seconds, self.boxes = 10.0, []
        base_T_map = numpy.eye(4)
        base_T_map[:3, 3] = (-2.0, 0.0, 0.0)
        self.removed = []
        scene = types.SimpleNamespace(add_box=lambda *arguments: self.boxes.append(arguments), remove=self.removed.append,
                                      objects={"support": 1, "support_0": 1, "support_1": 1, "cube_1": 1})
        self.addCleanup(search.Lidar._of.clear)
        frames = types.SimpleNamespace(matrix=lambda target, source, wait_s: base_T_map)
        for patched in (mock.patch.object(support, "scene", lambda: scene),
                        mock.patch.object(support.robot_state, "frames", lambda: frames),
                        mock.patch.object(support.rospy.Time, "now", lambda: support.rospy.Time.from_sec(self.seconds)),
                        mock.patch.object(support.SeeSupport, "_seen", lambda leaf: plane(0.5, 1.1, -0.4, 0.4, 0.7))):
            patched.start()
            self.addCleanup(patched.stop)

    def test_it_adds_one_box_and_waits_for_the_arm_node(self):
        leaf = support.SeeSupport((2.8, 0.0, 0.72), "map")
        for _ in range(30):
            leaf.tick_once()
            if leaf.status != Status.RUNNING:
                break
            self.seconds += 0.1
        self.assertEqual(Status.SUCCESS, leaf.status)
        self.assertGreaterEqual(self.seconds, 12.0)
        (name, size, middle, frame), = self.boxes
        self.assertEqual(("support", "base_footprint"), (name, frame))
        self.assertAlmostEqual(0.8, middle[0], delta=0.02)
        self.assertEqual(["support_0", "support_1"], self.removed)

    def test_what_the_lidar_saw_of_the_table_beside_the_image_is_added_at_its_height(self):
        """In the map the table reaches from y = -0.4 to 1.5, and the image shows it to 0.4; a lower table is beside it, another one 1 m away from it."""
        legs = {(25, -4), (30, 14), (30, -4)}
        heights = {(i, j): 0.7 for i in range(25, 31) for j in range(-4, 15) if (i, j) not in {(27, 10), (28, 11), *legs}}
        beside = {(i, j): 0.6 for i in range(31, 35) for j in range(-4, 15)}
        away = {(i, j): 0.7 for i in range(25, 31) for j in range(25, 30)}
        search.Lidar._of["map"] = types.SimpleNamespace(heights=lambda: {**heights, **beside, **away})
        support.SeeSupport((2.8, 0.0, 0.72), "map").tick_once()
        (_, _, middle, _), *rest = self.boxes
        self.assertEqual({f"support_{number}" for number in range(len(rest))}, {name for name, *_ in rest})
        self.assertEqual({"map"}, {frame for *_, frame in rest})
        covered = sum(size[0] * size[1] for _, size, _, _ in rest)
        self.assertAlmostEqual(0.6 * 1.1, covered, delta=0.05)
        for _, size, at, _ in rest:
            self.assertTrue(0.35 < at[1] < 1.5, at)
            self.assertAlmostEqual(middle[2], at[2])

    def test_without_a_surface_it_fails(self):
        leaf = support.SeeSupport((4.8, 0.0, 0.72), "map")
        leaf.tick_once()
        self.assertEqual((Status.FAILURE, []), (leaf.status, self.boxes))
        self.assertIn("no surface is seen below (2.80, 0.00, 0.72)", leaf.feedback_message)


if __name__ == "__main__":
    unittest.main()
