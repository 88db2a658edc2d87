"""Runs the whole simulated robot for a long time, with random tasks and a fault every few seconds, and checks the end.

Everything of bringup.launch at once: detection, mapping, navigation, arms, health. The base drives, the arms move, images are asked
for, one after another and at random. Meanwhile, in random order: a part's nodelet manager or loader is killed, one hangs, health is
killed, the camera freezes, the lidar's sweeps are lost, the ROS master starts again. Checked: after each fault all parts work again;
a task that fails does so during a fault, or within some seconds after it, and says why; nothing is touched; memory does not grow
without end. Exit code 0 when all holds, else 1.
"""

import argparse
import contextlib
import dataclasses
import json
import os
import pathlib
import statistics
import sys
import time

import rospy

from part_meter import OTHERS, PartMeter, part_of
from ros_session import Stalled, run_trial
import translated_robot  # noqa: E402 (it adds the place of harness)
from harness import network  # noqa: E402

WS = pathlib.Path(os.environ.get("EXTPERFC_WS", pathlib.Path(__file__).resolve().parents[2] / ".ws"))
READY_S = 120.0
AFTERWARDS_S = 20.0      # a task that began so soon after a fault may fail because of it: a map or a costmap is young
YOUNG_MAP_S = 10.0       # until the map shows what is around the robot
SAMPLE_S = 5.0           # of memory
YOUNG_S = 60.0           # of a process: what it loads does not count as growth
GROWS_MB_MIN = 6.0       # of a process that lived for OLD_S; a map grows with what is seen
OLD_S = 240.0


def parse_arguments(argv):
    parser = argparse.ArgumentParser(prog="tools/soak_robot", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--minutes", type=float, default=120.0, metavar="M", help="default: 120")
    parser.add_argument("--every", type=float, default=20.0, metavar="S", help="between a fault's end and the next; default: 20")
    parser.add_argument("--seed", type=int, default=1, metavar="N", help="of tasks, faults and the simulator; default: 1")
    parser.add_argument("--world", default="office", help="of the simulator; default: office")
    parser.add_argument("--translated", action="store_true",
                        help="the simulated robot has a master of its own, behind a network link, and the translator is between them; "
                             "more faults: the robot starts again with its master, the link is slow or cut (needs root)")
    parser.add_argument("--out", type=pathlib.Path, default=WS / "soak_robot", metavar="FOLDER",
                        help="log and soak.json; default: .ws/soak_robot")
    options = parser.parse_args(argv)
    if options.minutes <= 0 or options.every < 0:
        parser.error("--minutes must be positive, --every 0 or more")
    return options


class Memory:
    """Of every process, as it grows: {(node, pid): [(time [s], MB)]}."""

    def __init__(self, meter):
        self._meter, self._next_s, self.samples = meter, 0.0, {}

    def note(self):
        now = time.monotonic()
        if now < self._next_s:
            return
        self._next_s = now + SAMPLE_S
        for key, memory_mb in self._meter.memory().items():
            self.samples.setdefault(key, []).append((now, memory_mb))

    def growth(self):
        """{part: (largest memory [MB], MB per minute of its oldest process after its first minute, None: none was so old)}."""
        found = {}
        for (node, _), samples in self.samples.items():
            part = part_of(node)
            if part == OTHERS:
                continue
            largest_mb, rate, age_s = found.get(part, (0.0, None, OLD_S))
            largest_mb = max(largest_mb, max(memory_mb for _, memory_mb in samples))
            settled = [sample for sample in samples if sample[0] > samples[0][0] + YOUNG_S]
            own_age_s = samples[-1][0] - samples[0][0]
            if own_age_s >= age_s:
                rate, age_s = 60 * (settled[-1][1] - settled[0][1]) / (settled[-1][0] - settled[0][0]), own_age_s
            found[part] = largest_mb, rate, age_s
        return {part: (largest_mb, rate) for part, (largest_mb, rate, _) in found.items()}


class Soak:
    """One run: what was injected and what was done meanwhile."""

    def __init__(self, options, session, robot, cable):
        import std_msgs.msg
        from nav_robot import NavRobot
        from extperfc.arm import robot_state
        from robot_faults import Faults
        from robot_health import Listener
        from robot_tasks import Tasks
        self.options, self.session, self.faults, self.contacts, self._touched = options, session, [], 0, False
        session.start_master()
        if robot:
            session.launch(None, translated_robot.LAUNCH_FILE, robot_master=robot.master.uri)
        else:
            session.launch("extperfc", "bringup.launch", rviz="false", world=options.world, seed=options.seed)
        session.join("soak_robot")
        rospy.Subscriber("sim/truth/blocked", std_msgs.msg.Bool, self._on_blocked)
        # Before Listener, which takes any message: a topic's first subscription decides in which type its messages come.
        robot_state.frames()
        self.robot = NavRobot(session.alive)
        self.listener = Listener()
        self.robot.wait(lambda: self.listener.complete, "a complete robot", READY_S)
        self.robot.ready()
        self.tasks = Tasks(self.robot, options.seed)
        self._source = Faults(self.listener, options.seed, session, robot, cable)
        self.memory = Memory(PartMeter(os.environ["ROS_MASTER_URI"]))

    def _on_blocked(self, message):
        self.contacts += message.data and not self._touched
        self._touched = message.data

    def run(self):
        self.begin_s = time.monotonic()
        end_s = self.begin_s + 60 * self.options.minutes
        self._wait(min(end_s, self.begin_s + YOUNG_MAP_S))
        self.tasks.start()
        self._wait(min(end_s, self.begin_s + self.options.every))
        while time.monotonic() < end_s:
            fault = self._source.next()
            self.faults.append(fault)
            back = f"works again after {fault.back_s:.1f} s" if fault.back_s is not None else "DOES NOT WORK AGAIN"
            back += f", all well after {fault.well_s:.1f} s" if fault.well_s is not None else ", NOT ALL IS WELL AGAIN"
            print(f"{(fault.begin_s - self.begin_s) / 60:6.1f} min  {fault.name}: {back}", flush=True)
            self._wait(min(end_s, time.monotonic() + self.options.every))
        self.tasks.stop()
        self.tasks.join(120.0)

    def _wait(self, until_s):
        while time.monotonic() < until_s:
            if not self.session.alive():
                raise Stalled("roslaunch has ended")
            if self.tasks.problem:
                raise Stalled(self.tasks.problem)
            self.memory.note()
            time.sleep(0.2)

    def of_a_fault(self, outcome):
        """Whether a task ran while something was broken, or had just been."""
        return any(outcome.begin_s < fault.end_s + AFTERWARDS_S and fault.begin_s < outcome.end_s for fault in self.faults)

    def problems(self):
        """What is wrong, a line each."""
        found = [f"{fault.name}: it did not work again" for fault in self.faults if fault.back_s is None]
        found += [f"{fault.name}: a part still complained {fault.end_s - fault.begin_s:.0f} s later" for fault in self.faults
                  if fault.back_s is not None and fault.well_s is None]
        found += [f"{task.kind} failed without a fault after {(task.begin_s - self.begin_s) / 60:.1f} min: {task.why}"
                  for task in self.tasks.outcomes if not task.done and not self.of_a_fault(task)]
        found += [f"{part} grows by {rate:.1f} MB a minute" for part, (_, rate) in self.memory.growth().items()
                  if rate is not None and rate > GROWS_MB_MIN]
        if self.tasks.is_alive():
            found.append(f"a task does not end: {self.tasks.present}")
        if self.contacts:
            found.append(f"the base touched something {self.contacts} times")
        return found


def spread(values):
    """Median and maximum; None is left out."""
    good = [value for value in values if value is not None]
    return f"{statistics.median(good):.1f}, {max(good):.1f}" if good else "never"


def show(soak, problems):
    print(f"\n{'fault':34}  times  works again after  all parts are well after, median and worst [s]")
    for name in sorted({fault.name for fault in soak.faults}):
        own = [fault for fault in soak.faults if fault.name == name]
        print(f"{name:34}  {len(own):5d}  {spread([fault.back_s for fault in own]):17}  {spread([fault.well_s for fault in own])}")
    print(f"\n{'task':8}  done  failed during a fault  without")
    for kind in sorted({task.kind for task in soak.tasks.outcomes}):
        own = [task for task in soak.tasks.outcomes if task.kind == kind]
        failed = [soak.of_a_fault(task) for task in own if not task.done]
        print(f"{kind:8}  {len(own) - len(failed):4d}  {sum(failed):21d}  {len(failed) - sum(failed):7d}")
    print(f"\n{'memory':34}  largest [MB]  grows [MB per minute]")
    for part, (largest_mb, rate) in sorted(soak.memory.growth().items()):
        print(f"{part:34}  {largest_mb:12.0f}  {'-' if rate is None else f'{rate:.2f}':>21}")
    print("\n" + ("\n".join(problems) if problems else "everything works at the end, and nothing was lost but by a fault"))


def one_run(options, session, robot=None, cable=None):
    """The exit code. robot: a RobotSide, cable: between it and here, where there are any."""
    soak = Soak(options, session, robot, cable)
    soak.run()
    problems = soak.problems()
    show(soak, problems)
    content = {"minutes": options.minutes, "seed": options.seed, "problems": problems, "contacts": soak.contacts,
               "faults": [dataclasses.asdict(fault) for fault in soak.faults],
               "tasks": [dataclasses.asdict(task) for task in soak.tasks.outcomes], "memory": soak.memory.growth()}
    (options.out / "soak.json").write_text(json.dumps(content, indent=1) + "\n")
    return 1 if problems else 0


def main(argv):
    options = parse_arguments(argv)
    options.out.mkdir(parents=True, exist_ok=True)
    if not options.translated:
        return run_trial(options.out, lambda session: one_run(options, session), Stalled)
    with contextlib.ExitStack() as stack:
        networks = stack.enter_context(contextlib.closing(network.LinkedNetworks()))
        if networks.why_not:
            print(f"without a link that is slow or cut: {networks.why_not}", file=sys.stderr)
        stack.enter_context(networks.here.inside())  # and all that starts from here on
        robot = translated_robot.RobotSide(networks.robot, options.out, world=options.world, seed=options.seed)
        stack.callback(robot.close)
        robot.start()
        return run_trial(options.out, lambda session: one_run(options, session, robot, networks.cable), Stalled)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
