"""Parts of the trainer: learning rate, averaged weights, images, checkpoints, progress."""

import dataclasses
import io
import os
import pathlib
import tempfile
import unittest

import cv2
import numpy as np
from training_case import TorchCase, TrainingCase, torch

from extperfc.training.data import augmentation
from extperfc.training.progress import Progress, duration

if torch:
    from extperfc.training.checkpoints import CheckpointFolder
    from extperfc.training.data.torch_dataset import DetectionDataset, StepSampler, prepare
    from extperfc.training.schedule import WeightAverage, rate_at


class Schedule(TorchCase):
    def test_warm_up_then_half_a_cosine(self):
        rates = [rate_at(step, 110, 10, 0.01) for step in range(111)]
        np.testing.assert_allclose(np.arange(1, 11) / 11, rates[:10])
        self.assertEqual(1.0, rates[10])
        self.assertAlmostEqual((1 + 0.01) / 2, rates[60])
        self.assertAlmostEqual(0.01, rates[110])
        self.assertTrue((np.diff(rates[10:]) <= 0).all())

    def test_average_forgets_the_first_weights(self):
        network = torch.nn.Linear(1, 1, bias=False)
        torch.nn.init.constant_(network.weight, 0.0)
        average = WeightAverage(network, 0.999)
        torch.nn.init.constant_(network.weight, 1.0)
        for _ in range(100):
            average.update()
        self.assertGreater(float(average.network.weight), 0.99)

    def test_average_with_a_fixed_decay(self):
        network = torch.nn.Linear(1, 1, bias=False)
        torch.nn.init.constant_(network.weight, 0.0)
        average = WeightAverage(network, 0.05)  # less than (1 + n) / (10 + n) from the beginning
        torch.nn.init.constant_(network.weight, 1.0)
        average.update()
        average.update()
        self.assertAlmostEqual(1 - 0.05 ** 2, float(average.network.weight), places=6)


class Images(TrainingCase):
    def dataset(self, options=augmentation.Augmentation(), seed=1):
        return DetectionDataset(self.data, (48, 48), "stretch", options, seed)

    def test_seed_epoch_and_index_decide(self):
        one, other = self.dataset(), self.dataset()
        for key in ((0, 3), (5, 3), (0, 4)):
            self.assertTrue(torch.equal(one[key][0], other[key][0]))
            self.assertTrue(torch.equal(one[key][1]["boxes"], other[key][1]["boxes"]))
        self.assertFalse(torch.equal(one[0, 3][0], one[1, 3][0]))
        self.assertFalse(torch.equal(one[0, 3][0], self.dataset(seed=2)[0, 3][0]))

    def test_without_changes_it_is_the_image(self):
        plain, unchanged = self.dataset(None), self.dataset(augmentation.NONE)
        for index in range(5):
            self.assertTrue(torch.equal(plain[index][0], unchanged[7, index][0]))
            self.assertTrue(torch.equal(plain[index][1]["boxes"], unchanged[7, index][1]["boxes"]))

    def test_boxes_follow_the_objects(self):
        image = np.full((90, 120, 3), 40, np.uint8)
        image[30:60, 50:80] = 250
        options = dataclasses.replace(augmentation.Augmentation(), min_visible=0)
        seen = 0
        for epoch in range(60):
            view, boxes, visible = augmentation.random_view(image, [[50, 30, 80, 60]], options,
                                                            augmentation.rng_of(1, epoch, 0))
            ys, xs = np.nonzero((view == 250).all(2))
            self.assertEqual(len(xs) > 0, visible[0] > 0, epoch)
            if len(xs):
                np.testing.assert_array_equal(
                    [xs.min(), ys.min(), xs.max() + 1, ys.max() + 1], boxes[0], f"epoch {epoch}")
                self.assertAlmostEqual(len(xs) / 900, visible[0], places=5)
                seen += visible[0] < 1
        self.assertGreater(seen, 3)

    def test_colors_change_within_their_limits(self):
        image = np.full((20, 20, 3), (100, 120, 140), np.uint8)
        changed = [
            augmentation.random_colors(image, augmentation.Augmentation(blur=0), augmentation.rng_of(1, e, 0)).mean()
            for e in range(40)
        ]
        self.assertTrue(60 < min(changed) < 110 and 130 < max(changed) < 200, (min(changed), max(changed)))

    def test_colors_change_as_those_of_torchvision(self):
        from PIL import Image
        from torchvision.transforms import functional
        rng = np.random.default_rng(4)
        image = cv2.resize(rng.integers(0, 256, (6, 8, 3), np.uint8), (80, 60), interpolation=cv2.INTER_LINEAR)
        limits = {"brightness": 1, "contrast": 2, "saturation": 2, "hue": 16}  # a step of 8 bits of hue is 6
        for name, values in (("brightness", (0.7, 1.3)), ("contrast", (0.7, 1.3)), ("saturation", (0.6, 1.4)),
                             ("hue", (-0.03, 0.03, 0.4))):
            for value in values:
                ours = augmentation.CHANGES[name](image, value).astype(int)
                theirs = np.asarray(getattr(functional, f"adjust_{name}")(Image.fromarray(image), value), int)
                self.assertLessEqual(np.abs(ours - theirs).max(), limits[name], (name, value))
                self.assertLess(np.abs(ours - theirs).mean(), 2, (name, value))
                self.assertGreater(np.abs(ours - image).mean(), 3 * np.abs(ours - theirs).mean(), (name, value))

    def test_little_of_an_object_is_neither_learned_nor_punished(self):
        target = augmentation.target_of(np.float32([[0, 0, 9, 9], [0, 0, 9, 9], [5, 5, 5, 9],
                                                    [0, 0, 9, 9]]), [0, 1, 2, 0], [False, False, False, True],
                                        np.array([0.9, 0.3, 0.0, 1.0]), 0.4)
        self.assertEqual([0, 1, 0], target["labels"].tolist())
        self.assertEqual([False, True, True], target["ignore"].tolist())

    def test_order_is_a_permutation_that_processes_divide(self):
        def batches(rank, world, epoch, first=0):
            sampler = StepSampler(25, 4, 1, rank, world)
            sampler.epoch, sampler.first_step = epoch, first
            return [[index for _, index in batch] for batch in sampler]
        alone = batches(0, 1, 2)
        self.assertEqual(24, len({i for batch in alone for i in batch}))
        self.assertNotEqual(alone, batches(0, 1, 3))
        self.assertEqual(alone[4:], batches(0, 1, 2, 4))
        both = [sorted(a + b) for a, b in zip(batches(0, 2, 2), batches(1, 2, 2))]
        self.assertEqual([sorted(alone[i] + alone[i + 1]) for i in (0, 2, 4)], both)

    def test_few_images_fill_a_batch(self):
        sampler = StepSampler(3, 8, 1)
        self.assertEqual([8], [len(batch) for batch in sampler])

    def test_preprocessing(self):
        images = torch.tensor([[[[10, 20, 30]]]], dtype=torch.uint8)
        rules = dataclasses.make_dataclass("P", ["color", "mean", "scale"])
        self.assertEqual([0.0, 5.0, 30.0], prepare(images, rules("rgb", (10, 10, 0), (1, 0.5, 1))).flatten().tolist())
        self.assertEqual([30.0, 20.0, 10.0], prepare(images, rules("bgr", 0, 1)).flatten().tolist())


class Checkpoints(TorchCase):
    def test_rotation_and_damage(self):
        with tempfile.TemporaryDirectory() as folder:
            place, reports = CheckpointFolder(folder, 2), []
            self.assertIsNone(place.load_newest())
            (pathlib.Path(folder) / ".step_000000001.pt.partial").write_bytes(b"a killed process left this")
            for step in (5, 10, 15):
                place.save({"step": step}, step)
            self.assertEqual(["step_000000010.pt", "step_000000015.pt"], sorted(os.listdir(folder)))
            newest = place.files()[-1]
            newest.write_bytes(newest.read_bytes()[:60])
            self.assertEqual(10, place.load_newest(reports.append)["step"])
            self.assertIn("damaged", reports[0])


class ProgressLines(unittest.TestCase):
    def test_time_left(self):
        now = [0.0]
        progress = Progress(10, 2, io.StringIO(), lambda: now[0])
        self.assertIsNone(progress.left_s())
        for _ in range(4):
            now[0] += 5
            progress.step()
        self.assertEqual(20.0, progress.left_s())
        self.assertEqual(["0:59", "1:00:01"], [duration(59.2), duration(3601)])

    def test_plain_lines_without_a_terminal_and_a_bar_with_one(self):
        class Terminal(io.StringIO):
            def isatty(self):
                return True
        texts = []
        for stream in (io.StringIO(), Terminal()):
            now = [0.0]
            progress = Progress(100, 0, stream, lambda: now[0])
            for _ in range(50):
                now[0] += 1.0
                progress.step("loss 1.0")
            progress.line("an epoch")
            texts.append(stream.getvalue())
        self.assertEqual(["step 30/100 loss 1.0, 1:10 left", "an epoch"], texts[0].splitlines())
        self.assertEqual(50, texts[1].count("["  "#") + texts[1].count("[" "."))
        self.assertIn("50/100 loss 1.0, 0:50 left", texts[1])

if __name__ == "__main__":
    unittest.main()
