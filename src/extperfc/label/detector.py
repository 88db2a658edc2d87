"""Boxes that a network finds, by OpenCV DNN: the same steps as src/detect, for proposals in the labelling window."""

import cv2
import numpy as np

from extperfc.label import model_folder
from extperfc.label.boxes import from_floats
from extperfc.label.model_folder import ModelError

PADDING = 114  # grey of letterbox bars
MAX_CANDIDATES = 1000  # of one class; suppression takes quadratic time


def _placed(spec, width, height):
    """(x, y, w, h) of the image within the network's input [px]."""
    if not spec.is_letterbox:
        return 0, 0, spec.width, spec.height
    scale = min(spec.width / width, spec.height / height)
    w = min(max(int(width * scale + 0.5), 1), spec.width)
    h = min(max(int(height * scale + 0.5), 1), spec.height)
    return (spec.width - w) // 2, (spec.height - h) // 2, w, h


def preprocess(spec, image):
    """A BGR image (H, W, 3) of 8 bits as the network's input (1, 3, height, width), and where the image is in it."""
    x, y, w, h = area = _placed(spec, image.shape[1], image.shape[0])
    small = cv2.resize(image, (w, h), interpolation=cv2.INTER_AREA if spec.is_area else cv2.INTER_LINEAR)
    canvas = np.full((spec.height, spec.width, 3), PADDING, np.float32)
    canvas[y:y + h, x:x + w] = small if spec.is_bgr else small[..., ::-1]
    return np.ascontiguousarray(((canvas - spec.mean) * spec.scale).transpose(2, 0, 1)[None], np.float32), area


def _corners(centers):
    """Corners of rows cx, cy, w, h."""
    half = centers[:, 2:] / 2
    return np.concatenate([centers[:, :2] - half, centers[:, :2] + half], 1)


def _ssd_boxes(spec, offsets):
    if spec.layout == "ssd":
        return offsets * np.array([spec.width, spec.height] * 2, np.float32)
    if len(offsets) != len(spec.priors):
        raise ModelError(
            f"{spec.name}: the network has {len(offsets)} candidates, but model.yaml describes {len(spec.priors)} "
            "priors: correct output.priors")
    center, size = spec.variances
    boxes = np.concatenate([spec.priors[:, :2] + offsets[:, :2] * center * spec.priors[:, 2:],
                            spec.priors[:, 2:] * np.exp(offsets[:, 2:] * size)], 1)
    return _corners(boxes * np.array([spec.width, spec.height] * 2, np.float32))


def _softmax(logits):
    powers = np.exp(logits - logits.max(1, keepdims=True))
    return powers / powers.sum(1, keepdims=True)


def _best(scores):
    """Each row's best class only; the others score 0."""
    kept = np.zeros_like(scores)
    rows = np.arange(len(scores))
    best = scores.argmax(1)
    kept[rows, best] = scores[rows, best]
    return kept


def _check(spec, tensors):
    """Tensors without the batch dimension, of the shapes that the layout asks for."""
    tensors = [tensor[0] if tensor.ndim == 3 and tensor.shape[0] == 1 else tensor for tensor in tensors]
    classes = len(spec.classes)
    columns = classes + (spec.background_class >= 0)
    ssd = [(None, 4), (None, columns)]
    wanted = {"ssd": ssd, "ssd_priors": ssd, "yolo_v7": [(None, 5 + classes)],
              "yolo_v8": [(4 + classes, None)]}[spec.layout]
    for tensor, shape in zip(tensors, wanted):
        if tensor.ndim != 2 or any(want not in (None, have) for want, have in zip(shape, tensor.shape)):
            expected = ", ".join("N" if want is None else str(want) for want in shape)
            raise ModelError(
                f"{spec.name}: an output has shape {list(tensor.shape)}, but layout {spec.layout} with {classes} "
                f"classes "
                f"needs [{expected}]: correct output.layout, output.names or classes in model.yaml")
    return tensors


def decode(spec, tensors):
    """Corners (N, 4) in pixels of the input and scores (N, classes), from the tensors in the order of models/README.md.
    Raises ModelError when their shapes do not fit the layout."""
    tensors = _check(spec, tensors)
    if spec.layout in ("ssd", "ssd_priors"):
        scores = _softmax(tensors[1]) if spec.apply_softmax else tensors[1]
        if spec.background_class >= 0:
            scores = np.delete(scores, spec.background_class, 1)
        return _ssd_boxes(spec, tensors[0]), scores
    rows = tensors[0].T if spec.layout == "yolo_v8" else tensors[0]
    scores = rows[:, 4:] if spec.layout == "yolo_v8" else rows[:, 4:5] * rows[:, 5:]
    return _corners(rows[:, :4]), _best(scores)


def suppress(spec, corners, scores, min_score):
    """[(class index, score, corners)], best first, of what remains of overlapping boxes of one class."""
    kept = []
    for index in range(scores.shape[1]):
        candidates = np.flatnonzero(scores[:, index] >= min_score)
        boxes = [(float(x0), float(y0), float(x1 - x0), float(y1 - y0)) for x0, y0, x1, y1 in corners[candidates]]
        values = scores[candidates, index].astype(float).tolist()
        survivors = cv2.dnn.NMSBoxes(boxes, values, 0.0, spec.nms_iou, 1.0, MAX_CANDIDATES) if boxes else ()
        kept += [(index, values[i], corners[candidates[i]]) for i in np.ravel(survivors).astype(int)]
    kept.sort(key=lambda one: -one[1])
    return kept[:spec.max_detections]


class Detector:
    """A network of a model folder. One thread at a time may use it."""

    def __init__(self, folder):
        """Raises ModelError."""
        self.spec = model_folder.load(folder)
        try:
            self._net = cv2.dnn.readNetFromONNX(str(self.spec.file))
        except cv2.error as error:
            raise ModelError(
                f"OpenCV cannot load {self.spec.file}: {' '.join(str(error).split())[:200]}; models need opset 10 "
                "(models/README.md)") from None
        self._net.setPreferableBackend(cv2.dnn.DNN_BACKEND_OPENCV)
        self._outputs = list(self.spec.output_names or self._net.getUnconnectedOutLayersNames()[:1])

    def detect(self, image, min_score=None):
        """[(class name, score, (x0, y0, x1, y1))] of a BGR image, best first; real-valued pixels within the image.
        Raises ModelError."""
        blob, (x, y, w, h) = preprocess(self.spec, image)
        try:
            self._net.setInput(blob)
            tensors = self._net.forward(self._outputs)
        except cv2.error as error:
            raise ModelError(
                f"{self.spec.name}: OpenCV cannot run the network: {' '.join(str(error).split())[:200]}; check "
                "output.names with tools/extperfc-model check") from None
        corners, scores = decode(self.spec, tensors)
        found = suppress(self.spec, corners, scores, self.spec.score if min_score is None else min_score)
        size = np.array([image.shape[1], image.shape[0]] * 2)
        corners = [np.clip((box - (x, y, x, y)) * size / (w, h, w, h), 0, size) for _, _, box in found]
        return [(self.spec.classes[index], score, tuple(box)) for (index, score, _), box in zip(found, corners)]

    def propose(self, image, min_score=None):
        """[(boxes.Box, score)] of found objects in whole pixels within the image, best first."""
        height, width = image.shape[:2]
        found = ((from_floats(name, corners, width, height), score)
                 for name, score, corners in self.detect(image, min_score))
        return [(box, score) for box, score in found if box]
