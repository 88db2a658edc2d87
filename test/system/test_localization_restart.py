"""localization.launch started again with the same master: the localizer resumes from the pose that it stored."""

import math
import pathlib
import subprocess
import tempfile
import time
import unittest

import yaml

from bag_player import BagSession, end
from drawn_room import DRIVE, between, map_the_drive, write_bag

RATE = 6                              # simulated seconds per second
FIRST, SECOND = 100, 40               # scans before and after the second start
MAX_STORED_M = 0.2                    # of the stored pose from where the robot stopped
MAX_ERROR_M, MAX_ERROR_DEG = 0.3, 10.0  # of the estimates after the second start


def yaw_of(orientation):
    return 2 * math.atan2(orientation.z, orientation.w)


class LocalizationRestart(unittest.TestCase):
    def setUp(self):
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.folder = pathlib.Path(temporary.name)

    def test_a_second_start_goes_on_from_the_stored_pose(self):
        import rospy
        from geometry_msgs.msg import PoseWithCovarianceStamped
        _, path = map_the_drive(self.folder)
        start, stop = path[DRIVE.stamps[0]], path[round(DRIVE.stamps[FIRST - 1], 3)]
        self.assertGreater(math.hypot(*stop[:2]), 1.0, "what is stored must be far from where a start without it begins")
        poses = []
        with BagSession(self.folder / "launch.log") as session:
            self.start_core(session.port)
            self.play_a_part(session, 0, FIRST, initial_pose_x=start[0], initial_pose_y=start[1], initial_pose_a=start[2])
            session.wait(lambda: self.off_stored_pose(stop) < MAX_STORED_M, "the last pose in the parameter server", 20)
            end(session.process)
            self.assertLess(rospy.get_param("/localizer/initial_cov_xx"), 0.1, "it knows better than at the start")
            rospy.init_node("localization_restart_test", disable_signals=True)
            rospy.Subscriber("/amcl_pose", PoseWithCovarianceStamped, poses.append, queue_size=100)
            self.play_a_part(session, FIRST, FIRST + SECOND)
            rospy.signal_shutdown("done")
            self.assertEqual([], session.errors())
        self.assertGreater(len(poses), 0)
        for message in poses:
            pose = message.pose.pose
            x, y, yaw = between(path[round(message.header.stamp.to_sec(), 3)],
                                (pose.position.x, pose.position.y, yaw_of(pose.orientation)))
            self.assertLess(math.hypot(x, y), MAX_ERROR_M, message.header.stamp)
            self.assertLess(abs(math.degrees(yaw)), MAX_ERROR_DEG, message.header.stamp)

    def start_core(self, port):
        """A ROS master that outlives the launch files."""
        import rosgraph
        core = subprocess.Popen(["roscore", "-p", str(port)], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
                                stdin=subprocess.DEVNULL)
        self.addCleanup(end, core)
        deadline = time.monotonic() + 30
        while not rosgraph.is_master_online():
            self.assertLess(time.monotonic(), deadline, "the ROS master did not start")
            time.sleep(0.05)

    @staticmethod
    def off_stored_pose(pose):
        """Distance [m] of the stored pose from this one."""
        import rospy
        return math.hypot(*(rospy.get_param(f"/localizer/initial_pose_{axis}", math.inf) - pose["xy".index(axis)]
                            for axis in "xy"))

    def play_a_part(self, session, first, last, **arguments):
        """Starts localization.launch and plays these scans to it."""
        part = self.folder / f"{first}.bag"
        write_bag(part, DRIVE.stamps[first:last], DRIVE.scans[first:last], DRIVE.odometry[first:last])
        session.launch_in_bag_time("localization.launch", self.folder, map_file=self.folder / "map.yaml",
                                   base_frame="base_link", rviz="false", **arguments)
        player = session.play(part, RATE)
        try:
            session.wait(lambda: player.poll() is not None, "the end of the bag", 40)
        finally:
            end(player)

    def parameters_of(self, *arguments):
        """initial_* that localization.launch sets."""
        shown = subprocess.run(["roslaunch", "--dump-params", "extperfc", "localization.launch", "rviz:=false", *arguments],
                               check=True, capture_output=True, text=True, timeout=60)
        prefix = "/localizer/initial_"
        return {name[len(prefix):]: value for name, value in yaml.safe_load(shown.stdout).items() if name.startswith(prefix)}

    def test_only_a_given_pose_replaces_what_was_stored(self):
        self.assertEqual({}, self.parameters_of())
        spread = {"cov_xx": 0.25, "cov_yy": 0.25, "cov_aa": 0.0685389}
        self.assertEqual({"pose_x": 1.5, "pose_y": 0, "pose_a": 0, **spread}, self.parameters_of("initial_pose_x:=1.5"))
        self.assertEqual({"pose_x": 0, "pose_y": 0, "pose_a": 0, **spread}, self.parameters_of("initial_pose_a:=0"))


if __name__ == "__main__":
    unittest.main()
