"""Heights that were seen above each square of the floor. Without ROS."""

import numpy


class Heights:
    """spans: {(i, j): [number of points, lowest, highest]} of squares with points from low_m to high_m above the floor.
    Further squares than max_squares are not kept."""

    def __init__(self, square_m, low_m, high_m, max_squares):
        self.square_m, self.low_m, self.high_m, self.max_squares = square_m, low_m, high_m, max_squares
        self.spans = {}

    def add(self, points):
        """Points (x, y, z), N x 3, in a frame that stands on the floor."""
        points = points[numpy.isfinite(points).all(axis=1)]
        points = points[(points[:, 2] >= self.low_m) & (points[:, 2] <= self.high_m)]
        if len(points) == 0:
            return
        squares, index, counts = numpy.unique(numpy.floor(points[:, :2] / self.square_m).astype(int), axis=0,
                                              return_inverse=True, return_counts=True)
        index = index.reshape(-1)
        lowest, highest = numpy.full(len(squares), numpy.inf), numpy.full(len(squares), -numpy.inf)
        numpy.minimum.at(lowest, index, points[:, 2])
        numpy.maximum.at(highest, index, points[:, 2])
        for square, count, low, high in zip(map(tuple, squares.tolist()), counts.tolist(), lowest.tolist(), highest.tolist()):
            known = self.spans.get(square)
            if known is not None:
                known[:] = known[0] + count, min(known[1], low), max(known[2], high)
            elif len(self.spans) < self.max_squares:
                self.spans[square] = [count, low, high]


def runs(indices):
    """[(first, length)] of what follows one another among whole numbers."""
    indices = numpy.array(sorted(indices), dtype=int)
    found = numpy.split(indices, numpy.flatnonzero(numpy.diff(indices) > 1) + 1)
    return [(int(run[0]), len(run)) for run in found if len(run)]
