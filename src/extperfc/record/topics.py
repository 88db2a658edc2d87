"""Frames of a running ROS system."""

import queue
import threading

import message_filters
import rosgraph
import rospy
from sensor_msgs.msg import CameraInfo, CompressedImage, Image

from extperfc.record import frames
from extperfc.record.frames import SourceError

PAIR_QUEUE = 10  # messages of each topic that wait for their partner
BUFFER_BYTES = 1 << 24  # an image must fit, else rospy falls behind


def image_type(topic):
    """Message class of an image topic, by image_transport's names."""
    return CompressedImage if topic.endswith("/compressed") else Image


def synchronized(subscribers, slop_s, callback):
    """Calls back with one message of each subscriber whose stamps differ by at most slop_s; directly with a single
    one."""
    if len(subscribers) == 1:
        subscribers[0].registerCallback(callback)
        return None
    pairs = message_filters.ApproximateTimeSynchronizer(subscribers, PAIR_QUEUE, slop_s)
    pairs.registerCallback(callback)
    return pairs


class _Counted:
    """A topic, with what arrived on it."""

    def __init__(self, topic, kind):
        self.topic, self.count, self.stamp_s = rospy.resolve_name(topic), 0, None
        self.subscriber = message_filters.Subscriber(topic, kind, queue_size=2, buff_size=BUFFER_BYTES)
        self.subscriber.registerCallback(self._on_message)

    def _on_message(self, message):
        self.count, self.stamp_s = self.count + 1, message.header.stamp.to_sec()


class TopicSource:
    """The newest pair of color and depth images, and the camera info that came last."""

    is_live = True

    def __init__(self, color, depth, info, slop_s):
        """color, depth, info: names of topics; depth may be None. Raises SourceError without a ROS master."""
        if not rosgraph.is_master_online():
            raise SourceError(
                f"there is no ROS master at {rosgraph.get_master_uri()}: start roscore or the robot, or set "
                f"ROS_MASTER_URI"
            )
        rospy.init_node("extperfc_record", anonymous=True, disable_signals=True)
        self._slop_s, self._newest, self._info, self._info_came = slop_s, queue.Queue(1), None, threading.Event()
        self._topics = [_Counted(topic, image_type(topic)) for topic in (color, depth) if topic]
        self._pairs = synchronized([topic.subscriber for topic in self._topics], slop_s, self._on_pair)
        self._info_topic = rospy.resolve_name(info)
        self._info_subscriber = rospy.Subscriber(info, CameraInfo, self._on_info, queue_size=1)

    def _on_info(self, message):
        self._info = message
        self._info_came.set()

    def _on_pair(self, color, depth=None):
        """A newer pair replaces the one that waits."""
        try:
            self._newest.get_nowait()
        except queue.Empty:
            pass
        self._newest.put((color, depth))

    def next_frame(self, timeout_s):
        """The newest frame that was not returned yet; None when none comes in time. Raises SourceError for unusable
        images."""
        try:
            color, depth = self._newest.get(timeout=timeout_s)
        except queue.Empty:
            return None
        return frames.pair(color, depth, self._info)

    def await_intrinsics(self, timeout_s):
        """Waits for the camera info, which may come later than the first images. Returns frames.Intrinsics, or None."""
        self._info_came.wait(timeout_s)
        return self._info and frames.intrinsics_of(self._info)

    @property
    def info_topic(self):
        return self._info_topic

    def why_silent(self):
        """Why no frame came, and what to do."""
        master = rosgraph.Master(rospy.get_name())
        try:
            published = dict(master.getTopicTypes())
            publishers = {topic for topic, nodes in master.getSystemState()[0] if nodes}
        except (rosgraph.MasterException, OSError):
            return f"the ROS master at {rosgraph.get_master_uri()} does not answer any more: start it again"
        lacking = [one.topic for one in self._topics if one.topic not in publishers]
        if lacking:
            others = sorted(topic for topic in publishers
                            if published.get(topic) in ("sensor_msgs/Image", "sensor_msgs/CompressedImage"))
            seen = f"image topics are {', '.join(others)}" if others else "there is no image topic at all"
            return (
                f"no publisher of {' and '.join(lacking)} ({seen}): start the camera's driver, or give "
                f"--color-topic and "
                "--depth-topic (--no-depth without one)")
        quiet = [one.topic for one in self._topics if one.count == 0]
        if quiet:
            return (f"{' and '.join(quiet)} has a publisher, but no image arrives: check the driver, and ROS_IP or "
                    "ROS_HOSTNAME of both computers")
        gap_s = abs(self._topics[0].stamp_s - self._topics[-1].stamp_s)
        return (f"images arrive, but no pair within {self._slop_s} s; the last stamps differ by {gap_s:.3f} s: let the "
                "driver synchronise (enable_sync:=true with RealSense), or give --slop")

    def close(self):
        for one in self._topics:
            one.subscriber.unregister()
        self._info_subscriber.unregister()
