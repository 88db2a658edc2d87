"""RGB-D cameras for tests: a bright square before a dark wall, for the model `square`, beside a launch file."""

import os
import pathlib
import tempfile
import threading
import time

import numpy as np
import rospy
from ros_session import RosSession
from sensor_msgs.msg import CameraInfo, Image

REPO = pathlib.Path(__file__).resolve().parents[2]
SQUARE_MODEL = REPO / "test/data/models/square"  # finds the one bright square in a dark image
WIDTH, HEIGHT, FOCAL_PX = 320, 240, 300.0
SQUARE = (80, 60, 80, 60)                        # left, top, width, height [px]
RED, BLUE = (230, 20, 20), (20, 20, 230)
CLASS_RED, CLASS_BLUE = 0, 2
WALL_M = 3.0
PATIENCE_S = 60.0


def image(pixels, encoding, stamp, frame):
    message = Image(height=HEIGHT, width=WIDTH, encoding=encoding, step=pixels[0].nbytes, data=pixels.tobytes())
    message.header.stamp, message.header.frame_id = stamp, frame
    return message


def color_image(color, left, stamp, frame):
    pixels = np.full((HEIGHT, WIDTH, 3), 10, np.uint8)
    pixels[SQUARE[1]:SQUARE[1] + SQUARE[3], left:left + SQUARE[2]] = color
    return image(pixels, "rgb8", stamp, frame)


def depth_image(object_m, left, stamp, frame):
    pixels = np.full((HEIGHT, WIDTH), round(1000 * WALL_M), np.uint16)
    pixels[SQUARE[1]:SQUARE[1] + SQUARE[3], left:left + SQUARE[2]] = round(1000 * object_m)
    return image(pixels, "16UC1", stamp, frame)


def camera_info(stamp, frame):
    cx, cy = (WIDTH - 1) / 2, (HEIGHT - 1) / 2
    info = CameraInfo(width=WIDTH, height=HEIGHT, distortion_model="plumb_bob", D=[0.0] * 5,
                      K=[FOCAL_PX, 0, cx, 0, FOCAL_PX, cy, 0, 0, 1], R=[1, 0, 0, 0, 1, 0, 0, 0, 1],
                      P=[FOCAL_PX, 0, cx, 0, 0, FOCAL_PX, cy, 0, 0, 0, 1, 0])
    info.header.stamp, info.header.frame_id = stamp, frame
    return info


class Camera:
    """Publishes a square before a wall, ten times a second. `left_in_depth` and `depth_frame`: of a depth camera beside
    the color camera."""

    def __init__(self, namespace, color, object_m, left_in_depth=SQUARE[0], depth_frame=None,
                 depth_topic="camera/aligned_depth_to_color/image_raw", depth_info_topic=None):
        self.frame = f"{namespace.strip('/') or 'camera'}_optical"
        self.depth_frame = depth_frame or self.frame
        self.draw = (lambda stamp: color_image(color, SQUARE[0], stamp, self.frame),
                     lambda stamp: depth_image(object_m, left_in_depth, stamp, self.depth_frame))
        self.publishers = [rospy.Publisher(namespace + name, kind, queue_size=2) for name, kind in (
            ("camera/color/image_raw", Image), (depth_topic, Image), ("camera/color/camera_info", CameraInfo))]
        self.depth_info = (rospy.Publisher(namespace + depth_info_topic, CameraInfo, queue_size=2) if depth_info_topic
                           else None)
        self.timer = rospy.Timer(rospy.Duration(0.1), self.publish)

    def publish(self, _event):
        stamp = rospy.Time.now()
        if self.depth_info:
            self.depth_info.publish(camera_info(stamp, self.depth_frame))
        messages = [*(draw(stamp) for draw in self.draw), camera_info(stamp, self.frame)]
        for publisher, message in zip(self.publishers, messages):
            publisher.publish(message)


class Latest:
    """The latest message of a topic with at least one detection, or any image."""

    def __init__(self, topic, kind):
        self.message, self.ready = None, threading.Event()
        self.subscriber = rospy.Subscriber(topic, kind, self.take)

    def take(self, message):
        if getattr(message, "detections", True):
            self.message = message
            self.ready.set()

    def wait(self, session):
        """The message; an AssertionError with the errors of the session when none comes."""
        end = time.monotonic() + PATIENCE_S
        while not self.ready.wait(0.5):
            assert session.alive(), session.errors()
            assert time.monotonic() < end, f"nothing on {self.subscriber.name}: {session.errors()}"
        return self.message


def launch(case, node, launch_file, **arguments):
    """The RosSession of a launch file with the model `square`, in which the caller is the ROS node `node`. It ends with
    the tests of the class `case`."""
    folder = tempfile.TemporaryDirectory()
    case.addClassCleanup(folder.cleanup)
    session = RosSession(os.path.join(folder.name, "log"))
    case.addClassCleanup(session.close)
    session.launch("extperfc", launch_file, model=str(SQUARE_MODEL), backend="opencv", **arguments)
    session.join(node, simulated=False)
    case.addClassCleanup(rospy.signal_shutdown, "the test is over")
    return session
