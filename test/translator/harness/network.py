"""Places where processes run: network namespaces joined by cables, or this host itself."""

import contextlib
import ctypes
import os
import subprocess

_CLONE_NEWNET = 0x40000000


def separate_networks_work():
    """None when network namespaces can be made here, else why not."""
    if os.geteuid() != 0:
        return "network namespaces need root"
    tried = subprocess.run(["unshare", "--net", "ip", "link", "add", "near0", "type", "veth", "peer", "name", "far0"],
                           capture_output=True, text=True)
    return None if tried.returncode == 0 else "network namespaces do not work here: " + tried.stderr.strip()


class Host:
    """This computer's own network."""
    address = "127.0.0.1"

    def command(self, arguments):
        return arguments

    @contextlib.contextmanager
    def inside(self):
        yield

    def close(self):
        pass


class Namespace:
    """A network of its own. It lives as long as the process that holds it, which ends with this one."""

    def __init__(self, address=None):
        self.address = address
        self._holder = subprocess.Popen(["unshare", "--net", "sh", "-c", "ip link set lo up && echo up && exec cat"],
                                        stdin=subprocess.PIPE, stdout=subprocess.PIPE)
        if self._holder.stdout.readline() != b"up\n":
            raise RuntimeError("no network namespace: unshare --net failed")
        self._file = f"/proc/{self._holder.pid}/ns/net"

    @property
    def pid(self):
        return self._holder.pid

    def command(self, arguments):
        """A command line that runs `arguments` in here."""
        return ["nsenter", f"--net={self._file}", "--", *map(str, arguments)]

    def run(self, *arguments):
        subprocess.run(self.command(arguments), check=True, capture_output=True, text=True)

    @contextlib.contextmanager
    def inside(self):
        """Sockets that this thread makes meanwhile belong to this network."""
        libc = ctypes.CDLL(None, use_errno=True)
        with open("/proc/thread-self/ns/net") as before, open(self._file) as there:
            if libc.setns(there.fileno(), _CLONE_NEWNET) != 0:
                raise OSError(ctypes.get_errno(), "setns")
            try:
                yield
            finally:
                libc.setns(before.fileno(), _CLONE_NEWNET)

    def close(self):
        if self._holder.poll() is None:
            self._holder.stdin.close()
            self._holder.wait()
        self._holder.stdout.close()


class Cable:
    """A veth pair between two namespaces, which get an address each."""

    def __init__(self, name, ends, addresses):
        self.ends = [(place, f"{name}{index}") for index, place in enumerate(ends)]
        (first, near), (second, far) = self.ends
        subprocess.run(["ip", "link", "add", near, "netns", str(first.pid), "type", "veth",
                        "peer", "name", far, "netns", str(second.pid)], check=True, capture_output=True, text=True)
        for (place, device), address in zip(self.ends, addresses):
            place.run("ip", "address", "add", address + "/24", "dev", device)
            place.run("ip", "link", "set", device, "up")

    def cut(self):
        """Everything is lost silently, both ways."""
        for place, device in self.ends:
            place.run("tc", "qdisc", "replace", "dev", device, "root", "blackhole")

    def pull(self):
        """Both ends lose their carrier, and the second one its routes."""
        place, device = self.ends[1]
        place.run("ip", "link", "set", device, "down")

    def plug(self):
        place, device = self.ends[1]
        place.run("ip", "link", "set", device, "up")

    def slow(self, kbit_per_s):
        for place, device in self.ends:
            place.run("tc", "qdisc", "replace", "dev", device, "root", "tbf", "rate", f"{kbit_per_s}kbit",
                      "burst", "32kbit", "latency", "200ms")

    def mend(self):
        for place, device in self.ends:
            place.run("tc", "qdisc", "delete", "dev", device, "root")


class SeparateNetworks:
    """The robot's network, the workstation's, and a computer between them: no packet goes from one to the other."""

    def __init__(self):
        self.robot, self.workstation, self.between = Namespace("10.91.1.2"), Namespace("10.91.2.2"), Namespace()
        self.robot_cable = Cable("robot", (self.between, self.robot), ("10.91.1.1", self.robot.address))
        self.workstation_cable = Cable("workstation", (self.between, self.workstation),
                                       ("10.91.2.1", self.workstation.address))
        self.addresses_between = {"robot": "10.91.1.1", "workstation": "10.91.2.1"}

    def close(self):
        for place in (self.robot, self.workstation, self.between):
            place.close()


class OneHost:
    """Both masters on this host, at two ports."""

    def __init__(self):
        self.robot = self.workstation = self.between = Host()
        self.addresses_between = {"robot": "127.0.0.1", "workstation": "127.0.0.1"}

    def close(self):
        pass


class LinkedNetworks:
    """The robot's network and one for all that runs here, with a cable between them. Without a right to networks both are this host,
    and there is no cable: why_not says why."""

    def __init__(self):
        self.why_not = separate_networks_work()
        self.cable = None
        if self.why_not:
            self.here = self.robot = Host()
            return
        self.here, self.robot = Namespace("10.92.1.1"), Namespace("10.92.1.2")
        self.cable = Cable("cable", (self.here, self.robot), (self.here.address, self.robot.address))

    def close(self):
        self.robot.close()
        self.here.close()
