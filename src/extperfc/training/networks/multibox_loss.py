"""SSD's training objective: Liu et al., "SSD: Single Shot MultiBox Detector", 2016, section 2.2, equations 1 to 3."""

import typing

import torch
import torchvision
from torch.nn import functional

from . import priors as prior_boxes

MATCH_IOU = 0.5  # a prior at or above belongs to the object
NEGATIVES_PER_POSITIVE = 3
NEGATIVES_WITHOUT_OBJECTS = 3  # the paper has no such images: here they teach what no object looks like
BACKGROUND = 0
IGNORED = -1


class Matching(typing.NamedTuple):
    """Per prior: its class (0: background, -1: neither learned nor punished), and the row of its object."""

    classes: torch.Tensor
    objects: torch.Tensor


def match(target, corners, input_size):
    """Matching of priors x0 y0 x1 y1 [N, 4], 0 to 1, with the objects of an image.

    Every object gets the prior of the best overlap; every other prior with an overlap of MATCH_IOU its best object. Of
    two objects with the same best prior the one that overlaps more has it, and the other its best free one.
    """
    boxes, ignored = target["boxes"] / input_size, target["ignore"]
    classes = torch.full((len(corners),), BACKGROUND, dtype=torch.int64, device=corners.device)
    objects = torch.zeros_like(classes)
    if len(boxes) == 0:
        return Matching(classes, objects)
    overlap = torchvision.ops.box_iou(boxes, corners)
    best, objects = overlap.max(0)
    forced = force_best(overlap, objects)
    matched = (best >= MATCH_IOU) | forced
    classes = torch.where(matched, target["labels"][objects] + 1, classes)
    return Matching(torch.where(matched & ignored[objects], torch.full_like(classes, IGNORED), classes), objects)


def force_best(overlap, objects):
    """Gives every object its best prior, in `objects` [N]; returns which priors were given so, bool [N]."""
    forced = torch.zeros(overlap.shape[1], dtype=torch.bool, device=overlap.device)
    for row in overlap.max(1)[0].argsort(dim=0, descending=True, stable=True).tolist():
        prior = int(overlap[row].masked_fill(forced, -1).argmax())
        objects[prior], forced[prior] = row, True
    return forced


def hard_negatives(losses, classes):
    """The background priors with the highest loss, three for every positive one: bool [B, N] (section 2.2)."""
    wanted = (NEGATIVES_PER_POSITIVE * (classes > 0).sum(1)).clamp(min=NEGATIVES_WITHOUT_OBJECTS)
    losses = losses.detach().masked_fill(classes != BACKGROUND, -1)
    rank = losses.argsort(dim=1, descending=True, stable=True).argsort(dim=1, stable=True)
    return (rank < wanted[:, None]) & (classes == BACKGROUND)


def multibox_loss(offsets, logits, targets, priors, input_size):
    """L = (L_conf + L_loc) / N over the N matched priors of the batch.

    offsets [B, P, 4], logits [B, P, 1 + C] with the background first, priors cx cy w h [P, 4] from 0 to 1.
    """
    corners = prior_boxes.corners(priors)
    matchings = [match(target, corners, input_size) for target in targets]
    classes = torch.stack([matching.classes for matching in matchings])
    losses = functional.cross_entropy(logits.flatten(0, 1), classes.flatten().clamp(min=0), reduction="none").view_as(
        classes
    )
    counted = (classes > 0) | hard_negatives(losses, classes)
    count = max(1, int((classes > 0).sum()))
    localization = offsets.sum() * 0
    for row, (target, matching) in enumerate(zip(targets, matchings)):
        positive = matching.classes > 0
        if positive.any():
            boxes = torchvision.ops.box_convert(
                target["boxes"][matching.objects[positive]] / input_size, "xyxy", "cxcywh"
            )
            wanted = prior_boxes.encode(boxes, priors[positive])
            localization = localization + functional.smooth_l1_loss(offsets[row, positive], wanted, reduction="sum")
    return {"classification": (losses * counted).sum() / count, "localization": localization / count}
