"""Training by time budget: AdamW, cosine schedule with warm-up, averaged weights, checkpoints."""
import copy
import math
import time
from pathlib import Path

import cv2
import numpy as np
import torch
from torch.utils.data import DataLoader, IterableDataset

from . import dataset, network
from .loss import detection_loss

WARMUP_STEPS = 300
REFRESH = 4000  # samples after which the worker looks for new images in the cache
OBJECTS = 28  # maximum of objects in one sample
MOSAICS = 0.45  # fraction of samples made of several images, which hold more objects; none at the end


class Samples(IterableDataset):
    """Endless augmented samples: image (H, W, 3) uint8, truth (OBJECTS, 5), valid (OBJECTS,); class -1 is ignored."""

    def __init__(self, options, seed, mosaic):
        self.options, self.seed, self.mosaic = options, seed, mosaic

    def __iter__(self):
        cv2.setNumThreads(1)
        augmenter = dataset.Augmenter([], self.seed)
        while True:
            augmenter.use(dataset.index(self.options.cache, 'train', self.options.versions))
            for _ in range(REFRESH):
                image, boxes = augmenter.sample(self.mosaic)
                truth, valid = np.zeros((OBJECTS, 5), np.float32), np.zeros(OBJECTS, bool)
                count = min(OBJECTS, len(boxes))
                boxes = boxes[np.argsort(boxes[:, 0] < 0, kind='stable')][:count]
                truth[:count], valid[:count] = boxes, True
                yield image, truth, valid


def average(slow, fast, step):
    """Moves the averaged network towards the trained one."""
    keep = min(0.999, (1 + step) / (20 + step))
    with torch.no_grad():
        for a, b in zip(slow.state_dict().values(), fast.state_dict().values()):
            if a.dtype.is_floating_point:
                a.mul_(keep).add_(b, alpha=1 - keep)
            else:
                a.copy_(b)


def optimiser(net, rate):
    """AdamW with decay on convolution weights only."""
    plain = [p for p in net.parameters() if p.ndim == 1]
    decayed = [p for p in net.parameters() if p.ndim > 1]
    return torch.optim.AdamW([{'params': plain, 'weight_decay': 0.0}, {'params': decayed, 'weight_decay': 0.03}], lr=rate)


def schedule(step, progress, rate):
    """Learning rate: linear warm-up, then half a cosine over the fraction of the time budget that has passed."""
    return rate * min(1, (step + 1) / WARMUP_STEPS) * (0.02 + 0.98 * 0.5 * (1 + math.cos(math.pi * min(1, progress))))


class Trainer:
    """One training run; `run` returns when the time budget is used up."""

    def __init__(self, options):
        if not dataset.index(options.cache, 'train', options.versions):
            raise SystemExit(f'no images in {options.cache}: run `tools/train_shapes generate` first')
        torch.manual_seed(options.seed)
        torch.set_num_threads(options.threads)
        self.options = options
        name = ('cuda' if torch.cuda.is_available() else 'cpu') if options.device == 'auto' else options.device
        self.device = torch.device(name)
        self.net = network.ShapeNet().to(self.device, memory_format=torch.channels_last)
        self.slow = copy.deepcopy(self.net).eval()
        self.solver = optimiser(self.net, options.rate)
        self.step, self.used = 0, 0.0
        self.centres, self.strides = (t.to(self.device) for t in network.cells())
        self.checkpoint = Path(options.checkpoint)
        if options.resume and self.checkpoint.exists():
            self.restore()

    def restore(self):
        """Continues from the checkpoint."""
        state = torch.load(self.checkpoint, map_location=self.device)
        self.net.load_state_dict(state['net'])
        self.slow.load_state_dict(state['average'])
        self.solver.load_state_dict(state['solver'])
        self.step, self.used = state['step'], state['used_s']

    def save(self):
        """Writes the checkpoint, whole or not at all."""
        self.checkpoint.parent.mkdir(parents=True, exist_ok=True)
        partial = self.checkpoint.with_suffix('.partial')
        torch.save({'net': self.net.state_dict(), 'average': self.slow.state_dict(), 'solver': self.solver.state_dict(),
                    'step': self.step, 'used_s': self.used, 'seed': self.options.seed}, partial)
        partial.rename(self.checkpoint)

    def one_step(self, batch, progress):
        """Learns from one batch; returns both losses."""
        images, truth, valid = (part.to(self.device) for part in batch)
        used = max(1, int(valid.sum(1).max()))
        truth, valid = truth[:, :used], valid[:, :used]
        images = images.permute(0, 3, 1, 2).float().mul_(1 / 255).contiguous(memory_format=torch.channels_last)
        for group in self.solver.param_groups:
            group['lr'] = schedule(self.step, progress, self.options.rate)
        with torch.autocast(self.device.type, torch.bfloat16, enabled=self.options.bfloat16):
            logits, reach = self.net(images)
        score_loss, box_loss = detection_loss(logits, reach, self.centres, self.strides, truth, valid)
        self.solver.zero_grad(set_to_none=True)
        (score_loss + box_loss).backward()
        torch.nn.utils.clip_grad_norm_(self.net.parameters(), 10.0)
        self.solver.step()
        self.step += 1
        average(self.slow, self.net, self.step)
        return float(score_loss), float(box_loss)

    def run(self):
        """Trains until the budget is used up; the last part of it without mosaics."""
        budget, begin = 60.0 * self.options.minutes, time.time() - self.used
        sums, mosaic, batches = np.zeros(2), MOSAICS, None
        while self.used < budget:
            late = self.used > 0.93 * budget
            if batches is None or (late and mosaic > 0):
                mosaic = 0.0 if late else MOSAICS
                samples = Samples(self.options, self.options.seed + self.step, mosaic)
                batches = iter(DataLoader(samples, self.options.batch, num_workers=1, prefetch_factor=4))
            sums = 0.97 * sums + 0.03 * np.array(self.one_step(next(batches), self.used / budget))
            self.used = time.time() - begin
            if self.step % 50 == 0:
                rate = schedule(self.step, self.used / budget, self.options.rate)
                print(f'step {self.step} samples {self.step * self.options.batch} score {sums[0]:.3f} box {sums[1]:.3f} '
                      f'rate {rate:.5f} left {(budget - self.used) / 60:.1f} min', flush=True)
            if self.step % 500 == 0:
                self.save()
        self.save()
