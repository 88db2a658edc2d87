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
SAME_M = 0.06                # and differ by less in height
EDGE = 0.3                   # of a square, by which its middle may lie outside of a table
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
        return set(self.heights())

    def heights(self):
        """{(i, j): height} of tops."""
        flat = {square: (low + high) / 2 for square, (count, low, high) in self._heights.spans.items()
                if count >= MIN_POINTS and high - low <= FLAT_M}
        return {one: height for one, height in flat.items() if sum(near in flat for near in around(one)) >= MIN_NEIGHBOURS}


def table_at(heights, at, near_m):
    """{(i, j)} of the table at (x, y), taken to be a rectangle: of the nearest of the squares {(i, j): height}, at most near_m away,
    with those that are joined at its height, and those between them and at the corners, where legs are seen. Empty: no table was
    seen there."""
    begin = min(heights, key=lambda square: math.dist(middle_of(square), at), default=None)
    if begin is None or math.dist(middle_of(begin), at) > near_m:
        return set()
    joined, queue = {begin}, collections.deque([begin])
    while queue:
        i, j = queue.popleft()
        for one in ((i + di, j + dj) for di in range(-GAP, GAP + 1) for dj in range(-GAP, GAP + 1)):
            if one not in joined and abs(heights.get(one, math.inf) - heights[begin]) < SAME_M:
                joined.add(one)
                queue.append(one)
    return rectangle(joined)


def rectangle(squares):
    """{(i, j)} in the smallest rectangle about squares."""
    cells = numpy.array(sorted(squares), numpy.float32)
    middle, size, angle = cv2.minAreaRect(cells)
    reach = math.ceil(max(size)) + 1
    i, j = (axis.ravel() for axis in numpy.indices((2 * reach + 1, 2 * reach + 1)) - reach)
    i, j = i + round(middle[0]), j + round(middle[1])
    cosine, sine = math.cos(math.radians(angle)), math.sin(math.radians(angle))
    x, y = i - middle[0], j - middle[1]
    along, across = numpy.abs(cosine * x + sine * y), numpy.abs(cosine * y - sine * x)
    inside = (along <= size[0] / 2 + EDGE) & (across <= size[1] / 2 + EDGE)
    return set(zip(i[inside].tolist(), j[inside].tolist()))


def middle_of(square):
    return (square[0] + 0.5) * SQUARE_M, (square[1] + 0.5) * SQUARE_M


def strips(squares):
    """[((length, width), middle)] of rectangles along x that cover squares [m]."""
    rows = collections.defaultdict(list)
    for i, j in squares:
        rows[j].append(i)
    return [((length * SQUARE_M, SQUARE_M), ((first + length / 2) * SQUARE_M, (j + 0.5) * SQUARE_M))
            for j, columns in sorted(rows.items()) for first, length in runs(columns)]
