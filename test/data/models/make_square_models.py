#!/usr/bin/python3
"""Writes square/ and square_slow/, the networks of the ROS tests. Needs PyTorch 1.13 (python3-torch).

Nothing is learned: the network computes the box around the one bright square of an image from the moments of its
brightness, and its class (red, green, blue or white) from its colour. So a test knows every answer beforehand.
square_slow takes a thousand times as long for the same answer: a detector that is busy.
"""
import hashlib
from pathlib import Path

import torch
from torch import nn

OPSET = 10  # the newest that OpenCV 4.6 reads without trouble
CELLS = 32  # the image is looked at as CELLS x CELLS values
CLASSES = ['red', 'green', 'blue', 'white']
BRIGHT, CONTRAST = 0.4, 5.0  # a cell counts from this brightness on, fully at BRIGHT + 1 / CONTRAST
DESCRIPTION = """\
# Written by make_square_models.py
name: {name}
file: {name}.onnx
sha256: {sha256}
input: {{width: {side}, height: {side}, color: rgb, scale: 0.00392157}}
output: {{layout: yolo_v8}}
classes: [{classes}]
"""


class Square(nn.Module):
    """[1, 3, side, side] of 0 to 1 -> [1, 4 + classes, 1]: cx cy w h in input pixels, scores."""

    def __init__(self, side, burden=0):
        super().__init__()
        self.cell_px, self.burden = side // CELLS, burden
        self.shrink = nn.AvgPool2d(self.cell_px)
        at = (torch.arange(CELLS) + 0.5) * self.cell_px
        one, x, y = torch.ones(CELLS, CELLS), at.expand(CELLS, CELLS), at.view(-1, 1).expand(CELLS, CELLS)
        self.moments = nn.Conv2d(1, 5, CELLS, bias=False)
        self.moments.weight.data = torch.stack([one, x, y, x * x, y * y]).unsqueeze(1)
        self.first = nn.Conv2d(3, 32, 3, padding=1) if burden else None
        self.again = nn.Conv2d(32, 32, 3, padding=1) if burden else None

    def forward(self, x):
        small = self.shrink(x) if self.cell_px > 1 else x
        red, green, blue = small[:, 0:1], small[:, 1:2], small[:, 2:3]
        mask = ((torch.maximum(torch.maximum(red, green), blue) - BRIGHT) * CONTRAST).clamp(0, 1)
        cells, sx, sy, sxx, syy = (self.moments(mask)[:, i:i + 1] for i in range(5))
        cells = cells + 1e-3
        cx, cy = sx / cells, sy / cells
        # A uniform square of width w has the variance w^2 / 12; one of whole cells loses cell^2 / 12.
        w, h = (((12 * (s / cells - c * c) + self.cell_px ** 2).clamp(0, 1e9)) ** 0.5 for s, c in ((sxx, cx), (syy, cy)))
        r, g, b = ((channel * mask).mean((2, 3), keepdim=True) * CELLS ** 2 / cells for channel in (red, green, blue))
        white = -torch.maximum(torch.maximum(-r, -g), -b)
        found = (cells - 1).clamp(0, 1)
        scores = [(r - torch.maximum(g, b)), (g - torch.maximum(r, b)), (b - torch.maximum(r, g)), white]
        if self.burden:
            found = found + self.work(x) * 1e-12
        return torch.cat([cx, cy, w, h] + [s.clamp(0, 1) * found for s in scores], 1).flatten(2)

    def work(self, x):
        x = self.first(x)
        for _ in range(self.burden):
            x = torch.relu(self.again(x))
        return x.mean((1, 2, 3)).view(1, 1, 1, 1)


def export(name, side, burden=0):
    torch.manual_seed(7)
    folder = Path(__file__).with_name(name)
    folder.mkdir(exist_ok=True)
    file = folder / (name + '.onnx')
    torch.onnx.export(Square(side, burden).eval(), torch.rand(1, 3, side, side), file.as_posix(), opset_version=OPSET,
                      input_names=['images'], output_names=['output'])
    sha256 = hashlib.sha256(file.read_bytes()).hexdigest()
    (folder / 'model.yaml').write_text(
        DESCRIPTION.format(name=name, sha256=sha256, side=side, classes=', '.join(CLASSES)))


if __name__ == '__main__':
    export('square', CELLS)
    export('square_slow', 10 * CELLS, burden=3)
