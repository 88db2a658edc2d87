"""Whether a part runs: what its processes and its diagnostics say together. Times are seconds of a clock that never jumps."""

import collections
import enum
import re

OK, WARN, ERROR, STALE = 0, 1, 2, 3  # levels of diagnostic_msgs/DiagnosticStatus


MINUTE_S = 60.0
MANY_STARTS = 6  # within a minute, without a report: it will not start by itself


class State(enum.Enum):
    STARTING = "starting"
    RUNNING = "running"
    SILENT = "silent"    # a process lives, its diagnostics are old
    MISSING = "missing"  # no process
    REFUSING = "refuses to start"  # started again and again, and ended each time


class PartState:
    """State of one part, a settings.Part."""

    def __init__(self, part, now):
        self.part = part
        self._pattern = re.compile(part.diagnostics)
        self._statuses = {}    # name -> (status, time of its arrival), since the latest change of processes
        self._processes = ()   # of the node and of its manager; empty where one of them is missing
        self._was_local = False
        self._since = now      # of the latest start or end of a process
        self._starts = collections.deque(maxlen=100)  # times

    def matches(self, status_name):
        return self._pattern.fullmatch(status_name) is not None

    def add(self, status, now):
        self._statuses[status.name] = (status, now)

    def set_processes(self, processes, now):
        """The living processes that the part needs, empty where one is missing."""
        if processes != self._processes:
            self._processes, self._since, self._statuses = processes, now, {}
            if processes:
                self._starts.append(now)
        self._was_local = self._was_local or bool(processes)

    def _recent_starts(self, now):
        return sum(now - time < MINUTE_S for time in self._starts)

    def state(self, now):
        if not self._statuses and self._recent_starts(now) >= MANY_STARTS:
            return State.REFUSING
        if self._was_local and not self._processes:
            return State.MISSING
        if not self._statuses and now - self._since < self.part.start_s:
            return State.STARTING
        if now - self._last_sign() <= self.part.max_age_s and self._statuses:
            return State.RUNNING
        return State.SILENT if self._processes else State.MISSING

    def _last_sign(self):
        """When the part showed last that it works; a start counts when its time is over."""
        return max((time for _, time in self._statuses.values()), default=self._since + self.part.start_s)

    def hangs(self, now):
        return self.state(now) is State.SILENT and now - self._last_sign() > self.part.hang_s

    def statuses(self, now):
        """The latest diagnostics; of a part that runs without those that it does not repeat."""
        oldest = now - self.part.max_age_s if self.state(now) is State.RUNNING else float("-inf")
        return [status for status, time in self._statuses.values() if time >= oldest]

    def level(self, now):
        state = self.state(now)
        if state is State.RUNNING:
            return max(status.level for status in self.statuses(now))
        return {State.STARTING: WARN, State.SILENT: STALE}.get(state, ERROR)

    def message(self, now):
        """One line: the state, and what the diagnostics complain of."""
        state, level = self.state(now), self.level(now)
        if state is State.SILENT:
            return f"silent for {now - self._last_sign():.0f} s"
        if state is State.RUNNING and level != OK:
            return "; ".join(dict.fromkeys(status.message for status in self.statuses(now) if status.level == level))
        if state is State.REFUSING:
            return f"{state.value}: started {self._recent_starts(now)} times within a minute"
        return state.value
