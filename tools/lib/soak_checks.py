"""What the notes of a soak's nodes must show."""

import collections
import dataclasses

Note = collections.namedtuple("Note", "kind name run number time")

RECOVERY_S = 12.0  # after a fault, until messages come again
SETTLE_S = 1.0     # after the first of them
BEFORE_S = 0.5     # what is sent so shortly before a fault may be lost in it
STALE_S = 1.0      # a command older than that must not arrive: the profile's age, 0.2 s, and the way of 0.8 s
SLOPE_MB_PER_HOUR = 20.0
GROWTH_MB = 8.0


@dataclasses.dataclass
class Fault:
    begin: float
    end: float
    text: str


def read_notes(file):
    """Whole lines only: the last may have been cut by a kill."""
    notes = []
    with open(file) as lines:
        for line in lines:
            tokens = line.split()
            if len(tokens) == 5 and line.endswith("\n"):
                notes.append(Note(tokens[0], tokens[1], int(tokens[2]), int(tokens[3]), float(tokens[4])))
    return notes


@dataclasses.dataclass
class Stream:
    """One topic: what was sent and heard, over the whole soak."""
    topic: str
    sent: list
    heard: list
    checked: int = 0
    missing: list = dataclasses.field(default_factory=list)
    doubled: int = 0
    slowest_recovery_s: float = 0.0
    problems: list = dataclasses.field(default_factory=list)

    def check(self, faults, end):
        """Between the faults, once messages come again, everything that was sent arrives, once."""
        arrived = collections.Counter((note.run, note.number) for note in self.heard)
        self.doubled = sum(count - 1 for count in arrived.values())
        for begin, stop, text in windows(faults, end):
            first = next((note.time for note in self.heard if note.time >= begin), None)
            if first is None or first - begin > RECOVERY_S or first > stop:
                if stop - begin > RECOVERY_S:
                    self.problems.append(f"{self.topic}: silent for {stop - begin:.1f} s after: {text}")
                continue
            self.slowest_recovery_s = max(self.slowest_recovery_s, first - begin)
            due = [note for note in self.sent if first + SETTLE_S <= note.time < stop - BEFORE_S]
            lost = [note for note in due if (note.run, note.number) not in arrived]
            self.checked += len(due)
            self.missing += lost
            if lost:
                self.problems.append(f"{self.topic}: {len(lost)} of {len(due)} lost after: {text}")
        if self.doubled:
            self.problems.append(f"{self.topic}: {self.doubled} arrived twice")


def windows(faults, end):
    """(begin, end, what happened before) of the times without a fault."""
    for i, fault in enumerate(faults):
        yield fault.end, faults[i + 1].begin if i + 1 < len(faults) else end, fault.text


def stale(stream, stops):
    """Messages that arrived too old, other than those that lay in the buffer of a listener that was stopped or cut off."""
    sent_at = {(note.run, note.number): note.time for note in stream.sent}
    late = []
    for note in stream.heard:
        sent = sent_at.get((note.run, note.number))
        if sent is None or note.time - sent <= STALE_S:
            continue
        if not any(fault.begin - BEFORE_S <= sent <= fault.end for fault in stops):
            late.append(note)
    return late


def slope_mb_per_hour(samples):
    """Least squares over (time [s], size [MB])."""
    if len(samples) < 3:
        return 0.0
    mean_t = sum(t for t, _ in samples) / len(samples)
    mean_m = sum(m for _, m in samples) / len(samples)
    spread = sum((t - mean_t) ** 2 for t, _ in samples)
    return 3600 * sum((t - mean_t) * (m - mean_m) for t, m in samples) / spread if spread else 0.0


def memory_problems(samples):
    """Of (time [s], size [MB]); the first fifth is warming up. A slope counts once it makes some megabytes."""
    steady = samples[len(samples) // 5:]
    if len(steady) < 3:
        return []
    slope, growth = slope_mb_per_hour(steady), steady[-1][1] - steady[0][1]
    grown_mb = slope / 3600 * (steady[-1][0] - steady[0][0])
    problems = []
    if slope > SLOPE_MB_PER_HOUR and grown_mb > 2.0:
        problems.append(f"memory grows by {slope:.1f} MB per hour")
    if growth > GROWTH_MB:
        problems.append(f"memory grew by {growth:.1f} MB")
    return problems
