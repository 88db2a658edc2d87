"""Training of the default detector: AdamW, warm-up, constant rate, linear decay; averaged weights; exact resumption.

What is learnt at a step depends on the recipe and the step alone, so that a run that was ended and resumed, on this or
another machine, goes the same way as one that was not (up to rounding, which differs between processors).
"""
import copy
import gc
from dataclasses import asdict, dataclass
from pathlib import Path

import torch

from ..cuda_graphs import recorded
from ..progress import Progress
from . import HEIGHT, WIDTH, network
from .augment import Augmenter
from .export import earlier_runs, read_weights
from .loss import detection_loss
from .store import NONE, ImageStore

WAIT_S = 600.0  # for an image that is being rendered


@dataclass
class Recipe:
    """Everything that decides about the weights."""
    seed: int = 1
    images: int = 90000  # rendered ones
    first_images: int = 3000  # that the first steps draw from
    more_images: int = 12  # with every step, so that rendering may go on
    steps: int = 7500
    small_steps: int = 3000  # of them, the first, with a small input
    small_size: tuple = (256, 192)
    size: tuple = (WIDTH, HEIGHT)
    decay_steps: int = 4500  # of them, the last, with a falling rate and, in their second half, without mosaics
    warmup_steps: int = 500
    batch: int = 128
    rate: float = 3e-3
    weight_decay: float = 0.03
    mosaic: float = 0.3  # fraction of samples
    averaging: float = 0.9995  # of the weights, per step

    @classmethod
    def continued(cls, steps=3500):
        """Of a run that begins with trained weights: other samples, the whole input, a rate that falls from the start."""
        return cls(seed=2, images=54000, first_images=12000, more_images=12, steps=steps, small_steps=0, decay_steps=steps,
                   rate=2e-3, warmup_steps=min(500, steps))

    def pool(self, step):
        """Images that a step draws from."""
        return min(self.images, self.first_images + self.more_images * step)

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


class Average:
    """A network whose weights follow those of a trained one: a running average."""

    def __init__(self, net, keep):
        self.net, self.keep = copy.deepcopy(net).eval(), keep
        pairs = list(zip(self.net.state_dict().values(), net.state_dict().values()))
        self.slow, self.fast = zip(*[(a, b) for a, b in pairs if a.dtype.is_floating_point])
        self.counters = [(a, b) for a, b in pairs if not a.dtype.is_floating_point]

    @torch.no_grad()
    def follow(self, step):
        """Moves towards the trained network. In few calls: a GPU would wait for hundreds of them."""
        keep = min(self.keep, (1 + step) / (20 + step))
        torch._foreach_mul_(self.slow, keep)
        torch._foreach_add_(self.slow, self.fast, alpha=1 - keep)
        for a, b in self.counters:
            a.copy_(b)


class Losses(torch.nn.Module):
    """Losses (2,), of scores and boxes, of one network for images of one size (width, height)."""

    def __init__(self, net, size, device, bfloat16):
        super().__init__()
        self.net, self.device_type, self.bfloat16 = net, device.type, bfloat16
        centres, strides = network.cells(*size)
        self.register_buffer('centres', centres.to(device))
        self.register_buffer('strides', strides.to(device))

    def forward(self, images, boxes):
        """Images (B, 3, H, W), 0 to 255, and boxes (B, OBJECTS, 5) of an Augmenter."""
        images = images.mul(1 / 255).contiguous(memory_format=torch.channels_last)
        with torch.autocast(self.device_type, torch.bfloat16, enabled=self.bfloat16, cache_enabled=False):
            logits, reach = self.net(images)
        return torch.stack(detection_loss(logits, reach, self.centres, self.strides, boxes, boxes[..., 0] > NONE))

    def record(self, images, boxes):
        """Makes CUDA graphs of both passes, for batches of this shape: a GPU then waits for no call. Statistics stay.
        RuntimeError where that is not possible.
        """
        gc.collect()  # the graphs of an earlier phase, with their memory
        torch.cuda.empty_cache()
        recorded(self, (images, boxes))


def optimiser(net, recipe):
    """AdamW with decay on convolution weights only."""
    plain = [p for p in net.parameters() if p.ndim == 1]
    decayed = [p for p in net.parameters() if p.ndim > 1]
    return torch.optim.AdamW([{'params': plain, 'weight_decay': 0.0},
                              {'params': decayed, 'weight_decay': recipe.weight_decay}], lr=recipe.rate)


class Trainer:
    """One run; `options` has folder, checkpoint, device ('auto', 'cpu', 'cuda'), threads, bfloat16, save_every.

    `start`: weights.pt of a model folder, or a checkpoint, instead of random weights.
    """

    def __init__(self, recipe, options, start=None):
        torch.manual_seed(recipe.seed)
        torch.set_num_threads(options.threads)
        self.recipe, self.options = recipe, options
        name = ('cuda' if torch.cuda.is_available() else 'cpu') if options.device == 'auto' else options.device
        self.device = torch.device(name)
        torch.backends.cudnn.benchmark = True  # a run has few sizes
        self.net = network.ShapeNet()
        self.before = []  # runs that led to the weights of the start
        if start is not None:
            self.net.load_state_dict(read_weights(start))
            self.before = earlier_runs(start)
        self.net = self.net.to(self.device, memory_format=torch.channels_last)
        self.average = Average(self.net, recipe.averaging)
        self.solver = optimiser(self.net, recipe)
        self.step = 0
        self.checkpoint = Path(options.checkpoint)
        if self.checkpoint.exists():
            self.restore()

    def restore(self):
        """Continues from the checkpoint."""
        state = torch.load(self.checkpoint, map_location=self.device)
        self.net.load_state_dict(state['net'])
        self.average.net.load_state_dict(state['average'])
        self.solver.load_state_dict(state['solver'])
        self.step, self.before = state['step'], state.get('before', [])
        print(f'resumed at step {self.step}', flush=True)

    def save(self):
        """Writes the checkpoint, whole or not at all."""
        self.checkpoint.parent.mkdir(parents=True, exist_ok=True)
        partial = self.checkpoint.with_suffix('.partial')
        torch.save({'net': self.net.state_dict(), 'average': self.average.net.state_dict(),
                    'solver': self.solver.state_dict(), 'step': self.step, 'recipe': asdict(self.recipe),
                    'before': self.before}, partial)
        partial.rename(self.checkpoint)

    @staticmethod
    def record(losses, batch):
        """Makes the steps to come quicker where that is possible."""
        try:
            losses.record(*batch)
        except RuntimeError as error:
            print(f'CUDA graphs are not possible here ({str(error).splitlines()[0]}); going on without', flush=True)

    def one_step(self, losses, images, boxes):
        """Learns from one batch; returns both losses (2,), on the device."""
        for group in self.solver.param_groups:
            group['lr'] = self.recipe.learning_rate(self.step)
        values = losses(images, boxes)
        self.solver.zero_grad(set_to_none=True)
        values.sum().backward()
        torch.nn.utils.clip_grad_norm_(self.net.parameters(), 10.0)
        self.solver.step()
        self.step += 1
        self.average.follow(self.step)
        return values.detach()

    def run(self):
        """Trains to the last step."""
        recipe, options = self.recipe, self.options
        store = ImageStore(options.folder, recipe.images, self.device, WAIT_S, options.threads)
        progress, smooth, text = Progress(recipe.steps, self.step), None, ''
        while self.step < recipe.steps:
            end, size = recipe.phase_end(self.step), recipe.input_size(self.step)
            losses = Losses(self.net, size, self.device, options.bfloat16)
            augmenter, to_record = Augmenter(store, size, recipe.seed, recipe.batch), self.device.type == 'cuda'
            while self.step < end:
                pool = recipe.pool(self.step)
                store.grow(pool)
                batch = augmenter.samples(self.step, pool, recipe.mosaics(self.step))
                if to_record:
                    self.record(losses, batch)
                    to_record = False
                values = self.one_step(losses, *batch)
                smooth = values.lerp(values if smooth is None else smooth, 0.98)
                if self.step % 50 == 0:  # what is on the device is read now and then only
                    text = 'score {:.3f}, box {:.3f}'.format(*smooth.tolist())
                progress.step(text)
                if self.step % options.save_every == 0:
                    self.save()
        self.save()
