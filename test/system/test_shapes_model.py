"""The shipped detector on images rendered here, none of which it was trained on."""

import pathlib
import subprocess
import sys
import tempfile
import unittest

REPO = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(REPO / "src"))

from extperfc.training.shapes import evaluate  # noqa: E402

MODEL = REPO / "models" / "shapes"


class ShapesModel(unittest.TestCase):
    """The bounds are the figures of the model card, less twice what 40 images of ten worlds let them vary."""

    def look(self, min_found, max_false, *arguments):
        score = float((MODEL / "model.yaml").read_text().split("score:")[1].split(",")[0])
        with tempfile.TemporaryDirectory() as folder:
            subprocess.run([REPO / "tools" / "extperfc-render", folder, "--count", "40", "--val", "1", *arguments],
                           check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
            counts = evaluate.found_and_false(evaluate.Detector(MODEL / "shapes.onnx"), folder, score)
        self.assertGreater(counts["objects"], 100)
        self.assertGreaterEqual(counts["found"] / counts["objects"], min_found, counts)
        self.assertLessEqual(counts["false"] / counts["images"], max_false, counts)

    def test_the_laboratory(self):
        world = str(REPO / "config" / "worlds" / "lab.yaml")
        self.look(0.89, 0.45, "--world", world, "--seed", "77", "--supersampling", "1")

    def test_ordinary_rooms(self):
        self.look(0.77, 1.2, "--seed", "78")


if __name__ == "__main__":
    unittest.main()
