"""What the menu of the goals does: one command at a time, in a thread of its own, and "stop" at any time."""

import threading

from extperfc.arm.errors import ArmError
from extperfc.arm.hands import ALL


class Commands:
    """arms: {arm, "both": extperfc.arm.Arm}; goals: {side: ArmGoal}; changed(): the arms have moved."""

    def __init__(self, arms, goals, changed):
        self._arms, self._goals, self._changed = arms, goals, changed
        self._busy, self._plan, self._linear = threading.Lock(), None, False

    # Each of these returns at once. `which` is a side or "both".

    def plan(self, which):
        self._start(which, "planning", self._plan_now)

    def execute(self, which):
        """Executes what was planned last, of any arm."""
        self._start(which, "moving", self._execute_now)

    def plan_and_execute(self, which):
        self._start(which, "planning and moving", self._move_now)

    def go_to(self, which, state):
        self._start(which, f"moving to {state}", lambda who: self._moved(who, self._arms[who].move_to(state)))

    def open(self, side):
        self._start(side, "opening", lambda who: self._arms[who].open() or "open")

    def close(self, side):
        self._start(side, "closing", lambda who: "holds an object" if self._arms[who].close() else "closed, empty")

    def stop(self, which):
        threading.Thread(target=self._stop_now, args=(which,), daemon=True).start()

    def set_linear(self, linear):
        self._linear = linear

    # Below: in the command's thread. What they return is shown.

    def _goal_of(self, which):
        return {side: goal.pose for side, goal in self._goals.items()} if which == ALL else self._goals[which].pose

    def _plan_now(self, which):
        self._plan = None
        self._plan = self._arms[which].plan(self._goal_of(which), linear=self._linear)
        return f"path of {self._plan.duration_s:.1f} s, planned in {1000 * self._plan.planning_time_s:.0f} ms"

    def _execute_now(self, which):
        if self._plan is None:
            return "no plan yet"
        plan, self._plan = self._plan, None
        return self._moved(which, self._arms[which].execute(plan))

    def _move_now(self, which):
        return self._moved(which, self._arms[which].move_to(self._goal_of(which), linear=self._linear))

    def _moved(self, which, result):
        self._changed(which)
        return result.message or "there"

    def _stop_now(self, which):
        try:
            self._arms[ALL].stop()
            self._say(which, "stopped")
        except ArmError as error:
            self._say(which, str(error), False)

    def _start(self, which, what, work):
        if not self._busy.acquire(blocking=False):
            self._say(which, "busy: stop it, or wait", False)
            return
        threading.Thread(target=self._run, args=(which, what, work), daemon=True).start()

    def _run(self, which, what, work):
        self._say(which, what + " ...")
        try:
            said = (work(which), True)
        except (ArmError, ValueError) as error:
            said = (str(error), False)
        finally:
            self._busy.release()  # before it is said: who reads it may go on
        self._say(which, *said)

    def _say(self, which, text, good=True):
        for side in self._goals if which == ALL else (which,):
            self._goals[side].say(text, good)
