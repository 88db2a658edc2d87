"""localization.launch with nothing but a map's file: a recording played by rosbag, and files that are no maps."""

import contextlib
import math
import pathlib
import tempfile
import time
import unittest

from bag_player import BagSession, end
from drawn_room import DRIVE, between, compose, map_the_drive
from ros_session import RosSession

RATE = 10                            # simulated seconds per second
SECONDS = 60                         # of the recording
WRONG_BY = (0.3, -0.2, 0.15)         # of the initial pose [m, m, rad]
SETTLED_S = 3.0                      # of the recording, after which the pose must be right
# Against the mapper's own path in this map. The goals of localization: 0.05 m and 1.1 degrees in the mean.
MAX_MEAN_ERROR_M, MAX_MEAN_ERROR_DEG, MAX_ERROR_M, MAX_ERROR_DEG = 0.05, 1.1, 0.2, 5.0


class LocalizationBag(unittest.TestCase):
    def setUp(self):
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.folder = pathlib.Path(temporary.name)

    def test_a_map_file_is_enough(self):
        import rospy
        from geometry_msgs.msg import PoseWithCovarianceStamped
        bag, path = map_the_drive(self.folder)
        start = compose(path[DRIVE.stamps[0]], WRONG_BY)
        poses = []
        with BagSession(self.folder / "launch.log") as session:
            session.launch_in_bag_time(
                "localization.launch", self.folder, map_file=self.folder / "map.yaml", base_frame="base_link", rviz="false",
                initial_pose_x=start[0], initial_pose_y=start[1], initial_pose_a=start[2])
            rospy.init_node("localization_bag_test", disable_signals=True)
            rospy.Subscriber("/amcl_pose", PoseWithCovarianceStamped, poses.append, queue_size=100)
            player = session.play(bag, RATE, "--duration", str(SECONDS))
            try:
                session.wait(lambda: player.poll() is not None, "the end of the bag", 40)
            finally:
                end(player)
            self.assertNotIn("/map", [name for name, _ in rospy.get_published_topics()], "no map server runs")
            rospy.signal_shutdown("done")
            self.assertEqual([], session.errors())
        self.check(poses, path)

    def check(self, poses, path):
        errors = []
        for message in poses:
            stamp, pose = message.header.stamp.to_sec(), message.pose.pose
            found = pose.position.x, pose.position.y, 2 * math.atan2(pose.orientation.z, pose.orientation.w)
            x, y, yaw = between(path[round(stamp, 3)], found)
            if stamp > DRIVE.stamps[0] + SETTLED_S:
                errors.append((math.hypot(x, y), abs(math.degrees(yaw))))
        metres, degrees = zip(*errors)
        mean_m, mean_deg = sum(metres) / len(metres), sum(degrees) / len(degrees)
        print(f"{len(errors)} updates: mean {mean_m:.3f} m {mean_deg:.2f} deg, max {max(metres):.3f} m "
              f"{max(degrees):.2f} deg", flush=True)
        self.assertGreater(len(errors), 50, "an update every 0.2 m of 25 m at the latest")
        self.assertLess(mean_m, MAX_MEAN_ERROR_M)
        self.assertLess(mean_deg, MAX_MEAN_ERROR_DEG)
        self.assertLess(max(metres), MAX_ERROR_M)
        self.assertLess(max(degrees), MAX_ERROR_DEG)

    def test_what_is_no_map_is_refused_in_one_error(self):
        good = "resolution: 0.05\norigin: [0, 0, 0]\nnegate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196\n"
        (self.folder / "broken.yaml").write_text("image: room.pgm\norigin: [0, 0\nresolution 0.05\n")
        (self.folder / "no_image.yaml").write_text("image: gone.pgm\n" + good)
        (self.folder / "half.yaml").write_text("image: half.pgm\n" + good)
        (self.folder / "half.pgm").write_bytes(b"P5\n100 100\n255\n" + bytes(5000))
        wrong = {"absent.yaml": "absent.yaml: cannot be read", "broken.yaml": r"broken.yaml:\d+: not YAML",
                 "no_image.yaml": "gone.pgm", "half.yaml": "half.pgm"}
        with contextlib.ExitStack() as stack:
            sessions = {}
            for name in wrong:
                sessions[name] = stack.enter_context(RosSession(self.folder / f"{name}.log"))
                sessions[name].launch("extperfc", "localization.launch", map_file=self.folder / name, rviz="false")
            deadline = time.monotonic() + 60
            while any(session.alive() for session in sessions.values()) and time.monotonic() < deadline:
                time.sleep(0.05)
            for name, session in sessions.items():
                with self.subTest(name=name):
                    errors = session.errors()
                    self.assertFalse(session.alive(), "the launch must end")
                    self.assertEqual(1, len(errors), errors)
                    self.assertRegex(errors[0], wrong[name])
                    print(errors[0], flush=True)


if __name__ == "__main__":
    unittest.main()
