"""From where a robot sees what stands in a map and on tables: poses for its camera. Without ROS."""

import heapq
import math
from dataclasses import dataclass

import cv2
import numpy

OCCUPIED = 50         # cells of this value and above
STEP_M = 0.2          # between positions that are tried
YAWS = 24             # directions that are tried at each
SQUARE_M = 0.1        # obstacles and tables are counted in squares of this side
TOP_WEIGHT = 3.0      # of a square of a table, of an obstacle's border: 1
LOOK_M = 1.0          # what a look costs, as metres of travel
LINE_PARTS = numpy.linspace(0.1, 0.85, 8)  # of the line from robot to square: where it is checked
TIGHT = 0.75          # of the clearance that a path shall have: less is not passable; the navigator has the last word
TIGHT_COSTS = 4.0     # metres of travel that are as bad as one in such a place
START_M = 0.8         # from a robot to the next place where its path may lead
REFUSED_M = 0.25      # places as near to one that could not be reached are not tried

NEIGHBOURS = [(dr, dc, math.hypot(dr, dc)) for dr in (-1, 0, 1) for dc in (-1, 0, 1) if dr or dc]  # of a cell: offsets, distance


@dataclass(frozen=True)
class Camera:
    """What a camera of the robot sees well, in the plane: obstacles at these distances from the base's middle."""
    near_m: float = 0.6
    far_m: float = 1.25
    half_angle_rad: float = 0.4


@dataclass(frozen=True)
class Grid:
    """cells[y, x] as in nav_msgs/OccupancyGrid (-1 unknown, 0 free to 100 occupied); origin: corner of the first cell [m]."""
    cells: numpy.ndarray
    resolution_m: float
    origin: tuple

    def cell_of(self, x, y):
        return (math.floor((y - self.origin[1]) / self.resolution_m), math.floor((x - self.origin[0]) / self.resolution_m))

    def middle_of(self, row, column):
        return (self.origin[0] + (column + 0.5) * self.resolution_m, self.origin[1] + (row + 0.5) * self.resolution_m)


@dataclass(frozen=True)
class View:
    """pose: (x, y, yaw) of the base; squares: {(i, j)} that the camera sees from there and has not seen before."""
    pose: tuple
    squares: frozenset


class Views:
    """Chooses where to look from next: much that was not seen yet, a short drive.

    pass_m and stand_m: from the base's middle to the next obstacle, on its path and where it stands in any direction. A view
    that shows fewer than min_new new squares is not worth a drive.
    """

    def __init__(self, camera=Camera(), pass_m=0.42, stand_m=0.62, min_new=4):
        self.camera, self.pass_m, self.stand_m, self.min_new = camera, pass_m, stand_m, min_new
        self.looked, self._refused = set(), []

    def next(self, grid, robot, tops=frozenset()):
        """The best View for a robot at (x, y), None: nothing is left. tops: squares of tables, into which the base may not
        drive, and over which the camera looks."""
        tops = frozenset(tops)
        squares = sorted((borders_of(grid) | tops) - self.looked)
        places = self._places(grid, robot, tops)
        if not squares or not places:
            return None
        weights = numpy.array([TOP_WEIGHT if square in tops else 1.0 for square in squares])
        middles = (numpy.array(squares) + 0.5) * SQUARE_M
        sight = with_squares(grid, [near for one in tops for near in (one, *around(one))], 0)
        best, best_value = None, 0.0
        for bound, travel, place in self._by_bound(places, middles, weights):
            if bound <= best_value:
                break
            yaw, seen = best_direction(sight, place, middles, weights, self.camera)
            value = weights[seen].sum() / (travel + LOOK_M)
            if len(seen) >= self.min_new and value > best_value:
                best, best_value = View((*place, yaw), frozenset(squares[index] for index in seen)), value
        return best

    def done(self, view):
        """The robot has looked."""
        self.looked |= view.squares

    def refuse(self, view):
        """The robot does not get there."""
        self._refused.append(view.pose[:2])

    def _places(self, grid, robot, tops):
        """[(travel [m], (x, y))] of places where the base may stand."""
        found = standing_places(with_squares(grid, tops, 100), robot, self.pass_m, self.stand_m)
        return [one for one in found if all(math.dist(one[1], refused) > REFUSED_M for refused in self._refused)]

    def _by_bound(self, places, middles, weights):
        """[(more than the value of any view from there, travel, place)], the greatest first."""
        bounds = []
        for travel, place in places:
            near = numpy.abs(middles - place).max(axis=1) <= self.camera.far_m
            bounds.append((weights[near].sum() / (travel + LOOK_M), travel, place))
        return sorted(bounds, reverse=True)


def around(square):
    i, j = square
    return [(i + di, j + dj) for di in (-1, 0, 1) for dj in (-1, 0, 1) if di or dj]


def with_squares(grid, squares, value):
    """A copy of a grid in which the cells of squares have a value."""
    cells = grid.cells.copy()
    for i, j in squares:
        (r0, c0), (r1, c1) = grid.cell_of(i * SQUARE_M, j * SQUARE_M), grid.cell_of((i + 1) * SQUARE_M, (j + 1) * SQUARE_M)
        cells[max(0, r0):max(0, r1 + 1), max(0, c0):max(0, c1 + 1)] = value
    return Grid(cells, grid.resolution_m, grid.origin)


def standing_places(grid, robot, pass_m, stand_m):
    """[(travel [m], (x, y))] of places on a grid of STEP_M where the base may stand in any direction, with stand_m to the
    next obstacle, and that it reaches from `robot` (x, y) with pass_m on its path, or less where no other path leads there."""
    free = ((grid.cells >= 0) & (grid.cells < OCCUPIED)).astype(numpy.uint8)
    clearance_m = cv2.distanceTransform(numpy.pad(free, 1), cv2.DIST_L2, 5)[1:-1, 1:-1] * grid.resolution_m
    stride = max(1, round(STEP_M / grid.resolution_m))
    widest_m, step_m = block_maxima(clearance_m, stride), stride * grid.resolution_m
    robot_cell = grid.cell_of(*robot)
    costs = numpy.where(widest_m >= pass_m, 1.0, numpy.where(widest_m >= TIGHT * pass_m, TIGHT_COSTS, numpy.inf))
    start = nearest_passable(free, costs, robot_cell, stride, grid.resolution_m)
    travel = travel_m(costs, start, step_m)
    stand = clearance_m[stride // 2::stride, stride // 2::stride] >= stand_m
    rows, columns = numpy.nonzero(stand & numpy.isfinite(travel[:stand.shape[0], :stand.shape[1]]))
    return [(float(travel[r, c]), grid.middle_of(int(r) * stride + stride // 2, int(c) * stride + stride // 2))
            for r, c in zip(rows, columns)]


def block_maxima(values, size):
    """The maximum of each block of size x size cells: a passage between two of a grid's points is not missed. No path leads through a
    wall, where size cells are narrower than the clearance that a path needs."""
    rows, columns = (-(-length // size) for length in values.shape)
    padded = numpy.zeros((rows * size, columns * size), values.dtype)
    padded[:values.shape[0], :values.shape[1]] = values
    return padded.reshape(rows, size, columns, size).max(axis=(1, 3))


def nearest_passable(free, costs, robot, stride, resolution_m):
    """The nearest block of stride x stride cells where a path may lead, for a robot in the cell `robot` that stands nearer to an obstacle
    than that, or beside what it does not know: over free cells, at most START_M away; else the robot's own block."""
    reach = math.ceil(START_M / resolution_m)
    first = [max(0, index - reach) for index in robot]
    window = free[first[0]:robot[0] + reach + 1, first[1]:robot[1] + reach + 1]
    travel = travel_m(numpy.where(window > 0, 1.0, numpy.inf), tuple(numpy.subtract(robot, first)), resolution_m)
    rows, columns = numpy.indices(window.shape)
    travel[numpy.isinf(costs[(rows + first[0]) // stride, (columns + first[1]) // stride])] = numpy.inf
    found = travel.size and travel.min() <= START_M
    cell = numpy.add(first, numpy.unravel_index(numpy.argmin(travel), travel.shape)) if found else robot
    return tuple(int(index) // stride for index in cell)


def travel_m(costs, start, step_m):
    """Distance of travel from a cell to every other, eight neighbours, times the cost of each cell that is entered; infinite: out of
    reach. The start counts as passable; one outside of the grid reaches nothing."""
    distance = numpy.full(costs.shape, numpy.inf)
    rows, columns = costs.shape
    if not (0 <= start[0] < rows and 0 <= start[1] < columns):
        return distance
    costs, distance = costs.tolist(), distance.tolist()  # single cells of arrays are slow
    distance[start[0]][start[1]] = 0.0
    queue = [(0.0, *start)]
    while queue:
        far, row, column = heapq.heappop(queue)
        if far > distance[row][column]:
            continue
        for dr, dc, length in NEIGHBOURS:
            r, c = row + dr, column + dc
            if not (0 <= r < rows and 0 <= c < columns):
                continue
            there = far + step_m * length * costs[r][c]
            if there < distance[r][c]:
                distance[r][c] = there
                heapq.heappush(queue, (there, r, c))
    return numpy.array(distance)


def borders_of(grid):
    """{(i, j)}: squares with an occupied cell beside a free one."""
    free = ((grid.cells >= 0) & (grid.cells < OCCUPIED)).astype(numpy.uint8)
    border = (grid.cells >= OCCUPIED) & (cv2.dilate(free, numpy.ones((3, 3), numpy.uint8)) > 0)
    rows, columns = numpy.nonzero(border)
    points = numpy.column_stack(grid.middle_of(rows, columns))
    return set(map(tuple, numpy.floor(points / SQUARE_M).astype(int).tolist()))


def best_direction(grid, place, middles, weights, camera):
    """(yaw, indices of the squares that the camera sees from a place in that direction), of YAWS directions the best."""
    offset = middles - place
    distance = numpy.hypot(*offset.T)
    near = numpy.nonzero((distance >= camera.near_m) & (distance <= camera.far_m))[0]
    near = near[are_lines_free(grid, place, middles[near])]
    bearing = numpy.arctan2(offset[near, 1], offset[near, 0])
    yaws = -math.pi + numpy.arange(YAWS) * 2 * math.pi / YAWS
    seen = numpy.abs(numpy.angle(numpy.exp(1j * (bearing[None, :] - yaws[:, None])))) <= camera.half_angle_rad
    best = int(numpy.argmax(seen @ weights[near]))
    return float(yaws[best]), near[seen[best]]


def are_lines_free(grid, start, ends):
    """Whether no occupied cell lies between a point and each of N x 2 others, except near these."""
    points = start + LINE_PARTS[None, :, None] * (ends[:, None, :] - numpy.asarray(start))
    columns, rows = (((points - grid.origin) / grid.resolution_m).astype(int)).transpose(2, 0, 1)
    return (grid.cells[numpy.clip(rows, 0, grid.cells.shape[0] - 1), numpy.clip(columns, 0, grid.cells.shape[1] - 1)]
            < OCCUPIED).all(axis=1)
