"""The robot's messages as they come: rates, and times from a sensor's message to the result with its stamp."""

import collections
import functools
import itertools
import struct
import threading
import time

import rospy
from diagnostic_msgs.msg import DiagnosticStatus
from geometry_msgs.msg import PoseStamped, Twist

from ros_session import Stalled

CHAINS = (("image to 3D detections", "images", "3D detections"), ("lidar sweep to planar scan", "lidar sweeps", "planar scans"),
          ("planar scan to pose in the map", "planar scans", "poses in the map"), ("planar scan to map", "planar scans", "maps"))
MOVES_M_S = 1e-3
STANDS_S = 0.3  # without a command that moves it
KEPT = 4096  # stamps of each stream: more than a case has
POLL_S = 0.02


def stamp_of(message):
    """(seconds, nanoseconds) of a message that begins with a header, without reading the rest of it."""
    return struct.unpack_from("<II", message._buff, 4)  # pylint: disable=protected-access


class Streams:
    """topics: {name: topic of messages that begin with a header}. speed: simulated seconds per second. Times are in simulated
    seconds, measured by the wall's clock."""

    def __init__(self, session, topics, speed, ready_s):
        self._session, self._speed, self._ready_s = session, speed, ready_s
        self._lock, self._arrivals = threading.Lock(), {name: collections.OrderedDict() for name in topics}
        self._summary, self._goals_x, self._begun, self._ended = None, None, None, None
        self._asked_at, self._moved_at = None, 0.0  # of a goal that came while the base stood; of the last command that moves it
        self.goal_to_motion_ms = []
        session.join("bench_system")
        for name, topic in topics.items():
            rospy.Subscriber(topic, rospy.AnyMsg, functools.partial(self._on_message, name), queue_size=20, buff_size=2**22)
        rospy.Subscriber("diagnostics_toplevel_state", DiagnosticStatus, lambda message: setattr(self, "_summary", message))
        rospy.Subscriber("cmd_vel", Twist, self._on_command, queue_size=5)
        self._goals = rospy.Publisher("move_base_simple/goal", PoseStamped, queue_size=1)

    @property
    def names(self):
        return list(self._arrivals)

    def wait_until_complete(self):
        """Until health reports every part and each stream has begun."""
        deadline = time.monotonic() + self._ready_s
        while not (self._summary and self._summary.level == DiagnosticStatus.OK and all(self._arrivals.values())):
            if time.monotonic() > deadline or not self._session.alive():
                missing = [name for name, arrived in self._arrivals.items() if not arrived]
                raise Stalled(f"not complete after {self._ready_s:g} s: {self._summary and self._summary.message}; without"
                              f" messages: {', '.join(missing) or 'none'}; {' '.join(self._session.errors())}")
            time.sleep(POLL_S)

    def begin(self):
        """What was before does not count."""
        with self._lock:
            for arrived in self._arrivals.values():
                arrived.clear()
            self.goal_to_motion_ms.clear()
            self._begun = time.monotonic(), rospy.get_time()

    def drive(self, seconds, places_m, period_s):
        """For so many simulated seconds, a goal each period, in turn."""
        self._goals_x = self._goals_x or itertools.cycle(places_m)
        end_s = next_s = rospy.get_time()
        end_s += seconds
        while rospy.get_time() < end_s:
            if not self._session.alive():
                raise Stalled("roslaunch has ended")
            if rospy.get_time() >= next_s:
                next_s += period_s
                self._send(next(self._goals_x))
            time.sleep(POLL_S)
        self._ended = time.monotonic(), rospy.get_time()

    def _send(self, x_m):
        goal = PoseStamped()
        goal.header.frame_id = "map"
        goal.pose.position.x, goal.pose.orientation.w = x_m, 1.0
        with self._lock:
            now = time.monotonic()
            self._asked_at = now if now - self._moved_at > STANDS_S else None
        self._goals.publish(goal)

    def _on_command(self, twist):
        if max(abs(twist.linear.x), abs(twist.linear.y), abs(twist.angular.z)) <= MOVES_M_S:
            return
        with self._lock:
            self._moved_at = time.monotonic()
            if self._asked_at is not None:
                self.goal_to_motion_ms.append(1e3 * self._speed * (self._moved_at - self._asked_at))
                self._asked_at = None

    def _on_message(self, name, message):
        now, stamp = time.monotonic(), stamp_of(message)
        with self._lock:
            arrived = self._arrivals[name]
            arrived.setdefault(stamp, now)
            while len(arrived) > KEPT:
                arrived.popitem(last=False)

    def pace(self):
        """Simulated seconds per second since begin()."""
        return (self._ended[1] - self._begun[1]) / (self._ended[0] - self._begun[0])

    def rate(self, name, seconds):
        """Messages per simulated second."""
        with self._lock:
            return len(self._arrivals[name]) / seconds

    def latencies_ms(self, source, result):
        """From the arrival of a sensor's message to that of the result with its stamp, in simulated milliseconds."""
        with self._lock:
            begin, end = self._arrivals[source], self._arrivals[result]
            return [1e3 * self._speed * (at - begin[stamp]) for stamp, at in end.items() if stamp in begin]
