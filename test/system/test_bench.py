"""tools/bench: every benchmark runs, in a short form, and writes the agreed JSON."""

import json
import pathlib
import subprocess
import tempfile
import unittest

REPO = pathlib.Path(__file__).resolve().parents[2]
LOGS = {"intel": "Intel", "fr079": "fr079", "mit-csail": "mit-csail"}  # file and name in the tables
KEYS = {"case", "metric", "unit", "ours", "peer", "peer_name", "ratio", "goal", "met"}


def is_there(log):
    return (REPO / "../shared/data/slam" / f"{log}.clf.bz2").exists()


class Bench(unittest.TestCase):
    def bench(self, name, *options):
        with tempfile.TemporaryDirectory() as folder:
            file = pathlib.Path(folder) / "result.json"
            done = subprocess.run([REPO / "tools" / "bench", name, "--json", file, *options], capture_output=True,
                                  text=True, timeout=300)
            self.assertEqual(0, done.returncode, done.stdout + done.stderr)
            result = json.loads(file.read_text())
        self.assertEqual({"name", "machine", "rows"}, set(result))
        self.assertEqual(name, result["name"])
        self.assertTrue(result["rows"])
        for row in result["rows"]:
            self.assertEqual(KEYS, set(row), row)
            if row["ratio"] is not None:
                self.assertAlmostEqual(row["ours"] / row["peer"], row["ratio"], delta=1e-3 * abs(row["ratio"]), msg=row)
                if row["ours"] != 0:  # a count may be 0 where the peer's is not
                    self.assertGreater(row["ratio"], 0.0, row)
        self.assertIn(result["rows"][0]["case"], done.stdout, "the table shows what the JSON holds")
        return result["rows"]

    def test_arm(self):
        rows = self.bench("arm", "--quick")
        of = {(row["case"], row["metric"]): row for row in rows}
        self.assertTrue(any("unsafe" == metric and row["ours"] == 0 for (_, metric), row in of.items()), sorted(of))
        if ("left arm", "solved") in of:  # the problems are there
            for case in ("left arm", "both arms"):
                self.assertEqual(0, of[case, "paths with a hidden collision"]["ours"])
                self.assertGreaterEqual(of[case, "solved"]["ours"], 90)
                self.assertGreater(of[case, "valid problems"]["ours"], 0)

    def test_depth(self):
        rows = self.bench("depth", "--scenes", "10")
        paper = [row for row in rows if row["goal"] is not None]
        self.assertTrue(paper)

    def test_system(self):
        of = {row["metric"]: row["ours"] for row in self.bench("system", "--seconds", "8", "--cameras", "1", "--slower")}
        for name in ("3D detections per second", "poses in the map per second", "image to 3D detections, median", "mapper: memory"):
            self.assertGreater(of[name], 0, name)

    def test_scan(self):
        rows = self.bench("scan")
        cases = {row["case"] for row in rows}
        self.assertLessEqual({"ground: none", "ground: height", "ground: plane", "ground: slope"}, cases)
        self.assertLessEqual({"full sweep, everything, ground: plane", "full sweep, everything, ground: slope"}, cases)
        self.assertTrue(all(row["goal"] == 3.0 for row in rows), rows)

    def test_map(self):
        rows = self.bench("map", "--quick")
        cases = " ".join(row["case"] for row in rows)
        for particles in (1, 10, 30, 100):
            self.assertIn(f" {particles} particles", cases)
        metrics = {row["metric"] for row in rows}
        self.assertTrue({"translational error", "CPU per scan, p99", "peak memory", "map(), worst call"} <= metrics)
        measured = [row for row in rows if row["metric"] == "translational error"]
        self.assertTrue(all(0 < row["ours"] < 0.2 for row in measured), measured)
        floor = [row for row in measured if row["peer_name"] == "odometry"]
        self.assertTrue(floor)
        self.assertTrue(all(row["ours"] < row["peer"] for row in floor), floor)
        for log in filter(is_there, LOGS):
            self.assertIn(LOGS[log], {row["case"].split(",")[0] for row in floor})
            self.assertIn(f"{LOGS[log]}, first 1000 scans, 30 particles", cases)

    @unittest.skipUnless(is_there("fr079"), "no recording beside the package")
    def test_map_of_one_log(self):
        rows = self.bench("map", "--quick", "--only", "log", "--log", "fr079")
        self.assertEqual({"fr079"}, {row["case"].split(",")[0] for row in rows})

    def test_map_of_an_unknown_log_is_one_clear_error(self):
        done = subprocess.run([REPO / "tools" / "bench", "map", "--log", "nonsense"], capture_output=True, text=True,
                              timeout=300)
        self.assertNotEqual(0, done.returncode)
        self.assertIn("--log needs intel, fr079 or mit-csail, not 'nonsense'", done.stdout + done.stderr)

    @unittest.skipUnless(is_there("intel"), "no recording beside the package")
    def test_localize(self):
        rows = self.bench("localize", "--quick")
        memory = [row for row in rows if row["metric"] == "peak memory"]
        self.assertEqual([True], [row["met"] for row in memory])

    def test_translate(self):
        rows = self.bench("translate", "--samples", "20", "--seconds", "1", "--topics", "20", "--rate", "500")
        by_case = {row["case"].split(",")[0] for row in rows}
        self.assertTrue({"200 B", "6 MB", "20 topics"} <= by_case, by_case)
        self.assertTrue(all(row["ours"] == 0.0 for row in rows if row["metric"] == "damaged"), rows)

    def test_transport(self):
        rows = self.bench("transport", "--pairs", "30")
        self.assertTrue(any("TCP" in (row["peer_name"] or "") or "TCP" in row["case"] for row in rows), rows)

    def test_networks(self):
        try:
            import torch  # noqa: F401
        except ImportError:
            self.skipTest("no PyTorch: tools/setup --tests installs what training needs")
        rows = self.bench("networks", "--quick", "--network", "squeezenet_ssd_lite")
        frames = {row["case"]: row["ours"] for row in rows if row["metric"] == "frames"}
        self.assertIn("SqueezeNet-SSD-Lite, opencv CPU, f32", frames)
        self.assertEqual([None], [value for case, value in frames.items() if "NCS2" in case])
        self.assertTrue(all(value > 0 for case, value in frames.items() if "NCS2" not in case), frames)

    def test_detect(self):
        rows = self.bench("detect", "--frames", "10", "--threads", "1")
        self.assertTrue(any(row["goal"] is not None for row in rows))

    def test_unknown_name_is_one_clear_error(self):
        done = subprocess.run([REPO / "tools" / "bench", "nonsense"], capture_output=True, text=True, timeout=60)
        self.assertNotEqual(0, done.returncode)
        self.assertIn("nonsense", done.stderr)
        self.assertIn("detect", done.stderr)


if __name__ == "__main__":
    unittest.main()
