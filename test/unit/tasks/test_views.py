"""Views of a camera that together show what stands in a map."""

import math
import pathlib
import sys
import unittest

import numpy

REPO = pathlib.Path(__file__).resolve().parents[3]
sys.path.insert(0, str(REPO / "src"))

try:
    from extperfc.tasks import views
except ModuleNotFoundError as error:
    raise unittest.SkipTest(f"{error.name} is not installed: tools/setup fetches it") from None


def room(width_m=6.0, depth_m=4.0, resolution_m=0.05):
    """A room with walls, a table in its middle, and a second room behind a wall without a door; its corner is at (-1, -2)."""
    cells = numpy.zeros((round(depth_m / resolution_m), round(width_m / resolution_m)), numpy.int8)
    cells[[0, -1], :] = 100
    cells[:, [0, -1]] = 100
    grid = views.Grid(cells, resolution_m, (-1.0, -2.0))
    fill(grid, 1.7, -0.3, 2.3, 0.3)
    fill(grid, 3.5, -2.0, 3.6, 2.0)
    return grid


def fill(grid, x0, y0, x1, y1):
    (r0, c0), (r1, c1) = grid.cell_of(x0, y0), grid.cell_of(x1, y1)
    grid.cells[r0:r1, c0:c1] = 100


def is_seen(target, pose, camera):
    distance = math.hypot(target[0] - pose[0], target[1] - pose[1])
    bearing = math.remainder(math.atan2(target[1] - pose[1], target[0] - pose[0]) - pose[2], 2 * math.pi)
    return camera.near_m <= distance <= camera.far_m and abs(bearing) <= camera.half_angle_rad


class Views(unittest.TestCase):
    def setUp(self):
        self.grid, self.camera = room(), views.Camera()
        self.poses = views.viewpoints(self.grid, (0.0, 0.0), self.camera)

    def test_they_show_nearly_everything_that_the_robot_can_reach(self):
        targets = [t for t in views.targets_of(self.grid) if t[0] < 3.45]
        seen = [t for t in targets if any(is_seen(t, pose, self.camera) for pose in self.poses)]
        self.assertGreater(len(seen), 0.85 * len(targets), f"of {len(targets)}")
        table = [t for t in targets if 1.6 < t[0] < 2.4 and -0.4 < t[1] < 0.4]
        self.assertTrue(table)
        for target in table:
            self.assertTrue(any(is_seen(target, pose, self.camera) for pose in self.poses), target)

    def test_the_robot_fits_at_each_and_can_come_there(self):
        for x, y, _ in self.poses:
            self.assertLess(x, 3.5 - 0.6, "the other room has no door")
            row, column = self.grid.cell_of(x, y)
            around = 12
            square = self.grid.cells[row - around + 4:row + around - 4, column - around + 4:column + around - 4]
            self.assertFalse((square >= 50).any(), (x, y))

    def test_their_order_is_a_path_not_a_zigzag(self):
        travelled = sum(math.dist(a[:2], b[:2]) for a, b in zip(self.poses, self.poses[1:]))
        by_hazard = sorted(self.poses, key=lambda pose: math.sin(1000 * pose[0] + 77 * pose[1] + pose[2]))
        self.assertLess(travelled, 0.7 * sum(math.dist(a[:2], b[:2]) for a, b in zip(by_hazard, by_hazard[1:])))

    def test_maps_in_which_nothing_can_be_seen(self):
        unknown = views.Grid(numpy.full((40, 60), -1, numpy.int8), 0.05, (0.0, 0.0))
        self.assertEqual([], views.viewpoints(unknown, (1.0, 1.0)))
        free = views.Grid(numpy.zeros((40, 60), numpy.int8), 0.05, (0.0, 0.0))
        self.assertEqual([], views.viewpoints(free, (1.0, 1.0)))
        self.assertEqual([], views.viewpoints(self.grid, (50.0, 50.0)), "the robot is not in the map")

    def test_the_nearest_first(self):
        first = self.poses[0]
        self.assertLess(math.dist(first[:2], (0.0, 0.0)), 1.0)


class Cover(unittest.TestCase):
    def test_the_largest_sets_that_add_something(self):
        sets = {"a": {1, 2, 3, 4}, "b": {3, 4, 5}, "c": {5, 6, 7}, "d": {4, 5}}
        self.assertEqual(["a", "c"], views.cover(sets, 2))
        self.assertEqual([], views.cover({}, 1))


if __name__ == "__main__":
    unittest.main()
