"""Views of a camera that together show what stands in a map."""

import itertools
import math
import pathlib
import sys
import unittest

import numpy

REPO = pathlib.Path(__file__).resolve().parents[3]
sys.path.insert(0, str(REPO / "src"))

try:
    from extperfc.tasks import tops, views
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


def tour(grid, robot=(0.0, 0.0), tops=frozenset(), reach=lambda pose: True):
    """(all views in turn, until nothing is left, the Views)."""
    views_, found = views.Views(), []
    while True:
        view = views_.next(grid, robot, tops)
        if view is None:
            return found, views_
        found.append(view)
        if reach(view.pose):
            views_.done(view)
            robot = view.pose[:2]
        else:
            views_.refuse(view)


def is_in(square, x0, y0, x1, y1):
    x, y = ((index + 0.5) * views.SQUARE_M for index in square)
    return x0 < x < x1 and y0 < y < y1


class RoomWithATable(unittest.TestCase):
    def setUp(self):
        self.grid = room()
        self.found, self.views = tour(self.grid)

    def test_they_show_nearly_everything_that_the_robot_can_reach(self):
        squares = [one for one in views.borders_of(self.grid) if one[0] * views.SQUARE_M < 3.4]
        seen = [one for one in squares if one in self.views.looked]
        self.assertGreater(len(seen), 0.85 * len(squares), f"of {len(squares)}")
        table = [one for one in squares if is_in(one, 1.6, -0.4, 2.4, 0.4)]
        self.assertTrue(table)
        self.assertEqual([], [one for one in table if one not in self.views.looked])

    def test_what_a_view_shows_is_before_the_camera_and_new(self):
        before, camera = set(), self.views.camera
        for view in self.found:
            self.assertGreaterEqual(len(view.squares), self.views.min_new)
            self.assertFalse(view.squares & before)
            before |= view.squares
            for i, j in view.squares:
                dx, dy = (i + 0.5) * views.SQUARE_M - view.pose[0], (j + 0.5) * views.SQUARE_M - view.pose[1]
                self.assertTrue(camera.near_m <= math.hypot(dx, dy) <= camera.far_m)
                self.assertLessEqual(abs(math.remainder(math.atan2(dy, dx) - view.pose[2], 2 * math.pi)), camera.half_angle_rad)

    def test_the_robot_fits_at_each_and_can_come_there(self):
        for x, y, _ in (view.pose for view in self.found):
            self.assertLess(x, 3.5 - 0.6, "the other room has no door")
            row, column = self.grid.cell_of(x, y)
            square = self.grid.cells[row - 8:row + 8, column - 8:column + 8]
            self.assertFalse((square >= 50).any(), (x, y))

    def test_their_order_is_a_path_not_a_zigzag(self):
        poses = [view.pose for view in self.found]
        travelled = sum(math.dist(a[:2], b[:2]) for a, b in zip(poses, poses[1:]))
        by_hazard = sorted(poses, key=lambda pose: math.sin(1000 * pose[0] + 77 * pose[1] + pose[2]))
        self.assertLess(travelled, 0.8 * sum(math.dist(a[:2], b[:2]) for a, b in zip(by_hazard, by_hazard[1:])))

    def test_the_nearest_first(self):
        self.assertLess(math.dist(self.found[0].pose[:2], (0.0, 0.0)), 1.0)

    def test_a_robot_in_a_narrow_place_gets_out_of_it(self):
        fill(self.grid, -0.95, -1.35, -0.1, -1.25)  # a niche of 0.6 m, open to one side
        view = views.Views().next(self.grid, (-0.3, -1.65))
        self.assertIsNotNone(view)
        fill(self.grid, -0.1, -1.95, 0.0, -1.25)    # closed: no path through its wall, however near the room is
        self.assertIsNone(views.Views().next(self.grid, (-0.3, -1.65)))

    def test_a_passage_between_two_points_of_the_places_is_seen(self):
        """0.9 m wide, wherever it lies; and one of half of that is none."""
        for shift_m in numpy.arange(0.0, 0.2, 0.05):
            for width_m, leads in ((0.9, True), (0.45, False)):
                grid = room()
                fill(grid, 0.5, -2.0, 0.6, -1.5 + shift_m)
                fill(grid, 0.5, -1.5 + shift_m + width_m, 0.6, 2.0)
                beyond = [place for _, place in views.standing_places(grid, (-0.2, 0.0), 0.42, 0.62) if place[0] > 0.6]
                self.assertEqual(leads, bool(beyond), (shift_m, width_m))

    def test_another_view_when_one_is_out_of_reach(self):
        found, of = tour(self.grid, reach=lambda pose: pose[1] > -0.6)
        refused = [view.pose for view in found if view.pose[1] <= -0.6]
        self.assertTrue(refused)
        for a, b in itertools.combinations(refused, 2):
            self.assertGreater(math.dist(a[:2], b[:2]), 0.2)
        self.assertTrue(of.looked)


class Tables(unittest.TestCase):
    """A table that the map shows by a leg alone: its top is known from elsewhere."""

    def setUp(self):
        self.grid = views.Grid(numpy.zeros((120, 120), numpy.int8), 0.05, (-3.0, -3.0))
        self.grid.cells[[0, -1], :] = self.grid.cells[:, [0, -1]] = 100
        fill(self.grid, 1.0, -0.4, 1.1, -0.3)
        self.top = {(i, j) for i in range(10, 20) for j in range(-4, 4)}  # 1.0 m x 0.8 m

    def test_all_of_it_is_seen_and_before_the_walls(self):
        found, of = tour(self.grid, tops=self.top)
        self.assertEqual(set(), self.top - of.looked)
        last_of_top = max(index for index, view in enumerate(found) if view.squares & self.top)
        self.assertLess(last_of_top, 8, "tables come first")
        self.assertGreater(len(found), 12)

    def test_the_robot_does_not_stand_under_it(self):
        for view in tour(self.grid, tops=self.top)[0]:
            self.assertFalse(is_in([v / views.SQUARE_M - 0.5 for v in view.pose[:2]], 0.5, -0.9, 2.5, 0.9), view.pose)

    def test_a_wall_hides_a_table_and_its_own_edge_does_not(self):
        fill(self.grid, 1.0, -0.4, 1.05, 0.4)  # the lidar saw the edge
        self.assertEqual(set(), self.top - tour(self.grid, tops=self.top)[1].looked)
        fill(self.grid, 0.5, -3.0, 0.6, 3.0)
        self.assertFalse(tour(self.grid, tops=self.top)[1].looked & self.top)


class Nothing(unittest.TestCase):
    def test_maps_in_which_nothing_can_be_seen(self):
        unknown = views.Grid(numpy.full((40, 60), -1, numpy.int8), 0.05, (0.0, 0.0))
        self.assertIsNone(views.Views().next(unknown, (1.0, 1.0)))
        free = views.Grid(numpy.zeros((40, 60), numpy.int8), 0.05, (0.0, 0.0))
        self.assertIsNone(views.Views().next(free, (1.0, 1.0)))
        self.assertIsNone(views.Views().next(room(), (50.0, 50.0)), "the robot is not in the map")


class SeenByTheLidar(unittest.TestCase):
    """Tops: what lies in one plane at the height of tables."""

    def setUp(self):
        self.tops = tops.Tops()

    def grid_of(self, x0, x1, y0, y1, z, step=0.04):
        x, y = numpy.meshgrid(numpy.arange(x0, x1, step), numpy.arange(y0, y1, step))
        return numpy.column_stack([x.ravel(), y.ravel(), numpy.full(x.size, z)])

    def test_a_table_is_a_top_and_a_wall_is_none(self):
        rng = numpy.random.default_rng(3)
        table = self.grid_of(1.0, 1.8, -0.5, 0.5, 0.68)
        wall = numpy.vstack([self.grid_of(3.0, 3.05, -2, 2, z) for z in (0.4, 0.5, 0.6, 0.7, 0.9)])
        for _ in range(3):
            points = numpy.vstack([table, wall, self.grid_of(-3, 3, -3, 3, 0.0), [[numpy.nan] * 3]])
            self.tops.add(points + rng.normal(0, 0.01, points.shape))
        found = self.tops.squares()
        inside = {(i, j) for i in range(10, 18) for j in range(-5, 5)}
        self.assertLess(len(inside - found), 4)
        self.assertTrue(all(0.85 < (i + 0.5) * views.SQUARE_M < 1.95 for i, _ in found), found)

    def test_a_square_alone_is_no_table(self):
        self.tops.add(self.grid_of(1.01, 1.09, 0.01, 0.09, 0.7, 0.02))
        self.assertEqual(set(), self.tops.squares())

    def test_what_turns_out_to_be_a_wall_is_no_top_any_more(self):
        self.tops.add(self.grid_of(1.0, 1.3, 0.0, 0.3, 0.5))
        self.assertTrue(self.tops.squares())
        self.tops.add(self.grid_of(1.0, 1.3, 0.0, 0.3, 1.0))
        self.assertEqual(set(), self.tops.squares())

    def test_no_points(self):
        self.tops.add(numpy.zeros((0, 3)))
        self.tops.add(numpy.full((5, 3), numpy.nan))
        self.assertEqual(set(), self.tops.squares())


if __name__ == "__main__":
    unittest.main()
