"""What a calibration found, how well it fits, and how sure it is."""

import dataclasses
import math

import numpy
import yaml

from extperfc import robot_description as rd
from extperfc.calibrate import motions, solver, views

MAX_SIGMA_M = 0.01                  # a result that is less certain than this is refused
MAX_SIGMA_RAD = math.radians(1.0)


@dataclasses.dataclass(frozen=True)
class HeldOut:
    """How well the other views predict one that was left out."""
    name: str
    pixels: float      # root mean square of the corners' distances [px]
    position_m: float  # of the board, from its pose in this image alone
    angle_rad: float


@dataclasses.dataclass(frozen=True)
class Result:
    """All that is known after a calibration."""
    solution: solver.Solution
    view_errors_px: numpy.ndarray  # of every view, those left out too
    held_out: list                 # HeldOut of every view used
    covariance: numpy.ndarray      # 6 x 6 of parent_T_camera: x y z [m], rotation about parent's x y z [rad]
    spread_px: float               # root mean square of the corners' distances of the views used
    diversity: motions.Diversity

    @property
    def parent_T_camera(self):
        return self.solution.unknowns.parent_T_camera

    @property
    def sigma_m(self):
        """Standard deviation of the camera's position: root of the sum over the axes."""
        return float(numpy.sqrt(numpy.trace(self.covariance[:3, :3])))

    @property
    def sigma_rad(self):
        return float(numpy.sqrt(numpy.trace(self.covariance[3:, 3:])))


def pose_difference(a, b):
    """6 values: how b differs from a in translation [m] and as a rotation vector [rad], in the frame that both are
    given in."""
    return numpy.concatenate([b[:3, 3] - a[:3, 3], motions.rotation_vector(b[:3, :3] @ a[:3, :3].T)])


def _left_out(unknowns, seen, focal):
    predicted = unknowns.camera_T_board(seen.parent_T_carrier)
    difference = pose_difference(seen.camera_T_board, predicted)
    return HeldOut(seen.name, float(solver.view_errors(unknowns, [seen], focal)[0]),
                   float(numpy.linalg.norm(difference[:3])), float(numpy.linalg.norm(difference[3:])))


def cross_validate(solution, observations, focal):
    """([HeldOut], 6 x 6 covariance of parent_T_camera): every view is predicted by a refinement without it, and the
    refinements' scatter is the jackknife's estimate of the covariance (B. Efron, 1982, chapter 3). A view counts as a
    whole, so that errors of the robot's joints, which all corners of a view share, are part of it."""
    held_out, differences = [], []
    for i, seen in enumerate(observations):
        others = observations[:i] + observations[i + 1:]
        unknowns, _ = solver.refine(solution.unknowns, others, focal, solution.scales)
        held_out.append(_left_out(unknowns, seen, focal))
        differences.append(pose_difference(solution.unknowns.parent_T_camera, unknowns.parent_T_camera))
    differences = numpy.array(differences) - numpy.mean(differences, axis=0)
    return held_out, (len(observations) - 1) / len(observations) * differences.T @ differences


def calibrate(view_set):
    """The Result of a views.ViewSet. Raises motions.DegenerateError and solver.SolverError."""
    observations, focal = solver.observations_of(view_set), view_set.camera.focal
    return calibrate_observations(observations, focal, view_set.frames.carrier,
                                  [view.detection.pixels for view in view_set.views],
                                  (view_set.camera.width, view_set.camera.height))


def calibrate_observations(observations, focal, carrier="the carrier", pixels=(), image_size=(1, 1)):
    """The same of solver.Observation."""
    solution = solver.solve(observations, focal, carrier)
    fitting = [seen for seen, fits in zip(observations, solution.used) if fits]
    held_out, covariance = cross_validate(solution, fitting, focal)
    errors = solver.view_errors(solution.unknowns, observations, focal)
    counts = numpy.array([len(seen.points) for seen in observations]) * numpy.array(solution.used)
    found = Result(solution, errors, held_out, covariance, float(numpy.sqrt((errors**2 * counts).sum() / counts.sum())),
                   motions.diversity([seen.parent_T_carrier for seen in fitting], pixels, image_size))
    if found.sigma_m > MAX_SIGMA_M or found.sigma_rad > MAX_SIGMA_RAD:
        raise motions.DegenerateError(
            f"the camera's pose is uncertain by {1000 * found.sigma_m:.0f} mm and {math.degrees(found.sigma_rad):.1f} degrees: "
            f"take more views, with larger rotations of {carrier} about different axes, and check that nothing slips")
    return found


# ------------------------------------------------------------------------------------------------------ texts
def rpy_of_rotation(rotation):
    """Roll, pitch, yaw [rad] about the fixed axes, as in a URDF, of a 3 x 3 rotation; pitch in [-pi / 2, pi / 2]."""
    pitch = math.asin(max(-1.0, min(1.0, -rotation[2, 0])))
    if abs(rotation[2, 0]) > 1 - 1e-12:  # roll and yaw are about the same axis: all is yaw
        return 0.0, pitch, math.atan2(-rotation[0, 1], rotation[1, 1])
    return math.atan2(rotation[2, 1], rotation[2, 2]), pitch, math.atan2(rotation[1, 0], rotation[0, 0])


def rms(values):
    return float(numpy.sqrt(numpy.mean(numpy.square(list(values)))))


def report(found, view_set):
    """Lines for people."""
    frames, solution = view_set.frames, found.solution
    pose = found.parent_T_camera
    rpy = numpy.degrees(rpy_of_rotation(pose[:3, :3]))
    sigmas = numpy.sqrt(numpy.diag(found.covariance))
    lines = [f"{frames.camera} in {frames.parent}, from {sum(solution.used)} views:",
             "  position  " + "  ".join(f"{axis} {1000 * value:8.2f} +- {1000 * sigma:.2f} mm"
                                        for axis, value, sigma in zip("xyz", pose[:3, 3], sigmas)),
             "  rotation  " + "  ".join(f"{name} {value:7.2f}" for name, value in zip(("roll", "pitch", "yaw"), rpy)) +
             f" degrees, +- {math.degrees(found.sigma_rad):.2f}",
             f"  residual  {found.spread_px:.2f} px (root mean square of the corners' distances)"]
    lines.append("  views left out one by one, predicted by the others: "
                 f"{rms(held.pixels for held in found.held_out):.2f} px, "
                 f"{1000 * rms(held.position_m for held in found.held_out):.1f} mm, "
                 f"{math.degrees(rms(held.angle_rad for held in found.held_out)):.2f} degrees")
    for name, fits, error in zip([view.name for view in view_set.views], solution.used, found.view_errors_px):
        if not fits:
            lines.append(f"  {name}: contradicts the others by {error:.1f} px and was left out")
    if view_set.unseen:
        lines.append(f"  no board in {', '.join(view_set.unseen)}")
    return lines + closed_form_lines(found, view_set)


def closed_form_lines(found, view_set):
    """A table of the methods, with their distance from the refined result."""
    observations = [seen for seen, fits in zip(solver.observations_of(view_set), found.solution.used) if fits]
    lines = [f"  {'method':<16}{'residual':>10}{'from the refined result':>34}"]
    for name, unknowns in found.solution.closed_forms.items():
        difference = pose_difference(found.parent_T_camera, unknowns.parent_T_camera)
        error = rms(solver.view_errors(unknowns, observations, view_set.camera.focal))
        lines.append(f"  {name:<16}{error:>7.2f} px{1000 * numpy.linalg.norm(difference[:3]):>18.1f} mm"
                     f"{math.degrees(numpy.linalg.norm(difference[3:])):>6.2f} degrees")
    return lines + [f"  {'refined':<16}{found.spread_px:>7.2f} px"]


# ------------------------------------------------------------------------------------------------------ files
def as_yaml(found, view_set, date):
    """Text of the file that the launch argument camera_pose takes: a geometry_msgs/TransformStamped, as
    static_transform_publisher of tf2_ros reads it from a parameter, and the figures behind it."""
    child, child_T_camera = view_set.frames.child_T_camera()
    numbers = views.numbers_of_pose(found.parent_T_camera @ rd.inverse(child_T_camera))
    fields = {
        "header": {
            "frame_id": view_set.frames.parent
        },
        "child_frame_id": child,
        "transform": {
            "translation": dict(zip("xyz", numbers[:3])),
            "rotation": dict(zip("xyzw", numbers[3:]))
        },
        "calibration": {
            "date": date,
            "views": int(sum(found.solution.used)),
            "views_left_out": int(len(found.solution.used) - sum(found.solution.used)),
            "residual_px": round(found.spread_px, 4),
            "cross_validation": {
                "px": round(rms(held.pixels for held in found.held_out), 4),
                "mm": round(1000 * rms(held.position_m for held in found.held_out), 4),
                "degrees": round(math.degrees(rms(held.angle_rad for held in found.held_out)), 4)
            },
            "sigma": {
                "mm": round(1000 * found.sigma_m, 4),
                "degrees": round(math.degrees(found.sigma_rad), 4)
            },
            "camera_frame": view_set.frames.camera,
            "parent_T_camera": [float(value) for value in views.numbers_of_pose(found.parent_T_camera)],
            "covariance": [float(f"{value:.6g}") for value in found.covariance.ravel()],
            "carrier": view_set.frames.carrier,
            "carrier_T_board":
            [float(value) for value in views.numbers_of_pose(found.solution.unknowns.carrier_T_board)]
        }
    }
    return ("# Pose of a camera, by extperfc-calibrate; give this file to a launch file as camera_pose:=FILE.\n" +
            yaml.safe_dump(fields, sort_keys=False, default_flow_style=None, width=120))


def read_pose(file):
    """(parent, child, parent_T_child) of such a file. Raises views.ViewsError."""
    try:
        fields = yaml.safe_load(file.read_text())
        transform = fields["transform"]
        numbers = [
            transform[group][axis] for group, axes in (("translation", "xyz"), ("rotation", "xyzw")) for axis in axes
        ]
        return fields["header"]["frame_id"], fields["child_frame_id"], views.pose_of_numbers(numbers)
    except OSError as error:
        raise views.ViewsError(f"{file}: {error.strerror}") from None
    except (yaml.YAMLError, KeyError, TypeError) as error:
        raise views.ViewsError(
            f"{file} holds no pose of a camera: {error}; extperfc-calibrate solve writes such files") from None
