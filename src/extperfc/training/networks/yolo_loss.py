"""Label assignment and loss of YOLOv7-tiny.

YOLOv7 (Wang et al. 2022, section 4.2) assigns by the predictions of the lead head, with SimOTA's optimization; the tiny
network has no auxiliary head, so the lead head's assignment is the only one. SimOTA: Ge et al., "YOLOX: Exceeding YOLO
Series in 2021", section 2.1: for object i and prediction j the cost c_ij = L_cls + lambda * L_reg (equation 1), and the
k_i predictions of the lowest cost within a fixed centre region are positive, k_i being the sum of the best overlaps.
The loss of boxes is complete IoU (Zheng et al., "Distance-IoU Loss", 2020, equations 10 to 12).
"""

import math
import typing

import torch
import torchvision
from torch.nn import functional

from .objects import common_area, pairwise_iou, stack

LAMBDA = 3.0  # weight of the overlap in the cost
MAX_SIZE_RATIO = 4.0  # an anchor is a candidate for objects up to this factor larger or smaller
CENTER_RADIUS = 1.0  # cells between the centres of an object and of its candidate cells, along each axis
BEST_OVERLAPS = 10  # whose sum is the number of positives
LOCALIZATION_GAIN = 5.0  # YOLOX, section 2.1
IGNORED_FRACTION = 0.5  # of a prediction's area within an ignored object


class Predictions(typing.NamedTuple):
    """All N predictions of a batch: boxes cx cy w h [B, N, 4] px, logits of objectness and classes [B, N, 1 + C]; and,
    the same for every image, the anchors' sizes [N, 2] px, the cells' centres [N, 2] px and their strides [N] px."""

    boxes: torch.Tensor
    logits: torch.Tensor
    anchors: torch.Tensor
    centers: torch.Tensor
    strides: torch.Tensor


def predictions_of(levels, anchors, strides):
    """Predictions from YoloV7Tiny.decoded()."""
    places = [cells_of(boxes, sizes, stride) for (boxes, _), sizes, stride in zip(levels, anchors, strides)]
    sizes, centers, steps = (torch.cat(parts) for parts in zip(*places))
    boxes = torch.cat([boxes.flatten(1, 3) for boxes, _ in levels], 1)
    logits = torch.cat([logits.flatten(1, 3) for _, logits in levels], 1)
    return Predictions(boxes, logits, sizes, centers, steps)


def cells_of(boxes, sizes, stride):
    """Anchor sizes, cell centres and strides of a level's predictions, in the order of its maps."""
    count, rows, columns = boxes.shape[1:4]
    y, x = torch.meshgrid(*(torch.arange(n, device=boxes.device) for n in (rows, columns)), indexing="ij")
    centers = ((torch.stack([x, y], -1) + 0.5) * stride).reshape(-1, 2).repeat(count, 1)
    return (
        sizes.repeat_interleave(rows * columns, 0),
        centers,
        torch.full((len(centers),), float(stride), device=boxes.device),
    )


def corners(boxes):
    """x0 y0 x1 y1 of boxes cx cy w h."""
    return torchvision.ops.box_convert(boxes, "cxcywh", "xyxy")


@torch.no_grad()
def assign(predictions, boxes, labels, learned):
    """(which predictions are positive, bool [B, N]; the object of each, int64 [B, N]).

    boxes: cx cy w h [B, M, 4] px, M > 0. labels: [B, M]. learned: bool [B, M], the objects that get predictions.
    """
    allowed = learned[..., None] & is_candidate(predictions, boxes)
    overlap = pairwise_iou(corners(boxes), corners(predictions.boxes)).masked_fill(~allowed, 0)
    cost = class_cost(predictions.logits, labels) + LAMBDA * -torch.log(overlap + 1e-8)
    cost = cost.masked_fill(~allowed, math.inf)
    chosen = cheapest(cost, overlap)
    return chosen.any(1), cost.masked_fill(~chosen, math.inf).argmin(1)  # what several objects want is the cheapest's


def is_candidate(predictions, boxes):
    """bool [B, M, N]: predictions in cells about the centre of an object cx cy w h, with an anchor of about its size."""
    allowed = torch.ones((*boxes.shape[:2], len(predictions.anchors)), dtype=torch.bool, device=boxes.device)
    for axis in (0, 1):  # one after the other: all at once would need four times the memory
        center, size = boxes[..., axis, None], boxes[..., 2 + axis, None]
        allowed &= (center - predictions.centers[:, axis]).abs() < CENTER_RADIUS * predictions.strides
        ratio = size / predictions.anchors[:, axis]
        allowed &= (ratio < MAX_SIZE_RATIO) & (ratio > 1 / MAX_SIZE_RATIO)
    return allowed


def class_cost(logits, labels):
    """Binary cross-entropy [B, M, N] of the predicted scores with each object's class."""
    scores = (logits[..., :1].sigmoid() * logits[..., 1:].sigmoid()).sqrt().clamp(1e-7, 1 - 1e-7)
    wrong = -torch.log1p(-scores)
    rows = labels[..., None].expand(-1, -1, logits.shape[1])
    return wrong.sum(2)[:, None] + (-torch.log(scores) - wrong).transpose(1, 2).gather(1, rows)


def cheapest(cost, overlap):
    """bool [B, M, N]: of every object the k predictions of the lowest cost, k the sum of its best overlaps, at least 1."""
    few = min(BEST_OVERLAPS, overlap.shape[2])
    counts = overlap.topk(few, 2)[0].sum(2).int().clamp(min=1)
    costs, places = cost.topk(few, 2, largest=False)
    wanted = (torch.arange(few, device=cost.device) < counts[..., None]) & costs.isfinite()
    return torch.zeros_like(cost, dtype=torch.bool).scatter_(2, places, wanted)


@torch.no_grad()
def ignored_predictions(predictions, ignored, exist):
    """bool [B, N]: predictions that lie mostly in an ignored object [B, M, 4] cx cy w h that exists [B, M]."""
    found = predictions.boxes[:, None]
    common = common_area(corners(found), corners(ignored[:, :, None]))
    return (exist[..., None] & (common > IGNORED_FRACTION * found[..., 2:].prod(-1))).any(1)


def complete_iou(boxes, wanted):
    """IoU less the squared distance of centres over the squared diagonal and a term of the aspect ratio; boxes cx cy
    w h."""
    one, other = corners(boxes), corners(wanted)
    common = common_area(one, other)
    iou = common / (boxes[:, 2:].prod(1) + wanted[:, 2:].prod(1) - common + 1e-7)
    diagonal = (torch.maximum(one[:, 2:], other[:, 2:]) - torch.minimum(one[:, :2], other[:, :2])).square().sum(1)
    distance = (boxes[:, :2] - wanted[:, :2]).square().sum(1) / (diagonal + 1e-7)
    angle = torch.atan(wanted[:, 2] / wanted[:, 3]) - torch.atan(boxes[:, 2] / (boxes[:, 3] + 1e-7))
    aspect = 4 / math.pi ** 2 * angle.square()
    weight = (aspect / (1 - iou + aspect + 1e-7)).detach()
    return iou - distance - weight * aspect


def yolo_loss(levels, targets, anchors, strides):
    """Sums over the batch divided by its number of positive predictions; the objectness to learn is the overlap."""
    predictions = predictions_of(levels, anchors, strides)
    objects = stack(targets, predictions.boxes.device)
    objectness = torch.zeros_like(predictions.logits[..., 0])
    counted = torch.ones_like(objectness, dtype=torch.bool)
    image = row = owner = objects.labels.new_zeros(0)
    boxes = torchvision.ops.box_convert(objects.boxes, "xyxy", "cxcywh")
    if boxes.shape[1]:
        learned = objects.exist & ~objects.ignore & (boxes[..., 2:] > 0).all(2)
        positive, owners = assign(predictions, boxes, objects.labels, learned)
        counted = positive | ~ignored_predictions(predictions, boxes, objects.exist & objects.ignore)
        image, row = positive.nonzero(as_tuple=True)
        owner = owners[image, row]
    overlap = complete_iou(predictions.boxes[image, row], boxes[image, owner])
    objectness[image, row] = overlap.detach().clamp(0, 1).to(objectness.dtype)
    logits = predictions.logits[image, row, 1:]
    kinds = functional.one_hot(objects.labels[image, owner], logits.shape[1]).to(logits.dtype)
    classification = functional.binary_cross_entropy_with_logits(logits, kinds, reduction="sum")
    each = functional.binary_cross_entropy_with_logits(predictions.logits[..., 0], objectness, reduction="none")
    count = max(1, len(image))
    return {"localization": LOCALIZATION_GAIN * (1 - overlap).sum() / count, "objectness": (each * counted).sum() / count,
            "classification": classification / count}
