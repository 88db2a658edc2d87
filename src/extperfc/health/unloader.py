"""Asks nodelet managers to unload nodelets, with a time limit."""

import threading
import time

import rospy
from nodelet.srv import NodeletUnload


class Unloader:
    """Requests run beside the caller, since a manager that hangs never answers."""

    def __init__(self, limit_s):
        self._limit_s = limit_s
        self._running = []  # (thread, manager, end)

    def unload(self, manager, nodelet):
        thread = threading.Thread(target=self._ask, args=(manager.node, nodelet), daemon=True)
        thread.start()
        self._running.append((thread, manager, time.monotonic() + self._limit_s))

    @staticmethod
    def _ask(manager, nodelet):
        try:
            rospy.ServiceProxy(f"{manager}/unload_nodelet", NodeletUnload)(nodelet)
        except rospy.ServiceException:
            pass  # the manager ended, or had unloaded the nodelet

    def overdue(self):
        """Managers that did not answer in time; each request counts once."""
        now = time.monotonic()
        late = [manager for thread, manager, end in self._running if thread.is_alive() and now > end]
        self._running = [entry for entry in self._running if entry[0].is_alive() and now <= entry[2]]
        return list(dict.fromkeys(late))
