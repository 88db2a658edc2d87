"""Which tests the package has, which of them may run at a time, and which are left to `tools/test --all`.

Tests of Python files can be parts of the long tier too: test_tiers.long_scenario marks a method or a class.
"""

import collections
import os
import pathlib
import subprocess
import time

import recent_changes
import tidy
from junit_counts import Counts
from sanitized import Variant
from test_processes import (DEADLINE, REPO, ctest_list, gtest_runner, note_skipped, rostest_runner, run, step_runner,
                            unittest_runner)

WS = pathlib.Path(os.environ.get("EXTPERFC_WS", REPO / ".ws"))
GROUPS = ("unit", "ros", "core", "sanitize", "style", "system")
SLOW_GROUPS = ("core", "sanitize", "style")
JOBS = os.cpu_count() or 1
FILE_LIMIT_S = 400
LONG_FILE_LIMIT_S = 7200

# Tests of the groups ros and system that mostly wait, the longest first: some run at a time, since each has its own master,
# port and ROS_HOME, and none measures time or needs a whole processor.
BESIDE = (
    "system/translator_faults", "ros/navigator", "system/arm_moves", "system/calibrate", "system/arm_objects",
    "ros/robot_interface", "system/translator", "system/translator_calls", "system/arm_markers", "system/mapping_bag",
    "ros/localizer", "system/translator_connections", "ros/mapper", "system/localization_bag", "ros/detector",
    "system/localization_restart", "ros/rosbag", "ros/zero_copy", "ros/sources", "ros/box_depth", "system/translator_rospy",
    "system/record_tool", "ros/cloud_to_scan", "ros/translator_node", "system/translator_oracle", "system/label_tool",
    "system/cameras_launch", "system/bringup_robot", "system/two_robots", "ros/explorer", "system/detection_launch",
    "system/align_depth", "ros/map_server", "ros/start_up", "ros/tracker", "ros/params", "ros/translator_params")

# CPU-bound tests: they run in the background at the lowest priority, so each gets twice the usual time.
ASIDE = ("system/training", "system/network_folders", "system/plain_workspace", "system/map_tool", "system/training_kills",
         "system/shapes_model", "style/format", "system/render_tool", "system/model_tool", "system/translate_tool",
         "system/examples", "style/tidy")

# Whole tests that only `tools/test --all`, or their name, runs; and what the normal tier has of them.
LONG = {
    "system/bench": "measures; correctness of what it measures is in the unit tests",
    "system/translator_soak": "system/translator_faults has each fault alone",
    "system/robot_soak": "ten minutes; system/bringup has each fault alone",
    "system/mapping_office": "system/mapping_bag and ros/mapper draw maps",
    "system/mapping_people": "minutes; system/mapping_office has the same checks without people"}


class Test(collections.namedtuple("Test", "name group run long")):
    """One line of the report. long: not part of the normal tier."""

    def rank(self):
        """The place in the order of its kind; those that no list names come last."""
        return next((names.index(self.name) for names in (BESIDE, ASIDE) if self.name in names), len(BESIDE))


def own_cpp_files():
    listed = subprocess.run(["git", "ls-files", "--cached", "--others", "--exclude-standard", "*.cpp", "*.hpp"],
                            cwd=REPO, capture_output=True, text=True)
    files = listed.stdout.split() if listed.returncode == 0 else []
    return [f for f in files or (str(p.relative_to(REPO)) for d in ("include", "src", "test")
                                 for p in (REPO / d).rglob("*.[ch]pp")) if (REPO / f).exists()]


def tidy_sources():
    """Sources that clang-tidy reads: our own code, not the tests."""
    return [f for f in own_cpp_files() if f.startswith("src/") and f.endswith(".cpp")]


def openvino_options():
    place = WS / "openvino" / "openvino" / "cmake"
    return [f"-DOpenVINO_DIR={place}"] if place.exists() else ["-DEXTPERFC_WITH_OPENVINO=OFF"]


def tidy_configuration():
    command = ["cmake", "-S", str(WS / "src"), "-B", str(WS / "tidy"), "-G", "Ninja",
               "-DCMAKE_EXPORT_COMPILE_COMMANDS=ON", "-DPYTHON_EXECUTABLE=/usr/bin/python3",
               f"-DCATKIN_DEVEL_PREFIX={WS}/devel", "-DCATKIN_ENABLE_TESTING=OFF", "-DEXTPERFC_TESTS=OFF",
               "-DEXTPERFC_BENCHMARKS=OFF", "-DEXTPERFC_UNITY=OFF", "-DCMAKE_DISABLE_PRECOMPILE_HEADERS=ON"]
    return command + (openvino_options() if (WS / "openvino").exists() else [])


def tidy_runner(sources, end):
    """clang-tidy over `sources`, a test each; findings in our headers count too. What `end` (seconds since 1970) and the
    deadline of the whole run leave no time for is skipped."""
    def runner(log):
        if not sources:
            return Counts(0, 0, 0)
        if run(tidy_configuration(), log, 120) != 0:
            return Counts(0, 1, 0)
        reading = tidy.Reading(WS / "tidy" / "compile_commands.json", tidy.newest_first(REPO, sources), JOBS, log)
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
            yield Test(f"{folder}/{file.stem[5:]}", "unit", unittest_runner(file, 120), False)
    for name, command in ctest_list(WS / "build" / "extperfc"):
        if command:
            yield Test(name, "unit", gtest_runner(command), False)


def ros_and_system_tests(with_long):
    for file in sorted((REPO / "test" / "ros").glob("*.test")):
        name = f"ros/{file.stem}"
        yield Test(name, "ros", rostest_runner(file), name in LONG)
    format_check = ["clang-format", "--dry-run", "--Werror", *own_cpp_files()]
    yield Test("style/format", "style", step_runner([format_check], 300, aside=True), False)
    for file in sorted((REPO / "test" / "system").rglob("test_*.py")):
        name = f"system/{file.stem[5:]}"
        aside = name in ASIDE
        limit_s = LONG_FILE_LIMIT_S if with_long else FILE_LIMIT_S * (1 + aside)
        yield Test(name, "system", unittest_runner(file, limit_s, with_long, aside), name in LONG)


def slow_checks(scope):
    """Neither variant has ROS; the modules that know nothing of OpenVINO and MRPT are built once, for the sanitizers."""
    def variant(name, options, pattern=""):
        return Variant(WS / "variants" / name, options, pattern, scope.modules, scope.end)
    yield Test("core/bare", "core", variant(
        "core", ["-DEXTPERFC_WITH_OPENVINO=OFF", "-DEXTPERFC_WITH_MRPT=OFF"], "unit/(detect|sources|offline)/"), True)
    yield Test("sanitize/thread", "sanitize", variant(
        "tsan", ["-DEXTPERFC_SANITIZE=thread", "-DEXTPERFC_WITH_OPENVINO=OFF"],
        "latest_slot|in_order|event_loop|resolver|mapper_threads|map_image|planning_team"), True)
    yield Test("sanitize/address_undefined", "sanitize", variant(
        "asan", ["-DEXTPERFC_SANITIZE=address,undefined", *openvino_options()]), True)
    yield Test("style/tidy", "style", tidy_runner(scope.sources, scope.end), True)


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
