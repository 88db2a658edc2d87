"""Drawn data sets: shaded shapes on plain and cluttered ground, for smoke runs and as a first source domain.

`solids` has the classes of the robot's task, `household` sixteen other solids and household shapes. Drawn images show
whether training works; they do not make a network for photographs.
"""

import pathlib
import zlib

import cv2
import numpy as np

from .dataset import DataError, Dataset, make_sample
from .splits import FRACTIONS, write_splits
from .voc import write_voc_sample


def _circle(x, y, radius_x, radius_y=None, steps=40):
    angle = np.linspace(0, 2 * np.pi, steps, endpoint=False)
    return np.stack([x + radius_x * np.cos(angle), y + (radius_y or radius_x) * np.sin(angle)], 1)


def _box(x0, y0, x1, y1):
    return np.array([(x0, y0), (x1, y0), (x1, y1), (x0, y1)], float)


def _regular(corners, radius=1.0, inner=None):
    count = corners * (2 if inner else 1)
    angle = -np.pi / 2 + np.arange(count) * 2 * np.pi / count
    length = np.where(np.arange(count) % 2, inner or radius, radius)
    return np.stack([length * np.cos(angle), length * np.sin(angle)], 1)


def _ball(scale_y=1.0):
    rings = np.linspace(0, 1, 9)
    return [(_circle(-0.3 * t, -0.3 * t * scale_y, 1 - 0.9 * t, scale_y * (1 - 0.9 * t)), 0.55 + 0.6 * t)
            for t in rings]


def _shaded(x0, x1, y0, y1, top=1.0):
    """A body of revolution: vertical strips, brightest left of the middle; `top`: upper width over lower width."""
    strips, edges = [], np.linspace(x0, x1, 10)
    for left, right in zip(edges, edges[1:]):
        shade = 1.15 - 1.3 * abs((left + right) / 2 - x0 - 0.35 * (x1 - x0)) / (x1 - x0)
        strips.append((np.array([(left * top, y0), (right * top, y0), (right, y1), (left, y1)]), shade))
    return strips


# Parts of each shape, back to front: (corners [N, 2] in units of half the shape's size, y down; brightness).
SHAPES = {
    "cone": [(_circle(0, 0.85, 0.8, 0.15), 0.6), *_shaded(-0.8, 0.8, -1, 0.85, 0.02)],
    "cube": [(np.array([(-1, -.45), (0, -.1), (0, 1), (-1, .6)]), 0.95),
             (np.array([(0, -.1), (1, -.45), (1, .6), (0, 1)]), 0.6),
             (np.array([(-1, -.45), (0, -.8), (1, -.45), (0, -.1)]), 1.2)],
    "sphere": _ball(),
    "cylinder": [(_circle(0, 0.8, 0.6, 0.2), 0.6), *_shaded(-0.6, 0.6, -0.8, 0.8), (_circle(0, -0.8, 0.6, 0.2), 1.2)],
    "pyramid": [(np.array([(0, -1), (-0.9, 0.6), (0.1, 0.95)]), 1.1),
                (np.array([(0, -1), (0.1, 0.95), (0.9, 0.5)]), 0.6)],
    "torus": [(_circle(0, 0, 1 - 0.3 * t, 0.62 - 0.3 * t), 0.6 + 0.5 * t)
              for t in np.linspace(0, 1, 6)] + [(_circle(0, 0, 0.45, 0.16), -1)],
    "ellipsoid": _ball(0.55),
    "prism": [(np.array([(-1, 0.6), (-0.4, -0.6), (0.1, 0.8)]), 1.1),
              (np.array([(-.4, -.6), (.7, -.8), (1, .5), (.1, .8)]), 0.65)],
    "star": [(_regular(5, 1.0, 0.42), 1.0), (_regular(5, 0.5, 0.2), 1.2)],
    "hexagon": [(_regular(6), 0.7), (_regular(6, 0.8), 1.1)],
    "capsule": [(_circle(0, -0.6, 0.4), 0.9), (_circle(0, 0.6, 0.4), 0.7), *_shaded(-0.4, 0.4, -0.6, 0.6)],
    "mug": [(_circle(0.65, 0, 0.35, 0.4), 0.7), (_circle(0.65, 0, 0.2, 0.25), -1), *_shaded(-0.7, 0.6, -0.7, 0.8),
            (_circle(-0.05, -0.7, 0.65, 0.18), 0.45)],
    "bottle": [*_shaded(-0.4, 0.4, -0.2, 1), *_shaded(-0.4, 0.4, -0.5, -0.2, 0.4), *_shaded(-0.16, 0.16, -1, -0.5)],
    "bowl": [(_circle(0, -0.2, 1, 0.75)[:21], 0.9), (_circle(0, -0.2, 0.7, 0.7)[:21], 1.05),
             (_circle(0, -0.2, 1, 0.22), 0.5)],
    "book": [(_box(-0.75, -0.95, 0.75, 0.95), 0.6), (_box(-0.68, -0.95, 0.75, 0.9), 1.1),
             (_box(-0.4, -0.6, 0.45, -0.35), 0.5)],
    "plate": [(_circle(0, 0, 1, 0.4), 0.8), (_circle(0, -0.02, 0.9, 0.35), 1.15), (_circle(0, 0, 0.6, 0.22), 0.95)],
    "cross": [(_box(-0.3, -1, 0.3, 1), 0.9), (_box(-1, -0.3, 1, 0.3), 1.05)],
    "arch": [(_box(-1, -0.7, 1, 0.9), 0.95), (_circle(0, 0.35, 0.5, 0.55), -1), (_box(-0.5, 0.35, 0.5, 0.9), -1)],
    "spoon": [(_box(-0.09, -0.3, 0.09, 1), 0.8), (_circle(0, -0.6, 0.32, 0.42), 0.9),
              (_circle(0, -0.6, 0.22, 0.3), 1.2)],
}
SOLIDS = ("cone", "cube", "sphere")
DOMAINS = {"solids": SOLIDS, "household": tuple(name for name in SHAPES if name not in SOLIDS)}


def draw_image(class_names, rng, size=(320, 240)):
    """(uint8 [H, W, 3] BGR, rows of make_sample) of a random scene with one to four objects of the classes."""
    image = ground(size, rng)
    taken, rows = np.zeros(image.shape[:2], np.uint8), []
    for _ in range(rng.integers(1, 5)):
        label = int(rng.integers(len(class_names)))
        layer, mask = draw_shape(SHAPES[class_names[label]], size, rng, image)
        ys, xs = np.nonzero(mask)
        if len(xs) and (taken[mask > 0] > 0).mean() < 0.05:
            image[mask > 0] = layer[mask > 0]
            taken |= mask
            rows.append((label, xs.min(), ys.min(), xs.max() + 1, ys.max() + 1, False))
    image = cv2.GaussianBlur(image, (3, 3), float(rng.uniform(0.3, 1.0)))
    noise = rng.normal(0, rng.uniform(1, 6), image.shape)
    return np.clip(image + noise, 0, 255).astype(np.uint8), rows


def ground(size, rng):
    """A slope of brightness with some lines and spots."""
    width, height = size
    slope = np.linspace(*rng.uniform(0.6, 1.1, 2), height)[:, None] * np.linspace(*rng.uniform(0.7, 1.1, 2), width)
    image = np.clip(slope[..., None] * rng.uniform(60, 220, 3), 0, 255).astype(np.uint8)
    for _ in range(rng.integers(0, 7)):
        ends = [tuple(int(v) for v in rng.integers(0, size)) for _ in range(2)]
        color = [int(v) for v in rng.integers(20, 235, 3)]
        if rng.random() < 0.5:
            cv2.line(image, *ends, color, int(rng.integers(1, 5)), cv2.LINE_AA)
        else:
            cv2.circle(image, ends[0], int(rng.integers(2, 12)), color, -1, cv2.LINE_AA)
    return image


def draw_shape(parts, size, rng, behind):
    """(layer, mask) of a shape at a random place, size, tilt and colour; parts of brightness -1 show what is behind."""
    half = rng.uniform(0.1, 0.26) * min(size)
    tilt = rng.uniform(-0.3, 0.3)
    center = rng.uniform([half, half], np.array(size) - half)
    rotation = half * np.array([(np.cos(tilt), np.sin(tilt)), (-np.sin(tilt), np.cos(tilt))])
    color = rng.uniform(40, 225, 3)
    layer, mask = behind.copy(), np.zeros(behind.shape[:2], np.uint8)
    for corners, shade in parts:
        points = np.round((corners @ rotation + center) * 16).astype(np.int32)
        cut = np.zeros_like(mask)
        cv2.fillPoly(cut, [points], 1, cv2.LINE_8, 4)
        layer[cut > 0] = behind[cut > 0] if shade < 0 else np.clip(color * shade, 0, 255)
        mask[cut > 0] = 0 if shade < 0 else 1
    return layer, mask


def write_drawn(folder, domain, count, seed, size=(320, 240)):
    """Writes `count` images of a domain as a Pascal VOC folder with splits; returns the Dataset.

    The same arguments write the same images. DataError when the folder holds other files.
    """
    folder = pathlib.Path(folder)
    if domain not in DOMAINS:
        raise DataError(f"no drawn domain \"{domain}\"; there are {', '.join(DOMAINS)}")
    if folder.exists() and any(folder.iterdir()):
        raise DataError(f"{folder} is not empty: give a new folder")
    for name in ("JPEGImages", "Annotations", "ImageSets/Main"):
        (folder / name).mkdir(parents=True, exist_ok=True)
    class_names = DOMAINS[domain]
    (folder / "labels.txt").write_text("".join(f"{name}\n" for name in class_names))
    samples = []
    for number in range(count):
        rng = np.random.default_rng([seed, number, zlib.crc32(domain.encode())])
        image, rows = draw_image(class_names, rng, size)
        name = f"{number + 1:06d}"
        sample = make_sample(name, folder / "JPEGImages" / f"{name}.png", rows, size)
        cv2.imwrite(str(sample.image), image)
        write_voc_sample(folder, sample, class_names)
        samples.append(sample)
    dataset = Dataset(folder, class_names, tuple(samples))
    edges = np.round(np.cumsum([0, *FRACTIONS.values()]) * count).astype(int)
    names = {split: tuple(s.name for s in samples[a:b]) for split, a, b in zip(FRACTIONS, edges, edges[1:])}
    write_splits(dataset, names, seed, replace=True)
    return Dataset(folder, class_names, tuple(samples), names)
