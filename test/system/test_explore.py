"""tools/trial_explore and, in the map that it makes, tools/trial_navigate, as a user runs them."""

import json
import pathlib
import subprocess
import sys
import tempfile
import unittest

REPO = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(REPO / "tools" / "lib"))

from test_tiers import long_scenario  # noqa: E402


def run(tool, *arguments, timeout=240):
    return subprocess.run([REPO / "tools" / tool, *map(str, arguments)], capture_output=True, text=True, timeout=timeout)


class Explore(unittest.TestCase):
    @long_scenario("a minute; ros/explorer and unit/navigate explore floors without the simulator")
    def test_maps_the_flat_and_drives_in_its_map(self):
        with tempfile.TemporaryDirectory() as folder:
            out = pathlib.Path(folder)
            done = run("trial_explore", "--world", "flat", "--speed", 2, "--out", out, "--json", out / "explore.json")
            self.assertEqual(0, done.returncode, done.stdout + done.stderr)
            result = json.loads((out / "explore.json").read_text())
            self.assertTrue(result["finished"], result["message"])
            self.assertGreater(result["floor_m2"], 30)
            self.assertGreater(result["driven_m"], 5)
            self.assertLess(result["map_error_m"], 0.05)
            self.assertTrue((out / "map_1.png").exists())
            done = run("trial_navigate", "--world", "flat", "--speed", 2, "--goals", 2, "--out", out, "--map", out / "map_1.yaml",
                       "--json", out / "drive.json")
            self.assertEqual(0, done.returncode, done.stdout + done.stderr)
            self.assertEqual(2, json.loads((out / "drive.json").read_text())["summary"]["reached"])

    def test_bad_arguments_are_refused(self):
        for arguments in (("--people", "-3"), ("--speed", "0"), ("--fine", "1"), ("--limit", "-1")):
            done = run("trial_explore", *arguments)
            self.assertEqual(2, done.returncode, arguments)
            self.assertIn("must", done.stderr)
        done = run("trial_navigate", "--map", "no/such.yaml")
        self.assertEqual(2, done.returncode)
        self.assertIn("tools/trial_explore makes one", done.stderr)


if __name__ == "__main__":
    unittest.main()
