"""tools/extperfc-train as a user calls it, with the real networks: two of them here, all five with tools/test --all."""

import json
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import time
import unittest

import cv2
import test_tiers
import yaml

REPO = pathlib.Path(__file__).resolve().parents[2]
TOOL = REPO / "tools" / "extperfc-train"
UNIT = REPO / "test" / "unit" / "training"
TIME_LIMIT_S = 1800
STRATEGIES = ("random_weights", "feature_representation_transfer", "instance_transfer")
SMALL = ("squeezenet_ssd_lite", "mobilenet_v1_ssd")
ALL = (*SMALL, "mobilenet_v2_ssd_lite", "vgg16_ssd", "yolov7_tiny_320")

sys.path.insert(0, str(REPO / "src"))
from extperfc.training.data import drawn  # noqa: E402

try:
    import matplotlib  # noqa: F401
    import torch  # noqa: F401
    import torchvision  # noqa: F401
    WHY_NOT = ""
except ImportError as error:
    WHY_NOT = f"{error}: tools/setup --training installs what training needs"


def call(*arguments, **more):
    environment = dict(os.environ, OMP_NUM_THREADS="1")
    return subprocess.run([*map(str, arguments)],
                          capture_output=True,
                          text=True,
                          timeout=TIME_LIMIT_S,
                          env=environment,
                          **more)


def waited(condition, seconds):
    """Whether a condition holds within some seconds."""
    end = time.monotonic() + seconds
    while not condition():
        if time.monotonic() > end:
            return False
        time.sleep(0.2)
    return True


class Place(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.place = tempfile.TemporaryDirectory()
        cls.addClassCleanup(cls.place.cleanup)
        cls.folder = pathlib.Path(cls.place.name)

    def check_matrix(self, output, networks):
        rows = json.loads((output / "matrix.json").read_text())
        self.assertEqual([(n, s) for n in networks for s in STRATEGIES], [(r["network"], r["strategy"]) for r in rows])
        for row in rows:
            self.assertTrue(0 <= row["mean_ap"] <= 1 and 0 < row["lowest_validation_loss"] < 1000, row)
            run = output / row["network"] / row["strategy"]
            for name in ("weights.pt", "provenance.json", "curves.png", "test/report.md", "test/mistakes.png"):
                self.assertTrue((run / name).exists(), f"{run}/{name}")
        for name in ("ap_over_iou.png", "validation_loss.png"):
            self.assertIsNotNone(cv2.imread(str(output / name)))
        return rows


class WithoutTraining(Place):
    """What needs no PyTorch."""

    def test_check_and_split(self):
        data = self.folder / "data"
        drawn.write_drawn(data, "solids", 20, 1, (64, 48))
        sound = call(TOOL, "check", data, "--json", self.folder / "report.json")
        self.assertEqual(0, sound.returncode, sound.stderr)
        self.assertEqual(20, json.loads((self.folder / "report.json").read_text())["images"])
        refused = call(TOOL, "split", data)
        self.assertEqual(2, refused.returncode)
        self.assertRegex(refused.stderr, "extperfc-train: .* is there already: give --replace")
        made = call(TOOL, "split", data, "--replace", "--seed", "7")
        self.assertEqual(0, made.returncode, made.stderr)
        self.assertRegex(made.stdout, r"train: 1\d images; cone \d+, cube \d+, sphere \d+")
        (data / "JPEGImages" / "000003.png").unlink()
        damaged = call(TOOL, "check", data)
        self.assertEqual(1, damaged.returncode)
        self.assertIn("no image JPEGImages/000003.jpg", damaged.stdout)

    def test_help_and_errors_without_a_traceback(self):
        for arguments in (["--help"], ["train", "--help"], ["matrix", "--help"]):
            shown = call(TOOL, *arguments)
            self.assertEqual(0, shown.returncode, shown.stderr)
        self.assertRegex(call(TOOL, "train", "--help").stdout, r"learning_rate: 0\n +highest learning rate")
        (self.folder / "bad.yaml").write_text("trainign: {}\n")
        for arguments in (["train", self.folder / "bad.yaml"], ["evaluate", self.folder / "none",
                                                                self.folder], ["check", "/none"]):
            failed = call(TOOL, *arguments)
            self.assertEqual(2, failed.returncode, failed.stderr)
            self.assertTrue(failed.stderr.startswith("extperfc-train: "), failed.stderr)
            self.assertNotIn("Traceback", failed.stderr)


@unittest.skipIf(WHY_NOT, WHY_NOT)
class Matrix(Place):
    """Two networks with three strategies, and what a user does with the result."""

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.output = cls.folder / "matrix"
        cls.command = (TOOL, "matrix", "--smoke", "--output", cls.output, "--networks", *SMALL)
        cls.ended = call(*cls.command)

    def test_every_run_of_two_networks(self):
        self.assertEqual(0, self.ended.returncode, self.ended.stderr)
        self.check_matrix(self.output, SMALL)
        transfers = re.findall(r"instance_transfer: (\d+) tensors copied, 0 frozen, (\d+) initialized",
                               self.ended.stdout)
        self.assertEqual(2, len(transfers))
        self.assertTrue(all(int(copied) > 5 * int(left) > 0 for copied, left in transfers), transfers)

    def test_started_again_it_trains_nothing_again(self):
        runs = {file: file.stat().st_mtime_ns for file in self.output.rglob("weights.pt")}
        rows = json.loads((self.output / "matrix.json").read_text())
        again = call(*self.command, "--jobs", "2")
        self.assertEqual(0, again.returncode, again.stderr)
        self.assertEqual(runs, {file: file.stat().st_mtime_ns for file in self.output.rglob("weights.pt")})
        self.assertEqual(rows, json.loads((self.output / "matrix.json").read_text()), "networks side by side: the same")
        for network in SMALL:
            self.assertIn(f"{network} is finished", again.stdout)
            self.assertIn("mAP", (self.output / network / "log.txt").read_text())

    def test_side_by_side_every_failure_is_named(self):
        (self.folder / "empty").mkdir()
        failed = call(TOOL, "matrix", "--smoke", "--data", self.folder / "empty", "--jobs", "2", "--output",
                      self.folder / "failed", "--networks", *SMALL)
        self.assertEqual(2, failed.returncode, failed.stderr)
        for network in SMALL:
            self.assertRegex(failed.stderr, f"{network}: .*empty")
        self.assertNotIn("Traceback", failed.stderr)

    def test_evaluate_a_run(self):
        run = self.output / SMALL[0] / "instance_transfer"
        shown = call(TOOL, "evaluate", run, self.output / "drawn_target", "--output", self.folder / "evaluation")
        self.assertEqual(0, shown.returncode, shown.stderr)
        of_matrix = json.loads((run / "test" / "report.json").read_text())
        alone = json.loads((self.folder / "evaluation" / "report.json").read_text())
        self.assertEqual(of_matrix["mean_ap_over_iou"], alone["mean_ap_over_iou"])


@unittest.skipIf(WHY_NOT, WHY_NOT)
class Long(Place):
    @test_tiers.long_scenario("Matrix has two of the five networks")
    def test_all_fifteen_runs(self):
        ended = call(TOOL, "matrix", "--smoke", "--output", self.folder / "matrix", "--networks", *ALL)
        self.assertEqual(0, ended.returncode, ended.stderr)
        self.assertEqual(15, len(self.check_matrix(self.folder / "matrix", ALL)))

    @test_tiers.long_scenario("Matrix has networks side by side that end by themselves")
    def test_networks_side_by_side_end_with_the_program_that_began_them(self):
        output = self.folder / "left"
        command = [TOOL, "matrix", "--output", output, "--device", "cpu", "--jobs", "2", "--workers", "0", "--batch-size", "2",
                   "--networks", *SMALL]
        drawn.write_drawn(self.folder / "few", "solids", 40, 3, (96, 72))
        with subprocess.Popen([*map(str, command), "--data", self.folder / "few", "--source-data", self.folder / "few"],
                              stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL) as program:
            logs = [output / name / "source" / "provenance.json" for name in SMALL]
            self.assertTrue(waited(lambda: all(log.exists() for log in logs), 120), "they do not begin")
            began = [int(pid) for pid in pathlib.Path(f"/proc/{program.pid}/task/{program.pid}/children").read_text().split()]
            program.kill()
        self.assertGreaterEqual(len(began), 2)
        self.assertTrue(waited(lambda: not any(pathlib.Path(f"/proc/{pid}").exists() for pid in began), 60), began)

    @test_tiers.long_scenario("test_training_kills has two processes, and the kill of one")
    def test_two_processes_that_are_killed_go_on_to_the_same_bits(self):
        drawn.write_drawn(self.folder / "data", "solids", 30, 3, (96, 72))
        training = {"epochs": 3, "warmup_epochs": 1, "batch_size": 2, "workers": 0, "threads": 1, "device": "cpu",
                    "checkpoint_steps": 3}
        digests = []
        for name, runs in (("whole", [[]]), ("killed", [["--die-at", "step:8"], ["--resume"]])):
            file = self.folder / f"{name}.yaml"
            file.write_text(yaml.safe_dump({"data": {"path": "data"}, "output": name, "training": training}))
            for arguments in runs:
                ended = call("/usr/bin/python3", "-m", "torch.distributed.run", "--standalone", "--nproc_per_node", 2,
                             "--redirects", 1, "--tee", 1, "--log_dir", self.folder / "logs", UNIT / "tiny_train.py",
                             file, "--digest", self.folder / name, *arguments)
                self.assertEqual("--die-at" in arguments, ended.returncode != 0, ended.stderr)
            digests.append((self.folder / f"{name}.0").read_text())
        self.assertEqual(*digests)


if __name__ == "__main__":
    unittest.main()
