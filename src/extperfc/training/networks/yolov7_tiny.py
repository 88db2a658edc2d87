"""YOLOv7-tiny: Wang et al., "YOLOv7: Trainable bag-of-freebies sets new state-of-the-art for real-time object
detectors", 2022 (section 3.1: efficient layer aggregation; section 4.3: implicit knowledge; tiny: leaky ReLU), written
from the paper.
"""

import math

import torch
from torch import nn
from torch.nn import functional

from .network import UNIT_RANGE, DetectionNetwork
from .yolo_loss import yolo_loss

STRIDES = (8, 16, 32)
# Width and height in input pixels, per stride: the YOLO family's boxes of COCO.
ANCHORS = (((10, 13), (16, 30), (33, 23)), ((30, 61), (62, 45), (59, 119)), ((116, 90), (156, 198), (373, 326)))
PER_CELL = 3
OBJECTS_PER_IMAGE = 8  # expected at 640 pixels; only for the first bias of objectness


class Unit(nn.Sequential):
    """Convolution without bias, batch normalization, leaky ReLU."""

    def __init__(self, inputs, outputs, kernel=1, stride=1):
        super().__init__(nn.Conv2d(inputs, outputs, kernel, stride, kernel // 2, bias=False),
                         nn.BatchNorm2d(outputs, eps=1e-3, momentum=0.03), nn.LeakyReLU(0.1, inplace=True))


class Aggregation(nn.Module):
    """Efficient layer aggregation (section 3.1, figure 2c) of tiny size: two 1 x 1 branches, two 3 x 3 layers after the
    second, all four maps side by side into a 1 x 1 layer."""

    def __init__(self, inputs, hidden, outputs):
        super().__init__()
        self.bypass, self.enter = Unit(inputs, hidden), Unit(inputs, hidden)
        self.first, self.second = Unit(hidden, hidden, 3), Unit(hidden, hidden, 3)
        self.leave = Unit(4 * hidden, outputs)

    def forward(self, x):
        entered = self.enter(x)
        first = self.first(entered)
        return self.leave(torch.cat([self.second(first), first, entered, self.bypass(x)], 1))


class PyramidPool(nn.Module):
    """Spatial pyramid pooling over 5, 9 and 13 cells inside a cross-stage block."""

    def __init__(self, inputs, outputs):
        super().__init__()
        self.bypass, self.enter = Unit(inputs, outputs), Unit(inputs, outputs)
        self.mix, self.leave = Unit(4 * outputs, outputs), Unit(2 * outputs, outputs)

    def forward(self, x):
        entered = self.enter(x)
        pooled = [functional.max_pool2d(entered, size, 1, size // 2) for size in (13, 9, 5)]
        return self.leave(torch.cat([self.mix(torch.cat([*pooled, entered], 1)), self.bypass(x)], 1))


class Backbone(nn.Module):
    """Maps of 128, 256 and 512 channels at strides 8, 16 and 32."""

    def __init__(self):
        super().__init__()
        self.stem = nn.Sequential(Unit(3, 32, 3, 2), Unit(32, 64, 3, 2), Aggregation(64, 32, 64))
        self.to8, self.to16, self.to32 = (
            Aggregation(64, 64, 128),
            Aggregation(128, 128, 256),
            Aggregation(256, 256, 512),
        )

    def forward(self, images):
        fine = self.to8(functional.max_pool2d(self.stem(images), 2))
        middle = self.to16(functional.max_pool2d(fine, 2))
        return [fine, middle, self.to32(functional.max_pool2d(middle, 2))]


class Neck(nn.Module):
    """Path aggregation: from coarse to fine, and back."""

    def __init__(self):
        super().__init__()
        self.pool = PyramidPool(512, 256)
        self.up16, self.side16, self.mix16 = Unit(256, 128), Unit(256, 128), Aggregation(256, 64, 128)
        self.up8, self.side8, self.mix8 = Unit(128, 64), Unit(128, 64), Aggregation(128, 32, 64)
        self.down16, self.back16 = Unit(64, 128, 3, 2), Aggregation(256, 64, 128)
        self.down32, self.back32 = Unit(128, 256, 3, 2), Aggregation(512, 128, 256)
        self.ends = nn.ModuleList([Unit(64, 128, 3), Unit(128, 256, 3), Unit(256, 512, 3)])

    def forward(self, maps):
        fine, middle, coarse = maps
        coarse = self.pool(coarse)
        middle = self.mix16(torch.cat([self.side16(middle), doubled(self.up16(coarse))], 1))
        fine = self.mix8(torch.cat([self.side8(fine), doubled(self.up8(middle))], 1))
        middle = self.back16(torch.cat([self.down16(fine), middle], 1))
        coarse = self.back32(torch.cat([self.down32(middle), coarse], 1))
        return [end(m) for end, m in zip(self.ends, (fine, middle, coarse))]


def doubled(x):
    """Every cell becomes four."""
    return functional.interpolate(x, scale_factor=2.0, mode="nearest")


class Head(nn.Module):
    """1 x 1 convolution between two learned constants per channel, one added and one multiplied: implicit knowledge
    (section 4.3); `fused` gives the one convolution that does the same."""

    def __init__(self, inputs, outputs):
        super().__init__()
        self.convolution = nn.Conv2d(inputs, outputs, 1)
        self.added = nn.Parameter(torch.randn(1, inputs, 1, 1) * 0.02)
        self.factor = nn.Parameter(1 + torch.randn(1, outputs, 1, 1) * 0.02)

    def forward(self, x):
        return self.factor * self.convolution(x + self.added)

    def fused(self):
        """Convolution with the constants in its weights."""
        result = nn.Conv2d(self.convolution.in_channels, self.convolution.out_channels, 1)
        with torch.no_grad():
            factor = self.factor.flatten()
            result.weight.copy_(self.convolution.weight * factor[:, None, None, None])
            result.bias.copy_(self.convolution(self.added).flatten() * factor)
        return result


class RawHeads(nn.Module):
    """The network with fused heads: what is exported."""

    def __init__(self, network):
        super().__init__()
        self.backbone, self.neck = network.backbone, network.neck
        self.heads = nn.ModuleList(head.fused() for head in network.heads)

    def forward(self, images):
        return tuple(head(m) for head, m in zip(self.heads, self.neck(self.backbone(images))))


class YoloV7Tiny(DetectionNetwork):
    """raw: one map [B, 3 * (5 + C), rows, columns] per stride: per anchor tx ty tw th, objectness, classes.

    With s the sigmoid, centre = (2 s(t) - 0.5 + cell) * stride, size = (2 s(t))^2 * anchor, score = s(objectness) *
    s(class).
    """

    preprocessing = UNIT_RANGE

    def __init__(self, class_names, side):
        super().__init__()
        self.name, self.class_names, self.input_size = f"yolov7_tiny_{side}", tuple(class_names), (side, side)
        self.backbone, self.neck = Backbone(), Neck()
        self.heads = nn.ModuleList(Head(width, PER_CELL * (5 + len(class_names))) for width in (128, 256, 512))
        self.register_buffer("anchors", torch.tensor(ANCHORS, dtype=torch.float32), persistent=False)
        for head, stride in zip(self.heads, STRIDES):
            self._start_biases(head.convolution, stride)

    def _start_biases(self, convolution, stride):
        """First scores are those of few objects: without it the first steps only learn that most cells are empty."""
        with torch.no_grad():
            biases = convolution.bias.view(PER_CELL, -1)
            biases[:, 4] = math.log(OBJECTS_PER_IMAGE / (640 / stride) ** 2)
            biases[:, 5:] = math.log(0.6 / (len(self.class_names) - 0.99)) if len(self.class_names) > 1 else 0.0

    def forward(self, images):
        return tuple(head(m) for head, m in zip(self.heads, self.neck(self.backbone(images))))

    def decoded(self, raw):
        """Per stride: boxes cx cy w h in input pixels [B, 3, rows, columns, 4] and logits of objectness and classes."""
        return [
            self._decoded_level(values, anchors, stride) for values, anchors, stride in zip(raw, self.anchors, STRIDES)
        ]

    @staticmethod
    def _decoded_level(values, anchors, stride):
        rows, columns = values.shape[-2:]
        values = values.view(len(values), PER_CELL, -1, rows, columns).permute(0, 1, 3, 4, 2)
        y, x = torch.meshgrid(*(torch.arange(n, device=values.device) for n in (rows, columns)), indexing="ij")
        relative = values[..., :4].sigmoid() * 2
        center = (relative[..., :2] - 0.5 + torch.stack([x, y], -1)) * stride
        size = relative[..., 2:] ** 2 * anchors[:, None, None]
        return torch.cat([center, size], -1), values[..., 4:]

    def loss(self, raw, targets):
        return yolo_loss(self.decoded(raw), targets, self.anchors, STRIDES)

    def candidates(self, raw):
        levels = self.decoded(raw)
        boxes = torch.cat([boxes.flatten(1, 3) for boxes, _ in levels], 1)
        scores = torch.cat([logits.flatten(1, 3) for _, logits in levels], 1).sigmoid()
        corners = torch.cat([boxes[..., :2] - boxes[..., 2:] / 2, boxes[..., :2] + boxes[..., 2:] / 2], -1)
        return corners, scores[..., :1] * scores[..., 1:], True

    def export_form(self):
        names = [f"stride{stride}" for stride in STRIDES]
        levels = [
            {"stride": stride, "sizes": [list(size) for size in sizes]} for stride, sizes in zip(STRIDES, ANCHORS)
        ]
        return RawHeads(self), names, {"layout": "yolo_anchors", "names": names, "anchors": levels}
