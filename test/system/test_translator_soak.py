"""tools/soak_translator in a short form: a few faults, and the checks at the end hold."""

import os
import pathlib
import random
import subprocess
import sys
import unittest

REPO = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(REPO / "tools" / "lib"))

import soak_checks  # noqa: E402
from soak_checks import Fault, Note, Stream  # noqa: E402

SOAK = REPO / "tools" / "lib" / "soak_translator.py"


def stream(lost=(), doubled=(), from_s=0.0, to_s=60.0, silent=lambda t: False):
    """Ten messages per second, each 10 ms under way."""
    sent = [Note("sent", "/t", 1, i, from_s + i / 10) for i in range(int(10 * (to_s - from_s)))]
    heard = [note._replace(kind="heard", time=note.time + 0.01) for note in sent
             if note.number not in lost and not silent(note.time)]
    heard += [heard[number]._replace(time=heard[number].time + 0.2) for number in doubled]
    return Stream("/t", sent, sorted(heard, key=lambda note: note.time))


class Checks(unittest.TestCase):
    """The judge itself: it must see what it is there to see."""

    FAULTS = [Fault(10.0, 12.0, "one"), Fault(35.0, 36.0, "two")]

    def problems(self, given):
        given.check(self.FAULTS, 60.0)
        return given.problems

    def test_nothing_lost(self):
        good = stream()
        self.assertEqual([], self.problems(good))
        self.assertGreater(good.checked, 300)

    def test_lost_between_faults(self):
        self.assertEqual(1, len(self.problems(stream(lost={200}))))

    def test_lost_in_a_fault_is_no_problem(self):
        self.assertEqual([], self.problems(stream(silent=lambda t: 10.0 <= t < 15.0)))

    def test_twice(self):
        self.assertIn("twice", " ".join(self.problems(stream(doubled=[50]))))

    def test_never_again(self):
        self.assertIn("silent", " ".join(self.problems(stream(silent=lambda t: t > 10.0))))

    def test_stale(self):
        late = stream()
        late.heard[300] = late.heard[300]._replace(time=late.heard[300].time + 2.0)
        self.assertEqual(1, len(soak_checks.stale(late, [])))
        self.assertEqual([], soak_checks.stale(late, [Fault(29.0, 31.0, "stopped")]))

    def test_memory(self):
        noise = random.Random(3)
        flat = [(float(t), 80.0 + noise.random()) for t in range(1800)]
        self.assertEqual([], soak_checks.memory_problems(flat))
        self.assertTrue(soak_checks.memory_problems([(t, m + 0.01 * t) for t, m in flat]))


class Soak(unittest.TestCase):
    def test_short(self):
        command = ["/usr/bin/python3", SOAK, "--minutes", "0.5", "--fault-period", "6", "--seed", "2"]
        done = subprocess.run(command, capture_output=True, text=True, timeout=240, env=os.environ)
        self.assertEqual(0, done.returncode, done.stdout + done.stderr)
        self.assertIn("0 problems", done.stdout)
        self.assertIn("/soak/robot/convert", done.stdout)


if __name__ == "__main__":
    unittest.main()
