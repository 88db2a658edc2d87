"""Leaves that move the arms."""

import math

import numpy
import rospy

from extperfc.arm import Arm, ArmError, robot_state
from extperfc.robot_description import rotation_about
from extperfc.tasks.blackboard import Key, read, write
from extperfc.tasks.find import DEPTH_FRAME
from extperfc.tasks.leaf import ActionLeaf, Leaf

SERVER_WAIT_S = 30.0  # of real time, for the arm node to come up
SHOW_TILT_RAD = 0.6          # of a gripper that shows something, from how it points
SIDEWAYS_RAD = 1.2           # of the approach direction from the view
BESIDE_RAD = (0.3, 0.4)      # about the tool's x and z: with more, a finger comes before the object

_arms = {}


def _arm(side):
    """One client per process and side."""
    if side not in _arms:
        _arms[side] = Arm(side, wait_s=SERVER_WAIT_S)
    return _arms[side]


def scene():
    """The arm node's extperfc.arm Scene."""
    return _arm("both").scene


class MoveArm(ActionLeaf):
    """Moves "left", "right" or "both" to a goal of extperfc.arm.Arm.move_to, or to what a Key holds; with its options."""

    def __init__(self, side, goal, name=None, **options):
        super().__init__(name or f"move {side} arm" + ("s" if side == "both" else ""))
        self.side, self.goal, self.options = side, goal, options

    def motion(self):
        return _arm(read(self.side)).move_to(read(self.goal), wait=False, **self.options)


class ArmsTo(Leaf):
    """Moves all arms to a goal as MoveArm does. Where they do not come there together, beside a wall say, each one that can
    goes there alone, and one is enough."""

    def __init__(self, goal, name=None):
        super().__init__(name or "arms, as many as can")
        self.goal = goal

    def begin(self):
        self._why, self._came, self._alone = "", False, None
        self._motion = self._sent("both")

    def step(self):
        if not self._motion.done:
            return None
        try:
            self._motion.result()
            if self._alone is None:
                return True
            self._came = True
        except ArmError as error:
            self._why = self._why or str(error)
        if self._alone is None:
            sides = _arm("both").sides
            self._alone = list(sides) if len(sides) > 1 else []
        if self._alone:
            self._motion = self._sent(self._alone.pop(0))
            return None
        if not self._came:
            raise ValueError(self._why)
        return True

    def _sent(self, side):
        return _arm(side).move_to(read(self.goal), wait=False)


class MoveGrippers(Leaf):
    """Opens or closes the grippers of "left", "right" or "both". Blocks the tree for up to `timeout_s` of real time each."""

    def __init__(self, side, open, timeout_s=10.0, name=None):  # pylint: disable=redefined-builtin
        super().__init__(name or f"{'open' if open else 'close'} {side} gripper" + ("s" if side == "both" else ""))
        self.side, self.opens, self.timeout_s = side, open, timeout_s

    def step(self):
        arm = _arm(read(self.side))
        (arm.open if self.opens else arm.close)(timeout=self.timeout_s)
        return True


class InScene(Leaf):
    """Waits until the arm node's scene has an object with this name or label, which its node `objects` adds from detections."""

    PERIOD_S = 0.2  # of ROS time, between requests to the node

    def __init__(self, label, timeout_s=10.0, name=None):
        super().__init__(name or f"{label} in the scene")
        self.label, self.timeout_s = label, timeout_s

    def begin(self):
        self._begin, self._asked = rospy.Time.now(), rospy.Time(0)

    def step(self):
        now = rospy.Time.now()
        if now < self._asked + rospy.Duration(self.PERIOD_S):
            return None
        self._asked = now
        label, objects = read(self.label), scene().objects
        if any(label in (name, one.label) for name, one in objects.items()):
            return True
        if now > self._begin + rospy.Duration(self.timeout_s):
            raise ValueError(f"the arm node's scene has no {label} after {self.timeout_s:g} s, but {', '.join(sorted(objects)) or 'nothing'}")
        return None


class Pick(ActionLeaf):
    """Picks an object by its name in the arm node's scene, or its label. Writes the extperfc/PickResult under `key`, and
    under `<key>_from` where the object stood (PoseStamped, None: not known).

    place_at: a pose or a list of them, or a Key: see Arm.pick.
    """

    def __init__(self, what, key="held", side="both", lift=0.0, place_at=None, frame=None, name=None):
        super().__init__(name or f"pick the {what}")
        self.what, self.key, self.side, self.lift, self.place_at, self.frame = what, key, side, lift, place_at, frame

    def motion(self):
        arm = _arm(self.side)
        self._before = {name: one.pose for name, one in arm.scene.objects.items()}
        return arm.pick(read(self.what), lift=self.lift, place_at=read(self.place_at), frame=self.frame, wait=False)

    def succeeded(self, result):
        write(self.key, result)
        write(f"{self.key}_from", self._before.get(result.object))


class StillHeld(Leaf):
    """Fails when the picked object is in no gripper any more: the arm node's scene says so, or the gripper, which closes again
    and moves only when it is empty. What slipped out leaves the scene, for where it lies is not known. Blocks the tree for up to
    `timeout_s` of real time."""

    def __init__(self, held="held", timeout_s=10.0, name=None):
        super().__init__(name or "it is still held")
        self.held, self.timeout_s = held, timeout_s

    def step(self):
        picked = read(Key(self.held))
        one = scene().objects.get(picked.object)
        if one is None or not one.link:
            raise ValueError(f"no gripper holds {picked.object} any more")
        if not _arm(picked.arm).close(timeout=self.timeout_s):
            scene().remove(picked.object)
            raise ValueError(f"{picked.object} slipped out of the {picked.arm} gripper")
        return True


class Place(ActionLeaf):
    """Places what a gripper holds at a pose, or at that of a Key. any_yaw: any rotation about the vertical is accepted."""

    def __init__(self, pose, any_yaw=True, frame=None, name=None):
        super().__init__(name or "place")
        self.pose, self.any_yaw, self.frame = pose, any_yaw, frame

    def motion(self):
        pose = read(self.pose)
        if pose is None:
            raise ValueError("the place is not known")
        return _arm("both").place(pose, any_yaw=self.any_yaw, frame=self.frame, wait=False)


class Show(ActionLeaf):
    """Holds the picked object before the camera, at a distance [m] on its axis; the gripper points about as it does.

    between: the fingers come to the left and right of the object as the camera sees it, so that they do not hide it, and
    the gripper tilts by tilt_rad at most, so that an object that stood upright stays about so; otherwise the gripper may
    have any rotation about its approach direction. slack_m: accepted distance from the point along each axis. A point that
    the arm does not reach is a failure.
    """

    def __init__(self, held="held", distance_m=0.4, between=True, tilt_rad=0.3, slack_m=0.03, frame=DEPTH_FRAME, name=None):
        super().__init__(name or "show")
        self.held, self.distance_m, self.between, self.tilt_rad = held, distance_m, between, tilt_rad
        self.slack_m, self.frame = slack_m, frame

    def motion(self):
        arm = _arm(read(Key(self.held)).arm)
        frames = robot_state.frames()
        base_T_camera = frames.matrix(arm.hands.frame, self.frame, SERVER_WAIT_S)
        base_T_tool = frames.matrix(arm.hands.frame, arm.hands[arm.side].tip, SERVER_WAIT_S)
        base_T_tool[:3, 3] = (base_T_camera @ (0.0, 0.0, read(self.distance_m), 1.0))[:3]
        tolerance = (SHOW_TILT_RAD, SHOW_TILT_RAD, math.pi)
        if self.between:
            base_T_tool[:3, :3] = between_fingers(base_T_tool[:3, :3], base_T_camera[:3, 2])
            tolerance = (BESIDE_RAD[0], self.tilt_rad, BESIDE_RAD[1])
        return arm.move_to(base_T_tool, wait=False, position_tolerance=self.slack_m, orientation_tolerance=tolerance)


def between_fingers(rotation, view):
    """A tool's 3x3 rotation, changed so that a camera which looks along `view` sees what the tool holds: the direction in which
    the fingers close (y) is perpendicular to the view, and the approach direction (z) is at least SIDEWAYS_RAD off it, for a
    tool that comes from the camera's side hides what it holds. Otherwise z stays, and y is the nearer one of both."""
    z = rotation[:, 2]
    y = numpy.cross(z, view)
    if numpy.linalg.norm(y) < 0.1:  # along the view: the fingers stay about where they are
        y = rotation[:, 1] - view * (view @ rotation[:, 1])
    y /= numpy.linalg.norm(y)
    away = SIDEWAYS_RAD - math.acos(numpy.clip(z @ view, -1.0, 1.0))
    if away > 0:
        z = rotation_about(y, -away) @ z
    z = z - y * (y @ z)
    z /= numpy.linalg.norm(z)
    y *= numpy.sign(y @ rotation[:, 1]) or 1.0
    return numpy.column_stack([numpy.cross(y, z), y, z])
