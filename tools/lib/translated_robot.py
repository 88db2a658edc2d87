"""The simulated Baxter with base, lidar and camera at a master of its own, for bringup.launch with a translator between them."""

import os
import pathlib
import signal
import subprocess
import sys

from extperfc.health.processes import ProcessTable
from ros_session import end_launch

REPO = pathlib.Path(__file__).resolve().parents[2]
LAUNCH_FILE = REPO / "test" / "system" / "translated_robot.launch"  # of the other side; argument robot_master

sys.path.insert(0, str(REPO / "test" / "translator"))

from harness import processes  # noqa: E402


class RobotSide:
    """Master and simulator in a place of harness.network, with logs in `folder`. arguments: more of sim.launch."""

    def __init__(self, place, folder, **arguments):
        self.master, self._place, self._folder, self._launch = processes.Master("robot", place, folder), place, folder, None
        self._arguments = {"rviz": "false", "scan": "false", "start_pose": "tuck", "publish_map_frame": "false", **arguments}

    def start(self):
        self.master.start()
        command = ["roslaunch", "extperfc", "sim.launch", *(f"{name}:={value}" for name, value in self._arguments.items())]
        with open(self._folder / "robot.log", "a") as log:
            self._launch = subprocess.Popen(self._place.command(command), stdout=log, stderr=subprocess.STDOUT, stdin=subprocess.DEVNULL,
                                            env=self.master.environment())

    def kill(self):
        """Every process at once, as when the robot loses its power."""
        self._launch.kill()  # first: it would start the others again
        self._launch.wait()
        for process in ProcessTable(self.master.uri).scan().values():
            os.kill(process.pid, signal.SIGKILL)
        self.master.kill()

    def close(self):
        if self._launch is not None and self._launch.poll() is None:
            end_launch(self._launch)
        self.master.end()
