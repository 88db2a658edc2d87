"""Views from a bag of images, camera info, and tf or joint states."""

from extperfc.calibrate import collector as collecting
from extperfc.calibrate import messages, robot_poses, views

TF_TOPICS = ("/tf", "/tf_static")


class Recording:
    """A bag, opened. `topics`: color, camera_info and, with a robot's description, joint_states."""

    def __init__(self, file, topics, frames, urdf=None):
        import rosbag
        try:
            self._bag = rosbag.Bag(str(file))
        except (OSError, rosbag.ROSBagException) as error:
            raise views.ViewsError(f"{file} cannot be read as a bag: {error}") from None
        self._file, self._topics = file, topics
        self._require(topics["color"], topics["camera_info"])
        self.camera, stamped = self._camera_info()
        self._buffer = self._transforms()
        self.frames = self._with_mount(frames, stamped)
        self._poses = self._joint_poses(urdf) if urdf else robot_poses.TfPoses(self._buffer, frames.parent,
                                                                               frames.carrier)

    def close(self):
        self._bag.close()

    def _require(self, *topics):
        known = self._bag.get_type_and_topic_info().topics
        for topic in topics:
            if topic not in known:
                raise views.ViewsError(
                    f"{self._file} has no topic {topic}, but {', '.join(sorted(known))}: name it by an option")

    def _camera_info(self):
        for _, message, _ in self._bag.read_messages(self._topics["camera_info"]):
            return messages.camera_of_message(message), message
        raise views.ViewsError(f"{self._file} has no message on {self._topics['camera_info']}")

    def _transforms(self):
        """A tf2 BufferCore with all transforms of the bag."""
        import rospy
        import tf2_ros
        length_s = self._bag.get_end_time() - self._bag.get_start_time()
        buffer = tf2_ros.BufferCore(rospy.Duration(length_s + 10))
        for topic, message, _ in self._bag.read_messages(TF_TOPICS):
            for transform in message.transforms:
                if topic == "/tf_static":
                    buffer.set_transform_static(transform, "bag")
                else:
                    buffer.set_transform(transform, "bag")
        return buffer

    def _with_mount(self, frames, camera_info):
        """The frames with the camera's own names, as far as tf knows them."""
        import rospy
        camera = frames.camera or camera_info.header.frame_id
        lookup = robot_poses.TfPoses(self._buffer, "", "").lookup
        return views.Frames(frames.parent, frames.carrier, camera, frames.mount,
                            lookup(camera, frames.mount, rospy.Time(0)) if frames.mount else None)

    def _joint_poses(self, urdf):
        self._require(self._topics["joint_states"])
        poses = robot_poses.JointPoses(urdf, self.frames.parent, self.frames.carrier, keep=10**9)
        for _, message, _ in self._bag.read_messages(self._topics["joint_states"]):
            poses.add(message)
        return poses

    def collect(self, folder, board, wanted_views, report):
        """Takes every view that adds something; `report` gets a line for each. Raises views.ViewsError when nothing
        can be used."""
        collector = collecting.Collector(folder, self.camera, board, self.frames, wanted_views)
        without_pose, last_text = 0, ""
        for _, message, _ in self._bag.read_messages(self._topics["color"]):
            stamp = message.header.stamp.to_sec()
            now, before = self._poses.at(stamp), self._poses.at(stamp - collecting.STILL_S)
            if now is None or before is None:
                without_pose += 1
                continue
            if not collecting.stands_still(now, before) or not collecting.motions.is_new(now, collector.poses):
                continue
            answer = collector.offer(messages.image_of_message(message), now)
            last_text = answer.text
            if answer.taken:
                report(answer.text)
        if not collector.poses:
            why = (
                f"tf or joint states do not give {self.frames.carrier} in {self.frames.parent} at the time of "
                f"{without_pose} images"
                if without_pose else last_text or "the robot never stood still")
            raise views.ViewsError(f"no view of {self._file} can be used: {why}")
        return collector
