"""Images of a board, warped from its print by the camera's projection."""

import cv2
import numpy

from extperfc import robot_description as rd
from extperfc.calibrate import views

PIXELS_PER_M = 4000
CAMERA = views.Camera(640, 480, numpy.array([[615.0, 0, 319.5], [0, 615.0, 239.5], [0, 0, 1]]), numpy.zeros(5))
SUPERSAMPLING = 2
cv2.setNumThreads(1)  # tests run beside each other


def print_of(board):
    """(grey image of the print, board_T_pixel as a 3 x 3 homography)."""
    x, y, width, height = board.outline()
    image = numpy.full((round(height * PIXELS_PER_M), round(width * PIXELS_PER_M)), 240, numpy.uint8)
    for cx, cy, w, h in board.dark_cells():
        left, top = round((cx - x) * PIXELS_PER_M), round((cy - y) * PIXELS_PER_M)
        right, bottom = round((cx + w - x) * PIXELS_PER_M), round((cy + h - y) * PIXELS_PER_M)
        image[top:bottom, left:right] = 20
    scale = 1 / PIXELS_PER_M
    return image, numpy.array([[scale, 0, x + scale / 2], [0, scale, y + scale / 2], [0, 0, 1]])


def render(board, camera_T_board, noise=2.0, seed=0):
    """What an undistorted camera sees, grey."""
    image, board_T_pixel = print_of(board)
    big = numpy.array([[SUPERSAMPLING, 0, (SUPERSAMPLING - 1) / 2], [0, SUPERSAMPLING, (SUPERSAMPLING - 1) / 2],
                       [0, 0, 1]])
    homography = big @ CAMERA.matrix @ camera_T_board[:3, [0, 1, 3]] @ board_T_pixel
    size = (CAMERA.width * SUPERSAMPLING, CAMERA.height * SUPERSAMPLING)
    warped = cv2.warpPerspective(image, homography, size, flags=cv2.INTER_AREA, borderValue=110)
    seen = cv2.resize(warped, (CAMERA.width, CAMERA.height), interpolation=cv2.INTER_AREA).astype(float)
    seen += numpy.random.default_rng(seed).normal(0, noise, seen.shape)
    return numpy.clip(seen, 0, 255).astype(numpy.uint8)


def pose(board, z_m=0.5, tilt=(0.2, -0.3, 0.1), middle=(0.0, 0.0)):
    """camera_T_board with the print's middle at (x, y, z_m) of the camera."""
    x, y, width, height = board.outline()
    centre = rd.transform((x + width / 2, y + height / 2, 0))
    return rd.transform((*middle, z_m), rd.rotation_of_rpy(*tilt)) @ rd.inverse(centre)
