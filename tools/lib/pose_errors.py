"""Poses on the floor and how far estimated ones are from the truth; knows neither ROS nor maps."""

import bisect
import collections
import math

import numpy

Pose = collections.namedtuple("Pose", "x y yaw")  # [m, m, rad]


def compose(a, b):
    """The pose of c in a, from that of b in a and of c in b."""
    cos, sin = math.cos(a.yaw), math.sin(a.yaw)
    return Pose(a.x + cos * b.x - sin * b.y, a.y + sin * b.x + cos * b.y, math.remainder(a.yaw + b.yaw, 2 * math.pi))


def inverse(a):
    cos, sin = math.cos(a.yaw), math.sin(a.yaw)
    return Pose(-cos * a.x - sin * a.y, sin * a.x - cos * a.y, math.remainder(-a.yaw, 2 * math.pi))


def error(a, b):
    """Distance [m] and angle [rad] between two poses."""
    return math.hypot(a.x - b.x, a.y - b.y), abs(math.remainder(a.yaw - b.yaw, 2 * math.pi))


def interpolate(a, b, fraction):
    """From a (fraction 0) to b (fraction 1)."""
    yaw = math.remainder(b.yaw - a.yaw, 2 * math.pi)
    return Pose(a.x + fraction * (b.x - a.x), a.y + fraction * (b.y - a.y),
                math.remainder(a.yaw + fraction * yaw, 2 * math.pi))


class Track:
    """Poses by time, the last `kept` of them. A stamp that runs back begins anew."""

    def __init__(self, kept=20000):
        self.kept = kept
        self.stamps = []
        self.poses = []

    def add(self, stamp_s, pose):
        if self.stamps and stamp_s <= self.stamps[-1]:
            if stamp_s == self.stamps[-1]:
                return
            self.stamps.clear()
            self.poses.clear()
        self.stamps.append(stamp_s)
        self.poses.append(pose)
        if len(self.stamps) > 2 * self.kept:
            del self.stamps[:-self.kept], self.poses[:-self.kept]

    def at(self, stamp_s):
        """Interpolated between two poses; None outside the track."""
        after = bisect.bisect_left(self.stamps, stamp_s)
        if after < len(self.stamps) and self.stamps[after] == stamp_s:
            return self.poses[after]
        if after == 0 or after == len(self.stamps):
            return None
        t0, t1 = self.stamps[after - 1], self.stamps[after]
        return interpolate(self.poses[after - 1], self.poses[after], (stamp_s - t0) / (t1 - t0))

    def before(self, stamp_s):
        """The last pose not later than this; None before the first."""
        after = bisect.bisect_right(self.stamps, stamp_s)
        return self.poses[after - 1] if after else None


def settled_after(stamps, errors, max_m, max_rad):
    """When the errors (pairs of metres and radians) came below both limits for good; None when they did not."""
    settled = None
    for stamp, (metres, radians) in zip(stamps, errors):
        if metres > max_m or radians > max_rad:
            settled = None
        elif settled is None:
            settled = stamp
    return settled


class Summary:
    """Mean, 95 % and greatest of errors (pairs of metres and radians)."""

    def __init__(self, errors):
        if not errors:
            raise ValueError("no errors to summarise")
        metres, degrees = numpy.array([e[0] for e in errors]), numpy.degrees([e[1] for e in errors])
        self.count = len(errors)
        self.mean_m, self.p95_m, self.max_m = metres.mean(), numpy.percentile(metres, 95), metres.max()
        self.mean_deg, self.p95_deg, self.max_deg = degrees.mean(), numpy.percentile(degrees, 95), degrees.max()

    def __str__(self):
        return (f"{self.count} poses: mean {100 * self.mean_m:.1f} cm, {self.mean_deg:.2f} degrees; 95 % below "
                f"{100 * self.p95_m:.1f} cm, {self.p95_deg:.2f} degrees; greatest {100 * self.max_m:.1f} cm, "
                f"{self.max_deg:.2f} degrees")
