"""What is decided about parts that end or hang, and what their tree says. Times are written as seconds."""

import types
import unittest

from extperfc.health import settings, tree
from extperfc.health.part_state import ERROR, OK, STALE, WARN, State
from extperfc.health.processes import Process
from extperfc.health.supervisor import End, Supervisor, Unload

VALUES = {"look_period_s": 0.2, "publish_period_s": 1.0, "ping_period_s": 1.0, "master_period_s": 2.0, "start_s": 10.0, "max_age_s": 3.0, "hang_s": 6.0,
          "unload_s": 2.0, "max_restarts_per_minute": 2,
          "parts": {"navigator": {"group": "Navigation"}, "mux": {"group": "Navigation"}, "publisher": {"group": "Robot"}}}
MANAGER = Process(10, 100, "/manager")
NAVIGATOR = Process(11, 101, "/navigator", "/manager")
MUX = Process(12, 102, "/mux", "/manager")
PUBLISHER = Process(13, 103, "/publisher")


def table(*processes):
    return {process.node: process for process in processes}


ALL = table(MANAGER, NAVIGATOR, MUX, PUBLISHER)


def status(name, level=OK, message="fine"):
    return types.SimpleNamespace(name=name, level=level, message=message, hardware_id="none", values=[])


class Supervised(unittest.TestCase):
    def setUp(self):
        self.supervisor = Supervisor(settings.load(VALUES), 0.0)
        self.parts = {part.part.name: part for part in self.supervisor.parts}
        self.supervisor.look(ALL, 0.0)

    def report(self, now, *names):
        for name in names or self.parts:
            self.assertTrue(self.supervisor.add(status(f"{name}: it"), now))

    def states(self, now):
        return {name: part.state(now) for name, part in self.parts.items()}


class States(Supervised):
    def test_from_start_to_silence(self):
        self.assertEqual({State.STARTING}, set(self.states(5.0).values()))
        self.report(5.0)
        self.assertEqual({State.RUNNING}, set(self.states(8.0).values()))
        self.assertEqual({State.SILENT}, set(self.states(8.1).values()))

    def test_what_never_reports_is_silent_when_its_start_is_over(self):
        self.assertEqual(State.STARTING, self.states(9.9)["mux"])
        self.assertEqual(State.SILENT, self.states(10.1)["mux"])
        self.assertFalse(self.parts["mux"].hangs(15.9))
        self.assertTrue(self.parts["mux"].hangs(16.1))

    def test_without_its_manager_a_nodelet_is_missing_at_once(self):
        self.report(1.0)
        self.supervisor.look(table(NAVIGATOR, MUX, PUBLISHER), 1.1)
        self.assertEqual({"navigator": State.MISSING, "mux": State.MISSING, "publisher": State.RUNNING}, self.states(1.2))

    def test_reports_of_the_process_before_do_not_count(self):
        self.report(1.0)
        self.supervisor.look(table(MANAGER, NAVIGATOR, MUX, Process(99, 500, "/publisher")), 1.1)
        self.assertEqual(State.STARTING, self.states(1.2)["publisher"])
        self.report(1.3, "publisher")
        self.assertEqual(State.RUNNING, self.states(1.4)["publisher"])

    def test_what_refuses_to_start_is_said_to(self):
        for pid in range(50, 54):
            self.supervisor.look(table(Process(pid, pid, "/publisher")), float(pid))
            self.supervisor.look(table(), pid + 0.5)
        self.assertEqual("missing", self.parts["publisher"].message(54.9), "four starts and that at 0 s")
        self.supervisor.look(table(Process(55, 55, "/publisher")), 55.0)
        self.assertEqual((ERROR, "refuses to start: started 6 times within a minute"),
                         (self.parts["publisher"].level(55.1), self.parts["publisher"].message(55.1)))
        self.report(55.2, "publisher")
        self.assertEqual("running", self.parts["publisher"].message(55.3))

    def test_a_part_on_another_machine_counts_by_its_reports(self):
        far = Supervisor(settings.load(VALUES), 0.0)
        far.look({}, 0.0)
        far.add(status("mux: it"), 1.0)
        self.assertEqual(State.RUNNING, far.parts[1].state(2.0))
        self.assertEqual(State.MISSING, far.parts[1].state(4.1))

    def test_a_status_that_is_not_repeated_is_forgotten(self):
        self.supervisor.add(status("mux: old", ERROR, "broken"), 1.0)
        self.supervisor.add(status("mux: it"), 4.5)
        self.assertEqual((OK, "running"), (self.parts["mux"].level(5.0), self.parts["mux"].message(5.0)))

    def test_names_belong_to_whole_nodes(self):
        self.assertFalse(self.supervisor.add(status("mux_other: it"), 1.0))
        self.assertTrue(self.supervisor.add(status("/mux: it"), 1.0))


class Actions(Supervised):
    def test_nothing_is_done_about_what_runs(self):
        for now in range(1, 30):
            self.report(float(now))
            self.assertEqual([], self.supervisor.look(ALL, now + 0.5))

    def test_loaders_end_with_their_manager(self):
        actions = self.supervisor.look(table(NAVIGATOR, MUX, PUBLISHER), 1.0)
        self.assertEqual([NAVIGATOR, MUX], [action.process for action in actions])
        self.assertIn("/manager ended", actions[0].reason)

    def test_a_manager_that_is_back_already_ends_the_old_loaders_only(self):
        new = Process(20, 200, "/manager")
        late = Process(21, 201, "/mux", "/manager")
        actions = self.supervisor.look(table(new, NAVIGATOR, late, PUBLISHER), 1.0)
        self.assertEqual([NAVIGATOR], [action.process for action in actions])
        self.assertEqual([], self.supervisor.look(table(new, late, PUBLISHER), 1.2))

    def test_a_nodelet_without_loader_is_unloaded(self):
        self.assertEqual([Unload(MANAGER, "/mux")], self.supervisor.look(table(MANAGER, NAVIGATOR, PUBLISHER), 1.0))
        self.assertEqual([], self.supervisor.look(table(MANAGER, NAVIGATOR, PUBLISHER), 1.2))

    def test_what_hangs_is_ended_not_more_often_than_allowed(self):
        ended, now = [], 1.0
        for pid in range(50, 56):
            hanging = Process(pid, pid, "/publisher")
            self.supervisor.look(table(MANAGER, NAVIGATOR, MUX, hanging), now)
            self.report(now)
            now += 6.5
            self.report(now, "navigator", "mux")
            ended += self.supervisor.look(table(MANAGER, NAVIGATOR, MUX, hanging), now)
        self.assertEqual([50, 51], [action.process.pid for action in ended])
        self.assertTrue(all(isinstance(action, End) for action in ended))
        self.assertEqual(["/publisher"], self.supervisor.given_up(now))
        self.assertEqual(2, self.supervisor.limit.recent(now))
        now += 60.0
        self.report(now, "navigator", "mux")
        self.assertEqual(55, self.supervisor.look(table(MANAGER, NAVIGATOR, MUX, hanging), now)[0].process.pid)

    def test_managers_that_do_not_unload_are_ended_within_the_same_limit(self):
        self.assertEqual([MANAGER], [action.process for action in self.supervisor.end_overdue([MANAGER], 1.0)])
        self.assertEqual(1, len(self.supervisor.end_overdue([MANAGER], 2.0)))
        self.assertEqual([], self.supervisor.end_overdue([MANAGER], 3.0))
        self.assertEqual(["/manager"], self.supervisor.given_up(4.0))
        self.assertEqual([], self.supervisor.given_up(9.0))


class Tree(Supervised):
    def test_summary_names_what_is_wrong(self):
        self.report(1.0)
        self.assertEqual((OK, "all 3 parts run"), self.summary(1.0))
        self.supervisor.add(status("mux: it", WARN, "slow"), 1.0)
        self.supervisor.look(table(MANAGER, NAVIGATOR, MUX), 1.0)
        self.assertEqual((ERROR, "missing: publisher; warning: mux"), self.summary(1.1))
        self.supervisor.add(status("mux: it", ERROR, "broken"), 1.2)
        self.assertEqual((ERROR, "missing: publisher; failing: mux"), self.summary(1.3))
        self.assertEqual((ERROR, "missing: publisher; silent: navigator, mux"), self.summary(5.0))

    def test_summary_begins_with_what_is_not_of_one_part(self):
        self.report(1.0)
        made = tree.summary(self.supervisor.parts, 1.0, "no ROS master")
        self.assertEqual((ERROR, "no ROS master"), (made.level, made.message))

    def summary(self, now):
        made = tree.summary(self.supervisor.parts, now)
        return made.level, made.message

    def test_every_status_has_its_branches_and_they_are_as_bad_as_the_worst(self):
        self.report(1.0)
        self.supervisor.add(status("mux: a/b", WARN, "slow"), 1.0)
        made = {entry.name: entry for entry in tree.build(self.supervisor.parts, [status("far: x", STALE)], 1.0)}
        self.assertEqual({"/Navigation", "/Navigation/navigator", "/Navigation/navigator/navigator: it", "/Navigation/mux",
                          "/Navigation/mux/mux: it", "/Navigation/mux/mux: a b", "/Robot", "/Robot/publisher",
                          "/Robot/publisher/publisher: it", "/Other", "/Other/far: x"}, set(made))
        self.assertEqual((WARN, WARN, OK, STALE), tuple(made[name].level for name in (
            "/Navigation", "/Navigation/mux", "/Robot", "/Other")))
        self.assertEqual("slow", made["/Navigation/mux"].message)
        self.assertEqual([("navigator", "running"), ("mux", "slow")],
                         [(value.key, value.value) for value in made["/Navigation"].values])


if __name__ == "__main__":
    unittest.main()
