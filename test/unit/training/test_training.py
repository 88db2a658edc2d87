#!/usr/bin/python3
"""Tests of the generated images, the figures of merit and the shipped shape detector."""
import hashlib
import re
import sys
import tempfile
import unittest
from pathlib import Path

import cv2
import numpy as np

ROOT = Path(__file__).resolve().parents[3]
sys.path.insert(0, str(ROOT / 'src'))

from extperfc.training import dataset, evaluate, scenes, sequence  # noqa: E402

try:
    import torch
except ImportError:
    torch = None

MODEL = ROOT / 'models' / 'shapes'
SMALL = (224, 168)


class Images(unittest.TestCase):
    """The generator."""

    def test_same_seed_same_image(self):
        for seed in (3, 4, 5):
            first, second = scenes.make_image(seed, SMALL), scenes.make_image(seed, SMALL)
            np.testing.assert_array_equal(first.image, second.image, err_msg=f'seed {seed}')
            self.assertEqual(first.boxes, second.boxes, f'seed {seed}')

    def test_other_seed_other_image(self):
        self.assertGreater(np.abs(scenes.make_image(1, SMALL).image.astype(int) - scenes.make_image(2, SMALL).image).mean(), 1)

    def test_boxes_are_those_of_the_masks(self):
        count = 0
        for seed in range(30, 45):
            sample = scenes.make_image(seed, SMALL)
            for number, (x0, y0, x1, y1) in zip(sample.numbers, sample.boxes):
                ys, xs = np.nonzero(sample.ids == number)
                self.assertEqual((xs.min(), ys.min(), xs.max() + 1, ys.max() + 1), (x0, y0, x1, y1), f'seed {seed}')
                self.assertTrue(np.isfinite(sample.depth[ys, xs]).all(), f'seed {seed}')
                count += 1
        self.assertGreater(count, 5)

    def test_depth_of_a_ball(self):
        scene = sequence.Scene(1)
        sample, truth = scene.render(0.4)
        balls = [(n, t) for n, t in zip(sample.numbers, truth) if t['class'] == 'sphere']
        self.assertTrue(balls)
        for number, ball in balls:
            nearest = sample.depth[sample.ids == number].min()
            self.assertLess(abs(nearest - (ball['position'][2] - ball['size'][2] / 2)), 0.3 * ball['size'][2], ball)

    def test_truth_projects_into_its_box(self):
        for item in sequence.Scene(2).render(0.3)[1]:
            x, y, z = item['position']
            u = x / z * sequence.FOCAL + (sequence.WIDTH - 1) / 2
            v = y / z * sequence.FOCAL + (sequence.HEIGHT - 1) / 2
            x0, y0, x1, y1 = item['box']
            if 5 < x0 and x1 < sequence.WIDTH - 5 and 5 < y0 and y1 < sequence.HEIGHT - 5:
                self.assertTrue(x0 - 20 <= u <= x1 + 20 and y0 - 20 <= v <= y1 + 20, item)

    def test_sequence_folder(self):
        with tempfile.TemporaryDirectory() as folder:
            sequence.write(folder, 2, 3)
            depth = cv2.imread(f'{folder}/depth/000001.png', cv2.IMREAD_UNCHANGED)
            self.assertEqual((depth.dtype, depth.shape), (np.uint16, (480, 640)))
            self.assertEqual(len(Path(folder, 'associations.txt').read_text().splitlines()), 2)


class Figures(unittest.TestCase):
    """Average precision and decoding."""

    def test_average_precision_by_hand(self):
        # Hits 1, 0, 1 of two objects: precision 1 up to recall 0.5 (51 of 101 points), then 2/3 (50 points).
        value = evaluate.average_precision(np.array([.9, .8, .7]), np.array([1, 0, 1]), 2)
        self.assertAlmostEqual(value, (51 + 50 * 2 / 3) / 101, places=9)

    def test_ignored_do_not_count(self):
        value = evaluate.average_precision(np.array([.9, .8]), np.array([-1, 1]), 1)
        self.assertAlmostEqual(value, 1.0)

    def test_second_detection_of_an_object_is_false(self):
        found = np.array([[0, .9, 0, 0, 10, 10], [0, .8, 0, 0, 10, 9]], float)
        result = evaluate.match(found, np.array([[0, 0, 10, 10.]]), np.zeros((0, 4)), 0.5)
        self.assertEqual(list(result), [1, 0])

    def test_letterbox_of_a_camera_image(self):
        out = dataset.letterbox(np.zeros((480, 640, 3), np.uint8))
        self.assertEqual(out.shape, (256, 320, 3))
        self.assertTrue((out[:8] == 114).all() and (out[-8:] == 114).all() and (out[8:248] == 0).all())

    def test_decode_suppresses_within_a_class(self):
        raw = np.zeros((7, 3))
        raw[:4] = np.array([[50, 50, 20, 20], [51, 50, 20, 20], [50, 50, 20, 20]]).T
        raw[4, :2], raw[5, 2] = (.9, .8), .7
        self.assertEqual(evaluate.decode(raw, 0.5, 0.5)[:, 0].tolist(), [0, 1])


@unittest.skipIf(torch is None, 'PyTorch is not installed (apt install python3-torch python3-torchvision)')
class Network(unittest.TestCase):
    """Decoding in the exported graph against that of the loss."""

    def test_exported_boxes_are_those_of_the_loss(self):
        from extperfc.training import network
        torch.manual_seed(0)
        net = network.ShapeNet().eval()
        images = torch.rand(1, 3, dataset.HEIGHT, dataset.WIDTH)
        centres, strides = network.cells()
        with torch.no_grad():
            scores, reach = net(images)
            boxes = network.corners(reach, centres, strides)[0]
            out = network.Exported(net).eval()(images)[0]
        np.testing.assert_allclose(out[:2].t() - out[2:4].t() / 2, boxes[:, :2], atol=1e-3)
        np.testing.assert_allclose(out[:2].t() + out[2:4].t() / 2, boxes[:, 2:], atol=1e-3)
        np.testing.assert_allclose(out[4:], torch.sigmoid(scores[0]), atol=1e-6)

    def test_loss_prefers_the_truth(self):
        from extperfc.training import loss, network
        centres, strides = network.cells()
        truth, valid = torch.tensor([[[2., 100, 80, 164, 144]]]), torch.ones(1, 1, dtype=torch.bool)
        gap = torch.cat([centres - truth[0, 0, 1:3], truth[0, 0, 3:] - centres], 1)
        reach = torch.log((gap / strides[:, None]).clamp(min=.05)).t()[None]
        logits = torch.full((1, 3, len(strides)), -6.0)
        logits[0, 2, gap.min(1)[0] > 24] = 5.0
        good = sum(loss.detection_loss(logits, reach, centres, strides, truth, valid))
        bad = sum(loss.detection_loss(logits.roll(1, 1), reach + 1, centres, strides, truth, valid))
        self.assertLess(float(good), 0.3 * float(bad))


class Shipped(unittest.TestCase):
    """The model in models/shapes."""

    def test_sha256(self):
        stated = re.search(r'^sha256: ([0-9a-f]{64})$', (MODEL / 'model.yaml').read_text(), re.M).group(1)
        self.assertEqual(stated, hashlib.sha256((MODEL / 'shapes.onnx').read_bytes()).hexdigest())

    def test_finds_objects_in_held_out_rooms(self):
        detector, hits, total, false = evaluate.Detector(MODEL / 'shapes.onnx'), 0, 0, 0
        for image, boxes in evaluate.rooms(24):
            found = detector(image)
            for kind in range(3):
                mine, truth = found[found[:, 0] == kind], boxes[boxes[:, 0] == kind, 1:]
                result = evaluate.match(mine, truth, boxes[boxes[:, 0] < 0, 1:], 0.5)
                hits, total, false = hits + np.sum(result == 1), total + len(truth), false + np.sum(result == 0)
        self.assertGreater(total, 100)
        self.assertGreater(hits / total, 0.7)
        self.assertLess(false / total, 0.3)


if __name__ == '__main__':
    unittest.main()
