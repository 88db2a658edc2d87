"""tools/demo as a user runs it."""

import csv
import pathlib
import re
import subprocess
import tempfile
import unittest

REPO = pathlib.Path(__file__).resolve().parents[2]
SHARED = REPO.parent / "shared" / "data"


def demo(*arguments):
    return subprocess.run([REPO / "tools" / "demo", "--no-rviz", *arguments], capture_output=True, text=True,
                          timeout=180)


class Demo(unittest.TestCase):
    def test_plays_the_default_and_stops_by_itself(self):
        with tempfile.TemporaryDirectory() as out:
            done = demo("--seconds", "6", "--out", out)
            self.assertEqual(0, done.returncode, done.stdout + done.stderr)
            frames = int(re.search(r"^(\d+) frames, (\d+) objects", done.stdout, re.M).group(1))
            self.assertGreaterEqual(frames, 10)
            with open(pathlib.Path(out) / "table.csv") as file:
                rows = list(csv.DictReader(file))
            located = [row for row in rows if row["depth_m"]]
            self.assertGreater(len(located), frames, "about one object a frame at the very least")
            for row in located:
                self.assertTrue(0.1 < float(row["depth_m"]) < 10.0, row)
            self.assertGreaterEqual(len(list(pathlib.Path(out).glob("*.png"))), 10)

    def test_real_pictures_with_a_public_network(self):
        pictures, model = SHARED / "rgbd" / "dining_room", SHARED / "models" / "fastestdet"
        if not pictures.exists() or not model.exists():
            self.skipTest("the recordings beside the repository (../shared) are not here")
        with tempfile.TemporaryDirectory() as out:
            done = demo("--source", pictures, "--model", model, "--rate", "3", "--out", out)
            self.assertEqual(0, done.returncode, done.stdout + done.stderr)
            self.assertGreaterEqual(len(re.findall(r"^\d+ +chair ", done.stdout, re.M)), 5, done.stdout)

    def test_errors_name_what_is_wrong(self):
        missing = demo("--source", "/no/such/folder")
        self.assertEqual(2, missing.returncode)
        self.assertIn("/no/such/folder does not exist", missing.stderr)
        with tempfile.TemporaryDirectory() as empty:
            broken = demo("--model", empty)
            self.assertEqual(1, broken.returncode)
            self.assertIn("error:", broken.stderr)
            self.assertIn(empty, broken.stderr)
            self.assertNotIn("Traceback", broken.stderr)


if __name__ == "__main__":
    unittest.main()
