"""From candidates to detections: threshold, then greedy suppression within each class."""

import torch
import torchvision

MAX_CANDIDATES = 1000  # of a class, compared with each other; as at run time (src/detect)


def suppress(boxes, scores, best_only, score_threshold, nms_iou, max_detections):
    """Detections of one image from boxes [N, 4] and scores [N, C].

    best_only: a box counts for its best class alone (YOLO), else for every class above the threshold (SSD).
    """
    boxes, scores = boxes.float(), scores.float()
    wanted = scores >= score_threshold
    if best_only:
        wanted &= torch.nn.functional.one_hot(scores.argmax(1), scores.shape[1]).bool()
    rows, labels = [], []
    for label in range(scores.shape[1]):
        found = wanted[:, label].nonzero()[:, 0]
        found = found[scores[found, label].argsort(dim=0, descending=True, stable=True)[:MAX_CANDIDATES]]
        rows.append(found)
        labels.append(torch.full_like(found, label))
    rows, labels = torch.cat(rows), torch.cat(labels)
    values = scores[rows, labels]
    keep = torchvision.ops.batched_nms(boxes[rows], values, labels, nms_iou)[:max_detections]
    return {"boxes": boxes[rows[keep]], "scores": values[keep], "labels": labels[keep]}
