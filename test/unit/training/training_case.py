"""What tests of training have in common: drawn images in a folder, and quick runs of the tiny network on them."""

import pathlib
import sys
import tempfile
import unittest
import unittest.mock

ROOT = pathlib.Path(__file__).resolve().parents[3]
HERE = pathlib.Path(__file__).resolve().parent
sys.path[:0] = [str(ROOT / "src"), str(HERE)]

try:
    import matplotlib  # noqa: F401
    import torch
    import torchvision  # noqa: F401
    WHY_NOT = ""
except ImportError as error:
    torch, WHY_NOT = None, f"{error}: tools/setup --training installs what training needs"

from extperfc.training import experiment  # noqa: E402
from extperfc.training.data import drawn  # noqa: E402

if torch:
    import tiny_network

    from extperfc.training import curves, trainer
    torch.set_num_threads(1)

FAST = {"epochs": 3, "warmup_epochs": 1, "batch_size": 4, "workers": 0, "threads": 1, "learning_rate": 0.003,
        "average_decay": 0.9, "device": "cpu"}


def equal(one, other):
    """Whether two state dictionaries hold the same bits."""
    return one.keys() == other.keys() and all(torch.equal(one[name], other[name]) for name in one)


@unittest.skipIf(WHY_NOT, WHY_NOT)
class TorchCase(unittest.TestCase):
    """Tests that need PyTorch; modules that import it are imported `if torch`."""


class TrainingCase(TorchCase):
    """A folder with drawn images, and runs in it."""

    @classmethod
    def setUpClass(cls):
        cls.place = tempfile.TemporaryDirectory()
        cls.root = pathlib.Path(cls.place.name)
        cls.data = drawn.write_drawn(cls.root / "data", "solids", 30, 3, (96, 72))

    @classmethod
    def tearDownClass(cls):
        cls.place.cleanup()

    def values(self, output, training=None, **others):
        return {"data": {"path": "data"}, "output": output, "training": {**FAST, **(training or {})}, **others}

    def make(self, output, training=None, **others):
        return experiment.make(self.values(output, training, **others), self.root / "x.yaml")

    def train(self, output, training=None, resume=False, **others):
        reports = []
        run = trainer.Trainer(self.make(output, training, **others), resume, tiny_network.build, reports.append)
        with unittest.mock.patch.object(curves, "draw_run"):  # takes longer than such a run
            run.run()
        return run, reports
