"""Runs tests and ends with the line `N passed, N failed, N skipped`.

  tools/test              everything
  tools/test unit         C++ and Python unit tests and the contract tests (under 3 minutes)
  tools/test ros          rostest suites
  tools/test core         the core without OpenVINO and MRPT: what meets them builds, and its unit tests pass
  tools/test sanitize     the core without ROS: unit tests with AddressSanitizer and UndefinedBehaviorSanitizer, threads
                          with ThreadSanitizer
  tools/test style        clang-format and clang-tidy
  tools/test system       tools/demo and the command-line tools
  tools/test NAME ...     every test whose name contains NAME, e.g. `tools/test decode`

A ros or system test that fails in a whole run is run once more, since those meet other programs' timing on a shared
machine. Both results are printed, the second one counts; --once leaves that out.

EXTPERFC_TEST_DEADLINE (seconds since 1970) bounds a whole run on a machine that ends it at some time: what has not
ended by then is printed as left out, and counts as skipped. Without it everything runs to its end, but for clang-tidy:
a whole run gives it 40 minutes beside the other tests, newest changes first; `tools/test tidy` reads all sources.
"""

import argparse
import collections
import json
import os
import pathlib
import re
import socket
import subprocess
import sys
import tempfile
import threading
import time
import xml.etree.ElementTree

import tidy

REPO = pathlib.Path(__file__).resolve().parents[2]
WS = pathlib.Path(os.environ.get("EXTPERFC_WS", REPO / ".ws"))
GROUPS = ("unit", "ros", "core", "sanitize", "style", "system")
JOBS = str(os.cpu_count() or 1)
TIDY_LIMIT_S = 2400  # of a whole run, beside the other tests
DEADLINE = float(os.environ.get("EXTPERFC_TEST_DEADLINE", "inf"))

Counts = collections.namedtuple("Counts", "passed failed skipped")
Test = collections.namedtuple("Test", "name group run")


class OutOfTime(Exception):
    """The deadline of the whole run has come."""


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
            os.killpg(process.pid, 15)
            try:
                process.wait(10)
            except subprocess.TimeoutExpired:
                os.killpg(process.pid, 9)
                process.wait()
            if left_s < timeout_s:
                raise OutOfTime from None
            stream.write(f"\nended after {timeout_s} s\n")
            return 124


def run_in_time(runner, log, reason="left out: the time of the whole run is over"):
    """A test's counts; one skipped, for `reason`, when the deadline came first."""
    try:
        return runner(log)
    except OutOfTime:
        with open(log, "a") as stream:
            stream.write(f"\nskipped '{reason}'\n")
        return Counts(0, 0, 1)


def counts_of_junit(files, return_code):
    """Counts of JUnit-like result files; a bad exit code without a failed case in them is one failure more."""
    passed = failed = skipped = 0
    for file in files:
        for case in xml.etree.ElementTree.parse(file).iter("testcase"):
            if case.find("failure") is not None or case.find("error") is not None:
                failed += 1
            elif case.find("skipped") is not None or case.get("status") == "notrun" or case.get("result") == "skipped":
                skipped += 1
            else:
                passed += 1
    if return_code != 0 and failed == 0:
        failed += 1
    if passed + failed + skipped == 0:
        failed = 1  # a test program that tests nothing
    return Counts(passed, failed, skipped)


def counts_of_unittest(log, return_code):
    """Counts from the closing lines of Python's unittest."""
    text = pathlib.Path(log).read_text(errors="replace")
    ran = re.findall(r"^Ran (\d+) tests?", text, re.M)
    closing = re.findall(r"^(?:OK|FAILED)(?: \((.*)\))?$", text, re.M)
    if not ran or not closing:
        return Counts(0, 1, 0)
    found = dict(re.findall(r"(\w+)=(\d+)", closing[-1].replace("expected failures", "expected")))
    failed = int(found.get("failures", 0)) + int(found.get("errors", 0))
    skipped = int(found.get("skipped", 0))
    if return_code != 0 and failed == 0:
        failed = 1
    return Counts(max(0, int(ran[-1]) - failed - skipped), failed, skipped)


def ctest_names(build):
    """Names of the tests that a build folder registers, built or not."""
    listed = subprocess.run(["ctest", "--show-only=json-v1"], cwd=build, capture_output=True, text=True, check=True)
    return [test["name"] for test in json.loads(listed.stdout)["tests"]]


def ctest_programs(build, prefix):
    """(name, command) of the GoogleTest programs that a build folder registers."""
    listed = subprocess.run(["ctest", "--show-only=json-v1"], cwd=build, capture_output=True, text=True, check=True)
    for test in json.loads(listed.stdout)["tests"]:
        if "command" in test:
            yield prefix + test["name"], test["command"]


def gtest_runner(command, **more_environment):
    def runner(log):
        with tempfile.TemporaryDirectory() as folder:
            environment = dict(os.environ, GTEST_OUTPUT=f"xml:{folder}/", GTEST_COLOR="no", **more_environment)
            code = run(command, log, 180, env=environment)
            return counts_of_junit(pathlib.Path(folder).glob("*.xml"), code)
    return runner


def unittest_runner(file, timeout_s):
    def runner(log):
        environment = dict(os.environ, PYTHONPATH=os.pathsep.join(
            [str(REPO / "src"), str(REPO / "tools" / "lib"), os.environ.get("PYTHONPATH", "")]))
        code = run(["/usr/bin/python3", "-m", "unittest", "-v", file.stem], log, timeout_s, cwd=file.parent,
                   env=environment)
        return counts_of_unittest(log, code)
    return runner


def rostest_runner(file):
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


def step_runner(commands, timeout_s):
    """One test that passes when every command exits with 0."""
    def runner(log):
        for command in commands:
            if run(command, log, timeout_s, cwd=REPO) != 0:
                return Counts(0, 1, 0)
        return Counts(1, 0, 0)
    return runner


def run_room(build, room, names, log):
    """Builds and runs those of the named tests that belong to a room; test unit/base/x is the program test_base_x."""
    names = [name for name in names if name.split("/")[1] == room]
    targets = ["test_" + name.split("/", 1)[1].replace("/", "_") for name in names]
    if run(["ninja", "-C", str(build), "-j", JOBS, *targets], log, 3600) != 0:
        return Counts(0, 1, 0)
    total = Counts(0, 0, 0)
    for test_name, command in ctest_programs(build, ""):
        if test_name in names:
            # The workspace's LD_LIBRARY_PATH would put its libraries before the variant's own.
            total = Counts(*map(sum, zip(total, gtest_runner(command, LD_LIBRARY_PATH="")(log))))
    return total


def variant_runner(name, cmake_options, pattern=""):
    """Builds the core in a folder of its own and runs its unit tests there."""
    def runner(log):
        build = WS / "variants" / name
        configure = ["cmake", "-S", str(REPO), "-B", str(build), "-G", "Ninja", "-DCMAKE_BUILD_TYPE=None", "-DCMAKE_CXX_FLAGS=-O1", "-DEXTPERFC_WITH_ROS=OFF", "-DEXTPERFC_WERROR=ON", "-DEXTPERFC_BENCHMARKS=OFF", *cmake_options]
        if run(configure, log, 120) != 0:
            return Counts(0, 1, 0)
        chosen_names = [name for name in ctest_names(build) if re.search(pattern, name)]
        total = Counts(0, 0, 0)
        # Room by room, so that what was ready counts when the time of the whole run is over.
        for room in dict.fromkeys(name.split("/")[1] for name in chosen_names):
            counts = run_in_time(lambda log, room=room: run_room(build, room, chosen_names, log), log,
                                 f"{room} left out: the time of the whole run is over")
            total = Counts(*map(sum, zip(total, counts)))
        return total
    return runner


def own_cpp_files():
    listed = subprocess.run(["git", "ls-files", "--cached", "--others", "--exclude-standard", "*.cpp", "*.hpp"],
                            cwd=REPO, capture_output=True, text=True)
    files = listed.stdout.split() if listed.returncode == 0 else []
    return [f for f in files or (str(p.relative_to(REPO)) for d in ("include", "src", "test")
                                 for p in (REPO / d).rglob("*.[ch]pp")) if (REPO / f).exists()]


def tidy_sources():
    """Sources that clang-tidy reads: our own code, not the tests."""
    return [f for f in own_cpp_files() if f.startswith("src/") and f.endswith(".cpp")]


def step_aside():
    """What waits for nothing gives way to tests that mostly wait. Sessions count as a whole where the kernel
    groups them."""
    os.nice(19)
    try:
        pathlib.Path("/proc/self/autogroup").write_text("19")
    except OSError:
        pass


class InBackground:
    """A test that runs beside the others, with what they leave of the processors, from start() on."""

    def __init__(self, runner):
        self.runner, self.thread, self.counts = runner, None, None

    def start(self, log):
        self.thread = threading.Thread(target=lambda: setattr(self, "counts", run_in_time(self.runner, log)), daemon=True)
        self.thread.start()

    def __call__(self, log):
        if self.thread is None:
            return self.runner(log)
        self.thread.join()
        return self.counts or Counts(0, 1, 0)


def tidy_runner(limit_s):
    """clang-tidy over the sources, a test each; findings in our headers count too. What `limit_s` and the deadline of
    the whole run leave no time for is skipped."""
    def runner(log):
        configure = ["cmake", "-S", str(WS / "src"), "-B", str(WS / "tidy"), "-G", "Ninja",
                     "-DCMAKE_EXPORT_COMPILE_COMMANDS=ON", "-DPYTHON_EXECUTABLE=/usr/bin/python3",
                     f"-DCATKIN_DEVEL_PREFIX={WS}/devel", "-DCATKIN_ENABLE_TESTING=OFF", "-DEXTPERFC_TESTS=OFF",
                     "-DEXTPERFC_BENCHMARKS=OFF", "-DCMAKE_DISABLE_PRECOMPILE_HEADERS=ON"]
        if (WS / "openvino").exists():
            configure.append(f"-DOpenVINO_DIR={WS}/openvino/openvino/cmake")
        if run(configure, log, 120) != 0:
            return Counts(0, 1, 0)
        reading = tidy.Reading(WS / "tidy" / "compile_commands.json", tidy.newest_first(REPO, tidy_sources()), int(JOBS),
                               log, step_aside)
        reading.run(time.monotonic() + min(limit_s, max(0.0, DEADLINE - time.time() - 20)))
        if reading.left_out:
            with open(log, "a") as stream:
                stream.write(f"skipped '{len(reading.left_out)} of {len(reading.todo)} sources left out, the longest "
                             "unchanged ones: the time is over (tools/test tidy reads all)'\n")
        failed = len(reading.findings) if reading.todo else 1
        return Counts(len(reading.read) - len(reading.findings), failed, len(reading.left_out))
    return runner


def openvino_options():
    place = WS / "openvino" / "openvino" / "cmake"
    return [f"-DOpenVINO_DIR={place}"] if place.exists() else ["-DEXTPERFC_WITH_OPENVINO=OFF"]


def all_tests(tidy_limit_s=float("inf")):
    """Every test of the package, quick groups first."""
    for folder in ("contract", "unit"):
        for file in sorted((REPO / "test" / folder).rglob("test_*.py")):
            yield Test(f"{folder}/{file.stem[5:]}", "unit", unittest_runner(file, 120))
    for name, command in ctest_programs(WS / "build" / "extperfc", ""):
        yield Test(name, "unit", gtest_runner(command))
    for file in sorted((REPO / "test" / "ros").glob("*.test")):
        yield Test(f"ros/{file.stem}", "ros", rostest_runner(file))
    yield Test("style/format", "style", step_runner([["clang-format", "--dry-run", "--Werror", *own_cpp_files()]], 300))
    for file in sorted((REPO / "test" / "system").rglob("test_*.py")):
        yield Test(f"system/{file.stem[5:]}", "system", unittest_runner(file, 400))
    # Neither variant has ROS; the rooms that know nothing of OpenVINO and MRPT are built once, for the sanitizers.
    yield Test("core/bare", "core", variant_runner(
        "core", ["-DEXTPERFC_WITH_OPENVINO=OFF", "-DEXTPERFC_WITH_MRPT=OFF"], "unit/(detect|sources|offline)/"))
    yield Test("sanitize/thread", "sanitize", variant_runner(
        "tsan", ["-DEXTPERFC_SANITIZE=thread", "-DEXTPERFC_WITH_OPENVINO=OFF"], "latest_slot|in_order|event_loop|resolver|mapper_threads|map_picture|planning_team"))
    yield Test("sanitize/address_undefined", "sanitize", variant_runner(
        "asan", ["-DEXTPERFC_SANITIZE=address,undefined", *openvino_options()]))
    yield Test("style/tidy", "style", InBackground(tidy_runner(tidy_limit_s)))


def chosen(tests, words):
    if not words:
        return tests
    return [t for t in tests if any(t.group == w if w in GROUPS else w in t.name for w in words)]


def telling_lines(lines):
    """What a reader of a failure needs: the place of each failure with the lines about it, then the end."""
    marks = [i for i, line in enumerate(lines) if re.search(r"\[FAILURE\]|: Failure$|^FAIL: |\[  FAILED  \]|Sanitizer|: error: ", line)]
    wanted = {i + d for i in marks[:20] for d in range(-3, 12)} | set(range(len(lines) - 30, len(lines)))
    return [lines[i] for i in sorted(wanted) if 0 <= i < len(lines)]


def report(test, counts, seconds, log):
    state = "FAILED" if counts.failed else "ok"
    text = f"{test.name:<34} {state:<7} {counts.passed:4} passed"
    if counts.failed:
        text += f", {counts.failed} failed"
    if counts.skipped:
        text += f", {counts.skipped} skipped"
    print(f"{text:<78} {seconds:6.1f} s", flush=True)
    content = log.read_text(errors="replace") if log.exists() else ""
    if counts.failed:
        print("\n".join("    | " + line for line in telling_lines(content.splitlines())), flush=True)
        print(f"    whole log: {log}", flush=True)
    for reason in sorted(set(re.findall(r"skipped ['\"](.*)['\"]$|^.*: Skipped\n(.*)$", content, re.M))):
        print("    skipped: " + (reason[0] or reason[1]).strip(), flush=True)


def log_of(test, logs):
    return logs / (test.name.replace("/", "_") + ".log")


def fresh_log(test, logs):
    log = log_of(test, logs)
    log.parent.mkdir(parents=True, exist_ok=True)
    log.unlink(missing_ok=True)
    return log


def main(argv):
    parser = argparse.ArgumentParser(prog="tools/test", description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("names", nargs="*", help="groups or parts of names; none: everything")
    parser.add_argument("--once", action="store_true", help="do not run a failed ros or system test again")
    parser.add_argument("--list", action="store_true", help="list the chosen tests and stop")
    options = parser.parse_args(argv)
    tests = chosen(list(all_tests(float("inf") if options.names else TIDY_LIMIT_S)), options.names)
    if not tests:
        parser.error(f"no test matches {' '.join(options.names)}; --list shows all")
    if options.list:
        print("\n".join(t.name for t in tests))
        return 0
    logs = WS / "test_logs"
    total = Counts(0, 0, 0)
    begin = time.monotonic()
    background = [t for t in tests if isinstance(t.run, InBackground)] if len(tests) > 1 else []
    started = []
    for test in tests:
        if test.group != "unit":  # those are quick
            for other in background:
                other.run.start(fresh_log(other, logs))
            started, background = started + background, []
        log = log_of(test, logs) if test in started else fresh_log(test, logs)
        start = time.monotonic()
        counts = run_in_time(test.run, log)
        if counts.failed and test.group in ("ros", "system") and not options.names and not options.once:
            report(test, counts, time.monotonic() - start, log)
            print(f"{test.name}: once more", flush=True)
            log.rename(log.with_suffix(".first.log"))
            start = time.monotonic()
            counts = run_in_time(test.run, log)
        report(test, counts, time.monotonic() - start, log)
        total = Counts(*map(sum, zip(total, counts)))
    print(f"\n{time.monotonic() - begin:.0f} s in all")
    print(f"{total.passed} passed, {total.failed} failed, {total.skipped} skipped")
    return 1 if total.failed else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
