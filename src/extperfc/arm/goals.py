"""Conversion of convenient Python values to messages. Without communication."""

import collections.abc
import dataclasses
import numbers

import geometry_msgs.msg
import numpy
import sensor_msgs.msg

import extperfc.msg
from extperfc import robot_description as rd
from extperfc.arm.hands import ALL, BAXTER


def _finite(values, what):
    array = numpy.asarray(values, float)
    if not numpy.all(numpy.isfinite(array)):
        raise ValueError(f"{what}: {values} is not finite")
    return array


def pose_of_matrix(target_T_source):
    """geometry_msgs/Pose of a 4x4 transform."""
    array = _finite(target_T_source, "transform")
    rotation = array[:3, :3]
    if (array.shape != (4, 4) or numpy.abs(rotation @ rotation.T - numpy.eye(3)).max() > 1e-3
            or numpy.linalg.det(rotation) < 0):
        raise ValueError("the array is not a 4x4 transform with a rotation")
    pose = geometry_msgs.msg.Pose()
    pose.position.x, pose.position.y, pose.position.z = (float(v) for v in array[:3, 3])
    q = pose.orientation
    q.x, q.y, q.z, q.w = rd.quaternion_of_rotation(rotation)
    return pose


def matrix_of_pose(pose):
    """4x4 transform of a Pose or a PoseStamped, whose frame is left out."""
    pose = getattr(pose, "pose", pose)
    p, q = pose.position, pose.orientation
    return rd.transform(_finite((p.x, p.y, p.z), "position"), rd.rotation_of_quaternion(q.x, q.y, q.z, q.w))


def _is_numbers(value):
    return (not isinstance(value, (str, collections.abc.Mapping)) and hasattr(value, "__len__")
            and all(isinstance(v, numbers.Real) for v in value))


def is_pose(value):
    """Is this one pose, in any form that pose_stamped accepts?"""
    return (isinstance(value, (geometry_msgs.msg.Pose, geometry_msgs.msg.PoseStamped))
            or getattr(value, "shape", None) == (4, 4) or (_is_numbers(value) and len(value) in (3, 6, 7)))


def pose_stamped(value, frame=BAXTER.frame, rotation=None):
    """A geometry_msgs/PoseStamped with stamp 0, which means now.

    value: a PoseStamped (its own frame counts), a Pose, a 4x4 array, (x, y, z), (x, y, z, roll, pitch, yaw) or
    (x, y, z, qx, qy, qz, qw) in metres and radians. rotation: 3x3, for three numbers; None: identity.
    Raises ValueError.
    """
    if isinstance(value, geometry_msgs.msg.PoseStamped):
        return value
    stamped = geometry_msgs.msg.PoseStamped()
    stamped.header.frame_id = frame
    if isinstance(value, geometry_msgs.msg.Pose):
        stamped.pose = value
    elif getattr(value, "shape", None) == (4, 4):
        stamped.pose = pose_of_matrix(value)
    elif is_pose(value):
        array = _finite(value, "pose")
        rotation_matrix = numpy.eye(3) if rotation is None else rotation
        if len(array) == 6:
            rotation_matrix = rd.rotation_of_rpy(*array[3:])
        elif len(array) == 7:
            rotation_matrix = rd.rotation_of_quaternion(*array[3:])
        stamped.pose = pose_of_matrix(rd.transform(array[:3], rotation_matrix))
    else:
        raise ValueError(f"{value!r} is not a pose: give a Pose, a PoseStamped, a 4x4 array, or 3, 6 or 7 numbers")
    return stamped


def joint_state(values, side=ALL, hands=BAXTER):
    """sensor_msgs/JointState of {name: radians}. Of one arm, names may leave out the side: s0 is left_s0."""
    if isinstance(values, sensor_msgs.msg.JointState):
        return values
    message = sensor_msgs.msg.JointState()
    for name, value in values.items():
        if not isinstance(value, numbers.Real):
            raise ValueError(f"joint {name}: {value!r} is not a number of radians")
        message.name.append(hands.full_name(name, side))
        message.position.append(float(_finite(value, name)))
    if len(set(message.name)) != len(message.name):
        raise ValueError(f"a joint is named twice: {', '.join(sorted(message.name))}")
    return message


def _vector(values):
    """geometry_msgs/Vector3 of three numbers or one for all."""
    array = _finite(values, "vector")
    if array.shape not in ((), (3,)):
        raise ValueError(f"{values!r} should be one number or three")
    return geometry_msgs.msg.Vector3(*(float(v) for v in numpy.broadcast_to(array, 3)))


def tool_goal(tip, pose, position_tolerance=0.0, orientation_tolerance=0.0):
    """extperfc/ToolGoal of a PoseStamped; tolerances [m], [rad]: one number or one for each axis of the pose, 0: exact."""
    return extperfc.msg.ToolGoal(tip, pose, _vector(position_tolerance), _vector(orientation_tolerance))


def _constraint(kind, link="", axis=(0, 0, 0), frame="", other=""):
    return extperfc.msg.ToolConstraint(kind, link, other, frame, _vector(axis))


def _direction(axis):
    if _finite(axis, "axis").shape != (3,) or not numpy.linalg.norm(axis) > 0:
        raise ValueError(f"{axis!r} is not a direction")
    return axis


def keep_axis(axis, link=""):
    """The axis of the tool's own frame points as at the start: a cup stays level. Arm.keep_level finds the axis."""
    return _constraint(extperfc.msg.ToolConstraint.KEEP_AXIS, link, _direction(axis))


def keep_plane(normal, frame="", link=""):
    """The tool's origin stays in the plane through its start with this normal in `frame` (empty: the robot's root)."""
    return _constraint(extperfc.msg.ToolConstraint.KEEP_PLANE, link, _direction(normal), frame)


def keep_line(direction, frame="", link=""):
    """The tool's origin stays on the line through its start along this direction of `frame`."""
    return _constraint(extperfc.msg.ToolConstraint.KEEP_LINE, link, _direction(direction), frame)


def keep_orientation(link=""):
    """The tool keeps the orientation of the start."""
    return _constraint(extperfc.msg.ToolConstraint.KEEP_ORIENTATION, link)


def keep_relative(link=BAXTER["left"].tip, other=BAXTER["right"].tip):
    """Both tools keep their relative pose: both grippers hold one object."""
    return _constraint(extperfc.msg.ToolConstraint.KEEP_RELATIVE, link, other=other)


@dataclasses.dataclass
class MotionOptions:
    """Options of a motion. 0 means: the parameter of the node."""
    frame: str = ""                         # of poses without a frame_id; "": that of the robot's arms, base of a Baxter
    constraints: object = ()                # one of keep_...(), or several
    start: object = None                    # for plan: {joint: radians}; joints not named are where they are
    position_tolerance: object = 0.0        # [m], see tool_goal
    orientation_tolerance: object = 0.0     # [rad]
    planning_time: float = 0.0              # [s]
    improve: bool = False                   # use the whole planning time and return the shortest path
    planner: str = ""
    seed: int = 0
    velocity_scale: float = 0.0             # of the robot's limits, (0, 1]
    acceleration_scale: float = 0.0         # the same
    minimum_fraction: float = 0.0           # linear: a smaller planned fraction is a failure; 0: the whole path


def _flat(constraints):
    if isinstance(constraints, extperfc.msg.ToolConstraint):
        return [constraints]
    return [one for some in constraints for one in _flat(some)]


def _of_sides(goal, hands):
    return isinstance(goal, collections.abc.Mapping) and bool(goal) and set(goal) <= set(hands.names)


def _tool_goals(side, goal, options, rotation_now, hands):
    """Tool goals of one arm: of a pose or of a list of poses."""
    poses = [goal] if is_pose(goal) else list(goal)
    if not poses:
        raise ValueError("the list of goals is empty")
    goals, frame = [], options.frame or hands.frame
    for pose in poses:
        rotation = rotation_now(side, frame) if _is_numbers(pose) and len(pose) == 3 else None
        goals.append(tool_goal(hands[side].tip, pose_stamped(pose, frame, rotation), options.position_tolerance,
                               options.orientation_tolerance))
    return goals


def _set_goal(request, side, goal, options, rotation_now, hands):
    if isinstance(goal, str):
        request.named_state = goal
    elif _of_sides(goal, hands):
        for one, part in goal.items():
            if side not in (ALL, one):
                raise ValueError(f"the {side} arm has no goal for {one}")
            if isinstance(part, (collections.abc.Mapping, sensor_msgs.msg.JointState)):
                joints = joint_state(part, one, hands)
                request.joint_goal.name += list(joints.name)
                request.joint_goal.position += list(joints.position)
            elif isinstance(part, str):
                raise ValueError("named states count for the whole group: give one name instead of one for each arm")
            else:
                request.tool_goals += _tool_goals(one, part, options, rotation_now, hands)
        if request.tool_goals and request.joint_goal.name:
            raise ValueError("one arm has a pose and the other joint values: give two of a kind")
    elif isinstance(goal, (collections.abc.Mapping, sensor_msgs.msg.JointState)):
        request.joint_goal = joint_state(goal, side, hands)
        if not request.joint_goal.name:
            raise ValueError("a goal without joints")
    elif side == ALL:
        raise ValueError("poses for both arms: give {'left': pose, 'right': pose}")
    elif is_pose(goal) or (isinstance(goal, (list, tuple)) and all(is_pose(g) for g in goal)):
        request.tool_goals = _tool_goals(side, goal, options, rotation_now, hands)
    else:
        raise ValueError(f"{goal!r} is not a goal: give a state's name, {{joint: radians}}, a pose or a list of poses")


def motion_request(side, goal, options, linear, rotation_now, hands=BAXTER):
    """extperfc/ArmRequest. rotation_now(side, frame): 3x3 rotation of the tool at present. Raises ValueError."""
    request = extperfc.msg.ArmRequest(group=hands.group(side))
    request.motion = request.LINEAR if linear else request.FREE
    _set_goal(request, side, goal, options, rotation_now, hands)
    links = [tool.link for tool in request.tool_goals]
    if len(set(links)) != len(links) and not linear:
        raise ValueError("several poses for one arm: only linear=True goes from one to the next")
    request.constraints = _flat(options.constraints)
    if options.start is not None:
        request.start = joint_state(options.start, side, hands)
    for name in ("planning_time", "velocity_scale", "acceleration_scale", "minimum_fraction"):
        value = float(_finite(getattr(options, name), name))
        if value < 0 or (name != "planning_time" and value > 1):
            raise ValueError(f"{name}: {value} is out of its range")
        setattr(request, name, value)
    request.improve, request.planner, request.seed = bool(options.improve), options.planner, int(options.seed)
    return request
