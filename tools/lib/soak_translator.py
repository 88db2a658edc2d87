"""Runs the translator between two masters for a long time, with a fault every few seconds, and checks the end.

Talkers and listeners on both sides: topics that pass and that convert, latched ones, a command, a service. A fault at a
time, in random order: a master restarts with its nodes, a talker or a listener is killed, a listener stops, the network
of a side drops, garbage at the ports. Checked: between the faults all that is sent arrives, once; messages come again
after each fault; commands are never stale; who comes late gets all that is latched; the translator lives, and its
memory is flat. Exit code 0 when all holds, else 1.
"""

import argparse
import pathlib
import random
import sys
import time

REPO = pathlib.Path(__file__).resolve().parents[2]
sys.path[:0] = [str(REPO / "test" / "translator"), str(REPO / "test" / "translator_soak")]

import soak_checks  # noqa: E402
import soak_node  # noqa: E402
from harness import processes  # noqa: E402
from harness.session import Session  # noqa: E402
from soak_checks import Fault, Stream  # noqa: E402
from soak_faults import Faults  # noqa: E402

NODE = REPO / "test" / "translator_soak" / "soak_node.py"
COMMAND = "/robot/limb/left/joint_command_timeout"
SAMPLE_S = 2.0
LATE_S = 15.0  # for a late listener to get all that is latched, its own start included


class Node(processes.Child):
    """soak_node.py at a side."""

    def __init__(self, soak, name, run=0):
        role, side = name.split("_")[:2]
        master = getattr(soak.session, side)
        environment = master.environment()
        era = "indigo" if side == "robot" else "noetic"
        environment["PYTHONPATH"] = f"{processes.ERAS / era / 'python'}:{environment.get('PYTHONPATH', '')}"
        self.run = run
        self.file = soak.folder / f"{name}.txt"
        super().__init__(name, master.place, [processes.PYTHON, str(NODE), "--role", role, "--side", side, "--run", str(run),
                                              "--rate", str(soak.rate), "--file", str(self.file)], soak.folder, environment)

    def lines(self):
        return self.file.read_text().splitlines() if self.file.exists() else []


class Soak:
    """Everything that runs, and what was noted of it."""

    def __init__(self, arguments):
        self.rate = arguments.rate
        self.session = Session(one_host=arguments.one_host)
        self.folder = self.session.folder.path
        self.nodes, self._runs = {}, 0
        self.faults, self.memory, self.rates, self.problems = [], [], [], []
        self.translator = self.session.translate()

    def start(self, *names):
        """Nodes that ran before go on in the same file."""
        for name in names:
            self._runs += 1
            self.nodes[name] = Node(self, name, self._runs)
        for name in names:
            self._wait_ready(name)

    def _wait_ready(self, name, seconds=60):  # on a busy machine Python takes its time
        node, line = self.nodes[name], f" {self.nodes[name].run} 0 "
        ready = lambda: any(l.startswith("ready") and line in l for l in node.lines())
        processes.wait_until(lambda: ready() or not node.alive(), seconds, lambda: f"{name}: {node.log_tail()}")
        if not node.alive():
            raise RuntimeError(f"{name} ended: {node.log_tail()}")

    def kill(self, name):
        self.nodes[name].kill()

    def close(self):
        for node in self.nodes.values():
            node.end()
        self.session.close()

    # What is looked at while it runs.

    def sample(self):
        if not self.translator.alive():
            raise RuntimeError("the translator ended: " + self.translator.log_tail(30))
        self.memory.append((time.monotonic(), self.translator.memory_mb()))

    def pass_time(self, until):
        while time.monotonic() < until:
            self.sample()
            time.sleep(max(0.0, min(SAMPLE_S, until - time.monotonic())))

    def latched_now(self, side):
        """(topic, run, number) of what the talker of a side has latched."""
        run = self.nodes[f"talker_{side}"].run
        return {(name, run, 1) for name, (_, latched) in soak_node.topics_of(side).items() if latched}

    def check_late(self, side):
        """A listener that comes now gets everything that is latched on the other side."""
        name = f"late_{side}"
        due = self.latched_now("workstation" if side == "robot" else "robot")
        self._runs += 1
        node = Node(self, name, self._runs)
        begin = time.monotonic()
        heard = lambda: {(n.name, n.run, n.number) for n in soak_checks.read_notes(node.file) if n.kind == "heard"}
        try:
            processes.wait_until(lambda: node.file.exists() and due <= heard(), LATE_S, "latched")
            return f"late listener on {side}: all latched after {time.monotonic() - begin:.1f} s"
        except processes.TooLate:
            got = heard() if node.file.exists() else set()
            self.problems.append(f"late listener on {side} misses {sorted(due - got)}")
            return self.problems[-1]
        finally:
            node.end()
            node.file.unlink(missing_ok=True)

    def streams(self):
        """By topic, from the files of talkers and listeners."""
        found = {}
        for side, other in (("robot", "workstation"), ("workstation", "robot")):
            sent = soak_checks.read_notes(self.folder / f"talker_{side}.txt")
            heard = soak_checks.read_notes(self.folder / f"listener_{other}.txt")
            for topic, (_, latched) in soak_node.topics_of(side).items():
                if not latched:
                    found[topic] = Stream(topic, [n for n in sent if n.kind == "sent" and n.name == topic],
                                          [n for n in heard if n.kind == "heard" and n.name == topic])
        return found

    def calls(self):
        notes = soak_checks.read_notes(self.folder / "listener_workstation.txt")
        return [n for n in notes if n.kind in ("called", "failed")]


def parse_arguments(argv):
    parser = argparse.ArgumentParser(prog="tools/soak_translator", description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--minutes", type=float, default=30.0, metavar="N", help="default: 30")
    parser.add_argument("--fault-period", type=float, default=20.0, metavar="S", help="seconds from fault to fault; default: 20")
    parser.add_argument("--seed", type=int, default=1, metavar="N", help="of the order of the faults; default: 1")
    parser.add_argument("--rate", type=float, default=20.0, metavar="HZ", help="messages per second and topic; default: 20")
    parser.add_argument("--plot", type=pathlib.Path, metavar="PNG", help="draw memory and rates")
    parser.add_argument("--one-host", action="store_true", help="no network namespaces, even where they work")
    options = parser.parse_args(argv)
    if not (options.minutes > 0 and options.fault_period > 0 and options.rate > 0):
        parser.error("minutes, period and rate must be positive")
    return options


def say(begin, text):
    print(f"{time.monotonic() - begin:7.1f} s  {text}", flush=True)


def begin_all(soak, begin):
    soak.start(*(f"{role}_{side}" for role in ("talker", "listener") for side in ("robot", "workstation")))
    networks = "two network namespaces" if soak.session.separate else "one host"
    say(begin, f"two masters, {networks}, four nodes at {soak.rate:g} Hz per topic")
    soak.pass_time(time.monotonic() + 5.0)


def run(soak, arguments):
    """The faults, one after another, each with a late listener after it."""
    begin = time.monotonic()
    begin_all(soak, begin)
    period = arguments.fault_period
    lengths_s = [length for length in (1.0, 3.0, 10.0) if length <= period / 2] or [0.5]
    order = Faults(soak, random.Random(arguments.seed), lengths_s).shuffled()
    side_of_late = "workstation"
    stop = begin + 60 * arguments.minutes
    while time.monotonic() + period < stop:
        started = time.monotonic()
        text = next(order)()
        soak.faults.append(Fault(started, time.monotonic(), text))
        soak.sample()
        say(begin, f"{text} (translator: {soak.memory[-1][1]:.1f} MB)")
        soak.pass_time(started + period - 4.0 if period > 12 else started + 0.7 * period)
        side_of_late = "robot" if side_of_late == "workstation" else "workstation"
        line = soak.check_late(side_of_late)
        say(begin, line)
        soak.pass_time(started + period)
    for side in ("robot", "workstation"):
        say(begin, soak.check_late(side))


def check(soak, streams, end):
    problems = list(soak.problems)
    blind = [fault for fault in soak.faults if "stopped" in fault.text or "network of workstation" in fault.text]
    for stream in streams.values():
        stream.check(soak.faults, end)
        # A command that waited too long is dropped on purpose; but commands must come again after a fault.
        problems += [p for p in stream.problems if stream.topic != COMMAND or " lost after: " not in p]
    late = soak_checks.stale(streams[COMMAND], blind)
    problems += [f"{len(late)} stale commands arrived"] if late else []
    problems += soak_checks.memory_problems(soak.memory)
    problems += call_problems(soak, end)
    return problems


def call_problems(soak, end):
    failed = []
    for begin, stop, text in soak_checks.windows(soak.faults, end):
        from_s = begin + soak_checks.RECOVERY_S
        failed += [f"call failed {note.time - begin:.1f} s after: {text}" for note in soak.calls()
                   if note.kind == "failed" and from_s <= note.time < stop - soak_checks.BEFORE_S]
    return failed[:5]


def report(soak, streams, problems):
    print(f"\n{'topic':42} {'sent':>7} {'arrived':>7} {'checked':>7} {'missing':>7} {'twice':>5} {'slowest recovery':>17}")
    for stream in streams.values():
        print(f"{stream.topic:42} {len(stream.sent):7d} {len(stream.heard):7d} {stream.checked:7d} {len(stream.missing):7d} "
              f"{stream.doubled:5d} {stream.slowest_recovery_s:15.1f} s")
    calls = soak.calls()
    print(f"{soak_node.SERVICE:42} {len(calls):7d} {sum(n.kind == 'called' for n in calls):7d}   (calls, answered)")
    sizes = [size for _, size in soak.memory]
    print(f"memory of the translator: {sizes[0]:.1f} MB at first, {max(sizes):.1f} at most, {sizes[-1]:.1f} at the end, "
          f"{soak_checks.slope_mb_per_hour(soak.memory[len(soak.memory) // 5:]):+.1f} MB per hour")
    print(f"{len(soak.faults)} faults, {len(problems)} problems")
    for problem in problems:
        print("PROBLEM:", problem)


def plot(file, soak, streams, begin):
    try:
        import matplotlib
    except ImportError:
        print("no plot: needs matplotlib; install python3-matplotlib", file=sys.stderr)
        return
    matplotlib.use("Agg")
    import matplotlib.pyplot as plt
    figure, (memory, rates) = plt.subplots(2, 1, figsize=(10, 5.5), sharex=True)
    memory.plot([(t - begin) / 60 for t, _ in soak.memory], [size for _, size in soak.memory])
    memory.set_ylabel("resident memory [MB]")
    memory.set_ylim(0, 1.25 * max(size for _, size in soak.memory))
    bin_s = 5.0
    for stream in streams.values():
        counts = {}
        for note in stream.heard:
            counts[int((note.time - begin) / bin_s)] = counts.get(int((note.time - begin) / bin_s), 0) + 1
        last = int((soak.memory[-1][0] - begin) / bin_s)
        rates.plot([(i + 0.5) * bin_s / 60 for i in range(last)], [counts.get(i, 0) / bin_s for i in range(last)],
                   linewidth=0.8, label=stream.topic)
    for fault in soak.faults:
        for axis in (memory, rates):
            axis.axvline((fault.begin - begin) / 60, color="red", alpha=0.2, linewidth=0.7)
    rates.set_ylabel("arrived [1/s]")
    rates.set_xlabel("time [min]; red: a fault")
    rates.legend(fontsize="x-small", loc="upper center", ncol=3)
    rates.set_ylim(0, 1.3 * rates.get_ylim()[1])
    figure.tight_layout()
    figure.savefig(file, dpi=110)


def main(argv=None):
    arguments = parse_arguments(argv)
    print(f"seed {arguments.seed}", flush=True)
    begin = time.monotonic()
    soak = Soak(arguments)
    try:
        run(soak, arguments)
        end = time.monotonic()
        streams = soak.streams()
        problems = check(soak, streams, end)
        report(soak, streams, problems)
        if arguments.plot:
            plot(arguments.plot, soak, streams, begin)
    finally:
        soak.close()
    return 1 if problems else 0


if __name__ == "__main__":
    sys.exit(main())
