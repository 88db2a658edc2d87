"""Prior (default) boxes of an SSD and the offsets from them: Liu et al., "SSD: Single Shot MultiBox Detector", 2016,
section 2.2. Order and arithmetic are those of layout `ssd_priors` in models/README.md.
"""

import dataclasses
import typing

import torch

VARIANCES = (0.1, 0.2)  # of centre and size


@dataclasses.dataclass(frozen=True)
class PriorLevel:
    """Boxes of one feature map of cells x cells; stride and sizes in input pixels, aspect ratios as width over height.

    Per cell: a square of min_size, a square of sqrt(min_size * max_size), then a wide and a tall box for each ratio.
    """

    cells: int
    stride: int
    min_size: float
    max_size: float
    aspect_ratios: typing.Tuple[float, ...] = (2, 3)

    def sizes(self):
        """(width, height) of each box of a cell [px]."""
        middle = (self.min_size * self.max_size) ** 0.5
        boxes = [(self.min_size, self.min_size), (middle, middle)]
        for root in (ratio ** 0.5 for ratio in self.aspect_ratios):
            boxes += [(self.min_size * root, self.min_size / root), (self.min_size / root, self.min_size * root)]
        return boxes

    def as_dict(self):
        """Its entry in model.yaml."""
        return {"stride": self.stride, "rows": self.cells, "columns": self.cells, "min_size": self.min_size,
                "max_size": self.max_size, "aspect_ratios": list(self.aspect_ratios)}


def make_priors(levels, input_size):
    """cx cy w h, float32 [N, 4], 0 to 1 of a square input, clipped to it."""
    rows = [((x + 0.5) * level.stride, (y + 0.5) * level.stride, w, h)
            for level in levels for y in range(level.cells) for x in range(level.cells) for w, h in level.sizes()]
    return (torch.tensor(rows, dtype=torch.float64) / input_size).clamp(0, 1).float()


def corners(boxes):
    """x0 y0 x1 y1 from cx cy w h, [..., 4]."""
    return torch.cat([boxes[..., :2] - boxes[..., 2:] / 2, boxes[..., :2] + boxes[..., 2:] / 2], -1)


def decode(offsets, priors):
    """cx cy w h of offsets [..., N, 4]: centre = prior centre + offset * 0.1 * prior size, size = prior size *
    exp(offset * 0.2)."""
    center, size = VARIANCES
    return torch.cat([priors[:, :2] + offsets[..., :2] * center * priors[:, 2:],
                      priors[:, 2:] * torch.exp(offsets[..., 2:] * size)], -1)


def encode(boxes, priors):
    """Offsets [N, 4] of boxes cx cy w h from their priors: the inverse of decode(). Sides must be positive."""
    center, size = VARIANCES
    return torch.cat([(boxes[:, :2] - priors[:, :2]) / priors[:, 2:] / center,
                      torch.log(boxes[:, 2:] / priors[:, 2:]) / size], -1)
