"""The node of tools/health.

  reads      /diagnostics; the processes of this machine
  publishes  diagnostics_agg (diagnostic_msgs/DiagnosticArray): the tree /<group>/<part>/<status>
             diagnostics_toplevel_state (diagnostic_msgs/DiagnosticStatus, latched, at changes): the whole robot, and which
             part is missing, silent, failing or starting
             /diagnostics: its own
  restores   registrations and parameters at a ROS master that started again at the same place
  ends       processes of parts that hang, and nodelet loaders whose manager ended; roslaunch starts them again
  parameters config/health.yaml; ~started: names of the parts that were started, between commas
"""

import os
import signal
import sys
import threading
import time

import rosgraph
import rospy
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue

from extperfc.health import settings, tree
from extperfc.health.master_keeper import MasterKeeper
from extperfc.health.part_state import State
from extperfc.health.ping import Pinger
from extperfc.health.processes import ProcessTable
from extperfc.health.supervisor import End, Supervisor
from extperfc.health.unloader import Unloader

SCAN_PERIOD_S = 1.0  # of looks for new nodes while all parts run
FORGET_S = 10.0  # statuses without a part that are not repeated


class Health:
    """Everything of the node; run() returns at shutdown."""

    def __init__(self, chosen):
        now = time.monotonic()
        self._settings = chosen
        self._lock = threading.Lock()  # of the supervisor and the other statuses
        self._supervisor = Supervisor(chosen, now)
        self._others = {}  # name -> (status, time)
        self._table = ProcessTable(rosgraph.get_master_uri())
        self._unloader = Unloader(chosen.unload_s)
        self._down = {part.part.name: now for part in self._supervisor.parts}  # name -> since when it does not run
        self._shown, self._published, self._scanned, self._look_ms = None, now - chosen.publish_period_s, now, 0.0
        self._tree = rospy.Publisher("diagnostics_agg", DiagnosticArray, queue_size=5)
        self._summary = rospy.Publisher("diagnostics_toplevel_state", DiagnosticStatus, queue_size=5, latch=True)
        self._own = rospy.Publisher("/diagnostics", DiagnosticArray, queue_size=5)
        rospy.Subscriber("/diagnostics", DiagnosticArray, self._on_diagnostics, queue_size=100)
        pinged = [part.node for part in chosen.parts if part.ping]
        self._master = MasterKeeper(rosgraph.get_master_uri(), rospy.get_name(), chosen.master_period_s)
        self._master.start()
        Pinger(rospy.get_name(), pinged, chosen.ping_period_s, self._add).start()

    def _on_diagnostics(self, message):
        for status in message.status:
            self._add(status)

    def _add(self, status):
        now = time.monotonic()
        with self._lock:
            if not self._supervisor.add(status, now):
                self._others[status.name] = (status, now)

    def run(self):
        """Wall time counts: simulated time may stand still, and begins anew with the simulator."""
        while not rospy.is_shutdown():
            begin = time.monotonic()
            self._look()
            self._publish_summary()
            if begin - self._published >= self._settings.publish_period_s:
                self._published = begin
                self._publish_tree()
            self._look_ms = 1e3 * (time.monotonic() - begin)
            time.sleep(self._settings.look_period_s)

    def _look(self):
        now = time.monotonic()
        if self._down or now - self._scanned > SCAN_PERIOD_S:
            processes, self._scanned = self._table.scan(), now
        else:
            processes = self._table.scan_known()
        with self._lock:
            actions = self._supervisor.look(processes, now)
            actions += self._supervisor.end_overdue(self._unloader.overdue(), now)
            states = [(part.part.name, part.state(now), part.message(now)) for part in self._supervisor.parts]
        for action in actions:
            if isinstance(action, End):
                self._end(action.process, action.reason)
            else:
                self._unloader.unload(action.manager, action.nodelet)
        self._log_changes(states, now)

    def _log_changes(self, states, now):
        for name, state, message in states:
            if state is State.RUNNING and name in self._down:
                rospy.loginfo("health: %s runs after %.1f s", name, now - self._down.pop(name))
            elif state is not State.RUNNING and name not in self._down:
                self._down[name] = now
                rospy.logwarn("health: %s is %s", name, message)

    def _end(self, process, reason):
        """SIGKILL: roscpp's nodelet managers do nothing at SIGTERM that a process which hangs could still do."""
        if self._table.alive(process):
            rospy.logwarn("health: ending %s (pid %d): %s", process.node, process.pid, reason)
            try:
                os.kill(process.pid, signal.SIGKILL)
            except ProcessLookupError:
                pass  # it ended by itself

    def _publish_summary(self):
        """At once when its line changed, else with the tree when the message of a part did."""
        now = time.monotonic()
        with self._lock:
            summary = tree.summary(self._supervisor.parts, now, self._master.complaint)
        is_new = self._shown is None or summary.message != self._shown.message
        is_due = now - self._published >= self._settings.publish_period_s
        if is_new or (is_due and summary != self._shown):
            self._shown = summary
            self._summary.publish(summary)
        if is_new:
            (rospy.loginfo if summary.level == DiagnosticStatus.OK else rospy.logwarn)("health: %s", summary.message)

    def _publish_tree(self):
        now = time.monotonic()
        with self._lock:
            self._others = {name: entry for name, entry in self._others.items() if now - entry[1] < FORGET_S}
            statuses = tree.build(self._supervisor.parts, [status for status, _ in self._others.values()], now)
            own = self._own_status(now)
        for publisher, sent in ((self._tree, statuses), (self._own, [own])):
            message = DiagnosticArray(status=sent)
            message.header.stamp = rospy.Time.now()
            publisher.publish(message)

    def _own_status(self, now):
        given_up = self._supervisor.given_up(now)
        text = f"restarted too often, left alone: {', '.join(given_up)}" if given_up else "supervises"
        level = DiagnosticStatus.ERROR if given_up else DiagnosticStatus.OK
        values = {"parts": len(self._supervisor.parts), "restarts in a minute": self._supervisor.limit.recent(now),
                  "look [ms]": f"{self._look_ms:.1f}"}
        return DiagnosticStatus(level=level, name=f"{rospy.get_name()[1:]}: supervisor", message=text, hardware_id="none",
                                values=[KeyValue(key=key, value=str(value)) for key, value in values.items()])


def main():
    if {"-h", "--help"} & set(rospy.myargv()[1:]):
        print(__doc__)
        return 0
    if not rosgraph.is_master_online():
        print(f"health: no ROS master at {rosgraph.get_master_uri()}", file=sys.stderr)
        return 1
    rospy.init_node("health")
    try:
        chosen = settings.load(rospy.get_param("~", {}), rospy.get_namespace())
    except settings.Wrong as error:
        rospy.logfatal("health: %s", error)
        return 1
    try:
        Health(chosen).run()
    except rospy.ROSException:  # a topic was closed meanwhile
        if not rospy.is_shutdown():
            raise
    return 0
