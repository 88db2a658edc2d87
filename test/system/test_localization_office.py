"""The localizer on the simulated office floor, against the truth."""

import pathlib
import subprocess
import tempfile
import unittest

from pose_errors import Pose, Summary, Track, compose, error, inverse, settled_after
from ros_session import RosSession

REPO = pathlib.Path(__file__).resolve().parents[2]
SPEED = 3.0  # simulated seconds per second

# From the middle passage through the eastern ring of corridors and back, past the printer and among people who walk.
ROUND = [(0.0, 3.2), (4.5, 3.55), (8.0, 3.6), (11.2, 3.2), (11.35, 0.0), (11.35, -2.2), (11.0, -3.3), (4.0, -3.5), (0.0, -3.2), (0.0, 0.0)]


class Office(unittest.TestCase):
    def test_drives_a_round_and_knows_where_it_is(self):
        import rospy
        from sim_robot import SimRobot
        with tempfile.TemporaryDirectory() as folder, RosSession(pathlib.Path(folder) / "launch.log") as session:
            session.launch("extperfc", "sim_localization.launch", rviz="false", real_time_factor=SPEED)
            session.join("test_localization_office")
            robot = SimRobot()
            robot.ready()
            starting = session.errors()  # on a loaded machine the first cloud may come before the first transform
            begin = robot.now()
            robot.drive(ROUND, speed_m_s=0.8, real_s=130)
            stamps, errors = robot.errors(begin + 1.0, robot.now() - 0.2)
            rospy.signal_shutdown("done")
            self.assertEqual(starting, session.errors())
        summary = Summary(errors)
        print(summary)
        self.assertGreater(stamps[-1] - stamps[0], 30.0, "the drive is longer than that")
        self.assertGreater(len(errors), 1000)
        self.assertLess(summary.mean_m, 0.05, summary)
        self.assertLess(summary.mean_deg, 1.0, summary)
        self.assertLess(summary.p95_m, 0.12, summary)
        self.assertLess(summary.max_m, 0.3, summary)

    def test_the_kidnapping_trial_says_how_it_is_used(self):
        tool = REPO / "tools" / "trial_kidnap"
        shown = subprocess.run([tool, "--help"], capture_output=True, text=True, timeout=60)
        self.assertEqual(0, shown.returncode, shown.stderr)
        self.assertIn("--param KEY=VALUE", shown.stdout)
        wrong = subprocess.run([tool, "--param", "lonely"], capture_output=True, text=True, timeout=60)
        self.assertEqual(2, wrong.returncode)
        self.assertIn("--param must be KEY=VALUE, not lonely", wrong.stderr)


class PoseErrors(unittest.TestCase):
    def test_transforms(self):
        a, b = Pose(1.0, 2.0, 3.0), Pose(-0.5, 0.7, 1.0)
        metres, radians = error(compose(compose(a, b), inverse(b)), a)
        self.assertAlmostEqual(0.0, metres)
        self.assertAlmostEqual(0.0, radians)

    def test_track_interpolates_across_pi(self):
        track = Track()
        track.add(1.0, Pose(0, 0, 3.1))
        track.add(2.0, Pose(1, 0, -3.1))
        middle = track.at(1.5)
        self.assertAlmostEqual(0.5, middle.x)
        self.assertAlmostEqual(3.14159, abs(middle.yaw), 3)
        self.assertIsNone(track.at(2.1))
        self.assertEqual(1, track.before(5.0).x)
        track.add(0.5, Pose(9, 9, 0))
        self.assertIsNone(track.at(1.5), "time ran back: restarted")

    def test_settled_is_for_good(self):
        stamps = [0, 1, 2, 3, 4]
        self.assertEqual(3, settled_after(stamps, [(9, 0), (0, 0), (9, 0), (0, 0), (0.1, 0)], 0.3, 0.1))
        self.assertIsNone(settled_after(stamps, [(0, 0)] * 4 + [(0, 1)], 0.3, 0.1))


if __name__ == "__main__":
    unittest.main()
