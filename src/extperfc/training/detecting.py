"""A network's detections as NumPy arrays."""

import numpy as np
import torch

from .cuda_graphs import recorded
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


class NetworkPass(torch.nn.Module):
    """pixels float32 [B, 3, H, W] -> the network's output, computed in `precision`, as float32."""

    def __init__(self, network, precision):
        super().__init__()
        self.network, self.precision = network, precision

    def forward(self, pixels):
        if self.precision == torch.float32:
            return self.network(pixels)
        if pixels.is_cuda:
            pixels = pixels.contiguous(memory_format=torch.channels_last)
        # Each weight is used once: a cache of converted ones would gain nothing, and a recording allows none.
        with torch.autocast(pixels.device.type, self.precision, cache_enabled=False):
            return as_float(self.network(pixels))


class LossModule(torch.nn.Module):
    """(images uint8 [B, H, W, 3], targets) -> losses: what DistributedDataParallel wraps.

    The network runs in `precision`; its losses are computed in float32. The targets may be on another device.
    """

    def __init__(self, network, precision=torch.float32):
        super().__init__()
        self.network_pass = NetworkPass(network, precision)

    @property
    def network(self):
        return self.network_pass.network

    def raw(self, images):
        """The network's output in float32."""
        return self.network_pass(prepare(images, self.network.preprocessing))

    def forward(self, images, targets):
        return self.network.loss(self.raw(images), targets)

    def record(self, images):
        """Makes one CUDA graph of the network's forward and one of its backward pass, for images of this shape. Statistics
        and weights stay; the network's training mode must, too. RuntimeError where that is not possible."""
        self.network_pass = recorded(self.network_pass, (prepare(images, self.network.preprocessing),))
