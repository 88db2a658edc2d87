"""Average precision of the shipped ONNX file, run by OpenCV's DNN module as the robot would run it. Needs no torch."""
import json
import time

import cv2
import numpy as np

from . import dataset, scenes, sequence

IOUS = np.round(np.arange(0.5, 1.0, 0.05), 2)
RECALLS = np.linspace(0, 1, 101)
VIEWS = (0.05, 0.35, 0.65, 0.95)  # places on the camera's arc


class Detector:
    """Runs a shapes.onnx on RGB images (H, W, 3) uint8."""

    def __init__(self, path):
        self.net = cv2.dnn.readNetFromONNX(str(path))

    def __call__(self, image, score=0.35, nms_iou=0.5):
        """Detections (N, 6): class, score, x0, y0, x1, y1 in pixels of the image, best first."""
        height, width = image.shape[:2]
        blob = cv2.dnn.blobFromImage(dataset.letterbox(image), 1 / 255.0)
        self.net.setInput(blob, 'images')
        raw = self.net.forward('output')
        scale, left, top = dataset.placement(width, height)
        found = decode(raw[0], score, nms_iou)
        found[:, 2:] = (found[:, 2:] - (left, top, left, top)) / scale
        found[:, 2::2] = found[:, 2::2].clip(0, width)
        found[:, 3::2] = found[:, 3::2].clip(0, height)
        return found


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


def rows(sample):
    """Boxes (N, 5) of an image: class (-1: ignored), x0, y0, x1, y1."""
    labelled = [[label] + box for label, box in zip(sample.labels, sample.boxes)]
    return np.array(labelled + [[-1] + box for box in sample.ignored], np.float32).reshape(-1, 5)


def rooms(count):
    """Yields images and boxes of ordinary views: the scenes of tools/generate_images, none of them trained on."""
    for seed in range(dataset.ROOMS[0], dataset.ROOMS[0] + (count + len(VIEWS) - 1) // len(VIEWS)):
        scene = sequence.Scene(seed)
        for fraction in VIEWS:
            sample = scene.render(fraction)[0]
            yield sample.image, rows(sample)


def images(options):
    """Yields images and boxes (N, 5) of a split, from the cache or rendered from their seeds."""
    if options.split == 'rooms':
        yield from rooms(options.count or dataset.ROOMS[1])
        return
    first, count = dataset.SPLITS[options.split]
    count = options.count or count
    if not options.no_cache:
        dataset.generate(options.cache, options.split, count, report=lambda text: None)
        for entry in dataset.index(options.cache, options.split)[:count]:
            yield dataset.load(entry)
        return
    for seed in range(first, first + count):
        sample = scenes.make_image(seed, dataset.image_size(options.split))
        yield sample.image, rows(sample)


def collect(detector, source, use_ignored=True):
    """Runs the detector; per class: scores (N,), results (N, thresholds) and the number of objects."""
    scores, results, totals = [[], [], []], [[], [], []], np.zeros(3, int)
    for image, boxes in source:
        found = detector(image, score=0.01)
        ignored = boxes[boxes[:, 0] < 0, 1:] if use_ignored else np.zeros((0, 4))
        for kind in range(3):
            mine, truth = found[found[:, 0] == kind], boxes[boxes[:, 0] == kind, 1:]
            totals[kind] += len(truth)
            scores[kind].extend(mine[:, 1])
            results[kind].extend(np.stack([match(mine, truth, ignored, iou) for iou in IOUS], 1))
    return [np.array(s) for s in scores], [np.array(r).reshape(-1, len(IOUS)) for r in results], totals


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
    for kind, name in enumerate(scenes.CLASSES):
        per_iou = [average_precision(scores[kind], results[kind][:, i], totals[kind]) for i in range(len(IOUS))]
        table[name] = {'objects': int(totals[kind]), 'ap50': per_iou[0], 'ap': float(np.mean(per_iou))}
    table['mean'] = {'objects': int(totals.sum()), 'ap50': float(np.mean([table[n]['ap50'] for n in scenes.CLASSES])),
                     'ap': float(np.mean([table[n]['ap'] for n in scenes.CLASSES]))}
    return table, best_threshold(scores, results, totals)


def run(model, options):
    """Evaluates a model file; returns the table, the threshold and the number of images."""
    count = 0

    def counted():
        nonlocal count
        for item in images(options):
            count += 1
            yield item
    table, threshold = summary(*collect(Detector(model), counted()))
    return table, threshold, count


def main(options):
    """Prints the table and, when asked, writes it as JSON."""
    begin = time.time()
    table, threshold, count = run(options.model, options)
    print(f'{options.split}: {count} images, generator version {scenes.VERSION}, {time.time() - begin:.0f} s')
    print(f'{"class":8} {"objects":>8} {"AP50":>7} {"AP50:95":>8}')
    for name, row in table.items():
        print(f'{name:8} {row["objects"]:8d} {row["ap50"]:7.3f} {row["ap"]:8.3f}')
    print('best F1 {f1:.3f} at score {score:.2f} (precision {precision:.3f}, recall {recall:.3f})'.format(**threshold))
    if options.json:
        options.json.write_text(json.dumps({'split': options.split, 'images': count, 'table': table,
                                            'threshold': threshold}, indent=1) + '\n')
