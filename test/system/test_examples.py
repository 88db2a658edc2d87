"""The programs in examples/ run, and print what they are for."""

import os
import pathlib
import re
import subprocess
import tempfile
import unittest

REPO = pathlib.Path(__file__).resolve().parents[2]
PROGRAMS = pathlib.Path(os.environ.get("EXTPERFC_WS", REPO / ".ws")) / "devel" / "lib" / "extperfc"
MAX_LINES = 60


class Examples(unittest.TestCase):
    def run_example(self, name, *arguments):
        done = subprocess.run([str(PROGRAMS / f"example_{name}"), *map(str, arguments)], capture_output=True, text=True,
                              timeout=100)
        self.assertEqual(0, done.returncode, done.stderr)
        return done.stdout

    def number(self, pattern, text):
        found = re.search(pattern, text)
        self.assertIsNotNone(found, text)
        return float(found.group(1))

    def test_each_is_short_and_listed(self):
        readme = (REPO / "examples" / "README.md").read_text()
        sources = sorted((REPO / "examples").glob("*.cpp"))
        self.assertGreaterEqual(len(sources), 8)
        for source in sources:
            self.assertLessEqual(len(source.read_text().splitlines()), MAX_LINES, source.name)
            self.assertIn(f"`{source.stem}", readme)

    def test_detect_image(self):
        text = self.run_example("01_detect_image", REPO / "docs/images/arm_grasp.png")
        self.assertRegex(text, r"(cone|cube|sphere) 0\.\d+ at x")

    def test_an_image_that_is_missing_is_named(self):
        done = subprocess.run([str(PROGRAMS / "example_01_detect_image"), "/nowhere.png"], capture_output=True, text=True,
                              timeout=100)
        self.assertEqual(1, done.returncode)
        self.assertIn("/nowhere.png", done.stderr)

    def test_locate_box(self):
        self.assertAlmostEqual(0.8, self.number(r"depth ([\d.]+) m", self.run_example("02_locate_box")), delta=0.001)

    def test_map_and_localize(self):
        log = REPO / "test/data/carmen/small.clf"
        with tempfile.TemporaryDirectory() as folder:
            floor = pathlib.Path(folder) / "floor"
            text = self.run_example("03_map_log", log, floor)
            self.assertGreater(self.number(r"(\d+) scans", text), 0)
            self.assertGreater(self.number(r"(\d+) updates", self.run_example("04_localize", f"{floor}.yaml", log)), 0)

    def test_plan_arm(self):
        self.assertGreater(self.number(r"(\d+) points", self.run_example("05_plan_arm")), 2)

    def test_certify_path(self):
        text = self.run_example("06_certify_path")
        self.assertIn("aside: proven free", text)
        self.assertLess(self.number(r"down: free up to ([\d.]+) %", text), 100)
        self.assertIn("inside table", text)

    def test_translate_message(self):
        text = self.run_example("07_translate_message")
        self.assertIn("would convert it", text)
        self.assertGreater(self.number(r"became (\d+)", text), 0)

    def test_build_world(self):
        text = self.run_example("08_build_world")
        self.assertAlmostEqual(0.4, self.number(r"drove to x ([\d.]+) m", text), delta=0.15)
        self.assertAlmostEqual(0.1, self.number(r"lies at\s+\S+\s+\S+\s+(\S+) m", text), delta=0.01)


if __name__ == "__main__":
    unittest.main()
