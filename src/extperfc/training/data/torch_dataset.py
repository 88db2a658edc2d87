"""Samples as PyTorch's loaders want them."""

import numpy as np
import torch

from . import augmentation
from .placement import make_input


class DetectionDataset(torch.utils.data.Dataset):
    """Images as a network's input and their targets.

    An item is (image uint8 [H, W, 3] RGB, target): `boxes` float32 [M, 4] x0 y0 x1 y1 in pixels of the input, `labels`
    int64 [M] from 0, `ignore` bool [M], `index` of the sample. With `options` each image is augmented, in a manner that
    seed, epoch and index fix; without, it is only resized.
    """

    def __init__(self, dataset, input_size, resize, options=None, seed=0):
        self.samples, self.input_size, self.resize = dataset.samples, tuple(input_size), resize
        self.options, self.seed = options, seed

    def __len__(self):
        return len(self.samples)

    def __getitem__(self, key):
        """key: the index, or (epoch, index)."""
        epoch, index = key if isinstance(key, tuple) else (0, key)
        sample = self.samples[index]
        image, boxes, visible = sample.read_image(), sample.boxes, np.ones(len(sample.boxes))
        rng = augmentation.rng_of(self.seed, epoch, index)
        if self.options:
            image, boxes, visible = augmentation.random_view(image, boxes, self.options, rng)
        image, placement = make_input(image, self.input_size, self.resize)
        if self.options:
            image = augmentation.random_colors(image, self.options, rng)
        min_visible = self.options.min_visible if self.options else 0.0
        target = augmentation.target_of(placement.to_input(boxes), sample.labels, sample.difficult, visible,
                                        min_visible)
        return torch.from_numpy(image), {**{k: torch.from_numpy(v) for k, v in target.items()}, "index": index}


def collate(items):
    """A batch: images uint8 [B, H, W, 3] and the list of targets."""
    return torch.stack([image for image, _ in items]), [target for _, target in items]


def prepare(images, preprocessing):
    """float32 [B, 3, H, W] from uint8 [B, H, W, 3]: x' = (x - mean) * scale, in 8-bit units."""
    def channels(values):
        return torch.as_tensor(np.broadcast_to(values, 3).copy(), dtype=torch.float32,
                               device=images.device).view(1, 3, 1, 1)
    pixels = images.permute(0, 3, 1, 2).float()
    if getattr(preprocessing, "color", "rgb") == "bgr":
        pixels = pixels.flip(1)
    return ((pixels - channels(preprocessing.mean)) * channels(preprocessing.scale)).contiguous()


class StepSampler(torch.utils.data.Sampler):
    """Keys (epoch, index) of the batches of one process in one epoch, from a step on.

    The order is a permutation that seed and epoch fix, over all processes alike; each batch of size * world images is
    cut among them. An incomplete last batch is left out, unless it is the only one: then images repeat.
    """

    def __init__(self, count, batch_size, seed, rank=0, world=1):
        self.count, self.batch_size, self.seed, self.rank, self.world = count, batch_size, seed, rank, world
        self.epoch, self.first_step = 0, 0

    @property
    def steps(self):
        """Steps of an epoch."""
        return max(1, self.count // (self.batch_size * self.world))

    def __len__(self):
        return self.steps - self.first_step

    def __iter__(self):
        order = np.random.default_rng([self.seed, 0x5A, self.epoch]).permutation(self.count)
        whole = self.batch_size * self.world
        order = np.resize(order, max(whole, len(order)))
        for step in range(self.first_step, self.steps):
            batch = order[step * whole:(step + 1) * whole][self.rank::self.world]
            yield [(self.epoch, int(i)) for i in batch]
