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

LAMBDA = 3.0  # weight of the overlap in the cost
MAX_SIZE_RATIO = 4.0  # an anchor is a candidate for objects up to this factor larger or smaller
CENTER_RADIUS = 1.0  # cells between the centres of an object and of its candidate cells, along each axis
BEST_OVERLAPS = 10  # whose sum is the number of positives
LOCALIZATION_GAIN = 5.0  # YOLOX, section 2.1
IGNORED_FRACTION = 0.5  # of a prediction's area within an ignored object


class Predictions(typing.NamedTuple):
    """All N predictions of an image: boxes cx cy w h [N, 4] px, logits of objectness and classes [N, 1 + C], the
    anchor's size [N, 2] px, the cell's centre [N, 2] px and its stride [N] px."""

    boxes: torch.Tensor
    logits: torch.Tensor
    anchors: torch.Tensor
    centers: torch.Tensor
    strides: torch.Tensor


def predictions_of(levels, anchors, strides):
    """One Predictions per image from YoloV7Tiny.decoded()."""
    places = [cells_of(boxes, sizes, stride) for (boxes, _), sizes, stride in zip(levels, anchors, strides)]
    sizes, centers, steps = (torch.cat(parts) for parts in zip(*places))
    boxes = torch.cat([boxes.flatten(1, 3) for boxes, _ in levels], 1)
    logits = torch.cat([logits.flatten(1, 3) for _, logits in levels], 1)
    return [Predictions(b, p, sizes, centers, steps) for b, p in zip(boxes, logits)]


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
def assign(predictions, boxes, labels):
    """(rows of the positive predictions, the object of each) for objects cx cy w h [M, 4] px, M > 0."""
    ratio = boxes[:, None, 2:] / predictions.anchors
    fits = torch.maximum(ratio, 1 / ratio).amax(-1) < MAX_SIZE_RATIO
    offset = (boxes[:, None, :2] - predictions.centers).abs() / predictions.strides[:, None]
    near = (offset < CENTER_RADIUS).all(-1)
    candidates = (fits & near).any(0).nonzero()[:, 0]
    if len(candidates) == 0:
        return candidates, candidates
    allowed = (fits & near)[:, candidates]
    overlap = torchvision.ops.box_iou(corners(boxes), corners(predictions.boxes[candidates]))
    overlap = overlap.masked_fill(~allowed, 0)
    cost = (class_cost(predictions.logits[candidates], labels) + LAMBDA * -torch.log(overlap + 1e-8)).masked_fill(
        ~allowed, math.inf)
    chosen = cheapest(cost, overlap)
    taken = chosen.any(0)
    owners = cost.masked_fill(~chosen, math.inf).argmin(0)  # a prediction that several objects want is the cheapest's
    return candidates[taken], owners[taken]


def class_cost(logits, labels):
    """Binary cross-entropy [M, K] of the predicted scores with each object's class."""
    scores = (logits[:, :1].sigmoid() * logits[:, 1:].sigmoid()).sqrt().clamp(1e-7, 1 - 1e-7)
    wrong = -torch.log1p(-scores)
    return wrong.sum(1) + (-torch.log(scores) - wrong)[:, labels].t()


def cheapest(cost, overlap):
    """bool [M, K]: of every object the k predictions of the lowest cost, k the sum of its best overlaps, at least 1."""
    best = overlap.topk(min(BEST_OVERLAPS, overlap.shape[1]), 1)[0]
    counts = best.sum(1).int().clamp(min=1)
    rank = cost.argsort(dim=1, stable=True).argsort(dim=1, stable=True)
    return (rank < counts[:, None]) & cost.isfinite()


def ignored_predictions(predictions, ignored):
    """bool [N]: predictions that lie mostly in an ignored object [M, 4] cx cy w h."""
    if len(ignored) == 0:
        return torch.zeros(len(predictions.boxes), dtype=torch.bool, device=predictions.boxes.device)
    found, objects = corners(predictions.boxes.detach()), corners(ignored)
    low, high = torch.maximum(found[:, None, :2], objects[:, :2]), torch.minimum(found[:, None, 2:], objects[:, 2:])
    common = (high - low).clamp(min=0).prod(-1)
    return (common > IGNORED_FRACTION * predictions.boxes.detach()[:, 2:].prod(-1)[:, None]).any(1)


def complete_iou(boxes, wanted):
    """IoU less the squared distance of centres over the squared diagonal and a term of the aspect ratio; boxes cx cy
    w h."""
    one, other = corners(boxes), corners(wanted)
    common = (torch.minimum(one[:, 2:], other[:, 2:]) - torch.maximum(one[:, :2], other[:, :2])).clamp(min=0).prod(1)
    iou = common / (boxes[:, 2:].prod(1) + wanted[:, 2:].prod(1) - common + 1e-7)
    diagonal = (torch.maximum(one[:, 2:], other[:, 2:]) - torch.minimum(one[:, :2], other[:, :2])).square().sum(1)
    distance = (boxes[:, :2] - wanted[:, :2]).square().sum(1) / (diagonal + 1e-7)
    angle = torch.atan(wanted[:, 2] / wanted[:, 3]) - torch.atan(boxes[:, 2] / (boxes[:, 3] + 1e-7))
    aspect = 4 / math.pi ** 2 * angle.square()
    weight = (aspect / (1 - iou + aspect + 1e-7)).detach()
    return iou - distance - weight * aspect


def image_loss(predictions, target):
    """Sums over an image: (localization, objectness, classification), and the number of positives."""
    wanted = torchvision.ops.box_convert(target["boxes"], "xyxy", "cxcywh")
    learned = ~target["ignore"] & (wanted[:, 2:] > 0).all(1)
    boxes, labels = wanted[learned], target["labels"][learned]
    objectness = torch.zeros(len(predictions.boxes), device=boxes.device)
    counted = ~ignored_predictions(predictions, wanted[target["ignore"]])
    localization = classification = predictions.logits.sum() * 0
    positive = owners = labels[:0]
    if len(boxes):
        positive, owners = assign(predictions, boxes, labels)
    if len(positive):
        overlap = complete_iou(predictions.boxes[positive], boxes[owners])
        localization = (1 - overlap).sum()
        objectness[positive] = overlap.detach().clamp(0, 1).to(objectness.dtype)
        counted[positive] = True
        kinds = functional.one_hot(labels[owners], predictions.logits.shape[1] - 1).to(predictions.logits.dtype)
        classification = functional.binary_cross_entropy_with_logits(
            predictions.logits[positive, 1:], kinds, reduction="sum"
        )
    each = functional.binary_cross_entropy_with_logits(predictions.logits[:, 0], objectness, reduction="none")
    return localization, (each * counted).sum(), classification, len(positive)


def yolo_loss(levels, targets, anchors, strides):
    """Sums over the batch divided by its number of positive predictions; the objectness to learn is the overlap."""
    sums = [image_loss(p, target) for p, target in zip(predictions_of(levels, anchors, strides), targets)]
    localization, objectness, classification, counts = zip(*sums)
    count = max(1, sum(counts))
    return {"localization": LOCALIZATION_GAIN * sum(localization) / count, "objectness": sum(objectness) / count,
            "classification": sum(classification) / count}
