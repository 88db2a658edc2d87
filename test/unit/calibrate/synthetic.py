"""Views of a board whose true transforms are known, made from a seed."""

import math

import numpy

from extperfc import robot_description as rd
from extperfc.calibrate import solver, views
from extperfc.calibrate.board import Chessboard

BOARD = Chessboard(9, 6, 0.03)
CAMERA = views.Camera(640, 480, numpy.array([[615.0, 0, 319.5], [0, 615.0, 239.5], [0, 0, 1]]),
                      numpy.array([0.1, -0.2, 0.001, -0.002, 0.05]))
PARENT_T_CAMERA = rd.transform((0.17, 0.03, 0.19), rd.rotation_of_rpy(-2.4, 0.05, -1.5))
CARRIER_T_BOARD = rd.transform((0.02, -0.05, 0.08), rd.rotation_of_rpy(0.3, -0.2, 0.5))
BOARD_MIDDLE = rd.transform((0.12, 0.075, 0.0))


def view_pose(random, tilt_rad=0.6, roll_rad=math.pi, axis=None):
    """A random camera_T_board with the board in the image, tilted about any axis of the image, or about `axis` only."""
    z = random.uniform(0.45, 0.8)
    middle = (random.uniform(-0.25, 0.25) * z, random.uniform(-0.15, 0.15) * z, z)
    if axis is not None:
        rotation = rd.rotation_about(axis, random.uniform(-tilt_rad, tilt_rad))
    else:
        angle = random.uniform(0, 2 * math.pi)
        rotation = (rd.rotation_about((math.cos(angle), math.sin(angle), 0), random.uniform(0.1, tilt_rad)) @
                    rd.rotation_about((0, 0, 1), random.uniform(-roll_rad, roll_rad)))
    return rd.transform(middle, rotation) @ rd.inverse(BOARD_MIDDLE)


def carrier_pose(camera_T_board):
    """parent_T_carrier that brings the board there."""
    return PARENT_T_CAMERA @ camera_T_board @ rd.inverse(CARRIER_T_BOARD)


def disturbed(pose, random, sigma_m, sigma_rad):
    """A pose as a robot with errors reports it."""
    vector = random.normal(0, sigma_rad, 3)
    angle = float(numpy.linalg.norm(vector))
    rotation = rd.rotation_about(vector / angle, angle) if angle > 0 else numpy.eye(3)
    return pose @ rd.transform(random.normal(0, sigma_m, 3), rotation)


def observation(name, camera_T_board, random, sigma_px=0.1, robot_m=0.0, robot_rad=0.0):
    pixels = CAMERA.project(BOARD.points(), camera_T_board) + random.normal(0, sigma_px, (len(BOARD.points()), 2))
    reported = disturbed(carrier_pose(camera_T_board), random, robot_m, robot_rad)
    return solver.observe(name, reported, BOARD.points(), CAMERA.rays(pixels))


def observations(count, seed, **errors):
    random = numpy.random.default_rng(seed)
    return [observation(f"view {i}", view_pose(random), random, **errors) for i in range(count)]
