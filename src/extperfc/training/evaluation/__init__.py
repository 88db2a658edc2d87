"""How good a detector is: average precision over IoU, COCO's figures, confusions, mistakes in images."""

from .average_precision import IOU_THRESHOLDS, Detections, Evaluation, Truth, evaluate

__all__ = ["IOU_THRESHOLDS", "Detections", "Evaluation", "Truth", "evaluate"]
