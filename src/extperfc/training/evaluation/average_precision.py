"""Average precision over the overlap that counts as found, as the ExtPerFC paper evaluates its detectors.

For class c and IoU threshold t, detections of all images are ranked by score. A detection is true when its IoU with an
object of its class, not yet found by a better one, is at least t. With precision p = TP / (TP + FP) and recall
r = TP / objects along the ranking,

    AP_c(t) = integral over r from 0 to 1 of max over r' >= r of p(r'),
    mAP(t)  = mean of AP_c(t) over the classes that have objects,
    mAP     = mean of mAP(t) over t = 0.01, 0.02, ..., 1.00.

AP_c(t) over t is the paper's figure of AP over IoU. COCO differs in two respects: it reads the precision at 101 recalls
instead of integrating, and averages over t = 0.50, 0.55, ..., 0.95; `interpolation="coco"` does the first.
"""

import dataclasses
import typing

import numpy as np

IOU_THRESHOLDS = np.arange(1, 101) / 100
COCO_RECALLS = np.linspace(0, 1, 101)
MAX_DETECTIONS = 100  # of a class per image, as COCO counts
EXACT = 1 - 1e-10  # IoU of equal boxes, up to rounding


class Detections(typing.NamedTuple):
    """Of one image: boxes [K, 4] x0 y0 x1 y1 px, scores [K] from 0 to 1, labels [K] from 0."""

    boxes: np.ndarray
    scores: np.ndarray
    labels: np.ndarray


class Truth(typing.NamedTuple):
    """Of one image: boxes [M, 4] px, labels [M], difficult [M]. Detections on a difficult object do not count."""

    boxes: np.ndarray
    labels: np.ndarray
    difficult: np.ndarray


@dataclasses.dataclass(frozen=True, eq=False)
class Ranking:
    """Detections of one class over all images, best first.

    scores [N], true and ignored bool [N, T] per IoU threshold, objects: the number that counts.
    """

    scores: np.ndarray
    true: np.ndarray
    ignored: np.ndarray
    objects: int

    def curve(self, column):
        """(recall [K], precision [K], scores [K]) along the ranking at one IoU threshold."""
        counted = ~self.ignored[:, column]
        found = np.cumsum(self.true[counted, column])
        rank = np.arange(1, len(found) + 1)
        return found / max(1, self.objects), found / np.maximum(rank, 1), self.scores[counted]

    def average_precision(self, column, interpolation="area"):
        """AP at one IoU threshold; NaN without objects. interpolation: "area" (the paper's) or "coco"."""
        if not self.objects:
            return float("nan")
        recall, precision, _ = self.curve(column)
        envelope = np.maximum.accumulate(precision[::-1])[::-1]
        if interpolation == "coco":
            places = np.searchsorted(recall, COCO_RECALLS, side="left")
            return float(np.append(envelope, 0.0)[np.minimum(places, len(envelope))].mean())
        return float(np.sum(np.diff(recall, prepend=0.0) * envelope))


@dataclasses.dataclass(frozen=True, eq=False)
class Evaluation:
    """AP of every class at every IoU threshold: ap [C, T], NaN for a class without objects."""

    class_names: typing.Tuple[str, ...]
    thresholds: np.ndarray
    ap: np.ndarray
    rankings: typing.Tuple[Ranking, ...]
    images: int

    def column(self, iou):
        """Index of an IoU threshold."""
        return int(np.argmin(np.abs(self.thresholds - iou)))

    def mean_ap_over_iou(self):
        """mAP(t) [T]: the mean over the classes with objects."""
        return mean_without_nan(self.ap, 0)

    def mean_ap(self, iou=None):
        """mAP at one IoU threshold, or the mean over all of them (the paper's); NaN without any object."""
        over_iou = self.mean_ap_over_iou()
        return float(over_iou.mean() if iou is None else over_iou[self.column(iou)])

    def best_threshold(self, iou=0.5):
        """(score threshold, F1, precision, recall) with the highest F1 over all classes together."""
        column = self.column(iou)
        parts = [(r.scores[~r.ignored[:, column]], r.true[~r.ignored[:, column], column]) for r in self.rankings]
        scores, true = (np.concatenate([p[i] for p in parts]) for i in (0, 1))
        objects = sum(r.objects for r in self.rankings)
        if not len(scores) or not objects:
            return 0.5, 0.0, 0.0, 0.0
        order = np.argsort(-scores, kind="stable")
        found = np.cumsum(true[order])
        precision, recall = found / np.arange(1, len(found) + 1), found / objects
        f1 = 2 * precision * recall / np.maximum(precision + recall, 1e-9)
        best = int(np.argmax(f1))
        return float(scores[order][best]), float(f1[best]), float(precision[best]), float(recall[best])

    def as_dict(self):
        """For JSON."""
        over_iou = self.mean_ap_over_iou()
        threshold, f1, precision, recall = self.best_threshold()
        return {
            "images": self.images, "iou_thresholds": [round(float(t), 2) for t in self.thresholds],
            "mean_ap": self.mean_ap(), "mean_ap50": self.mean_ap(0.5), "mean_ap75": self.mean_ap(0.75),
            "mean_ap_over_iou": [float(v) for v in over_iou],
            "classes": {name: {"objects": r.objects, "ap": float(row.mean()), "ap50": float(row[self.column(0.5)]),
                               "ap75": float(row[self.column(0.75)]), "ap_over_iou": [float(v) for v in row]}
                        for name, r, row in zip(self.class_names, self.rankings, self.ap)},
            "best_threshold": {"score": threshold, "f1": f1, "precision": precision, "recall": recall}}


def mean_without_nan(values, axis):
    """Mean of what is a number; NaN where nothing is."""
    known = ~np.isnan(values)
    count = known.sum(axis)
    return np.where(count, np.where(known, values, 0).sum(axis) / np.maximum(count, 1), np.nan)


def iou_matrix(a, b):
    """IoU [len(a), len(b)] of boxes x0 y0 x1 y1."""
    common = intersections(a, b)
    return common / np.maximum(areas(a)[:, None] + areas(b)[None] - common, 1e-12)


def intersections(a, b):
    low = np.maximum(a[:, None, :2], b[None, :, :2])
    high = np.minimum(a[:, None, 2:], b[None, :, 2:])
    return np.prod(np.clip(high - low, 0, None), axis=2)


def areas(boxes):
    return np.prod(np.clip(boxes[:, 2:] - boxes[:, :2], 0, None), axis=1)


def match(boxes, truth, difficult, thresholds):
    """(true, ignored), bool [N, T], of one image's detections of one class, best first.

    Each takes the object with the highest IoU among those that are free at that threshold. One that finds none is
    ignored when that part of it lies on a difficult object (COCO's rule for crowds: intersection over the detection's
    area).
    """
    limits = np.minimum(thresholds, EXACT)
    true = np.zeros((len(boxes), len(limits)), bool)
    ignored = np.zeros_like(true)
    free = np.ones((len(limits), len(truth)), bool)
    overlap = iou_matrix(boxes, truth)
    covered = intersections(boxes, difficult) / np.maximum(areas(boxes), 1e-12)[:, None]
    columns = np.arange(len(limits))
    for i in range(len(boxes)):
        if len(truth):
            candidates = np.where(free, overlap[i], -1.0)
            best = candidates.argmax(1)
            true[i] = candidates[columns, best] >= limits
            free[columns[true[i]], best[true[i]]] = False
        if len(difficult):
            ignored[i] = ~true[i] & (covered[i].max() >= limits)
    return true, ignored


def rank(detections, truths, label, thresholds):
    """Ranking of one class over all images."""
    scores, true, ignored, objects = [], [], [], 0
    for found, truth in zip(detections, truths):
        mine = np.flatnonzero(found.labels == label)
        mine = mine[np.argsort(-found.scores[mine], kind="stable")][:MAX_DETECTIONS]
        of_class = truth.labels == label
        plain = truth.boxes[of_class & ~truth.difficult].astype(np.float64)
        hard = truth.boxes[of_class & truth.difficult].astype(np.float64)
        hits, skipped = match(found.boxes[mine].astype(np.float64).reshape(-1, 4), plain, hard, thresholds)
        scores.append(found.scores[mine])
        true.append(hits)
        ignored.append(skipped)
        objects += len(plain)
    scores = np.concatenate(scores) if scores else np.zeros(0)
    order = np.argsort(-scores, kind="stable")
    shape = (0, len(thresholds))
    stack = [np.concatenate(part or [np.zeros(shape, bool)])[order] for part in (true, ignored)]
    return Ranking(scores[order], *stack, objects)


def evaluate(detections, truths, class_names, thresholds=IOU_THRESHOLDS, interpolation="area"):
    """Evaluation of the Detections of images against their Truth, both in the same order and the same pixels."""
    if len(detections) != len(truths):
        raise ValueError(f"{len(detections)} images have detections, but {len(truths)} have labels")
    rankings = tuple(rank(detections, truths, label, thresholds) for label in range(len(class_names)))
    ap = np.array([[r.average_precision(t, interpolation) for t in range(len(thresholds))] for r in rankings])
    return Evaluation(tuple(class_names), np.asarray(thresholds), ap.reshape(len(class_names), len(thresholds)),
                      rankings, len(truths))
