"""On a machine without the packages, Python programs say in one line what is missing."""

import pathlib
import re
import subprocess
import unittest

REPO = pathlib.Path(__file__).resolve().parents[2]


BARE = """
import os, runpy, sys
sys.modules.update(dict.fromkeys(("cv2", "matplotlib", "numpy", "PIL", "py_trees", "rosgraph", "rospy", "torch", "yaml")))
sys.argv = sys.argv[1:]
sys.path[0] = os.path.dirname(sys.argv[0])
runpy.run_path(sys.argv[0], run_name="__main__")
"""


def run_bare(*arguments):
    """As where nothing but Python is installed."""
    return subprocess.run(["/usr/bin/python3", "-c", BARE, *map(str, arguments)], capture_output=True, text=True, timeout=30)


def programs():
    """Our programs in Python, each as the arguments that start it."""
    for file in sorted((REPO / "tools").iterdir()):
        text = file.read_text(errors="replace") if file.is_file() else ""
        if text.startswith("#!/usr/bin/python3") and "missing_modules" in text:
            yield [file]
        started = re.search(r'run_tool\.py" (\S+\.py) "\$@"', text)
        if started:
            yield [REPO / "tools/lib/run_tool.py", started[1]]
    for demo in ("demo.py", "demo_grasp.py"):
        yield [REPO / "tools/lib/run_tool.py", demo]


class BarePython(unittest.TestCase):
    def test_the_demos_help_needs_nothing(self):
        for options, known in (("demo_options.py", "--source"), ("demo_grasp_options.py", "--runs")):
            done = run_bare(REPO / "tools/lib/run_tool.py", options, "--help")
            self.assertEqual((done.returncode, done.stderr), (0, ""))
            self.assertIn(known, done.stdout)

    def test_a_program_says_what_it_lacks(self):
        self.assertGreater(len(list(programs())), 10)
        for program in programs():
            with self.subTest(program=program[-1]):
                done = run_bare(*program, "--no-such-option")
                self.assertRegex(done.stderr, r"^[\w-]+: the Python module \w+ is not installed: run tools/setup --tests, or [^\n]+\n$")
                self.assertEqual(done.returncode, 1)


if __name__ == "__main__":
    unittest.main()
