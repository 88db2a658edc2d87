"""Which tests the package has, which of them may run beside others, and which are left to `tools/test --all`.

Tests of Python files can be parts of the long tier too: test_tiers.long_scenario marks a method or a class.
"""

import collections
import os
import pathlib
import subprocess
import threading
import time

import recent_changes
import tidy
from junit_counts import Counts
from sanitized import Variant
from test_processes import (DEADLINE, REPO, ctest_list, gtest_runner, note_skipped, rostest_runner, run, run_in_time,
                            step_runner, unittest_runner)

WS = pathlib.Path(os.environ.get("EXTPERFC_WS", REPO / ".ws"))
GROUPS = ("unit", "ros", "core", "sanitize", "style", "system")
SLOW_GROUPS = ("core", "sanitize", "style")
JOBS = os.cpu_count() or 1
FILE_LIMIT_S = 400
LONG_FILE_LIMIT_S = 7200

# Tests of the groups ros and system that may run two at a time: each has its own master, port and ROS_HOME, and none of
# them measures time or needs a whole processor. All others run alone.
BESIDE_OTHERS = {
    "ros/box_depth", "ros/detector", "ros/localizer", "ros/mapper", "ros/navigator", "ros/params", "ros/robot_interface", "ros/rosbag",
    "ros/sources", "ros/start_up", "ros/tracker", "ros/translator_node", "ros/translator_params",
    "system/align_depth", "system/arm_markers", "system/arm_moves", "system/arm_objects", "system/cameras_launch",
    "system/detection_launch", "system/examples", "system/label_tool",
    "system/localization_bag", "system/localization_restart", "system/map_tool", "system/mapping_bag", "system/model_tool",
    "system/network_folders", "system/plain_workspace", "system/record_tool", "system/render_tool",
    "system/training", "system/training_kills", "system/translate_tool", "system/translator_calls",
    "system/translator_connections", "system/translator_oracle", "system/translator_rospy"}

# Whole tests that only `tools/test --all`, or their name, runs; and what the normal tier has of them.
LONG = {
    "system/bench": "measures; correctness of what it measures is in the unit tests",
    "system/translator_soak": "system/translator_faults has each fault alone",
    "system/mapping_office": "system/mapping_bag and ros/mapper draw maps"}


class Test(collections.namedtuple("Test", "name group run beside_others long")):
    """One line of the report. beside_others: may run while others do; long: not part of the normal tier."""


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


def openvino_options():
    place = WS / "openvino" / "openvino" / "cmake"
    return [f"-DOpenVINO_DIR={place}"] if place.exists() else ["-DEXTPERFC_WITH_OPENVINO=OFF"]


def tidy_configuration():
    command = ["cmake", "-S", str(WS / "src"), "-B", str(WS / "tidy"), "-G", "Ninja",
               "-DCMAKE_EXPORT_COMPILE_COMMANDS=ON", "-DPYTHON_EXECUTABLE=/usr/bin/python3",
               f"-DCATKIN_DEVEL_PREFIX={WS}/devel", "-DCATKIN_ENABLE_TESTING=OFF", "-DEXTPERFC_TESTS=OFF",
               "-DEXTPERFC_BENCHMARKS=OFF", "-DCMAKE_DISABLE_PRECOMPILE_HEADERS=ON"]
    return command + (openvino_options() if (WS / "openvino").exists() else [])


def tidy_runner(sources, end):
    """clang-tidy over `sources`, a test each; findings in our headers count too. What `end` (seconds since 1970) and the
    deadline of the whole run leave no time for is skipped."""
    def runner(log):
        if not sources:
            return Counts(0, 0, 0)
        if run(tidy_configuration(), log, 120) != 0:
            return Counts(0, 1, 0)
        reading = tidy.Reading(WS / "tidy" / "compile_commands.json", tidy.newest_first(REPO, sources), JOBS, log,
                               step_aside)
        reading.run(time.monotonic() + max(0.0, min(end, DEADLINE - 20) - time.time()))
        if reading.left_out:
            note_skipped(log, f"{len(reading.left_out)} of {len(reading.todo)} sources left out, the longest unchanged "
                              "ones: the time is over (tools/test tidy reads all)")
        failed = len(reading.findings) if reading.todo else 1
        return Counts(len(reading.read) - len(reading.findings), failed, len(reading.left_out))
    return runner


class Scope:
    """How much of the slow checks a run does. recent: only what changed lately and one more module, until `end`."""

    def __init__(self, recent=False, end=float("inf")):
        self.end, self.modules, self.sources = end, None, tidy_sources()
        if recent:
            changed = recent_changes.changed_files(REPO)
            every = recent_changes.modules_of(self.sources)
            self.modules = [module for module in recent_changes.modules_of(changed) if module in every]
            extra = recent_changes.in_rotation(every, self.modules)
            self.sources = recent_changes.sources_to_read(changed, self.sources) + [
                name for name in self.sources if extra and recent_changes.module_of(name) == extra]
            self.modules += [extra] if extra else []


def python_and_unit_tests():
    for folder in ("contract", "unit"):
        for file in sorted((REPO / "test" / folder).rglob("test_*.py")):
            yield Test(f"{folder}/{file.stem[5:]}", "unit", unittest_runner(file, 120), True, False)
    for name, command in ctest_list(WS / "build" / "extperfc"):
        if command:
            yield Test(name, "unit", gtest_runner(command), True, False)


def ros_and_system_tests(with_long):
    for file in sorted((REPO / "test" / "ros").glob("*.test")):
        name = f"ros/{file.stem}"
        yield Test(name, "ros", rostest_runner(file), name in BESIDE_OTHERS, name in LONG)
    yield Test("style/format", "style", step_runner([["clang-format", "--dry-run", "--Werror", *own_cpp_files()]], 300),
               True, False)
    for file in sorted((REPO / "test" / "system").rglob("test_*.py")):
        name = f"system/{file.stem[5:]}"
        limit_s = LONG_FILE_LIMIT_S if with_long else FILE_LIMIT_S
        yield Test(name, "system", unittest_runner(file, limit_s, with_long), name in BESIDE_OTHERS, name in LONG)


def slow_checks(scope):
    """Neither variant has ROS; the modules that know nothing of OpenVINO and MRPT are built once, for the sanitizers."""
    def variant(name, options, pattern=""):
        return Variant(WS / "variants" / name, options, pattern, scope.modules, scope.end)
    yield Test("core/bare", "core", variant(
        "core", ["-DEXTPERFC_WITH_OPENVINO=OFF", "-DEXTPERFC_WITH_MRPT=OFF"], "unit/(detect|sources|offline)/"), False, True)
    yield Test("sanitize/thread", "sanitize", variant(
        "tsan", ["-DEXTPERFC_SANITIZE=thread", "-DEXTPERFC_WITH_OPENVINO=OFF"],
        "latest_slot|in_order|event_loop|resolver|mapper_threads|map_image|planning_team"), False, True)
    yield Test("sanitize/address_undefined", "sanitize", variant(
        "asan", ["-DEXTPERFC_SANITIZE=address,undefined", *openvino_options()]), False, True)
    yield Test("style/tidy", "style", InBackground(tidy_runner(scope.sources, scope.end)), False, True)


def all_tests(scope, with_long):
    """Every test of the package, quick groups first."""
    yield from python_and_unit_tests()
    yield from ros_and_system_tests(with_long)
    yield from slow_checks(scope)


def is_meant(test, pattern, with_long):
    """A group's name means its tests of the normal tier, or all of them where that tier has none; any other pattern means
    the tests whose names contain it."""
    if pattern not in GROUPS:
        return pattern in test.name
    return test.group == pattern and (with_long or not test.long or pattern in SLOW_GROUPS)


def chosen(tests, patterns, with_long):
    """The tests that patterns mean; without patterns the normal tier, or all."""
    if patterns:
        return [t for t in tests if any(is_meant(t, pattern, with_long) for pattern in patterns)]
    return [t for t in tests if with_long or not t.long]
