"""Training samples from folders that extperfc-render writes. Needs no torch.

Boxes are (N, 5) float32: class (index in CLASSES, -1: ignored), x0, y0, x1, y1 in pixels, x1 and y1 behind the last pixel.
"""
import time
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import cv2
import numpy as np

from . import CLASSES, PAD


def image_file(folder, number):
    """Image `number` (from 0) of a rendered folder."""
    return Path(folder) / 'JPEGImages' / f'{number + 1:06d}.jpg'


def notes_file(folder, number):
    """What image `number` (from 0) shows; written after the image."""
    return Path(folder) / 'Annotations' / f'{number + 1:06d}.xml'


def read_boxes(folder, number):
    """Boxes (N, 5) of an image; what is marked difficult is ignored."""
    root = ElementTree.parse(notes_file(folder, number)).getroot()
    rows = []
    for item in root.iter('object'):
        label = -1 if item.findtext('difficult') == '1' else CLASSES.index(item.findtext('name'))
        x0, y0, x1, y1 = (int(item.findtext(f'bndbox/{key}')) for key in ('xmin', 'ymin', 'xmax', 'ymax'))
        rows.append((label, x0 - 1, y0 - 1, x1, y1))
    return np.array(rows, np.float32).reshape(-1, 5)


def wait_for(folder, number, wait_s=0.0):
    """Waits for an image that is still to be rendered, `wait_s` at most; then ends with what to do."""
    end = time.monotonic() + wait_s
    notes = notes_file(folder, number)
    while not notes.exists():
        if time.monotonic() > end:
            raise SystemExit(f'{notes} does not exist: render the images first (tools/train_shapes render)')
        time.sleep(0.2)


def load(folder, number, wait_s=0.0):
    """Image (H, W, 3) in RGB and boxes (N, 5). Waits for an image that is still to be rendered, `wait_s` at most."""
    wait_for(folder, number, wait_s)
    image = cv2.imread(str(image_file(folder, number)), cv2.IMREAD_COLOR)
    if image is None:
        raise SystemExit(f'{image_file(folder, number)} cannot be read: render the folder anew')
    return cv2.cvtColor(image, cv2.COLOR_BGR2RGB), read_boxes(folder, number)


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
