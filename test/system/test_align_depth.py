"""Depth of a camera beside the color camera, which detection.launch aligns."""

import pathlib
import sys
import unittest

REPO = pathlib.Path(__file__).resolve().parents[2]
sys.path[:0] = [str(REPO / "tools" / "lib"), str(REPO / "test" / "system")]

import numpy as np  # noqa: E402
import rospy  # noqa: E402
import tf2_ros  # noqa: E402
from geometry_msgs.msg import TransformStamped  # noqa: E402
from sensor_msgs.msg import Image  # noqa: E402
from simulated_camera import FOCAL_PX, HEIGHT, RED, SQUARE, WIDTH, Camera, Latest, launch  # noqa: E402
from vision_msgs.msg import Detection3DArray  # noqa: E402


class UnalignedDepth(unittest.TestCase):
    BASELINE_M = 0.05  # the depth camera is so far to the left of the color camera
    OBJECT_M = 1.0

    def test_depth_of_a_camera_beside_is_aligned(self):
        session = launch(type(self), "test_align_depth", "detection.launch", align_depth="true")
        mount = TransformStamped(child_frame_id="depth_optical")
        mount.header.frame_id, mount.header.stamp = "camera_optical", rospy.Time.now()
        mount.transform.translation.x, mount.transform.rotation.w = -self.BASELINE_M, 1.0
        broadcaster = tf2_ros.StaticTransformBroadcaster()
        broadcaster.sendTransform(mount)
        shift_px = round(FOCAL_PX * self.BASELINE_M / self.OBJECT_M)
        camera = Camera("/", RED, self.OBJECT_M, left_in_depth=SQUARE[0] + shift_px, depth_frame="depth_optical",
                        depth_topic="camera/depth/image_rect_raw", depth_info_topic="camera/depth/camera_info")
        objects = Latest("/detections_3d", Detection3DArray)
        aligned = Latest("/camera/aligned_depth_to_color/image_raw", Image)
        message = objects.wait(session)
        self.assertEqual(camera.frame, message.header.frame_id)
        center = message.detections[0].bbox.center.position
        x_px = SQUARE[0] + SQUARE[2] / 2 - 0.5 - (WIDTH - 1) / 2
        self.assertAlmostEqual(x_px / FOCAL_PX * center.z, center.x, delta=0.01)
        self.assertAlmostEqual(self.OBJECT_M * (1 + 0.5 * SQUARE[3] / FOCAL_PX), center.z, delta=0.03)

        picked = aligned.wait(session)
        self.assertEqual(camera.frame, picked.header.frame_id)
        depth = np.frombuffer(picked.data, np.uint16).reshape(HEIGHT, WIDTH)
        inside = depth[SQUARE[1] + 2:SQUARE[1] + SQUARE[3] - 2, SQUARE[0] + 2:SQUARE[0] + SQUARE[2] - 2]
        self.assertTrue((np.abs(inside.astype(int) - round(1000 * self.OBJECT_M)) <= 1).all(),
                        "the object where its color is")
        beside = depth[SQUARE[1] + 2:SQUARE[1] + SQUARE[3] - 2, SQUARE[0] - 30:SQUARE[0] - 2]
        self.assertFalse((np.abs(beside.astype(int) - round(1000 * self.OBJECT_M)) <= 1).any(), "and nowhere else")


if __name__ == "__main__":
    unittest.main()
