"""Runs tests and ends with the line `N passed, N failed, N skipped`.

  tools/test              what a change must pass: unit, contract, ros and the main system scenarios
  tools/test --all        all of it: also long scenarios, every benchmark once, the core without optional libraries,
                          sanitizers, and clang-tidy over every source
  tools/test --recent     the first, then sanitizers and clang-tidy for the modules that changed within two days of the
                          newest commit, and for one other module, a different one each day; .ci/run does this
  tools/test unit         C++ and Python unit tests and the contract tests
  tools/test ros          rostest suites
  tools/test core         the core without OpenVINO and MRPT: what meets them builds, and its unit tests pass
  tools/test sanitize     the core without ROS: unit tests with AddressSanitizer and UndefinedBehaviorSanitizer, threads
                          with ThreadSanitizer
  tools/test style        clang-format and clang-tidy
  tools/test system       tools/demo, the command-line tools, whole scenarios
                          (a group's long scenarios are in it with --all)
  tools/test NAME ...     every test whose name contains NAME, long or not, e.g. `tools/test decode`
  tools/test --flaky N NAME ...
                          each of these N times; prints how often each failed

Unit tests run as many at a time as there are processors; of those ros and system tests that mostly wait one more; tests
that measure time or need a whole processor run alone. CPU-bound tests run in the background, at the lowest priority.

A ros or system test that fails in a whole run is run once more, alone, since those meet other programs' timing on a shared
machine. Both results are printed, the second one counts, and the test is counted as flaky in the line before the last;
--once leaves that out.

EXTPERFC_TEST_DEADLINE (seconds since 1970) bounds a whole run on a machine that ends it at some time: what has not
ended by then is printed as left out, and counts as skipped. EXTPERFC_TEST_SLOW_END bounds the sanitizers and clang-tidy
alike, and only them. Without these everything runs to its end.
"""

import argparse
import collections
import concurrent.futures
import os
import re
import sys
import threading
import time

from junit_counts import total_of
from test_list import ASIDE, BESIDE, GROUPS, JOBS, WS, Scope, Test, all_tests, chosen
from test_processes import run_in_time

LOGS = WS / "test_logs"
Done = collections.namedtuple("Done", "test counts seconds log")


def telling_lines(lines):
    """What a reader of a failure needs: the place of each failure with the lines about it, then the end."""
    marks = [i for i, line in enumerate(lines) if re.search(r"\[FAILURE\]|: Failure$|^FAIL: |\[  FAILED  \]|Sanitizer|: error: ", line)]
    wanted = {i + d for i in marks[:20] for d in range(-3, 12)} | set(range(len(lines) - 30, len(lines)))
    return [lines[i] for i in sorted(wanted) if 0 <= i < len(lines)]


def report(done):
    """Prints one test's line, what a reader of its failure needs, and why something was skipped."""
    test, counts = done.test, done.counts
    text = f"{test.name:<34} {'FAILED' if counts.failed else 'ok':<7} {counts.passed:4} passed"
    if counts.failed:
        text += f", {counts.failed} failed"
    if counts.skipped:
        text += f", {counts.skipped} skipped"
    lines = [f"{text:<78} {done.seconds:6.1f} s"]
    content = done.log.read_text(errors="replace") if done.log.exists() else ""
    if counts.failed:
        lines += ["    | " + line for line in telling_lines(content.splitlines())] + [f"    whole log: {done.log}"]
    for reason in sorted(set(re.findall(r"skipped ['\"](.*)['\"]$|^.*: Skipped\n(.*)$", content, re.M))):
        lines.append("    skipped: " + (reason[0] or reason[1]).strip())
    print("\n".join(lines), flush=True)


def log_of(test):
    return LOGS / (test.name.replace("/", "_") + ".log")


def fresh_log(test):
    log = log_of(test)
    log.parent.mkdir(parents=True, exist_ok=True)
    log.unlink(missing_ok=True)
    return log


def run_one(test, log):
    """Runs a test in the time that is left."""
    begin = time.monotonic()
    counts = run_in_time(test.run, log)
    return Done(test, counts, time.monotonic() - begin, log)


class Session:
    """Runs tests in phases and keeps their results; prints each as soon as it is there."""

    def __init__(self):
        self.results, self._printing = [], threading.Lock()

    def phase(self, tests, at_a_time):
        """Runs tests, some at a time."""
        with concurrent.futures.ThreadPoolExecutor(at_a_time) as team:
            list(team.map(self._run, tests))

    def _run(self, test):
        done = run_one(test, fresh_log(test))
        with self._printing:
            report(done)
            self.results.append(done)

    def repeat_failures(self):
        """Runs failed ros and system tests once more, alone; returns the names of those that then pass."""
        flaky = []
        for i, first in enumerate(self.results):
            if not first.counts.failed or first.test.group not in ("ros", "system"):
                continue
            print(f"{first.test.name}: once more", flush=True)
            first.log.rename(first.log.with_suffix(".first.log"))
            again = run_one(first.test, first.log)
            report(again)
            self.results[i] = again
            if again.counts.passed and not again.counts.failed:
                flaky.append(first.test.name)
                print(f"{first.test.name}: flaky", flush=True)
        return flaky

    def total(self):
        return total_of([done.counts for done in self.results])


def run_all(tests, repeat):
    """Runs tests in an order that keeps the processors busy and leaves measuring ones alone; (counts, flaky names)."""
    session = Session()
    session.phase([t for t in tests if t.group == "unit"], JOBS)
    others = sorted((t for t in tests if t.group != "unit"), key=Test.rank)
    with concurrent.futures.ThreadPoolExecutor(1) as team:
        background = team.submit(session.phase, [t for t in others if t.name in ASIDE], 1)
        session.phase([t for t in others if t.name in BESIDE], JOBS + 1)
        session.phase([t for t in others if t.name not in BESIDE and t.name not in ASIDE], 1)
        background.result()
    flaky = session.repeat_failures() if repeat else []
    return session.total(), flaky


def count_failures(tests, times):
    """Runs each test several times; prints how often it failed; returns the sum of all counts."""
    counts = []
    for test in tests:
        failed = 0
        for i in range(times):
            log = fresh_log(test)
            done = run_one(test, log)
            counts.append(done.counts)
            if done.counts.failed:
                failed += 1
                report(done)
                log.rename(log.with_suffix(f".{i + 1}.log"))
        print(f"{test.name:<34} failed {failed} of {times} times", flush=True)
    return total_of(counts)


def parse(argv):
    parser = argparse.ArgumentParser(prog="tools/test", description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("names", nargs="*", help="groups or parts of names; none: the normal tier")
    tier = parser.add_mutually_exclusive_group()
    tier.add_argument("--all", action="store_true", help="long scenarios and slow checks too")
    tier.add_argument("--recent", action="store_true", help="slow checks of what changed lately too")
    tier.add_argument("--flaky", type=int, metavar="N", help="run each named test N times and count failures")
    parser.add_argument("--once", action="store_true", help="do not run a failed ros or system test again")
    parser.add_argument("--list", action="store_true", help="list the chosen tests and stop")
    options = parser.parse_args(argv)
    if options.flaky is not None and (options.flaky < 1 or not options.names):
        parser.error("--flaky needs a positive number and names of tests")
    return parser, options


def choose(options):
    """The tests of a command line."""
    with_long = options.all or any(name not in GROUPS for name in options.names)
    scope = Scope(options.recent, float(os.environ.get("EXTPERFC_TEST_SLOW_END", "inf")))
    tests = list(all_tests(scope, with_long))
    picked = chosen(tests, options.names, options.all)
    if options.recent and not options.names:
        picked += [t for t in tests if t.group == "sanitize" or t.name == "style/tidy"]
    return picked


def main(argv):
    parser, options = parse(argv)
    tests = choose(options)
    if not tests:
        parser.error(f"no test matches {' '.join(options.names)}; --list shows all")
    if options.list:
        print("\n".join(t.name for t in tests))
        return 0
    begin = time.monotonic()
    flaky = []
    if options.flaky:
        total = count_failures(tests, options.flaky)
    else:
        total, flaky = run_all(tests, not options.names and not options.once)
    print(f"\n{time.monotonic() - begin:.0f} s in all")
    print(f"{len(flaky)} flaky" + (f": {', '.join(flaky)}" if flaky else ""))
    print("{} passed, {} failed, {} skipped".format(*total))
    return 1 if total.failed else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
