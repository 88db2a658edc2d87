"""What stands upright around a robot, by the points of a lidar from all over its way: walls, shelves, cabinets. Without ROS."""

import math

from extperfc.tasks.heights import Heights, runs

SQUARE_M = 0.05
LOW_M, HIGH_M = 0.25, 2.2     # heights above the floor that arms come to
UPRIGHT_M = 0.25              # a square whose points at such heights differ by less is a table top, or too little is known of it
MIN_POINTS = 4                # of a square
TALL_M = 1.1                  # what is seen up to here is taken to go on
RISE_M = 0.05                 # the rings of a lidar seldom hit the highest point
MAX_SQUARES = 400_000         # 1,000 m2; further ones are not kept


class Solids:
    """Upright squares of the floor, and up to which height something was seen above each."""

    def __init__(self):
        self._heights = Heights(SQUARE_M, LOW_M, HIGH_M, MAX_SQUARES)

    def add(self, points):
        """Points (x, y, z), N x 3, in a frame that stands on the floor."""
        self._heights.add(points)

    def boxes(self, at, near_m, far_m, without=lambda x, y: False):
        """[(size, middle)] of boxes from the floor upwards whose squares' middles are so far from `at` (x, y); those for which
        without(x, y) is true are left out. Neighbours along x with the same height are one box."""
        rows = {}
        for (i, j), (count, low, high) in self._heights.spans.items():
            x, y = (i + 0.5) * SQUARE_M, (j + 0.5) * SQUARE_M
            upright = count >= MIN_POINTS and high - low >= UPRIGHT_M
            if upright and near_m <= math.dist(at, (x, y)) <= far_m and not without(x, y):
                rows.setdefault((j, HIGH_M if high >= TALL_M else math.ceil((high + RISE_M) / 0.1) * 0.1), []).append(i)
        found = []
        for (j, top), columns in sorted(rows.items()):
            for first, length in runs(columns):
                middle = ((first + length / 2) * SQUARE_M, (j + 0.5) * SQUARE_M, top / 2)
                found.append(((length * SQUARE_M, SQUARE_M, top), middle))
        return found
