"""One entry for every format of labelled images."""

import dataclasses
import pathlib

import numpy as np

from . import coco, voc
from .dataset import DataError, Problem, refuse_errors

OUTSIDE_TOLERANCE_PX = 2.0  # labelling programs are off by a pixel at the border


def scan(path):
    """(Dataset, problems) of a Pascal VOC folder, a COCO file or a folder of COCO files.

    Boxes that cannot be used are left out and reported. DataError only where `path` is neither format.
    """
    path = pathlib.Path(path)
    if not path.exists():
        raise DataError(f"{path}: no such file or folder")
    if path.is_dir() and voc.is_voc_folder(path):
        dataset, problems = voc.scan_voc(path)
    elif coco.is_coco(path):
        dataset, problems = coco.scan_coco(path)
    else:
        raise DataError(
            f"{path}: neither a Pascal VOC folder (with Annotations and JPEGImages) nor a COCO file or folder"
            " (with annotations/*.json and images)")
    samples = []
    for sample in dataset.samples:
        usable, found = usable_boxes(sample)
        problems += found
        samples.append(usable)
    if not samples:
        problems.append(Problem("no_images", str(path), "has no image with labels"))
    return dataclasses.replace(dataset, samples=tuple(samples)), problems


def read_dataset(path):
    """The data set at `path`; DataError lists everything that is wrong with it, the first ones in words."""
    dataset, problems = scan(path)
    refuse_errors(path, problems)
    return dataset


def usable_boxes(sample):
    """(the sample with boxes cut to the image and bad ones left out, problems)."""
    problems, keep = [], []
    for number, (x0, y0, x1, y1) in enumerate(sample.boxes, 1):
        kind, text = box_fault((x0, y0, x1, y1), sample.size)
        if kind:
            is_error = kind != "box_over_edge"
            problems.append(Problem(kind, sample.name, f"box {number} {text}", is_error))
        keep.append(kind in ("", "box_over_edge"))
    boxes = sample.boxes[keep] if keep else sample.boxes
    if all(sample.size):
        boxes = np.clip(boxes, 0, np.array([*sample.size, *sample.size], np.float32))
    return dataclasses.replace(sample, boxes=boxes, labels=sample.labels[keep] if keep else sample.labels,
                               difficult=sample.difficult[keep] if keep else sample.difficult), problems


def box_fault(box, size):
    """(kind, text) of what is wrong with a box in an image of `size` px; ("", "") when it is right."""
    x0, y0, x1, y1 = (float(v) for v in box)
    shown = f"({x0:g}, {y0:g}) to ({x1:g}, {y1:g})"
    if not np.isfinite(box).all():
        return "bad_annotation", f"{shown} is not finite: draw it again"
    if x1 < x0 or y1 < y0:
        return "inverted_box", f"{shown} has its corners exchanged: draw it again"
    if x1 == x0 or y1 == y0:
        return "empty_box", f"{shown} is empty: draw it again, or delete it"
    if not all(size):
        return "", ""
    if x1 <= 0 or y1 <= 0 or x0 >= size[0] or y0 >= size[1]:
        return "box_outside", f"{shown} lies outside its image of {size[0]} x {size[1]} pixels: draw it again"
    if min(x0, y0) < -OUTSIDE_TOLERANCE_PX or max(x1 - size[0], y1 - size[1]) > OUTSIDE_TOLERANCE_PX:
        return "box_over_edge", (f"{shown} goes over the edge of its image of {size[0]} x {size[1]} pixels; it is cut"
                                 " there")
    return "", ""
