"""The two unknown transforms of a calibration: closed forms for a start, then a joint refinement.

Closed forms: OpenCV's calibrateHandEye (Tsai and Lenz 1989; Park and Martin 1994; Horaud and Dornaika 1995; Andreff
et al. 1999; Daniilidis 1999) and calibrateRobotWorldHandEye (Shah 2013; Li et al. 2010). They need the board's pose
of every view and weigh rotations and translations against each other as they please.

Refinement: maximum likelihood of all corners over both transforms, when the robot's poses have errors too. A corner's
error is normal with Cauchy's robust weight (P. W. Holland and R. E. Welsch, 1977); a view's robot error, 6 values,
has Student's t-distribution with a scale of translations and one of rotations that are estimated from the views (EM
algorithm: C. Liu and D. B. Rubin, Statistica Sinica 5, 1995). With an exact robot this is the minimum of the
reprojection errors (A. Tabb and K. Ahmad Yousef, Machine Vision and Applications 28, 2017); with an inexact one it is
not led astray by trusting its positions.
"""

import dataclasses

import cv2
import numpy

from extperfc import robot_description as rd
from extperfc.calibrate import motions

CAUCHY = 2.385               # of the tuning constant: 95 % efficiency for normal errors
MIN_DEPTH_M = 1e-3           # of a point before the camera
WEIGHINGS = 4
SMALL_STEP = 1e-6            # [m, rad]
MIN_SCALE_PX = 0.02          # below this the robust scale is rounding
MIN_ROBOT_M, MIN_ROBOT_RAD = 2e-5, 2e-5   # robot errors below these are rounding
STUDENT = 4.0                # degrees of freedom of the robot's errors
CONSENSUS_TRIES = 40
CONSENSUS_VIEWS = 5
OUTLIER_SQUARED = 40.0  # a view whose robot error is this large, in squared standard deviations, is left out
MAX_OUTLIERS = 0.35          # of the views
MAX_STEPS = 60
CLOSED_FORMS = {"Tsai-Lenz": cv2.CALIB_HAND_EYE_TSAI, "Park-Martin": cv2.CALIB_HAND_EYE_PARK,
                "Horaud-Dornaika": cv2.CALIB_HAND_EYE_HORAUD, "Andreff": cv2.CALIB_HAND_EYE_ANDREFF,
                "Daniilidis": cv2.CALIB_HAND_EYE_DANIILIDIS}
ROBOT_WORLD_FORMS = {"Shah": cv2.CALIB_ROBOT_WORLD_HAND_EYE_SHAH, "Li": cv2.CALIB_ROBOT_WORLD_HAND_EYE_LI}


class SolverError(ValueError):
    """No result; the text says why and what to do."""


@dataclasses.dataclass(frozen=True)
class Observation:
    """What the solver knows of a view."""
    name: str
    parent_T_carrier: numpy.ndarray  # 4 x 4
    points: numpy.ndarray            # n x 3 [m], of the board
    rays: numpy.ndarray              # n x 2: x / z, y / z
    camera_T_board: numpy.ndarray    # 4 x 4, from this image alone


@dataclasses.dataclass(frozen=True)
class Unknowns:
    """What is sought."""
    parent_T_camera: numpy.ndarray
    carrier_T_board: numpy.ndarray

    def camera_T_board(self, parent_T_carrier):
        return rd.inverse(self.parent_T_camera) @ parent_T_carrier @ self.carrier_T_board


@dataclasses.dataclass(frozen=True)
class Scales:
    """Standard deviations along one axis: of a corner, and of what the robot reports of a link."""
    corner_px: float = 1.0
    robot_m: float = 1e-3
    robot_rad: float = 1e-3


@dataclasses.dataclass(frozen=True)
class Solution:
    """A refined result."""
    unknowns: Unknowns
    scales: Scales
    used: list           # of bool: whether a view was used
    closed_forms: dict   # name: Unknowns


def board_pose(points, rays):
    """camera_T_board of n x 3 points [m] of a plane seen along n x 2 rays; the better one of the two poses of a plane
    (T. Collins and A. Bartoli, IJCV 109, 2014), refined."""
    image = numpy.ascontiguousarray(rays).reshape(-1, 1, 2)
    board = numpy.ascontiguousarray(points).reshape(-1, 1, 3)
    found, rotations, translations, _ = cv2.solvePnPGeneric(board, image, numpy.eye(3), None, flags=cv2.SOLVEPNP_IPPE)
    if not found:
        raise SolverError("no pose explains the corners of a board: is its description right?")
    rotation, translation = cv2.solvePnPRefineLM(board, image, numpy.eye(3), None, rotations[0], translations[0])
    return rd.transform(translation.ravel(), cv2.Rodrigues(rotation)[0])


def observe(name, parent_T_carrier, points, rays):
    return Observation(name, parent_T_carrier, points, rays, board_pose(points, rays))


def observations_of(view_set):
    """Observations of a views.ViewSet."""
    points = view_set.board.points()
    return [
        observe(view.name, view.parent_T_carrier, points[view.detection.indices],
                view_set.camera.rays(view.detection.pixels)) for view in view_set.views
    ]


# ------------------------------------------------------------------------------------------------------ closed forms
def _parts(poses):
    return [pose[:3, :3] for pose in poses], [pose[:3, 3] for pose in poses]


def _hand_eye(observations, method):
    """parent_T_camera: for OpenCV the parent is the gripper, and the carrier is the base."""
    turned = _parts([rd.inverse(seen.parent_T_carrier) for seen in observations])
    seen = _parts([seen.camera_T_board for seen in observations])
    rotation, translation = cv2.calibrateHandEye(*turned, *seen, method=method)
    return rd.transform(translation.ravel(), rotation)


def _robot_world(observations, method):
    """parent_T_camera: for OpenCV the board is the world, the carrier the base, and the parent the gripper."""
    seen = _parts([seen.camera_T_board for seen in observations])
    robot = _parts([seen.parent_T_carrier for seen in observations])
    found = cv2.calibrateRobotWorldHandEye(*seen, *robot, method=method)
    return rd.inverse(rd.transform(found[3].ravel(), found[2]))


def _with_board(parent_T_camera, observations):
    """Unknowns with the mean of carrier_T_board over the views."""
    boards = [rd.inverse(seen.parent_T_carrier) @ parent_T_camera @ seen.camera_T_board for seen in observations]
    rotation = motions.mean_rotation([board[:3, :3] for board in boards])
    return Unknowns(parent_T_camera, rd.transform(numpy.median([board[:3, 3] for board in boards], axis=0), rotation))


def closed_forms(observations):
    """{name: Unknowns} of the methods that give a finite transform."""
    found = {}
    for forms, solve in ((CLOSED_FORMS, _hand_eye), (ROBOT_WORLD_FORMS, _robot_world)):
        for name, method in forms.items():
            try:
                pose = solve(observations, method)
            except cv2.error:
                continue
            if numpy.isfinite(pose).all() and abs(numpy.linalg.det(pose[:3, :3]) - 1) < 1e-3:
                found[name] = _with_board(pose, observations)
    return found


# ------------------------------------------------------------------------------------------------------ residuals
def residuals(unknowns, seen, focal):
    """n x 2 [px]: where the corners should be, less where they are, lens distortion removed."""
    pose = unknowns.camera_T_board(seen.parent_T_carrier)
    points = seen.points @ pose[:3, :3].T + pose[:3, 3]
    points[:, 2] = numpy.maximum(points[:, 2], MIN_DEPTH_M)
    return (points[:, :2] / points[:, 2:] - seen.rays) * focal


def view_errors(unknowns, observations, focal):
    """Root mean square of the corners' distances [px] of every view."""
    return numpy.array([numpy.sqrt((residuals(unknowns, seen, focal)**2).sum(axis=1).mean()) for seen in observations])


def _cross(vectors):
    """n x 3 x 3: matrices of the cross product with n x 3 vectors."""
    made = numpy.zeros((len(vectors), 3, 3))
    made[:, 0, 1], made[:, 0, 2], made[:, 1, 2] = -vectors[:, 2], vectors[:, 1], -vectors[:, 0]
    return made - made.transpose(0, 2, 1)


def _projection(points, focal):
    """n x 2 x 3: derivatives [px/m] of the images of n x 3 points [m]."""
    z = points[:, 2]
    made = numpy.zeros((len(points), 2, 3))
    for axis in (0, 1):
        made[:, axis, axis] = focal[axis] / z
        made[:, axis, 2] = -focal[axis] * points[:, axis] / z ** 2
    return made


def _moved_by(rotation, points):
    """n x 3 x 6: how points [m] of a frame move when that frame moves by a small translation and rotation, in its own
    axes; `rotation` takes the frame's axes to those of the answer."""
    return rotation @ numpy.concatenate([numpy.broadcast_to(numpy.eye(3), (len(points), 3, 3)), -_cross(points)],
                                        axis=2)


def linearized(unknowns, seen, focal):
    """(2n residuals [px], their derivatives 2n x 12 by small motions of camera and board, and 2n x 6 by one of the
    carrier); motions are translations and rotations in the moved frame's own axes."""
    pose = unknowns.camera_T_board(seen.parent_T_carrier)
    points = seen.points @ pose[:3, :3].T + pose[:3, 3]
    points[:, 2] = numpy.maximum(points[:, 2], MIN_DEPTH_M)
    board, projection = unknowns.carrier_T_board, _projection(points, focal)
    in_carrier = seen.points @ board[:3, :3].T + board[:3, 3]
    by_camera = projection @ -_moved_by(numpy.eye(3), points)
    by_board = projection @ _moved_by(pose[:3, :3], seen.points)
    by_carrier = projection @ _moved_by(pose[:3, :3] @ board[:3, :3].T, in_carrier)
    errors = (points[:, :2] / points[:, 2:] - seen.rays) * focal
    return errors.ravel(), numpy.concatenate([by_camera, by_board], axis=2).reshape(-1, 12), by_carrier.reshape(-1, 6)


# ------------------------------------------------------------------------------------------------------ refinement
class _RobotError:
    """What a view says of the robot's error in it, at present unknowns and scales."""

    def __init__(self, unknowns, seen, focal, scales):
        errors, self.derivatives, by_carrier = linearized(unknowns, seen, focal)
        precision = 1 / numpy.repeat([scales.robot_m, scales.robot_rad], 3) ** 2
        weights, self.weight = numpy.full(len(errors), scales.corner_px ** -2), 1.0
        for _ in range(WEIGHINGS):  # weights and robot error depend on each other
            weighted = by_carrier * weights[:, None]
            self._covariance = numpy.linalg.inv(weighted.T @ by_carrier + self.weight * numpy.diag(precision))
            self.motion = -self._covariance @ (weighted.T @ errors)
            left = (errors + by_carrier @ self.motion).reshape(-1, 2)
            self.squared = float(self.motion ** 2 @ precision)  # in standard deviations
            used_weights, used_weight = weights, self.weight
            weights = numpy.repeat(1 / (1 + (left**2).sum(axis=1) /
                                        (CAUCHY * scales.corner_px)**2), 2) / scales.corner_px**2
            self.weight = (STUDENT + 6) / (STUDENT + self.squared)
        self.corner_errors = numpy.linalg.norm(left, axis=1)
        self.moments = used_weight * self.motion ** 2 + numpy.diag(self._covariance)
        self._weighted = self.derivatives * used_weights[:, None]
        self._coupling, self._pull, self._errors = self._weighted.T @ by_carrier, weighted.T @ errors, errors

    def normal_equations(self):
        """12 x 12 matrix and right side, the robot's error eliminated (Schur's complement)."""
        eliminated = self._coupling @ self._covariance
        matrix = self._weighted.T @ self.derivatives - eliminated @ self._coupling.T
        return matrix, eliminated @ self._pull - self._weighted.T @ self._errors


def _moved(unknowns, step):
    def small(values):
        return rd.transform(values[:3], cv2.Rodrigues(values[3:])[0])
    return Unknowns(unknowns.parent_T_camera @ small(step[:6]), unknowns.carrier_T_board @ small(step[6:]))


def _new_scales(robot_errors):
    """Maximum likelihood of the scales, given what the views say: the corners' from their median (Rayleigh), the
    robot's from second moments."""
    corners = numpy.median(numpy.concatenate([error.corner_errors for error in robot_errors])) / 1.17741
    moments = numpy.mean([error.moments for error in robot_errors], axis=0)
    return Scales(max(float(corners), MIN_SCALE_PX), max(float(moments[:3].mean() ** 0.5), MIN_ROBOT_M),
                  max(float(moments[3:].mean() ** 0.5), MIN_ROBOT_RAD))


def _step(robot_errors):
    """12 values: towards the minimum."""
    matrix, right = (numpy.sum(parts, axis=0) for parts in zip(*(error.normal_equations() for error in robot_errors)))
    scale = 1 / numpy.sqrt(numpy.maximum(numpy.diag(matrix), 1e-30))  # metres and radians differ in size
    return scale * numpy.linalg.lstsq(matrix * scale[:, None] * scale, right * scale, rcond=1e-12)[0]


def refine(unknowns, observations, focal, scales=None):
    """(Unknowns, Scales) of the maximum of the likelihood near `unknowns`; the scales are estimated unless they are
    given."""
    fixed, scales = scales is not None, scales or Scales()
    for _ in range(MAX_STEPS):
        robot_errors = [_RobotError(unknowns, seen, focal, scales) for seen in observations]
        step = _step(robot_errors)
        unknowns = _moved(unknowns, step)
        previous, scales = scales, scales if fixed else _new_scales(robot_errors)
        settled = numpy.allclose(dataclasses.astuple(previous), dataclasses.astuple(scales), rtol=0.01, atol=0)
        if settled and numpy.abs(step).max() < SMALL_STEP:
            break
    return unknowns, scales


def consensus(observations, focal, seed=1):
    """Unknowns that explain half of the views best, of closed forms for all views and for random fives of them: least
    median of the views' errors (P. J. Rousseeuw, 1984), so that some of them may be wrong."""
    draws = numpy.random.default_rng(seed)
    best, best_error = None, numpy.inf
    for tried in range(CONSENSUS_TRIES + 1):
        count = min(CONSENSUS_VIEWS, len(observations))
        some = observations if tried == 0 else [
            observations[i] for i in draws.choice(len(observations), count, replace=False)
        ]
        for unknowns in _quick_forms(some):
            error = numpy.median(view_errors(unknowns, observations, focal))
            if error < best_error:
                best, best_error = unknowns, error
    if best is None:
        raise SolverError("no closed form has a solution: take views with more different orientations")
    return best


def _quick_forms(observations):
    """Unknowns of the two closed forms that are the most reliable on few views."""
    found = []
    for solve_by, method in ((_hand_eye, cv2.CALIB_HAND_EYE_PARK), (_robot_world, cv2.CALIB_ROBOT_WORLD_HAND_EYE_SHAH)):
        try:
            pose = solve_by(observations, method)
        except cv2.error:
            continue
        if numpy.isfinite(pose).all():
            found.append(_with_board(pose, observations))
    return found


def solve(observations, focal, carrier="the carrier"):
    """The Solution of all views that fit together. Raises motions.DegenerateError and SolverError."""
    motions.require(motions.diversity([seen.parent_T_carrier for seen in observations]), carrier)
    unknowns, scales = refine(consensus(observations, focal), observations, focal)
    used = [_RobotError(unknowns, seen, focal, scales).squared <= OUTLIER_SQUARED for seen in observations]
    wrong = used.count(False)
    if wrong > MAX_OUTLIERS * len(observations):
        raise SolverError(
            f"{wrong} of {len(observations)} views contradict the others: check that the board does not slip in its "
            "holder, that the robot stood still, and that frames and board are named rightly")
    fitting = [seen for seen, fits in zip(observations, used) if fits]
    motions.require(motions.diversity([seen.parent_T_carrier for seen in fitting]), carrier)
    unknowns, scales = refine(unknowns, fitting, focal)
    return Solution(unknowns, scales, used, closed_forms(fitting))
