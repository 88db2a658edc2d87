"""Where tables are, by the points of a lidar that looks at them from below or from above. Without ROS."""

import collections
import math

import cv2
import numpy

from extperfc.tasks.heights import Heights, runs
from extperfc.tasks.views import SQUARE_M, around

LOW_M, HIGH_M = 0.35, 1.2    # heights of table tops above the floor
FLAT_M = 0.08                # a square whose points at such heights differ by more is a wall, a leg, the side of a cabinet
MIN_POINTS = 3               # of a square
MIN_NEIGHBOURS = 2           # of the eight around it: a square alone is an edge of something
GAP = 2                      # squares of one table are so near to another one of it
MAX_SQUARES = 200_000        # 2,000 m2 of squares with points at such heights; further ones are not kept


class Tops:
    """Squares of the floor, as in extperfc.tasks.views, above which everything that was seen at the height of tables lies in
    one plane."""

    def __init__(self):
        self._heights = Heights(SQUARE_M, LOW_M, HIGH_M, MAX_SQUARES)

    def add(self, points):
        """Points (x, y, z), N x 3, in a frame that stands on the floor."""
        self._heights.add(points)

    def squares(self):
        """{(i, j)} of tops."""
        flat = {square for square, (count, low, high) in self._heights.spans.items() if count >= MIN_POINTS and high - low <= FLAT_M}
        return {one for one in flat if sum(near in flat for near in around(one)) >= MIN_NEIGHBOURS}


def table_at(squares, at, near_m):
    """{(i, j)} of the table at (x, y): of the nearest square, at most near_m away, those that are joined with it, and those between
    them. Empty: there is none."""
    begin = min(squares, key=lambda square: math.dist(middle_of(square), at), default=None)
    if begin is None or math.dist(middle_of(begin), at) > near_m:
        return set()
    joined, queue = {begin}, collections.deque([begin])
    while queue:
        i, j = queue.popleft()
        for one in ((i + di, j + dj) for di in range(-GAP, GAP + 1) for dj in range(-GAP, GAP + 1)):
            if one in squares and one not in joined:
                joined.add(one)
                queue.append(one)
    return between(joined)


def between(squares):
    """{(i, j)} of the convex hull of squares: a lidar does not meet every square of a plane."""
    cells = numpy.array(sorted(squares), numpy.int32)
    low = cells.min(axis=0)
    filled = numpy.zeros(cells.max(axis=0)[::-1] - low[::-1] + 1, numpy.uint8)
    cv2.fillConvexPoly(filled, cv2.convexHull(cells - low), 1)
    return {(int(i + low[0]), int(j + low[1])) for j, i in zip(*numpy.nonzero(filled))}


def middle_of(square):
    return (square[0] + 0.5) * SQUARE_M, (square[1] + 0.5) * SQUARE_M


def strips(squares):
    """[((length, width), middle)] of rectangles along x that cover squares [m]."""
    rows = collections.defaultdict(list)
    for i, j in squares:
        rows[j].append(i)
    return [((length * SQUARE_M, SQUARE_M), ((first + length / 2) * SQUARE_M, (j + 0.5) * SQUARE_M))
            for j, columns in sorted(rows.items()) for first, length in runs(columns)]
