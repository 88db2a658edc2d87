"""detection.launch beside a camera with its own topic names."""

import os
import pathlib
import sys
import tempfile
import time
import unittest

REPO = pathlib.Path(__file__).resolve().parents[2]
sys.path[:0] = [str(REPO / "tools" / "lib")]

import rosgraph  # noqa: E402
import rospy  # noqa: E402
from ros_session import RosSession  # noqa: E402
from vision_msgs.msg import Detection3DArray  # noqa: E402

TOPICS = {"color_topic": "/kinect/rgb/image", "depth_topic": "/kinect/depth_registered/image",
          "camera_info_topic": "/kinect/rgb/info"}
START_S = 60.0


class DetectionLaunch(unittest.TestCase):
    def test_the_nodelets_listen_to_the_topics_of_the_arguments(self):
        with tempfile.TemporaryDirectory() as folder, RosSession(os.path.join(folder, "log")) as session:
            session.launch("extperfc", "detection.launch", **TOPICS)
            session.join("test_detection_launch", simulated=False)
            self.addCleanup(rospy.signal_shutdown, "the test is over")
            rospy.Subscriber("detections_3d", Detection3DArray, lambda message: None)
            master = rosgraph.Master("/test_detection_launch")
            deadline = time.monotonic() + START_S
            missing = set(TOPICS.values())
            while missing:
                self.assertTrue(session.alive(), session.errors())
                self.assertLess(time.monotonic(), deadline, f"nobody subscribes to {sorted(missing)}: {session.errors()}")
                missing = set(TOPICS.values()) - {name for name, _ in master.getSystemState()[1]}
                time.sleep(0.1)


if __name__ == "__main__":
    unittest.main()
