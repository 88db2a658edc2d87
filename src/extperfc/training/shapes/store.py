"""The rendered images of a training run. A GPU keeps in its memory what fits, so that its input does not wait for files."""
from collections import deque
from concurrent.futures import ThreadPoolExecutor

import cv2
import numpy as np
import torch

from .samples import load, notes_file, read_boxes, wait_for

OBJECTS = 40  # maximum of objects in one image or sample
NONE = -2  # label of an unused row of boxes; -1 is an ignored object
AHEAD = 256  # images that are read before they are asked for, at most


def rows_of(boxes):
    """Boxes (N, 5) as (OBJECTS, 5): what is asked for first, then what is ignored, then unused rows."""
    rows = np.full((OBJECTS, 5), NONE, np.float32)
    boxes = boxes[np.argsort(boxes[:, 0] < 0, kind='stable')][:OBJECTS]
    rows[:len(boxes)] = boxes
    return torch.from_numpy(rows)


def pinned(values, device):
    """Values on the CPU; those for a GPU in memory from which it copies without being waited for."""
    return values.contiguous().pin_memory() if device.type == 'cuda' else values


class ImageStore:
    """Images (H, W, 3) uint8 and boxes (OBJECTS, 5) of a folder that may still grow; all images have one size.

    A GPU keeps the first images, up to a `fraction` of its free memory (0.6 MB each at 512 x 384); all others are read whenever
    they are asked for.
    """

    def __init__(self, folder, capacity, device, wait_s=0.0, threads=2, fraction=0.7):
        self.folder, self.device, self.wait_s, self.known = folder, device, wait_s, 0
        cv2.setNumThreads(1)  # once: the readers are the threads
        self.readers = ThreadPoolExecutor(threads)
        self.coming, self.asked = deque(), 0  # what is being read, in turn, and the number of the next
        self.height, self.width = load(folder, 0, wait_s)[0].shape[:2]
        self.boxes = torch.empty(capacity, OBJECTS, 5, device=device)
        kept = min(capacity, int(fraction * free_memory(device) / (3 * self.height * self.width)))
        self.images = torch.empty(kept, self.height, self.width, 3, dtype=torch.uint8, device=device)

    def grow(self, count):
        """Makes the first `count` images known; waits for those that are still to be rendered. Rendered ones that follow are
        read ahead.
        """
        for number in range(self.known, count):
            self._ask(number + 1)
            image, boxes = self.coming.popleft().result()
            self.boxes[number] = boxes.to(self.device, non_blocking=True)
            if image is not None:
                self.images[number] = image.to(self.device, non_blocking=True)
        self.known = max(count, self.known)

    def _ask(self, needed):
        """Lets readers read up to `needed`, and what is rendered of those that follow."""
        end = min(needed + AHEAD, len(self.boxes))
        while self.asked < needed or (self.asked < end and notes_file(self.folder, self.asked).exists()):
            self.coming.append(self.readers.submit(self._read, self.asked))
            self.asked += 1

    def fetch(self, numbers):
        """Images (N, H, W, 3) uint8 and boxes (N, OBJECTS, 5) of known images, on the device."""
        places = numbers.to(self.device, non_blocking=True)
        absent = (numbers >= len(self.images)).nonzero()[:, 0]
        if not len(absent):
            return self.images[places], self.boxes[places]
        read = torch.stack(list(self.readers.map(self._image, numbers[absent].tolist()))).to(self.device)
        if len(absent) == len(numbers):
            return read, self.boxes[places]
        images = self.images[places.clamp(max=len(self.images) - 1)]
        images[absent.to(self.device)] = read
        return images, self.boxes[places]

    def _image(self, number):
        return torch.from_numpy(load(self.folder, number)[0])

    def _read(self, number):
        wait_for(self.folder, number, self.wait_s)
        image = pinned(self._image(number), self.device) if number < len(self.images) else None
        return image, pinned(rows_of(read_boxes(self.folder, number)), self.device)


def free_memory(device):
    """Bytes that images may fill; none on the CPU, whose memory other programs need."""
    return torch.cuda.mem_get_info(device)[0] if device.type == 'cuda' else 0
