"""Frames of a bag, read as fast as they are taken."""

import collections

import message_filters
import rosbag
import rospy

from extperfc.record import frames
from extperfc.record.frames import SourceError
from extperfc.record.topics import synchronized


class BagSource:
    """Pairs of color and depth images of a bag, in its order."""

    is_live = False

    def __init__(self, file, color, depth, info, slop_s):
        """color, depth, info: names of topics; depth may be None. Raises SourceError."""
        try:
            self._bag = rosbag.Bag(str(file))
        except (OSError, rosbag.ROSBagException) as error:
            raise SourceError(f"cannot read the bag {file}: {error}; is it complete (rosbag reindex)?") from None
        self._color, self._depth, self._info_topic = (self._found(name) for name in (color, depth, info))
        self._check(file, [(color, self._color)] + ([(depth, self._depth)] if depth else []))
        self._filters = {topic: message_filters.SimpleFilter() for topic in (self._color, self._depth) if topic}
        rospy.rostime.set_rostime_initialized(True)  # the pairing asks for the time, though it goes by the stamps alone
        self._ready, self._info, self._slop_s = collections.deque(), None, slop_s
        self._pairs = synchronized(list(self._filters.values()), slop_s, self._on_pair)
        topics = [topic for topic in (*self._filters, self._info_topic) if topic]
        self._messages = self._bag.read_messages(topics=topics)

    def _found(self, name):
        """The topic of the bag that a name means, with or without the leading slash."""
        return next(
            (topic
             for topic in self._bag.get_type_and_topic_info().topics if name and topic.strip("/") == name.strip("/")),
            None)

    def _check(self, file, wanted):
        lacking = [name for name, found in wanted if found is None]
        if lacking:
            images = [
                topic for topic, entry in self._bag.get_type_and_topic_info().topics.items()
                if "Image" in entry.msg_type
            ]
            seen = f"its image topics are {', '.join(images)}" if images else "it has no image topic"
            raise SourceError(
                f"the bag {file} has no topic {' and no topic '.join(lacking)} ({seen}): give --color-topic and "
                f"--depth-topic "
                "(--no-depth without one)")

    def _on_pair(self, color, depth=None):
        self._ready.append(frames.pair(color, depth, self._info))

    def next_frame(self, _timeout_s):
        """The next frame. Raises EOFError behind the last one, and SourceError for unusable images."""
        while not self._ready:
            try:
                topic, message, _ = next(self._messages)
            except StopIteration:
                raise EOFError from None
            except rosbag.ROSBagException as error:
                raise SourceError(f"the bag is damaged: {error}; run rosbag reindex") from None
            if topic == self._info_topic:
                self._info = message
            else:
                self._filters[topic].signalMessage(message)
        return self._ready.popleft()

    def await_intrinsics(self, _timeout_s):
        """Those of the bag's first camera info, wherever it stands; None without one."""
        if self._info is None and self._info_topic:
            _, self._info, _ = next(self._bag.read_messages(topics=[self._info_topic]))
        return self._info and frames.intrinsics_of(self._info)

    @property
    def info_topic(self):
        return self._info_topic or "camera info"

    def why_silent(self):
        """Why not one frame was in the bag."""
        return f"the bag has no pair of color and depth images within {self._slop_s} s: give --slop, or --no-depth"

    def close(self):
        self._bag.close()
