"""tools/extperfc-calibrate finds the hidden pose of a simulated camera, from topics and from a bag, and a launch file
uses it."""

import json
import pathlib
import subprocess
import sys
import tempfile
import unittest

import numpy

REPO = pathlib.Path(__file__).resolve().parents[2]
sys.path[:0] = [str(REPO / "src"), str(REPO / "tools" / "lib"), str(REPO / "test" / "unit" / "calibrate")]

import test_tiers  # noqa: E402
import trial_calibrate  # noqa: E402

VIEWS = 10


class Calibrate(unittest.TestCase):
    def test_a_hidden_offset_is_found_within_2_mm_and_0_3_degrees(self):
        with tempfile.TemporaryDirectory() as folder:
            options = trial_calibrate.parse_arguments(
                ["--trials", "1", "--views",
                 str(VIEWS), "--speed", "2", "--seed", "7", "--out", folder])
            found = trial_calibrate.trial(0, options, trial_calibrate.session_of(options))
        self.assertGreater(found["hidden_mm"], 10)
        self.assertGreater(found["hidden_degrees"], 1.5)
        self.assertLess(found["error_mm"], 2)
        self.assertLess(found["error_degrees"], 0.3)


class Bag(unittest.TestCase):
    """A bag of rendered images."""

    @classmethod
    def setUpClass(cls):
        temporary = tempfile.TemporaryDirectory()
        cls.addClassCleanup(temporary.cleanup)
        cls.root = pathlib.Path(temporary.name)
        cls.bag = cls.root / "views.bag"
        write_bag(cls.bag)

    def calibrate(self, folder, *arguments):
        command = [REPO / "tools" / "extperfc-calibrate", "collect", self.root / folder, "--bag", self.bag, "--board",
                   "chessboard:7x4:0.03", "--camera-on", "head", "--views", "8", *arguments]
        return subprocess.run(list(map(str, command)), capture_output=True, text=True, timeout=120)

    def test_the_camera_of_a_bag_is_found(self):
        from extperfc.calibrate import result
        from test_calibrate_folder import PARENT_T_CAMERA
        done = self.calibrate("by_tf", "--board-on", "left_gripper")
        self.assertEqual(0, done.returncode, done.stdout + done.stderr)
        parent, child, pose = result.read_pose(self.root / "by_tf" / "camera_pose.yaml")
        self.assertEqual(("head", "camera_optical"), (parent, child))
        self.assertLess(numpy.linalg.norm(result.pose_difference(PARENT_T_CAMERA, pose)[:3]), 0.002)

    def test_what_a_bag_lacks_is_named(self):
        done = self.calibrate("no_frame", "--board-on", "right_gripper")
        self.assertEqual(1, done.returncode)
        self.assertIn("do not give right_gripper in head", done.stderr)
        done = self.calibrate("no_topic", "--board-on", "left_gripper", "--color", "/other/image")
        self.assertEqual(1, done.returncode)
        self.assertIn("has no topic /other/image, but /camera/color/camera_info", done.stderr)


def write_bag(file):
    """Images, each with tf of a robot that stands still around it."""
    import geometry_msgs.msg
    import rendered
    import rosbag
    import rospy
    import sensor_msgs.msg
    import tf2_msgs.msg
    from extperfc.calibrate import views
    from test_calibrate_folder import BOARD, carrier_pose, poses

    def header(stamp_s):
        message = sensor_msgs.msg.Image().header
        message.frame_id, message.stamp = "camera_optical", rospy.Time.from_sec(stamp_s)
        return message

    with rosbag.Bag(str(file), "w") as bag:
        camera = rendered.CAMERA
        for i, pose in enumerate(poses()):
            stamp_s = 100.0 + 2 * i
            for at_s in (stamp_s - 1.0, stamp_s + 0.5):
                numbers = views.numbers_of_pose(carrier_pose(pose))
                transform = geometry_msgs.msg.TransformStamped(header=header(at_s), child_frame_id="left_gripper")
                transform.header.frame_id = "head"
                t, q = transform.transform.translation, transform.transform.rotation
                t.x, t.y, t.z, q.x, q.y, q.z, q.w = numbers
                bag.write("/tf", tf2_msgs.msg.TFMessage([transform]), rospy.Time.from_sec(at_s))
            image = rendered.render(BOARD, pose, seed=i)
            message = sensor_msgs.msg.Image(header(stamp_s), camera.height, camera.width, "mono8", 0, camera.width,
                                            image.tobytes())
            info = sensor_msgs.msg.CameraInfo(header=message.header, height=camera.height, width=camera.width,
                                              distortion_model="plumb_bob", K=list(camera.matrix.ravel()), D=[0.0] * 5)
            bag.write("/camera/color/camera_info", info, message.header.stamp)
            bag.write("/camera/color/image_raw", message, message.header.stamp)


class Launch(unittest.TestCase):
    def test_the_launch_argument_publishes_the_pose(self):
        from ros_session import RosSession
        with tempfile.TemporaryDirectory() as folder:
            file = pathlib.Path(folder) / "camera_pose.yaml"
            file.write_text("header: {frame_id: head}\nchild_frame_id: camera_link\ntransform:\n"
                            "  translation: {x: 0.1, y: 0.2, z: 0.3}\n  rotation: {x: 0.0, y: 0.0, z: 0.0, w: 1.0}\n")
            # rospy belongs to the master of the first test of this process, so this one asks by a command.
            with RosSession(pathlib.Path(folder) / "log") as session:
                session.launch("extperfc", "camera_frames.launch", camera_pose=file)
                session.wait_for_master()
                seen = subprocess.run(["rostopic", "echo", "-n", "2", "/tf_static"],
                                      capture_output=True,
                                      text=True,
                                      timeout=60).stdout
        for text in ('frame_id: "head"', "z: 0.3", "camera_color_optical_frame"):
            self.assertIn(text, seen)


@test_tiers.long_scenario("the same parts as trial_grasp; unit/depth_scores has the figures")
class TrialDepth(unittest.TestCase):
    def test_held_objects_are_measured_within_2_cm(self):
        with tempfile.TemporaryDirectory() as folder:
            command = [
                REPO / "tools" / "trial_depth", "--shapes", "cube", "--ranges", "0.3", "0.6", "--near", "0.12",
                "--images", "2", "--boxes", "truth", "--out", folder
            ]
            done = subprocess.run(list(map(str, command)), capture_output=True, text=True, timeout=300)
            self.assertEqual(0, done.returncode, done.stdout + done.stderr)
            summary = json.loads((pathlib.Path(folder) / "depth_kinematics.json").read_text())
        self.assertRegex(done.stdout, "cube +true boxes: 2 images, 2 boxes, no estimate")
        for row in summary["summary"]:
            self.assertEqual(4, row["n"], row)
            self.assertLess(row["max_m"], 0.02, row)


if __name__ == "__main__":
    unittest.main()
