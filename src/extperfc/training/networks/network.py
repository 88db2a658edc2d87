"""The contract of every network: what the trainer, the exporter and the evaluation know of it."""

import dataclasses
import typing

import torch


@dataclasses.dataclass(frozen=True)
class Preprocessing:
    """How an image becomes the network's input: resized, then x' = (x - mean) * scale in 8-bit units, channel by
    channel.

    color: "rgb". resize: "stretch" (each axis scaled alone) or "letterbox" (aspect kept, centred, the rest grey 114).
    """

    resize: str
    mean: typing.Tuple[float, float, float]
    scale: typing.Tuple[float, float, float]
    color: str = "rgb"


IMAGENET = Preprocessing("stretch", (123.675, 116.28, 103.53), (1 / 58.395, 1 / 57.12, 1 / 57.375))
UNIT_RANGE = Preprocessing("letterbox", (0.0, 0.0, 0.0), (1 / 255, 1 / 255, 1 / 255))


class DetectionNetwork(torch.nn.Module):
    """A detector of boxes.

    name: as in NETWORKS. class_names: without the background. input_size: width, height [px]. preprocessing:
    Preprocessing. backbone: the part that feature-representation transfer copies and freezes; everything else is the
    head. learning_rate: the highest one that suits AdamW and 32 images per step.

    forward(images) takes float32 [B, 3, H, W], preprocessed, and gives `raw`, a tuple of tensors. loss(raw, targets)
    gives scalars to be summed. targets: one dictionary per image with `boxes` float32 [M, 4] x0 y0 x1 y1 in input
    pixels, `labels` int64 [M] from 0, `ignore` bool [M] (neither learned nor punished); M may be 0. They may be on
    another device than raw.
    """

    name: str
    class_names: typing.Tuple[str, ...]
    input_size: typing.Tuple[int, int]
    preprocessing: Preprocessing
    backbone: torch.nn.Module
    learning_rate: float = 1e-3

    def head_parameters(self):
        """Parameters outside the backbone."""
        of_backbone = {id(parameter) for parameter in self.backbone.parameters()}
        return [parameter for parameter in self.parameters() if id(parameter) not in of_backbone]

    def loss(self, raw, targets):
        """{"classification", "localization", maybe "objectness"}: scalars."""
        raise NotImplementedError

    def candidates(self, raw):
        """(boxes [B, N, 4] in input pixels, scores [B, N, C] from 0 to 1, whether only the best class of a box
        counts)."""
        raise NotImplementedError

    def export_form(self):
        """(module, output tensor names, `output` section of model.yaml): what export() writes."""
        raise NotImplementedError

    @torch.no_grad()
    def detect(self, raw, score_threshold=0.01, nms_iou=0.45, max_detections=100):
        """One dictionary per image, best first: `boxes` [K, 4] in input pixels, `scores` [K], `labels` [K]."""
        from .suppression import suppress
        boxes, scores, best_only = self.candidates(raw)
        return [suppress(*one, best_only, score_threshold, nms_iou, max_detections) for one in zip(boxes, scores)]


def parameter_count(network):
    """Numbers that training can change."""
    return sum(parameter.numel() for parameter in network.parameters())
