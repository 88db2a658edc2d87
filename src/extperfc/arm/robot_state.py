"""State of the robot: joints and frames. One listener for all arms of a process."""

import threading
import time

import rospy
import sensor_msgs.msg
import tf2_ros

from extperfc import robot_description as rd
from extperfc.arm.connection import join
from extperfc.arm.errors import ArmError
from extperfc.msg import ArmCode


class JointListener:
    """Positions by joint name, as last heard; messages may name some of the joints only."""

    def __init__(self, namespace="", topic="robot/joint_states"):
        self._positions, self._heard = {}, threading.Condition()
        self.topic = rospy.resolve_name(join(namespace, topic))
        self._subscriber = rospy.Subscriber(self.topic, sensor_msgs.msg.JointState, self.on_message, queue_size=1)

    def on_message(self, message):
        with self._heard:
            self._positions.update(zip(message.name, message.position))
            self._heard.notify_all()

    def positions(self):
        """{joint: radians or metres} of all joints heard of so far."""
        with self._heard:
            return dict(self._positions)

    def of(self, names, wait_s):
        """These joints, those that were heard of. Raises ArmError when none was within wait_s seconds of real time."""
        deadline = time.monotonic() + wait_s
        with self._heard:
            while True:
                found = {name: self._positions[name] for name in names if name in self._positions}
                left = deadline - time.monotonic()
                if found or left <= 0:
                    break
                self._heard.wait(left)
        if not found:
            raise ArmError(ArmCode.NO_JOINT_STATES, f"no positions of the joints {', '.join(names)} "
                           f"on {self.topic} within {wait_s:g} s")
        return found


class FrameListener:
    """Transforms by tf."""

    def __init__(self):
        self._buffer = tf2_ros.Buffer()
        self._listener = tf2_ros.TransformListener(self._buffer)

    def lookup(self, target, source, wait_s, stamp=rospy.Time(0)):
        """target_T_source at a time, by default the latest, as a geometry_msgs/TransformStamped. Raises ArmError."""
        deadline = time.monotonic() + wait_s
        while True:
            try:
                return self._buffer.lookup_transform(target, source, stamp)
            except tf2_ros.TransformException as error:
                if time.monotonic() > deadline or rospy.is_shutdown():
                    raise ArmError(ArmCode.UNKNOWN_FRAME, f"no transform from {source} to {target}: {error}") from None
            time.sleep(0.02)

    def rotation(self, target, source, wait_s):
        """3x3 rotation of the same."""
        q = self.lookup(target, source, wait_s).transform.rotation
        return rd.rotation_of_quaternion(q.x, q.y, q.z, q.w)

    def matrix(self, target, source, wait_s, stamp=rospy.Time(0)):
        """4x4 of the same, with the translation."""
        found = self.lookup(target, source, wait_s, stamp).transform
        t, q = found.translation, found.rotation
        return rd.transform((t.x, t.y, t.z), rd.rotation_of_quaternion(q.x, q.y, q.z, q.w))


_frames, _joints, _lock = [], {}, threading.Lock()


def frames():
    """The FrameListener of this process."""
    with _lock:
        if not _frames:
            _frames.append(FrameListener())
        return _frames[0]


def joints(namespace=""):
    """The JointListener of this process for a robot."""
    with _lock:
        if namespace not in _joints:
            _joints[namespace] = JointListener(namespace)
        return _joints[namespace]
