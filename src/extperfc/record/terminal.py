"""Single keys from the terminal, and a status line."""

import os
import select
import stat
import sys
import termios
import time
import tty


class Keys:
    """Keys of standard input without waiting for Enter, also from a pipe. A context manager: restores the terminal."""

    def __init__(self, stream=None):
        self._file = (stream or sys.stdin).fileno()
        self._settings = None
        self.is_open = True

    def __enter__(self):
        if os.isatty(self._file):
            self._settings = termios.tcgetattr(self._file)
            tty.setcbreak(self._file)
        return self

    def __exit__(self, *_):
        if self._settings:
            termios.tcsetattr(self._file, termios.TCSADRAIN, self._settings)

    def is_usable(self):
        """False where nothing can be typed, e.g. for /dev/null."""
        return os.isatty(self._file) or stat.S_ISFIFO(os.fstat(self._file).st_mode)

    def pressed(self):
        """What was typed since the last call, as text."""
        typed = b""
        while self.is_open and select.select([self._file], [], [], 0)[0]:
            data = os.read(self._file, 64)
            self.is_open = bool(data)
            typed += data
        return typed.decode(errors="ignore")


class StatusLine:
    """One line that is written over in a terminal; elsewhere a line every few seconds."""

    QUIET_S = 5.0  # between lines of a log
    REFRESH_S = 0.1

    def __init__(self, stream=None):
        self._stream = stream or sys.stdout
        self._is_terminal = self._stream.isatty()
        self._last, self._written = "", -1e9

    def show(self, text):
        """Shows counts; rarely enough for the output."""
        now = time.monotonic()
        if text == self._last or now - self._written < (self.REFRESH_S if self._is_terminal else self.QUIET_S):
            return
        self._last, self._written = text, now
        self._write(f"\r\033[K{text}" if self._is_terminal else f"{text}\n")

    def say(self, text):
        """A line that stays."""
        self._write(f"\r\033[K{text}\n" if self._is_terminal else f"{text}\n")
        self._last, self._written = "", -1e9

    def _write(self, text):
        self._stream.write(text)
        self._stream.flush()
