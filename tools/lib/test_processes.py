"""Processes that tests run in: a limit of time each, a deadline for the whole run, and the runners of each kind of test.

A runner is a function of a log file that runs one test and returns its Counts.
"""

import json
import os
import pathlib
import signal
import socket
import subprocess
import tempfile
import time

from junit_counts import Counts, counts_of_junit, counts_of_unittest

REPO = pathlib.Path(__file__).resolve().parents[2]
DEADLINE = float(os.environ.get("EXTPERFC_TEST_DEADLINE", "inf"))


class OutOfTime(Exception):
    """The deadline of the whole run has come."""


def stepping_aside(command):
    """The command so that it gives way to all others. Sessions count as a whole where the kernel groups them."""
    return ["/bin/sh", "-c", 'echo 19 2>/dev/null > /proc/self/autogroup; exec nice -n 19 "$@"', "sh", *command]


def run(command, log, timeout_s, **kwargs):
    """Runs a command with its output in `log`; returns its exit code, 124 when it ran too long (and was ended).
    Raises OutOfTime at the deadline of the whole run."""
    left_s = DEADLINE - time.time()
    if left_s <= 0:
        raise OutOfTime
    with open(log, "a") as stream:
        process = subprocess.Popen(command, stdout=stream, stderr=subprocess.STDOUT, stdin=subprocess.DEVNULL,
                                   start_new_session=True, **kwargs)
        try:
            return process.wait(min(timeout_s, left_s))
        except subprocess.TimeoutExpired:
            end_group(process)
            if left_s < timeout_s:
                raise OutOfTime from None
            stream.write(f"\nended after {timeout_s} s\n")
            return 124


def end_group(process):
    """Ends a process and those of its session: politely first, for good after 10 s."""
    os.killpg(process.pid, signal.SIGTERM)
    try:
        process.wait(10)
    except subprocess.TimeoutExpired:
        os.killpg(process.pid, signal.SIGKILL)
        process.wait()


def run_in_time(runner, log, reason="left out: the time of the whole run is over"):
    """A test's counts; one skipped, for `reason`, when the deadline came first."""
    try:
        return runner(log)
    except OutOfTime:
        note_skipped(log, reason)
        return Counts(0, 0, 1)


def note_skipped(log, reason):
    """Writes why something was skipped where the report looks for it."""
    with open(log, "a") as stream:
        stream.write(f"\nskipped '{reason}'\n")


def ctest_list(build):
    """(name, command or None) of the tests that a build folder registers; without a command they are not built."""
    listed = subprocess.run(["ctest", "--show-only=json-v1"], cwd=build, capture_output=True, text=True, check=True)
    return [(test["name"], test.get("command")) for test in json.loads(listed.stdout)["tests"]]


def gtest_runner(command, **more_environment):
    """A GoogleTest program."""
    def runner(log):
        with tempfile.TemporaryDirectory() as folder:
            environment = dict(os.environ, GTEST_OUTPUT=f"xml:{folder}/", GTEST_COLOR="no", **more_environment)
            code = run(command, log, 180, env=environment)
            return counts_of_junit(pathlib.Path(folder).glob("*.xml"), code)
    return runner


def unittest_runner(file, timeout_s, with_long=True, aside=False):
    """A Python file; without its long scenarios unless `with_long`; `aside`: it gives way to all others."""
    def runner(log):
        places = [str(REPO / "src"), str(REPO / "tools" / "lib"), os.environ.get("PYTHONPATH", "")]
        environment = dict(os.environ, PYTHONPATH=os.pathsep.join(places))
        command = ["/usr/bin/python3", str(REPO / "tools/lib/run_unittest_file.py"), file.stem]
        command += ["--with-long"] * with_long
        code = run(stepping_aside(command) if aside else command, log, timeout_s, cwd=file.parent, env=environment)
        return counts_of_unittest(pathlib.Path(log).read_text(errors="replace"), code)
    return runner


def rostest_runner(file):
    """A rostest file, with its own master and ROS_HOME."""
    def runner(log):
        with tempfile.TemporaryDirectory(prefix="extperfc_ros_") as home:
            with socket.socket() as probe:
                probe.bind(("127.0.0.1", 0))
                port = probe.getsockname()[1]
            environment = dict(os.environ, ROS_HOME=home, ROS_IP="127.0.0.1",
                               ROS_MASTER_URI=f"http://127.0.0.1:{port}")
            environment.pop("ROS_HOSTNAME", None)
            code = run(["rostest", "--results-base-dir", home + "/results", str(file)], log, 240, env=environment)
            results = [f for f in pathlib.Path(home).rglob("*.xml") if not f.name.startswith("rostest-")]
            return counts_of_junit(results, code)
    return runner


def step_runner(commands, timeout_s, aside=False):
    """One test that passes when every command exits with 0; `aside`: they give way to all others."""
    def runner(log):
        for command in commands:
            if run(stepping_aside(command) if aside else command, log, timeout_s, cwd=REPO) != 0:
                return Counts(0, 1, 0)
        return Counts(1, 0, 0)
    return runner


