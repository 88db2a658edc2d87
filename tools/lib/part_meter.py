"""CPU time and memory of the robot's parts: the processes of their nodelet managers and nodes."""

import os
import pathlib

from extperfc.health.processes import ProcessTable

TICKS_PER_S = os.sysconf("SC_CLK_TCK")
PAGE_MB = os.sysconf("SC_PAGE_SIZE") / 2**20
# Nodes by what a reader knows them as; a loader of nodelets waits, and counts as "loaders and others".
PARTS = {"/robot_manager": "simulator", "/lidar_manager": "cloud_to_scan", "/camera_manager": "detector and box_depth",
         "/more_cameras_manager": "detectors and box_depths of the other cameras", "/mapping_manager": "mapper",
         "/navigation_manager": "navigator and cmd_vel_mux", "/arm_manager": "arm", "/health": "health",
         "/robot_state_publisher": "robot_state_publisher", "/translator": "translator"}
OTHERS = "loaders and others"


def part_of(node):
    return PARTS.get(node, OTHERS)


class PartMeter:
    """What the parts use."""

    def __init__(self, master_uri, root="/proc"):
        self._root, self._table = pathlib.Path(root), ProcessTable(master_uri, root)
        self.begin()

    def begin(self):
        """used() counts from here on, for the processes that live now."""
        self._processes = self._table.scan()
        self._at = {name: self._cpu_s(process.pid) for name, process in self._processes.items()}

    def memory(self):
        """{(node, pid): resident memory [MB]} of the processes that live now."""
        return {(name, process.pid): self._memory_mb(process.pid) for name, process in self._table.scan().items()}

    def used(self):
        """{part: (CPU time since begin() [s], resident memory [MB])}. A process that ended meanwhile counts to what is left of it."""
        found = {}
        for name, process in self._processes.items():
            part = part_of(name)
            cpu_s, memory_mb = found.get(part, (0.0, 0.0))
            found[part] = cpu_s + max(0.0, self._cpu_s(process.pid) - self._at[name]), memory_mb + self._memory_mb(process.pid)
        return found

    def _cpu_s(self, pid):
        fields = self._fields(pid, "stat", after=b")")
        return (int(fields[11]) + int(fields[12])) / TICKS_PER_S if len(fields) > 12 else 0.0

    def _memory_mb(self, pid):
        fields = self._fields(pid, "statm")
        return int(fields[1]) * PAGE_MB if len(fields) > 1 else 0.0

    def _fields(self, pid, name, after=None):
        try:
            data = (self._root / str(pid) / name).read_bytes()
        except OSError:
            return []
        return (data.rpartition(after)[2] if after else data).split()
