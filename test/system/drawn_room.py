"""A robot with wheels that slip drives through a drawn room: its scans, its odometry and the truth, always the same. For
the tests that map a recording."""

import itertools
import math
import pathlib
import random
import re
import subprocess

import numpy

MAP = pathlib.Path(__file__).resolve().parents[2] / "tools" / "extperfc-map"
RAYS = 180
ANGLES = numpy.radians(numpy.arange(RAYS) - 90.0)
# A room of 12 m x 9 m with a niche and three pillars: walls as x0 y0 x1 y1 [m].
WALLS = numpy.array([
    (-4, -3, 8, -3), (8, -3, 8, 2), (8, 2, 6, 2), (6, 2, 6, 4), (6, 4, 8, 4), (8, 4, 8, 6), (8, 6, -4, 6),
    (-4, 6, -4, -3),
    *((x + s * a, y + s * b, x + s * c, y + s * d) for x, y, s in ((0, 3, .3), (3, 1.2, .4), (5, -1.5, .25))
      for a, b, c, d in ((-1, -1, 1, -1), (1, -1, 1, 1), (1, 1, -1, 1), (-1, 1, -1, -1)))], dtype=float)


def compose(a, b):
    c, s = math.cos(a[2]), math.sin(a[2])
    return (a[0] + c * b[0] - s * b[1], a[1] + s * b[0] + c * b[1], math.remainder(a[2] + b[2], 2 * math.pi))


def between(a, b):
    c, s = math.cos(a[2]), math.sin(a[2])
    dx, dy = b[0] - a[0], b[1] - a[1]
    return (c * dx + s * dy, -s * dx + c * dy, math.remainder(b[2] - a[2], 2 * math.pi))


def ranges_from(pose):
    """Distances to the nearest wall along each ray."""
    directions = numpy.stack([numpy.cos(ANGLES + pose[2]), numpy.sin(ANGLES + pose[2])], axis=1)[:, None, :]
    start = WALLS[None, :, :2] - numpy.array(pose[:2])
    along = (WALLS[:, 2:] - WALLS[:, :2])[None]
    cross = directions[..., 0] * along[..., 1] - directions[..., 1] * along[..., 0]
    with numpy.errstate(divide="ignore", invalid="ignore"):
        distance = (start[..., 0] * along[..., 1] - start[..., 1] * along[..., 0]) / cross
        ratio = (start[..., 0] * directions[..., 1] - start[..., 1] * directions[..., 0]) / cross
    distance[~((distance > 0) & (ratio >= 0) & (ratio <= 1))] = numpy.inf
    return distance.min(axis=1)


def drive():
    """True poses of two rounds about the pillars, a scan every 0.2 s: 0.08 m and up to 6 degrees apart."""
    corners = [(-2, -1.5), (6.5, -2.2), (7, 0.8), (1.5, 4.5), (-2.5, 4.5)]
    pose = (-2.0, -1.5, 0.0)
    poses = [pose]
    for x, y in itertools.islice(itertools.cycle(corners), 1, 2 * len(corners) + 1):
        while math.hypot(x - pose[0], y - pose[1]) > 0.1:
            yaw_error = math.remainder(math.atan2(y - pose[1], x - pose[0]) - pose[2], 2 * math.pi)
            step = 0.08 if abs(yaw_error) < 0.5 else 0.0
            pose = compose(pose, (step, 0, max(-0.1, min(0.1, yaw_error))))
            poses.append(pose)
    return poses


def odometry_of(poses, rng):
    """Odometry of wheels that slip by 3 % and rotate 3 % too far."""
    seen = (0.0, 0.0, 0.0)
    track = [seen]
    for last, now in zip(poses, poses[1:]):
        dx, dy, rotation = between(last, now)
        seen = compose(seen, (dx * rng.gauss(1.01, 0.03), dy, rotation * rng.gauss(1.03, 0.03) + rng.gauss(0, 2e-4)))
        track.append(seen)
    return track


class Drive:
    """One simulated drive, made once."""
    def __init__(self):
        rng = random.Random(11)
        self.truth = drive()
        self.odometry = odometry_of(self.truth, rng)
        self.scans = [[max(0.05, distance + rng.gauss(0, 0.01)) for distance in ranges_from(pose)]
                      for pose in self.truth]
        self.stamps = [1000 + 0.2 * i for i in range(len(self.truth))]

    def carmen(self):
        lines = ["# a simulated room", "PARAM robot_frontlaser_offset 0.0 nohost 0"]
        for stamp, scan, odom in zip(self.stamps, self.scans, self.odometry):
            ranges = " ".join(f"{distance:.2f}" for distance in scan)
            pose = " ".join(f"{value:.6f}" for value in odom)
            lines.append(f"FLASER {RAYS} {ranges} {pose} {pose} {stamp:.6f} nohost {stamp - 1000:.6f}")
        return "\n".join(lines) + "\n"

    def relations(self):
        rng = random.Random(5)
        count = len(self.truth)
        pairs = [(i, i + 5) for i in range(0, count - 5, 7)]
        pairs += [(i, i + rng.randrange(110, count - 110)) for i in range(0, 100, 4)]
        lines = ["# i j x y z roll pitch yaw"]
        for i, j in pairs:
            x, y, yaw = between(self.truth[i], self.truth[j])
            lines.append(f"{i} {j} {x:.6f} {y:.6f} 0 0 0 {yaw:.6f}")
        return "\n".join(lines) + "\n"


DRIVE = Drive()


def write_bag(file, stamps, scans, odometry, kind="tf"):
    """A bag with /scan (180 degrees, a ray per value), and odometry in /tf or as nav_msgs/Odometry on /odom (`kind`: tf,
    topic); the scanner sits in the middle of base_link."""
    import genpy
    import rosbag
    from nav_msgs.msg import Odometry
    from sensor_msgs.msg import LaserScan

    with rosbag.Bag(str(file), "w") as bag:
        start = genpy.Time.from_sec(stamps[0])
        bag.write("/tf_static", transform_message("base_link", "laser", start, (0, 0, 0)), start)
        for seconds, ranges, pose in zip(stamps, scans, odometry):
            stamp = genpy.Time.from_sec(seconds)
            scan = LaserScan(angle_min=-math.pi / 2, angle_increment=math.pi / 180, range_min=0.02, range_max=30,
                             ranges=ranges)
            scan.header.frame_id, scan.header.stamp = "laser", stamp
            bag.write("/scan", scan, stamp)
            if kind == "tf":
                bag.write("/tf", transform_message("odom", "base_link", stamp, pose), stamp)
                continue
            message = Odometry()
            message.header.stamp = stamp
            message.pose.pose.position.x, message.pose.pose.position.y = pose[:2]
            message.pose.pose.orientation.z = math.sin(pose[2] / 2)
            message.pose.pose.orientation.w = math.cos(pose[2] / 2)
            bag.write("/odom", message, stamp)


def map_the_drive(folder):
    """Writes the drive's bag, and its map as map.yaml: the bag, and the mapper's pose at each stamp, to the millisecond."""
    bag = folder / "room.bag"
    write_bag(bag, DRIVE.stamps, DRIVE.scans, DRIVE.odometry)
    subprocess.run([MAP, bag, "--out", folder, "--quiet"], check=True, capture_output=True, timeout=120)
    return bag, {round(stamp, 3): pose for stamp, *pose in read_tum(folder / "trajectory.tum")}


def transform_message(parent, child, stamp, pose):
    """The tf2_msgs/TFMessage of a planar pose."""
    from geometry_msgs.msg import TransformStamped
    from tf2_msgs.msg import TFMessage

    message = TransformStamped()
    message.header.frame_id, message.child_frame_id, message.header.stamp = parent, child, stamp
    message.transform.translation.x, message.transform.translation.y = pose[:2]
    message.transform.rotation.z, message.transform.rotation.w = math.sin(pose[2] / 2), math.cos(pose[2] / 2)
    return TFMessage([message])


def read_tum(file):
    """(stamp, x, y, yaw) of each line."""
    rows = [list(map(float, line.split())) for line in file.read_text().splitlines() if not line.startswith("#")]
    return [(row[0], row[1], row[2], 2 * math.atan2(row[6], row[7])) for row in rows]


def read_pgm(file):
    match = re.match(rb"P5\n#[^\n]*\n(\d+) (\d+)\n255\n", data := file.read_bytes())
    width, height = map(int, match.groups())
    return numpy.frombuffer(data[match.end():], dtype=numpy.uint8).reshape(height, width)
