"""Whether a robot's footprint touched what really stands around it; knows neither ROS nor the simulator."""

import math

import cv2
import numpy

CHASSIS = ((0.4064, 0.3937), (-0.4064, 0.3937), (-0.4064, -0.3937), (0.4064, -0.3937))  # m, of the mobile Baxter
PERSON_RADIUS_M = 0.25


class TrueMap:
    """Occupied cells of the true floor plan: row by row from the lower left corner at (x0, y0)."""

    def __init__(self, cells, resolution_m, x0, y0):
        self.cells, self.resolution_m, self.x0, self.y0 = numpy.asarray(cells), resolution_m, x0, y0
        self.occupied = self.cells >= 65
        free = (~self.occupied).astype(numpy.uint8)
        self.clearance_m = resolution_m * cv2.distanceTransform(free, cv2.DIST_L2, 5)

    def cell(self, x, y):
        """Row and column; perhaps outside."""
        return int(math.floor((y - self.y0) / self.resolution_m)), int(math.floor((x - self.x0) / self.resolution_m))

    def clearance_at(self, x, y):
        row, column = self.cell(x, y)
        inside = 0 <= row < self.occupied.shape[0] and 0 <= column < self.occupied.shape[1]
        return float(self.clearance_m[row, column]) if inside else 0.0

    def touches(self, pose, corners=CHASSIS):
        """Whether the middle of an occupied cell lies under the footprint: exact to half a cell."""
        reach = max(math.hypot(*corner) for corner in corners)
        if self.clearance_at(pose.x, pose.y) > reach + self.resolution_m:
            return False
        low, high = self.cell(pose.x - reach, pose.y - reach), self.cell(pose.x + reach, pose.y + reach)
        rows = numpy.arange(max(0, low[0]), min(self.occupied.shape[0], high[0] + 1))
        columns = numpy.arange(max(0, low[1]), min(self.occupied.shape[1], high[1] + 1))
        part = self.occupied[rows[0]:rows[-1] + 1, columns[0]:columns[-1] + 1] if len(rows) and len(columns) else None
        if part is None or not part.any():
            return False
        row, column = numpy.nonzero(part)
        x = self.x0 + (columns[0] + column + 0.5) * self.resolution_m - pose.x
        y = self.y0 + (rows[0] + row + 0.5) * self.resolution_m - pose.y
        return bool(_inside(_to_base(x, y, pose.yaw), corners).any())


def _to_base(x, y, yaw):
    cos, sin = math.cos(yaw), math.sin(yaw)
    return numpy.stack([cos * x + sin * y, -sin * x + cos * y], -1)


def _inside(points, corners):
    """Of a convex polygon, corners counter-clockwise."""
    inside = numpy.ones(len(points), bool)
    for (ax, ay), (bx, by) in zip(corners, corners[1:] + corners[:1]):
        inside &= (bx - ax) * (points[:, 1] - ay) - (by - ay) * (points[:, 0] - ax) >= 0
    return inside


def distance_to_footprint(pose, x, y, corners=CHASSIS):
    """From a point to the footprint [m]; 0 inside."""
    point = _to_base(numpy.array([x - pose.x]), numpy.array([y - pose.y]), pose.yaw)
    if _inside(point, tuple(corners))[0]:
        return 0.0
    px, py = point[0]
    nearest = math.inf
    for (ax, ay), (bx, by) in zip(corners, corners[1:] + corners[:1]):
        ex, ey = bx - ax, by - ay
        along = min(1.0, max(0.0, ((px - ax) * ex + (py - ay) * ey) / (ex * ex + ey * ey)))
        nearest = min(nearest, math.hypot(px - ax - along * ex, py - ay - along * ey))
    return nearest


def count_episodes(flags):
    """How often a sequence of truths begins to be true."""
    return sum(1 for before, now in zip([False, *flags], flags) if now and not before)


def reachable(true_map, start, radius_m):
    """Cells that a disc of this radius reaches from a start (x, y), as a mask."""
    passable = (true_map.clearance_m > radius_m).astype(numpy.uint8)
    _, labels = cv2.connectedComponents(passable)
    label = labels[true_map.cell(*start)]
    return (labels == label) & (passable > 0) if label else numpy.zeros_like(passable, bool)
