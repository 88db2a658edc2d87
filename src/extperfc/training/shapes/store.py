"""The rendered images of a training run. A GPU keeps them all in its memory, so that its input never waits for files."""
from concurrent.futures import ThreadPoolExecutor

import cv2
import numpy as np
import torch

from .samples import load, read_boxes, wait_for

OBJECTS = 40  # maximum of objects in one image or sample
NONE = -2  # label of an unused row of boxes; -1 is an ignored object


def rows_of(boxes):
    """Boxes (N, 5) as (OBJECTS, 5): what is asked for first, then what is ignored, then unused rows."""
    rows = np.full((OBJECTS, 5), NONE, np.float32)
    boxes = boxes[np.argsort(boxes[:, 0] < 0, kind='stable')][:OBJECTS]
    rows[:len(boxes)] = boxes
    return torch.from_numpy(rows)


class ImageStore:
    """Images (H, W, 3) uint8 and boxes (OBJECTS, 5) of a folder that may still grow; all images have one size.

    On the CPU, images are read whenever they are asked for; on a GPU, `capacity` of them are kept (0.6 MB each at 512 x 384).
    """

    def __init__(self, folder, capacity, device, wait_s=0.0, threads=2):
        self.folder, self.device, self.wait_s, self.known = folder, device, wait_s, 0
        cv2.setNumThreads(1)  # once: the readers are the threads
        self.readers = ThreadPoolExecutor(threads)
        self.height, self.width = load(folder, 0, wait_s)[0].shape[:2]
        self.boxes = torch.empty(capacity, OBJECTS, 5, device=device)
        kept = capacity if device.type == 'cuda' else 0
        self.images = torch.empty(kept, self.height, self.width, 3, dtype=torch.uint8, device=device)

    def grow(self, count):
        """Makes the first `count` images known; waits for those that are still to be rendered."""
        fresh = range(self.known, count)
        if not fresh:
            return
        for number, (image, boxes) in zip(fresh, self.readers.map(self._read, fresh)):
            self.boxes[number] = boxes.to(self.device)
            if image is not None:
                self.images[number] = image.to(self.device, non_blocking=True)
        self.known = count

    def fetch(self, numbers):
        """Images (N, H, W, 3) uint8 and boxes (N, OBJECTS, 5) of known images, on the device."""
        if len(self.images):
            places = numbers.to(self.device, non_blocking=True)
            return self.images[places], self.boxes[places]
        images = list(self.readers.map(self._image, numbers.tolist()))
        return torch.stack(images), self.boxes[numbers]

    def _image(self, number):
        return torch.from_numpy(np.ascontiguousarray(load(self.folder, number)[0]))

    def _read(self, number):
        wait_for(self.folder, number, self.wait_s)
        image = self._image(number) if len(self.images) else None
        return image, rows_of(read_boxes(self.folder, number))
