"""tools/demo as a user runs it."""

import csv
import json
import math
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest

REPO = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(REPO / "tools" / "lib"))

from test_tiers import long_scenario  # noqa: E402

SHARED = REPO.parent / "shared" / "data"


def demo(*arguments, task=(), timeout=180):
    return subprocess.run([REPO / "tools" / "demo", *task, "--no-rviz", *arguments], capture_output=True, text=True,
                          timeout=timeout)


def read_table(folder):
    with open(pathlib.Path(folder) / "table.csv") as file:
        return list(csv.DictReader(file))


class Demo(unittest.TestCase):
    def test_finds_the_simulated_objects_where_they_are(self):
        with tempfile.TemporaryDirectory() as out:
            done = demo("--seconds", "8", "--out", out)
            self.assertEqual(0, done.returncode, done.stdout + done.stderr)
            found, visible = map(int, re.search(r"^found (\d+) of (\d+) visible objects", done.stdout, re.M).groups())
            self.assertGreater(visible, 50, done.stdout)
            self.assertGreater(found, 0.8 * visible, done.stdout)
            mean_cm = float(re.search(r"mean error ([\d.]+) cm", done.stdout).group(1))
            self.assertLess(mean_cm, 2.5, done.stdout)
            rows = read_table(out)
            self.assertGreater(sum(row["found"] == "1" for row in rows), 50)
            for row in rows:
                if row["found"] == "1" and row["center_x_m"]:
                    self.assert_error_is_the_distance(row)
                    self.assert_surface_lies_before_the_centre(row)
            self.assertGreaterEqual(len(list(pathlib.Path(out).glob("*.png"))), 10)

    def assert_error_is_the_distance(self, row):
        center, truth = ([float(row[f"{name}_{axis}_m"]) for axis in "xyz"] for name in ("center", "true"))
        self.assertAlmostEqual(math.dist(center, truth), float(row["error_m"]), delta=5e-4)

    def assert_surface_lies_before_the_centre(self, row):
        """x y z of a row are what was measured; objects are 4 to 20 cm large, unless the image's border cuts them."""
        center, surface = ([float(row[f"{name}{axis}_m"]) for axis in "xyz"] for name in ("center_", ""))
        x0, y0, x1, y1 = (float(row[name]) for name in ("x0", "y0", "x1", "y1"))
        whole = x0 > 1 and y0 > 1 and x1 < 639 and y1 < 479
        self.assertTrue((0.01 if whole else 0.002) < math.dist(center, surface) < 0.12, row)
        self.assertLess(float(row["sigma_m"]), 0.1, "nothing of the extent is in the error of the surface")

    def test_plays_a_rendered_recording_once(self):
        with tempfile.TemporaryDirectory() as folder:
            images, out = pathlib.Path(folder) / "images", pathlib.Path(folder) / "out"
            subprocess.run([REPO / "tools" / "extperfc-render", images, "--sequence", "--count", "30", "--seed", "7"], check=True, stdout=subprocess.DEVNULL)
            done = demo("--source", images, "--out", out)
            self.assertEqual(0, done.returncode, done.stdout + done.stderr)
            frames = int(re.search(r"^(\d+) frames, (\d+) objects", done.stdout, re.M).group(1))
            self.assertGreaterEqual(frames, 10)
            located = [row for row in read_table(out) if row["depth_m"]]
            self.assertGreater(len(located), frames, "about one object a frame at the very least")
            for row in located:
                self.assertTrue(0.1 < float(row["depth_m"]) < 10.0, row)
            self.assertGreaterEqual(len(list(out.glob("*.png"))), 10)

    def test_real_images_with_a_public_network(self):
        images, model = SHARED / "rgbd" / "dining_room", SHARED / "models" / "fastestdet"
        if not images.exists() or not model.exists():
            self.skipTest("the recordings beside the repository (../shared) are not here")
        with tempfile.TemporaryDirectory() as out:
            done = demo("--source", images, "--model", model, "--rate", "3", "--out", out)
            self.assertEqual(0, done.returncode, done.stdout + done.stderr)
            self.assertGreaterEqual(len(re.findall(r"^\d+ +chair ", done.stdout, re.M)), 5, done.stdout)

    @long_scenario("system/grasp runs the same leaves with one object")
    def test_grasps_shows_and_places_three_objects(self):
        with tempfile.TemporaryDirectory() as out:
            done = demo("--seed", "7", "--out", out, task=["grasp"], timeout=600)
            self.assertEqual(0, done.returncode, done.stdout + done.stderr)
            self.assertIn("1 of 1 runs succeeded, 3 of 3 objects", done.stdout)
            rows = json.loads((pathlib.Path(out) / "grasp.json").read_text())
            self.assertEqual([0.3, 0.4, 0.5], sorted(row["distance_m"] for row in rows))
            for row in rows:
                self.assertLess(abs(row["estimated_m"] - row["true_m"]), 0.01, row)
            self.assertEqual(3, len(list(pathlib.Path(out).glob("shown_7_*.png"))))

    @long_scenario("system/grasp runs most of its leaves")
    def test_fetches_a_cube_in_a_flat(self):
        with tempfile.TemporaryDirectory() as out:
            done = demo("--seed", "12", "--speed", "0.7", "--out", out, task=["tour"], timeout=900)
            self.assertEqual(0, done.returncode, done.stdout + done.stderr)
            row = json.loads((pathlib.Path(out) / "seed_12" / "tour.json").read_text())
            self.assertEqual((0, True), (row["contacts"], row["placed"]), row)
            self.assertEqual(["deliver", "explore", "fetch", "search"], sorted(row["stages_s"]))

    @long_scenario("unit/tasks follows with a base that is made up")
    def test_follows_a_person(self):
        with tempfile.TemporaryDirectory() as out:
            done = demo("--seed", "1", "--seconds", "60", "--out", out, task=["follow"], timeout=600)
            self.assertEqual(0, done.returncode, done.stdout + done.stderr)
            row = json.loads((pathlib.Path(out) / "seed_1" / "follow.json").read_text())
            self.assertGreater(row["driven_m"], 15.0)
            self.assertEqual([], row["ghosts"])

    def test_errors_name_what_is_wrong(self):
        missing = demo("--source", "/no/such/folder")
        self.assertEqual(2, missing.returncode)
        self.assertIn("/no/such/folder does not exist", missing.stderr)
        frame = demo("--frame", "odom")
        self.assertEqual(2, frame.returncode)
        self.assertIn("--frame goes with --source", frame.stderr)
        runs = demo("--runs", "0", task=["grasp"])
        self.assertEqual(2, runs.returncode)
        self.assertIn("--runs and --speed must be positive", runs.stderr)
        faces = demo("--face-model", "/no/such/folder", task=["follow"])
        self.assertEqual(2, faces.returncode)
        self.assertIn("--face-model /no/such/folder is no folder", faces.stderr)
        limit = demo("--limit", "0", task=["tour"])
        self.assertEqual(2, limit.returncode)
        self.assertIn("--limit must be positive", limit.stderr)
        nowhere = demo("--world", "atlantis")
        self.assertEqual(1, nowhere.returncode)
        self.assertIn("there is no world 'atlantis'", nowhere.stderr)
        self.assertIn("lab", nowhere.stderr)
        with tempfile.TemporaryDirectory() as empty:
            broken = demo("--model", empty)
            self.assertEqual(1, broken.returncode)
            self.assertIn("error:", broken.stderr)
            self.assertIn(empty, broken.stderr)
            self.assertNotIn("Traceback", broken.stderr)


if __name__ == "__main__":
    unittest.main()
