"""Processes of this machine that are ROS nodes of one master, and the nodelet loaders among them, read from /proc."""

import dataclasses
import os
import pathlib
import typing


@dataclasses.dataclass(frozen=True)
class Process:
    """A ROS node. started: ticks since boot, which tell it from a later process with the same pid. manager: of a nodelet's
    loader, the node that it loads into."""
    pid: int
    started: int
    node: str
    manager: typing.Optional[str] = None


def resolve(name, namespace):
    """A ROS name as roscpp resolves it, without remappings."""
    return name if name.startswith("/") else f"{namespace.rstrip('/')}/{name}"


def node_of(arguments, environment):
    """(name, manager) of a command line and its environment; None where it is no node that roslaunch started."""
    names = [argument[len("__name:="):] for argument in arguments if argument.startswith("__name:=")]
    if not names:
        return None
    namespace = "/" + environment.get("ROS_NAMESPACE", "").strip("/")
    manager = None
    if "load" in arguments[1:3]:
        plain = [argument for argument in arguments[arguments.index("load") + 1:] if ":=" not in argument and argument[:2] != "--"]
        manager = resolve(plain[1], namespace) if len(plain) > 1 else None
    return resolve(names[-1], namespace), manager


def _split(data):
    return [part for part in data.decode(errors="replace").split("\0") if part]


class ProcessTable:
    """The nodes of a master on this machine."""

    def __init__(self, master_uri, root="/proc"):
        self._master_uri = master_uri.rstrip("/")
        self._root = pathlib.Path(root)
        self._known = {}  # (pid, started) -> Process or None

    def alive(self, process):
        return self._started(process.pid) == process.started

    def scan(self):
        """{name: Process} of every node that lives."""
        known = {}
        for entry in os.listdir(self._root):
            started = self._started(entry) if entry.isdigit() else None
            if started is not None:
                key = int(entry), started
                known[key] = self._known[key] if self._known.get(key) else self._read(*key)
        self._known = known
        return self._by_name(known.values())

    def scan_known(self):
        """The same without nodes that are new since scan(): a tenth of its cost."""
        self._known = {key: process for key, process in self._known.items() if process is None or self.alive(process)}
        return self._by_name(self._known.values())

    @staticmethod
    def _by_name(processes):
        return {process.node: process for process in sorted(filter(None, processes), key=lambda found: found.started)}

    def _started(self, pid):
        """When a process started; None when it ended, also before its parent took notice."""
        try:
            fields = (self._root / str(pid) / "stat").read_bytes().rpartition(b")")[2].split()
        except OSError:
            return None
        return int(fields[19]) if len(fields) > 19 and fields[0] not in (b"Z", b"X") else None

    def _read(self, pid, started):
        folder = self._root / str(pid)
        try:
            arguments = _split((folder / "cmdline").read_bytes())
            if not any(argument.startswith("__name:=") for argument in arguments):
                return None
            environment = dict(item.partition("=")[::2] for item in _split((folder / "environ").read_bytes()))
        except OSError:
            return None
        found = node_of(arguments, environment)
        if found is None or environment.get("ROS_MASTER_URI", "").rstrip("/") != self._master_uri:
            return None
        return Process(pid, started, *found)
