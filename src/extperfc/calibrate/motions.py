"""Whether the robot's poses determine the camera's pose, and which motion is missing.

The rotation of the camera follows from the directions of the axes that the carrier rotates about, its translation
from how far rotations about different axes move the board: views that differ by translations, or by rotations about
one axis, leave a part of the result free (R. Y. Tsai and R. K. Lenz, IEEE Trans. Robotics and Automation 5(3), 1989,
section IV).
"""

import dataclasses
import math

import cv2
import numpy

MIN_VIEWS = 8
MIN_SPREAD_RAD = math.radians(5)     # of rotations about the second axis, standard deviation: below this it is refused
GOOD_SPREAD_RAD = math.radians(12)   # advised
GOOD_COVERAGE = 0.35                 # advised fraction of the image in which corners were seen
NEW_ROTATION_RAD = math.radians(8)   # a view that differs less from another one,
NEW_TRANSLATION_M = 0.05             # and was moved less than this, adds little
AXES = "xyz"


class DegenerateError(ValueError):
    """Views that do not determine the result; the text says what is missing."""


@dataclasses.dataclass(frozen=True)
class Diversity:
    """How much the views differ."""
    views: int
    spread_rad: numpy.ndarray  # 3: standard deviation of the carrier's rotation about its principal axes, largest first
    axes: numpy.ndarray         # 3 x 3: these axes as rows, in the carrier's frame
    by_axis_rad: numpy.ndarray  # 3: about the carrier's own x, y and z
    coverage: float             # fraction of the image inside the outline of all corners seen, [0, 1]


def rotation_vector(rotation):
    """Axis times angle of a 3 x 3 rotation [rad]."""
    return cv2.Rodrigues(numpy.ascontiguousarray(rotation))[0].ravel()


def angle_between(a, b):
    """Angle [rad] of the rotation between two 4 x 4 poses."""
    return float(numpy.linalg.norm(rotation_vector(a[:3, :3].T @ b[:3, :3])))


def mean_rotation(rotations):
    """The 3 x 3 rotation that is nearest to the mean of several."""
    left, _, right = numpy.linalg.svd(numpy.sum(rotations, axis=0))
    return left @ numpy.diag([1, 1, numpy.linalg.det(left @ right)]) @ right


def diversity(poses, pixels=(), image_size=(1, 1)):
    """Of parent_T_carrier of every view, the corners [px] seen in each, and (width, height) of the images."""
    if not poses:
        return Diversity(0, numpy.zeros(3), numpy.eye(3), numpy.zeros(3), 0.0)
    mean = mean_rotation([pose[:3, :3] for pose in poses])
    vectors = numpy.array([rotation_vector(mean.T @ pose[:3, :3]) for pose in poses])
    _, spread, axes = numpy.linalg.svd(vectors / math.sqrt(len(poses)))
    spread = numpy.pad(spread, (0, 3 - len(spread)))
    return Diversity(len(poses), spread, axes, numpy.sqrt((vectors ** 2).mean(axis=0)), coverage(pixels, image_size))


def coverage(pixels, image_size):
    """Fraction of an image of (width, height) [px] within the convex outline of all pixels."""
    if not len(pixels):
        return 0.0
    hull = cv2.convexHull(numpy.concatenate(list(pixels)).astype(numpy.float32))
    return float(cv2.contourArea(hull) / (image_size[0] * image_size[1]))


def is_new(pose, poses):
    """Whether a view at this pose differs enough from the others to be worth taking."""
    return all(angle_between(pose, other) > NEW_ROTATION_RAD or
               numpy.linalg.norm(pose[:3, 3] - other[:3, 3]) > NEW_TRANSLATION_M for other in poses)


def _weak_axis(found):
    """Name of the carrier's own axis that it was rotated about least."""
    return AXES[int(numpy.argmin(found.by_axis_rad))]


def _strong_axis(found):
    """Name of the carrier's own axis that is nearest to the only axis of rotation."""
    return AXES[int(numpy.argmax(numpy.abs(found.axes[0])))]


def missing(found, carrier, wanted_views=MIN_VIEWS, spread_rad=GOOD_SPREAD_RAD, coverage_wanted=GOOD_COVERAGE):
    """What is still to be done, as sentences, the most urgent first; empty: nothing."""
    needs = []
    degrees = numpy.degrees(found.spread_rad)
    wanted = f"the spread of {degrees[1]:.0f} degrees should become {math.degrees(spread_rad):.0f}"
    if found.spread_rad[0] < spread_rad:
        needs.append(
            f"rotate {carrier}: so far it was almost only shifted, by {degrees[0]:.0f} degrees at the most; tilt it by "
            "20 degrees and more about two different axes")
    elif found.spread_rad[1] < spread_rad:
        needs.append(
            f"rotate {carrier} about its {_weak_axis(found)} axis too: so far it was rotated about one axis (its "
            f"{_strong_axis(found)} axis, or near it); {wanted}")
    if found.views < wanted_views:
        needs.append(f"{wanted_views - found.views} more views ({found.views} of {wanted_views})")
    if found.views >= 3 and found.coverage < coverage_wanted:
        needs.append(f"show the board in other parts of the image: it covered {100 * found.coverage:.0f} %, "
                     f"{100 * coverage_wanted:.0f} % are advised")
    return needs


def require(found, carrier):
    """Raises DegenerateError where the views cannot determine the result."""
    needs = missing(found, carrier, MIN_VIEWS, MIN_SPREAD_RAD, 0.0)
    if needs:
        raise DegenerateError("the views do not determine the camera's pose: " + "; ".join(needs))
