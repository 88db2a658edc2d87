#!/usr/bin/python3
"""Model folders and detection in Python, layout by layout against numbers worked by hand."""

import pathlib
import shutil
import sys
import tempfile
import unittest

import numpy

REPO = pathlib.Path(__file__).resolve().parents[3]
sys.path.insert(0, str(REPO / "src"))

from extperfc.label import detector, model_folder  # noqa: E402
from extperfc.label.model_folder import ModelError  # noqa: E402

INPUT = "name: m\nfile: net.onnx\ninput: {width: 100, height: 200}\nclasses: [a, b]\n"


class WithFolder(unittest.TestCase):
    def setUp(self):
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.path = pathlib.Path(temporary.name)
        (self.path / "net.onnx").write_bytes(b"")

    def spec(self, output, more="", base=INPUT):
        (self.path / "model.yaml").write_text(f"{base}output: {output}\n{more}")
        return model_folder.load(self.path)


class Folders(WithFolder):
    def test_shipped_model(self):
        spec = model_folder.load(REPO / "models" / "shapes")
        self.assertEqual(("yolo_v8", 512, 384, ("cone", "cube", "sphere"), True, False),
                         (spec.layout, spec.width, spec.height, spec.classes, spec.is_letterbox, spec.is_bgr))
        numpy.testing.assert_allclose(spec.scale, 1 / 255, rtol=1e-5)

    def test_problems_name_file_and_key(self):
        for output, more, expected in (
            ("{layout: yolo_anchors}", "",
             "yolo_anchors cannot propose boxes here: use a model of layout ssd, ssd_priors"),
            ("{layout: yolo_grid}", "", "yolo_grid cannot propose"), ("{layout: ssd, names: [boxes]}", "",
                                                                      "output.names"),
            ("{layout: yolo_v8, nonsense: 1}", "",
             "unknown key output.nonsense"), ("{layout: yolo_v8}", "thresholds: {score: 2}", "thresholds.score"),
            ("{layout: yolo_v8}", "sha256: " + "0" * 64,
             "sha256"), ("{layout: yolo_v8}", "classes_file: gone.txt",
                         "gone.txt"), ("{layout: ssd_priors, names: [o, s], priors: [[1, 2, 3]]}", "",
                                       "output.priors"), ("[]", "", "output must be a mapping")):
            with self.subTest(expected):
                with self.assertRaisesRegex(ModelError, expected) as caught:
                    self.spec(output, more)
                self.assertIn(str(self.path), str(caught.exception))
        with self.assertRaisesRegex(ModelError, "models/shapes"):
            model_folder.load(self.path / "gone")
        (self.path / "model.yaml").write_text("a: [")
        with self.assertRaisesRegex(ModelError, "no YAML"):
            model_folder.load(self.path)

    def test_priors_of_a_level(self):
        spec = self.spec(
            "{layout: ssd_priors, names: [o, s], priors: {levels: [{stride: 100, min_size: 40, max_size: 90, "
            "aspect_ratios: [4]}]}}")
        self.assertEqual((2 * 4, 4), spec.priors.shape)  # 1 x 2 cells
        expected = [[0.5, 0.25, 0.4, 0.2], [0.5, 0.25, 0.6, 0.3], [0.5, 0.25, 0.8, 0.1], [0.5, 0.25, 0.2, 0.4]]
        numpy.testing.assert_allclose(expected, spec.priors[:4], atol=1e-6)
        numpy.testing.assert_allclose([0.5, 0.75], spec.priors[4, :2])


class Decoding(WithFolder):
    def test_ssd(self):
        spec = self.spec("{layout: ssd, names: [b, s], background_class: 0}")
        corners, scores = detector.decode(spec,
                                          [numpy.float32([[[0.1, 0.2, 0.5, 0.6]]]),
                                           numpy.float32([[[0.1, 0.2, 0.7]]])])
        numpy.testing.assert_allclose([[10, 40, 50, 120]], corners)
        numpy.testing.assert_allclose([[0.2, 0.7]], scores)

    def test_ssd_priors_with_softmax(self):
        spec = self.spec(
            "{layout: ssd_priors, names: [o, s], background_class: 0, apply_softmax: true, "
            "priors: [[0.5, 0.5, 0.2, 0.4]]}"
        )
        offsets = numpy.float32([[[1, -1, numpy.log(2) / 0.2, 0]]])
        corners, scores = detector.decode(spec, [offsets, numpy.log(numpy.float32([[[1, 1, 2]]]))])
        # Centre 0.5 + 0.1 * 0.2, 0.5 - 0.1 * 0.4; size 0.4, 0.4; of 100 x 200 px.
        numpy.testing.assert_allclose([[32, 52, 72, 132]], corners, atol=1e-4)
        numpy.testing.assert_allclose([[0.25, 0.5]], scores, atol=1e-6)

    def test_yolo(self):
        v7 = self.spec("{layout: yolo_v7}")
        corners, scores = detector.decode(v7, [numpy.float32([[[50, 60, 20, 40, 0.5, 0.4, 0.8]]])])
        numpy.testing.assert_allclose([[40, 40, 60, 80]], corners)
        numpy.testing.assert_allclose([[0, 0.4]], scores)
        v8 = self.spec("{layout: yolo_v8}")
        corners, scores = detector.decode(v8, [numpy.float32([[[50], [60], [20], [40], [0.9], [0.8]]])])
        numpy.testing.assert_allclose([[40, 40, 60, 80]], corners)
        numpy.testing.assert_allclose([[0.9, 0]], scores)

    def test_wrong_shapes_are_explained(self):
        spec = self.spec("{layout: yolo_v8}")
        with self.assertRaisesRegex(ModelError, r"shape \[7, 100\].*yolo_v8 with 2 classes needs \[6, N\]"):
            detector.decode(spec, [numpy.zeros((1, 7, 100), numpy.float32)])
        spec = self.spec("{layout: ssd_priors, names: [o, s], priors: [[0.5, 0.5, 0.2, 0.4]]}")
        with self.assertRaisesRegex(ModelError, "2 candidates.*1 priors"):
            detector.decode(spec, [numpy.zeros((2, 4), numpy.float32), numpy.zeros((2, 2), numpy.float32)])

    def test_suppression_is_within_a_class(self):
        spec = self.spec("{layout: yolo_v8}", "thresholds: {nms_iou: 0.5}")
        corners = numpy.float32([[0, 0, 40, 40], [1, 0, 41, 40], [0, 0, 40, 40], [60, 60, 90, 90]])
        scores = numpy.float32([[0.9, 0], [0.8, 0], [0, 0.7], [0.3, 0]])
        self.assertEqual([(0, 0.9), (1, 0.7)], [(index, round(score, 4))
                                                for index, score, _ in detector.suppress(spec, corners, scores, 0.5)])

    def test_letterbox(self):
        spec = self.spec("{layout: yolo_v8}",
                         base=INPUT.replace("height: 200", "height: 200, resize: letterbox, mean: 14, scale: 0.5"))
        blob, area = detector.preprocess(spec, numpy.full((50, 100, 3), (0, 20, 40), numpy.uint8))
        self.assertEqual(((1, 3, 200, 100), (0, 75, 100, 50)), (blob.shape, area))
        numpy.testing.assert_allclose([50, 50, 50], blob[0, :, 0, 0])
        numpy.testing.assert_allclose([13, 3, -7], blob[0, :, 100, 50], atol=1e-5)  # red first


class Network(WithFolder):
    def test_a_damaged_network_is_named(self):
        shutil.copy(REPO / "models" / "shapes" / "model.yaml", self.path)
        text = (self.path / "model.yaml").read_text().replace("sha256: ", "source: ",
                                                              1).replace("source: trained", "license: trained")
        (self.path / "model.yaml").write_text("\n".join(line for line in text.splitlines()
                                                        if not line.startswith("license: BSD")))
        (self.path / "shapes.onnx").write_bytes(b"no network")
        with self.assertRaisesRegex(ModelError, "cannot load .*shapes.onnx"):
            detector.Detector(self.path)

    def test_boxes_map_back_to_the_image(self):
        network = detector.Detector(REPO / "models" / "shapes")
        raw = numpy.zeros((1, 7, 2), numpy.float32)
        raw[0, :, 0] = (256, 150, 36, 72, 0, 0.9, 0)

        class Fixed:
            def setInput(self, blob):
                self.shape = blob.shape

            def forward(self, names):
                return [raw]

        network._net = Fixed()
        found = network.detect(numpy.zeros((500, 1024, 3), numpy.uint8))
        self.assertEqual(["cube"], [name for name, _, _ in found])
        # The image fills 512 x 250 at (0, 67): pixels are doubled.
        numpy.testing.assert_allclose((476, 94, 548, 238), found[0][2], atol=1e-4)
        self.assertEqual((476, 94, 548, 238), network.propose(numpy.zeros((500, 1024, 3), numpy.uint8))[0][0].corners)


if __name__ == "__main__":
    unittest.main()
