"""Faults of the robot's parts, and how long they take to work again."""

import dataclasses
import os
import random
import signal
import time

import rospy

from robot_health import NODES, SIMULATOR, TRANSLATOR, named, runs

from extperfc.health.ping import FAILURES
from extperfc.health.processes import ProcessTable
from extperfc.health.registrations import Master, missing
from extperfc.srv import SetFault

NOTICED_S, RECOVERED_S = 30.0, 90.0  # of real time
SENSOR_S = 5.0                       # that a sensor fails
HANGS = ("/camera_manager", "/navigation_manager")
SENSORS = {"camera_freeze": "detections_3d", "lidar_drop": "scan"}  # of the simulator: kind, what shows that it is over
DOWN_S = 3.0                         # that a master, or the robot, is away
SLOW_KBIT_S = 20000                  # of a link that needs seven times as much for all images and clouds
LATCHED = ("tf_static",)             # comes once
POLL_S = 0.02


@dataclasses.dataclass(frozen=True)
class Fault:
    """One that was. begin_s, end_s: of time.monotonic(), end_s when all parts report that they are well; back_s: from the fault's end, or
    the kill, until what it broke works again; well_s: until end_s. None: it did not come so far."""
    name: str
    begin_s: float
    end_s: float
    back_s: float
    well_s: float


class Faults:
    """One at a time, in an order that the seed decides. robot, cable: a RobotSide and the cable to it, where there are any."""

    def __init__(self, listener, seed, session, robot=None, cable=None):
        self._listener, self._rng, self._session = listener, random.Random(f"faults {seed}"), session
        self._robot, self._cable = robot, cable
        self._warn = ()  # parts that warn rightly
        self._nodes = {name: node for name, node in NODES.items() if name != SIMULATOR} | (TRANSLATOR if robot else {})
        self._table = ProcessTable(os.environ["ROS_MASTER_URI"])
        kills = [(f"kill {node}", lambda node=node: self._end(node, signal.SIGKILL)) for node in self._nodes]
        hangs = [(f"stop {node}", lambda node=node: self._end(node, signal.SIGSTOP)) for node in HANGS]
        sensors = [(kind, lambda kind=kind: self._fail_sensor(kind)) for kind in SENSORS]
        self._kinds = [*kills, ("kill /health", self._kill_health), *hangs, *sensors, ("restart the ROS master", self._restart_master)]
        self._kinds += [("restart the robot with its master", self._restart_robot)] if robot else []
        self._kinds += [("slow link", lambda: self._disturb_link(lambda: cable.slow(SLOW_KBIT_S))),
                        ("cut link", lambda: self._disturb_link(cable.cut))] if cable else []
        self._left = []

    def next(self):
        """Injects a fault and waits until the robot is complete again. Each kind comes once before any comes again."""
        if not self._left:
            self._left = self._rng.sample(self._kinds, len(self._kinds))
        name, inject = self._left.pop()
        self._warn = () if self._listener.complete else self._warn
        begin_s = time.monotonic()
        over_s = inject()
        works_s = time.monotonic()
        well = self._wait(lambda: self._listener.well(self._warn), RECOVERED_S)
        end_s = time.monotonic()
        if over_s is None:
            return Fault(name, begin_s, end_s, None, None)
        return Fault(name, begin_s, end_s, works_s - over_s, end_s - over_s if well else None)

    def _wait(self, condition, seconds):
        deadline = time.monotonic() + seconds
        while not condition():
            if time.monotonic() > deadline or not self._session.alive():
                return False
            time.sleep(POLL_S)
        return True

    def _end(self, node, number):
        """When it ended; None: it was not noticed, or did not work again."""
        parts, topic = self._nodes[node]
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

    def _restart_master(self):
        """Works again when the master knows all that it knew before."""
        master = Master(os.environ["ROS_MASTER_URI"], rospy.get_name())
        before = master.read()
        self._session.kill_master()
        time.sleep(DOWN_S)
        self._session.start_master()
        over_s = time.monotonic()
        return over_s if self._wait(lambda: _knows(master, before), RECOVERED_S) else None

    def _restart_robot(self):
        """It begins elsewhere; the mapper says so until it recognizes a place."""
        self._warn = ("mapper",)
        self._robot.kill()
        time.sleep(DOWN_S)
        self._robot.start()
        return self._when_all_works()

    def _disturb_link(self, disturb):
        disturb()
        time.sleep(SENSOR_S)
        self._cable.mend()
        return self._when_all_works()

    def _when_all_works(self):
        """Now; None: not all topics bring messages again."""
        over_s = time.monotonic()
        topics = [topic for _, topic in self._nodes.values() if topic and topic not in LATCHED]
        good = self._wait(lambda: all(self._listener.works(topic, over_s, 0.0) for topic in topics), RECOVERED_S)
        return over_s if good else None


def _knows(master, before):
    """Whether a master knows the parameters of these Registrations, and their topics and services by the same nodes, apart from
    those of this process, which come and go."""
    try:
        now = master.read()
    except FAILURES:
        return False
    topics = ((before.publishers, now.publishers), (before.subscribers, now.subscribers))
    others = {service for service, (node, _) in before.services.items() if node != rospy.get_name()}
    return (all(set(nodes) - {rospy.get_name()} <= set(known.get(topic, [])) for old, known in topics for topic, nodes in old.items())
            and others <= set(now.services) and not missing(before.parameters, now.parameters))
