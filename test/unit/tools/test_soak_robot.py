"""What tools/soak_robot counts as lost, and as growth; where it drives; what tools/bench system measures."""

import argparse
import math
import pathlib
import random
import struct
import sys
import tempfile
import types
import unittest
from unittest import mock

import numpy

REPO = pathlib.Path(__file__).resolve().parents[3]
sys.path[:0] = [str(REPO / "src"), str(REPO / "tools" / "lib"), str(REPO / "test" / "benchmark" / "system")]

import bench_system  # noqa: E402
import part_meter  # noqa: E402
import robot_faults  # noqa: E402
import robot_health  # noqa: E402
import robot_tasks  # noqa: E402
import soak_robot  # noqa: E402
import streams  # noqa: E402
from driven_contacts import TrueMap  # noqa: E402
from pose_errors import Pose, compose, inverse  # noqa: E402
from robot_faults import Fault  # noqa: E402
from robot_tasks import Outcome  # noqa: E402


def soak(faults, outcomes, contacts=0, growth=None):
    made = soak_robot.Soak.__new__(soak_robot.Soak)
    made.faults, made.contacts, made.begin_s = faults, contacts, 0.0
    made.tasks = types.SimpleNamespace(outcomes=outcomes, is_alive=lambda: False)
    made.memory = types.SimpleNamespace(growth=lambda: growth or {})
    return made


class Checks(unittest.TestCase):
    KILL = Fault("kill /navigator", 100.0, 103.0, 2.0, 3.0)

    def problems(self, *arguments, **more):
        return soak(*arguments, **more).problems()

    def test_a_task_that_fails_during_a_fault_or_soon_after_is_lost_by_it(self):
        for begin_s, end_s in ((90.0, 101.0), (102.0, 110.0), (115.0, 120.0)):
            self.assertEqual([], self.problems([self.KILL], [Outcome("drive", begin_s, end_s, False, "why")]))

    def test_any_other_is_named_with_its_reason(self):
        for begin_s, end_s in ((80.0, 99.0), (124.0, 130.0)):
            found = self.problems([self.KILL], [Outcome("drive", begin_s, end_s, False, "no path")])
            self.assertEqual(1, len(found))
            self.assertIn("no path", found[0])
        self.assertEqual([], self.problems([self.KILL], [Outcome("drive", 80.0, 99.0, True, "")]))

    def test_what_does_not_work_again_contacts_and_growth_are_named(self):
        found = self.problems([Fault("kill /arm", 1.0, 91.0, None, None), Fault("cut link", 95.0, 190.0, 2.0, None)], [], contacts=2,
                              growth={"arm": (90.0, 7.5), "mapper": (95.0, None)})
        self.assertEqual(4, len(found))
        self.assertIn("kill /arm", found[0])
        self.assertIn("cut link: a part still complained 95 s later", found[1])
        self.assertIn("arm grows by 7.5 MB", found[2])
        self.assertIn("2 times", found[3])


class Memory(unittest.TestCase):
    def test_growth_is_that_of_the_oldest_process_after_its_first_minute(self):
        memory = soak_robot.Memory(None)
        old = [(float(second), 50.0 + (30.0 if second > 30 else second) + 2.0 * second / 60) for second in range(0, 601, 5)]
        memory.samples = {("/arm_manager", 1): old, ("/arm_manager", 2): [(601.0, 300.0), (640.0, 310.0)], ("/arm", 3): [(0.0, 15.0)]}
        self.assertEqual({"arm"}, set(memory.growth()), "loaders of nodelets do not count")
        largest_mb, rate = memory.growth()["arm"]
        self.assertEqual(310.0, largest_mb)
        self.assertAlmostEqual(2.0, rate, places=1)

    def test_of_young_processes_growth_is_not_known(self):
        memory = soak_robot.Memory(None)
        memory.samples = {("/arm_manager", 1): [(0.0, 50.0), (200.0, 90.0)]}
        self.assertEqual({"arm": (90.0, None)}, memory.growth())


class Places(unittest.TestCase):
    def setUp(self):
        cells = numpy.zeros((200, 200), numpy.int8)
        cells[:, 100:104] = 100
        self.map = TrueMap(cells, 0.05, 0.0, 0.0)

    def test_a_drive_ends_where_a_straight_line_is_free(self):
        rng, here = random.Random(3), Pose(3.0, 5.0, 0.0)
        for _ in range(50):
            place = robot_tasks.free_place(rng, self.map, here)
            self.assertLess(place.x, 5.0 - robot_tasks.CLEAR_M + 0.05, "beyond the wall")
            self.assertLessEqual(math.hypot(place.x - 3.0, place.y - 5.0), robot_tasks.FAR_M)

    def test_where_nothing_is_free_there_is_no_drive(self):
        self.assertIsNone(robot_tasks.free_place(random.Random(3), self.map, Pose(4.9, 5.0, 0.0)))

    def test_poses(self):
        a, b = Pose(1.0, 2.0, 0.5), Pose(-0.3, 0.7, 2.9)
        back = compose(inverse(a), compose(a, b))
        for name in ("x", "y", "yaw"):
            self.assertAlmostEqual(getattr(b, name), getattr(back, name))


class Order(unittest.TestCase):
    def test_each_fault_comes_once_before_any_comes_again(self):
        with mock.patch.object(robot_faults, "ProcessTable"), mock.patch.dict("os.environ", ROS_MASTER_URI="http://localhost:1"):
            faults = robot_faults.Faults(types.SimpleNamespace(complete=True, well=lambda but: True), 5, None)
        faults._kinds = [(str(number), lambda: 0.0) for number in range(6)]
        names = [faults.next().name for _ in range(12)]
        self.assertEqual([sorted(map(str, range(6)))] * 2, [sorted(names[:6]), sorted(names[6:])])
        self.assertNotEqual(names[:6], names[6:])


class Well(unittest.TestCase):
    def test_a_robot_that_restarted_is_well_while_the_mapper_alone_warns(self):
        listener = robot_health.Listener.__new__(robot_health.Listener)
        for message, but, well in (("all 9 parts run", (), True), ("warning: mapper", (), False), ("warning: mapper", ("mapper",), True),
                                   ("warning: mapper, arm", ("mapper",), False), ("missing: arm; warning: mapper", ("mapper",), False)):
            listener.summary = types.SimpleNamespace(level=0 if message.startswith("all") else 1, message=message)
            self.assertEqual(well, listener.well(but), message)


class Meter(unittest.TestCase):
    def test_parts_are_their_nodelet_managers(self):
        with tempfile.TemporaryDirectory() as root:
            table = types.SimpleNamespace(scan=lambda: {"/arm_manager": types.SimpleNamespace(pid=7), "/arm": types.SimpleNamespace(pid=8)})
            with mock.patch.object(part_meter, "ProcessTable", lambda *_: table):
                for pid in (7, 8):
                    self.write(root, pid, ticks=100, pages=512)
                meter = part_meter.PartMeter("", root)
                self.write(root, 7, ticks=100 + 3 * part_meter.TICKS_PER_S, pages=1024)
                used = meter.used()
        cpu_s, memory_mb = used["arm"]
        self.assertAlmostEqual(3.0, cpu_s)
        self.assertAlmostEqual(1024 * part_meter.PAGE_MB, memory_mb)
        self.assertEqual(0.0, used[part_meter.OTHERS][0])

    @staticmethod
    def write(root, pid, ticks, pages):
        folder = pathlib.Path(root) / str(pid)
        folder.mkdir(exist_ok=True)
        (folder / "stat").write_text(f"{pid} (a (b) c) S " + " ".join(["0"] * 10) + f" {ticks - 40} 40 0 0")
        (folder / "statm").write_text(f"9999 {pages} 5")


class Latencies(unittest.TestCase):
    def test_results_are_matched_with_their_source_by_the_stamp(self):
        made = streams.Streams.__new__(streams.Streams)
        made._speed, made._lock = 2.0, mock.MagicMock()
        made._arrivals = {"images": {(1, 0): 10.0, (2, 0): 11.0}, "results": {(1, 0): 10.1, (3, 0): 12.0}}
        self.assertEqual([200], [round(value) for value in made.latencies_ms("images", "results")])

    def test_the_stamp_of_any_message(self):
        self.assertEqual((5, 70), streams.stamp_of(types.SimpleNamespace(_buff=struct.pack("<IIII", 3, 5, 70, 0))))

    def test_wrong_options_are_refused(self):
        with mock.patch.object(argparse.ArgumentParser, "error", side_effect=ValueError):
            for wrong in (["--seconds", "1"], ["--cameras", "0"], ["--slower", "-1"]):
                with self.assertRaises(ValueError, msg=wrong):
                    bench_system.parse(wrong)


if __name__ == "__main__":
    unittest.main()
