"""Drives the simulated robot along waypoints, step by step, while a mapper keeps pace: for test_mapping_office.py.

The simulation stands still between steps of a tenth of a second (sim/step), so nothing depends on the machine's speed,
and every wait has a deadline whose message has the robot's pose.
"""

import heapq
import math
import time

import cv2
import numpy as np

STEPS = 24            # of 1/240 s: one sweep of the lidar
HALF_WIDTH_M = 0.406  # of the chassis, 0.81 x 0.79 m; doors are 0.95 m wide
ROTATION_CLEARANCE_M = 0.62  # where the robot may rotate: half of the chassis' diagonal and 5 cm
FAST_M_S, SLOW_M_S = 0.9, 0.3
MAX_YAW_RATE_RAD_S = 0.5
SIDE_GAIN_1_S = 2.5   # of the return to the path
ARRIVED_M = 0.12


class Plan:
    """Shortest paths that keep off the walls of an occupancy grid (nav_msgs/OccupancyGrid of the truth)."""

    def __init__(self, grid):
        info = grid.info
        self.side, self.x0, self.y0 = info.resolution, info.origin.position.x, info.origin.position.y
        occupied = (np.array(grid.data, np.int16).reshape(info.height, info.width) >= 65).astype(np.uint8)
        reach = int(round(HALF_WIDTH_M / self.side))
        square = np.ones((2 * reach + 1, 2 * reach + 1), np.uint8)
        self.blocked = cv2.dilate(occupied, square, borderValue=1) > 0
        self.clearance_m = cv2.distanceTransform(1 - occupied, cv2.DIST_L2, 5) * self.side

    def cell(self, x, y):
        return int((y - self.y0) / self.side), int((x - self.x0) / self.side)

    def clearance(self, x, y):
        return float(self.clearance_m[self.cell(x, y)])

    def block(self, x, y, radius_m=0.25):
        """An obstacle that the true map does not contain is here, e.g. a door handle."""
        row, column = self.cell(x, y)
        reach = int(radius_m / self.side)
        self.blocked[row - reach:row + reach + 1, column - reach:column + reach + 1] = True

    def path(self, start, goal):
        """Points [m] from start to goal (A*, eight neighbours), or None."""
        begin, end = self.cell(*start), self.cell(*goal)
        if self.blocked[end]:
            return None
        best, came, queue = {begin: 0.0}, {}, [(0.0, begin)]
        while queue:
            _, here = heapq.heappop(queue)
            if here == end:
                return self._points(came, end)
            for dr, dc in ((-1, 0), (1, 0), (0, -1), (0, 1), (-1, -1), (-1, 1), (1, -1), (1, 1)):
                to = here[0] + dr, here[1] + dc
                if self.blocked[to] and here != begin:
                    continue
                near = max(0.0, 0.9 - self.clearance_m[to])
                cost = best[here] + math.hypot(dr, dc) * (1 + 8 * near)
                if cost < best.get(to, math.inf):
                    best[to], came[to] = cost, here
                    heapq.heappush(queue, (cost + math.dist(to, end), to))
        return None

    def _points(self, came, end):
        cells = [end]
        while cells[-1] in came:
            cells.append(came[cells[-1]])
        return [(self.x0 + (c + 0.5) * self.side, self.y0 + (r + 0.5) * self.side) for r, c in reversed(cells)]


def aligned(yaw):
    """The nearest multiple of a right angle: so the chassis passes doors."""
    return round(yaw / (math.pi / 2)) * math.pi / 2


def command(plan, path, at, pose, back=False):
    """Velocity vx, vy, wz in the robot's frame along the path, and the index of the path's point nearest to the robot.

    `back`: a little back along the path, for a robot that something holds."""
    x, y, yaw = pose
    near = range(max(0, at - 10), min(len(path), at + 20))
    at = min(near, key=lambda i: math.dist(path[i], (x, y)))
    narrow = min(plan.clearance(*point) for point in path[max(0, at - 12):at + 16] + [(x, y)]) < ROTATION_CLEARANCE_M
    crooked = math.remainder(aligned(yaw) - yaw, 2 * math.pi)
    wz = max(-MAX_YAW_RATE_RAD_S, min(MAX_YAW_RATE_RAD_S, 2.0 * crooked)) if narrow else MAX_YAW_RATE_RAD_S
    speed = SLOW_M_S if narrow else FAST_M_S
    if narrow and abs(crooked) > 0.03 and plan.clearance(x, y) >= ROTATION_CLEARANCE_M:
        speed = 0.0
    goal = path[max(0, at - 5) if back else min(len(path) - 1, at + 5)]
    ahead = goal[0] - path[at][0], goal[1] - path[at][1]
    length = math.hypot(*ahead)
    speed = min(speed, 2.0 * math.dist(path[-1], (x, y)) + 0.05)
    dx, dy = (speed * part / length if length > 1e-6 else 0.0 for part in ahead)
    dx, dy = dx + SIDE_GAIN_1_S * (path[at][0] - x), dy + SIDE_GAIN_1_S * (path[at][1] - y)
    middle = yaw + 0.5 * wz * 0.1  # the command holds for a step, in which the robot rotates
    cos, sin = math.cos(middle), math.sin(middle)
    return (cos * dx + sin * dy, -sin * dx + cos * dy, wz), at


class Deadline:
    """Waits for conditions, and says where it stands when one does not come true."""

    def __init__(self, seconds, where):
        self.end, self.where = time.monotonic() + seconds, where

    def wait(self, what, condition, seconds):
        end = min(self.end, time.monotonic() + seconds)
        while not condition():
            if time.monotonic() > end:
                raise TimeoutError(f"waited in vain for {what}; {self.where()}")
            time.sleep(0.001)

    def check(self):
        if time.monotonic() > self.end:
            raise TimeoutError("out of time; " + self.where())
