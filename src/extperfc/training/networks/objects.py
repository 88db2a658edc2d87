"""The objects of a batch in tensors of one size, so that losses need no loop over its images: a GPU waits for loops."""

import typing

import torch


class Objects(typing.NamedTuple):
    """boxes float32 [B, M, 4] x0 y0 x1 y1 px, labels int64 [B, M], ignore bool [B, M] (neither learned nor punished),
    exist bool [B, M]; M is that of the image with the largest number of objects. Rows that do not exist are zero."""

    boxes: torch.Tensor
    labels: torch.Tensor
    ignore: torch.Tensor
    exist: torch.Tensor


def stack(targets, device):
    """Objects on a device, of the targets of DetectionNetwork.loss()."""
    def padded(name):
        return torch.nn.utils.rnn.pad_sequence([target[name] for target in targets], batch_first=True)
    ignore = padded("ignore")
    counts = torch.tensor([len(target["labels"]) for target in targets], device=ignore.device)
    exist = torch.arange(ignore.shape[1], device=ignore.device)[None] < counts[:, None]
    return Objects(*(part.to(device) for part in (padded("boxes"), padded("labels"), ignore, exist)))


def pairwise_iou(boxes, others):
    """Intersection over union [B, M, N] of boxes [B, M, 4] and others [N, 4] or [B, N, 4], x0 y0 x1 y1."""
    boxes, others = boxes[:, :, None], (others if others.ndim == 3 else others[None])[:, None]
    common = common_area(boxes, others)
    return common / (area(boxes) + area(others) - common).clamp(min=1e-12)


def common_area(boxes, others):
    """Area [...] that boxes [..., 4] have in common, x0 y0 x1 y1."""
    low, high = torch.maximum(boxes[..., :2], others[..., :2]), torch.minimum(boxes[..., 2:], others[..., 2:])
    return (high - low).clamp(min=0).prod(-1)


def area(boxes):
    """Area [...] of boxes [..., 4], x0 y0 x1 y1."""
    return (boxes[..., 2:] - boxes[..., :2]).prod(-1)
