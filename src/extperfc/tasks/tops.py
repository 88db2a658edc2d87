"""Where tables are, by the points of a lidar that looks at them from below or from above. Without ROS."""

import numpy

from extperfc.tasks.views import SQUARE_M, around

LOW_M, HIGH_M = 0.35, 1.2    # heights of table tops above the floor
FLAT_M = 0.08                # a square whose points at such heights differ by more is a wall, a leg, the side of a cabinet
MIN_POINTS = 3               # of a square
MIN_NEIGHBOURS = 2           # of the eight around it: a square alone is an edge of something
MAX_SQUARES = 200_000        # 2,000 m2 of squares with points at such heights; further ones are not kept


class Tops:
    """Squares of the floor, as in extperfc.tasks.views, above which everything that was seen at the height of tables lies in
    one plane."""

    def __init__(self):
        self._squares = {}  # (i, j): [number of points, lowest, highest]

    def add(self, points):
        """Points (x, y, z), N x 3, in a frame that stands on the floor."""
        points = points[numpy.isfinite(points).all(axis=1)]
        points = points[(points[:, 2] >= LOW_M) & (points[:, 2] <= HIGH_M)]
        if len(points) == 0:
            return
        squares, index, counts = numpy.unique(numpy.floor(points[:, :2] / SQUARE_M).astype(int), axis=0, return_inverse=True,
                                              return_counts=True)
        lowest, highest = numpy.full(len(squares), numpy.inf), numpy.full(len(squares), -numpy.inf)
        numpy.minimum.at(lowest, index, points[:, 2])
        numpy.maximum.at(highest, index, points[:, 2])
        for square, count, low, high in zip(map(tuple, squares.tolist()), counts, lowest, highest):
            known = self._squares.get(square)
            if known is not None:
                known[:] = known[0] + int(count), min(known[1], low), max(known[2], high)
            elif len(self._squares) < MAX_SQUARES:
                self._squares[square] = [int(count), low, high]

    def squares(self):
        """{(i, j)} of tops."""
        flat = {square for square, (count, low, high) in self._squares.items() if count >= MIN_POINTS and high - low <= FLAT_M}
        return {one for one in flat if sum(near in flat for near in around(one)) >= MIN_NEIGHBOURS}
