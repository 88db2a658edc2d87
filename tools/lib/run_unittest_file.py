"""Runs one file test_*.py of the current folder with unittest and prints how long each test took.

  run_unittest_file.py test_NAME [--with-long]

Tests marked with test_tiers.long_scenario run only with --with-long.
"""

import argparse
import sys
import time
import unittest


class TimedResult(unittest.TextTestResult):
    """The usual output, with the seconds of each test."""

    def startTest(self, test):
        self._begin = time.monotonic()
        super().startTest(test)

    def stopTest(self, test):
        super().stopTest(test)
        self.stream.writeln(f"  {time.monotonic() - self._begin:7.2f} s  {test.id()}")


def long_reason(test):
    """Why a test is a long scenario; None for the others."""
    method = getattr(test, getattr(test, "_testMethodName", ""), None)
    return getattr(method, "long_scenario", None) or getattr(type(test), "long_scenario", None)


def tests_of(suite):
    """The tests of nested suites."""
    for test in suite:
        if isinstance(test, unittest.TestSuite):
            yield from tests_of(test)
        else:
            yield test


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("module")
    parser.add_argument("--with-long", action="store_true")
    options = parser.parse_args()
    sys.path.insert(0, "")
    every = list(tests_of(unittest.defaultTestLoader.loadTestsFromName(options.module)))
    chosen = [test for test in every if options.with_long or not long_reason(test)]
    for test in every:
        if test not in chosen:
            print(f"long scenario, left to tools/test --all: {test.id()}", file=sys.stderr)
    if not chosen:
        print("\nRan 0 tests\n\nOK", file=sys.stderr)  # newer versions of unittest say otherwise
        return 0
    runner = unittest.TextTestRunner(verbosity=2, resultclass=TimedResult)
    return 0 if runner.run(unittest.TestSuite(chosen)).wasSuccessful() else 1


if __name__ == "__main__":
    sys.exit(main())
