"""How many tests passed, failed and were skipped, from what test programs leave behind."""

import collections
import re
import xml.etree.ElementTree

Counts = collections.namedtuple("Counts", "passed failed skipped")


def total_of(counts):
    """The sum of several."""
    return Counts(*map(sum, zip(Counts(0, 0, 0), *counts)))


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


def counts_of_unittest(text, return_code):
    """Counts from the closing lines of Python's unittest."""
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
