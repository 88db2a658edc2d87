#!/usr/bin/python3
"""Writes recording/, two aligned images of a red square before a wall, for nodelets that a .test file starts."""
from pathlib import Path

import cv2
import numpy

FOLDER = Path(__file__).with_name('recording')

for index in range(2):
    color = numpy.full((240, 320, 3), 10, numpy.uint8)
    depth = numpy.full((240, 320), 2000, numpy.uint16)
    square = (slice(60, 120), slice(80 + 10 * index, 160 + 10 * index))
    color[square] = (20, 20, 230)
    depth[square] = 1000
    for name, image in (('rgb', color), ('depth', depth)):
        (FOLDER / name).mkdir(parents=True, exist_ok=True)
        cv2.imwrite(str(FOLDER / name / f'{index}.png'), image)
