#!/usr/bin/python3
"""Writes red_nose/, the face detector of the ROS tests. Needs PyTorch 1.13 (python3-torch).

Nothing is learned: a network with the outputs of a YuNet takes every cell of 32 x 32 pixels that is red for the nose of a
face of 96 x 96 pixels, with the landmarks where ArcFace expects them. So a test knows every answer beforehand.
"""
import hashlib
import math
from pathlib import Path

import torch
from torch import nn

OPSET = 10  # the newest that OpenCV 4.6 reads without trouble
SIDE = 320
STRIDES = (8, 16, 32)
FACE_CELLS = 3
LANDMARKS = ((38.2946, 51.6963), (73.5318, 51.5014), (56.0252, 71.7366), (41.5493, 92.3655), (70.7299, 92.2041))
NAMES = [f'{kind}_{stride}' for kind in ('cls', 'obj', 'bbox', 'kps') for stride in STRIDES]
DESCRIPTION = """\
# Written by make_red_nose.py
name: red_nose
file: red_nose.onnx
sha256: {sha256}
input: {{width: {side}, height: {side}, color: rgb, resize: letterbox, scale: 0.00392157}}
output: {{layout: yunet, names: [{names}]}}
classes: [face]
"""


def constant(values):
    """A convolution from one channel to these values, independent of its input."""
    layer = nn.Conv2d(1, len(values), 1)
    nn.init.zeros_(layer.weight)
    layer.bias.data = torch.tensor(values)
    return layer


class RedNose(nn.Module):
    """[1, 3, side, side] of 0 to 1 -> cls, obj, bbox and kps of the three strides."""

    def __init__(self):
        super().__init__()
        scale = FACE_CELLS / 112
        points = [0.5 + (value - 56) * scale for point in LANDMARKS for value in point]
        self.redness = nn.Conv2d(3, 1, 1, bias=False)
        self.redness.weight.data = torch.tensor([1.0, -1.0, -1.0]).view(1, 3, 1, 1)
        self.pools = nn.ModuleList(nn.AvgPool2d(stride) for stride in STRIDES)
        self.bbox = constant([0.5, 0.5, math.log(FACE_CELLS), math.log(FACE_CELLS)])
        self.kps = constant(points)

    def forward(self, x):
        cls, obj, bbox, kps = [], [], [], []
        for pool, stride in zip(self.pools, STRIDES):
            red = pool(self.redness(x))
            score = torch.sigmoid(40 * (red - 0.4) if stride == STRIDES[-1] else red - 20)
            cells = (SIDE // stride) ** 2
            rows = [part.permute(0, 2, 3, 1).reshape(1, cells, -1)
                    for part in (score, score * 1.0001, self.bbox(red), self.kps(red))]
            for outputs, part in zip((cls, obj, bbox, kps), rows):
                outputs.append(part)
        return (*cls, *obj, *bbox, *kps)


if __name__ == '__main__':
    folder = Path(__file__).with_name('red_nose')
    folder.mkdir(exist_ok=True)
    file = folder / 'red_nose.onnx'
    torch.onnx.export(RedNose().eval(), torch.rand(1, 3, SIDE, SIDE), file.as_posix(), opset_version=OPSET,
                      input_names=['input'], output_names=NAMES)
    sha256 = hashlib.sha256(file.read_bytes()).hexdigest()
    (folder / 'model.yaml').write_text(DESCRIPTION.format(sha256=sha256, side=SIDE, names=', '.join(NAMES)))
