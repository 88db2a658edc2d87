"""A network's detections as NumPy arrays."""

import numpy as np
import torch

from .data.torch_dataset import prepare
from .evaluation import Detections, Truth


def to_numpy(found):
    """Detections of one image of DetectionNetwork.detect()."""
    boxes, scores, labels = (found[key].detach().float().cpu().numpy() for key in ("boxes", "scores", "labels"))
    return Detections(boxes.reshape(-1, 4), scores, labels.astype(np.int64))


def truth_of(target):
    """Truth of a target of DetectionDataset, in input pixels."""
    return Truth(target["boxes"].cpu().numpy(), target["labels"].cpu().numpy(), target["ignore"].cpu().numpy())


def as_float(raw):
    """float32 for every floating tensor of a network's raw output, in any nesting of lists, tuples and dictionaries."""
    if isinstance(raw, torch.Tensor):
        return raw.float() if raw.dtype.is_floating_point else raw
    if isinstance(raw, dict):
        return type(raw)((key, as_float(value)) for key, value in raw.items())
    if isinstance(raw, tuple) and hasattr(raw, "_fields"):
        return type(raw)(*(as_float(value) for value in raw))
    return type(raw)(as_float(value) for value in raw) if isinstance(raw, (list, tuple)) else raw


class LossModule(torch.nn.Module):
    """(images uint8 [B, H, W, 3], targets) -> losses: what DistributedDataParallel wraps.

    The network runs in `precision`; its losses are computed in float32.
    """

    def __init__(self, network, precision=torch.float32):
        super().__init__()
        self.network, self.precision = network, precision

    def raw(self, images):
        """The network's output in float32."""
        pixels = prepare(images, self.network.preprocessing)
        if self.precision == torch.float32:
            return self.network(pixels)
        with torch.autocast(images.device.type, self.precision):
            return as_float(self.network(pixels))

    def forward(self, images, targets):
        return self.network.loss(self.raw(images), targets)
