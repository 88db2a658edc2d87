"""How well a network finds rendered objects, run as the robot would. Needs no torch."""
import json
import re
import time
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import cv2
import numpy as np

from . import CLASSES, HEIGHT, WIDTH
from .samples import letterbox, load, placement

IOUS = np.round(np.arange(0.5, 1.0, 0.05), 2)
RECALLS = np.linspace(0, 1, 101)
CLEAR_VISIBLE, CLEAR_WIDTH = 0.5, 16  # an object that has to be found: fraction seen, width in the image [px]


def input_size(path):
    """Width and height that the model.yaml beside a network names; without one, those of a new export."""
    notes = Path(path).with_name('model.yaml')
    named = re.search(r'width: (\d+), height: (\d+)', notes.read_text()) if notes.exists() else None
    return (int(named[1]), int(named[2])) if named else (WIDTH, HEIGHT)


class Detector:
    """Runs a shapes network on RGB images (H, W, 3) uint8."""

    def __init__(self, path, size=None):
        self.net, self.size = cv2.dnn.readNetFromONNX(str(path)), size or input_size(path)

    def __call__(self, image, score=0.35, nms_iou=0.5):
        """Detections (N, 6): class, score, x0, y0, x1, y1 in pixels of the image, best first."""
        height, width = image.shape[:2]
        self.net.setInput(cv2.dnn.blobFromImage(letterbox(image, self.size), 1 / 255.0), 'images')
        raw = self.net.forward('output')
        scale, left, top = placement(width, height, self.size)
        found = decode(raw[0], score, nms_iou)
        found[:, 2:] = (found[:, 2:] - (left, top, left, top)) / scale
        found[:, 2::2] = found[:, 2::2].clip(0, width)
        found[:, 3::2] = found[:, 3::2].clip(0, height)
        return found


class FolderModel:
    """The same of a whole model folder by OpenCV or OpenVINO, which runs INT8 networks too."""

    def __init__(self, folder, backend):
        from ..evaluation.model_folder import FolderDetector
        self.detector = FolderDetector(folder, backend)

    def __call__(self, image, score=0.35):
        """Detections (N, 6), as Detector's."""
        self.detector.score = score
        found = self.detector.detect(image)
        return np.column_stack([found.labels, found.scores, found.boxes]).reshape(-1, 6)


def open_model(path, backend='opencv'):
    """The network of an ONNX file by OpenCV, or that of a model folder by a back end."""
    return FolderModel(path, backend) if Path(path).is_dir() else Detector(path)


def decode(raw, score, nms_iou):
    """Detections (N, 6) in input pixels from the network's output (7, cells); suppression within each class."""
    kinds = raw[4:].argmax(0)
    scores = raw[4:].max(0)
    keep = np.flatnonzero(scores >= score)
    keep = keep[np.argsort(-scores[keep], kind='stable')]
    half = raw[2:4, keep] / 2
    boxes = np.concatenate([raw[:2, keep] - half, raw[:2, keep] + half]).T
    rows = np.column_stack([kinds[keep], scores[keep], boxes]).astype(np.float64).reshape(-1, 6)
    out = []
    while len(rows):
        out.append(rows[0])
        same = (rows[:, 0] == rows[0, 0]) & (overlap(rows[:1, 2:], rows[:, 2:])[0] > nms_iou)
        rows = rows[~same]
    return np.array(out).reshape(-1, 6)


def overlap(a, b):
    """IoU (len(a), len(b)) of boxes x0, y0, x1, y1."""
    low = np.maximum(a[:, None, :2], b[None, :, :2])
    high = np.minimum(a[:, None, 2:], b[None, :, 2:])
    common = np.prod(np.clip(high - low, 0, None), axis=2)
    area = [np.prod(boxes[:, 2:] - boxes[:, :2], axis=1) for boxes in (a, b)]
    return common / (area[0][:, None] + area[1][None] - common + 1e-9)


def match(found, truth, ignored, iou):
    """For detections of one class and image, best first: 1 true, 0 false, -1 not counted (on an ignored object)."""
    result = np.zeros(len(found), int)
    free = np.ones(len(truth), bool)
    shared = overlap(found[:, 2:], truth)
    for i in range(len(found)):
        candidates = np.where(free, shared[i], 0)
        if len(truth) and candidates.max() >= iou:
            free[candidates.argmax()] = False
            result[i] = 1
        elif len(ignored):
            low, high = np.maximum(found[i, 2:4], ignored[:, :2]), np.minimum(found[i, 4:], ignored[:, 2:])
            inside = np.prod(np.clip(high - low, 0, None), axis=1) / (np.prod(found[i, 4:] - found[i, 2:4]) + 1e-9)
            result[i] = -1 if inside.max() >= 0.5 else 0
    return result


def average_precision(scores, results, total):
    """COCO's 101-point interpolated precision from the scores and results (1, 0, -1) of all detections of a class."""
    if total == 0:
        return float('nan')
    counted = results >= 0
    hits = results[counted][np.argsort(-scores[counted], kind='stable')]
    true = np.cumsum(hits)
    recall, precision = true / total, true / np.arange(1, len(hits) + 1)
    precision = np.maximum.accumulate(precision[::-1])[::-1]
    places = np.searchsorted(recall, RECALLS, side='left')
    return float(np.mean([precision[p] if p < len(precision) else 0.0 for p in places]))


def images_of(folder, count=None):
    """Yields number, image and boxes (N, 5) of a rendered folder."""
    total = len(list((Path(folder) / 'Annotations').glob('*.xml')))
    if not total:
        raise SystemExit(f'{folder} holds no rendered images: make them with tools/extperfc-render')
    for number in range(min(total, count or total)):
        yield (number, *load(folder, number))


def clear_objects(folder, number):
    """Which objects of an image have to be found: mask over its boxes."""
    root = ElementTree.parse(Path(folder) / 'Annotations' / f'{number + 1:06d}.xml').getroot()

    def clear(item):
        width = int(item.findtext('bndbox/xmax')) - int(item.findtext('bndbox/xmin')) + 1
        return float(item.findtext('visible')) >= CLEAR_VISIBLE and width > CLEAR_WIDTH
    return np.array([clear(item) for item in root.iter('object')], bool)


def collect(detector, folder, count=None):
    """Runs the detector; per class: scores (N,), results (N, thresholds) and the number of objects."""
    scores, results, totals = [[], [], []], [[], [], []], np.zeros(3, int)
    for _, image, boxes in images_of(folder, count):
        found = detector(image, score=0.01)
        ignored = boxes[boxes[:, 0] < 0, 1:]
        for kind in range(3):
            mine, truth = found[found[:, 0] == kind], boxes[boxes[:, 0] == kind, 1:]
            totals[kind] += len(truth)
            scores[kind].extend(mine[:, 1])
            results[kind].extend(np.stack([match(mine, truth, ignored, iou) for iou in IOUS], 1))
    return [np.array(s) for s in scores], [np.array(r).reshape(-1, len(IOUS)) for r in results], totals


def found_and_false(detector, folder, score, count=None):
    """At one threshold: clear objects, how many of them were found (IoU 0.5, right class), false finds, images."""
    asked = found_count = false = images = 0
    for number, image, boxes in images_of(folder, count):
        found, clear = detector(image, score=score), clear_objects(folder, number) & (boxes[:, 0] >= 0)
        shared = overlap(found[:, 2:], boxes[:, 1:]) if len(found) and len(boxes) else np.zeros((len(found), len(boxes)))
        right = (shared >= 0.5) & (found[:, :1] == boxes[None, :, 0])
        excused = (shared >= 0.3) & (boxes[None, :, 0] < 0)
        asked += int(clear.sum())
        found_count += int((right.any(0) & clear).sum()) if len(found) else 0
        false += int((~(right | excused).any(1)).sum()) if len(found) else 0
        images += 1
    return {'objects': asked, 'found': found_count, 'false': false, 'images': images}


def best_threshold(scores, results, totals):
    """Score threshold with the best F1 over all classes at IoU 0.5, and precision, recall and F1 there."""
    score, hit = np.concatenate(scores), np.concatenate([r[:, 0] for r in results])
    best = (0.0, 0.5, 0.0, 0.0)
    for threshold in np.arange(0.1, 0.9, 0.01):
        taken = hit[(score >= threshold) & (hit >= 0)]
        precision, recall = taken.mean() if len(taken) else 0.0, taken.sum() / max(1, totals.sum())
        f1 = 2 * precision * recall / (precision + recall + 1e-9)
        best = max(best, (float(f1), float(round(threshold, 2)), float(precision), float(recall)))
    return {'f1': best[0], 'score': best[1], 'precision': best[2], 'recall': best[3]}


def summary(scores, results, totals):
    """Table of AP per class and in the mean at IoU 0.5 and over 0.5:0.95, with the best threshold."""
    table = {}
    for kind, name in enumerate(CLASSES):
        per_iou = [average_precision(scores[kind], results[kind][:, i], totals[kind]) for i in range(len(IOUS))]
        table[name] = {'objects': int(totals[kind]), 'ap50': per_iou[0], 'ap': float(np.mean(per_iou))}
    table['mean'] = {'objects': int(totals.sum()), 'ap50': float(np.mean([table[n]['ap50'] for n in CLASSES])),
                     'ap': float(np.mean([table[n]['ap'] for n in CLASSES]))}
    return table, best_threshold(scores, results, totals)


def print_table(table, threshold, title):
    """The table for people."""
    print(title)
    print(f'{"class":8} {"objects":>8} {"AP50":>7} {"AP50:95":>8}')
    for name, row in table.items():
        print(f'{name:8} {row["objects"]:8d} {row["ap50"]:7.3f} {row["ap"]:8.3f}')
    print('best F1 {f1:.3f} at score {score:.2f} (precision {precision:.3f}, recall {recall:.3f})'.format(**threshold))


def evaluate(model, folder, count=None, score=None, backend='opencv'):
    """AP table, best threshold, and what is found at `score` (default: the best threshold)."""
    detector = open_model(model, backend)
    table, threshold = summary(*collect(detector, folder, count))
    return table, threshold, found_and_false(detector, folder, score or threshold['score'], count)


def main(options):
    """Prints the figures of every folder and, when asked, writes them as JSON."""
    report = {}
    for folder in options.folders:
        begin = time.time()
        table, threshold, clear = evaluate(options.model, folder, options.count, options.score, options.backend)
        print_table(table, threshold, f'{folder}: {clear["images"]} images, {time.time() - begin:.0f} s')
        print(f'clear objects found: {clear["found"]} of {clear["objects"]} '
              f'({100 * clear["found"] / max(1, clear["objects"]):.1f} %), '
              f'{clear["false"] / max(1, clear["images"]):.3f} false per image\n')
        report[str(folder)] = {'table': table, 'threshold': threshold, 'clear': clear}
    if options.json:
        options.json.write_text(json.dumps(report, indent=1) + '\n')
