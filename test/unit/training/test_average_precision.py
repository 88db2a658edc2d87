"""Average precision against an example worked by hand and against pycocotools; confusions; model folders."""

import hashlib
import os
import pathlib
import sys
import tempfile
import types
import unittest

import cv2
import numpy as np
import yaml

ROOT = pathlib.Path(__file__).resolve().parents[3]
sys.path.insert(0, str(ROOT / "src"))
sys.path.append(str(pathlib.Path(os.environ.get("EXTPERFC_WS", ROOT / ".ws")) / "training"))

from extperfc.training.data import DataError  # noqa: E402
from extperfc.training.evaluation import Detections, Truth, coco, confusion, evaluate, model_folder  # noqa: E402
from extperfc.training.evaluation.detector import open_detector  # noqa: E402
from extperfc.training.evaluation.average_precision import IOU_THRESHOLDS  # noqa: E402

try:
    import matplotlib
except ImportError:
    matplotlib = None


def truth(*rows):
    """Rows of (label, x0, y0, x1, y1, difficult)."""
    table = np.array(rows, float).reshape(-1, 6)
    return Truth(table[:, 1:5], table[:, 0].astype(int), table[:, 5] > 0)


def found(*rows):
    """Rows of (label, score, x0, y0, x1, y1)."""
    table = np.array(rows, float).reshape(-1, 6)
    return Detections(table[:, 2:], table[:, 1], table[:, 0].astype(int))


def random_images(count, classes, seed):
    """Detections and truths with hits of every quality, inventions, misses, wrong classes and difficult objects."""
    rng = np.random.default_rng(seed)
    detections, truths = [], []
    for _ in range(count):
        corner = rng.uniform(0, 200, (rng.integers(0, 6), 2))
        boxes = np.concatenate([corner, corner + rng.uniform(8, 80, corner.shape)], 1)
        labels = rng.integers(0, classes, len(boxes))
        truths.append(Truth(boxes, labels, rng.random(len(boxes)) < 0.15))
        rows = np.repeat(np.arange(len(boxes)), 2)
        shaken = boxes[rows] + rng.normal(0, 6, (len(rows), 4))
        free = rng.uniform(0, 200, (3, 2))
        guess = np.concatenate([shaken, np.concatenate([free, free + rng.uniform(8, 60, free.shape)], 1)])
        guess = np.concatenate([np.minimum(guess[:, :2], guess[:, 2:] - 1), guess[:, 2:]], 1)
        kinds = np.concatenate([labels[rows], rng.integers(0, classes, 3)])
        swapped = rng.random(len(kinds)) < 0.1
        kinds[swapped] = rng.integers(0, classes, swapped.sum())
        detections.append(Detections(guess, rng.permutation(np.linspace(0.05, 0.99, len(guess))), kinds))
    return detections, truths


class ByHand(unittest.TestCase):
    """Two classes, two images; the arithmetic is in the comments."""

    TRUTHS = [truth((0, 0, 0, 10, 10, 0), (0, 20, 0, 30, 10, 0), (1, 50, 50, 60, 60, 0)), truth((0, 0, 0, 10, 10, 0))]
    DETECTIONS = [
        found((0, 0.9, 0, 0, 10, 8),     # IoU 80 / 100 = 0.8 with the first
              (0, 0.6, 20, 0, 30, 5),    # IoU 50 / 100 = 0.5 with the second
              (0, 0.3, 0, 0, 10, 10)),   # the first again, IoU 1
        found((0, 0.8, 40, 40, 50, 50))]  # on nothing

    def setUp(self):
        self.result = evaluate(self.DETECTIONS, self.TRUTHS, ("cone", "cube"))

    def test_at_half_overlap(self):
        # Ranking 0.9 true, 0.8 false, 0.6 true, 0.3 false (its object is taken): precision 1, 1/2, 2/3, 1/2 at recall
        # 1/3, 1/3, 2/3, 2/3. Area: 1/3 * 1 + 1/3 * 2/3.
        self.assertAlmostEqual(5 / 9, self.result.ap[0, self.result.column(0.5)])

    def test_above_half_overlap(self):
        # From 0.51 to 0.80 the second is missed: true, false, false, false. Area: 1/3.
        for iou in (0.51, 0.65, 0.80):
            self.assertAlmostEqual(1 / 3, self.result.ap[0, self.result.column(iou)])
        # From 0.81 on only the last one is true, at rank 4: precision 1/4 at recall 1/3. Area: 1/12.
        for iou in (0.81, 1.00):
            self.assertAlmostEqual(1 / 12, self.result.ap[0, self.result.column(iou)])

    def test_mean_over_all_thresholds(self):
        # 50 thresholds up to 0.50, 30 up to 0.80, 20 up to 1.00; no cube was found.
        cone = (50 * 5 / 9 + 30 / 3 + 20 / 12) / 100
        self.assertEqual(100, len(IOU_THRESHOLDS))
        self.assertAlmostEqual(cone, self.result.ap[0].mean())
        self.assertAlmostEqual(cone / 2, self.result.mean_ap())
        self.assertAlmostEqual(5 / 18, self.result.mean_ap(0.5))

    def test_best_threshold(self):
        # F1 at 0.9: p 1, r 1/4 -> 0.4; at 0.6: p 2/3, r 1/2 -> 4/7, the highest.
        score, f1, precision, recall = self.result.best_threshold()
        self.assertAlmostEqual(0.6, score)
        np.testing.assert_allclose([4 / 7, 2 / 3, 1 / 2], [f1, precision, recall])

    def test_coco_interpolation_at_half_overlap(self):
        # Recalls 0 to 0.33 (34 of 101) at precision 1, 0.34 to 0.66 (33) at 2/3.
        result = evaluate(self.DETECTIONS, self.TRUTHS, ("cone", "cube"), interpolation="coco")
        self.assertAlmostEqual((34 + 33 * 2 / 3) / 101, result.ap[0, result.column(0.5)])


class Rules(unittest.TestCase):
    def test_perfect_and_empty(self):
        perfect = evaluate([found((0, 0.9, 1, 2, 30, 40))], [truth((0, 1, 2, 30, 40, 0))], ("cone",))
        self.assertEqual(1.0, perfect.mean_ap())
        self.assertEqual(0.0, evaluate([found()], [truth((0, 1, 2, 30, 40, 0))], ("cone",)).mean_ap())
        self.assertTrue(np.isnan(evaluate([found((0, 0.9, 1, 2, 3, 4))], [truth()], ("cone",)).mean_ap()))

    def test_a_class_without_objects_is_not_in_the_mean(self):
        result = evaluate([found((0, 0.9, 0, 0, 9, 9))], [truth((0, 0, 0, 9, 9, 0))], ("cone", "cube"))
        self.assertEqual(1.0, result.mean_ap(0.5))
        self.assertTrue(np.isnan(result.ap[1]).all())

    def test_detections_on_difficult_objects_do_not_count(self):
        truths = [truth((0, 0, 0, 10, 10, 0), (0, 50, 50, 90, 90, 1))]
        result = evaluate([found((0, 0.9, 50, 50, 70, 70), (0, 0.8, 60, 60, 90, 90), (0, 0.5, 0, 0, 10, 10))], truths,
                          ("cone", ))
        self.assertEqual(1.0, result.mean_ap())

    def test_falls_with_the_threshold(self):
        result = evaluate(*random_images(30, 3, 4), ("a", "b", "c"))
        over_iou = result.mean_ap_over_iou()
        self.assertTrue((np.diff(over_iou) <= 1e-12).all())
        self.assertGreater(over_iou[0], over_iou[60])

    def test_images_must_agree(self):
        with self.assertRaisesRegex(ValueError, "1 images have detections, but 2"):
            evaluate([found()], [truth(), truth()], ("cone",))


@unittest.skipUnless(coco.is_available(), "pycocotools is missing: tools/setup --tests installs it")
class Pycocotools(unittest.TestCase):
    NAMES = ("a", "b", "c")

    def test_every_threshold_and_class_agrees(self):
        for seed in (1, 2, 3):
            detections, truths = random_images(40, 3, seed)
            run = coco.coco_evaluation(detections, truths, self.NAMES)
            theirs = run.eval["precision"][:, :, :, 0, 2].mean(1).T  # [K, T]
            ours = evaluate(detections, truths, self.NAMES, run.params.iouThrs, "coco")
            np.testing.assert_allclose(ours.ap, theirs, atol=1e-9, err_msg=f"seed {seed}")
            self.assertGreater(theirs.max(), 0.3)

    def test_area_and_101_recalls_are_close_but_not_the_same(self):
        detections, truths = random_images(60, 3, 5)
        area, sampled = (evaluate(detections, truths, self.NAMES, interpolation=i) for i in ("area", "coco"))
        difference = np.abs(area.ap - sampled.ap).max()
        self.assertTrue(1e-6 < difference < 0.02, difference)

    def test_figures_have_names(self):
        figures = coco.coco_metrics(*random_images(20, 3, 6), self.NAMES)
        self.assertEqual(15, len(figures))
        self.assertTrue(0 < figures["AP"] < figures["AP50"] <= 1)

    def test_no_detection_at_all(self):
        figures = coco.coco_metrics([found()], [truth((0, 0, 0, 9, 9, 0))], ("cone",))
        self.assertEqual(0.0, figures["AP"])


class Confusions(unittest.TestCase):
    TRUTHS = [truth((0, 0, 0, 20, 20, 0), (1, 40, 0, 60, 20, 0), (1, 0, 40, 30, 70, 0), (0, 80, 80, 99, 99, 1))]
    DETECTIONS = [
        found((0, 0.9, 0, 0, 20, 20), (0, 0.8, 41, 0, 60, 20), (1, 0.7, 70, 30, 79, 39), (0, 0.6, 80, 80, 99, 99),
              (1, 0.2, 0, 40, 30, 70))
    ]

    def test_table_and_mistakes(self):
        table, mistakes = confusion.confusion(self.DETECTIONS, self.TRUTHS, ("cone", "cube"), 0.5)
        # One cone as a cone; a cube as a cone; a cube missed (0.2 is below the threshold); a cube invented.
        self.assertEqual([[1, 0, 0], [1, 0, 1], [0, 1, 0]], table.tolist())
        self.assertEqual({"cube as cone 0.80", "invented cube 0.70", "missed cube"}, {m.text for m in mistakes})

    def test_the_right_class_is_preferred(self):
        table, _ = confusion.confusion([found((1, 0.9, 0, 0, 20, 20), (0, 0.8, 0, 0, 20, 19))],
                                       [truth((0, 0, 0, 20, 20, 0))], ("cone", "cube"), 0.5)
        self.assertEqual([[1, 0, 0], [0, 0, 0], [0, 1, 0]], table.tolist())

    def test_the_worst_of_each_kind(self):
        mistakes = confusion.confusion(self.DETECTIONS, self.TRUTHS, ("cone", "cube"), 0.5)[1]
        self.assertEqual(["confused", "invented"], [m.kind for m in confusion.worst(mistakes, 2)])
        self.assertEqual(3, len(confusion.worst(mistakes, 20)))

    def test_sheet_shows_detections_in_red_and_objects_in_green(self):
        mistakes = confusion.worst(confusion.confusion(self.DETECTIONS, self.TRUTHS, ("cone", "cube"), 0.5)[1], 9)
        sheet = confusion.contact_sheet(mistakes, lambda i: np.full((100, 100, 3), 90, np.uint8), self.TRUTHS)
        self.assertEqual((190, 5 * 160, 3), sheet.shape)
        for color in confusion.COLORS.values():
            self.assertGreater((sheet == np.uint8(color)).all(2).sum(), 50)


@unittest.skipIf(matplotlib is None, "matplotlib is missing: apt install python3-matplotlib")
class Reports(unittest.TestCase):
    def test_files_and_figures(self):
        from extperfc.training.evaluation.report import write_report
        detections, truths = random_images(12, 2, 7)
        with tempfile.TemporaryDirectory() as folder:
            content = write_report(folder, "a title", detections, truths, ("cone", "never"),
                                   lambda i: np.full((240, 240, 3), 128, np.uint8))
            text = (pathlib.Path(folder) / "report.md").read_text()
            for name in ("ap_over_iou.png", "precision_recall.png", "mistakes.png"):
                self.assertIsNotNone(cv2.imread(f"{folder}/{name}"))
                self.assertIn(f"]({name})", text)
            self.assertIn(f"{content['mean_ap']:.3f}", text)
            self.assertEqual(100, len(content["mean_ap_over_iou"]))
            saved = yaml.safe_load((pathlib.Path(folder) / "report.json").read_text())
            self.assertAlmostEqual(content["mean_ap"], saved["mean_ap"])


class ModelFolders(unittest.TestCase):
    def test_the_shipped_network_finds_what_it_was_made_for(self):
        detector = model_folder.FolderDetector(ROOT / "models" / "shapes")
        image = np.full((480, 640, 3), 150, np.uint8)
        cv2.circle(image, (320, 240), 60, (40, 60, 200), -1, cv2.LINE_AA)
        found_boxes = detector.detect(image)
        self.assertEqual(len(found_boxes.boxes), len(found_boxes.scores))
        self.assertTrue((np.diff(found_boxes.scores) <= 0).all())
        self.assertTrue((found_boxes.boxes >= 0).all() and (found_boxes.boxes[:, 2] <= 640).all())

    def test_ssd_priors(self):
        output = {
            "priors": [[0.5, 0.5, 0.2, 0.4]],
            "variances": [0.1, 0.2],
            "background_class": 0,
            "apply_softmax": True
        }
        boxes, scores = model_folder.decode_ssd_priors(
            [np.float32([[[1, 0, 0, np.log(2) / 0.2]]]), np.float32([[[0, np.log(3), 0]]])], output, (300, 100))
        # Centre 0.5 + 1 * 0.1 * 0.2 = 0.52; size 0.2, 0.4 * 2; softmax of 0, ln 3, 0: 0.2, 0.6, 0.2.
        np.testing.assert_allclose([[126, 10, 186, 90]], boxes, rtol=1e-5)
        np.testing.assert_allclose([[0.6, 0.2]], scores, rtol=1e-6)

    def test_generated_priors(self):
        settings = {"clip": True, "levels": [{"stride": 50, "min_size": 40, "max_size": 90, "aspect_ratios": [4]}]}
        priors = model_folder.generated_priors(settings, (100, 50))
        self.assertEqual((2 * 4, 4), priors.shape)  # two cells; 40, 60, wide, tall
        np.testing.assert_allclose(
            [[0.25, 0.5, 0.4, 0.8], [0.25, 0.5, 0.6, 1.0], [0.25, 0.5, 0.8, 0.4], [0.25, 0.5, 0.2, 1.0]],
            priors[:4],
            rtol=1e-6)

    def test_yolo_layouts(self):
        v8 = np.float32([[10, 20], [10, 20], [4, 8], [4, 8], [0.1, 0.7], [0.9, 0.2]])[None]
        boxes, scores = model_folder.decode_yolo_v8([v8], {}, (64, 64))
        np.testing.assert_allclose([[8, 8, 12, 12], [16, 16, 24, 24]], boxes)
        np.testing.assert_allclose([[0.1, 0.9], [0.7, 0.2]], scores)
        v7 = np.float32([[[10, 10, 4, 4, 0.5, 0.1, 0.9]]])
        np.testing.assert_allclose([[0.05, 0.45]], model_folder.decode_yolo_v7([v7], {}, (64, 64))[1], rtol=1e-6)
        head = np.zeros((1, 2 * 6, 2, 3), np.float32)  # two anchors, one class, all sigmoids 0.5
        boxes, scores = model_folder.decode_yolo_anchors([head],
                                                         {"anchors": [{
                                                             "stride": 8,
                                                             "sizes": [[10, 20], [30, 40]]
                                                         }]}, (24, 16))
        self.assertEqual((12, 4), boxes.shape)
        np.testing.assert_allclose([4 + 8 - 5, 4 - 10, 4 + 8 + 5, 4 + 10], boxes[1])  # cell (1, 0), first anchor
        np.testing.assert_allclose(0.25, scores)

    def test_input_is_prepared_as_stated_and_boxes_come_back(self):
        seen = []
        with tempfile.TemporaryDirectory() as folder:
            place = pathlib.Path(folder)
            (place / "net.onnx").write_bytes(b"")
            (place / "model.yaml").write_text(
                yaml.safe_dump({
                    "name": "x",
                    "file": "net.onnx",
                    "sha256": hashlib.sha256(b"").hexdigest(),
                    "classes": ["cone"],
                    "input": {
                        "width": 64,
                        "height": 64,
                        "resize": "letterbox",
                        "color": "bgr",
                        "mean": 100,
                        "scale": [0.1, 0.2, 0.3]
                    },
                    "output": {
                        "layout": "yolo_v8",
                        "names": ["o"]
                    }
                }))

            def runner(file, names):
                self.assertEqual(["o"], names)
                answer = [np.float32([[32], [32], [20], [10], [0.8]])[None]]
                return types.SimpleNamespace(run=lambda blob: seen.append(blob) or answer)
            before = model_folder.RUNNERS["opencv"]
            model_folder.RUNNERS["opencv"] = runner
            self.addCleanup(model_folder.RUNNERS.__setitem__, "opencv", before)
            detector = model_folder.FolderDetector(place)
            result = detector.detect(np.full((64, 128, 3), (110, 120, 130), np.uint8))
        np.testing.assert_allclose([3, 4, 3], seen[0][0, :, 32, 32], rtol=1e-5)  # blue, green, red
        np.testing.assert_allclose([[44, 22, 84, 42]], result.boxes, rtol=1e-5)

    def test_a_model_folder_with_weights_beside_is_a_model_folder(self):
        opened = open_detector(ROOT / "models" / "shapes")
        self.assertEqual(("cone", "cube", "sphere"), opened.class_names)
        gray = np.full((48, 64, 3), 120, np.uint8)
        self.assertEqual(0, len(opened.detect(gray).scores[opened.detect(gray).scores > 0.5]))

    def test_what_is_no_model_folder_is_refused(self):
        with tempfile.TemporaryDirectory() as folder, self.assertRaisesRegex(DataError, "no model.yaml"):
            model_folder.FolderDetector(folder)


if __name__ == "__main__":
    unittest.main()
