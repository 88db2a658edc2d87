"""Which images are so alike that a second one would train nothing and leak between the splits of a data set.

The measure: an image is reduced to 32 x 24 cells of mean color, scaled to a median of 128, so that exposure does not
count. A cell has changed by as much as it lies outside the range of the 3 x 3 cells around its place in the other
image, in the color channel with the largest difference, so that movements by less than a cell (3 % of the width)
count little. The change of two images is the mean of the 4 cells that changed by the largest amounts, in grey
levels, seen from the image where it is larger.

A mean over the whole image, or a perceptual hash of 64 bits, would miss a small object that was put somewhere else;
a plain difference would take each tremor of a hand for a new image. docs/labelling.md has the figures behind the
default.
"""

import cv2
import numpy as np

CELLS = (32, 24)  # columns, rows
COUNTED = 4  # cells: those of an object of 40 px of 640
MEDIAN = 128.0  # grey level that signatures are scaled to
MAX_GAIN = 3.0  # of that scaling, in both directions
DEFAULT_CHANGE = 15.0  # grey levels


def signature(image):
    """A BGR image of any size as its cells and their surroundings: (3, 768, 3) float32 of value, lowest and highest,
    by channel."""
    cells = cv2.resize(np.float32(image), CELLS, interpolation=cv2.INTER_AREA)
    cells *= np.clip(MEDIAN / max(float(np.median(cells)), 1.0), 1 / MAX_GAIN, MAX_GAIN)
    around = np.ones((3, 3), np.uint8)
    return np.stack([cells, cv2.erode(cells, around), cv2.dilate(cells, around)]).reshape(3, -1, 3)


def _outside(value, low, high):
    """Mean of the cells that lie the farthest outside of a range, for each row."""
    distance = np.maximum(np.maximum(low - value, value - high), 0).max(-1)
    return np.partition(distance, -COUNTED, axis=-1)[..., -COUNTED:].mean(-1)


def change(kept, other):
    """How much images differ [grey levels]. kept: one signature, or an array (N, 3, 768, 3), then (N,) values."""
    return np.maximum(_outside(other[0], kept[..., 1, :, :], kept[..., 2, :, :]),
                      _outside(kept[..., 0, :, :], other[1], other[2]))


class NearDuplicates:
    """Signatures of the images that were kept. Memory: 28 kB for each."""

    def __init__(self, min_change=DEFAULT_CHANGE):
        """min_change: grey levels by which a new image must differ from every kept one; 0 keeps all."""
        self.min_change = min_change
        self._kept, self._count = np.empty((64, 3, CELLS[0] * CELLS[1], 3), np.float32), 0

    def add(self, image):
        """Remembers a kept image."""
        if self._count == len(self._kept):
            self._kept = np.concatenate([self._kept, np.empty_like(self._kept)])
        self._kept[self._count] = signature(image)
        self._count += 1

    def smallest_change(self, image):
        """The change against the nearest kept image [grey levels]; infinite without any."""
        if self._count == 0:
            return float("inf")
        return float(change(self._kept[:self._count], signature(image)).min())

    def has_like(self, image):
        """True when a kept image is nearer than min_change."""
        return self.min_change > 0 and self.smallest_change(image) < self.min_change
