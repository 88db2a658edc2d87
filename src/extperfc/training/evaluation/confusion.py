"""Which class is taken for which, what is missed, what is invented; and the worst of it in images."""

import dataclasses
import typing

import cv2
import numpy as np

from .average_precision import areas, intersections, iou_matrix

MIN_IOU = 0.5
COLORS = {"truth": (0, 200, 0), "detection": (230, 40, 40)}  # RGB
CELL_PX = 160
CAPTION_PX = 30


@dataclasses.dataclass(frozen=True)
class Mistake:
    """One error of a detector. severity: higher is worse, comparable within a kind only."""

    kind: str  # "invented", "missed", "confused"
    image: int
    box: typing.Tuple[float, ...]  # of the detection, of the object when it was missed; px
    text: str
    severity: float


def pairs_of(found, truth, keep):
    """(detection, object, IoU) of one image: the same class first, then any, the better detection first."""
    overlap = iou_matrix(found.boxes[keep].reshape(-1, 4), truth.boxes.reshape(-1, 4))
    pairs, used_found, used_truth = [], set(), set()
    for same_class in (True, False):
        for row in np.argsort(-found.scores[keep], kind="stable"):
            agree = truth.labels == found.labels[keep][row]
            free = np.array([j not in used_truth for j in range(len(truth.labels))], bool)
            candidates = np.where(free & (agree if same_class else ~agree), overlap[row], 0.0)
            if row in used_found or not len(candidates) or candidates.max() < MIN_IOU:
                continue
            best = int(candidates.argmax())
            pairs.append((int(keep[row]), best, float(candidates[best])))
            used_found.add(row)
            used_truth.add(best)
    return pairs


def confusion(detections, truths, class_names, score):
    """(table int [C + 1, C + 1], mistakes, the worst first) of detections with at least `score`, at IoU 0.5.

    Row: the object's class, the last one for no object. Column: the detected class, the last one for missed. Difficult
    objects, and detections on them, do not count.
    """
    count = len(class_names)
    table, mistakes = np.zeros((count + 1, count + 1), int), []
    for image, (found, truth) in enumerate(zip(detections, truths)):
        keep = np.flatnonzero(found.scores >= score)
        pairs = pairs_of(found, truth, keep)
        for i, j, _ in pairs:
            if truth.difficult[j]:
                continue
            table[truth.labels[j], found.labels[i]] += 1
            if truth.labels[j] != found.labels[i]:
                text = f"{class_names[truth.labels[j]]} as {class_names[found.labels[i]]} {found.scores[i]:.2f}"
                mistakes.append(Mistake("confused", image, tuple(found.boxes[i]), text, float(found.scores[i])))
        for i in set(keep) - {i for i, _, _ in pairs}:
            if not on_difficult(found.boxes[i], truth):
                table[count, found.labels[i]] += 1
                text = f"invented {class_names[found.labels[i]]} {found.scores[i]:.2f}"
                mistakes.append(Mistake("invented", image, tuple(found.boxes[i]), text, float(found.scores[i])))
        for j in set(np.flatnonzero(~truth.difficult)) - {j for _, j, _ in pairs}:
            table[truth.labels[j], count] += 1
            size = float(areas(truth.boxes[j:j + 1])[0])
            mistakes.append(
                Mistake("missed", image, tuple(truth.boxes[j]), f"missed {class_names[truth.labels[j]]}", size))
    return table, sorted(mistakes, key=lambda m: (-m.severity, m.image))


def on_difficult(box, truth):
    """Whether at least half of a detection lies on a difficult object."""
    hard = truth.boxes[truth.difficult].reshape(-1, 4)
    box = np.asarray(box, np.float64)[None]
    return bool(len(hard)) and bool((intersections(box, hard) / np.maximum(areas(box), 1e-9)).max() >= 0.5)


def worst(mistakes, count):
    """Up to `count` mistakes, the kinds in equal numbers where there are enough."""
    kinds = [[m for m in mistakes if m.kind == kind] for kind in ("confused", "invented", "missed")]
    chosen = []
    while len(chosen) < count and any(kinds):
        chosen += [kind.pop(0) for kind in kinds if kind]
    return chosen[:count]


def contact_sheet(mistakes, read_image, truths, columns=5):
    """uint8 [H, W, 3] RGB: a cell per mistake with its surroundings; the detection red, labelled objects green."""
    cells = [cell(m, read_image(m.image), truths[m.image]) for m in mistakes]
    cells += [np.full((CELL_PX + CAPTION_PX, CELL_PX, 3), 255, np.uint8)] * (-len(cells) % columns)
    rows = [np.hstack(cells[i:i + columns]) for i in range(0, len(cells), columns)]
    return np.vstack(rows) if rows else np.full((CAPTION_PX, CELL_PX, 3), 255, np.uint8)


def cell(mistake, image, truth):
    """One mistake: a square around its box, twice as large, with a caption."""
    x0, y0, x1, y1 = mistake.box
    side = max(32.0, 2.0 * max(x1 - x0, y1 - y0))
    left, top = (x0 + x1 - side) / 2, (y0 + y1 - side) / 2
    scale = CELL_PX / side
    warp = np.array([[scale, 0, -left * scale], [0, scale, -top * scale]])
    view = cv2.warpAffine(image, warp, (CELL_PX, CELL_PX), flags=cv2.INTER_LINEAR, borderValue=(114, 114, 114))
    drawn = [(box, COLORS["truth"]) for box in truth.boxes]
    if mistake.kind != "missed":
        drawn.append((mistake.box, COLORS["detection"]))
    for box, color in drawn:
        corners = ((np.asarray(box).reshape(2, 2) - (left, top)) * scale).round().astype(int)
        cv2.rectangle(view, tuple(map(int, corners[0])), tuple(map(int, corners[1])), color, 2)
    out = np.full((CELL_PX + CAPTION_PX, CELL_PX, 3), 255, np.uint8)
    out[2:CELL_PX - 2, 2:-2] = view[2:-2, 2:-2]
    cv2.putText(out, mistake.text, (4, CELL_PX + 11), cv2.FONT_HERSHEY_SIMPLEX, 0.37, (0, 0, 0), 1, cv2.LINE_AA)
    cv2.putText(out, f"image {mistake.image + 1}", (4, CELL_PX + 25), cv2.FONT_HERSHEY_SIMPLEX, 0.33, (110, 110, 110),
                1, cv2.LINE_AA)
    return out
