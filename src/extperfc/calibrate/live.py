"""Views from the topics of a running robot."""

import threading
import time

import rospy
import sensor_msgs.msg
import tf2_ros

from extperfc.calibrate import collector as collecting
from extperfc.calibrate import messages, robot_poses, views

POSE_WAIT_S = 2.0       # of real time for tf or joint states of an image's time
REPEAT_TEXT_S = 3.0     # of real time until the same advice is given again
START_WAIT_S = 15.0


class LiveSource:
    """The latest image, the camera's calibration, and the robot's poses."""

    def __init__(self, topics, frames, urdf=None):
        self._topics, self._frames = topics, frames
        self._condition, self._image, self._info = threading.Condition(), None, None
        self._buffer = tf2_ros.Buffer()
        self._listener = tf2_ros.TransformListener(self._buffer)
        self._tf = robot_poses.TfPoses(self._buffer, frames.parent, frames.carrier)
        self._poses = self._tf
        if urdf:
            self._poses = robot_poses.JointPoses(urdf, frames.parent, frames.carrier)
            rospy.Subscriber(topics["joint_states"], sensor_msgs.msg.JointState, self._poses.add, queue_size=100)
        self._publisher = rospy.Publisher("calibrate/image", sensor_msgs.msg.Image, queue_size=1)
        rospy.Subscriber(topics["camera_info"], sensor_msgs.msg.CameraInfo, self._on_info, queue_size=1)
        rospy.Subscriber(topics["color"], sensor_msgs.msg.Image, self._on_image, queue_size=1, buff_size=2**24)

    def _on_image(self, message):
        with self._condition:
            self._image = message
            self._condition.notify_all()

    def _on_info(self, message):
        with self._condition:
            self._info = message
            self._condition.notify_all()

    def _wait_for(self, condition, wait_s):
        """Whether the condition came true within wait_s seconds of real time; holds the lock."""
        deadline = time.monotonic() + wait_s
        while not condition():
            left = deadline - time.monotonic()
            if left <= 0 or rospy.is_shutdown():
                return False
            self._condition.wait(min(left, 0.2))
        return True

    def start(self):
        """(views.Camera, views.Frames) once image and calibration have come. Raises views.ViewsError."""
        with self._condition:
            for what, topic in (("camera_info", lambda: self._info), ("color", lambda: self._image)):
                if not self._wait_for(lambda: topic() is not None, START_WAIT_S):
                    raise views.ViewsError(
                        f"no message on {rospy.resolve_name(self._topics[what])} within {START_WAIT_S:.0f} s: "
                        "is the camera's driver running?")
            info = self._info
        if self.pose_when_there(info.header.stamp.to_sec(), START_WAIT_S, latest=True) is None:
            raise views.ViewsError(
                f"no transform from {self._frames.carrier} to {self._frames.parent}: check --board-on and "
                "--camera-on, and that the robot's state is published")
        return messages.camera_of_message(info), self._with_mount(self._frames.camera or info.header.frame_id)

    def _with_mount(self, camera):
        frames = self._frames
        camera_T_mount = self._tf.lookup(camera, frames.mount, rospy.Time(0)) if frames.mount else None
        return views.Frames(frames.parent, frames.carrier, camera, frames.mount, camera_T_mount)

    def pose_when_there(self, stamp_s, wait_s=POSE_WAIT_S, latest=False):
        """parent_T_carrier at a time as soon as it is known, or at any time with `latest`; None after wait_s
        seconds."""
        deadline = time.monotonic() + wait_s
        while not rospy.is_shutdown():
            pose = self._poses.at(stamp_s)
            if pose is None and latest and self._poses is self._tf:
                pose = self._tf.at(0.0)
            if pose is not None or time.monotonic() > deadline:
                return pose
            with self._condition:
                self._condition.wait(0.02)
        return None

    def next_image(self, after):
        """The first image message that is newer than `after`; None when ROS ends."""
        with self._condition:
            while not rospy.is_shutdown():
                if self._wait_for(lambda: self._image is not after, 1.0):
                    return self._image
        return None

    def show(self, image, header):
        """Publishes a BGR image on calibrate/image, while it has subscribers."""
        if self._publisher.get_num_connections():
            height, width = image.shape[:2]
            encoding = "mono8" if image.ndim == 2 else "bgr8"
            step = width * (1 if image.ndim == 2 else 3)
            self._publisher.publish(sensor_msgs.msg.Image(header, height, width, encoding, 0, step, image.tobytes()))


class Advice:
    """Says a line when it is new, and again after a while."""

    def __init__(self, report):
        self._report, self._text, self._said_s = report, "", 0.0

    def give(self, text):
        if text != self._text or time.monotonic() - self._said_s > REPEAT_TEXT_S:
            self._report(text)
            self._text, self._said_s = text, time.monotonic()


def collect(source, folder, board, wanted_views, report):
    """Takes views until there are enough, or Ctrl-C; the Collector. Raises views.ViewsError."""
    camera, frames = source.start()
    collector = collecting.Collector(folder, camera, board, frames, wanted_views)
    advice, message = Advice(report), None
    report(f"watching {frames.camera}; move {frames.carrier}, and hold still for a moment in every pose")
    while not collector.is_complete():
        message = source.next_image(message)
        if message is None:
            break
        stamp_s = message.header.stamp.to_sec()
        now, before = source.pose_when_there(stamp_s), source.pose_when_there(stamp_s - collecting.STILL_S, 0.0)
        if now is None or before is None:
            advice.give(
                f"no transform from {frames.carrier} to {frames.parent} at the time of the images: are the clocks of "
                "robot and camera the same?")
            continue
        answer = collector.offer(messages.image_of_message(message), now, collecting.stands_still(now, before))
        source.show(answer.image, message.header)
        (report if answer.taken else advice.give)(answer.text)
    return collector
