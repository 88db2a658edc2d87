"""Training of the default detector: AdamW, warm-up, constant rate, linear decay; averaged weights; exact resumption.

What is learnt at a step depends on the recipe and the step alone, so that a run that was ended and resumed, on this or
another machine, goes the same way as one that was not (up to rounding, which differs between processors).
"""
import copy
import time
from dataclasses import asdict, dataclass
from pathlib import Path

import cv2
import numpy as np
import torch
from torch.utils.data import DataLoader, IterableDataset

from . import network
from .loss import detection_loss
from .samples import Augmenter

OBJECTS = 40  # maximum of objects in one sample
WAIT_S = 600.0  # for an image that is being rendered


@dataclass
class Recipe:
    """Everything that decides about the weights."""
    seed: int = 1
    images: int = 28000  # rendered ones
    first_images: int = 4000  # that the first steps draw from; three more per step, so that rendering may go on
    steps: int = 7200
    small_steps: int = 5000  # of them, the first, with a small input
    small_size: tuple = (256, 192)
    size: tuple = (384, 288)
    decay_steps: int = 2200  # of them, the last, with a falling rate and, in their second half, without mosaics
    warmup_steps: int = 300
    batch: int = 16
    rate: float = 2e-3
    weight_decay: float = 0.03
    mosaic: float = 0.3  # fraction of samples
    averaging: float = 0.9995  # of the weights, per step

    def pool(self, step):
        """Images that a step draws from."""
        return min(self.images, self.first_images + 3 * step)

    def input_size(self, step):
        """Width and height [px]."""
        return self.small_size if step < self.small_steps else self.size

    def mosaics(self, step):
        """Fraction of samples made of four images."""
        return self.mosaic if step < self.steps - self.decay_steps // 2 else 0.0

    def learning_rate(self, step):
        """Linear warm-up, constant, linear decay."""
        left = (self.steps - step) / max(1, self.decay_steps)
        return self.rate * min(1.0, (step + 1) / self.warmup_steps) * max(0.01, min(1.0, left))

    def phase_end(self, step):
        """First later step at which input size or mosaics change."""
        changes = (self.small_steps, self.steps - self.decay_steps // 2, self.steps)
        return min(change for change in changes if change > step)


class Samples(IterableDataset):
    """Samples of steps `first` to `last`: image (H, W, 3) uint8, truth (OBJECTS, 5), valid (OBJECTS,)."""

    def __init__(self, recipe, folder, first, last):
        self.recipe, self.folder, self.first, self.last = recipe, folder, first, last

    def __iter__(self):
        cv2.setNumThreads(1)
        augmenter = Augmenter(self.folder, self.recipe.input_size(self.first), self.recipe.seed, WAIT_S)
        for index in range(self.first * self.recipe.batch, self.last * self.recipe.batch):
            step = index // self.recipe.batch
            image, boxes = augmenter.sample(index, self.recipe.pool(step), self.recipe.mosaics(step))
            boxes = boxes[np.argsort(boxes[:, 0] < 0, kind='stable')][:OBJECTS]
            truth, valid = np.zeros((OBJECTS, 5), np.float32), np.zeros(OBJECTS, bool)
            truth[:len(boxes)], valid[:len(boxes)] = boxes, True
            yield image, truth, valid


def average(slow, fast, step, keep):
    """Moves the averaged network towards the trained one."""
    keep = min(keep, (1 + step) / (20 + step))
    with torch.no_grad():
        for a, b in zip(slow.state_dict().values(), fast.state_dict().values()):
            if a.dtype.is_floating_point:
                a.mul_(keep).add_(b, alpha=1 - keep)
            else:
                a.copy_(b)


def optimiser(net, recipe):
    """AdamW with decay on convolution weights only."""
    plain = [p for p in net.parameters() if p.ndim == 1]
    decayed = [p for p in net.parameters() if p.ndim > 1]
    return torch.optim.AdamW([{'params': plain, 'weight_decay': 0.0},
                              {'params': decayed, 'weight_decay': recipe.weight_decay}], lr=recipe.rate)


class Trainer:
    """One run; `options` has folder, checkpoint, device ('auto', 'cpu', 'cuda'), threads, bfloat16, save_every.

    `start`: weights.pt of a model folder instead of random weights.
    """

    def __init__(self, recipe, options, start=None):
        torch.manual_seed(recipe.seed)
        torch.set_num_threads(options.threads)
        self.recipe, self.options = recipe, options
        name = ('cuda' if torch.cuda.is_available() else 'cpu') if options.device == 'auto' else options.device
        self.device = torch.device(name)
        self.net = network.ShapeNet()
        if start is not None:
            self.net.load_state_dict({name: value.float() if value.is_floating_point() else value
                                      for name, value in torch.load(start, map_location='cpu').items()})
        self.net = self.net.to(self.device, memory_format=torch.channels_last)
        self.slow = copy.deepcopy(self.net).eval()
        self.solver = optimiser(self.net, recipe)
        self.step = 0
        self.checkpoint = Path(options.checkpoint)
        if self.checkpoint.exists():
            self.restore()

    def restore(self):
        """Continues from the checkpoint."""
        state = torch.load(self.checkpoint, map_location=self.device)
        self.net.load_state_dict(state['net'])
        self.slow.load_state_dict(state['average'])
        self.solver.load_state_dict(state['solver'])
        self.step = state['step']
        print(f'resumed at step {self.step}', flush=True)

    def save(self):
        """Writes the checkpoint, whole or not at all."""
        self.checkpoint.parent.mkdir(parents=True, exist_ok=True)
        partial = self.checkpoint.with_suffix('.partial')
        torch.save({'net': self.net.state_dict(), 'average': self.slow.state_dict(), 'solver': self.solver.state_dict(),
                    'step': self.step, 'recipe': asdict(self.recipe)}, partial)
        partial.rename(self.checkpoint)

    def one_step(self, batch, cells):
        """Learns from one batch; returns both losses."""
        images, truth, valid = (part.to(self.device) for part in batch)
        used = max(1, int(valid.sum(1).max()))
        truth, valid = truth[:, :used], valid[:, :used]
        images = images.permute(0, 3, 1, 2).float().mul_(1 / 255).contiguous(memory_format=torch.channels_last)
        for group in self.solver.param_groups:
            group['lr'] = self.recipe.learning_rate(self.step)
        with torch.autocast(self.device.type, torch.bfloat16, enabled=self.options.bfloat16):
            logits, reach = self.net(images)
        score_loss, box_loss = detection_loss(logits, reach, *cells, truth, valid)
        self.solver.zero_grad(set_to_none=True)
        (score_loss + box_loss).backward()
        torch.nn.utils.clip_grad_norm_(self.net.parameters(), 10.0)
        self.solver.step()
        self.step += 1
        average(self.slow, self.net, self.step, self.recipe.averaging)
        return float(score_loss), float(box_loss)

    def run(self):
        """Trains to the last step."""
        begin, first = time.time(), self.step
        sums = np.zeros(2)
        while self.step < self.recipe.steps:
            end = self.recipe.phase_end(self.step)
            cells = [part.to(self.device) for part in network.cells(*self.recipe.input_size(self.step))]
            samples = Samples(self.recipe, self.options.folder, self.step, end)
            for batch in DataLoader(samples, self.recipe.batch, num_workers=1, prefetch_factor=4):
                losses = np.array(self.one_step(batch, cells))
                sums = losses if not sums.any() else 0.98 * sums + 0.02 * losses
                if self.step % 50 == 0:
                    left = (time.time() - begin) / (self.step - first) * (self.recipe.steps - self.step)
                    print(f'step {self.step} of {self.recipe.steps} score {sums[0]:.3f} box {sums[1]:.3f} '
                          f'rate {self.recipe.learning_rate(self.step):.5f} left {left / 60:.0f} min', flush=True)
                if self.step % self.options.save_every == 0:
                    self.save()
        self.save()
