"""Runs that are killed go on to the same bits; two processes learn one model."""

import json
import os
import pathlib
import signal
import subprocess
import sys
import unittest

import yaml

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "unit" / "training"))
from training_case import HERE, TrainingCase, equal, torch  # noqa: E402

from extperfc.training.experiment import ExperimentError  # noqa: E402

if torch:
    from extperfc.training.checkpoints import CheckpointFolder
    from extperfc.training.strategies import read_weights

TIME_LIMIT_S = 300


class Kills(TrainingCase):
    """Processes that end by SIGKILL."""

    def start(self, arguments, launcher=()):
        command = [*(launcher or (sys.executable,)), str(HERE / "tiny_train.py"), *map(str, arguments)]
        environment = dict(os.environ, OMP_NUM_THREADS="1")
        return subprocess.run(command, env=environment, capture_output=True, text=True, timeout=TIME_LIMIT_S)

    def write(self, output, training=None):
        file = self.root / f"{output}.yaml"
        file.write_text(yaml.safe_dump(self.values(output, {"checkpoint_steps": 4, **(training or {})})))
        return file

    def test_resumed_runs_have_the_bits_of_one_that_was_not_killed(self):
        whole, _ = self.train("whole", {"checkpoint_steps": 4})
        file = self.write("killed")
        # In the second epoch, two steps after a checkpoint; then in the middle of writing one; then to the end.
        for arguments in (["--die-at", "step:10"], ["--resume", "--die-at", "save:2"]):
            ended = self.start([file, *arguments])
            self.assertEqual(-signal.SIGKILL, ended.returncode, ended.stderr)
        self.assertEqual(1, len(list((self.root / "killed/checkpoints").glob(".*.partial"))))
        ended = self.start([file, "--resume"])
        self.assertEqual(0, ended.returncode, ended.stderr)
        self.assertIn("going on with epoch", ended.stdout)
        for part in ("network", "average"):
            one, other = (CheckpointFolder(self.root / name / "checkpoints", 2).load_newest()[part]
                          for name in ("whole", "killed"))
            one, other = (state["weights"] if part == "average" else state for state in (one, other))
            self.assertTrue(equal(one, other), part)
        one, other = (read_weights(self.root / name / "weights.pt")["weights"] for name in ("whole", "killed"))
        self.assertTrue(equal(one, other))
        self.assertEqual(whole.history, json.loads((self.root / "killed/history.json").read_text()))

    def test_two_processes_learn_one_model(self):
        file = self.write("two", {"epochs": 2, "batch_size": 2})
        launcher = (sys.executable, "-m", "torch.distributed.run", "--standalone", "--nproc_per_node", "2",
                    "--redirects", "1", "--tee", "1", "--log_dir", str(self.root / "logs"))
        ended = self.start([file, "--digest", self.root / "digest"], launcher)
        self.assertEqual(0, ended.returncode, ended.stderr)
        self.assertEqual(*((self.root / f"digest.{rank}").read_text() for rank in (0, 1)))
        record = json.loads((self.root / "two/provenance.json").read_text())
        self.assertEqual(2, record["processes"])
        history = json.loads((self.root / "two/history.json").read_text())
        self.assertEqual([5, 10], [row["step"] for row in history])  # 21 images in steps of 2 x 2
        with self.assertRaisesRegex(ExperimentError, "begun with 2 processes, not 1"):
            self.train("two", {"checkpoint_steps": 4, "epochs": 2, "batch_size": 2}, resume=True)

if __name__ == "__main__":
    unittest.main()
