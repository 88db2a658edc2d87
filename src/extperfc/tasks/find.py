"""Finds an object by the detector."""

import collections
import dataclasses
import math
import threading

import geometry_msgs.msg
import numpy
import rospy
import vision_msgs.msg

from extperfc.arm import robot_state
from extperfc.arm.errors import ArmError
from extperfc.arm.goals import matrix_of_pose, pose_stamped
from extperfc.tasks.blackboard import read, write
from extperfc.tasks.leaf import Leaf

DEPTH_FRAME = "camera_color_optical_frame"
MAX_OBJECTS = 100  # of one class at a time

_Detection = collections.namedtuple("_Detection", "frame_T_object size distance_m")


@dataclasses.dataclass(frozen=True)
class Found:
    """What Find leaves on the blackboard."""
    label: str
    pose: geometry_msgs.msg.PoseStamped  # of the object's middle, in the frame that Find was given
    size: tuple                          # [m] along x, y, z of the detections' frame
    distance_m: float                    # from the camera to the object's middle
    detections: int                      # of which this is the median

    @property
    def position(self):
        return self.pose.pose.position


def point_of(value):
    """(x, y, z) of a Found or of three numbers."""
    if isinstance(value, Found):
        value = (value.position.x, value.position.y, value.position.z)
    return numpy.array(value, float)


class _Detections:
    """The newest `detections_3d` with their classes' names."""

    def __init__(self):
        self._lock, self._names, self._messages = threading.Lock(), {}, []
        rospy.Subscriber("vision_info", vision_msgs.msg.VisionInfo, self._on_info)
        rospy.Subscriber("detections_3d", vision_msgs.msg.Detection3DArray, self._on_detections, queue_size=5)

    def _on_info(self, message):
        self._names = dict(enumerate(rospy.get_param(message.database_location, [])))

    def _on_detections(self, message):
        with self._lock:
            self._messages = [*self._messages[-49:], message]

    def since(self, stamp, label):
        """[(header, Detection3D)] of a class in the messages that are newer than a stamp, the newest stamp, and how many
        messages these are."""
        with self._lock:
            messages = [message for message in self._messages if message.header.stamp > stamp]
        found = [(message.header, one) for message in messages for one in message.detections
                 if one.results and self._names.get(one.results[0].id) == label]
        return found, max([stamp, *(message.header.stamp for message in messages)]), len(messages)


class Find(Leaf):
    """Waits until the detector has seen an object of a class `confirm` times at about the same place, and writes a Found
    under `key`: the medians of these detections. Subscribes `detections_3d` and `vision_info`.

    within_m: detections within this distance of the first one are the same object.
    near: (x, y, z), a Found or a Key, in `frame`: only objects within `near_m` of it. max_size_m: the longest edge, min_score: of
    detections that count; look-alikes are mostly larger, or scored lower. timeout_s: of ROS time. `ignored`: places (x, y, z)
    in `frame`, within `near_m` of which nothing counts.
    """

    _detections = None

    def __init__(self, label, key, frame="odom", confirm=5, within_m=0.05, near=None, near_m=0.3, max_size_m=math.inf,
                 min_score=0.0, timeout_s=10.0, name=None):
        super().__init__(name or f"find the {label}")
        self.label, self.key, self.frame, self.confirm, self.within_m = label, key, frame, confirm, within_m
        self.near, self.near_m, self.timeout_s = near, near_m, timeout_s
        self.max_size_m, self.min_score, self.ignored = max_size_m, min_score, []

    def setup(self, **_):
        Find._detections = Find._detections or _Detections()

    def begin(self):
        self.setup()
        self.images = 0  # that the detector has looked at since
        self._begin = self._last = rospy.Time.now()
        self._near, self._groups = None if self.near is None else point_of(read(self.near)), []

    def step(self):
        new, self._last, images = self._detections.since(self._last, self.label)
        self.images += images
        for header, detection in new:
            if self._counts(detection):
                self._add(header, detection.bbox)
        best = max(self._groups, key=len, default=[])
        if len(best) >= self.confirm:
            write(self.key, self._found(best))
            return True
        self.feedback_message = f"seen {len(best)} times"
        if (rospy.Time.now() - self._begin).to_sec() > self.timeout_s:
            raise ValueError(f"no {self.label} was seen {self.confirm} times within {self.timeout_s:g} s, but {len(best)} times")
        return None

    def _counts(self, detection):
        size = detection.bbox.size
        return max(size.x, size.y, size.z) <= self.max_size_m and detection.results[0].score >= self.min_score

    def _add(self, header, box):
        """Adds a detection to the object that it belongs to. One whose frames tf does not know at its time is left out."""
        seen = matrix_of_pose(box.center)
        try:
            frame_T_object = robot_state.frames().matrix(self.frame, header.frame_id, 0.0, header.stamp) @ seen
            camera_T_object = robot_state.frames().matrix(DEPTH_FRAME, header.frame_id, 0.0, header.stamp) @ seen
        except ArmError:
            return
        position = frame_T_object[:3, 3]
        if self._near is not None and numpy.linalg.norm(position - self._near) > self.near_m:
            return
        if any(numpy.linalg.norm(position - place) <= self.near_m for place in self.ignored):
            return
        one = _Detection(frame_T_object, (box.size.x, box.size.y, box.size.z), float(numpy.linalg.norm(camera_T_object[:3, 3])))
        for group in self._groups:
            if numpy.linalg.norm(group[0].frame_T_object[:3, 3] - position) < self.within_m:
                group.append(one)
                return
        if len(self._groups) < MAX_OBJECTS:
            self._groups.append([one])

    def _found(self, group):
        frame_T_object = group[-1].frame_T_object.copy()
        frame_T_object[:3, 3] = numpy.median([one.frame_T_object[:3, 3] for one in group], axis=0)
        size = tuple(float(v) for v in numpy.median([one.size for one in group], axis=0))
        distance_m = float(numpy.median([one.distance_m for one in group]))
        return Found(self.label, pose_stamped(frame_T_object, self.frame), size, distance_m, len(group))
