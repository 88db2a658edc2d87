"""Runs the files test_*.py below some folders with unittest, each in a process of its own, and writes what passed and
failed as JUnit XML: what catkin's run_tests expects of a test.
"""

import argparse
import os
import pathlib
import subprocess
import sys
import xml.etree.ElementTree

from junit_counts import counts_of_unittest

REPO = pathlib.Path(__file__).resolve().parents[2]
FILE_LIMIT_S = 120


def environment():
    """What the tests import: the package's modules and those of the tools."""
    places = [str(REPO / "src"), str(REPO / "tools" / "lib"), os.environ.get("PYTHONPATH", "")]
    return dict(os.environ, PYTHONPATH=os.pathsep.join(places), PYTHONDONTWRITEBYTECODE="1")


def run(file):
    """(exit code, output) of one file; 124 when it ran too long."""
    command = [sys.executable, "-m", "unittest", "-v", file.stem]
    try:
        done = subprocess.run(command, cwd=file.parent, env=environment(), stdout=subprocess.PIPE,
                              stderr=subprocess.STDOUT, stdin=subprocess.DEVNULL, text=True, timeout=FILE_LIMIT_S)
    except subprocess.TimeoutExpired as ended:
        return 124, (ended.stdout or b"").decode(errors="replace") + f"\nended after {FILE_LIMIT_S} s\n"
    return done.returncode, done.stdout


def add_suite(root, file):
    """Appends the results of one file; returns whether it passed."""
    code, output = run(file)
    counts = counts_of_unittest(output, code)
    suite = xml.etree.ElementTree.SubElement(
        root, "testsuite", name=file.stem, tests=str(sum(counts)), failures=str(counts.failed), errors="0",
        skipped=str(counts.skipped))
    for kind in counts._fields:
        for i in range(getattr(counts, kind)):
            case = xml.etree.ElementTree.SubElement(suite, "testcase", classname=file.stem, name=f"{kind} {i + 1}")
            if kind == "failed":
                xml.etree.ElementTree.SubElement(case, "failure", message="see the output").text = printable(output)
            elif kind == "skipped":
                xml.etree.ElementTree.SubElement(case, "skipped")
    print(f"{file.name}: {counts.passed} passed, {counts.failed} failed, {counts.skipped} skipped", flush=True)
    if counts.failed:
        print(output, flush=True)
    return counts.failed == 0


def printable(text):
    """XML has no place for other control characters."""
    return "".join(c for c in text if c.isprintable() or c in "\n\t")


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--xunit", type=pathlib.Path, required=True, help="the file to write")
    parser.add_argument("folders", nargs="+", type=pathlib.Path)
    options = parser.parse_args()
    root = xml.etree.ElementTree.Element("testsuites")
    files = sorted(file for folder in options.folders for file in folder.rglob("test_*.py"))
    passed = [add_suite(root, file) for file in files]
    options.xunit.parent.mkdir(parents=True, exist_ok=True)
    xml.etree.ElementTree.ElementTree(root).write(options.xunit)
    return 0 if passed and all(passed) else 1


if __name__ == "__main__":
    sys.exit(main())
