"""Goals that people drag: the interactive marker, and what is to be said of the pose it is at."""

import collections
import math
import threading
import time

from geometry_msgs.msg import Quaternion, Vector3
from visualization_msgs.msg import InteractiveMarker, InteractiveMarkerControl, Marker

from extperfc.arm.errors import ArmError
from extperfc.arm_markers.ghost import marker

GOOD, BAD, FAR = (0.25, 0.85, 0.35, 0.55), (0.95, 0.15, 0.1, 0.6), (0.95, 0.15, 0.1, 0.25)
GRAB = {"left": (0.2, 0.55, 1.0, 0.35), "right": (1.0, 0.6, 0.1, 0.35)}
SIZE_M = 0.28

# joints: {name: radians} to show, or None; good: this pose can be had; text: why not; rgba: of the ghost.
View = collections.namedtuple("View", "joints good text rgba")


def view_of(solve, last_joints):
    """What to show of a goal. solve(avoid_collisions) -> extperfc/SolveArmIkResponse.

    A pose that is within reach but collides is shown as it would be; one out of reach as the arm was last.
    """
    try:
        answer = solve(True)
        if answer.code == 0:
            return View(dict(zip(answer.joints.name, answer.joints.position)), True, "", GOOD)
        colliding = solve(False)
        if colliding.code == 0:
            return View(dict(zip(colliding.joints.name, colliding.joints.position)), False, answer.message, BAD)
        return View(last_joints, False, colliding.message, FAR)
    except ArmError as error:
        return View(last_joints, False, error.message, FAR)


class Newest:
    """Calls `work` with the latest item, in a separate thread and at most at a rate [Hz]; items that arrived in between
    are skipped."""

    def __init__(self, work, rate_hz):
        self._work, self._period_s = work, 1.0 / rate_hz
        self._waiting, self._changed, self._ended = [], threading.Condition(), False
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._thread.start()

    def put(self, item):
        with self._changed:
            self._waiting[:] = [item]
            self._changed.notify_all()

    def end(self):
        """Waits for the work at hand."""
        with self._changed:
            self._ended = True
            self._changed.notify_all()
        self._thread.join()

    def _run(self):
        while True:
            with self._changed:
                self._changed.wait_for(lambda: self._waiting or self._ended)
                if self._ended:
                    return
                item = self._waiting.pop()
            began = time.monotonic()
            self._work(item)
            with self._changed:
                self._changed.wait_for(lambda: self._ended, max(0.0, began + self._period_s - time.monotonic()))


def _control(name, mode, orientation=None):
    made = InteractiveMarkerControl(name=name, interaction_mode=mode)
    made.orientation = orientation if orientation is not None else Quaternion(w=1.0)
    return made


def _axis_controls():
    """Along and about each axis; a control acts along the x axis of its orientation."""
    half = math.sqrt(0.5)
    for axis, q in (("x", (0, 0, 0, 1)), ("y", (0, 0, half, half)), ("z", (0, half, 0, half))):
        yield _control(f"move_{axis}", InteractiveMarkerControl.MOVE_AXIS, Quaternion(*q))
        yield _control(f"turn_{axis}", InteractiveMarkerControl.ROTATE_AXIS, Quaternion(*q))


def goal_marker(side, pose_stamped):
    """The visualization_msgs/InteractiveMarker of one arm."""
    made = InteractiveMarker(name=side, description="", scale=SIZE_M, pose=pose_stamped.pose)
    made.header.frame_id = pose_stamped.header.frame_id  # stamp 0: it goes where its frame goes
    made.controls = list(_axis_controls())
    grab = _control("grab", InteractiveMarkerControl.MOVE_ROTATE_3D)
    ball = marker("", "", 0, Marker.SPHERE, GRAB[side], Vector3(*(0.3 * SIZE_M,) * 3))
    ball.header.frame_id, ball.frame_locked = "", False
    grab.markers, grab.always_visible = [ball], True
    made.controls.append(grab)
    return made
