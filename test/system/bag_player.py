"""A launch file of the package with simulated time, and `rosbag play` for it."""

import pathlib
import subprocess
import time

from ros_session import RosSession

REPO = pathlib.Path(__file__).resolve().parents[2]


class BagSession(RosSession):
    """A RosSession whose nodes live in the time of a bag."""

    def launch_in_bag_time(self, launch_file, folder, **arguments):
        """Starts launch/<launch_file>; the present process may call rospy.init_node() afterwards."""
        clock = pathlib.Path(folder) / "bag_time.launch"
        clock.write_text('<launch><param name="/use_sim_time" value="true"/></launch>\n')
        self.launch(str(clock), str(REPO / "launch" / launch_file), **arguments)
        self.wait(self._has_bag_time, "the launch", 30)

    @staticmethod
    def _has_bag_time():
        import rosgraph
        if not rosgraph.is_master_online():
            return False
        try:
            return rosgraph.Master("bag_session").getParam("/use_sim_time")
        except rosgraph.MasterError:
            return False

    def wait(self, condition, what, seconds, state=lambda: ""):
        """Until the condition holds. AssertionError with what was waited for, `state()`, and the launch's errors."""
        end = time.monotonic() + seconds
        while not condition():
            if time.monotonic() > end or not self.alive():
                raise AssertionError(f"waited {seconds} s for {what}; {state()} {self.errors()}")
            time.sleep(0.05)

    @staticmethod
    def play(bag, rate, *more):
        """Starts rosbag play with the bag's own clock. It begins when every topic of the bag has a listener."""
        command = ["rosbag", "play", "--clock", "--wait-for-subscribers", "--quiet", "--rate", str(rate), *more, str(bag)]
        return subprocess.Popen(command, stdout=subprocess.DEVNULL, stdin=subprocess.DEVNULL)


def end(process):
    """Ends a player, politely first."""
    process.terminate()
    try:
        process.wait(10)
    except subprocess.TimeoutExpired:
        process.kill()
        process.wait()
