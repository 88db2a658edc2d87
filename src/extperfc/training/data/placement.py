"""How an image becomes a network's input, as src/detect/preprocess.cpp does it on the robot."""

import typing

import cv2
import numpy as np

PADDING = 114  # grey of the letterbox bars


class Placement(typing.NamedTuple):
    """Pixels of the input = pixels of the image * (scale_x, scale_y) + (left, top)."""

    scale_x: float
    scale_y: float
    left: float
    top: float

    def to_input(self, boxes):
        """Boxes [M, 4] of the image in pixels of the input."""
        scale, shift = self._tables()
        return (np.asarray(boxes, np.float32).reshape(-1, 4) * scale + shift).astype(np.float32)

    def to_image(self, boxes, size=None):
        """Boxes [M, 4] of the input in pixels of the image, cut to `size` (width, height) when given."""
        scale, shift = self._tables()
        out = ((np.asarray(boxes, np.float32).reshape(-1, 4) - shift) / scale).astype(np.float32)
        return out if size is None else np.clip(out, 0, np.array([*size, *size], np.float32))

    def _tables(self):
        return (np.array([self.scale_x, self.scale_y] * 2, np.float32), np.array([self.left, self.top] * 2, np.float32))


def place(size, input_size, resize):
    """(Placement, (x, y, width, height) of the image in the input) for an image of `size` (width, height) px."""
    if resize == "stretch":
        return Placement(input_size[0] / size[0], input_size[1] / size[1], 0.0, 0.0), (0, 0, *input_size)
    scale = min(input_size[0] / size[0], input_size[1] / size[1])
    width, height = (min(max(int(np.floor(s * scale + 0.5)), 1), limit) for s, limit in zip(size, input_size))
    left, top = (input_size[0] - width) // 2, (input_size[1] - height) // 2
    return Placement(width / size[0], height / size[1], float(left), float(top)), (left, top, width, height)


def make_input(image, input_size, resize, interpolation=cv2.INTER_LINEAR):
    """(uint8 [height, width, 3] of the input, Placement) of an image uint8 [H, W, 3] in the same channel order."""
    placement, (left, top, width, height) = place(image.shape[1::-1], input_size, resize)
    resized = cv2.resize(image, (width, height), interpolation=interpolation)
    if (width, height) == tuple(input_size):
        return resized, placement
    out = np.full((input_size[1], input_size[0], 3), PADDING, np.uint8)
    out[top:top + height, left:left + width] = resized
    return out, placement
