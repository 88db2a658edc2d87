"""Simulator, localizer and navigator on the office floor, against the truth."""

import math
import os
import pathlib
import signal
import subprocess
import tempfile
import unittest

from driven_contacts import TrueMap, count_episodes, distance_to_footprint, reachable
from pose_errors import Pose
from ros_session import RosSession

REPO = pathlib.Path(__file__).resolve().parents[2]
SPEED = 2.0  # simulated seconds per second
GOALS = (Pose(0.0, 3.4, 0.0), Pose(-3.6, 6.0, 1.57))  # the corridor; a room behind a door


class Office(unittest.TestCase):
    def test_drives_through_a_door_without_contact_and_stops_when_the_navigator_dies(self):
        import rospy
        from nav_robot import NavRobot
        with tempfile.TemporaryDirectory() as folder, RosSession(pathlib.Path(folder) / "launch.log") as session:
            session.launch("extperfc", "sim_navigation.launch", rviz="false", real_time_factor=SPEED,
                           navigation_manager="nav_manager")
            session.join("test_navigation_office")
            robot = NavRobot(session.alive)
            robot.ready()
            info = robot.map.info
            cells = [robot.map.data[i * info.width:(i + 1) * info.width] for i in range(info.height)]
            true_map = TrueMap(cells, info.resolution, info.origin.position.x, info.origin.position.y)
            for goal in GOALS:
                drive = robot.drive(goal, limit_s=60, real_s=60)
                self.assertTrue(drive.reached, f"{goal}: {drive.text}")
                metres, radians = drive.error()
                self.assertLess(metres, 0.2)
                self.assertLess(radians, 0.2)
                self.assertEqual(0, drive.contacts(true_map), goal)
            self.stops_when_killed(robot, session)
            rospy.signal_shutdown("done")

    def stops_when_killed(self, robot, session):
        """The base's own timeout stops it: no one is left to send zero."""
        import rosgraph
        import xmlrpc.client
        robot.send(Pose(0.0, 3.4, 0.0))
        robot.wait(lambda: robot.status.state == "controlling" and robot.status.speed > 0.2, "the robot to drive", 30)
        uri = rosgraph.Master("/test").lookupNode("/nav_manager")
        pid = xmlrpc.client.ServerProxy(uri).getPid("/test")[2]
        os.kill(pid, signal.SIGKILL)
        begin = robot.now()
        robot.wait(lambda: robot.now() > begin + 2.0, "two seconds", 30)
        with robot.lock:
            late = [pose for stamp, pose in robot.samples if stamp > begin + 1.2]
        self.assertGreater(len(late), 10)
        self.assertLess(max(math.hypot(pose.x - late[-1].x, pose.y - late[-1].y) for pose in late), 0.01)

    def test_the_trial_says_how_it_is_used(self):
        tool = REPO / "tools" / "trial_navigate"
        shown = subprocess.run([tool, "--help"], capture_output=True, text=True, timeout=60)
        self.assertEqual(0, shown.returncode, shown.stderr)
        self.assertIn("--close-door", shown.stdout)
        wrong = subprocess.run([tool, "--param", "lonely"], capture_output=True, text=True, timeout=60)
        self.assertEqual(2, wrong.returncode)
        self.assertIn("--param must be KEY=VALUE, not lonely", wrong.stderr)


class Contacts(unittest.TestCase):
    def setUp(self):
        cells = [[0] * 100 for _ in range(100)]
        for row in range(100):
            cells[row][60] = 100  # a wall at x = 1.0 to 1.1
        self.map = TrueMap(cells, 0.1, -5.0, -5.0)

    def test_footprint_and_cells(self):
        self.assertFalse(self.map.touches(Pose(0.6, 0, 0)), "its front is at 1.006, the cells' middles at 1.05")
        self.assertTrue(self.map.touches(Pose(0.7, 0, 0)))
        self.assertTrue(self.map.touches(Pose(0.55, 0, math.pi / 4)), "a corner")
        self.assertFalse(self.map.touches(Pose(-3, 0, 0)))

    def test_distance_to_the_footprint(self):
        self.assertEqual(0.0, distance_to_footprint(Pose(1, 2, 0.3), 1.1, 2.0))
        self.assertAlmostEqual(1.0 - 0.4064, distance_to_footprint(Pose(0, 0, 0), 1.0, 0.0))
        self.assertAlmostEqual(1.0 - 0.3937, distance_to_footprint(Pose(0, 0, math.pi / 2), 1.0, 0.0))

    def test_episodes(self):
        self.assertEqual(2, count_episodes([False, True, True, False, True]))
        self.assertEqual(0, count_episodes([]))

    def test_what_a_disc_reaches(self):
        mask = reachable(self.map, (0.0, 0.0), 0.4)
        self.assertTrue(mask[self.map.cell(-3, 0)])
        self.assertFalse(mask[self.map.cell(3, 0)], "behind the wall")
        self.assertFalse(mask[self.map.cell(0.9, 0)], "too near to it")


if __name__ == "__main__":
    unittest.main()
