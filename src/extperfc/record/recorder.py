"""Takes frames of a source into a folder, on key press or at intervals."""

import dataclasses
import time

from extperfc.record.frames import SourceError

POLL_S = 0.05  # longest wait for a frame before keys are looked at
INFO_WAIT_S = 1.0
HELP = "Space: take an image   k: take it even if alike   q: end"


class Recorder:
    """Counts and decisions. `every_s`: seconds of the source's clock between two images, or None for key press only."""

    def __init__(self, source, folder, near_duplicates, every_s=None, max_count=None, timeout_s=5.0):
        self.saved = self.alike = self.frames = 0
        self._source, self._folder, self._near = source, folder, near_duplicates
        self._every_s, self._max_count, self._timeout_s = every_s, max_count, timeout_s
        self._taken_s, self._wanted, self._forced = None, False, False
        self._begin = self._last_frame = time.monotonic()

    def run(self, keys, status):
        """Records until q, the end of the source, or max_count images. Raises SourceError, FolderError and
        WriteError."""
        try:
            while self._max_count is None or self.saved < self._max_count:
                if not self._obey(keys.pressed(), status):
                    break
                self._step(self._source.next_frame(POLL_S), status)
                status.show(self.status())
        except EOFError:
            if self.frames == 0:
                raise SourceError(self._source.why_silent()) from None
        status.say(self.status())

    def status(self):
        """The counts as one line."""
        rate = self.frames / max(time.monotonic() - self._begin, 1e-3)
        text = f"{self.saved} saved, {self.alike} near duplicates skipped, {self.frames} frames"
        return f"{text}, {rate:.1f} per second" if self._source.is_live else text

    def _obey(self, typed, status):
        """Keys. Returns False for the one that ends."""
        for key in typed:
            if key in "qQ\x04":
                return False
            if key in " \rkK":
                self._wanted, self._forced = True, key in "kK"
            elif key != "\n":
                status.say(HELP)
        return True

    def _step(self, frame, status):
        if frame is None:
            self._check_silence(status)
            return
        self.frames, self._last_frame = self.frames + 1, time.monotonic()
        if self.frames == 1:
            frame = self._first(frame, status)
        if self._wanted or self._is_due(frame):
            self._take(frame, status)

    def _first(self, frame, status):
        """The first image waits for its camera info, so that it is not without one."""
        intrinsics = frame.intrinsics or self._source.await_intrinsics(INFO_WAIT_S)
        if intrinsics is None:
            status.say(
                f"no intrinsics from {self._source.info_topic}: camera.yaml is not written; boxes can be labelled "
                f"without it"
            )
        return dataclasses.replace(frame, intrinsics=intrinsics)

    def _is_due(self, frame):
        return self._every_s is not None and (self._taken_s is None
                                              or not 0 <= frame.stamp_s - self._taken_s < self._every_s)

    def _take(self, frame, status):
        was_asked, is_forced = self._wanted, self._forced
        self._wanted = self._forced = False
        if not is_forced and self._near.has_like(frame.color):
            self.alike += 1
            if was_asked:
                status.say(
                    f"skipped: it differs by {self._near.smallest_change(frame.color):.1f} grey levels from a kept "
                    f"image, less than "
                    f"{self._near.min_change:g}; k takes it anyway")
            return
        file = self._folder.write(frame)
        self._near.add(frame.color)
        self.saved, self._taken_s = self.saved + 1, frame.stamp_s
        if was_asked:
            status.say(f"{file.name}")

    def _check_silence(self, status):
        silent_s = time.monotonic() - self._last_frame
        if silent_s < self._timeout_s:
            return
        if self.frames == 0:
            raise SourceError(self._source.why_silent())
        status.say(f"no image for {silent_s:.0f} s: {self._source.why_silent()}")
        self._last_frame = time.monotonic()
