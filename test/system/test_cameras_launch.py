"""cameras.launch with two simulated cameras."""

import pathlib
import sys
import unittest

REPO = pathlib.Path(__file__).resolve().parents[2]
sys.path[:0] = [str(REPO / "tools" / "lib"), str(REPO / "test" / "system")]

import rosgraph  # noqa: E402
import rospy  # noqa: E402
from simulated_camera import (BLUE, CLASS_BLUE, CLASS_RED, FOCAL_PX, PATIENCE_S, RED, SQUARE, Camera,  # noqa: E402
                              Latest, launch)
from vision_msgs.msg import Detection3DArray  # noqa: E402


class TwoCameras(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.session = launch(cls, "test_cameras_launch", "cameras.launch", cameras="front,hand", threads="2",
                             track="true")
        cls.cameras = {"front": Camera("/front/", RED, 1.5), "hand": Camera("/hand/", BLUE, 0.8)}

    def test_each_camera_has_its_objects_in_its_namespace(self):
        expected = {"front": (CLASS_RED, 1.5), "hand": (CLASS_BLUE, 0.8)}
        latest = {name: Latest(f"/{name}/detections_3d", Detection3DArray) for name in expected}
        for name, (class_index, distance_m) in expected.items():
            with self.subTest(name):
                message = latest[name].wait(self.session)
                self.assertEqual(self.cameras[name].frame, message.header.frame_id)
                self.assertEqual([class_index], [found.results[0].id for found in message.detections])
                depth_m = message.detections[0].bbox.center.position.z
                self.assertAlmostEqual(distance_m * (1 + 0.5 * SQUARE[3] / FOCAL_PX), depth_m, delta=0.03)
                self.assertEqual(1, rospy.get_param(f"/{name}/detector/threads"))
                self.detect_once(name, class_index)
        publishers = dict(rosgraph.Master("/test_cameras_launch").getSystemState()[0])
        for name in expected:
            self.assertEqual(["/perception_manager"], publishers[f"/{name}/detections_3d"], "one manager for all")
            self.assertEqual(["/perception_manager"], publishers[f"/{name}/objects/tracks"])

    def detect_once(self, name, class_index):
        from extperfc.srv import DetectOnce
        answer = rospy.ServiceProxy(f"/{name}/detect_once", DetectOnce)(timeout=rospy.Duration(20.0))
        self.assertTrue(answer.success and answer.has_3d, answer.message)
        self.assertEqual([class_index], [found.results[0].id for found in answer.detections_3d.detections])

    def test_dynparam_changes_a_detector(self):
        from dynamic_reconfigure.client import Client
        client = Client("/front/detector", timeout=PATIENCE_S)
        self.addCleanup(client.close)
        self.assertTrue(client.get_configuration()["enabled"])
        changed = client.update_configuration({"enabled": False, "score_threshold": 0.75})
        self.assertEqual((False, 0.75), (changed["enabled"], changed["score_threshold"]))
        self.addCleanup(client.update_configuration, {"enabled": True, "score_threshold": -1.0})
        refused = client.update_configuration({"class_filter": "unicorn"})
        self.assertEqual("", refused["class_filter"])


if __name__ == "__main__":
    unittest.main()
