"""Where objects of the world `grasp` are put, and what counts as picked and placed; knows neither ROS nor the simulator."""

import collections
import math

import numpy

# name of the body and label: width [m], height [m], height of the body's origin (its centre of mass) as a fraction of it
Shape = collections.namedtuple("Shape", "width height origin")
SHAPES = {"cube": Shape(0.045, 0.045, 0.5), "sphere": Shape(0.05, 0.05, 0.5), "cone": Shape(0.06, 0.09, 0.25)}

# The tray of config/worlds/grasp.yaml: x and y of its middle, size; its origin is under it. The column stands on z of its own.
TRAY_XY, TRAY_SIZE = (0.56, 0.0), (0.46, 0.70, 0.03)
COLUMN_XY, COLUMN_HEIGHT, COLUMN_DIAMETER = (0.72, 0.0), 1.17, 0.09
# Objects stay so far from the tray's edges, and nearer to the robot than this no gripper fits between it and them [m].
EDGE_M = 0.05
MIN_X_M = 0.38
OTHER_PLACE_M = (0.08, 0.20)  # from where an object was to where it is placed

MAX_TILT_RAD = math.radians(10)
MAX_ERROR_M = 0.03       # of a placed object from where it should be, in the plane
MAX_ERROR_HEIGHT_M = 0.01
MIN_RISE = 0.7           # fraction of the lift that a picked object has risen by
MAX_IN_GRIPPER_M = 0.08    # of a held object's middle from the gripper's tip

PlacePose = collections.namedtuple("PlacePose", "x y top yaw")  # top: height of the tray; map [m], [rad]

OUTCOMES = ("success", "reported failure", "false success", "false failure")


class NoPlace(Exception):
    """A distance at which no place of the tray is in the image."""


def middle(shape, place_pose):
    """Middle of the object's bounding box when it stands there."""
    return numpy.array([place_pose.x, place_pose.y, place_pose.top + SHAPES[shape].height / 2])


def body_position(shape, place_pose):
    """Where the body's origin is when the object stands there."""
    return numpy.array([place_pose.x, place_pose.y, place_pose.top + SHAPES[shape].height * SHAPES[shape].origin])


def body_of(shape, map_T_middle):
    """map_T_body of the object whose middle of the bounding box is there, 4 x 4."""
    middle_T_body = numpy.eye(4)
    middle_T_body[2, 3] = SHAPES[shape].height * (SHAPES[shape].origin - 0.5)
    return map_T_middle @ middle_T_body


def on_tray(x, y):
    return (max(TRAY_XY[0] - TRAY_SIZE[0] / 2 + EDGE_M, MIN_X_M) < x < TRAY_XY[0] + TRAY_SIZE[0] / 2 - EDGE_M
            and abs(y - TRAY_XY[1]) < TRAY_SIZE[1] / 2 - EDGE_M)


def in_image(shape, position, camera, map_T_camera):
    """Whether an object with its middle there, with any yaw, is wholly in the image."""
    width, height, focal, cx, cy = camera
    half = (0.71 * SHAPES[shape].width, SHAPES[shape].height / 2)
    corners = [(*(position + (i * half[0], j * half[0], k * half[1])), 1.0) for i in (-1, 1) for j in (-1, 1) for k in (-1, 1)]
    x, y, z = (numpy.linalg.inv(map_T_camera) @ numpy.array(corners).T)[:3]
    u, v = focal * x / z + cx, focal * y / z + cy
    return bool((z > 0).all() and (u > 0).all() and (u < width - 1).all() and (v > 0).all() and (v < height - 1).all())


def draw_place_pose(rng, shape, distance_m, camera, map_T_camera, tries=1000):
    """A random PlacePose whose object's middle is that far from the camera and wholly in its image.

    `camera`: width, height, focal length, cx, cy [px]; `map_T_camera`: 4 x 4, optical frame.
    """
    width, height, focal, cx, cy = camera
    for _ in range(tries):
        ray = numpy.array([(rng.uniform(0, width) - cx) / focal, (rng.uniform(0, height) - cy) / focal, 1.0])
        middle_of = (map_T_camera @ numpy.append(distance_m * ray / numpy.linalg.norm(ray), 1.0))[:3]
        x, y, z = map(float, middle_of)
        if on_tray(x, y) and in_image(shape, middle_of, camera, map_T_camera):
            return PlacePose(x, y, z - SHAPES[shape].height / 2, rng.uniform(-math.pi, math.pi))
    raise NoPlace(f"no place of the tray is {distance_m} m from the camera and in its image")


def draw_other(rng, place_pose, tries=1000):
    """A random PlacePose of the same tray at some distance."""
    for _ in range(tries):
        distance, angle = rng.uniform(*OTHER_PLACE_M), rng.uniform(-math.pi, math.pi)
        x, y = place_pose.x + distance * math.cos(angle), place_pose.y + distance * math.sin(angle)
        if on_tray(x, y):
            return PlacePose(x, y, place_pose.top, rng.uniform(-math.pi, math.pi))
    raise NoPlace("no other place on the tray")


def lean(rotation):
    """Angle [rad] between the vertical and z of a 3 x 3 rotation."""
    return math.acos(max(-1.0, min(1.0, rotation[2, 2])))


def lies_on_side(rotation):
    """Smallest angle [rad] between the vertical and any axis of a 3 x 3 rotation, in either direction:
    how far a cube is from a face."""
    return math.acos(min(1.0, numpy.abs(rotation[2]).max()))


def is_held(rise_m, lift_m, from_tip_m):
    """Whether an object was lifted with the gripper."""
    return rise_m > MIN_RISE * lift_m and from_tip_m < MAX_IN_GRIPPER_M


def is_placed(shape, position, rotation, place_pose):
    """Whether an object with its body's origin at `position` stands at the PlacePose."""
    off = position - body_position(shape, place_pose)
    tilt = {"cube": lies_on_side, "cone": lean, "sphere": lambda _: 0.0}[shape](rotation)
    return (math.hypot(off[0], off[1]) < MAX_ERROR_M and abs(off[2]) < MAX_ERROR_HEIGHT_M and tilt < MAX_TILT_RAD)


def outcome(reported, true):
    """One of OUTCOMES: what the robot said against what was."""
    if reported:
        return "success" if true else "false success"
    return "false failure" if true else "reported failure"


def table(trials):
    """Lines for people. Each trial: shape, distance_m, outcome, stage, code, message, seconds."""
    lines = [f"{'shape':<8}{'distance':>9}{'success':>9}{'of':>4}{'reported':>10}{'false +':>9}{'false -':>9}"
             f"{'pick':>8}{'place':>8}"]
    groups = collections.OrderedDict()
    for trial in trials:
        groups.setdefault((trial["shape"], trial["distance_m"]), []).append(trial)
    for (shape, distance), members in groups.items():
        counts = collections.Counter(t["outcome"] for t in members)
        lines.append(f"{shape:<8}{distance:>7.1f} m{counts['success']:>9}{len(members):>4}{counts['reported failure']:>10}"
                     f"{counts['false success']:>9}{counts['false failure']:>9}"
                     f"{median(t.get('pick_s') for t in members):>8}{median(t.get('place_s') for t in members):>8}")
    for number, trial in enumerate(trials, 1):
        if trial["outcome"] != "success":
            lines.append(f"trial {number}, {trial['shape']} at {trial['distance_m']} m: {trial['outcome']} in {trial['stage']}, "
                         f"code {trial['code']}: {trial['message']}")
    return lines


def median(values):
    """Middle of the values that are there, as text."""
    there = sorted(v for v in values if v is not None)
    return f"{there[len(there) // 2]:.1f} s" if there else "--"
