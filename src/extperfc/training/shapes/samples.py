"""Training samples from folders that extperfc-render writes. Needs no torch.

Boxes are (N, 5) float32: class (index in CLASSES, -1: ignored), x0, y0, x1, y1 in pixels, x1 and y1 behind the last pixel.
"""
import time
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import cv2
import numpy as np

from . import CLASSES, PAD

MIN_SIDE = 8  # of an object that is asked for, at the network's input [px]


def image_file(folder, number):
    """Image `number` (from 0) of a rendered folder."""
    return Path(folder) / 'JPEGImages' / f'{number + 1:06d}.jpg'


def read_boxes(folder, number):
    """Boxes (N, 5) of an image; what is marked difficult is ignored."""
    root = ElementTree.parse(Path(folder) / 'Annotations' / f'{number + 1:06d}.xml').getroot()
    rows = []
    for item in root.iter('object'):
        label = -1 if item.findtext('difficult') == '1' else CLASSES.index(item.findtext('name'))
        x0, y0, x1, y1 = (int(item.findtext(f'bndbox/{key}')) for key in ('xmin', 'ymin', 'xmax', 'ymax'))
        rows.append((label, x0 - 1, y0 - 1, x1, y1))
    return np.array(rows, np.float32).reshape(-1, 5)


def load(folder, number, wait_s=0.0):
    """Image (H, W, 3) in RGB and boxes (N, 5). Waits for an image that is still to be rendered, `wait_s` at most."""
    end = time.monotonic() + wait_s
    notes = Path(folder) / 'Annotations' / f'{number + 1:06d}.xml'  # written after the image
    while not notes.exists():
        if time.monotonic() > end:
            raise SystemExit(f'{notes} does not exist: render the images first (tools/train_shapes render)')
        time.sleep(1.0)
    image = cv2.imread(str(image_file(folder, number)), cv2.IMREAD_COLOR)
    if image is None:
        raise SystemExit(f'{image_file(folder, number)} cannot be read: render the folder anew')
    return image[..., ::-1], read_boxes(folder, number)


def placement(width, height, size):
    """Letterbox of an image into `size` (width, height): scale, left, top [px]."""
    scale = min(size[0] / width, size[1] / height)
    return scale, (size[0] - round(width * scale)) // 2, (size[1] - round(height * scale)) // 2


def letterbox(image, size):
    """The image as the network sees it: aspect kept, centred, padded."""
    scale, left, top = placement(image.shape[1], image.shape[0], size)
    width, height = round(image.shape[1] * scale), round(image.shape[0] * scale)
    out = np.full((size[1], size[0], 3), PAD, np.uint8)
    out[top:top + height, left:left + width] = cv2.resize(image, (width, height), interpolation=cv2.INTER_LINEAR)
    return out


def move(boxes, scale, shift):
    """Boxes scaled, then shifted; both are pairs x, y."""
    out = boxes.copy()
    out[:, [1, 3]] = boxes[:, [1, 3]] * scale[0] + shift[0]
    out[:, [2, 4]] = boxes[:, [2, 4]] * scale[1] + shift[1]
    return out


def crop(boxes, area, keep=0.35):
    """Cuts boxes to area x0, y0, x1, y1; those with too little left become ignored, specks are dropped."""
    out = boxes.copy()
    out[:, 1::2] = np.clip(boxes[:, 1::2], area[0], area[2])
    out[:, 2::2] = np.clip(boxes[:, 2::2], area[1], area[3])
    size = out[:, 3:] - out[:, 1:3]
    full = np.maximum(1e-3, np.prod(boxes[:, 3:] - boxes[:, 1:3], axis=1))
    good = (np.prod(size, axis=1) >= keep * full) & (size.max(1) >= MIN_SIDE) & (size.min(1) >= 3)
    out[~good, 0] = -1
    return out[(size.min(1) >= 2) & (size.max(1) >= 4)]


class Augmenter:
    """Samples for one network input size: a function of (seed, index) alone."""

    def __init__(self, folder, size, seed, wait_s=0.0):
        self.folder, self.size, self.seed, self.wait_s = folder, size, seed, wait_s

    def sample(self, index, pool, mosaic):
        """Image (H, W, 3) uint8 and boxes (N, 5) from the first `pool` images; a fraction `mosaic` is made of four."""
        rng = np.random.default_rng([self.seed, index])
        width, height = self.size
        canvas = np.full((height, width, 3), PAD, np.uint8)
        if rng.random() < mosaic:
            boxes = self._mosaic(rng, pool, canvas)
        else:
            boxes = self._paste(rng, pool, canvas, (0, 0, width, height), np.exp(rng.uniform(np.log(0.75), np.log(1.5))))
        canvas = self._colour(rng, canvas)
        return (self._cover(rng, canvas, boxes) if rng.random() < 0.2 else canvas), boxes

    def _draw(self, rng, pool):
        image, boxes = load(self.folder, int(rng.integers(pool)), self.wait_s)
        if rng.random() < 0.5:
            image = image[:, ::-1]
            boxes = boxes * np.float32([1, -1, 1, -1, 1]) + np.float32([0, image.shape[1], 0, image.shape[1], 0])
            boxes = boxes[:, [0, 3, 2, 1, 4]]
        return image, boxes

    def _paste(self, rng, pool, canvas, area, zoom):
        """Puts an image into an area of the canvas, `zoom` times as large as it fits the whole one; returns its boxes."""
        image, boxes = self._draw(rng, pool)
        x0, y0, x1, y1 = area
        fit = zoom * min(self.size[0] / image.shape[1], self.size[1] / image.shape[0])
        stretch = np.exp(rng.normal(0, 0.06))
        factor = (fit * stretch, fit / stretch)
        gap = np.array([x1 - x0 - image.shape[1] * factor[0], y1 - y0 - image.shape[0] * factor[1]])
        shift = np.array([x0, y0]) + gap * rng.uniform(0, 1, 2)
        matrix = np.array([[factor[0], 0, shift[0] - x0], [0, factor[1], shift[1] - y0]])
        if fit < 0.5:
            image = cv2.blur(image, (2, 2))
        canvas[y0:y1, x0:x1] = cv2.warpAffine(np.ascontiguousarray(image), matrix, (x1 - x0, y1 - y0),
                                              flags=cv2.INTER_LINEAR, borderValue=(PAD,) * 3)
        return crop(move(boxes, factor, shift), area)

    def _mosaic(self, rng, pool, canvas):
        """Fills the canvas with four images; returns their boxes."""
        width, height = self.size
        x, y = int(width * rng.uniform(0.33, 0.67)), int(height * rng.uniform(0.33, 0.67))
        areas = ((0, 0, x, y), (x, 0, width, y), (0, y, x, height), (x, y, width, height))
        return np.concatenate([self._paste(rng, pool, canvas, area, np.exp(rng.uniform(-0.9, 0.1))) for area in areas])

    @staticmethod
    def _colour(rng, image):
        """Gain per channel, contrast, grey images, and exchange of channels."""
        kind = rng.random()
        if kind < 0.06:
            image = image[..., rng.permutation(3)]
        elif kind < 0.09:
            image = cv2.cvtColor(cv2.cvtColor(image, cv2.COLOR_RGB2GRAY), cv2.COLOR_GRAY2RGB)
        gain = np.exp(rng.normal(0, 0.12) + rng.normal(0, 0.05, 3))
        table = np.arange(256)[:, None] * gain + rng.normal(0, 8)
        return cv2.LUT(np.ascontiguousarray(image), np.uint8(np.clip(table, 0, 255))[:, None])

    @staticmethod
    def _cover(rng, image, boxes):
        """Covers small parts of the image, none of them much of an object."""
        height, width = image.shape[:2]
        for _ in range(int(rng.integers(1, 5))):
            size = rng.integers(6, 50, 2)
            x, y = rng.integers(0, (width - 6, height - 6))
            if len(boxes):
                overlap = (np.minimum(boxes[:, 3], x + size[0]) - np.maximum(boxes[:, 1], x)).clip(0) * \
                          (np.minimum(boxes[:, 4], y + size[1]) - np.maximum(boxes[:, 2], y)).clip(0)
                if (overlap > 0.25 * np.prod(boxes[:, 3:] - boxes[:, 1:3], axis=1)).any():
                    continue
            image[y:y + size[1], x:x + size[0]] = rng.integers(0, 256, 3)
        return image
