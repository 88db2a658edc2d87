"""A ROS master and a roslaunch of our own: free port, own ROS_HOME, ended by process id."""

import os
import re
import signal
import socket
import subprocess
import sys
import tempfile
import time

MASTER_S = 120.0  # for a master to answer, also where processors are slow or few; one that ends is noticed at once

_COLOR = re.compile(r"\x1b\[[0-9;]*m")
_NOISE = re.compile(r"Failed to load nodelet|REQUIRED process|Initiating shutdown|^=+$|bond broken")


class Stalled(Exception):
    """What should have happened did not, within a time that is long for every machine."""


def free_port():
    """A TCP port of the loopback interface that no one uses now."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


def end_launch(process):
    """Ends a roslaunch with its nodes: politely first, for good after 15 s."""
    process.send_signal(signal.SIGINT)
    try:
        process.wait(15)
    except subprocess.TimeoutExpired:
        process.kill()
        process.wait()


class RosSession:
    """Runs `roslaunch` with a private master; use as a context manager."""

    def __init__(self, log_file):
        self.port = free_port()
        self.log_file = log_file
        self.home = tempfile.TemporaryDirectory(prefix="extperfc_ros_")
        self.process = self.master = None
        os.environ.update(ROS_MASTER_URI=f"http://127.0.0.1:{self.port}", ROS_IP="127.0.0.1", ROS_HOME=self.home.name)
        os.environ.pop("ROS_HOSTNAME", None)

    def start_master(self):
        """A master apart from roslaunch, which either can outlive. Returns when it answers."""
        self.master = subprocess.Popen(["rosmaster", "--core", "-p", str(self.port)], stdout=subprocess.DEVNULL,
                                       stderr=subprocess.DEVNULL, stdin=subprocess.DEVNULL)
        self.wait_for_master()

    def kill_master(self):
        self.master.kill()
        self.master.wait()

    def launch(self, package, launch_file, **arguments):
        """Starts a launch file of a package, or one given by its path (package None); arguments are its `name:=value`
        pairs."""
        command = ["roslaunch", "-p", str(self.port), *([package] if package else []), str(launch_file)]
        command += [f"{name}:={value}" for name, value in arguments.items()]
        with open(self.log_file, "w") as log:
            self.process = subprocess.Popen(command, stdout=log, stderr=subprocess.STDOUT, stdin=subprocess.DEVNULL)

    def wait_for_master(self):
        """Until the master answers; raises Stalled."""
        import rosgraph
        starting, deadline = self.process or self.master, time.monotonic() + MASTER_S
        while not rosgraph.is_master_online():
            if starting.poll() is not None or time.monotonic() > deadline:
                raise Stalled("the ROS master does not start")
            time.sleep(0.05)

    def join(self, node, simulated=True):
        """This process becomes a node, by simulated time or not; raises Stalled when the master does not answer."""
        self.wait_for_master()
        import rospy
        if simulated:
            rospy.set_param("/use_sim_time", True)  # the launch may not have come to it yet, and a node asks once
        rospy.init_node(node, disable_signals=True)

    def alive(self):
        return self.process is not None and self.process.poll() is None

    def errors(self):
        """What the log reports to have gone wrong, without colours and stamps. Such a report may begin within a line: a program's
        standard output comes in blocks, whose ends are not those of lines."""
        with open(self.log_file, errors="replace") as log:
            text = _COLOR.sub("", log.read())
        found = []
        for match in re.finditer(r"\[\s*(FATAL|ERROR)\] \[[\d., ]*\]:? ?(.*(?:\n  .*)*)", text):
            if match.group(2) not in found and not _NOISE.search(match.group(2)):
                found.append(match.group(2))
        return found

    def close(self):
        """Ends what was started."""
        if self.alive():
            end_launch(self.process)
        if self.master is not None:
            self.kill_master()
        self.home.cleanup()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()


def run_trial(out, body, *failures):
    """The exit code of `body(session)` with a session that logs into the folder `out`. When it stalls, or raises one of
    `failures`, the reasons go to stderr and the code is 1."""
    import rospy
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(143))  # so that what was started ends, too
    out.mkdir(parents=True, exist_ok=True)
    with RosSession(out / "launch.log") as session:
        try:
            return body(session)
        except (Stalled, *failures) as error:
            for line in session.errors() or [f"{error}; see {session.log_file}"]:
                print("error: " + line, file=sys.stderr)
            return 1
        except KeyboardInterrupt:
            return 130
        finally:
            rospy.signal_shutdown("done")
