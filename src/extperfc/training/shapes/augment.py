"""Training samples from stored images, made by whole batches on the device that learns from them.

Boxes are (N, G, 5) float32: class (-1: ignored, -2: unused row), x0, y0, x1, y1 in pixels, x1 and y1 behind the last pixel.
"""
from dataclasses import dataclass

import torch
from torch.nn import functional

from . import PAD
from .store import NONE, OBJECTS, pinned

MIN_SIDE = 8  # of an object that is asked for, at the network's input [px]
KEPT = 0.35  # fraction of an object that has to be left to be asked for
MIRRORED, SWAPPED, GREY, COVERED = 0.5, 0.06, 0.09, 0.2  # fractions of samples; GREY counts SWAPPED in
COVERS = 4  # patches in a covered sample, at most


def sent(values, device):
    """Drawn values (on the CPU) on a device."""
    return pinned(values, device).to(device, non_blocking=True)


@dataclass
class Placing:
    """Where images go: source pixel (x, y) lands on scale * (x, y) + shift, mirrored before; seen within area only."""
    scale: torch.Tensor  # (N, 2)
    shift: torch.Tensor  # (N, 2) [px]
    mirrored: torch.Tensor  # (N,) bool
    area: torch.Tensor  # (N, 4) x0, y0, x1, y1 [px]

    def to(self, device):
        """The same on a device."""
        return Placing(*(sent(part, device) for part in vars(self).values()))


def place_boxes(boxes, width, placing):
    """Boxes of images of a width as the placing moves and cuts them; what is hardly left becomes ignored, specks unused."""
    label, left, top, right, bottom = boxes.unbind(-1)
    mirrored = placing.mirrored[:, None]
    left, right = torch.where(mirrored, width - right, left), torch.where(mirrored, width - left, right)
    moved = torch.stack([left, top, right, bottom], -1) * placing.scale.repeat(1, 2)[:, None] + placing.shift.repeat(1, 2)[:, None]
    low, high = placing.area[:, None, :2], placing.area[:, None, 2:]
    cut = torch.cat([moved[..., :2].clamp(low, high), moved[..., 2:].clamp(low, high)], -1)
    size, whole = cut[..., 2:] - cut[..., :2], moved[..., 2:] - moved[..., :2]
    short, long = size.amin(-1), size.amax(-1)
    asked = (size.prod(-1) >= KEPT * whole.prod(-1)) & (long >= MIN_SIDE) & (short >= 3)
    label = torch.where(asked, label, label.clamp(max=-1))
    label = torch.where((short >= 2) & (long >= 4), label, torch.full_like(label, NONE))
    return torch.cat([label[..., None], cut], -1)


def place_images(images, size, placing):
    """Images (N, H, W, 3) uint8 on canvases (N, 3, height, width) float, 0 to 255, with PAD around them."""
    height, width = images.shape[1:3]
    finer = 2 if width >= 1.5 * size[0] else 1  # what becomes smaller is sampled more finely, then averaged
    sign = torch.where(placing.mirrored, -1.0, 1.0)
    matrix = torch.zeros(len(images), 2, 3, device=images.device)
    for axis, (canvas, source) in enumerate(zip(size, (width, height))):
        reach = source * placing.scale[:, axis]
        matrix[:, axis, axis] = canvas / reach
        matrix[:, axis, 2] = (canvas - 2 * placing.shift[:, axis]) / reach - 1
    matrix[:, 0] *= sign[:, None]
    grid = functional.affine_grid(matrix, [len(images), 3, size[1] * finer, size[0] * finer], align_corners=False)
    source = images.permute(0, 3, 1, 2).float() - PAD
    placed = functional.grid_sample(source, grid, padding_mode='zeros', align_corners=False) + PAD
    return functional.avg_pool2d(placed, finer) if finer > 1 else placed


def first_objects(boxes):
    """The OBJECTS first rows (N, OBJECTS, 5): what is asked for, then what is ignored, then unused rows."""
    rank = -boxes[..., 0].clamp(max=0)
    order = rank.argsort(dim=1, stable=True)[:, :OBJECTS]
    return boxes.gather(1, order[..., None].expand(-1, -1, 5))


class Augmenter:
    """Batches for one network input size: a function of (seed, step) alone, up to rounding."""

    def __init__(self, store, size, seed, batch):
        self.store, self.size, self.seed, self.batch = store, size, seed, batch

    def samples(self, step, pool, mosaic):
        """Images (B, 3, H, W) float, 0 to 255, and boxes (B, OBJECTS, 5) from the first `pool` images; a fraction `mosaic`
        of the batch is made of four images each.
        """
        rng = torch.Generator().manual_seed(self.seed * 1_000_003 + step)
        of_four = round(mosaic * self.batch)
        images, boxes = self._single(rng, pool, self.batch - of_four)
        if of_four:
            more_images, more_boxes = self._mosaic(rng, pool, of_four)
            images, boxes = torch.cat([images, more_images]), torch.cat([boxes, more_boxes])
        return self._cover(rng, self._colour(rng, images), boxes), boxes

    def _placing(self, rng, area, zoom):
        """Images of the store into areas (N, 4), `zoom` (N,) times as large as they fit the whole canvas."""
        source = torch.tensor([self.store.width, self.store.height], dtype=torch.float32)
        fit = zoom * min(self.size[0] / self.store.width, self.size[1] / self.store.height)
        stretch = torch.exp(0.06 * torch.randn(len(area), generator=rng))
        scale = torch.stack([fit * stretch, fit / stretch], 1)
        gap = area[:, 2:] - area[:, :2] - source * scale
        shift = area[:, :2] + gap * torch.rand(len(area), 2, generator=rng)
        return Placing(scale, shift, torch.rand(len(area), generator=rng) < MIRRORED, area)

    def _paste(self, rng, pool, area, zoom):
        """Canvases with one drawn image each, and its boxes."""
        placing = self._placing(rng, area, zoom).to(self.store.device)
        images, boxes = self.store.fetch(torch.randint(pool, (len(area),), generator=rng))
        return place_images(images, self.size, placing), place_boxes(boxes, self.store.width, placing)

    def _single(self, rng, pool, count):
        area = torch.tensor([0.0, 0.0, *self.size]).expand(count, 4)
        zoom = torch.empty(count).uniform_(-0.29, 0.405, generator=rng).exp()  # 0.75 to 1.5
        return self._paste(rng, pool, area, zoom)

    def _mosaic(self, rng, pool, count):
        """Four images each, about a point in the middle third."""
        width, height = self.size
        x, y = [(side * torch.empty(count).uniform_(0.33, 0.67, generator=rng)).round() for side in self.size]
        none, right, bottom = torch.zeros(count), torch.full((count,), float(width)), torch.full((count,), float(height))
        whole, boxes = None, []
        columns, rows = torch.arange(width, device=self.store.device), torch.arange(height, device=self.store.device)
        for corners in ((none, none, x, y), (x, none, right, y), (none, y, x, bottom), (x, y, right, bottom)):
            area = torch.stack(corners, 1)
            part, more = self._paste(rng, pool, area, torch.empty(count).uniform_(-0.9, 0.1, generator=rng).exp())
            seen = inside(sent(area, self.store.device), columns, rows)
            whole = part if whole is None else torch.where(seen[:, None], part, whole)
            boxes.append(more)
        return whole, first_objects(torch.cat(boxes, 1))

    def _colour(self, rng, images):
        """Gain per channel, brightness, grey images, and exchange of channels."""
        count = len(images)
        kind = torch.rand(count, generator=rng)
        mixing = torch.eye(3).repeat(count, 1, 1)
        for number in (kind < SWAPPED).nonzero()[:, 0]:
            mixing[number] = mixing[number, torch.randperm(3, generator=rng)]
        mixing[(kind >= SWAPPED) & (kind < GREY)] = torch.tensor([0.299, 0.587, 0.114])
        gain = torch.exp(0.12 * torch.randn(count, 1, generator=rng) + 0.05 * torch.randn(count, 3, generator=rng))
        offset = 8 * torch.randn(count, 1, 1, generator=rng)
        mixing, offset = [sent(part, images.device) for part in (mixing * gain[..., None], offset)]
        return torch.baddbmm(offset, mixing, images.flatten(2)).clamp_(0, 255).view_as(images)

    def _cover(self, rng, images, boxes):
        """Covers small parts of some images, none of them much of an object."""
        width, height = self.size
        count = int(COVERED * len(images))
        columns, rows = torch.arange(width, device=images.device), torch.arange(height, device=images.device)
        chosen = sent(torch.randperm(len(images), generator=rng)[:count], images.device)
        for _ in range(COVERS):
            corner = torch.rand(count, 2, generator=rng) * torch.tensor([width - 6.0, height - 6.0])
            patch = torch.cat([corner, corner + torch.empty(count, 2).uniform_(6, 50, generator=rng)], 1)
            patch = sent(patch, images.device)
            colour = sent(255 * torch.rand(count, 3, 1, 1, generator=rng), images.device)
            low = torch.maximum(boxes[chosen, :, 1:3], patch[:, None, :2])
            high = torch.minimum(boxes[chosen, :, 3:], patch[:, None, 2:])
            size = boxes[chosen, :, 3:] - boxes[chosen, :, 1:3]
            hidden = (high - low).clamp(min=0).prod(-1) > 0.25 * size.prod(-1)
            free = ~hidden.any(1)[:, None, None] & inside(patch, columns, rows)
            images[chosen] = torch.where(free[:, None], colour, images[chosen])
        return images


def inside(area, columns, rows):
    """Mask (N, H, W) of the pixels in areas (N, 4)."""
    x0, y0, x1, y1 = area[:, :, None].unbind(1)
    across, down = (columns >= x0) & (columns < x1), (rows >= y0) & (rows < y1)
    return down[:, :, None] & across[:, None]
