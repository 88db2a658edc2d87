"""SSD's training objective: Liu et al., "SSD: Single Shot MultiBox Detector", 2016, section 2.2, equations 1 to 3."""

import typing

import torch
import torchvision
from torch.nn import functional

from . import priors as prior_boxes
from .objects import pairwise_iou, stack

MATCH_IOU = 0.5  # a prior at or above belongs to the object
NEGATIVES_PER_POSITIVE = 3
NEGATIVES_WITHOUT_OBJECTS = 3  # the paper has no such images: here they teach what no object looks like
BACKGROUND = 0
IGNORED = -1


class Matching(typing.NamedTuple):
    """Per image and prior, int64 [B, P]: its class (0: background, -1: neither learned nor punished), and the row of its
    object."""

    classes: torch.Tensor
    objects: torch.Tensor


def match(objects, corners, input_size):
    """Matching of priors x0 y0 x1 y1 [P, 4], 0 to 1, with the Objects of a batch.

    Every object gets the prior of the best overlap; every other prior with an overlap of MATCH_IOU its best object. Of
    two objects with the same best prior the one that overlaps more has it, and the other its best free one.
    """
    if objects.boxes.shape[1] == 0:
        none = torch.zeros(len(objects.boxes), len(corners), dtype=torch.int64, device=corners.device)
        return Matching(none, none)
    overlap = pairwise_iou(objects.boxes / input_size, corners).masked_fill(~objects.exist[..., None], -1)
    best, rows = overlap.max(1)
    forced = force_best(overlap, rows, objects.exist)
    matched = (best >= MATCH_IOU) | forced
    classes = torch.where(matched, objects.labels.gather(1, rows) + 1, BACKGROUND)
    return Matching(torch.where(matched & objects.ignore.gather(1, rows), IGNORED, classes), rows)


def force_best(overlap, rows, exist):
    """Gives every object its best prior, in `rows` [B, P]; returns which priors were given so, bool [B, P].

    overlap: [B, M, P]. exist: bool [B, M].
    """
    forced = torch.zeros_like(rows, dtype=torch.bool)
    for row in overlap.amax(2).argsort(dim=1, descending=True, stable=True).split(1, 1):  # [B, 1]: one object per image
        of_row = overlap.gather(1, row[..., None].expand(-1, -1, overlap.shape[2]))[:, 0]
        prior = of_row.masked_fill(forced, -2).argmax(1, keepdim=True)
        real = exist.gather(1, row)
        rows.scatter_(1, prior, torch.where(real, row, rows.gather(1, prior)))
        forced.scatter_(1, prior, real | forced.gather(1, prior))
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
    objects = stack(targets, offsets.device)
    matching = match(objects, prior_boxes.corners(priors), input_size)
    classes, positive = matching.classes, matching.classes > 0
    losses = functional.cross_entropy(logits.flatten(0, 1), classes.flatten().clamp(min=0), reduction="none").view_as(
        classes
    )
    counted = positive | hard_negatives(losses, classes)
    count = positive.sum().clamp(min=1)
    image, prior = positive.nonzero(as_tuple=True)
    boxes = objects.boxes[image, matching.objects[image, prior]] / input_size
    wanted = prior_boxes.encode(torchvision.ops.box_convert(boxes, "xyxy", "cxcywh"), priors[prior])
    localization = functional.smooth_l1_loss(offsets[image, prior], wanted, reduction="sum")
    return {"classification": (losses * counted).sum() / count, "localization": localization / count}
