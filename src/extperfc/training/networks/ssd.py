"""The single shot detector on any backbone: Liu et al., "SSD: Single Shot MultiBox Detector", 2016."""

import torch
from torch import nn

from . import priors as prior_boxes
from .multibox_loss import multibox_loss
from .network import IMAGENET, DetectionNetwork

INPUT = 300  # pixels, both sides
PREDICTION_STD = 0.01  # of the first weights that predict


class Ssd(DetectionNetwork):
    """Feature maps of a backbone, further ones of `extras`, and a predictor of offsets and one of classes on each.

    backbone(images) gives a list of maps, of which the first `predicted` (default: all) have predictors; each stage of
    `extras` makes the next one from the last. `scaling`, if given, is applied to the first map before its predictors.
    raw: offsets [B, N, 4] and logits [B, N, 1 + C], background first.
    """

    input_size = (INPUT, INPUT)
    preprocessing = IMAGENET

    def __init__(self, name, class_names, backbone, extras, channels, predictor, levels, scaling=None,
                 predicted=None, learning_rate=DetectionNetwork.learning_rate):
        """channels: of every map. predictor(inputs, outputs, is_last): the module that predicts."""
        super().__init__()
        self.learning_rate = learning_rate
        self.name, self.class_names, self.levels = name, tuple(class_names), tuple(levels)
        self.backbone, self.extras = backbone, nn.ModuleList(extras)
        self.scaling, self.predicted = scaling or nn.Identity(), predicted
        counts = [len(level.sizes()) for level in levels]
        last = len(levels) - 1
        self.offset_heads = nn.ModuleList(
            predictor(c, n * 4, i == last) for i, (c, n) in enumerate(zip(channels, counts))
        )
        self.class_heads = nn.ModuleList(predictor(c, n * (1 + len(class_names)), i == last)
                                         for i, (c, n) in enumerate(zip(channels, counts)))
        self.register_buffer("priors", prior_boxes.make_priors(levels, INPUT), persistent=False)
        for part in (self.extras, self.offset_heads, self.class_heads):
            part.apply(start_convolution)
        for head in [*self.offset_heads, *self.class_heads]:
            start_prediction(head)

    def forward(self, images):
        maps = self.backbone(images)
        last, maps = maps[-1], maps[:self.predicted]
        for stage in self.extras:
            last = stage(last)
            maps.append(last)
        maps[0] = self.scaling(maps[0])
        offsets = [rows(head(m), 4) for head, m in zip(self.offset_heads, maps)]
        logits = [rows(head(m), 1 + len(self.class_names)) for head, m in zip(self.class_heads, maps)]
        return torch.cat(offsets, 1), torch.cat(logits, 1)

    def loss(self, raw, targets):
        return multibox_loss(*raw, targets, self.priors, INPUT)

    def candidates(self, raw):
        offsets, logits = raw
        return prior_boxes.corners(prior_boxes.decode(offsets, self.priors)) * INPUT, logits.softmax(-1)[..., 1:], False

    def export_form(self):
        output = {"layout": "ssd_priors", "names": ["offsets", "logits"], "background_class": 0, "apply_softmax": True,
                  "variances": list(prior_boxes.VARIANCES),
                  "priors": {"clip": True, "levels": [level.as_dict() for level in self.levels]}}
        return self, ["offsets", "logits"], output


def rows(values, columns):
    """[B, N, columns] of a map [B, boxes * columns, H, W]: row after row, and per cell box after box."""
    return values.permute(0, 2, 3, 1).reshape(values.shape[0], -1, columns)


def start_convolution(module):
    """First weights of a new convolution: what it gives after a ReLU varies as much as what it gets, however many follow
    each other, depthwise ones too (He et al., "Delving Deep into Rectifiers", 2015, equation 10)."""
    if isinstance(module, nn.Conv2d):
        nn.init.kaiming_normal_(module.weight, nonlinearity="relu")
        if module.bias is not None:
            nn.init.zeros_(module.bias)


def start_prediction(head):
    """The first predictions are the priors themselves and hardly differ between classes."""
    last = [module for module in head.modules() if isinstance(module, nn.Conv2d)][-1]
    nn.init.normal_(last.weight, std=PREDICTION_STD)
