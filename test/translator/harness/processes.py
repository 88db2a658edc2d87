"""Masters, nodes and the translator as child processes, ended by process id."""

import collections
import contextlib
import http.client
import os
import pathlib
import re
import signal
import socket
import struct
import subprocess
import tempfile
import threading
import time
import xmlrpc.client

REPO = pathlib.Path(__file__).resolve().parents[3]
WS = pathlib.Path(os.environ.get("EXTPERFC_WS", REPO / ".ws"))
PROGRAMS = WS / "devel" / "lib" / "extperfc"
ERAS = WS / "build" / "extperfc" / "test" / "translator" / "eras"
PUPPET = REPO / "test" / "translator" / "puppet.py"
PYTHON = "/usr/bin/python3"


class TooLate(AssertionError):
    """A condition that did not come true in time."""


def wait_until(condition, seconds, what):
    """Returns the condition's first true value."""
    deadline = time.monotonic() + seconds
    while True:
        value = condition()
        if value:
            return value
        if time.monotonic() > deadline:
            raise TooLate(f"not within {seconds} s: {what() if callable(what) else what}")
        time.sleep(0.01)


class Child:
    """A process in a place, with its output in a log file."""

    def __init__(self, name, place, arguments, log_folder, environment, **popen):
        self.name = name
        self.log = pathlib.Path(log_folder) / f"{name}.log"
        with open(self.log, "a") as log:
            popen.setdefault("stdout", log)
            popen.setdefault("stdin", subprocess.DEVNULL)
            self.process = subprocess.Popen(place.command(arguments), stderr=log, env=environment, **popen)

    @property
    def pid(self):
        return self.process.pid  # nsenter replaces itself by the program

    def alive(self):
        return self.process.poll() is None

    def kill(self):
        """Without any chance to say goodbye."""
        self.process.kill()
        self.process.wait()

    def end(self):
        """Politely first, for good after 5 s."""
        if self.alive():
            self.process.send_signal(signal.SIGCONT)
            self.process.send_signal(signal.SIGINT)
            try:
                self.process.wait(5)
            except subprocess.TimeoutExpired:
                self.kill()

    def log_tail(self, lines=15):
        return "\n".join(self.log.read_text(errors="replace").splitlines()[-lines:])

    def memory_mb(self):
        text = pathlib.Path(f"/proc/{self.pid}/status").read_text()
        return int(re.search(r"VmRSS:\s+(\d+) kB", text).group(1)) / 1024

    def open_files(self):
        return len(os.listdir(f"/proc/{self.pid}/fd"))


class Master:
    """A rosmaster at a fixed port, so that it can come back there."""

    def __init__(self, name, place, folder):
        self.name, self.place, self.folder = name, place, folder
        with place.inside(), socket.socket() as probe:
            probe.bind((place.address, 0))
            self.port = probe.getsockname()[1]
        self.uri = f"http://{place.address}:{self.port}"
        self.child = None

    def environment(self):
        """What a node at this master needs."""
        home = pathlib.Path(self.folder) / f"home_{self.name}"
        home.mkdir(exist_ok=True)
        environment = dict(os.environ, ROS_MASTER_URI=self.uri, ROS_IP=self.place.address, ROS_HOME=str(home),
                           ROS_LOG_DIR=str(home / "log"), PYTHONUNBUFFERED="1")
        environment.pop("ROS_HOSTNAME", None)
        return environment

    def start(self):
        arguments = ["rosmaster", "--core", "-p", str(self.port)]
        self.child = Child(f"master_{self.name}", self.place, arguments, self.folder, self.environment())
        wait_until(lambda: self.ask("getPid", quiet=True), 20, lambda: "master: " + self.child.log_tail())
        return self

    def ask(self, method, *arguments, quiet=False):
        """The value that the master answers with; None when it fails and `quiet`."""
        try:
            with self.place.inside(), xmlrpc.client.ServerProxy(self.uri) as proxy:
                code, text, value = getattr(proxy, method)("/harness", *arguments)
        except (OSError, http.client.HTTPException):
            if quiet:
                return None
            raise
        if code != 1:
            if quiet:
                return None
            raise RuntimeError(f"{method}{arguments}: {text}")
        return value

    def nodes(self, kind, name):
        """Who publishes (0), subscribes (1) or serves (2) a name."""
        state = self.ask("getSystemState")
        return next((who for listed, who in state[kind] if listed == name), [])

    def kill(self):
        self.child.kill()

    def end(self):
        if self.child:
            self.child.end()


class Event(list):
    """Arguments that a puppet reported, and when they were received [s since 1970]."""

    def __init__(self, heard_at, arguments):
        super().__init__(arguments)
        self.heard_at = heard_at


class Puppet(Child):
    """A node of an era: puppet.py or era_node_<era>; the protocol is in puppet.py."""

    def __init__(self, name, era, language, master):
        environment = master.environment()
        arguments = [str(PROGRAMS / f"era_node_{era}")]
        if language == "python":
            arguments = [PYTHON, str(PUPPET)]
            environment["PYTHONPATH"] = f"{ERAS / era / 'python'}:{environment.get('PYTHONPATH', '')}"
        self._events, self._last_line, self._lock = collections.defaultdict(list), "", threading.Condition()
        super().__init__(name, master.place, [*arguments, f"__name:={name}"], master.folder, environment,
                         stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, bufsize=1)
        self.era, self.language = era, language
        self._reader = threading.Thread(target=self._read, daemon=True)
        self._reader.start()

    def _read(self):
        for line in self.process.stdout:
            tokens = line.split() or [""]
            with self._lock:
                key = tokens[0] if tokens[0] in ("ok", "error") else tuple(tokens[:2])
                self._events[key].append(Event(time.time(), tokens[2:]))
                self._last_line = line[:160]
                self._lock.notify_all()

    def wait_ready(self, seconds=30):
        self._wait(lambda: ("ready",) in self._events, seconds, "ready")
        return self

    def _wait(self, condition, seconds, what):
        with self._lock:
            if not self._lock.wait_for(lambda: condition() or not self.alive(), seconds) or not condition():
                raise TooLate(f"{self.name}: not within {seconds} s: {what}\nlast line: {self._last_line}\n"
                              f"{self.log_tail()}")

    def send(self, *arguments):
        """Gives a command and waits until it is obeyed."""
        obeyed, failed = self._events["ok"], self._events["error"]
        before = len(obeyed), len(failed)
        command = " ".join(map(str, arguments))
        self.process.stdin.write(command + "\n")
        self.process.stdin.flush()
        self._wait(lambda: (len(obeyed), len(failed)) != before, 20, f"an answer to {command[:120]}")
        if len(failed) != before[1]:
            raise RuntimeError(f"{self.name} cannot {command[:120]}: {' '.join(failed[-1])}\n{self.log_tail()}")

    def heard(self, kind, name):
        """The events of a kind about a name, without those two tokens."""
        with self._lock:
            return list(self._events[kind, name])

    def texts(self, topic):
        """The texts of a topic's std_msgs/String."""
        return [bytes.fromhex(content[9:]).decode() for _, content in self.heard("message", topic)]

    def ages(self, topic, first=0):
        """How old the messages of a topic were that another node streams [s], from the one with number `first` on."""
        return [event.heard_at - struct.unpack("<d", bytes.fromhex(event[1][1:]))[0]
                for event in self.heard("message", topic)[first:]]

    def wait_for(self, kind, name, count=1, seconds=15):
        """At least `count` events, in order."""
        self._wait(lambda: len(self._events[kind, name]) >= count, seconds, f"{count} x {kind} {name}")
        return self.heard(kind, name)

    def ask_to_end(self):
        """Returns at once; end() waits for it."""
        if self.alive():
            with contextlib.suppress(OSError):
                self.process.send_signal(signal.SIGCONT)
                self.process.stdin.close()

    def end(self):
        self.ask_to_end()
        try:
            self.process.wait(3)
        except subprocess.TimeoutExpired:
            self.kill()
        self._reader.join(2)
        self.process.stdout.close()


class Folder:
    """A temporary folder for logs and ROS_HOMEs; kept when the environment says EXTPERFC_KEEP."""

    def __init__(self):
        self.path = pathlib.Path(tempfile.mkdtemp(prefix="extperfc_translator_"))

    def close(self):
        if "EXTPERFC_KEEP" not in os.environ:
            subprocess.run(["rm", "-rf", str(self.path)], check=False)
