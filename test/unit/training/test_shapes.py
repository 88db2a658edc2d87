#!/usr/bin/python3
"""Tests of the default detector's samples, recipe, figures of merit and network."""
import contextlib
import hashlib
import json
import os
import re
import sys
import tempfile
import types
import unittest
from pathlib import Path

import cv2
import numpy as np

ROOT = Path(__file__).resolve().parents[3]
sys.path.insert(0, str(ROOT / 'src'))

from extperfc.training.shapes import HEIGHT, WIDTH, evaluate, samples  # noqa: E402

try:
    import torch
except ImportError:
    torch = None

MODEL = ROOT / 'models' / 'shapes'
COLOURS = {'cone': (200, 60, 30), 'cube': (30, 200, 60), 'sphere': (60, 30, 200)}


def note(name, box, difficult=0, visible=1.0):
    """An object of an annotation file; box x0, y0, x1, y1 with x1, y1 behind the last pixel."""
    x0, y0, x1, y1 = box
    return (f'<object><name>{name}</name><difficult>{difficult}</difficult><visible>{visible}</visible><bndbox>'
            f'<xmin>{x0 + 1}</xmin><ymin>{y0 + 1}</ymin><xmax>{x1}</xmax><ymax>{y1}</ymax></bndbox></object>')


def draw_folder(folder, count, seed=0):
    """Images with one coloured rectangle per class, as extperfc-render lays them out."""
    rng = np.random.default_rng(seed)
    for name in ('JPEGImages', 'Annotations'):
        Path(folder, name).mkdir(parents=True, exist_ok=True)
    Path(folder, 'render.txt').write_text('drawn\n')
    for number in range(count):
        image, notes = np.full((192, 256, 3), 120, np.uint8), ''
        for column, (name, colour) in enumerate(COLOURS.items()):
            x, y = 10 + 80 * column + int(rng.integers(20)), int(rng.integers(10, 120))
            cv2.rectangle(image, (x, y), (x + 39, y + 49), colour[::-1], -1)
            notes += note(name, (x, y, x + 40, y + 50))
        cv2.imwrite(str(samples.image_file(folder, number)), image)
        Path(folder, 'Annotations', f'{number + 1:06d}.xml').write_text(f'<annotation>{notes}</annotation>')


class Samples(unittest.TestCase):
    """Reading."""

    def setUp(self):
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.folder = temporary.name

    def test_boxes_count_from_zero_and_difficult_is_ignored(self):
        draw_folder(self.folder, 1)
        text = note('cube', (3, 4, 20, 30)) + note('sphere', (1, 2, 9, 10), difficult=1)
        Path(self.folder, 'Annotations', '000001.xml').write_text(f'<annotation>{text}</annotation>')
        np.testing.assert_array_equal(samples.read_boxes(self.folder, 0), [[1, 3, 4, 20, 30], [-1, 1, 2, 9, 10]])

    def test_letterbox_keeps_the_aspect(self):
        out = samples.letterbox(np.zeros((360, 640, 3), np.uint8), (WIDTH, HEIGHT))
        self.assertEqual(out.shape, (HEIGHT, WIDTH, 3))
        self.assertTrue((out[:48] == 114).all() and (out[-48:] == 114).all() and (out[48:336] == 0).all())

    def test_a_missing_image_is_one_clear_error(self):
        with self.assertRaisesRegex(SystemExit, '000001.xml does not exist: render'):
            samples.load(self.folder, 0)


class Figures(unittest.TestCase):
    """Average precision, decoding, and what is found at a threshold."""

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

    def test_decode_suppresses_within_a_class(self):
        raw = np.zeros((7, 3))
        raw[:4] = np.array([[50, 50, 20, 20], [51, 50, 20, 20], [50, 50, 20, 20]]).T
        raw[4, :2], raw[5, 2] = (.9, .8), .7
        self.assertEqual(evaluate.decode(raw, 0.5, 0.5)[:, 0].tolist(), [0, 1])

    def test_found_and_false_at_a_threshold(self):
        """Three clear objects, one hidden, one too narrow, one difficult; two right finds, one wrong class, one nowhere."""
        with tempfile.TemporaryDirectory() as folder:
            draw_folder(folder, 1)
            boxes = [('cone', (0, 0, 40, 40)), ('cube', (50, 0, 90, 40)), ('sphere', (100, 0, 140, 40))]
            text = ''.join(note(*entry) for entry in boxes) + note('cube', (150, 0, 190, 40), visible=0.4)
            text += note('cone', (0, 100, 16, 140)) + note('cone', (60, 100, 99, 140), difficult=1)
            Path(folder, 'Annotations', '000001.xml').write_text(f'<annotation>{text}</annotation>')
            finds = np.array([[0, .9, 0, 0, 40, 40], [1, .8, 51, 0, 90, 41], [1, .7, 100, 0, 140, 40],
                              [2, .6, 200, 100, 240, 140], [0, .6, 60, 100, 99, 140]])
            counts = evaluate.found_and_false(lambda image, score: finds[finds[:, 1] >= score], folder, 0.5)
        self.assertEqual(counts, {'objects': 3, 'found': 2, 'false': 2, 'images': 1})


@unittest.skipIf(torch is None, 'PyTorch is not installed (apt install python3-torch python3-torchvision)')
class Augmentation(unittest.TestCase):
    """Batches of samples from stored images."""

    def setUp(self):
        from extperfc.training.shapes import store
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        draw_folder(temporary.name, 6)
        self.store = store.ImageStore(temporary.name, 6, torch.device('cpu'))
        self.store.grow(6)

    def test_a_batch_is_a_function_of_seed_and_step(self):
        from extperfc.training.shapes.augment import Augmenter
        first, second = (Augmenter(self.store, (128, 96), 5, 4) for _ in range(2))
        second.samples(0, 6, 0.5)  # what came before does not matter
        for step in (3, 8):
            for one, other in zip(first.samples(step, 6, 0.5), second.samples(step, 6, 0.5)):
                self.assertTrue(torch.equal(one, other))
        self.assertFalse(torch.equal(first.samples(3, 6, 0)[0], first.samples(4, 6, 0)[0]))

    def test_boxes_stay_on_their_objects(self):
        """Every rectangle has one colour of its own: its box must be full of it, wherever the image went."""
        from extperfc.training.shapes.augment import Augmenter
        seen = 0
        for size in ((128, 96), (256, 192)):  # sampled more finely and averaged; as it is
            augmenter = Augmenter(self.store, size, 1, 20)
            augmenter._colour = lambda rng, images: images  # the colours are what is looked at
            augmenter._cover = lambda rng, images, boxes: images
            images, boxes = augmenter.samples(0, 6, 0.4)
            self.assertEqual((tuple(images.shape[2:]), len(boxes)), (size[::-1], 20))
            for image, rows in zip(images, boxes):
                for label, x0, y0, x1, y1 in rows[rows[:, 0] >= 0].tolist():
                    inside = image[:, int(y0 + 2):int(y1 - 2), int(x0 + 2):int(x1 - 2)].flatten(1).mean(1)
                    expected = torch.tensor(list(COLOURS.values())[int(label)])
                    self.assertLess((inside - expected).abs().max(), 45)
                    seen += 1
        self.assertGreater(seen, 60)

    def test_a_mirrored_and_cut_box(self):
        """By hand: width 100, mirrored, twice as large, 10 px to the right; the area ends at x = 150."""
        from extperfc.training.shapes.augment import Placing, place_boxes
        placing = Placing(torch.tensor([[2.0, 2.0]]), torch.tensor([[10.0, 0.0]]), torch.tensor([True]),
                          torch.tensor([[0.0, 0.0, 150.0, 200.0]]))
        boxes = torch.tensor([[[1., 60, 10, 80, 30], [2., 0, 10, 42, 30], [0., 0, 0, 20, 30], [-1., 50, 5, 60, 15]]])
        placed = place_boxes(boxes, 100, placing)[0]
        self.assertEqual(placed[0].tolist(), [1, 50, 20, 90, 60])
        self.assertEqual(placed[1].tolist(), [-1, 126, 20, 150, 60], 'less than 35 % are left: ignored')
        self.assertEqual(placed[2, 0], -2, 'beyond the edge: unused')
        self.assertEqual(placed[3, 0], -1, 'ignored stays ignored')

    def test_covers_hide_no_object(self):
        from extperfc.training.shapes.augment import Augmenter
        augmenter = Augmenter(self.store, (256, 192), 1, 40)
        boxes = torch.tensor([[[0., 40, 40, 200, 150]]]).repeat(40, 1, 1)
        covered = augmenter._cover(torch.Generator().manual_seed(2), torch.full((40, 3, 192, 256), -1.0), boxes)
        changed = (covered >= 0).any(1).flatten(1).any(1)
        self.assertTrue(1 <= changed.sum() <= 8)
        hidden = (covered[:, 0, 40:150, 40:200] >= 0).float().mean((1, 2))
        self.assertLess(hidden.max(), 4 * 0.25)

    def test_images_that_are_kept_and_read_are_the_same(self):
        """As a GPU whose memory has room for three of six images."""
        from unittest import mock

        from extperfc.training.shapes import store
        with mock.patch.object(store, 'free_memory', return_value=5 * 3 * 192 * 256):
            some = store.ImageStore(self.store.folder, 6, torch.device('cpu'))
        some.grow(6)
        self.assertEqual((len(some.images), len(self.store.images)), (3, 0))
        for numbers in ([0, 5, 2, 3, 3], [1, 2], [4, 3]):
            for one, other in zip(some.fetch(torch.tensor(numbers)), self.store.fetch(torch.tensor(numbers))):
                self.assertTrue(torch.equal(one, other), numbers)

    def test_a_store_reads_ahead_what_is_rendered_and_not_much_of_it(self):
        from unittest import mock

        from extperfc.training.shapes import store
        Path(self.store.folder, 'Annotations', '000005.xml').rename(Path(self.store.folder, 'later.xml'))
        for ahead, expected in ((2, 2), (9, 3)):
            with mock.patch.object(store, 'AHEAD', ahead):
                growing = store.ImageStore(self.store.folder, 6, torch.device('cpu'))
                growing.grow(1)
            self.assertEqual((growing.known, len(growing.coming)), (1, expected))
        Path(self.store.folder, 'later.xml').rename(Path(self.store.folder, 'Annotations', '000005.xml'))
        growing.grow(6)
        self.assertTrue(torch.equal(growing.boxes, self.store.boxes))

    def test_a_store_on_a_growing_folder_names_what_it_misses(self):
        with self.assertRaisesRegex(SystemExit, '000007.xml does not exist: render'):
            self.store.grow(7)


@unittest.skipIf(torch is None, 'PyTorch is not installed (apt install python3-torch python3-torchvision)')
class Network(unittest.TestCase):
    """The network, its loss and its training."""

    def test_exported_boxes_are_those_of_the_loss(self):
        from extperfc.training.shapes import network
        torch.manual_seed(0)
        net = network.ShapeNet().eval()
        images = torch.rand(1, 3, HEIGHT, WIDTH)
        centres, strides = network.cells()
        with torch.no_grad():
            scores, reach = net(images)
            boxes = network.corners(reach, centres, strides)[0]
            out = network.Exported(net).eval()(images)[0]
        np.testing.assert_allclose(out[:2].t() - out[2:4].t() / 2, boxes[:, :2], atol=1e-3)
        np.testing.assert_allclose(out[:2].t() + out[2:4].t() / 2, boxes[:, 2:], atol=1e-3)
        np.testing.assert_allclose(out[4:], torch.sigmoid(scores[0]), atol=1e-6)

    def test_loss_prefers_the_truth(self):
        from extperfc.training.shapes import loss, network
        centres, strides = network.cells(384, 288)
        truth, valid = torch.tensor([[[2., 100, 80, 164, 144]]]), torch.ones(1, 1, dtype=torch.bool)
        gap = torch.cat([centres - truth[0, 0, 1:3], truth[0, 0, 3:] - centres], 1)
        reach = torch.log((gap / strides[:, None]).clamp(min=.05)).t()[None]
        logits = torch.full((1, 3, len(strides)), -6.0)
        logits[0, 2, gap.min(1)[0] > 24] = 5.0
        good = sum(loss.detection_loss(logits, reach, centres, strides, truth, valid))
        bad = sum(loss.detection_loss(logits.roll(1, 1), reach + 1, centres, strides, truth, valid))
        self.assertLess(float(good), 0.3 * float(bad))

    def test_recording_leaves_the_statistics_also_when_it_fails(self):
        from unittest import mock

        from extperfc.training import cuda_graphs
        norm = torch.nn.BatchNorm1d(2)

        def run_and_fail(module, inputs, **_):
            module(*inputs)
            raise RuntimeError('no graph')
        with mock.patch.object(torch.cuda, 'make_graphed_callables', run_and_fail), self.assertRaises(RuntimeError):
            cuda_graphs.recorded(norm, (torch.ones(3, 2),))
        self.assertEqual((norm.running_mean.tolist(), int(norm.num_batches_tracked)), ([0.0, 0.0], 0))

    @unittest.skipUnless(torch is not None and torch.cuda.is_available(), 'no GPU')
    def test_recorded_losses_and_gradients_are_those_of_the_network(self):
        from extperfc.training.shapes import network, train
        torch.manual_seed(0)
        device = torch.device('cuda')
        images = 255 * torch.rand(2, 3, 64, 96, device=device)
        boxes = torch.full((2, 40, 5), -2.0, device=device)
        boxes[:, 0] = torch.tensor([1.0, 20, 10, 60, 50], device=device)
        results = []
        for recorded in (False, True):
            torch.manual_seed(1)
            net = network.ShapeNet().to(device, memory_format=torch.channels_last)
            losses = train.Losses(net, (96, 64), device, False)
            if recorded:
                losses.record(images, boxes)
                self.assertEqual(float(net.backbone.to4[0][1].running_mean.abs().max()), 0.0)
            values = losses(images, boxes)
            values.sum().backward()
            results.append([values.detach(), net.backbone.to4[0][0].weight.grad, net.backbone.to4[0][1].running_mean])
        for one, other in zip(*results):
            torch.testing.assert_close(one, other, rtol=0.02, atol=1e-4)

    def test_a_resumed_run_has_the_same_weights(self):
        from extperfc.training.shapes.train import Recipe, Trainer
        recipe = Recipe(images=4, first_images=2, more_images=1, steps=4, small_steps=2, small_size=(64, 64), size=(96, 64),
                        decay_steps=2, warmup_steps=1, batch=2)
        with tempfile.TemporaryDirectory() as folder:
            draw_folder(folder, 4)

            def run(name, steps):
                options = types.SimpleNamespace(folder=folder, checkpoint=Path(folder, name), device='cpu', threads=1,
                                                bfloat16=False, save_every=1)
                trainer = Trainer(recipe, options)
                stop = trainer.save

                def save_and_stop():
                    stop()
                    if trainer.step == steps:
                        raise KeyboardInterrupt
                trainer.save = save_and_stop
                try:
                    with open(os.devnull, 'w') as sink, contextlib.redirect_stdout(sink):
                        trainer.run()
                except KeyboardInterrupt:
                    pass
                return trainer.net.state_dict()
            whole = run('whole.pt', 99)
            run('broken.pt', 1)
            run('broken.pt', 3)
            resumed = run('broken.pt', 99)
        for name, value in whole.items():
            self.assertTrue(torch.equal(value, resumed[name]), name)

    def test_a_run_that_continues_begins_with_the_given_weights_and_is_noted_after_the_first(self):
        from extperfc.training.shapes import export
        from extperfc.training.shapes.train import Recipe, Trainer
        recipe = Recipe.continued(3)
        self.assertEqual((recipe.input_size(0), recipe.mosaics(2)), ((WIDTH, HEIGHT), 0.0))
        self.assertLess(recipe.learning_rate(2), recipe.learning_rate(1))
        self.assertNotEqual(recipe.seed, Recipe().seed)
        with tempfile.TemporaryDirectory() as folder:
            draw_folder(folder, 2)
            path = Path(folder, 'manifest.json')
            options = types.SimpleNamespace(folder=folder, checkpoint=Path(folder, 'a.pt'), device='cpu', threads=1,
                                            bfloat16=False, save_every=1)
            trainer = Trainer(recipe, options, MODEL / 'weights.pt')
            trainer.save()
            before = export.read_weights(MODEL / 'weights.pt')
            for name, value in export.read_weights(options.checkpoint).items():
                self.assertTrue(torch.equal(value, before[name]), name)
            export.write_manifest(torch.load(options.checkpoint), path, folder)
            runs = json.loads(path.read_text())['runs']
        self.assertEqual(runs[:-1], export.earlier_runs(MODEL / 'weights.pt'))
        self.assertEqual((runs[-1]['recipe']['steps'], runs[-1]['images']), (3, 2))

    def test_the_average_follows_as_a_running_mean_would(self):
        from extperfc.training.shapes.train import Average
        net = torch.nn.BatchNorm1d(2)
        average = Average(net, 0.9)
        with torch.no_grad():
            net.weight.fill_(3.0)
            net.num_batches_tracked.fill_(7)
        average.follow(0)
        self.assertTrue(torch.allclose(average.net.weight, torch.full((2,), 1 * 0.05 + 3 * 0.95)))
        average.follow(1000)
        self.assertTrue(torch.allclose(average.net.weight, torch.full((2,), 2.91)))
        self.assertEqual(int(average.net.num_batches_tracked), 7)


class Shipped(unittest.TestCase):
    """The model in models/shapes."""

    def test_sha256(self):
        stated = re.search(r'^sha256: ([0-9a-f]{64})$', (MODEL / 'model.yaml').read_text(), re.M).group(1)
        self.assertEqual(stated, hashlib.sha256((MODEL / 'shapes.onnx').read_bytes()).hexdigest())

    def test_the_folder_and_its_network_find_the_same(self):
        image = np.full((480, 640, 3), 180, np.uint8)
        cv2.circle(image, (200, 240), 60, (200, 40, 30), -1, cv2.LINE_AA)
        cv2.circle(image, (182, 222), 14, (240, 150, 140), -1, cv2.LINE_AA)
        network, folder = evaluate.open_model(MODEL / 'shapes.onnx'), evaluate.open_model(MODEL)
        found = network(image, score=0.2)
        self.assertGreater(len(found), 0)
        np.testing.assert_allclose(found, folder(image, score=0.2), atol=0.02)

    def test_input_is_that_of_the_recipe(self):
        self.assertIn(f'width: {WIDTH}, height: {HEIGHT}', (MODEL / 'model.yaml').read_text())


if __name__ == '__main__':
    unittest.main()
