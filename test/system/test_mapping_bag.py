"""The mapper nodelet, fed a recording by rosbag play, against extperfc-map on the same file."""

import bz2
import itertools
import json
import math
import os
import pathlib
import re
import subprocess
import tempfile
import unittest

import cv2
import numpy

from bag_player import BagSession, end
from drawn_room import DRIVE, between, compose, read_pgm, read_tum, write_bag
from generated_services import find_services

REPO = pathlib.Path(__file__).resolve().parents[2]
WS = pathlib.Path(os.environ.get("EXTPERFC_WS", REPO / ".ws"))
MAP = REPO / "tools" / "extperfc-map"
INTEL = REPO.parent / "shared" / "data" / "slam" / "intel.clf.bz2"
INTEL_SCANS = 400
SEEDS = (1, 2, 3, 4, 5)
RATE = 30               # simulated seconds per second, as far as the mapper follows: the player waits for it
LOOP_RATE = 4           # where the player does not wait for the mapper
# Each pair of seeds gives one draw of how far two runs of the filter differ, and the nodelet against each seed gives
# more of the same, when it is the same filter. Among equals the nodelet would have the largest of all differences by chance
# once in six runs, so the limit is twice the largest between seeds; a fiftieth of a cell is for what rounding does to a
# path that the seed does not change.
SPREAD = 2.0
MIN_DIFFERENCE_M = 0.001
MIN_DIFFERENCE_RAD = MIN_DIFFERENCE_M / 5.0   # moves a wall 5 m away by as much
MIN_F_SCORE_LOSS = 0.002


def intel_recording(count):
    """Stamps (five scans a second: the log's own run backwards in places), scans and odometry of the log's first scans."""
    scans, odometry = [], []
    with bz2.open(INTEL, "rt") as log:
        for line in log:
            tokens = line.split()
            if not tokens or tokens[0] != "FLASER":
                continue
            ranges, rest = tokens[2:2 + int(tokens[1])], tokens[2 + int(tokens[1]):]
            scans.append([value if value < 81.8 else math.inf for value in map(float, ranges)])
            odometry.append(tuple(map(float, rest[3:6])))
            if len(scans) == count:
                break
    return [2000 + 0.2 * i for i in range(len(scans))], scans, odometry


def path_difference(path, other):
    """Mean distance of the poses [m], and of the headings [rad]."""
    errors = [between(a, b) for a, b in zip(path, other)]
    return (sum(math.hypot(e[0], e[1]) for e in errors) / len(errors), sum(abs(e[2]) for e in errors) / len(errors))


class Run:
    """A path and a map in the frame of the path's first pose."""

    def __init__(self, poses, folder, stem):
        self.path = [between(poses[0], pose) for pose in poses]
        description = (folder / f"{stem}.yaml").read_text()
        x0, y0, yaw = (float(v) for v in re.search(r"origin: \[(.*)\]", description).group(1).split(","))
        self.side = float(re.search(r"resolution: (.*)", description).group(1))
        grid = read_pgm(folder / f"{stem}.pgm")[::-1]
        rows, columns = numpy.nonzero(grid == 0)
        first_T_map = between(poses[0], (0.0, 0.0, 0.0))
        first_T_grid = compose(first_T_map, (x0, y0, yaw))
        c, s = math.cos(first_T_grid[2]), math.sin(first_T_grid[2])
        x, y = (columns + 0.5) * self.side, (rows + 0.5) * self.side
        self.walls = numpy.stack([first_T_grid[0] + c * x - s * y, first_T_grid[1] + s * x + c * y], axis=1)

    def last_difference(self, other):
        """Distance [m] and rotation [rad] between the last poses."""
        x, y, yaw = between(self.path[-1], other.path[-1])
        return math.hypot(x, y), abs(yaw)

    def f_score_loss(self, other):
        """1 - F-score of the occupied cells; one is found when the other map has one within a cell and a half."""
        low = numpy.minimum(self.walls.min(axis=0), other.walls.min(axis=0)) - 1.0
        high = numpy.maximum(self.walls.max(axis=0), other.walls.max(axis=0)) + 1.0
        shape = tuple(numpy.ceil((high - low) / self.side).astype(int)[::-1])

        def cells(walls):
            return tuple(((walls - low) / self.side).astype(int).T[::-1])

        def found(walls, among):
            empty = numpy.ones(shape, numpy.uint8)
            empty[cells(among)] = 0
            return (cv2.distanceTransform(empty, cv2.DIST_L2, 5)[cells(walls)] <= 1.5).mean()

        precision, recall = found(self.walls, other.walls), found(other.walls, self.walls)
        return float(1 - 2 * precision * recall / (precision + recall))

    def differences(self, other):
        """All of the above: path [m, rad], last pose [m, rad], map."""
        return numpy.array([*path_difference(self.path, other.path), *self.last_difference(other), self.f_score_loss(other)])


NAMES = ("path [m]", "path [rad]", "last pose [m]", "last pose [rad]", "1 - F-score")
FLOOR = numpy.array([MIN_DIFFERENCE_M, MIN_DIFFERENCE_RAD, MIN_DIFFERENCE_M, MIN_DIFFERENCE_RAD, MIN_F_SCORE_LOSS])


def offline(bag, folder, seed, *more):
    out = folder / f"{bag.stem}_{seed}{'_'.join(more)}"
    done = subprocess.run([MAP, bag, "--out", out, "--json", "--quiet", "--seed", str(seed), *more], capture_output=True,
                          text=True, timeout=120)
    assert done.returncode == 0, done.stderr
    report = json.loads(done.stdout)
    return Run([row[1:] for row in read_tum(out / "trajectory.tum")], out, "map"), report


class Listener:
    """What the mapper says."""

    def __init__(self):
        import rospy
        from diagnostic_msgs.msg import DiagnosticArray
        from nav_msgs.msg import Path
        from rosgraph_msgs.msg import Log

        self.path, self.values, self.said = [], {}, []
        rospy.Subscriber("/trajectory", Path, self._on_path, queue_size=2)
        rospy.Subscriber("/diagnostics", DiagnosticArray, self._on_diagnostics, queue_size=20)
        rospy.Subscriber("/rosout", Log, lambda message: self.said.append(message.msg), queue_size=200)

    def _on_path(self, message):
        self.path = [(p.pose.position.x, p.pose.position.y, 2 * math.atan2(p.pose.orientation.z, p.pose.orientation.w))
                     for p in message.poses]

    def _on_diagnostics(self, message):
        for status in message.status:
            if status.name.lstrip("/").startswith("mapper"):
                self.values = {pair.key: pair.value for pair in status.values}

    def number(self, key):
        return float(self.values.get(key, "nan"))


class MappingBag(unittest.TestCase):
    def test_rosbag_play_gives_the_map_of_the_offline_tool(self):
        import rospy
        with tempfile.TemporaryDirectory() as temporary:
            folder = pathlib.Path(temporary)
            room, intel = folder / "room.bag", folder / "intel.bag"
            write_bag(room, DRIVE.stamps, DRIVE.scans, DRIVE.odometry)
            config = folder / "mapper.yaml"  # a busy machine may be late; nothing shall be dropped here
            config.write_text(re.sub(r"queue_size: \d+", "queue_size: 500",
                                     (REPO / "config" / "mapper.yaml").read_text()))
            with BagSession(folder / "launch.log") as session:
                session.launch_in_bag_time("mapping.launch", folder, config=config, base_frame="base_link")
                rospy.init_node("mapping_bag_test", disable_signals=True)
                listener = Listener()
                with self.subTest(recording="room"):
                    self.compare(session, listener, room, folder, DRIVE.odometry, before=0)
                if INTEL.exists():
                    with self.subTest(recording="the start of Intel"):
                        recording = intel_recording(INTEL_SCANS)
                        write_bag(intel, *recording)
                        self.reset()
                        self.compare(session, listener, intel, folder, recording[2], before=len(DRIVE.stamps))
                with self.subTest(what="a loop"):
                    self.loop(session, listener, room)
                rospy.signal_shutdown("done")
                self.assertEqual([], session.errors())

    def reset(self):
        import rospy
        from std_srvs.srv import Trigger
        rospy.wait_for_service("/mapper/reset", 20)
        self.assertTrue(rospy.ServiceProxy("/mapper/reset", Trigger)().success)

    def compare(self, session, listener, bag, folder, odometry, before):
        """The nodelet's path and map are as near to the tool's as those of two seeds are to each other."""
        count = len(odometry)
        runs = [offline(bag, folder, seed) for seed in SEEDS]
        self.assertEqual([(count, 0, 0)] * len(SEEDS), [
            (report["scans"], report["scans_refused"], report["scans_without_odometry"]) for _, report in runs])
        runs = [run for run, _ in runs]
        between_seeds = numpy.array([a.differences(b) for a, b in itertools.combinations(runs, 2)])
        nodelet = self.play(session, listener, bag, folder, count, before)
        found = numpy.array([nodelet.differences(run) for run in runs])
        limit = SPREAD * between_seeds.max(axis=0) + FLOOR
        for name, seeds, mine, bound in zip(NAMES, between_seeds.T, found.T, limit):
            print(f"{bag.stem:6} {name:16} between seeds: mean {seeds.mean():.5f} max {seeds.max():.5f}; nodelet against "
                  f"seeds: mean {mine.mean():.5f} max {mine.max():.5f}, same seed {mine[0]:.5f}; limit {bound:.5f}",
                  flush=True)
        for name, mine, bound in zip(NAMES, found.T, limit):
            self.assertLess(mine.max(), bound, name)
        by_wheels = path_difference(runs[0].path, [between(odometry[0], pose) for pose in odometry])
        self.assertGreater(by_wheels[0], 5 * limit[0], "the limit separates the filter's path from odometry's")

    def play(self, session, listener, bag, folder, count, before):
        """Plays the bag to the nodelet and returns what it made of it."""
        import rospy

        find_services()
        from extperfc.srv import SaveMap
        player = session.play(bag, RATE, "--rate-control-topic", "/pose", "--rate-control-max-delay", "2")
        try:
            session.wait(lambda: player.poll() is not None, f"the end of {bag.name}", 100, lambda: listener.values)
        finally:
            end(player)
        session.wait(lambda: listener.number("scans used") == before + count, f"{count} used scans", 20,
                     lambda: listener.values)
        session.wait(lambda: len(listener.path) == count, "the whole trajectory", 20, lambda: len(listener.path))
        self.assertEqual(0, listener.number("scans without odometry"))
        rospy.wait_for_service("/mapper/save_map", 20)
        saved = rospy.ServiceProxy("/mapper/save_map", SaveMap)(str(folder / bag.stem))
        self.assertTrue(saved.success, saved.message)
        return Run(listener.path, folder, bag.stem)

    def loop(self, session, listener, bag):
        """Round and round: time runs back, the nodelet reports it and continues."""
        rounds, used, said = listener.number("time ran back"), listener.number("scans used"), len(listener.said)
        player = session.play(bag, LOOP_RATE, "--loop", "--duration", "8")
        try:
            session.wait(lambda: listener.number("time ran back") >= rounds + 3, "three returns of time", 60,
                         lambda: listener.values)
        finally:
            end(player)
        self.assertIn("time ran back to 1000.000", "\n".join(listener.said[said:]))
        self.assertGreater(listener.number("scans used"), used + 60, "of 120 in three rounds")


if __name__ == "__main__":
    unittest.main()
