"""tools/soak_robot for some minutes: parts of the whole robot end, hang and fail, and nothing else is lost."""

import json
import pathlib
import subprocess
import tempfile
import unittest

REPO = pathlib.Path(__file__).resolve().parents[2]


class RobotSoak(unittest.TestCase):
    def soak(self, *arguments):
        with tempfile.TemporaryDirectory() as folder:
            done = subprocess.run([REPO / "tools" / "soak_robot", *arguments, "--out", folder], capture_output=True, text=True,
                                  timeout=1200)
            self.assertEqual(0, done.returncode, done.stdout + done.stderr)
            result = json.loads((pathlib.Path(folder) / "soak.json").read_text())
        self.assertGreaterEqual(len(result["faults"]), 10)
        self.assertGreaterEqual(sum(task["done"] for task in result["tasks"]), 10)

    def test_ten_minutes_of_faults(self):
        self.soak("--minutes", "10")

    def test_five_minutes_behind_a_translator(self):
        self.soak("--minutes", "5", "--every", "3", "--translated")


if __name__ == "__main__":
    unittest.main()
