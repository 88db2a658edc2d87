"""Progress: a bar on a terminal, otherwise a plain line now and then."""

import sys
import time

LINE_EVERY_S = 30.0
WIDTH = 24


def duration(seconds):
    """e.g. "1:02:03" or "2:03"."""
    seconds = int(round(seconds))
    hours, minutes = seconds // 3600, seconds // 60 % 60
    return f"{hours}:{minutes:02d}:{seconds % 60:02d}" if hours else f"{minutes}:{seconds % 60:02d}"


class Progress:
    """A bar with the time left for `total` steps of which `done` lie behind; rates count from the construction."""

    def __init__(self, total, done=0, stream=None, clock=time.monotonic, enabled=True):
        self.total, self.done, self.first = total, done, done
        self.stream, self.clock, self.enabled = stream or sys.stderr, clock, enabled
        self.begin = self.shown = clock()
        self.is_terminal = getattr(self.stream, "isatty", lambda: False)()

    def step(self, text=""):
        """One step more. text: or a function that gives it, called when it is shown."""
        self.done += 1
        now = self.clock()
        if self.enabled and now - self.shown >= (0.1 if self.is_terminal else LINE_EVERY_S):
            self.shown = now
            self._show(text() if callable(text) else text)

    def line(self, text):
        """A line that stays."""
        if self.enabled:
            clear = "\r\033[K" if self.is_terminal else ""
            self.stream.write(f"{clear}{text}\n")
            self.stream.flush()

    def left_s(self):
        """Estimated seconds until the end; None before the first step."""
        made = self.done - self.first
        return (self.clock() - self.begin) / made * (self.total - self.done) if made else None

    def _show(self, text):
        left = self.left_s()
        tail = f"{self.done}/{self.total} {text}, {duration(left)} left" if left is not None else text
        if self.is_terminal:
            filled = WIDTH * self.done // max(1, self.total)
            self.stream.write(f"\r\033[K[{'#' * filled}{'.' * (WIDTH - filled)}] {tail}")
        else:
            self.stream.write(f"step {tail}\n")
        self.stream.flush()
