"""Leaves that find objects in a map, and places before them."""

import math

import nav_msgs.msg
import nav_msgs.srv
import numpy
import rospy

from extperfc.arm import robot_state
from extperfc.arm.connection import Service
from extperfc.arm.errors import ArmError
from extperfc.arm.goals import pose_stamped
from extperfc.tasks.base_leaves import START, GoTo, planar_pose
from extperfc.tasks.blackboard import read, write
from extperfc.tasks.find import Find, Found
from extperfc.tasks.leaf import Leaf
from extperfc.tasks.views import Camera, Grid, viewpoints

BASE_FRAME = "base_footprint"
WAIT_S = 10.0       # of real time, for a map or a transform
LOOK_S = 1.5        # of ROS time at each pose, after the base has stopped
APPROACH_YAWS = 24  # directions from which an object is approached


def base_pose(frame):
    """(x, y, yaw) of the base."""
    frame_T_base = robot_state.frames().matrix(frame, BASE_FRAME, WAIT_S)
    return float(frame_T_base[0, 3]), float(frame_T_base[1, 3]), math.atan2(frame_T_base[1, 0], frame_T_base[0, 0])


class Search(Leaf):
    """Drives from view to view until an object of a class is found as by Find, with its arguments, and the base has stopped.

    The views show the camera all obstacles of the map (topic `map`) that border on free space: what stands on tables, too. A
    view to which the navigator has no plan is left out. Fails when all were seen.
    """

    def __init__(self, label, key, frame="map", camera=Camera(), name=None, **finding):
        super().__init__(name or f"search for the {label}")
        self.label, self.frame, self.camera = label, frame, camera
        self._find = Find(label, key, frame=frame, timeout_s=math.inf, **finding)
        self._plans = Plans(frame)

    def setup(self, **_):
        self._find.setup()

    def begin(self):
        self._find.begin()
        self._motion, self._look_until, self._number, self._failed = None, None, 0, 0
        self._views = viewpoints(newest_map(), base_pose(self.frame)[:2], self.camera)

    def step(self):
        if self._find.step():
            return True
        if self._motion is not None and not self._motion.done:
            return None
        if self._motion is not None:
            self._arrive()
        if self._look_until is not None and rospy.Time.now() < self._look_until:
            return None
        if self._number == len(self._views):
            raise ValueError(f"no {self.label} at {len(self._views)} views, of which {self._failed} could not be reached")
        self._look_until = None
        view, self._number = self._views[self._number], self._number + 1
        self.feedback_message = f"view {self._number} of {len(self._views)}"
        if self._plans.length_m(base_pose(self.frame), view) is None:
            self._failed += 1
        else:
            self._motion = GoTo(view, self.frame).motion()
        return None

    def _arrive(self):
        try:
            self._motion.result()
            self._look_until = rospy.Time.now() + rospy.Duration(LOOK_S)
        except ArmError as error:
            self._failed += 1
            rospy.logwarn("view %d of %d: %s", self._number, len(self._views), error)
        self._motion = None


class Plans:
    """Plans of the navigator, without driving."""

    def __init__(self, frame):
        self.frame = frame
        self._service = Service("", "move_base/make_plan", nav_msgs.srv.GetPlan, WAIT_S)

    def length_m(self, start, goal):
        """Of the plan from one pose (x, y, yaw) to another; None without a plan."""
        start, goal = (planar_pose(one, self.frame) for one in (start, goal))
        points = [(one.pose.position.x, one.pose.position.y)
                  for one in self._service(start=start, goal=goal, tolerance=0.0).plan.poses]
        return float(numpy.linalg.norm(numpy.diff(points, axis=0), axis=1).sum()) if points else None


def newest_map():
    """The Grid on the topic `map`. Raises ValueError without one."""
    try:
        message = rospy.wait_for_message("map", nav_msgs.msg.OccupancyGrid, WAIT_S)
    except rospy.ROSException:
        raise ValueError(f"no map on {rospy.resolve_name('map')} within {WAIT_S:g} s: is the mapper running?") from None
    cells = numpy.array(message.data, numpy.int8).reshape(message.info.height, message.info.width)
    origin = message.info.origin.position
    return Grid(cells, message.info.resolution, (origin.x, origin.y))


class Approach(Leaf):
    """Drives to a pose from which the arms reach a point: the base looks at it, at one of `standoffs_m` from its middle.

    point: (x, y, z) in `frame`, a Found, or a Key. Of the poses to which the navigator has a plan the one with the shortest
    is taken; when the robot does not arrive there, the next, `attempts` in all.
    """

    def __init__(self, point, frame="map", standoffs_m=(0.72, 0.78, 0.85), attempts=3, name=None):
        super().__init__(name or "approach")
        self.point, self.frame, self.standoffs_m, self.attempts = point, frame, standoffs_m, attempts
        self._plans = Plans(frame)

    def begin(self):
        point = read(self.point)
        if isinstance(point, Found):
            p = point.pose.pose.position
            point = (p.x, p.y, p.z)
        here = base_pose(self.frame)
        self._left = [(self._plans.length_m(here, pose), pose) for pose in poses_before(point, self.standoffs_m)]
        self._left = sorted(one for one in self._left if one[0] is not None)[:self.attempts]
        if not self._left:
            raise ValueError(f"the navigator has no plan to a place before ({point[0]:.2f}, {point[1]:.2f})")
        self._motion, self._why = None, ""

    def step(self):
        if self._motion is None:
            if not self._left:
                raise ValueError(self._why)
            self._motion = GoTo(self._left.pop(0)[1], self.frame).motion()
        if not self._motion.done:
            return None
        try:
            self._motion.result()
            return True
        except ArmError as error:
            self._why, self._motion = str(error), None
            return None


def poses_before(point, standoffs_m):
    """Poses (x, y, yaw) that look at a point from all sides, the nearest standoff first."""
    return [(point[0] - standoff * math.cos(yaw), point[1] - standoff * math.sin(yaw), yaw)
            for standoff in standoffs_m for yaw in (2 * math.pi * i / APPROACH_YAWS for i in range(APPROACH_YAWS))]
