"""Frames of a camera device or a video file, by OpenCV; color only."""

import pathlib
import time

import cv2

from extperfc.record.frames import Frame, SourceError


def _devices():
    return [str(path) for path in sorted(pathlib.Path("/dev").glob("video*"))]


class CameraSource:
    """A device by its number or path, or a video file."""

    def __init__(self, device, intrinsics=None):
        """intrinsics: frames.Intrinsics of the images, or None. Raises SourceError."""
        is_number = str(device).isdigit()
        self.is_live = is_number or str(device).startswith("/dev/") or "://" in str(device)
        self._device, self._intrinsics, self._count = device, intrinsics, 0
        self._capture = cv2.VideoCapture(int(device) if is_number else str(device))
        if not self._capture.isOpened():
            seen = ", ".join(_devices()) or "no /dev/video*: is the camera plugged in?"
            raise SourceError(
                f"cannot open the camera {device} (there is {seen}): give another --camera, end the program that "
                f"uses it, "
                "or join the group video")
        self._rate_hz = self._capture.get(cv2.CAP_PROP_FPS) or 30.0

    def next_frame(self, _timeout_s):
        """The next image. Raises EOFError at the end of a file, and SourceError when a device fails."""
        done, image = self._capture.read()
        if not done and not self.is_live:
            raise EOFError
        if not done:
            raise SourceError(
                f"the camera {self._device} delivers no images any more: is it unplugged, or used by another program?")
        self._count += 1
        stamp_s = time.monotonic() if self.is_live else self._count / self._rate_hz
        return Frame(stamp_s, image, None, self._intrinsics)

    def await_intrinsics(self, _timeout_s):
        return self._intrinsics

    @property
    def info_topic(self):
        return "--camera-info"

    def why_silent(self):
        return f"the camera {self._device} delivered no image: is it used by another program?"

    def close(self):
        self._capture.release()
