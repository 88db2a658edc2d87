"""Asks nodes without diagnostics whether they live."""

import threading
import xmlrpc.client

import rosgraph
from diagnostic_msgs.msg import DiagnosticStatus

TIMEOUT_S = 1.0


class _Transport(xmlrpc.client.Transport):
    def make_connection(self, host):
        connection = super().make_connection(host)
        connection.timeout = TIMEOUT_S
        return connection


def answers(master, caller, node):
    """Whether a node answers getPid within TIMEOUT_S."""
    try:
        uri = master.lookupNode(node)
        with xmlrpc.client.ServerProxy(uri, transport=_Transport()) as proxy:
            return proxy.getPid(caller)[0] == 1
    except (OSError, xmlrpc.client.Error, rosgraph.MasterException):
        return False


class Pinger(threading.Thread):
    """Calls `report` with a status `<node>: ping` for every node that answers, every period."""

    def __init__(self, caller, nodes, period_s, report):
        super().__init__(daemon=True)
        self._caller, self._nodes, self._period_s, self._report = caller, nodes, period_s, report
        self._ended = threading.Event()

    def stop(self):
        self._ended.set()

    def run(self):
        master = rosgraph.Master(self._caller)
        while not self._ended.wait(self._period_s):
            for node in self._nodes:
                if answers(master, self._caller, node):
                    self._report(DiagnosticStatus(level=DiagnosticStatus.OK, name=f"{node[1:]}: ping", message="answers"))
