"""Training targets and loss: task-aligned assignment (TOOD, Feng et al. 2021), scores that learn the IoU, GIoU."""
import torch
from torch.nn import functional

from .network import CLASS_COUNT, corners

TOP = 10  # cells per object


def area(sides):
    """Product of width and height (..., 2). prod() would do, but its gradient makes a GPU wait."""
    return sides[..., 0] * sides[..., 1]


def overlap(a, b):
    """IoU and GIoU of boxes (..., 4) x0, y0, x1, y1, broadcast."""
    low, high = torch.maximum(a[..., :2], b[..., :2]), torch.minimum(a[..., 2:], b[..., 2:])
    common = area((high - low).clamp(min=0))
    union = area((a[..., 2:] - a[..., :2]).clamp(min=0)) + area(b[..., 2:] - b[..., :2]) - common + 1e-6
    outer = area(torch.maximum(a[..., 2:], b[..., 2:]) - torch.minimum(a[..., :2], b[..., :2])) + 1e-6
    iou = common / union
    return iou, iou - (outer - union) / outer


def within(centres, boxes, valid):
    """Mask (B, G, N) of the cells whose centre lies in a valid box (B, G, 4)."""
    gap = torch.cat([centres[None, None] - boxes[:, :, None, :2], boxes[:, :, None, 2:] - centres[None, None]], -1)
    return (gap.min(-1)[0] > 0) & valid[..., None]


@torch.no_grad()
def assign(scores, boxes, centres, truth, valid):
    """Which cell learns which object.

    scores (B, N, C) and boxes (B, N, 4) are predictions; truth (B, G, 5) class, x0, y0, x1, y1; valid (B, G).
    Returns target scores (B, N, C), target boxes (B, N, 4) and the mask of positive cells (B, N).
    """
    batch, objects = valid.shape
    target = truth[..., 1:]
    inside = within(centres, target, valid)
    iou = overlap(target[:, :, None], boxes[:, None])[0] * inside
    kind = truth[..., 0].long()
    score = torch.gather(scores.transpose(1, 2), 1, kind[..., None].expand(-1, -1, scores.shape[1]))
    metric = score.sqrt() * iou ** 5 + 1e-9 * inside  # the small term lets the first cells in when no box overlaps yet
    best, which = metric.topk(TOP, -1)
    chosen = torch.zeros_like(metric).scatter_(-1, which, (best > 0).float()) * inside
    iou_chosen = torch.where(chosen > 0, iou + 1e-6, torch.zeros_like(iou))
    owner = iou_chosen.argmax(1)
    single = torch.zeros_like(chosen).scatter_(1, owner[:, None], 1.0) * chosen
    metric, iou = metric * single, iou * single
    quality = metric / (metric.amax(-1, keepdim=True) + 1e-9) * iou.amax(-1, keepdim=True)
    positive = single.sum(1) > 0
    rows = torch.arange(batch, device=truth.device)[:, None]
    value = quality.sum(1)
    wanted = functional.one_hot(kind[rows, owner], CLASS_COUNT).to(scores.dtype) * (value * positive)[..., None]
    return wanted, target[rows, owner], positive


def detection_loss(logits, reach, centres, strides, truth, valid):
    """Loss of scores and boxes: logits (B, C, N), log distances (B, 4, N), truth (B, G, 5), valid (B, G)."""
    ignored = valid & (truth[..., 0] < 0)
    skipped = within(centres, truth[..., 1:], ignored).any(1)
    valid, truth = valid & ~ignored, truth.clamp(min=0)
    logits, boxes = logits.float().transpose(1, 2), corners(reach.float(), centres, strides)
    scores = torch.sigmoid(logits.detach())
    wanted, target, positive = assign(scores, boxes.detach(), centres, truth, valid)
    total = wanted.sum().clamp(min=1)
    skipped &= ~positive
    each = functional.binary_cross_entropy_with_logits(logits, wanted, reduction='none')
    score_loss = (each * ~skipped[..., None]).sum() / total
    fraction = wanted.sum(-1) * positive  # a mask, as choosing rows would wait for the GPU
    box_loss = ((1 - overlap(boxes, target)[1]) * fraction).sum() / total
    return score_loss, 5.0 * box_loss
