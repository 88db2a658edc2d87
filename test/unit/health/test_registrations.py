"""A ROS master that starts again gets back what it knew. The master is rosmaster's; the nodes answer as nodes do."""

import socket
import socketserver
import subprocess
import sys
import threading
import unittest
import xmlrpc.server

from extperfc.health.master_keeper import MasterKeeper
from extperfc.health.registrations import Master, missing

ME = "/health"
PROGRAM = """
import sys, time, rosmaster.master
rosmaster.master.Master(int(sys.argv[1])).start()
print("started", flush=True)
while True:
    time.sleep(60)
"""


class Server(socketserver.ThreadingMixIn, xmlrpc.server.SimpleXMLRPCServer):
    daemon_threads = True


class Node:
    """Answers what a master and health ask a node."""

    def __init__(self, case):
        self.updates = []  # (topic, publishers)
        self._server = Server(("127.0.0.1", 0), logRequests=False)
        self._server.register_function(lambda caller: (1, "", 7), "getPid")
        self._server.register_function(self._update, "publisherUpdate")
        self.uri = f"http://127.0.0.1:{self._server.server_address[1]}/"
        self._thread = threading.Thread(target=self._server.serve_forever, kwargs={"poll_interval": 0.01})
        self._thread.start()
        case.addCleanup(self.end)

    def _update(self, caller, topic, publishers):
        self.updates.append((topic, sorted(publishers)))
        return 1, "", 0

    def end(self):
        self._server.shutdown()
        self._thread.join()
        self._server.server_close()


class RestartedMaster(unittest.TestCase):
    def setUp(self):
        with socket.socket() as probe:
            probe.bind(("127.0.0.1", 0))
            self.port = probe.getsockname()[1]
        self.start()
        self.nodes = {name: Node(self) for name in (ME, "/lidar", "/camera", "/mapper")}
        lidar, camera, mapper = (self.nodes[name].uri for name in ("/lidar", "/camera", "/mapper"))
        self.ask(("setParam", ME, "/mapper", {"resolution": 0.05, "frames": {"map": "map"}}), ("setParam", ME, "/use_sim_time", True),
                 ("registerPublisher", ME, "/diagnostics_agg", "diagnostic_msgs/DiagnosticArray", self.nodes[ME].uri),
                 ("registerPublisher", "/lidar", "/tf", "tf2_msgs/TFMessage", lidar),
                 ("registerPublisher", "/camera", "/tf", "tf2_msgs/TFMessage", camera),
                 ("registerSubscriber", "/mapper", "/tf", "tf2_msgs/TFMessage", mapper),
                 ("registerSubscriber", "/mapper", "/unheard", "*", mapper),
                 ("registerService", "/mapper", "/save_map", "rosrpc://127.0.0.1:5", mapper))

    def start(self):
        self.process = subprocess.Popen([sys.executable, "-c", PROGRAM, str(self.port)], stdout=subprocess.PIPE)
        self.addCleanup(self.end)
        self.assertEqual(b"started\n", self.process.stdout.readline())
        self.master = Master(f"http://127.0.0.1:{self.port}", ME)

    def end(self):
        self.process.kill()
        self.process.wait()
        self.process.stdout.close()

    def ask(self, *calls):
        return self.master.ask(*calls)

    def restart(self, meanwhile=lambda: None):
        """Registrations before; `meanwhile` happens while there is no master."""
        noted = self.master.read()
        self.end()
        meanwhile()
        self.start()
        self.assertFalse(self.master.knows("/lidar"))
        for node in self.nodes.values():
            node.updates.clear()
        return noted

    def test_everything_is_back(self):
        noted = self.restart()
        nodes, parameters = self.master.restore(noted)
        self.assertEqual((sorted(self.nodes), 2), (nodes, parameters))
        self.assertEqual(noted, self.master.read())
        self.assertEqual([], self.nodes["/mapper"].updates, "its connections were as they should")

    def test_what_the_new_master_knows_already_stays(self):
        noted = self.restart()
        self.ask(("setParam", ME, "/mapper/resolution", 0.1), ("setParam", ME, "/new", 1))
        self.master.restore(noted)
        self.assertEqual({"mapper": {"resolution": 0.1, "frames": {"map": "map"}}, "use_sim_time": True, "new": 1},
                         self.master.read().parameters)

    def test_a_node_that_ended_is_left_out_and_its_subscribers_hear_of_it(self):
        noted = self.restart(lambda: self.nodes.pop("/camera").end())
        self.assertEqual(sorted(self.nodes), self.master.restore(noted)[0])
        self.assertEqual(["/lidar"], self.master.read().publishers["/tf"])
        self.assertEqual([("/tf", [self.nodes["/lidar"].uri])], self.nodes["/mapper"].updates)

    def test_a_node_that_started_again_is_not_replaced_by_the_older_one(self):
        noted = self.restart()
        again = Node(self)
        self.ask(("registerPublisher", "/camera", "/tf", "tf2_msgs/TFMessage", again.uri))
        self.assertNotIn("/camera", self.master.restore(noted)[0])
        self.assertEqual(again.uri, self.master.read().nodes["/camera"])
        self.assertEqual([("/tf", sorted([self.nodes["/lidar"].uri, again.uri]))], self.nodes["/mapper"].updates)

    def test_the_keeper_says_that_there_is_no_master_and_restores_a_new_one(self):
        keeper = MasterKeeper(f"http://127.0.0.1:{self.port}", ME, 1.0)
        keeper.look()
        noted = self.master.read()

        def without():
            keeper.look()
            self.assertEqual("no ROS master", keeper.complaint)
        self.restart(without)
        keeper.look()
        self.assertEqual(("", noted), (keeper.complaint, self.master.read()))

    def test_a_keeper_that_started_after_the_master_restores_nothing(self):
        self.restart()
        MasterKeeper(f"http://127.0.0.1:{self.port}", ME, 1.0).look()
        self.assertEqual({}, self.master.read().nodes)


class Parameters(unittest.TestCase):
    def test_missing(self):
        self.assertEqual([("a/b/d", 2), ("e", {"f": 3})],
                         missing({"a": {"b": {"c": 1, "d": 2}}, "e": {"f": 3}, "g": 4, "h": {"i": 5}},
                                 {"a": {"b": {"c": 9}}, "g": {}, "h": 6}))


if __name__ == "__main__":
    unittest.main()
