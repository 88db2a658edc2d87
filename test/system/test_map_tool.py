"""tools/extperfc-map and tools/extperfc-relations as a user calls them."""

import bz2
import gzip
import itertools
import json
import math
import os
import pathlib
import pty
import random
import re
import signal
import struct
import subprocess
import tempfile
import unittest

import numpy

REPO = pathlib.Path(__file__).resolve().parents[2]
MAP = REPO / "tools" / "extperfc-map"
RELATIONS = REPO / "tools" / "extperfc-relations"
SLAM_DATA = REPO.parent / "shared" / "data" / "slam"
MRPT_DATA = pathlib.Path("/usr/share/mrpt/datasets")
FILES = ["map.pgm", "map.png", "map.session", "map.yaml", "report.json", "report.txt", "trajectory.tum"]

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
        share = (start[..., 0] * directions[..., 1] - start[..., 1] * directions[..., 0]) / cross
    distance[~((distance > 0) & (share >= 0) & (share <= 1))] = numpy.inf
    return distance.min(axis=1)


def drive():
    """True poses of two rounds about the pillars, a scan every 0.2 s: 0.08 m and up to 6 degrees apart."""
    corners = [(-2, -1.5), (6.5, -2.2), (7, 0.8), (1.5, 4.5), (-2.5, 4.5)]
    pose = (-2.0, -1.5, 0.0)
    poses = [pose]
    for x, y in itertools.islice(itertools.cycle(corners), 1, 2 * len(corners) + 1):
        while math.hypot(x - pose[0], y - pose[1]) > 0.1:
            turn = math.remainder(math.atan2(y - pose[1], x - pose[0]) - pose[2], 2 * math.pi)
            step = 0.08 if abs(turn) < 0.5 else 0.0
            pose = compose(pose, (step, 0, max(-0.1, min(0.1, turn))))
            poses.append(pose)
    return poses


def odometry_of(poses, rng):
    """What wheels that slip by 3 % and turn 3 % too far measure."""
    seen = (0.0, 0.0, 0.0)
    track = [seen]
    for last, now in zip(poses, poses[1:]):
        dx, dy, turn = between(last, now)
        seen = compose(seen, (dx * rng.gauss(1.01, 0.03), dy, turn * rng.gauss(1.03, 0.03) + rng.gauss(0, 2e-4)))
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


def call(tool, *arguments, **more):
    return subprocess.run([tool, *map(str, arguments)], capture_output=True, text=True, timeout=300, **more)


def read_tum(file):
    """(stamp, x, y, yaw) of each line."""
    rows = [list(map(float, line.split())) for line in file.read_text().splitlines() if not line.startswith("#")]
    return [(row[0], row[1], row[2], 2 * math.atan2(row[6], row[7])) for row in rows]


def read_pgm(file):
    match = re.match(rb"P5\n#[^\n]*\n(\d+) (\d+)\n255\n", data := file.read_bytes())
    width, height = map(int, match.groups())
    return numpy.frombuffer(data[match.end():], dtype=numpy.uint8).reshape(height, width)


class MapTool(unittest.TestCase):
    def setUp(self):
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.folder = pathlib.Path(temporary.name)
        self.log = self.folder / "room.clf"
        self.log.write_text(DRIVE.carmen())

    def mapped(self, recording, *arguments, out="out"):
        """Maps a recording; returns the report and the folder."""
        folder = self.folder / out
        done = call(MAP, recording, "--out", folder, "--json", "--quiet", *arguments)
        self.assertEqual(0, done.returncode, done.stdout + done.stderr)
        self.assertEqual("", done.stderr)
        self.assertEqual(FILES, sorted(file.name for file in folder.iterdir()))
        report = json.loads(done.stdout)
        self.assertEqual(report, json.loads((folder / "report.json").read_text()))
        return report, folder

    def check_path(self, folder, most_m, most_rad, truth=None):
        """Errors against the true path, both beginning at the same pose."""
        truth = truth or DRIVE.truth
        path = read_tum(folder / "trajectory.tum")
        self.assertEqual(len(truth), len(path))
        for (_, *pose), true in zip(path, truth):
            error = between(between(truth[0], true), between(path[0][1:], pose))
            self.assertLess(math.hypot(error[0], error[1]), most_m)
            self.assertLess(abs(error[2]), most_rad)

    def test_maps_a_room(self):
        relations = self.folder / "room.relations"
        relations.write_text(DRIVE.relations())
        report, folder = self.mapped(self.log, "--relations", relations, "--seed", 3)
        self.assertEqual(len(DRIVE.truth), report["scans"])
        self.assertEqual(0, report["scans_refused"])
        self.assertEqual(3, report["parameters"]["seed"])
        self.assertGreater(report["key_frames"], 50)
        self.assertLess(report["key_frames"], report["scans"])
        self.assertGreater(report["cpu_s"], 0)
        self.assertLess(report["peak_memory_mb"], 120)
        score = report["score"]
        self.assertEqual(0, score["unmatched"])
        self.assertGreater(score["loops"]["relations"], 20)
        # Odometry alone is metres off after two rounds; a map cell is 0.05 m.
        self.assertLess(score["all"]["translation_m"]["mean"], 0.03)
        self.assertLess(score["all"]["rotation_deg"]["mean"], 0.5)
        self.check_path(folder, 0.15, math.radians(2))
        stamps = [stamp for stamp, *_ in read_tum(folder / "trajectory.tum")]
        self.assertEqual([f"{s:.4f}" for s in DRIVE.stamps], [f"{s:.4f}" for s in stamps])
        self.check_map(folder)
        self.check_session(folder)

    def check_map(self, folder):
        """Walls are where they are, the floor is free, and behind the walls nothing is known."""
        grid = read_pgm(folder / "map.pgm")
        description = (folder / "map.yaml").read_text()
        origin = [float(v) for v in re.search(r"origin: \[(.*)\]", description).group(1).split(",")]
        resolution = float(re.search(r"resolution: (.*)", description).group(1))
        start = read_tum(folder / "trajectory.tum")[0][1:]

        def grey_near(x, y, reach):
            there = compose(start, between(DRIVE.truth[0], (x, y, 0)))
            column, row = (int((there[i] - origin[i]) / resolution) for i in (0, 1))
            row = grid.shape[0] - 1 - row
            return grid[row - reach:row + reach + 1, column - reach:column + reach + 1]

        seen = [0 in grey_near(*point, 2) for point in ((2, 6), (-4, 0), (8, 0), (3, -3), (-4, 3), (0, 2.7), (3, 0.8))]
        self.assertGreaterEqual(sum(seen), 6, seen)
        for x, y in ((-2, -1), (2, 3), (5, 1), (-2, 4)):
            self.assertEqual({254}, set(grey_near(x, y, 1).flat), (x, y))
        for x, y in ((3, 1.2), (10, 0), (-5.5, 2)):
            self.assertFalse(254 in grey_near(x, y, 0), (x, y))
        width, height = struct.unpack(">II", (folder / "map.png").read_bytes()[16:24])
        self.assertGreater(width * height, 10000)

    def check_session(self, folder):
        """The saved session goes on where it ended."""
        done = call(MAP, self.log, "--out", self.folder / "more", "--continue", folder / "map.session", "--scans", 30,
                    "--json", "--quiet")
        self.assertEqual(0, done.returncode, done.stderr)
        self.assertEqual(30, json.loads(done.stdout)["scans"])
        self.assertEqual(30, len(read_tum(self.folder / "more" / "trajectory.tum")))

    def test_packed_logs_give_the_same_map(self):
        text = DRIVE.carmen().encode()
        (self.folder / "room.gz").write_bytes(gzip.compress(text))
        (self.folder / "room.bz2").write_bytes(bz2.compress(text))
        trajectories = set()
        for name in ("room.clf", "room.gz", "room.bz2"):
            _, folder = self.mapped(self.folder / name, "--scans", 120, "--particles", 5, out="of_" + name)
            trajectories.add((folder / "trajectory.tum").read_bytes())
        self.assertEqual(1, len(trajectories), "the same recording and seed give the same path")

    def test_without_odometry(self):
        report, folder = self.mapped(self.log, "--no-odometry", "--scans", 150)
        self.assertEqual(150, report["scans_without_odometry"])
        self.check_path(folder, 0.15, math.radians(2), DRIVE.truth[:150])

    def test_parameters_arrive(self):
        report, _ = self.mapped(self.log, "--scans", 40, "--particles", 4, "--resolution", 0.1, "--set",
                                "linearUpdate=1.5", "--set=minimumScore=0.6")
        parameters = report["parameters"]
        self.assertEqual((4, 0.1, 1.5, 0.6), tuple(parameters[name] for name in (
            "particles", "delta", "linearUpdate", "minimumScore")))
        self.assertEqual(0.1, report["map"]["resolution_m"])

    def test_damaged_logs_are_mapped_as_far_as_they_go(self):
        lines = DRIVE.carmen().splitlines()
        lines[20] = lines[20][:300]
        self.log.write_text("\n".join(lines[:90]) + "\n")
        done = call(MAP, self.log, "--out", self.folder / "out")
        self.assertEqual(0, done.returncode, done.stderr)
        self.assertIn("1 damaged entries left out", done.stdout)
        self.assertIn("room.clf line 21:", done.stdout)
        self.assertIn("written to", done.stdout)
        packed = self.folder / "room.gz"
        packed.write_bytes(gzip.compress(DRIVE.carmen().encode())[:60000])
        done = call(MAP, packed, "--out", self.folder / "cut", "--quiet")
        self.assertEqual(1, done.returncode)
        self.assertRegex(done.stderr, r"^extperfc-map: .*room\.gz is damaged or breaks off.*came before\n$")
        self.assertEqual(FILES, sorted(file.name for file in (self.folder / "cut").iterdir()))

    def test_control_c_writes_what_there_is(self):
        fifo = self.folder / "endless.log"
        text = DRIVE.carmen()
        # Many drives on end: long enough to be interrupted, whatever the machine.
        fifo.write_text(text * 60)
        process = subprocess.Popen([MAP, fifo, "--out", self.folder / "out"], stdout=subprocess.PIPE,
                                   stderr=subprocess.PIPE, text=True)
        self.addCleanup(process.kill)
        line = process.stderr.readline()  # the first tenth is done
        self.assertRegex(line, r"^\d+ %, \d+ scans, ")
        process.send_signal(signal.SIGINT)
        output, errors = process.communicate(timeout=120)
        self.assertEqual(0, process.returncode, errors)
        self.assertIn("interrupted", output)
        self.assertEqual(FILES, sorted(file.name for file in (self.folder / "out").iterdir()))
        report = json.loads((self.folder / "out" / "report.json").read_text())
        self.assertTrue(report["interrupted"])
        self.assertEqual(report["scans"], len(read_tum(self.folder / "out" / "trajectory.tum")))

    def test_a_bar_on_a_terminal(self):
        master, slave = pty.openpty()
        try:
            done = subprocess.run([MAP, self.log, "--out", self.folder / "out", "--particles", "2"], stderr=slave,
                                  stdout=subprocess.PIPE, text=True, timeout=120)
            os.set_blocking(master, False)
            shown = os.read(master, 1 << 20).decode()
        finally:
            os.close(master)
            os.close(slave)
        self.assertEqual(0, done.returncode)
        self.assertRegex(shown, r"\r\[[#.]{30}\] \d+ %  \d+ scans")
        self.assertTrue(shown.endswith("\r\x1b[K"), repr(shown[-40:]))

    def test_wrong_arguments(self):
        for arguments, what in (((), "too few arguments|give a recording"), (("a", "b"), "unexpected argument b"),
                                (("a", "--particels", 3), "did you mean --particles"),
                                (("a", "--particles", 0), "particles"), (("a", "--particles", "many"), "particles"),
                                (("a", "--set", "particles"), "NAME=VALUE"),
                                (("a", "--set", "lineerUpdate=1"), "did you mean linearUpdate"),
                                (("a", "--set", "delta=-1"), "delta|resolution"),
                                (("a", "--laser-pose", "1,2"), "--laser-pose must be 3 numbers"),
                                (("a", "--scans", 0), "--scans"), (("a", "--out"), "--out needs a value")):
            with self.subTest(arguments=arguments):
                done = call(MAP, *arguments)
                self.assertEqual(2, done.returncode)
                self.assertRegex(done.stderr, f"^extperfc-map: .*({what}).*--help\\)\n$")
                self.assertEqual("", done.stdout)

    def test_failures_are_told_in_one_line(self):
        empty = self.folder / "empty.clf"
        empty.write_text("# nothing\n")
        other = self.folder / "other.bin"
        other.write_bytes(bytes(range(256)))
        session = self.folder / "bad.session"
        session.write_bytes(b"no session")
        for arguments, what in (((self.folder / "none.clf",), "cannot read"), ((self.folder,), "is a folder"),
                                ((empty,), "no usable laser scans"), ((other,), "neither a CARMEN log"),
                                ((self.log, "--relations", self.folder / "none"), "cannot read the relations"),
                                ((self.log, "--continue", session), "bad.session"),
                                ((self.log, "--out", self.log / "x"), "cannot make the folder")):
            with self.subTest(arguments=arguments):
                done = call(MAP, *arguments, "--quiet", cwd=self.folder)
                self.assertEqual(1, done.returncode, done.stdout)
                self.assertRegex(done.stderr, f"^extperfc-map: [^\n]*{what}[^\n]*\n$")

    def test_help(self):
        for tool, words in ((MAP, ("RECORDING", "--laser-pose", "resampleThreshold", "Exit status")),
                            (RELATIONS, ("TRAJECTORY", "--odometry", "Kuemmerle", "Exit status"))):
            for flag in ("--help", "-h"):
                done = call(tool, flag)
                self.assertEqual((0, ""), (done.returncode, done.stderr))
                for word in words:
                    self.assertIn(word, done.stdout)
                self.assertLessEqual(max(map(len, done.stdout.splitlines())), 120)

    def test_maps_a_bag(self):
        import genpy
        import rosbag
        from geometry_msgs.msg import TransformStamped
        from nav_msgs.msg import Odometry
        from sensor_msgs.msg import LaserScan
        from tf2_msgs.msg import TFMessage

        def transform(parent, child, stamp, pose):
            message = TransformStamped()
            message.header.frame_id, message.child_frame_id, message.header.stamp = parent, child, stamp
            message.transform.translation.x, message.transform.translation.y = pose[:2]
            message.transform.rotation.z, message.transform.rotation.w = math.sin(pose[2] / 2), math.cos(pose[2] / 2)
            return TFMessage([message])

        count = 150
        for kind in ("tf", "topic"):
            with rosbag.Bag(str(self.folder / f"{kind}.bag"), "w") as bag:
                start = genpy.Time.from_sec(DRIVE.stamps[0])
                bag.write("/tf_static", transform("base_link", "laser", start, (0, 0, 0)), start)
                for i in range(count):
                    stamp = genpy.Time.from_sec(DRIVE.stamps[i])
                    scan = LaserScan(angle_min=-math.pi / 2, angle_increment=math.pi / 180, range_min=0.02,
                                     range_max=30, ranges=DRIVE.scans[i])
                    scan.header.frame_id, scan.header.stamp = "laser", stamp
                    bag.write("/scan", scan, stamp)
                    if kind == "tf":
                        bag.write("/tf", transform("odom", "base_link", stamp, DRIVE.odometry[i]), stamp)
                    else:
                        odometry = Odometry()
                        odometry.header.stamp = stamp
                        pose = odometry.pose.pose
                        pose.position.x, pose.position.y = DRIVE.odometry[i][:2]
                        pose.orientation.z = math.sin(DRIVE.odometry[i][2] / 2)
                        pose.orientation.w = math.cos(DRIVE.odometry[i][2] / 2)
                        bag.write("/odom", odometry, stamp)
            with self.subTest(kind=kind):
                report, folder = self.mapped(self.folder / f"{kind}.bag", out=kind)
                self.assertEqual((count, 0), (report["scans"], report["scans_without_odometry"]))
                self.check_path(folder, 0.15, math.radians(2), DRIVE.truth[:count])
        for arguments, what in ((("--scan-topic", "front"), "no topic front; there are: /scan"),
                                (("--scan-topic", "tf"), "--scan-topic: /tf is of type"),
                                (("--base-frame", "base"), "does not say where the scanner 'laser' sits on 'base'")):
            done = call(MAP, self.folder / "tf.bag", *arguments, "--out", self.folder / "x")
            self.assertEqual(1, done.returncode)
            self.assertIn(what, done.stderr)
        cut = self.folder / "cut.bag"
        cut.write_bytes((self.folder / "tf.bag").read_bytes()[:20000])
        done = call(MAP, cut, "--out", self.folder / "x")
        self.assertEqual(1, done.returncode)
        self.assertRegex(done.stderr, "^extperfc-map: .*cut.bag .*\n$")

    def test_maps_mrpts_recording(self):
        recording = MRPT_DATA / "2006-01ENE-21-SENA_Telecom Faculty_one_loop_only.rawlog"
        if not recording.exists():
            self.skipTest("package mrpt-common is not installed")
        report, folder = self.mapped(recording)
        self.assertEqual(225, report["scans"])
        self.assertGreater(report["loops_closed"], 0)
        self.assertGreater((read_pgm(folder / "map.pgm") == 254).sum() * 0.05 ** 2, 1000, "square metres of free floor")

    def test_maps_mrpts_simulation(self):
        recording = MRPT_DATA / "graphslam-engine-demos/action_observations_map/simul.rawlog"
        truth = pathlib.Path(str(recording) + ".GT.txt")
        if not truth.exists():
            self.skipTest("package mrpt-common is not installed")
        _, folder = self.mapped(recording)
        path = read_tum(folder / "trajectory.tum")
        true = {round(row[0], 3): row[1:] for row in (
            list(map(float, line.split())) for line in truth.read_text().splitlines() if line[:1].isdigit())}
        pairs = [(pose, true[round(stamp, 3)]) for stamp, *pose in path if round(stamp, 3) in true]
        self.assertGreater(len(pairs), 1000)
        errors = [math.hypot(*between(known, pose)[:2]) for pose, known in pairs]
        self.assertLess(sum(errors) / len(errors), 0.5, "of a way of 200 m")

    def test_maps_the_start_of_intel(self):
        recording = SLAM_DATA / "intel.clf.bz2"
        if not recording.exists():
            self.skipTest("../shared/data/slam is not there")
        report, _ = self.mapped(recording, "--scans", 1000, "--relations", SLAM_DATA / "intel.relations")
        self.assertEqual((1000, 0), (report["scans"], report["scans_refused"]))
        score = report["score"]["all"]
        self.assertGreater(score["relations"], 30)
        self.assertLess(score["translation_m"]["mean"], 0.03)
        self.assertLess(score["rotation_deg"]["mean"], 0.6)
        self.assertLess(report["peak_memory_mb"], 80)


class RelationsTool(unittest.TestCase):
    def setUp(self):
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.folder = pathlib.Path(temporary.name)
        self.relations = self.folder / "room.relations"
        self.relations.write_text(DRIVE.relations())

    def write_path(self, indices, poses):
        file = self.folder / "path.tum"
        file.write_text("".join(
            f"{DRIVE.stamps[i]:.6f} {poses[i][0]} {poses[i][1]} 0 0 0 {math.sin(poses[i][2] / 2)} "
            f"{math.cos(poses[i][2] / 2)}\n" for i in indices))
        return file

    def score(self, *arguments):
        done = call(RELATIONS, *arguments, "--json")
        self.assertEqual(0, done.returncode, done.stderr)
        return json.loads(done.stdout)["score"]

    def test_the_truth_scores_zero_and_odometry_does_not(self):
        everything = range(len(DRIVE.truth))
        score = self.score(self.write_path(everything, DRIVE.truth), self.relations)
        self.assertLess(score["all"]["translation_m"]["worst"], 1e-5)
        self.assertLess(score["all"]["rotation_deg"]["worst"], 1e-3)
        odometry = self.score(self.write_path(everything, DRIVE.odometry), self.relations)
        self.assertGreater(odometry["loops"]["translation_m"]["mean"], 0.5)

    def test_sparse_trajectories_need_the_recording(self):
        path = self.write_path(range(0, len(DRIVE.truth), 10), DRIVE.truth)
        done = call(RELATIONS, path, self.relations)
        self.assertEqual(1, done.returncode)
        self.assertRegex(done.stderr, r"^extperfc-relations: .*give the recording \(--odometry RECORDING\).*\n$")
        log = self.folder / "room.clf"
        log.write_text(DRIVE.carmen())
        score = self.score(path, self.relations, "--odometry", log)
        self.assertLess(score["all"]["translation_m"]["mean"], 0.03)
        self.assertGreater(score["all"]["relations"], 50)

    def test_prints_and_draws(self):
        path = self.write_path(range(len(DRIVE.truth)), DRIVE.odometry)
        picture = self.folder / "relations.png"
        done = call(RELATIONS, path, self.relations, "--picture", picture, "--worst", 2, "--loop-span", 200)
        self.assertEqual(0, done.returncode, done.stderr)
        self.assertRegex(done.stdout, r"relations: (\d+) of \1 scored")
        self.assertEqual(2, done.stdout.count("    scans "))
        for group in ("all", "neighbours", "loops"):
            self.assertRegex(done.stdout, rf"  {group} +\d+ +\d\.\d{{4}}")
        self.assertTrue(picture.read_bytes().startswith(b"\x89PNG"))

    def test_errors(self):
        path = self.write_path(range(len(DRIVE.truth)), DRIVE.truth)
        for code, arguments, what in (
                (2, (), "too few arguments"), (2, (path, self.relations, "x"), "unexpected argument x"),
                (2, (path, self.relations, "--worst", -1), "--worst must be a number"),
                (1, (self.folder / "none", self.relations), "cannot read the trajectory"),
                (1, (path, self.folder / "none"), "cannot read the relations"),
                (1, (self.relations, self.relations), "line 2"),
                (1, (path, self.relations, "--odometry", self.folder / "none.clf"), "cannot read"),
                (1, (path, self.relations, "--picture", self.folder / "a.png", "--map", self.folder / "none.yaml"),
                 "none.yaml")):
            with self.subTest(what=what):
                done = call(RELATIONS, *arguments)
                self.assertEqual(code, done.returncode)
                self.assertRegex(done.stderr, f"^extperfc-relations: [^\n]*{what}[^\n]*\n$")


if __name__ == "__main__":
    unittest.main()
