"""Keeps what the ROS master knows, and gives it back to a master that started again."""

import threading
import time

import rospy

from extperfc.health.ping import FAILURES
from extperfc.health.registrations import Master

RETRY_S = 0.2  # while the master does not answer: nodes that start wait for it, too, and then read their parameters at once


class MasterKeeper(threading.Thread):
    """Notes the master's Registrations every period. They come back while the node `caller`, which is registered, runs."""

    def __init__(self, uri, caller, period_s):
        super().__init__(daemon=True)
        self._master, self._uri, self._caller, self._period_s = Master(uri, caller), uri, caller, period_s
        self._noted = None
        self._lost_s = None  # time.monotonic() of the first request without an answer

    @property
    def complaint(self):
        """What is wrong with the master, in a few words; "": nothing."""
        return "" if self._lost_s is None else "no ROS master"

    def run(self):
        while True:
            time.sleep(RETRY_S if self.complaint or self._noted is None else self._period_s)
            self.look()

    def look(self):
        """Reads or restores once."""
        try:
            if not self._master.knows(self._caller) and self._noted is not None:
                self._restore()
            latest = self._master.read()
        except FAILURES as error:
            self._lose(error)
            return
        if self._caller in latest.nodes:  # else it started again between the requests
            self._noted = latest
        if self._lost_s is not None:
            rospy.loginfo("health: the ROS master answers after %.1f s", time.monotonic() - self._lost_s)
            self._lost_s = None

    def _restore(self):
        nodes, parameters = self._master.restore(self._noted)
        rospy.loginfo("health: the ROS master started again; it has the registrations of %d nodes and %d parameters back",
                      len(nodes), parameters)
        gone = sorted(set(self._noted.nodes) - set(nodes))
        if gone:
            rospy.logwarn("health: not registered again, since they ended or are registered already: %s", ", ".join(gone))

    def _lose(self, error):
        if self._lost_s is None:
            self._lost_s = time.monotonic()
            rospy.logerr("health: no ROS master at %s (%s): what runs goes on, what starts waits for it. Start it again at the same port, "
                         "and it gets back what it knew", self._uri, error)
