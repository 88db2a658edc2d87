"""Parts of trees that many tasks need."""

import py_trees

from extperfc.tasks.arm_leaves import ArmsTo, InScene, MoveArm, Pick, Place, Show, StillHeld
from extperfc.tasks.around import SeeAround
from extperfc.tasks.blackboard import Key
from extperfc.tasks.find import Find
from extperfc.tasks.leaf import GiveUp, Say
from extperfc.tasks.search import Approach
from extperfc.tasks.support import SeeSupport


CLEAR_M = 0.9  # from the base's middle to what stands around it: elbows stick out so far


def _sequence(name, children):
    return py_trees.composites.Sequence(name, memory=True, children=children)


def _selector(name, children):
    return py_trees.composites.Selector(name, memory=True, children=children)


def pick_up(label, found="found", held="held", place_at=None, frame=None, attempts=2, start="neutral", **finding):
    """The arms go where they hide nothing from the camera (a state of the SRDF), the object is found and picked; a failure
    begins again, so many times in all. Beside a wall it is enough when one arm goes there, and where none can they stay. Writes a
    Found and a PickResult. finding: further arguments of Find."""
    return py_trees.decorators.Retry(f"{attempts} attempts", _sequence(f"pick up the {label}", [
        _selector("arms out of the image", [ArmsTo(start, name=f"arms to {start}"), Say("the arms stay where they are")]),
        Find(label, found, **finding),
        InScene(label),
        Pick(label, key=held, place_at=place_at, frame=frame),
    ]), num_failures=attempts)


def show(distance_m, held="held"):
    """Shows the held object to the camera, with no finger before it where the arm can."""
    return _selector("show", [
        Show(held, distance_m, name="show upright between the fingers"),
        Show(held, distance_m, tilt_rad=1.0, name="show tilted between the fingers"),
        Show(held, distance_m, between=False, name="show somehow")])


def put_down(pose, held="held", frame=None):
    """Places the held object. Where that fails it is put back where it was picked, and the tree fails: the object was not
    lost, but is not where it was wanted."""
    put_back = _sequence("put back", [
        Say("cannot be put down there: putting it back where it was"),
        Place(Key(f"{held}_from"), name="place where it was"),
        GiveUp("it is where it was before"),
    ])
    return _selector("put down", [Place(pose, frame=frame), put_back])


def bring(to, held="held", frame="map", attempts=5):
    """Drives the held object to a point (x, y, z) of its middle and places it there, seen from up to so many places. What is lost
    while the arms make room for the drive is noticed before it, where it lies."""
    return py_trees.decorators.Retry(f"{attempts} attempts", _sequence("bring it", [
        StillHeld(held),
        carry(held),
        StillHeld(held, name="still held for the drive"),
        Approach(to, frame, clear_m=CLEAR_M),
        SeeAround(frame),
        SeeSupport(to, frame),
        Place((*to, 0.0, 0.0, 0.0), frame=frame),
    ]), num_failures=attempts)


def carry(held="held"):
    """Brings the arms, of which one holds something, near to the body, as for driving: the first pose that can be reached. Without
    one they stay: the base knows how far they reach, and elsewhere is more room."""
    arm = Key(held, "arm")
    return _selector("carry", [MoveArm("both", "tuck", name="tuck"), MoveArm(arm, "tuck", name="tuck what holds it"),
                               MoveArm(arm, "neutral", name="one arm to neutral"), Say("the arms stay where they are")])
