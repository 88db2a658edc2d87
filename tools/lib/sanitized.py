"""Variants of the core without ROS, built in folders of their own: with sanitizers, or without optional libraries."""

import concurrent.futures
import os
import pathlib
import re
import time

from junit_counts import Counts, total_of
from test_processes import REPO, ctest_list, gtest_runner, note_skipped, run, run_in_time

JOBS = os.cpu_count() or 1


def module_of(test_name):
    """unit/arm/x is a test of arm."""
    return test_name.split("/")[1]


class Variant:
    """Builds and runs the unit tests of a variant, module by module.

    pattern: which tests; modules: which modules, first come first, None for all; end: when (seconds since 1970) to begin
    no further module."""

    def __init__(self, build, cmake_options, pattern="", modules=None, end=float("inf")):
        self.build, self.cmake_options, self.pattern = build, cmake_options, pattern
        self.modules, self.end = modules, end

    def __call__(self, log):
        if self.modules is not None and not self.modules:
            return Counts(0, 0, 0)
        configure = ["cmake", "-S", str(REPO), "-B", str(self.build), "-G", "Ninja", "-DCMAKE_BUILD_TYPE=None",
                     "-DCMAKE_CXX_FLAGS=-O1", "-DEXTPERFC_WITH_ROS=OFF", "-DEXTPERFC_WERROR=ON",
                     "-DEXTPERFC_BENCHMARKS=OFF", *self.cmake_options]
        if run(configure, log, 120) != 0:
            return Counts(0, 1, 0)
        names = [name for name, _ in ctest_list(self.build) if re.search(self.pattern, name)]
        present = list(dict.fromkeys(map(module_of, names)))
        wanted = present if self.modules is None else [module for module in self.modules if module in present]
        # Module by module, so that what was ready counts when the time of the whole run is over.
        counts = [self._run_module_in_time(module, [n for n in names if module_of(n) == module], log) for module in wanted]
        not_wanted = [module for module in present if module not in wanted]
        if not_wanted:
            note_skipped(log, f"unchanged modules {', '.join(not_wanted)} left to tools/test --all")
        return total_of(counts)

    def _run_module_in_time(self, module, names, log):
        if time.time() >= self.end:
            note_skipped(log, f"{module} left out: the time for sanitizers is over (tools/test --all runs it)")
            return Counts(0, 0, len(names))
        return run_in_time(lambda log: self._run_module(names, log), log,
                           f"{module} left out: the time of the whole run is over")

    def _run_module(self, names, log):
        """Test unit/base/x is the program test_base_x."""
        targets = ["test_" + name.split("/", 1)[1].replace("/", "_") for name in names]
        if run(["ninja", "-C", str(self.build), "-j", str(JOBS), *targets], log, 3600) != 0:
            return Counts(0, 1, 0)
        commands = [command for name, command in ctest_list(self.build) if name in names]
        logs = [log.with_suffix(f".{i}.log") for i in range(len(commands))]
        try:
            with concurrent.futures.ThreadPoolExecutor(JOBS) as team:
                return total_of(list(team.map(self._run_program, commands, logs)))
        finally:
            with open(log, "a") as whole:
                for one in filter(pathlib.Path.exists, logs):
                    whole.write(one.read_text(errors="replace"))
                    one.unlink()

    @staticmethod
    def _run_program(command, log):
        # The workspace's LD_LIBRARY_PATH would put its libraries before the variant's own.
        return gtest_runner(command, LD_LIBRARY_PATH="")(log)
