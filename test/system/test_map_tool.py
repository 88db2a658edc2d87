"""tools/extperfc-map and tools/extperfc-relations as a user calls them."""

import bz2
import gzip
import io
import json
import math
import os
import pathlib
import pty
import re
import shutil
import signal
import struct
import subprocess
import tempfile
import unittest

import cv2
import numpy

from drawn_room import DRIVE, between, compose, read_pgm, read_tum, write_bag

REPO = pathlib.Path(__file__).resolve().parents[2]
MAP = REPO / "tools" / "extperfc-map"
RELATIONS = REPO / "tools" / "extperfc-relations"
SLAM_DATA = REPO.parent / "shared" / "data" / "slam"
MRPT_DATA = pathlib.Path("/usr/share/mrpt/datasets")
FILES = ["map.pgm", "map.png", "map.session", "map.yaml", "report.json", "report.txt", "trajectory.tum"]


def call(tool, *arguments, **more):
    return subprocess.run([tool, *map(str, arguments)], capture_output=True, text=True, timeout=300, **more)


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

    def check_path(self, folder, max_m, max_rad, truth=None):
        """Errors against the true path, both beginning at the same pose."""
        truth = truth or DRIVE.truth
        path = read_tum(folder / "trajectory.tum")
        self.assertEqual(len(truth), len(path))
        for (_, *pose), true in zip(path, truth):
            error = between(between(truth[0], true), between(path[0][1:], pose))
            self.assertLess(math.hypot(error[0], error[1]), max_m)
            self.assertLess(abs(error[2]), max_rad)

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
        """The saved session resumes where it ended."""
        done = call(MAP, self.log, "--out", self.folder / "more", "--continue", folder / "map.session", "--scans", 30,
                    "--json", "--quiet")
        self.assertEqual(0, done.returncode, done.stderr)
        self.assertEqual(30, json.loads(done.stdout)["scans"])
        self.assertEqual(30, len(read_tum(self.folder / "more" / "trajectory.tum")))

    def test_sessions_are_merged_and_continued_elsewhere(self):
        lines = DRIVE.carmen().splitlines(keepends=True)
        half = len(lines) // 2
        for name, part in (("first", lines[:half]), ("second", lines[half:])):
            (self.folder / f"{name}.clf").write_text("".join(part))
        self.mapped(self.folder / "first.clf", out="first")
        self.mapped(self.folder / "second.clf", out="second")
        sessions = [self.folder / name / "map.session" for name in ("first", "second")]
        both = self.folder / "both"
        done = call(MAP, "--continue", sessions[0], "--merge", sessions[1], "--out", both)
        self.assertEqual(0, done.returncode, done.stderr)
        self.assertIn(f"merging {sessions[1]}", done.stderr)
        self.assertIn(f"merged       {sessions[1]}", done.stdout)
        self.assertEqual(FILES, sorted(file.name for file in both.iterdir()))
        self.check_path(both, 0.15, math.radians(2))
        start = between(DRIVE.truth[0], DRIVE.truth[half])
        done = call(MAP, self.folder / "second.clf", "--continue", sessions[0], "--start-pose",
                    f"{start[0] + 0.3},{start[1] - 0.3},{start[2] + 0.2}", "--out", self.folder / "more", "--json", "--quiet")
        self.assertEqual(0, done.returncode, done.stderr)
        self.assertEqual((0, 1), tuple(json.loads(done.stdout)[key] for key in ("carried", "parts")))
        path = read_tum(self.folder / "more" / "trajectory.tum")
        for true, (_, *pose) in zip(DRIVE.truth[half:], path):
            self.assertLess(math.hypot(*between(between(DRIVE.truth[0], true), pose)[:2]), 0.2)

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

    def test_a_name_that_is_no_text(self):
        """File names are bytes; JSON is UTF-8."""
        odd = self.folder / os.fsdecode(b"r\xffom.clf")
        shutil.copy(self.log, odd)
        done = call(MAP, odd, "--out", self.folder / "odd", "--scans", 10, "--json", "--quiet")
        self.assertEqual(0, done.returncode, done.stderr)
        self.assertEqual(10, json.loads(done.stdout)["scans"])

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
        # Many drives on end: long enough to be interrupted on any machine.
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
                                (("a", "--particels", 3), 'did you mean "--particles"'),
                                (("a", "--particles", 0), "particles"), (("a", "--particles", "many"), "particles"),
                                (("a", "--set", "particles"), "NAME=VALUE"),
                                (("a", "--set", "lineerUpdate=1"), 'did you mean "linearUpdate"'),
                                (("a", "--set", "delta=-1"), "delta|resolution"),
                                (("a", "--laser-pose", "1,2"), "--laser-pose must be 3 numbers"),
                                (("a", "--start-pose", "1,2,3"), "--start-pose needs --continue"),
                                (("--continue", "a"), "give a recording"), (("--merge", "a"), "give a recording"),
                                (("--continue", "a", "--merge", "b", "--simplemap", "c"), "--simplemap needs"),
                                (("a", "--scans", 0), "--scans"), (("a", "--out"), "--out needs a value")):
            with self.subTest(arguments=arguments):
                done = call(MAP, *arguments)
                self.assertEqual(2, done.returncode)
                self.assertRegex(done.stderr, f"^extperfc-map: .*({what}).*--help\\)\n$")
                self.assertEqual("", done.stdout)

    def test_failures_are_reported_in_one_line(self):
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
        for tool, texts in ((MAP, ("RECORDING", "--laser-pose", "resampleThreshold", "Exit status")),
                            (RELATIONS, ("TRAJECTORY", "--odometry", "Kuemmerle", "Exit status"))):
            for flag in ("--help", "-h"):
                done = call(tool, flag)
                self.assertEqual((0, ""), (done.returncode, done.stderr))
                for text in texts:
                    self.assertIn(text, done.stdout)
                self.assertLessEqual(max(map(len, done.stdout.splitlines())), 120)

    def test_maps_a_bag(self):
        count = 150
        for kind in ("tf", "topic"):
            write_bag(self.folder / f"{kind}.bag", DRIVE.stamps[:count], DRIVE.scans, DRIVE.odometry, kind)
            with self.subTest(kind=kind):
                report, folder = self.mapped(self.folder / f"{kind}.bag", out=kind)
                self.assertEqual((count, 0), (report["scans"], report["scans_without_odometry"]))
                self.check_path(folder, 0.15, math.radians(2), DRIVE.truth[:count])
        for arguments, what in ((("--scan-topic", "front"), "no topic front; there are: /scan"),
                                (("--scan-topic", "tf"), "--scan-topic: /tf is of type"),
                                (("--base-frame", "base"), "has no transform of the scanner 'laser' on 'base'")):
            done = call(MAP, self.folder / "tf.bag", *arguments, "--out", self.folder / "x")
            self.assertEqual(1, done.returncode)
            self.assertIn(what, done.stderr)
        cut = self.folder / "cut.bag"
        cut.write_bytes((self.folder / "tf.bag").read_bytes()[:20000])
        done = call(MAP, cut, "--out", self.folder / "x")
        self.assertEqual(1, done.returncode)
        self.assertRegex(done.stderr, "^extperfc-map: .*cut.bag .*\n$")

    def test_maps_for_mrpt(self):
        """The file of poses and scans gives MRPT's own program the room; its grid has the walls of ours."""
        grid, simple = self.folder / "room.gridmap.gz", self.folder / "room.simplemap"
        done = call(MAP, self.log, "--out", self.folder / "out", "--quiet", "--gridmap", grid, "--simplemap", simple)
        if done.returncode == 1 and "without MRPT" in done.stderr:
            self.skipTest("this build has no maps of MRPT")
        self.assertEqual(0, done.returncode, done.stderr)
        self.assertIn(b"COccupancyGridMap2D", gzip.decompress(grid.read_bytes())[:60])
        self.assertIn(b"CSimpleMap", simple.read_bytes()[:40])
        if shutil.which("observations2map") is None:
            self.skipTest("package mrpt-apps is not installed")
        config = self.folder / "grid.ini"
        config.write_text("[MappingApplication]\noccupancyGrid_count=1\n"
                          "[MappingApplication_occupancyGrid_00_creationOpts]\nresolution=0.05\n")
        made = subprocess.run(["observations2map", config, simple, self.folder / "mrpt"], capture_output=True, text=True,
                              stdin=subprocess.DEVNULL, timeout=120)
        self.assertEqual(0, made.returncode, made.stdout + made.stderr)
        image = cv2.imread(str(next(self.folder.glob("mrpt_*OccupancyGridMap2D_00.png"))), cv2.IMREAD_GRAYSCALE)
        limits = next(self.folder.glob("mrpt_*_limits.txt")).read_text().replace("%", "#")
        x_min, _, y_min, _ = numpy.loadtxt(io.StringIO(limits)).ravel()[:4]
        self.assertGreater(self.walls_found_by_mrpt(image, x_min, y_min), 0.95)

    def walls_found_by_mrpt(self, image, x_min, y_min):
        """Fraction of our map's occupied cells that have an occupied one of MRPT's image within a cell (0.05 m)."""
        grid = read_pgm(self.folder / "out" / "map.pgm")[::-1]
        origin = re.search(r"origin: \[(.*)\]", (self.folder / "out" / "map.yaml").read_text()).group(1).split(",")
        rows, columns = numpy.nonzero(grid == 0)
        near_walls = cv2.dilate((image[::-1] < 100).astype(numpy.uint8), numpy.ones((3, 3), numpy.uint8))
        columns = columns + round((float(origin[0]) - x_min) / 0.05)
        rows = rows + round((float(origin[1]) - y_min) / 0.05)
        inside = (rows >= 0) & (columns >= 0) & (rows < near_walls.shape[0]) & (columns < near_walls.shape[1])
        found = near_walls[rows[inside], columns[inside]].sum() / len(rows)
        # An image that is dark everywhere would have every wall.
        self.assertLess(near_walls.mean(), 0.1)
        return found

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
        self.assertLess(sum(errors) / len(errors), 0.5, "of a path of 200 m")

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
        image = self.folder / "relations.png"
        done = call(RELATIONS, path, self.relations, "--image", image, "--worst", 2, "--loop-span", 200)
        self.assertEqual(0, done.returncode, done.stderr)
        self.assertRegex(done.stdout, r"relations: (\d+) of \1 scored")
        self.assertEqual(2, done.stdout.count("    scans "))
        for group in ("all", "neighbours", "loops"):
            self.assertRegex(done.stdout, rf"  {group} +\d+ +\d\.\d{{4}}")
        self.assertTrue(image.read_bytes().startswith(b"\x89PNG"))

    def test_errors(self):
        path = self.write_path(range(len(DRIVE.truth)), DRIVE.truth)
        for code, arguments, what in (
                (2, (), "too few arguments"), (2, (path, self.relations, "x"), "unexpected argument x"),
                (2, (path, self.relations, "--worst", -1), "--worst must be a number"),
                (1, (self.folder / "none", self.relations), "cannot read the trajectory"),
                (1, (path, self.folder / "none"), "cannot read the relations"),
                (1, (self.relations, self.relations), "line 2"),
                (1, (path, self.relations, "--odometry", self.folder / "none.clf"), "cannot read"),
                (1, (path, self.relations, "--image", self.folder / "a.png", "--map", self.folder / "none.yaml"),
                 "none.yaml")):
            with self.subTest(what=what):
                done = call(RELATIONS, *arguments)
                self.assertEqual(code, done.returncode)
                self.assertRegex(done.stderr, f"^extperfc-relations: [^\n]*{what}[^\n]*\n$")


if __name__ == "__main__":
    unittest.main()
