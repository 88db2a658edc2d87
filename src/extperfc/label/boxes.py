"""Labelled boxes: immutable values in whole pixels."""

import dataclasses
import math

MIN_SIDE_PX = 2  # a smaller box is a slip of the mouse


@dataclasses.dataclass(frozen=True)
class Box:
    """A labelled object.

    x0, y0, x1, y1: pixels from the image's left upper corner; x1 and y1 are the first ones outside, so the width is
    x1 - x0.
    truncated, difficult, occluded: the flags of Pascal VOC. pose: its view point, "Unspecified" by default.
    visible: fraction of the object that is seen, in (0, 1], or None where it is not known.
    extra: elements of the annotation file that this program does not edit, as XML text; they are written back.
    """

    name: str
    x0: int
    y0: int
    x1: int
    y1: int
    truncated: bool = False
    difficult: bool = False
    occluded: bool = False
    pose: str = "Unspecified"
    visible: float | None = None
    extra: tuple[str, ...] = ()

    @property
    def width(self):
        return self.x1 - self.x0

    @property
    def height(self):
        return self.y1 - self.y0

    @property
    def area(self):
        return self.width * self.height

    @property
    def corners(self):
        return self.x0, self.y0, self.x1, self.y1

    def with_corners(self, x0, y0, x1, y1):
        """The same object with other borders, in any order of the corners."""
        return dataclasses.replace(self, x0=min(x0, x1), y0=min(y0, y1), x1=max(x0, x1), y1=max(y0, y1))

    def replaced(self, **changes):
        """The same object with other attributes."""
        return dataclasses.replace(self, **changes)


def clipped(box, width, height):
    """The part of a box within an image; None when less than MIN_SIDE_PX remains along either axis."""
    x0, y0 = max(0, min(box.x0, width)), max(0, min(box.y0, height))
    x1, y1 = max(0, min(box.x1, width)), max(0, min(box.y1, height))
    if x1 - x0 < MIN_SIDE_PX or y1 - y0 < MIN_SIDE_PX:
        return None
    return box if (x0, y0, x1, y1) == box.corners else box.replaced(x0=x0, y0=y0, x1=x1, y1=y1)


def moved(box, dx, dy, width, height):
    """A box shifted by (dx, dy) px, as far as it stays within the image with its whole size."""
    dx = max(-box.x0, min(dx, width - box.x1))
    dy = max(-box.y0, min(dy, height - box.y1))
    return box.replaced(x0=box.x0 + dx, y0=box.y0 + dy, x1=box.x1 + dx, y1=box.y1 + dy)


def resized(box, edges, dx, dy, width, height):
    """A box whose edges (a set of "left", "top", "right", "bottom") are shifted by (dx, dy) px, within the image and
    without turning it inside out."""
    x0, y0, x1, y1 = box.corners
    if "left" in edges:
        x0 = max(0, min(x0 + dx, x1 - MIN_SIDE_PX))
    if "right" in edges:
        x1 = min(width, max(x1 + dx, x0 + MIN_SIDE_PX))
    if "top" in edges:
        y0 = max(0, min(y0 + dy, y1 - MIN_SIDE_PX))
    if "bottom" in edges:
        y1 = min(height, max(y1 + dy, y0 + MIN_SIDE_PX))
    return box.replaced(x0=x0, y0=y0, x1=x1, y1=y1)


def from_floats(name, corners, width, height):
    """The box of real-valued corners (px), borders rounded to the nearest pixel; None when hardly any of it lies in
    the image."""
    if not all(math.isfinite(value) for value in corners):
        return None
    x0, y0, x1, y1 = (math.floor(value + 0.5) for value in corners)
    return clipped(Box(name, x0, y0, x1, y1), width, height)


def iou(a, b):
    """Intersection over union of two boxes, 0 to 1."""
    across = min(a.x1, b.x1) - max(a.x0, b.x0)
    down = min(a.y1, b.y1) - max(a.y0, b.y0)
    if across <= 0 or down <= 0:
        return 0.0
    return across * down / (a.area + b.area - across * down)


def without_known(proposed, present, max_iou=0.5):
    """Proposed boxes that overlap none of those present, or of those before them in the list, by more than max_iou."""
    kept = []
    for box in proposed:
        if all(iou(box, other) <= max_iou for other in (*present, *kept)):
            kept.append(box)
    return kept
