"""Random views of a labelled image, the same for the same (seed, epoch, index).

OpenCV does the work, three times as fast as torchvision's transforms of PIL images, which a test compares it with;
albumentations has been archived since 2025, and its successor is under the AGPL. The random numbers are drawn here, so
that no state of a process or a worker decides about an image.
"""

import dataclasses

import cv2
import numpy as np

from ..settings import number
from .placement import PADDING

MIN_SIDE_PX = 3.0


@dataclasses.dataclass(frozen=True)
class Augmentation:
    """How much images vary."""

    flip: float = number(0.5, 0, 1, "probability of a mirror image")
    zoom_min: float = number(0.5, 0.1, 1, "smallest window over the image's side: objects grow to the inverse of it")
    zoom_max: float = number(1.3, 1, 4, "largest window over the image's side: grey around the image")
    stretch: float = number(0.15, 0, 1, "largest change of the aspect ratio, as a fraction")
    brightness: float = number(0.3, 0, 0.9, "largest change, as a fraction")
    contrast: float = number(0.3, 0, 0.9, "largest change, as a fraction")
    saturation: float = number(0.4, 0, 1, "largest change, as a fraction")
    hue: float = number(0.03, 0, 0.5, "largest change, in revolutions of the colour circle")
    blur: float = number(0.15, 0, 1, "probability of a Gaussian blur")
    gray: float = number(0.03, 0, 1, "probability of a grey image")
    min_visible: float = number(0.4, 0, 1,
                                "objects of which a smaller fraction is left are neither learned nor punished")


NONE = Augmentation(0, 1, 1, 0, 0, 0, 0, 0, 0, 0)


def rng_of(seed, epoch, index):
    """Random numbers of one image in one epoch."""
    return np.random.default_rng([seed, epoch, index])


def random_view(image, boxes, options, rng):
    """A window of an image, mirrored or not: (uint8 [h, w, 3], boxes float32 [M, 4] cut to it, visible fraction [M]).

    image: uint8 [H, W, 3] RGB; boxes: float32 [M, 4], x0 y0 x1 y1 px. A box that has left the view keeps no area.
    """
    left, top, width, height = draw_window(image.shape[1::-1], options, rng)
    view = cut(image, left, top, width, height)
    moved = np.asarray(boxes, np.float32).reshape(-1, 4) - np.array([left, top, left, top], np.float32)
    if rng.random() < options.flip:
        view = cv2.flip(view, 1)
        moved = np.stack([width - moved[:, 2], moved[:, 1], width - moved[:, 0], moved[:, 3]], 1)
    return view, *cut_boxes(moved, width, height)


def draw_window(size, options, rng):
    """x, y, width, height in whole pixels of the window that becomes the view; it may reach beyond the image."""
    zoom = rng.uniform(options.zoom_min, options.zoom_max)
    aspect = np.sqrt(1 + options.stretch) ** rng.uniform(-1, 1)
    width, height = (max(8, int(round(side * zoom * factor))) for side, factor in zip(size, (aspect, 1 / aspect)))
    left, top = (int(round(rng.uniform(min(0, side - wide), max(0, side - wide))))
                 for side, wide in zip(size, (width, height)))
    return left, top, width, height


def cut(image, left, top, width, height):
    """The window of an image, grey beyond its edges."""
    rows, columns = image.shape[:2]
    above, before = max(0, -top), max(0, -left)
    below, behind = max(0, top + height - rows), max(0, left + width - columns)
    if above or before or below or behind:
        image = cv2.copyMakeBorder(image, above, below, before, behind, cv2.BORDER_CONSTANT, value=(PADDING,) * 3)
    return image[top + above:top + above + height, left + before:left + before + width]


def cut_boxes(boxes, width, height):
    """(boxes cut to a view of width x height px, the fraction of each that is left)."""
    limits = np.array([width, height, width, height], np.float32)
    inside = np.clip(boxes, 0, limits)
    area = np.prod(boxes[:, 2:] - boxes[:, :2], axis=1)
    left = np.prod(np.maximum(inside[:, 2:] - inside[:, :2], 0), axis=1)
    return inside.astype(np.float32), left / np.maximum(area, 1e-6)


def random_colors(image, options, rng):
    """Other brightness, contrast, saturation and hue in random order, then grey, then blur; image uint8 [H, W, 3] RGB."""
    changes = {
        name: 1 + rng.uniform(-1, 1) * getattr(options, name)
        for name in ("brightness", "contrast", "saturation")
    }
    changes["hue"] = rng.uniform(-1, 1) * options.hue
    for name in rng.permutation([*changes]):
        if changes[name] != (name != "hue"):  # 0 leaves the hue as it is, 1 the others
            image = CHANGES[name](image, changes[name])
    if rng.random() < options.gray:
        image = spread(gray_of(image))
    if rng.random() < options.blur:
        image = cv2.GaussianBlur(image, (5, 5), float(rng.uniform(0.3, 1.5)))
    return image


def gray_of(image):
    """Luminance uint8 [H, W]."""
    return cv2.cvtColor(image, cv2.COLOR_RGB2GRAY)


def spread(gray):
    """A grey image with three channels."""
    return cv2.merge([gray] * 3)


def by_table(image, values):
    """Every channel through a table of 256 values, which are rounded and limited."""
    return cv2.LUT(np.ascontiguousarray(image), np.clip(np.rint(values), 0, 255).astype(np.uint8))


def change_brightness(image, factor):
    """0: black, 1: as it is."""
    return by_table(image, np.arange(256) * factor)


def change_contrast(image, factor):
    """0: grey of the mean luminance, 1: as it is."""
    mean = round(cv2.mean(gray_of(image))[0])
    return by_table(image, mean + factor * (np.arange(256) - mean))


def change_saturation(image, factor):
    """0: grey, 1: as it is."""
    return cv2.addWeighted(image, factor, spread(gray_of(image)), 1 - factor, 0)


def change_hue(image, revolutions):
    """Turns the colour circle, -0.5 to 0.5 revolutions."""
    circle = cv2.cvtColor(image, cv2.COLOR_RGB2HSV_FULL)
    circle[..., 0] += np.uint8(round(revolutions * 256) % 256)  # wraps round, as the circle does
    return cv2.cvtColor(circle, cv2.COLOR_HSV2RGB_FULL)


CHANGES = {"brightness": change_brightness, "contrast": change_contrast, "saturation": change_saturation, "hue": change_hue}


def target_of(boxes, labels, difficult, visible, min_visible):
    """Target of a view as NumPy arrays: boxes [K, 4], labels [K], ignore [K]; what has left the view is dropped."""
    sides = np.minimum(boxes[:, 2] - boxes[:, 0], boxes[:, 3] - boxes[:, 1])
    keep = (visible > 0) & (sides > 0)
    ignore = np.asarray(difficult, bool) | (visible < min_visible) | (sides < MIN_SIDE_PX)
    return {
        "boxes": boxes[keep].astype(np.float32),
        "labels": np.asarray(labels, np.int64)[keep],
        "ignore": ignore[keep]
    }
