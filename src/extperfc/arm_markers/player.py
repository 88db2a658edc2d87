"""Planned motions as ghosts that move."""

import bisect
import threading
import time

import numpy

from extperfc.arm_markers.ghost import Ghost, array, line_marker

PERIOD_S = 0.1
THERE_RAD = 0.02            # every joint is so near to the end: the motion is over (rad or m)
PAUSE_S = 1.0               # at the end, before it begins again
LINE_POINTS = 200
GHOST = (0.95, 0.75, 0.2, 0.45)
LINES = ((0.3, 0.65, 1.0, 1.0), (1.0, 0.65, 0.2, 1.0))  # of the arms, in turn


class Motion:
    """A trajectory_msgs/JointTrajectory as joint values at times. Raises ValueError for an invalid trajectory."""

    def __init__(self, trajectory):
        self.names = list(trajectory.joint_names)
        self.times_s = [point.time_from_start.to_sec() for point in trajectory.points]
        self.positions = [numpy.array(point.positions, float) for point in trajectory.points]
        if not self.times_s:
            raise ValueError("a trajectory without points")
        if any(len(p) != len(self.names) for p in self.positions):
            raise ValueError("a trajectory whose points do not have one position for each joint")
        if any(b < a for a, b in zip(self.times_s, self.times_s[1:])):
            raise ValueError("a trajectory whose times go back")

    @property
    def duration_s(self):
        return self.times_s[-1]

    def at(self, time_s):
        """{joint: value}, straight between points; before the first and after the last as there."""
        after = bisect.bisect_right(self.times_s, time_s)
        if after == 0 or after == len(self.times_s):
            values = self.positions[min(after, len(self.times_s) - 1)]
        else:
            begin, end = self.times_s[after - 1], self.times_s[after]
            part = (time_s - begin) / (end - begin)
            values = (1 - part) * self.positions[after - 1] + part * self.positions[after]
        return {name: float(value) for name, value in zip(self.names, values)}


def moved_tips(robot, tips, joint_names):
    """Of {side: tool's link} those that these joints move."""
    return {side: tip for side, tip in tips.items() if set(robot.joints_above(tip)) & set(joint_names)}


def tool_lines(robot, tips, motion, other_joints, count=LINE_POINTS):
    """{side: points (N, 3) [m] of the tool in the root's frame}. tips: {side: tool's link}; other_joints: values of what the
    motion does not move."""
    moved = moved_tips(robot, tips, motion.names)
    lines = {side: [] for side in moved}
    for time_s in numpy.linspace(0, motion.duration_s, count):
        poses = robot.link_poses({**other_joints, **motion.at(time_s)})
        for side, tip in moved.items():
            lines[side].append(poses[tip][:3, 3])
    return {side: numpy.array(points) for side, points in lines.items()}


class PathPlayer:
    """Shows the newest motion again and again, in real time, in a thread of its own, until the robot is at its end.

    tips: {side: tool's link}; publish(MarkerArray); watched(): whether anybody looks; joints(): {joint: value} of the robot now.
    """

    def __init__(self, robot, tips, publish, watched, joints, pause_s=PAUSE_S):
        self._tips = tips
        self._robot, self._publish, self._watched, self._joints, self._pause_s = robot, publish, watched, joints, pause_s
        self._new, self._changed, self._ended = [], threading.Condition(), False
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._thread.start()

    def show(self, trajectory):
        """Raises ValueError where it cannot be shown."""
        motion = Motion(trajectory)
        unknown = [name for name in motion.names if name not in self._robot.joints]
        if unknown:
            raise ValueError(f"a trajectory of joints that the robot does not have: {', '.join(unknown)}")
        self._set(motion)

    def clear(self):
        self._set(None)

    def end(self):
        with self._changed:
            self._ended = True
            self._changed.notify_all()
        self._thread.join()

    def _set(self, motion):
        with self._changed:
            self._new[:] = [motion]
            self._changed.notify_all()

    def _interrupted(self, wait_s):
        """Waits, or returns early and True when there is something else to do."""
        with self._changed:
            return self._changed.wait_for(lambda: self._new or self._ended, wait_s)

    def _there(self, motion):
        now, end = self._joints(), motion.at(motion.duration_s)
        return all(name in now and abs(now[name] - value) < THERE_RAD for name, value in end.items())

    def _run(self):
        while not self._ended:
            with self._changed:
                self._changed.wait_for(lambda: self._new or self._ended)
                if self._ended:
                    return
                motion = self._new.pop()
            if motion is not None:
                self._publish(array(self._play(motion)))

    def _play(self, motion):
        """Until something else is to be done, or the robot is there. Returns the markers that take away what it showed."""
        ghost = Ghost(self._robot, self._robot.links_below(motion.names), "ghost")
        others = self._joints()
        sides = list(self._tips)
        lines = [line_marker(self._robot.root, "tool", number, points, LINES[sides.index(side) % len(LINES)])
                 for number, (side, points) in enumerate(tool_lines(self._robot, self._tips, motion, others).items())]
        while True:
            began = time.monotonic()
            while time.monotonic() - began <= motion.duration_s + self._pause_s:
                if self._watched():
                    values = {**others, **motion.at(time.monotonic() - began)}
                    self._publish(array(ghost.markers(values, GHOST) + lines))
                if self._interrupted(PERIOD_S) or self._there(motion):
                    for line in lines:
                        line.action, line.points = line.DELETE, []
                    return ghost.removals() + lines
