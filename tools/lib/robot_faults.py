"""Faults of the robot's parts, and how long they take to work again."""

import dataclasses
import os
import random
import signal
import time

import rospy

from robot_health import NODES, SIMULATOR, named, runs

from extperfc.health.processes import ProcessTable
from extperfc.srv import SetFault

NOTICED_S, RECOVERED_S = 30.0, 90.0  # of real time
SENSOR_S = 5.0                       # that a sensor fails
HANGS = ("/camera_manager", "/navigation_manager")
SENSORS = {"camera_freeze": "detections_3d", "lidar_drop": "scan"}  # of the simulator: kind, what shows that it is over
POLL_S = 0.02


@dataclasses.dataclass(frozen=True)
class Fault:
    """One that was. begin_s, end_s: of time.monotonic(); back_s: from its end, or the kill, on; None: it did not come back."""
    name: str
    begin_s: float
    end_s: float
    back_s: float


class Faults:
    """One at a time, in an order that the seed decides."""

    def __init__(self, listener, seed, alive):
        self._listener, self._rng, self._alive = listener, random.Random(f"faults {seed}"), alive
        self._table = ProcessTable(os.environ["ROS_MASTER_URI"])
        kills = [(f"kill {node}", lambda node=node: self._end(node, signal.SIGKILL)) for node in NODES if node != SIMULATOR]
        hangs = [(f"stop {node}", lambda node=node: self._end(node, signal.SIGSTOP)) for node in HANGS]
        sensors = [(kind, lambda kind=kind: self._fail_sensor(kind)) for kind in SENSORS]
        self._kinds, self._left = [*kills, ("kill /health", self._kill_health), *hangs, *sensors], []

    def next(self):
        """Injects a fault and waits until the robot is complete again. Each kind comes once before any comes again."""
        if not self._left:
            self._left = self._rng.sample(self._kinds, len(self._kinds))
        name, inject = self._left.pop()
        begin_s = time.monotonic()
        over_s = inject()
        back = self._wait(lambda: self._listener.complete, RECOVERED_S)
        end_s = time.monotonic()
        return Fault(name, begin_s, end_s, end_s - over_s if back and over_s is not None else None)

    def _wait(self, condition, seconds):
        deadline = time.monotonic() + seconds
        while not condition():
            if time.monotonic() > deadline or not self._alive():
                return False
            time.sleep(POLL_S)
        return True

    def _end(self, node, number):
        """When it ended; None: it was not noticed, or did not work again."""
        parts, topic = NODES[node]
        count, over_s = len(self._listener.messages), time.monotonic()
        os.kill(self._table.scan()[node].pid, number)
        title = "missing" if number == signal.SIGKILL else "silent"
        noticed = self._wait(lambda: all(any(named(message.message, title, part) for message in self._listener.since(count))
                                         for part in parts), NOTICED_S)
        if not noticed:
            return None
        since_s = time.monotonic()
        good = self._wait(lambda: all(runs(self._listener.summary.message, part) for part in parts)
                          and self._listener.works(topic, since_s, RECOVERED_S), RECOVERED_S)
        return over_s if good else None

    def _kill_health(self):
        count, over_s = len(self._listener.messages), time.monotonic()
        os.kill(self._table.scan()["/health"].pid, signal.SIGKILL)
        return over_s if self._wait(lambda: self._listener.since(count), RECOVERED_S) else None

    def _fail_sensor(self, kind):
        answer = rospy.ServiceProxy("sim/set_fault", SetFault)(kind, "", 1.0, SENSOR_S)
        if not answer.success:
            raise RuntimeError(f"{kind}: {answer.message}")
        end = rospy.get_time() + SENSOR_S
        self._wait(lambda: rospy.get_time() >= end, RECOVERED_S)
        over_s = time.monotonic()
        return over_s if self._wait(lambda: self._listener.works(SENSORS[kind], over_s, 0.0), RECOVERED_S) else None
