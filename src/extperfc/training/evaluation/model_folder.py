"""Model folders (models/README.md) in Python: the network by OpenCV or OpenVINO, decoded as src/detect does it."""

import pathlib

import cv2
import numpy as np
import yaml

from ..data.dataset import DataError
from ..networks.model_folder import placed_input
from ..networks.runtimes import OpenCv, OpenVino
from .average_precision import Detections

RUNNERS = {"opencv": OpenCv, "openvino": OpenVino}
SCORE, NMS_IOU, MAX_DETECTIONS = 0.01, 0.45, 100  # for average precision, whatever the model's own threshold


def sigmoid(x):
    return 1 / (1 + np.exp(-np.clip(x, -80, 80)))


class FolderDetector:
    """Detections of RGB images by the network of a model folder.

    DataError when the folder has no model.yaml, or its layout is unknown.
    """

    def __init__(self, folder, backend="opencv", score=SCORE):
        self.folder, self.score = pathlib.Path(folder), score
        file = self.folder / "model.yaml"
        if not file.exists():
            raise DataError(f"{self.folder}: no model.yaml: give a model folder, a weights.pt, or the output of a run")
        self.spec = yaml.safe_load(file.read_text())
        self.layout = self.spec["output"]["layout"]
        if self.layout not in DECODERS:
            raise DataError(f"{file}: output.layout {self.layout} is unknown: known are {', '.join(DECODERS)}")
        self.class_names = tuple(self.spec.get("classes") or
                                 filter(None, (self.folder / self.spec["classes_file"]).read_text().splitlines()))
        entry = self.spec["input"]
        self.input_size = entry["width"], entry["height"]
        self.nms_iou = self.spec.get("thresholds", {}).get("nms_iou", NMS_IOU)
        self.runner = RUNNERS[backend](self.folder / self.spec["file"], self.spec["output"].get("names"))

    def detect(self, image):
        """Detections, in pixels of the image uint8 [H, W, 3] RGB."""
        tensor, placement = placed_input(image, self.spec)
        boxes, scores = DECODERS[self.layout](self.runner.run(tensor), self.spec["output"], self.input_size)
        found = self._suppress(boxes, scores, best_only=not self.layout.startswith("ssd"))
        return found._replace(boxes=placement.to_image(found.boxes, image.shape[1::-1]))

    def _suppress(self, boxes, scores, best_only):
        """Suppression within each class; a YOLO candidate counts for its best class only."""
        rows = []
        best = scores.argmax(1) if best_only else None
        for label in range(scores.shape[1]):
            keep = np.flatnonzero((scores[:, label] >= self.score) & (best == label if best_only else True))
            sides = np.concatenate([boxes[keep, :2], boxes[keep, 2:] - boxes[keep, :2]], 1)
            for i in cv2.dnn.NMSBoxes(sides.tolist(), scores[keep, label].tolist(), self.score, self.nms_iou):
                rows.append((scores[keep[i], label], label, *boxes[keep[i]]))
        rows = np.array(sorted(rows, reverse=True)[:MAX_DETECTIONS], np.float32).reshape(-1, 6)
        return Detections(rows[:, 2:], rows[:, 0], rows[:, 1].astype(np.int64))


def around(center, size):
    """Corners [N, 4] of boxes with a centre and a size [N, 2]."""
    return np.concatenate([center - size / 2, center + size / 2], 1)


def class_scores(logits, output):
    """Scores [N, C] of an SSD head [N, C + B] without the background."""
    if output.get("apply_softmax"):
        logits = np.exp(logits - logits.max(1, keepdims=True))
        logits = logits / logits.sum(1, keepdims=True)
    background = output.get("background_class", -1)
    return np.delete(logits, background, 1) if background >= 0 else logits


def decode_ssd(tensors, output, input_size):
    boxes, scores = (t.reshape(t.shape[-2:]) for t in tensors)
    return boxes * np.float32([*input_size, *input_size]), class_scores(scores, output)


def decode_ssd_priors(tensors, output, input_size):
    """Offsets from prior boxes (Liu et al. 2016, section 2.2)."""
    offsets, scores = (t.reshape(t.shape[-2:]) for t in tensors)
    center, size = output.get("variances", (0.1, 0.2))
    listed = output["priors"]
    priors = np.float32(listed) if isinstance(listed, list) else generated_priors(listed, input_size)
    boxes = around(priors[:, :2] + offsets[:, :2] * center * priors[:, 2:],
                   priors[:, 2:] * np.exp(offsets[:, 2:] * size))
    return boxes * np.float32([*input_size, *input_size]), class_scores(scores, output)


def generated_priors(settings, input_size):
    """cx cy w h [N, 4], 0 to 1 of the input: per level and cell the squares, then wide and tall boxes."""
    width, height = input_size
    rows = []
    for level in settings["levels"]:
        stride, low, high = level["stride"], level["min_size"], level.get("max_size", 0)
        sides = [(low, low)] + ([(np.sqrt(low * high),) * 2] if high else [])
        for ratio in np.sqrt(level.get("aspect_ratios", [])):
            sides += [(low * ratio, low / ratio), (low / ratio, low * ratio)]
        for y in range(level.get("rows", -(-height // stride))):
            for x in range(level.get("columns", -(-width // stride))):
                cx, cy = (x + 0.5) * stride / width, (y + 0.5) * stride / height
                rows += [(cx, cy, w / width, h / height) for w, h in sides]
    priors = np.float32(rows)
    return np.clip(priors, 0, 1) if settings.get("clip") else priors


def decode_yolo_v7(tensors, output, input_size):
    rows = tensors[0].reshape(tensors[0].shape[-2:])
    return around(rows[:, :2], rows[:, 2:4]), rows[:, 4:5] * rows[:, 5:]


def decode_yolo_v8(tensors, output, input_size):
    rows = tensors[0].reshape(tensors[0].shape[-2:]).T
    return around(rows[:, :2], rows[:, 2:4]), rows[:, 4:]


def decode_yolo_anchors(tensors, output, input_size):
    """Raw heads of YOLOv5 and v7: centre (2 s - 0.5 + cell) * stride, size (2 s)^2 * anchor."""
    boxes, scores = [], []
    for tensor, level in zip(tensors, output["anchors"]):
        height, width = tensor.shape[-2:]
        planes = sigmoid(tensor.reshape(len(level["sizes"]), -1, height, width))
        cells = np.stack(np.meshgrid(np.arange(width), np.arange(height)), -1).reshape(-1, 2)
        for anchor, plane in zip(np.float32(level["sizes"]), planes):
            rows = plane.reshape(len(plane), -1).T
            boxes.append(around((2 * rows[:, :2] - 0.5 + cells) * level["stride"], (2 * rows[:, 2:4]) ** 2 * anchor))
            scores.append(rows[:, 4:5] * rows[:, 5:])
    return np.concatenate(boxes), np.concatenate(scores)


def decode_yolo_grid(tensors, output, input_size):
    """FastestDet's head: centre (tanh + cell) / cells, size by the sigmoid, score objectness^0.6 * class^0.4."""
    planes = tensors[0].reshape(tensors[0].shape[-3:])
    height, width = planes.shape[1:]
    rows = planes.reshape(len(planes), -1).T
    cells = np.stack(np.meshgrid(np.arange(width), np.arange(height)), -1).reshape(-1, 2)
    center = (np.tanh(rows[:, 1:3]) + cells) * np.float32([input_size[0] / width, input_size[1] / height])
    boxes = around(center, sigmoid(rows[:, 3:5]) * np.float32(input_size))
    return boxes, np.clip(rows[:, :1], 0, 1) ** 0.6 * np.clip(rows[:, 5:], 0, 1) ** 0.4


DECODERS = {"ssd": decode_ssd, "ssd_priors": decode_ssd_priors, "yolo_v7": decode_yolo_v7, "yolo_v8": decode_yolo_v8,
            "yolo_anchors": decode_yolo_anchors, "yolo_grid": decode_yolo_grid}
