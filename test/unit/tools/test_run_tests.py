"""tools/lib/run_tests.py and run_unittest_file.py: tiers, repetition, the closing lines."""

import contextlib
import io
import pathlib
import subprocess
import sys
import tempfile
import textwrap
import threading
import unittest
from unittest import mock

import run_tests
from junit_counts import Counts, counts_of_unittest
from test_list import BESIDE, Test, chosen

TOOLS = pathlib.Path(run_tests.__file__).parent
FILE = '''
import unittest
from test_tiers import long_scenario

class Some(unittest.TestCase):
    def test_short(self):
        pass

    @long_scenario("takes long")
    def test_long(self):
        pass

@long_scenario("takes long")
class More(unittest.TestCase):
    def test_other(self):
        pass
'''


def failing_first(times):
    """A runner that fails `times` times, then passes."""
    left = [times]

    def runner(log):
        left[0] -= 1
        pathlib.Path(log).write_text("log")
        return Counts(1, 0, 0) if left[0] < 0 else Counts(0, 1, 0)
    return runner


class Running(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        patch = mock.patch.object(run_tests, "LOGS", pathlib.Path(folder.name))
        patch.start()
        self.addCleanup(patch.stop)
        self.output = io.StringIO()
        quiet = contextlib.redirect_stdout(self.output)
        quiet.__enter__()
        self.addCleanup(quiet.__exit__, None, None, None)

    def test_a_test_that_passes_on_repetition_is_flaky(self):
        tests = [Test("system/a", "system", failing_first(1), False),
                 Test("ros/b", "ros", failing_first(2), False),
                 Test("unit/c", "unit", failing_first(1), False)]
        total, flaky = run_tests.run_all(tests, True)
        self.assertEqual(["system/a"], flaky)
        self.assertEqual(Counts(1, 2, 0), total)
        self.assertIn("system/a: flaky", self.output.getvalue())

    def test_failures_are_counted(self):
        total = run_tests.count_failures([Test("unit/c", "unit", failing_first(2), False)], 5)
        self.assertEqual(Counts(3, 2, 0), total)
        self.assertRegex(self.output.getvalue(), r"unit/c +failed 2 of 5 times")

    def test_only_tests_that_mostly_wait_run_at_a_time_and_the_background_beside_all(self):
        running, seen, lock = set(), {}, threading.Lock()
        meet, began, measured = threading.Barrier(3), threading.Event(), threading.Event()

        def runner(name):
            def run(log):
                with lock:
                    running.add(name)
                if name == "background":
                    began.set()
                    self.assertTrue(measured.wait(20))
                elif name in "cd":
                    self.assertTrue(began.wait(20))
                else:
                    meet.wait(20)
                with lock:
                    seen[name] = set(running)
                    running.remove(name)
                if name in "cd":
                    measured.set()
                return Counts(1, 0, 0)
            return run
        tests = [Test(name, "ros", runner(name), False) for name in ("c", "a", "background", "b", "e", "d")]
        with mock.patch.multiple(run_tests, JOBS=2, ASIDE=("background",), BESIDE=("b", "a", "e")):
            total, _ = run_tests.run_all(tests, True)
        self.assertEqual(Counts(6, 0, 0), total)
        self.assertEqual([{"c", "background"}, {"d"}], [seen["c"], seen["d"] - {"background"}])

    def test_the_longest_of_those_that_wait_begins_first(self):
        tests = [Test(name, "ros", None, False) for name in ("ros/new", *sorted(BESIDE))]
        self.assertEqual([*BESIDE, "ros/new"], [test.name for test in sorted(tests, key=Test.rank)])


class Choosing(unittest.TestCase):
    def test_tiers(self):
        tests = [Test("unit/a", "unit", None, False), Test("system/b", "system", None, True),
                 Test("system/d", "system", None, False), Test("sanitize/c", "sanitize", None, True)]

        def names(patterns, with_long):
            return [t.name[-1] for t in chosen(tests, patterns, with_long)]
        self.assertEqual(["a", "d"], names([], False))
        self.assertEqual(["a", "b", "d", "c"], names([], True))
        self.assertEqual(["d"], names(["system"], False))
        self.assertEqual(["b", "d"], names(["system"], True))
        self.assertEqual(["b"], names(["system/b"], False))
        self.assertEqual(["c"], names(["sanitize"], False))


class OneFile(unittest.TestCase):
    def ran(self, text, *options):
        with tempfile.TemporaryDirectory() as folder:
            (pathlib.Path(folder) / "test_some.py").write_text(textwrap.dedent(text))
            done = subprocess.run([sys.executable, str(TOOLS / "run_unittest_file.py"), "test_some", *options],
                                  cwd=folder, capture_output=True, text=True, timeout=60)
        return counts_of_unittest(done.stderr, done.returncode), done.stderr

    def test_long_scenarios_run_when_asked_for(self):
        counts, output = self.ran(FILE)
        self.assertEqual(Counts(1, 0, 0), counts, output)
        self.assertIn("left to tools/test --all: test_some.More.test_other", output)
        self.assertEqual(Counts(3, 0, 0), self.ran(FILE, "--with-long")[0])

    def test_a_file_of_long_scenarios_alone_is_no_failure(self):
        text = FILE.replace("class Some", '@long_scenario("all")\nclass Some')
        self.assertEqual(Counts(0, 0, 0), self.ran(text)[0])

    def test_a_file_that_cannot_be_imported_fails(self):
        self.assertEqual(1, self.ran("import no_such_module")[0].failed)


if __name__ == "__main__":
    unittest.main()
