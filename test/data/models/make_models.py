#!/usr/bin/python3
"""Writes the tiny networks that the unit tests of the detect module load. Needs PyTorch 1.13 (python3-torch).

They find nothing: their weights are random with a fixed seed. What matters is that their outputs have the shapes of
real detectors and depend on every input pixel, so that two back ends can be compared.
"""
from pathlib import Path

import torch
from torch import nn

OPSET = 10  # the newest that OpenCV 4.6 reads without trouble
CLASSES = 3
HEIGHT, WIDTH = 24, 32


def trunk():
    """One eighth of the resolution, 8 channels."""
    layers, channels = [], 3
    for _ in range(3):
        layers += [nn.Conv2d(channels, 8, 3, 2, 1), nn.ReLU()]
        channels = 8
    return nn.Sequential(*layers)


class YoloV8(nn.Module):
    """[1, 4 + classes, N], scores after the sigmoid; N is fixed in the graph, so it runs at one size only."""

    def __init__(self):
        super().__init__()
        self.trunk, self.head = trunk(), nn.Conv2d(8, 4 + CLASSES, 1)

    def forward(self, x):
        x = self.head(self.trunk(x)).reshape(1, 4 + CLASSES, HEIGHT * WIDTH // 64)
        return torch.cat([x[:, :4] * 10, torch.sigmoid(x[:, 4:])], 1)


class Ssd(nn.Module):
    """Corners [1, N, 4] and, background first, softmax scores [1, N, 1 + classes]."""

    def __init__(self):
        super().__init__()
        self.trunk, self.boxes, self.scores = trunk(), nn.Conv2d(8, 4, 1), nn.Conv2d(8, 1 + CLASSES, 1)

    def forward(self, x):
        x = self.trunk(x)
        boxes = torch.sigmoid(self.boxes(x)).flatten(2).transpose(1, 2) * 0.5
        boxes = torch.cat([boxes[..., :2], boxes[..., :2] + boxes[..., 2:]], -1)
        return boxes, torch.softmax(self.scores(x).flatten(2).transpose(1, 2), -1)


class YoloAnchors(nn.Module):
    """Raw heads of two levels with two anchors each."""

    def __init__(self):
        super().__init__()
        self.trunk, self.fine = trunk(), nn.Conv2d(8, 2 * (5 + CLASSES), 1)
        self.coarse = nn.Conv2d(8, 2 * (5 + CLASSES), 3, 2, 1)

    def forward(self, x):
        x = self.trunk(x)
        return self.fine(x), self.coarse(x)


class Vector(nn.Module):
    """One vector of 16 numbers from 112 x 112 pixels, as networks that describe faces have."""

    def __init__(self):
        super().__init__()
        self.pool, self.project = nn.AvgPool2d(16), nn.Linear(3 * 7 * 7, 16)

    def forward(self, x):
        return self.project(self.pool(x).flatten(1))


def export(network, name, outputs, size=(HEIGHT, WIDTH)):
    """One file beside this script."""
    torch.manual_seed(7)
    for parameter in network.parameters():
        nn.init.normal_(parameter, std=0.3)
    torch.onnx.export(network.eval(), torch.rand(1, 3, *size), Path(__file__).with_name(name).as_posix(),
                      opset_version=OPSET, input_names=['images'], output_names=outputs)


if __name__ == '__main__':
    export(YoloV8(), 'tiny_yolo_v8.onnx', ['output'])
    export(Ssd(), 'tiny_ssd.onnx', ['boxes', 'scores'])
    export(YoloAnchors(), 'tiny_yolo_anchors.onnx', ['fine', 'coarse'])
    export(Vector(), 'tiny_vector.onnx', ['vector'], (112, 112))
