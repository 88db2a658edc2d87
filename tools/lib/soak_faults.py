"""What goes wrong in the soak of the translator: each fault is over when its method returns."""

import contextlib
import os
import signal
import socket
import time
import urllib.parse
import xmlrpc.client

_GARBAGE = (b"\x00" * 64, b"\xff\xff\xff\xff" + b"x" * 1000, b"GET / HTTP/1.1\r\nContent-Length: 99999999999\r\n\r\n",
            b"POST /RPC2 HTTP/1.0\r\nContent-Length: 30\r\n\r\n<methodCall><methodName>x<<<<<", b"\x10\x00\x00\x00\xf0\xff\xff\xffabcdefghij")


class Faults:
    """Injects faults into a running soak; `lengths_s` are those of pauses and outages."""

    def __init__(self, soak, random, lengths_s):
        self._soak, self._random, self._lengths = soak, random, lengths_s
        self.all = [self.master_restarts, self.talker_dies, self.listener_dies, self.listener_stops, self.garbage]
        if soak.session.separate:
            self.all.append(self.network_drops)

    def _side(self):
        return self._random.choice(("robot", "workstation"))

    def shuffled(self):
        """Endless: every fault once, in random order, then again."""
        while True:
            order = list(self.all)
            self._random.shuffle(order)
            yield from order

    def master_restarts(self):
        """With its nodes, as when a robot is started again."""
        side = self._side()
        master = getattr(self._soak.session, side)
        master.kill()
        time.sleep(1.0)
        self._soak.kill(f"talker_{side}")
        self._soak.kill(f"listener_{side}")
        master.start()
        self._soak.start(f"talker_{side}", f"listener_{side}")
        return f"master of {side} and its nodes restart"

    def talker_dies(self):
        return self._dies(f"talker_{self._side()}")

    def listener_dies(self):
        return self._dies(f"listener_{self._side()}")

    def _dies(self, name):
        self._soak.kill(name)
        time.sleep(self._random.uniform(0.0, 1.0))
        self._soak.start(name)
        return f"{name} killed, restarts"

    def listener_stops(self):
        name, length_s = f"listener_{self._side()}", self._random.choice(self._lengths)
        pid = self._soak.nodes[name].pid
        os.kill(pid, signal.SIGSTOP)
        time.sleep(length_s)
        os.kill(pid, signal.SIGCONT)
        return f"{name} stopped for {length_s:g} s"

    def network_drops(self):
        side, length_s = self._side(), self._random.choice(self._lengths)
        cable = getattr(self._soak.session.network, side + "_cable")
        cable.cut()
        time.sleep(length_s)
        cable.mend()
        return f"network of {side} down for {length_s:g} s"

    def garbage(self):
        """At the translator's XML-RPC and TCPROS ports, as the master and the slave API name them."""
        side = self._side()
        master = getattr(self._soak.session, side)
        places = self._ports(master)
        for host, port in places * 4:
            with contextlib.suppress(OSError), master.place.inside(), socket.create_connection((host, port), 1.0) as probe:
                probe.sendall(self._random.choice(_GARBAGE))
                probe.settimeout(0.05)
                with contextlib.suppress(OSError):
                    probe.recv(1000)
        return f"garbage at {len(places)} ports of {side}"

    def _ports(self, master):
        uri = master.ask("lookupNode", self._soak.translator.node, quiet=True)
        if not uri:
            return []
        at = urllib.parse.urlparse(uri)
        places = [(at.hostname, at.port)]
        other = "workstation" if master is self._soak.session.robot else "robot"
        with contextlib.suppress(OSError, xmlrpc.client.Error), master.place.inside(), xmlrpc.client.ServerProxy(uri) as node:
            code, _, answer = node.requestTopic("/soak", f"/soak/{other}/pass", [["TCPROS"]])
            if code == 1:
                places.append((answer[1], answer[2]))
        return places
