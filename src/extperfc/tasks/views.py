"""From where a robot sees what stands in a map: poses for its camera. Without ROS."""

import heapq
import math
from dataclasses import dataclass

import cv2
import numpy

OCCUPIED = 50         # cells of this value and above
STEP_M = 0.2          # between positions that are tried
YAWS = 24             # directions that are tried at each
TARGET_M = 0.1        # obstacles are counted in squares of this side
LINE_POINTS = 8       # checked between robot and obstacle


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
        return (int((y - self.origin[1]) / self.resolution_m), int((x - self.origin[0]) / self.resolution_m))

    def middle_of(self, row, column):
        return (self.origin[0] + (column + 0.5) * self.resolution_m, self.origin[1] + (row + 0.5) * self.resolution_m)


def standing_places(grid, robot, pass_m, stand_m):
    """(passable cells of a grid of STEP_M, the robot's cell in it, {cell: (x, y)} of places): places where the base may stand
    in any direction, with stand_m to the next obstacle, and that it reaches from `robot` (x, y) with pass_m on its path."""
    free = ((grid.cells >= 0) & (grid.cells < OCCUPIED)).astype(numpy.uint8)
    clearance_m = cv2.distanceTransform(numpy.pad(free, 1), cv2.DIST_L2, 5)[1:-1, 1:-1] * grid.resolution_m
    stride = max(1, round(STEP_M / grid.resolution_m))
    coarse = clearance_m[stride // 2::stride, stride // 2::stride]
    start = tuple(index // stride for index in grid.cell_of(*robot))
    travel = travel_m(coarse >= pass_m, start, stride * grid.resolution_m)
    rows, columns = numpy.nonzero((coarse >= stand_m) & numpy.isfinite(travel))
    places = {(int(r), int(c)): grid.middle_of(r * stride + stride // 2, c * stride + stride // 2) for r, c in zip(rows, columns)}
    return coarse >= pass_m, start, places


def travel_m(passable, start, step_m):
    """Distance of travel from a cell to every other over passable ones, eight neighbours; infinite: out of reach. The start
    counts as passable; one outside of the grid reaches nothing."""
    distance = numpy.full(passable.shape, numpy.inf)
    if not (0 <= start[0] < passable.shape[0] and 0 <= start[1] < passable.shape[1]):
        return distance
    distance[start] = 0.0
    queue = [(0.0, start)]
    while queue:
        far, (row, column) = heapq.heappop(queue)
        if far > distance[row, column]:
            continue
        for dr in (-1, 0, 1):
            for dc in (-1, 0, 1):
                r, c = row + dr, column + dc
                if not (0 <= r < passable.shape[0] and 0 <= c < passable.shape[1] and passable[r, c]):
                    continue
                there = far + step_m * math.hypot(dr, dc)
                if there < distance[r, c]:
                    distance[r, c] = there
                    heapq.heappush(queue, (there, (r, c)))
    return distance


def targets_of(grid):
    """Middles (x, y) of the squares of TARGET_M with an occupied cell beside a free one: N x 2."""
    free = ((grid.cells >= 0) & (grid.cells < OCCUPIED)).astype(numpy.uint8)
    border = (grid.cells >= OCCUPIED) & (cv2.dilate(free, numpy.ones((3, 3), numpy.uint8)) > 0)
    rows, columns = numpy.nonzero(border)
    points = numpy.column_stack(grid.middle_of(rows, columns))
    squares = numpy.unique(numpy.floor(points / TARGET_M).astype(int), axis=0) if len(points) else numpy.zeros((0, 2), int)
    return (squares + 0.5) * TARGET_M


def seen_from(grid, place, targets, camera):
    """For each of YAWS directions the indices of the targets that the camera sees from a place."""
    offset = targets - place
    distance = numpy.hypot(*offset.T)
    near = numpy.nonzero((distance >= camera.near_m) & (distance <= camera.far_m))[0]
    near = [index for index in near if is_line_free(grid, place, targets[index])]
    bearing = numpy.arctan2(offset[near, 1], offset[near, 0])
    yaws = -math.pi + numpy.arange(YAWS) * 2 * math.pi / YAWS
    off = numpy.abs(numpy.angle(numpy.exp(1j * (bearing[None, :] - yaws[:, None]))))
    return yaws, [{near[i] for i in numpy.nonzero(row <= camera.half_angle_rad)[0]} for row in off]


def is_line_free(grid, start, end):
    """Whether no occupied cell lies between, except near the end."""
    for part in numpy.linspace(0.1, 0.85, LINE_POINTS):
        row, column = grid.cell_of(*(start + part * (numpy.asarray(end) - start)))
        if grid.cells[row, column] >= OCCUPIED:
            return False
    return True


def viewpoints(grid, robot, camera=Camera(), pass_m=0.42, stand_m=0.62, min_new=4):
    """Poses (x, y, yaw) from which together the camera sees nearly all obstacles that border on free space, in the order in
    which the robot at (x, y) shall visit them: greedy cover, then always the nearest by travel. A pose that shows fewer than
    min_new squares of TARGET_M that no other shows is left out."""
    passable, start, places = standing_places(grid, robot, pass_m, stand_m)
    targets = targets_of(grid)
    sets = {}
    for place, position in places.items():
        yaws, seen = seen_from(grid, numpy.array(position), targets, camera)
        sets.update({(place, float(yaw)): indices for yaw, indices in zip(yaws, seen) if len(indices) >= min_new})
    chosen = cover(sets, min_new)
    return [(*places[place], yaw) for place, yaw in in_order(chosen, passable, start)]


def cover(sets, min_new):
    """Keys of sets, the one with most elements that are not covered yet first, until none adds min_new."""
    left, chosen = {key: set(members) for key, members in sets.items()}, []
    while left:
        best = max(left, key=lambda key: len(left[key]))
        new = left.pop(best)
        if len(new) < min_new:
            break
        chosen.append(best)
        left = {key: members - new for key, members in left.items()}
        left = {key: members for key, members in left.items() if len(members) >= min_new}
    return chosen


def in_order(chosen, passable, start):
    """(place, yaw) pairs, always the one that is nearest by travel to the one before."""
    left, ordered = list(chosen), []
    while left:
        distance = travel_m(passable, start, 1.0)
        nearest = min(left, key=lambda one: distance[one[0]])
        left.remove(nearest)
        ordered.append(nearest)
        start = nearest[0]
    return ordered
