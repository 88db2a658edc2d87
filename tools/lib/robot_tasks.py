"""What the robot has to do while faults come: random drives, motions of the arms, and detections, one after another."""

import dataclasses
import math
import random
import threading
import time

import numpy
import rospy

import extperfc.arm
from driven_contacts import TrueMap
from extperfc.arm import robot_state
from pose_errors import Pose, compose, error, inverse

from extperfc.srv import DetectOnce

CLEAR_M = 0.75               # of a place that the base drives to, and of the line to it
ARMS_CLEAR_M = 1.3           # of the base, for motions of the arms
NEAR_M, FAR_M = 0.8, 3.0     # of a drive
DRIVE_S, ARMS_S, LOOK_S = 60.0, 90.0, 30.0  # of real time; simulated and real time pass alike
ARRIVED_M = 0.4              # odometry drifts meanwhile
UNSEEN = ("goal_unknown", "goal_outside")  # refused rightly: the young map does not show what the true one does
REACHED = 3                  # actionlib_msgs/GoalStatus.SUCCEEDED


@dataclasses.dataclass(frozen=True)
class Outcome:
    """Of a task; times of time.monotonic(). why: of a failure."""
    kind: str
    begin_s: float
    end_s: float
    done: bool
    why: str


def base_in_odom():
    """A Pose. ArmError: odom and the base have no transform."""
    odom_T_base = robot_state.frames().matrix("odom", "base_footprint", LOOK_S)
    return Pose(odom_T_base[0, 3], odom_T_base[1, 3], math.atan2(odom_T_base[1, 0], odom_T_base[0, 0]))


def free_place(rng, true_map, here, tries=400):
    """A Pose that a straight line without obstacles leads to, of those from NEAR_M to FAR_M away; None: no line is free."""
    for _ in range(tries):
        bearing, far_m = rng.uniform(-math.pi, math.pi), rng.uniform(NEAR_M, FAR_M)
        steps = numpy.linspace(0.0, far_m, max(2, int(far_m / 0.1)))[3:]
        line = [(here.x + step * math.cos(bearing), here.y + step * math.sin(bearing)) for step in steps]
        if all(true_map.clearance_at(x, y) > CLEAR_M for x, y in line):
            return Pose(*line[-1], rng.uniform(-math.pi, math.pi))
    return None


class Tasks(threading.Thread):
    """Runs until stop(). outcomes: of all tasks that ended; present: what is done now."""

    def __init__(self, robot, seed):
        super().__init__(daemon=True)
        self.robot, self.rng, self.outcomes, self.present, self.problem = robot, random.Random(f"tasks {seed}"), [], "", ""
        self._stop_asked = threading.Event()
        info = robot.map.info
        cells = numpy.array(robot.map.data, numpy.int8).reshape(info.height, info.width)
        self.true_map = TrueMap(cells, info.resolution, info.origin.position.x, info.origin.position.y)

    def stop(self):
        self._stop_asked.set()

    def run(self):
        try:
            while not self._stop_asked.is_set():
                kind = self.rng.choice(("drive", "drive", "arms", "look"))
                self._do(kind, getattr(self, f"_{kind}"))
        except Exception as fault:  # pylint: disable=broad-except
            self.problem = f"{type(fault).__name__}: {fault}"  # ends the whole run

    def _do(self, kind, task):
        self.present, begin_s = kind, time.monotonic()
        try:
            why = task()
        except (extperfc.arm.ArmError, rospy.ROSException, rospy.ServiceException, OSError) as fault:  # OSError: no ROS master
            why = str(fault) or type(fault).__name__
        if why is not None:
            self.outcomes.append(Outcome(kind, begin_s, time.monotonic(), not why, why))
        self._stop_asked.wait(0.5)

    def _drive(self):
        """"", or why it failed; None: there is nowhere to go."""
        here = self.robot.pose()
        place = free_place(self.rng, self.true_map, here)
        if place is None:
            return None
        odom_T_world = compose(base_in_odom(), inverse(here))
        drive = self.robot.drive(compose(odom_T_world, place), DRIVE_S, 2 * DRIVE_S, frame="odom")
        if drive.text.startswith(UNSEEN):
            return None
        if drive.state != REACHED:
            return f"{drive.text or 'no reason'} (state {drive.state})"
        off_m, _ = error(self.robot.pose(), place)
        return "" if off_m < ARRIVED_M else f"reported as reached, but {off_m:.2f} m off"

    def _arms(self):
        """Both arms to the front and back; where there is no room, a plan for it."""
        here, arms = self.robot.pose(), extperfc.arm.Arm("both")
        if self.true_map.clearance_at(here.x, here.y) < ARMS_CLEAR_M:
            arms.plan("neutral", timeout=ARMS_S)
            return ""
        try:
            arms.move_to("neutral", timeout=ARMS_S)
        finally:
            self._tuck(arms)
        return ""

    def _tuck(self, arms):
        """Until it is done, for the base drives after it."""
        while not self._stop_asked.is_set():
            try:
                arms.tuck(timeout=ARMS_S)
                return
            except (extperfc.arm.ArmError, rospy.ROSException):
                self._stop_asked.wait(1.0)

    def _look(self):
        rospy.wait_for_service("detect_once", LOOK_S)
        answer = rospy.ServiceProxy("detect_once", DetectOnce)(timeout=rospy.Duration(LOOK_S / 2))
        return "" if answer.success else answer.message or "no reason"
