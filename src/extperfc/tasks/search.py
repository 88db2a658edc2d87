"""Leaves that find objects in a map, and places before them."""

import math
import threading

import nav_msgs.msg
import nav_msgs.srv
import numpy
import rospy
import sensor_msgs.msg

from extperfc.arm import robot_state
from extperfc.arm.connection import Service
from extperfc.arm.errors import ArmError
from extperfc.tasks.base_leaves import GoTo, planar_pose
from extperfc.tasks.blackboard import Key, read
from extperfc.tasks.find import Find, point_of
from extperfc.tasks.leaf import Leaf
from extperfc.tasks.solids import Solids
from extperfc.tasks.tops import Tops
from extperfc.tasks.views import SQUARE_M, Camera, Grid, Views, around

BASE_FRAME = "base_footprint"
WAIT_S = 10.0       # of real time, for a map or a transform
LOOK_S = 1.0        # of ROS time at each pose, after the base has stopped, at least
LOOK_IMAGES = 8     # for the detector at each pose; with fewer a slow computer misses what is there
MAX_LOOK_S = 10.0   # a detector that is silent for so long is not waited for
AGAIN_S = 6.0       # of ROS time, for a look from near
NEAR_PLACES = 2     # to look from, at most: a detector that misses an object from one may see it from the other
NEAR_M = 0.2        # detections as near to each other are of one object
CLOUD_S = 1.0       # of ROS time, between clouds that are used
ROBOT_M = 0.9       # from the lidar: what is nearer may be the robot
TRANSFORM_S = 0.3   # of real time, that a cloud waits for its place in the map
FARTHER_COSTS = 5.0  # metres of a drive that are as bad as one metre more from what shall be reached
AGAIN_COSTS = 2.0    # of a pose where the robot stood for the same point before, or near it, in metres of a drive
AGAIN_M = 0.3        # from such a pose: near it
NARROW_COSTS = 5.0   # metres of a drive that are as bad as one metre less of clear_m beside the robot
AHEAD_RAD = 1.0      # from where a robot looks: what is there is before it, not beside it
APPROACH_YAWS = 24  # directions from which an object is approached


def base_pose(frame):
    """(x, y, yaw) of the base."""
    frame_T_base = robot_state.frames().matrix(frame, BASE_FRAME, WAIT_S)
    return float(frame_T_base[0, 3]), float(frame_T_base[1, 3]), math.atan2(frame_T_base[1, 0], frame_T_base[0, 0])


class Search(Leaf):
    """Drives from view to view until an object of a class is found as by Find, with its arguments.

    The views show the camera the obstacles of the map (topic `map`) that border on free space, and the tables that the lidar
    (topic `velodyne_points`) has seen since setup(); tables first. A view to which the navigator has no plan is left out.
    What was found is looked at again from where the arms would reach it (Approach), and then from another such place: where it is
    not found there, with a score of at least `min_score`, the search goes on. from_near=False: once is enough. Fails when nothing
    is left to look at, or after `max_views`.
    """

    def __init__(self, label, key, frame="map", camera=Camera(), from_near=True, min_score=0.5, max_views=200, name=None,
                 **finding):
        super().__init__(name or f"search for the {label}")
        self.label, self.frame, self.camera, self.from_near, self.max_views = label, frame, camera, from_near, max_views
        finding = {"near_m": NEAR_M, "frame": frame, **finding}
        self._find = Find(label, key, timeout_s=math.inf, min_score=0.0 if from_near else min_score, **finding)
        self._find_again = Find(label, key, timeout_s=AGAIN_S, min_score=min_score, near=Key(key), **finding)
        self._approach = Approach(Key(key), frame)
        self._plans, self._tops = Plans(frame), None

    def setup(self, **_):
        self._find.setup()
        self._tops = Lidar.of(self.frame)

    def begin(self):
        self.setup()
        self._find.begin()
        self._find.ignored = []
        self._views, self._number, self._failed = Views(self.camera), 0, 0
        self._motion, self._view, self._looks_since, self._closer = None, None, None, None

    def terminate(self, new_status):
        super().terminate(new_status)
        self._approach.terminate(new_status)

    def step(self):
        if self._closer is not None:
            return self._look_closer()
        if self._find.step():
            if not self.from_near:
                return True
            super().terminate(None)
            self._motion, self._looks_since, self._near_places = None, None, 0
            self.feedback_message = f"there may be a {self.label}: looking from near"
            return self._come_closer()
        return self._look_around()

    def _look_around(self):
        if self._motion is not None:
            if not self._motion.done:
                return None
            self._arrive()
        if self._looks_since is not None:
            if self._looks():
                return None
            self._views.done(self._view)
            self._looks_since = None
        self._next_view()
        return None

    def _looks(self):
        """Whether there is more to see from here."""
        since, images = self._looks_since
        looked_s = (rospy.Time.now() - since).to_sec()
        return looked_s < LOOK_S or self._find.images - images < LOOK_IMAGES and looked_s < MAX_LOOK_S

    def _next_view(self):
        here = base_pose(self.frame)
        self._view = self._views.next(newest_map(), here[:2], self._tops.squares()) if self._number < self.max_views else None
        if self._view is None:
            raise ValueError(f"no {self.label} at {self._number} views, of which {self._failed} could not be reached"
                             + self._not_confirmed())
        self._number += 1
        self.feedback_message = f"view {self._number}{self._not_confirmed()}"
        if self._plans.length_m(here, self._view.pose) is None:
            self._failed += 1
            self._views.refuse(self._view)
        else:
            self._motion = GoTo(self._view.pose, self.frame).motion()

    def _not_confirmed(self):
        return f"; what it saw at {len(self._find.ignored)} places was none from near" if self._find.ignored else ""

    def _arrive(self):
        try:
            self._motion.result()
            self._looks_since = rospy.Time.now(), self._find.images
        except ArmError as error:
            self._failed += 1
            self._views.refuse(self._view)
            rospy.logwarn("view %d: %s", self._number, error)
        self._motion = None

    def _look_closer(self):
        try:
            if self._closer.step():
                if self._closer is self._find_again:
                    return True
                self._closer = self._find_again
                self._closer.begin()
                self._near_places += 1
        except (ArmError, ValueError) as error:
            if self._closer is self._find_again and self._near_places < NEAR_PLACES:
                self._come_closer()
            else:
                self._ignore(error)
        return None

    def _come_closer(self):
        self._closer = self._approach
        try:
            self._closer.begin()
        except (ArmError, ValueError) as error:
            self._ignore(error)

    def _ignore(self, why):
        """What was found does not count; the search goes on."""
        place = point_of(read(Key(self._find.key)))
        rospy.loginfo("no %s at (%.2f, %.2f, %.2f): %s", self.label, *place, why)
        self._find.ignored.append(place)
        self._find.begin()
        self._closer = None


class Lidar:
    """What the clouds of `velodyne_points` show, since the first leaf that needs it was set up: one for each frame."""

    _of = {}

    @classmethod
    def of(cls, frame):
        if frame not in cls._of:
            cls._of[frame] = cls(frame)
        return cls._of[frame]

    @classmethod
    def known(cls, frame):
        """That of a leaf that needs it; None where none does."""
        return cls._of.get(frame)

    def __init__(self, frame):
        self.frame, self._tops, self._solids, self._lock = frame, Tops(), Solids(), threading.Lock()
        self._last_s = -math.inf
        rospy.Subscriber("velodyne_points", sensor_msgs.msg.PointCloud2, self._on_cloud, queue_size=1, buff_size=1 << 24)

    def squares(self):
        with self._lock:
            return self._tops.squares()

    def heights(self):
        """{(i, j): height} of tables."""
        with self._lock:
            return self._tops.heights()

    def boxes(self, at, near_m, far_m):
        """As Solids.boxes(), without what is at a table."""
        with self._lock:
            tops = self._tops.squares()
            return self._solids.boxes(at, near_m, far_m, lambda x, y: is_beside(tops, x, y))

    def _on_cloud(self, cloud):
        stamp = cloud.header.stamp
        if abs(stamp.to_sec() - self._last_s) < CLOUD_S:
            return
        self._last_s = stamp.to_sec()
        points = points_of(cloud)
        points = points[numpy.hypot(points[:, 0], points[:, 1]) > ROBOT_M]
        try:
            frame_T_lidar = robot_state.frames().matrix(self.frame, cloud.header.frame_id, TRANSFORM_S, stamp)
        except ArmError:
            return  # no place in the map yet
        points = points @ frame_T_lidar[:3, :3].T + frame_T_lidar[:3, 3]
        with self._lock:
            self._tops.add(points)
            self._solids.add(points)


def is_beside(tops, x, y):
    """Whether a place is on or at a square of a table."""
    square = (int(x // SQUARE_M), int(y // SQUARE_M))
    return square in tops or any(one in tops for one in around(square))


def points_of(cloud):
    """N x 3 of a PointCloud2 with fields x, y, z of 32 bits."""
    offsets = {field.name: field.offset for field in cloud.fields if field.datatype == sensor_msgs.msg.PointField.FLOAT32}
    fields = numpy.dtype({"names": ["x", "y", "z"], "formats": ["<f4"] * 3, "offsets": [offsets[axis] for axis in "xyz"],
                          "itemsize": cloud.point_step})
    points = numpy.frombuffer(cloud.data, fields, count=cloud.width * cloud.height)
    return numpy.column_stack([points[axis] for axis in "xyz"]).astype(float)


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
    is taken; one that stands farther from the point must save FARTHER_COSTS times that of the drive. When the robot does not
    arrive there, it is asked again which poses can be reached: from nearer it sees more. `attempts` in all. A leaf that runs
    again for the same point prefers another pose: from the last one something failed.

    clear_m: poses that have what the lidar sees stand upright, walls and shelves, nearer than this beside or behind them cost
    NARROW_COSTS more: arms need the room. Above 0 it needs the topic `velodyne_points`.
    """

    def __init__(self, point, frame="map", standoffs_m=(0.72, 0.78, 0.85), attempts=6, name=None, clear_m=0.0):
        super().__init__(name or "approach")
        self.point, self.frame, self.standoffs_m, self.attempts = point, frame, standoffs_m, attempts
        self.clear_m = clear_m
        self._plans, self._at, self._stood = Plans(frame), None, []

    def setup(self, **_):
        if self.clear_m > 0:
            Lidar.of(self.frame)

    def begin(self):
        last, self._at = self._at, point_of(read(self.point))
        if last is None or math.dist(last, self._at) > NEAR_M:
            self._stood = []
        self._tried, self._motion, self._why = [], None, ""

    def step(self):
        if self._motion is None:
            self._tried.append(self._next())
            self._motion = GoTo(self._tried[-1], self.frame).motion()
        if not self._motion.done:
            return None
        try:
            self._motion.result()
            self._stood.append(self._tried[-1])
            return True
        except ArmError as error:
            self._why, self._motion = str(error), None
            return None

    def _next(self):
        """The best pose that was not tried yet."""
        if len(self._tried) == self.attempts:
            raise ValueError(f"{self._why} (the last of {self.attempts} places before the goal)")
        here = base_pose(self.frame)
        boxes = Lidar.of(self.frame).boxes(self._at[:2], 0.0, max(self.standoffs_m) + self.clear_m) if self.clear_m > 0 else []
        left = [pose for pose in poses_before(self._at, self.standoffs_m) if pose not in self._tried]
        costs = [(length + FARTHER_COSTS * math.dist(pose[:2], self._at[:2]) + AGAIN_COSTS * self._stood_near(pose)
                  + NARROW_COSTS * self._missing_m(pose, boxes), pose)
                 for pose in left for length in [self._plans.length_m(here, pose)] if length is not None]
        if not costs:
            tried = f"; tried {len(self._tried)}, the last: {self._why}" if self._tried else ""
            raise ValueError(f"the navigator has no plan to a place before ({self._at[0]:.2f}, {self._at[1]:.2f}){tried}")
        return min(costs)[1]

    def _stood_near(self, pose):
        """How often the robot stood at a pose or near it."""
        return sum(math.dist(pose[:2], one[:2]) < AGAIN_M for one in self._stood)

    def _missing_m(self, pose, boxes):
        """Of clear_m about a pose."""
        return max(0.0, self.clear_m - min((beside_m(pose, box) for box in boxes), default=self.clear_m))


def beside_m(pose, box):
    """From a pose (x, y, yaw) to a box (size, middle) whose sides are along the axes; infinity when its nearest point is ahead."""
    away = [middle + min(max(at - middle, -size / 2), size / 2) - at for at, size, middle in zip(pose[:2], *box)]
    ahead = abs(math.remainder(math.atan2(away[1], away[0]) - pose[2], 2 * math.pi)) < AHEAD_RAD
    return math.inf if ahead and any(away) else math.hypot(*away)


def poses_before(point, standoffs_m):
    """Poses (x, y, yaw) that look at a point from all sides, the nearest standoff first."""
    return [(point[0] - standoff * math.cos(yaw), point[1] - standoff * math.sin(yaw), yaw)
            for standoff in standoffs_m for yaw in (2 * math.pi * i / APPROACH_YAWS for i in range(APPROACH_YAWS))]
