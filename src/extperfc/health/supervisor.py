"""What has to be done about parts whose processes ended or hang. Decides only; times are seconds of a clock that never jumps."""

import collections
import dataclasses

from extperfc.health.part_state import MINUTE_S, PartState

GIVEN_UP_S = 5.0  # a node that hangs is looked at more often than that


@dataclasses.dataclass(frozen=True)
class End:
    """End this process; roslaunch starts it again."""
    process: object
    reason: str


@dataclasses.dataclass(frozen=True)
class Unload:
    """Ask a manager to unload a nodelet whose loader ended without doing so; the next loader needs its name."""
    manager: object  # its Process
    nodelet: str


class Limit:
    """At most `count` restarts of a node within a minute."""

    def __init__(self, count):
        self._count = count
        self._times = collections.defaultdict(collections.deque)

    def allows(self, node, now):
        """Whether one more is left; counts it."""
        times = self._times[node]
        while times and now - times[0] > MINUTE_S:
            times.popleft()
        if len(times) >= self._count:
            return False
        times.append(now)
        return True

    def recent(self, now):
        return sum(now - time <= MINUTE_S for times in self._times.values() for time in times)


class Supervisor:
    """The parts of `settings`, seen from time to time by look()."""

    def __init__(self, settings, now):
        self.parts = [PartState(part, now) for part in settings.parts]
        self.limit = Limit(settings.max_restarts_per_minute)
        self._processes = {}
        self._orphans = set()  # loaders whose manager ended: there is nothing that they should have unloaded
        self._given_up = {}    # name of a node that was to be ended once more than allowed -> when

    def add(self, status, now):
        """Gives a status of diagnostics to its part; false where it belongs to none."""
        owners = [part for part in self.parts if part.matches(status.name)]
        for part in owners:
            part.add(status, now)
        return bool(owners)

    def look(self, processes, now):
        """Takes over {name: Process} of the living nodes. Returns a list of End and Unload."""
        actions = self._left_behind(processes)
        self._processes = processes
        for part in self.parts:
            part.set_processes(self._needed(part, processes), now)
            actions += self._end_hanging(part, now)
        return actions

    @staticmethod
    def _needed(part, processes):
        node = processes.get(part.part.node)
        if node is None or node.manager is None:
            return (node,) if node else ()
        manager = processes.get(node.manager)
        return (node, manager) if manager else ()

    def _left_behind(self, processes):
        """Loaders whose manager ended, and nodelets whose loader ended."""
        actions = []
        for loader in filter(lambda process: process.manager, self._processes.values()):
            manager = self._processes.get(loader.manager)
            if manager is None:
                continue
            manager_lives, loader_lives = processes.get(manager.node) == manager, processes.get(loader.node) == loader
            if loader_lives and not manager_lives:
                self._orphans.add(loader)
                actions.append(End(loader, f"its manager {manager.node} ended"))
            elif manager_lives and not loader_lives and loader not in self._orphans:
                actions.append(Unload(manager, loader.node))
        self._orphans.intersection_update(processes.values())
        return actions

    def _end_hanging(self, part, now):
        """The process to end of a part that hangs: of a nodelet first the loader, whose manager must unload it then."""
        node = self._processes.get(part.part.node)
        if node is None or not part.hangs(now):
            return []
        return self._within_limit(node, f"{part.part.name} is {part.message(now)}", now)

    def end_overdue(self, managers, now):
        """Ends of managers that did not unload a nodelet in time."""
        return [end for manager in managers for end in self._within_limit(manager, "it did not unload a nodelet in time", now)]

    def _within_limit(self, process, reason, now):
        """The End as a list, empty when the process was ended too often."""
        if self.limit.allows(process.node, now):
            return [End(process, reason)]
        self._given_up[process.node] = now
        return []

    def given_up(self, now):
        """Names of nodes that hang and are left alone, since they were ended too often."""
        return sorted(name for name, time in self._given_up.items() if now - time < GIVEN_UP_S)
