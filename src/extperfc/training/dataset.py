"""The generated data set: manifest, cache of encoded images, letterbox and augmentation. Needs no torch."""
import hashlib
import json
import os
import time
from pathlib import Path

import cv2
import numpy as np

from . import scenes

WIDTH, HEIGHT, PAD = 320, 256, 114  # network input [px] and padding value
SHARD = 100  # images per label file
GENERATOR_FILES = ('textures.py', 'solids.py', 'render.py', 'polygons.py', 'scene_objects.py', 'others.py', 'camera.py', 'rooms.py', 'scenes.py')
SPLITS = {'train': (0, 20000), 'val': (1000000, 400), 'test': (2000000, 1000)}  # first seed, images
ROOMS = (3000000, 1000)  # likewise for the ordinary views of sequence.py, for evaluation only


def default_cache():
    """Folder of the image cache, outside the repository."""
    return Path(os.environ.get('XDG_CACHE_HOME', Path.home() / '.cache')) / 'extperfc'


def generator_sha256():
    """SHA-256 over the generator's files, in a fixed order."""
    digest = hashlib.sha256()
    for name in GENERATOR_FILES:
        digest.update((Path(__file__).parent / name).read_bytes())
    return digest.hexdigest()


def image_size(split):
    """Width and height of a split's images [px]: training is smaller and faster, the others as cameras have it."""
    return scenes.SIZE if split == 'train' else (640, 480)


def shard_path(cache, split, index, version=scenes.VERSION):
    """Label file of a shard; its presence says that the shard's images are complete."""
    return Path(cache) / f'shapes-v{version}' / split / f'{index:05d}.json'


def generate(cache, split, count=None, report=print):
    """Renders what is missing of a split into the cache; returns the number of images."""
    cv2.setNumThreads(1)
    first, default = SPLITS[split]
    count = count or default
    begin = time.time()
    for shard in range((count + SHARD - 1) // SHARD):
        path = shard_path(cache, split, shard)
        if path.exists():
            continue
        path.parent.mkdir(parents=True, exist_ok=True)
        entries = []
        for seed in range(first + shard * SHARD, first + min(count, (shard + 1) * SHARD)):
            sample = scenes.make_image(seed, image_size(split))
            name = f'{seed:08d}.jpg'
            cv2.imwrite(str(path.parent / name), sample.image[..., ::-1], [cv2.IMWRITE_JPEG_QUALITY, 93])
            entries.append({'file': name, 'labels': sample.labels, 'boxes': sample.boxes, 'ignored': sample.ignored})
        partial = path.with_suffix('.partial')
        partial.write_text(json.dumps(entries, default=int))
        partial.rename(path)
        report(f'{split} shard {shard}: {time.time() - begin:.0f} s')
    return count


def index(cache, split, versions=(scenes.VERSION,)):
    """Entries of all complete shards of a split, with absolute paths; older versions must be asked for."""
    entries = []
    for version in versions:
        for path in sorted(shard_path(cache, split, 0, version).parent.glob('?????.json')):
            for entry in json.loads(path.read_text()):
                entries.append(dict(entry, file=str(path.parent / entry['file'])))
    return entries


def load(entry):
    """Image (H, W, 3) in RGB and boxes (N, 5): class (-1: ignored), x0, y0, x1, y1 of an entry."""
    image = cv2.imread(entry['file'], cv2.IMREAD_COLOR)[..., ::-1]
    rows = [[label] + box for label, box in zip(entry['labels'], entry['boxes'])]
    boxes = np.array(rows + [[-1] + box for box in entry.get('ignored', [])], np.float32)
    return image, boxes.reshape(-1, 5)


def manifest(cache=None):
    """Description of the data set; class counts only for splits in the cache."""
    out = {'generator': 'extperfc.training.scenes', 'version': scenes.VERSION, 'sha256': generator_sha256(),
           'sha256_of': list(GENERATOR_FILES), 'image_size': list(scenes.SIZE), 'classes': list(scenes.CLASSES),
           'splits': {name: {'first_seed': first, 'images': count} for name, (first, count) in SPLITS.items()}}
    for name, split in list(out['splits'].items()):
        entries = index(cache, name) if cache else []
        if entries:
            labels = [label for entry in entries for label in entry['labels']]
            split['images'] = len(entries)
            split['objects'] = {cls: labels.count(i) for i, cls in enumerate(scenes.CLASSES)}
    digest = hashlib.sha256((Path(__file__).parent / 'sequence.py').read_bytes()).hexdigest()
    out['splits']['rooms'] = {'first_seed': ROOMS[0], 'images': ROOMS[1],
                              'generator': 'extperfc.training.sequence', 'sha256': digest}
    return out


def placement(width, height):
    """Letterbox of an image: scale, left, top [px of the network input]."""
    scale = min(WIDTH / width, HEIGHT / height)
    return scale, (WIDTH - round(width * scale)) // 2, (HEIGHT - round(height * scale)) // 2


def letterbox(image):
    """The image as the network sees it (HEIGHT, WIDTH, 3): aspect kept, centred, padded."""
    height, width = image.shape[:2]
    scale, left, top = placement(width, height)
    size = (round(width * scale), round(height * scale))
    out = np.full((HEIGHT, WIDTH, 3), PAD, np.uint8)
    how = cv2.INTER_AREA if scale < 0.5 else cv2.INTER_LINEAR
    out[top:top + size[1], left:left + size[0]] = cv2.resize(image, size, interpolation=how)
    return out


def move(boxes, scale, shift):
    """Boxes (N, 5) scaled, then shifted; both are pairs x, y."""
    out = boxes.copy()
    out[:, [1, 3]] = boxes[:, [1, 3]] * scale[0] + shift[0]
    out[:, [2, 4]] = boxes[:, [2, 4]] * scale[1] + shift[1]
    return out


def crop_boxes(boxes, area, keep=0.35, min_side=11):
    """Cuts boxes to area x0, y0, x1, y1; those with too little left become ignored, specks are dropped."""
    if not len(boxes):
        return boxes
    out = boxes.copy()
    out[:, 1::2] = np.clip(boxes[:, 1::2], area[0], area[2])
    out[:, 2::2] = np.clip(boxes[:, 2::2], area[1], area[3])
    size = out[:, 3:] - out[:, 1:3]
    full = np.maximum(1e-3, np.prod(boxes[:, 3:] - boxes[:, 1:3], axis=1))
    good = (np.prod(size, axis=1) >= keep * full) & (size.max(1) >= min_side) & (size.min(1) >= 3)
    out[~good, 0] = -1
    return out[(size.min(1) >= 2) & (size.max(1) >= 4)]


class Augmenter:
    """Draws training samples (HEIGHT, WIDTH, 3) and boxes (N, 5) from entries, those with more objects more often."""

    def __init__(self, entries, seed):
        self.rng = np.random.default_rng(seed)
        self.use(entries)

    def use(self, entries):
        """Replaces the entries."""
        self.entries = entries
        self.sums = np.cumsum([0.4 + min(4, len(entry['labels'])) for entry in entries])

    def _one(self):
        image, boxes = load(self.entries[int(np.searchsorted(self.sums, self.rng.uniform(0, self.sums[-1])))])
        if self.rng.random() < 0.5:
            image = image[:, ::-1]
            boxes = boxes * np.float32([1, -1, 1, -1, 1]) + np.float32([0, image.shape[1], 0, image.shape[1], 0])
            boxes = boxes[:, [0, 3, 2, 1, 4]]
        return image, boxes

    def _into(self, canvas, area, scale):
        """Pastes an image at a scale and random shift into an area of the canvas; returns its boxes."""
        image, boxes = self._one()
        x0, y0, x1, y1 = area
        ratio = np.exp(self.rng.normal(0, 0.07))
        factor = (scale * ratio, scale / ratio)
        size = np.array([image.shape[1] * factor[0], image.shape[0] * factor[1]])
        room = np.array([x1 - x0, y1 - y0]) - size
        shift = np.array([x0, y0]) + room * self.rng.uniform(0, 1, 2)
        matrix = np.array([[factor[0], 0, shift[0] - x0], [0, factor[1], shift[1] - y0]])
        if scale < 0.55:
            image = cv2.blur(image, (2, 2))
        part = cv2.warpAffine(np.ascontiguousarray(image), matrix, (x1 - x0, y1 - y0), flags=cv2.INTER_LINEAR,
                              borderValue=(PAD,) * 3)
        canvas[y0:y1, x0:x1] = part
        return crop_boxes(move(boxes, factor, shift), area)

    def _colour(self, image):
        """Gain per channel, contrast and exchange of channels."""
        if self.rng.random() < 0.1:
            image = image[..., self.rng.permutation(3)]
        gain = np.exp(self.rng.normal(0, 0.12) + self.rng.normal(0, 0.05, 3))
        table = np.arange(256)[:, None] * gain + self.rng.normal(0, 8)
        return cv2.LUT(np.ascontiguousarray(image), np.uint8(np.clip(table, 0, 255))[:, None])

    def _cutout(self, image, boxes):
        """Covers small parts of the image, none of them much of an object."""
        for _ in range(int(self.rng.integers(1, 5))):
            size = self.rng.integers(6, 50, 2)
            x, y = self.rng.integers(0, (WIDTH - 6, HEIGHT - 6))
            if len(boxes):
                overlap = (np.minimum(boxes[:, 3], x + size[0]) - np.maximum(boxes[:, 1], x)).clip(0) * \
                          (np.minimum(boxes[:, 4], y + size[1]) - np.maximum(boxes[:, 2], y)).clip(0)
                if (overlap > 0.25 * np.prod(boxes[:, 3:] - boxes[:, 1:3], axis=1)).any():
                    continue
            image[y:y + size[1], x:x + size[0]] = self.rng.integers(0, 256, 3)
        return image

    def _mosaic(self, canvas):
        """Fills the canvas with two or four images; returns their boxes."""
        x, y = int(self.rng.integers(110, WIDTH - 110)), int(self.rng.integers(90, HEIGHT - 90))
        areas = ((0, 0, x, y), (x, 0, WIDTH, y), (0, y, x, HEIGHT), (x, y, WIDTH, HEIGHT))
        if self.rng.random() < 0.3:
            areas = ((0, 0, x, HEIGHT), (x, 0, WIDTH, HEIGHT))
        return np.concatenate([self._into(canvas, area, np.exp(self.rng.uniform(-1.0, -.15))) for area in areas])

    def sample(self, mosaic=0.2):
        """One training sample; the fraction of mosaics is given."""
        canvas = np.full((HEIGHT, WIDTH, 3), PAD, np.uint8)
        kind = self.rng.random()
        if kind < mosaic:
            boxes = self._mosaic(canvas)
        elif kind < mosaic + 0.35:
            boxes = self._into(canvas, (0, 0, WIDTH, HEIGHT), np.exp(self.rng.uniform(np.log(.5), np.log(1.25))))
        else:
            image, boxes = self._one()
            scale, left, top = placement(image.shape[1], image.shape[0])
            canvas = letterbox(image)
            boxes = crop_boxes(move(boxes, (scale, scale), (left, top)), (0, 0, WIDTH, HEIGHT))
        canvas = self._colour(canvas)
        if self.rng.random() < 0.2:
            canvas = self._cutout(canvas, boxes)
        return canvas, boxes
