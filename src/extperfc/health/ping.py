"""Asks nodes without diagnostics whether they live."""

import http.client
import threading
import xmlrpc.client

import rosgraph
from diagnostic_msgs.msg import DiagnosticStatus

TIMEOUT_S = 1.0
FAILURES = (OSError, http.client.HTTPException, xmlrpc.client.Error)  # of a call of an XML-RPC server that is not there or not well


class _Transport(xmlrpc.client.Transport):
    def __init__(self, timeout_s):
        super().__init__()
        self._timeout_s = timeout_s

    def make_connection(self, host):
        connection = super().make_connection(host)
        connection.timeout = self._timeout_s
        return connection


def proxy(uri, timeout_s=TIMEOUT_S):
    """An xmlrpc.client.ServerProxy, whose calls raise one of FAILURES, after timeout_s at the latest."""
    return xmlrpc.client.ServerProxy(uri, transport=_Transport(timeout_s))


def answers(uri, caller):
    """Whether the node at this URI answers getPid within TIMEOUT_S."""
    try:
        with proxy(uri) as node:
            return node.getPid(caller)[0] == 1
    except FAILURES:
        return False


class Pinger(threading.Thread):
    """Calls `report` with a status `<node>: ping` for every node that answers, every period."""

    def __init__(self, caller, nodes, period_s, report):
        super().__init__(daemon=True)
        self._caller, self._nodes, self._period_s, self._report = caller, nodes, period_s, report
        self._uris = {}
        self._ended = threading.Event()

    def stop(self):
        self._ended.set()

    def run(self):
        master = rosgraph.Master(self._caller)
        while not self._ended.wait(self._period_s):
            for node in self._nodes:
                uri = self._uri(master, node)
                if uri and answers(uri, self._caller):
                    self._report(DiagnosticStatus(level=DiagnosticStatus.OK, name=f"{node[1:]}: ping", message="answers"))

    def _uri(self, master, node):
        """The last known one while the master does not answer; None: the master does not know the node."""
        try:
            self._uris[node] = master.lookupNode(node)
        except rosgraph.MasterException:
            self._uris.pop(node, None)
        except FAILURES:
            pass
        return self._uris.get(node)
