"""Images as sources deliver them, and ROS messages as images."""

import dataclasses

import cv2
import numpy as np


class SourceError(Exception):
    """A source delivers nothing, or what cannot be used; the text says what and what to do."""


@dataclasses.dataclass(frozen=True)
class Intrinsics:
    """A pinhole camera. matrix: 9 numbers, row after row [px]; distortion: coefficients of `model`."""

    width: int
    height: int
    matrix: tuple
    model: str = "plumb_bob"
    distortion: tuple = (0.0,) * 5


@dataclasses.dataclass(frozen=True)
class Frame:
    """stamp_s: of the color image, of any clock that only grows. color: BGR (H, W, 3) uint8. depth_mm: (H, W) uint16
    aligned to it, 0 where unknown, or None. intrinsics: or None."""

    stamp_s: float
    color: np.ndarray
    depth_mm: np.ndarray | None = None
    intrinsics: Intrinsics | None = None


COLOR_CODES = {"rgb8": cv2.COLOR_RGB2BGR, "bgr8": None, "rgba8": cv2.COLOR_RGBA2BGR, "bgra8": cv2.COLOR_BGRA2BGR,
               "mono8": cv2.COLOR_GRAY2BGR, "yuv422": cv2.COLOR_YUV2BGR_UYVY, "yuv422_yuy2": cv2.COLOR_YUV2BGR_YUY2}
CHANNELS = {"rgb8": 3, "bgr8": 3, "rgba8": 4, "bgra8": 4, "mono8": 1, "yuv422": 2, "yuv422_yuy2": 2}
MAX_MM = 65535


def _pixels(message, kind, channels):
    """The message's rows as an array (H, W) or (H, W, channels), without their padding."""
    kind = np.dtype(kind).newbyteorder(">" if message.is_bigendian else "<")
    row_bytes = message.width * channels * kind.itemsize
    if message.width < 1 or message.step < row_bytes or len(message.data) < message.step * message.height:
        raise SourceError(
            f"an image of {message.width} x {message.height} {message.encoding} holds {len(message.data)} bytes with "
            f"{message.step} per row: its publisher is defective")
    rows = np.frombuffer(message.data, np.uint8, message.step * message.height).reshape(message.height, message.step)
    pixels = np.ascontiguousarray(rows[:, :row_bytes]).view(kind)
    return pixels.reshape(message.height, message.width, channels) if channels > 1 else pixels


def color_of(message):
    """BGR pixels of a sensor_msgs/Image or CompressedImage. Raises SourceError."""
    if hasattr(message, "format"):
        image = cv2.imdecode(np.frombuffer(message.data, np.uint8), cv2.IMREAD_COLOR)
        if image is None:
            raise SourceError(
                f"a compressed image of {len(message.data)} bytes ({message.format}) cannot be decoded: use the raw "
                f"topic"
            )
        return image
    if message.encoding not in COLOR_CODES:
        raise SourceError(
            f"the color image has encoding {message.encoding}: use a topic with {', '.join(COLOR_CODES)}, "
            "e.g. that of image_proc")
    pixels, code = _pixels(message, np.uint8, CHANNELS[message.encoding]), COLOR_CODES[message.encoding]
    return pixels if code is None else cv2.cvtColor(pixels, code)


def depth_of(message):
    """Depth [mm] of a sensor_msgs/Image: 16UC1 and mono16 in mm, 32FC1 in m. Raises SourceError."""
    if message.encoding in ("16UC1", "mono16"):
        return np.uint16(_pixels(message, np.uint16, 1))
    if message.encoding != "32FC1":
        raise SourceError(f"the depth image has encoding {message.encoding}: use a topic with 16UC1 (mm) or 32FC1 (m)")
    depth = np.nan_to_num(_pixels(message, np.float32, 1) * 1000.0, nan=0.0, posinf=0.0, neginf=0.0)
    return np.uint16(np.where((depth > 0) & (depth <= MAX_MM), np.round(depth), 0))


def intrinsics_of(message):
    """Intrinsics of a sensor_msgs/CameraInfo; None for one that was never calibrated."""
    if message.K[0] <= 0 or message.K[4] <= 0:
        return None
    return Intrinsics(message.width, message.height, tuple(message.K), message.distortion_model or "plumb_bob",
                      tuple(message.D))


def pair(color, depth, info):
    """A Frame of messages; depth and info may be None. Raises SourceError."""
    image, depth_mm = color_of(color), None if depth is None else depth_of(depth)
    if depth_mm is not None and depth_mm.shape != image.shape[:2]:
        raise SourceError(
            f"the depth image is {depth_mm.shape[1]} x {depth_mm.shape[0]} and the color image {image.shape[1]} x "
            f"{image.shape[0]}: give the depth topic that is aligned to color (align_depth:=true with RealSense), or "
            "--no-depth")
    return Frame(color.header.stamp.to_sec(), image, depth_mm, info and intrinsics_of(info))
