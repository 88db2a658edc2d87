"""COCO's figures by pycocotools, the standard implementation."""

import contextlib
import io

import numpy as np

NAMES = ("AP", "AP50", "AP75", "AP_small", "AP_medium", "AP_large", "AR_1", "AR_10", "AR_100", "AR_small", "AR_medium",
         "AR_large")
HINT = "pycocotools is not installed (tools/setup --training fetches it)"


def is_available():
    """Whether pycocotools can be imported."""
    try:
        import pycocotools.cocoeval  # noqa: F401
    except ImportError:
        return False
    return True


def coco_evaluation(detections, truths, class_names):
    """pycocotools' COCOeval after accumulate(): difficult objects are crowd regions."""
    from pycocotools.coco import COCO
    from pycocotools.cocoeval import COCOeval
    with contextlib.redirect_stdout(io.StringIO()):
        truth = COCO()
        truth.dataset = truth_dictionary(truths, class_names)
        truth.createIndex()
        rows = detection_rows(detections)
        found = truth.loadRes(rows) if len(rows) else COCO()
        if not len(rows):
            found.dataset = dict(truth.dataset, annotations=[])
            found.createIndex()
        run = COCOeval(truth, found, "bbox")
        run.evaluate()
        run.accumulate()
        run.summarize()
    return run


def coco_metrics(detections, truths, class_names):
    """{name: value} of COCO's twelve figures and AP per class (`AP/cone`); None where COCO has no figure."""
    run = coco_evaluation(detections, truths, class_names)
    figures = {name: known(value) for name, value in zip(NAMES, run.stats)}
    precision = run.eval["precision"][:, :, :, 0, 2]  # [T, R, K], all areas, 100 detections
    for k, name in enumerate(class_names):
        values = precision[:, :, k]
        figures[f"AP/{name}"] = known(values[values > -1].mean() if (values > -1).any() else -1)
    return figures


def known(value):
    """COCO writes -1 where there is nothing to measure."""
    return None if value < 0 else float(value)


def truth_dictionary(truths, class_names):
    notes = []
    for image, truth in enumerate(truths, 1):
        for box, label, difficult in zip(truth.boxes, truth.labels, truth.difficult):
            x0, y0, x1, y1 = (float(v) for v in box)
            notes.append({
                "id": len(notes) + 1,
                "image_id": image,
                "category_id": int(label) + 1,
                "iscrowd": int(difficult),
                "bbox": [x0, y0, x1 - x0, y1 - y0],
                "area": (x1 - x0) * (y1 - y0)
            })
    return {"images": [{"id": i} for i in range(1, len(truths) + 1)], "annotations": notes, "info": {},
            "categories": [{"id": i, "name": name} for i, name in enumerate(class_names, 1)]}


def detection_rows(detections):
    """[N, 7]: image, x, y, width, height, score, category."""
    rows = []
    for image, found in enumerate(detections, 1):
        boxes = np.asarray(found.boxes, np.float64).reshape(-1, 4)
        rows.append(
            np.column_stack([
                np.full(len(boxes), image), boxes[:, :2], boxes[:, 2:] - boxes[:, :2], found.scores,
                np.asarray(found.labels) + 1
            ]).reshape(-1, 7))
    return np.concatenate(rows) if rows else np.zeros((0, 7))
