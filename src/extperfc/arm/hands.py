"""What a robot calls its arms: SRDF groups, tools, grippers and joints, as the arm node has them."""

import dataclasses
import time

import rospy

from extperfc.arm.connection import START, WAIT_S, join
from extperfc.arm.errors import ArmError, ClientCode
from extperfc.robot_description import RobotDescription

ALL = "both"               # names all arms of a robot; where it has one, that one
ALL_GROUP = "both_arms"    # of the SRDF, where a robot has several arms
ARM_FRAME = "base"         # link of a Baxter in which poses are meant that bring no frame
POLL_S = 0.1


@dataclasses.dataclass(frozen=True)
class Hand:
    """One arm and its gripper. joints: those from the root to the tool; empty: not known."""
    name: str
    group: str
    tip: str
    action: str
    joints: tuple = ()


class Hands:
    """All of a robot, in the order of the arm node's parameter `grippers`. frame: of poses that bring none."""

    def __init__(self, hands, frame):
        self._hands, self.frame = {hand.name: hand for hand in hands}, frame

    def __getitem__(self, name):
        return self._hands[name]

    @property
    def names(self):
        return tuple(self._hands)

    def named(self, which):
        """The names that "both" or one name means. ValueError for an unknown one."""
        if which in self._hands:
            return (which,)
        if which == ALL:
            return self.names
        choice = [*self.names, ALL] if len(self.names) > 1 else self.names
        raise ValueError(f"unknown arm {which!r}: must be {' or '.join(choice)}")

    def group(self, which):
        """The SRDF's group of these arms."""
        names = self.named(which)
        return self._hands[names[0]].group if len(names) == 1 else ALL_GROUP

    def full_name(self, joint, which):
        """A joint's name with its side, "s0" of the left arm is "left_s0". ValueError where several arms have such a joint.
        What is a joint of none of the arms stays as it is: the node knows the robot's other joints."""
        if any(joint in hand.joints for hand in self._hands.values()):
            return joint
        found = [f"{name}_{joint}" for name in self.named(which) if f"{name}_{joint}" in self._hands[name].joints]
        if len(found) > 1:
            raise ValueError(f"joint {joint}: of which arm? Write {' or '.join(found)}")
        return found[0] if found else joint


BAXTER = Hands([Hand(side, f"{side}_arm", f"{side}_gripper", f"robot/end_effector/{side}_gripper/gripper_action",
                     tuple(f"{side}_{joint}" for joint in ("s0", "s1", "e0", "e1", "w0", "w1", "w2")))
                for side in ("left", "right")], ARM_FRAME)
_known = {}


def of(namespace=""):
    """Those of the arm node in a namespace, from its parameters; Baxter's as long as there are none."""
    if namespace not in _known:
        grippers = rospy.get_param(join(namespace, "arm/grippers"), None)
        if not grippers:
            return BAXTER
        _known[namespace] = from_parameters(grippers, _description(namespace))
    return _known[namespace]


def _description(namespace):
    """The URDF's text in this namespace or one above it, where the arm node looks, too; "": it is nowhere."""
    levels = rospy.resolve_name(join(namespace, "robot_description")).split("/")[1:-1]
    names = ["/".join(["", *levels[:count], "robot_description"]) for count in range(len(levels), -1, -1)]
    return next((rospy.get_param(name) for name in names if rospy.has_param(name)), "")


def wait_for(which, namespace="", wait_s=WAIT_S):
    """Until it is known that the robot has an arm of this name: one that no Baxter has waits for the node's parameters.
    ValueError, ArmError."""
    deadline = time.monotonic() + wait_s
    while of(namespace) is BAXTER and which not in (*BAXTER.names, ALL):
        if time.monotonic() > deadline:
            raise ArmError(ClientCode.NOT_RUNNING, f"no parameter {rospy.resolve_name(join(namespace, 'arm/grippers'))} that"
                                                   f" has an arm {which!r}: {START}")
        time.sleep(POLL_S)
    of(namespace).named(which)


def from_parameters(grippers, urdf):
    """Of the arm node's parameter `grippers` and the text of the robot's description; "": its joints are not known."""
    robot = RobotDescription(urdf) if urdf else None
    made = [Hand(one["name"], one["group"], one["tip"], one["action"],
                 tuple(robot.joints_above(one["tip"])) if robot else ()) for one in grippers]
    if robot is None:
        return Hands(made, ARM_FRAME)
    return Hands(made, ARM_FRAME if ARM_FRAME in robot.links else robot.root)
