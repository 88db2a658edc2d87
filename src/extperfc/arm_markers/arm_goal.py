"""One arm's goal in rviz: its pose, the ghost of the arm there, and its text."""

import threading

import extperfc.srv
from extperfc.arm import connection, goals
from extperfc.arm_markers.ghost import Ghost, array, text_marker
from extperfc.arm_markers.goal import Newest, view_of

TEXT_GOOD, TEXT_BAD = (0.85, 1.0, 0.85, 1.0), (1.0, 0.45, 0.35, 1.0)
TEXT_AT_M = (0.25, 0.0, 0.12)   # from the goal, in its frame: in front of the gripper, since text can hide
LINE_LETTERS = 60


def wrapped(text, letters=LINE_LETTERS):
    """The same text in lines of no more letters than this, where words allow it."""
    lines, line = [], ""
    for token in text.split():
        if line and len(line) + 1 + len(token) > letters:
            lines.append(line)
            line = token
        else:
            line = f"{line} {token}".strip()
    return "\n".join(lines + [line])


class ArmGoal:
    """arms: extperfc.arm.hands.Hands; publish(MarkerArray); joints(): {joint: value} of the robot now; solve: the service
    arm/solve_ik. Of any thread."""

    def __init__(self, side, arms, robot, frame, publish, joints, rate_hz, solve=None):
        self.side, self._robot, self._frame, self._publish, self._robot_joints = side, robot, frame, publish, joints
        self._arms, self._tip = arms, arms[side].tip
        self.joint_names = robot.joints_above(self._tip)
        self._ghost = Ghost(robot, robot.links_below(self.joint_names[:1]), f"{side}_goal")
        self._solve = solve or connection.Service("", "arm/solve_ik", extperfc.srv.SolveArmIk)
        self._lock = threading.Lock()
        self._pose, self._solution, self._dragged, self._said = self.tool_now(), {}, False, ("", True)
        self._newest = Newest(self._look, rate_hz)

    def tool_now(self):
        """geometry_msgs/PoseStamped of the tool, by forward kinematics."""
        frame_T_link = self._robot.link_poses(self._robot_joints(), self._frame)
        return goals.pose_stamped(frame_T_link[self._tip], self._frame)

    @property
    def pose(self):
        """geometry_msgs/PoseStamped."""
        with self._lock:
            return self._pose

    def drag(self, pose_stamped):
        """The goal is here now; its ghost follows."""
        with self._lock:
            self._pose, self._dragged = pose_stamped, True
        self._newest.put(pose_stamped)

    def settle(self):
        """The goal is where the tool is, and there is nothing to show. Returns the pose."""
        pose = self.tool_now()
        with self._lock:
            self._pose, self._dragged, self._solution, self._said = pose, False, {}, ("", True)
            self._publish(array(self._ghost.removals() + [self._text()]))
        return pose

    def say(self, text, good=True):
        """Text at the goal, until something else is said or the goal is dragged."""
        with self._lock:
            self._said = (text, good)
            self._publish(array([self._text()]))

    def end(self):
        self._newest.end()

    def _look(self, pose):
        """Of the newest pose, in the thread of Newest. Seeded with the last solution, so that the elbow does not jump."""
        now = self._robot_joints()
        last = self._solution or {name: now[name] for name in self.joint_names if name in now}

        def solve(avoid_collisions):
            return self._solve(group=self._arms.group(self.side), goal=goals.tool_goal(self._tip, pose),
                               seed=goals.joint_state(last, self.side, self._arms), avoid_collisions=avoid_collisions)

        view = view_of(solve, last)
        with self._lock:
            if not self._dragged:
                return  # settled meanwhile
            self._solution, self._said = view.joints, (view.text, view.good)
            self._publish(array(self._ghost.markers({**now, **view.joints}, view.rgba) + [self._text()]))

    def _text(self):
        text, good = self._said
        p = self._pose.pose.position
        at = (p.x + TEXT_AT_M[0], p.y + TEXT_AT_M[1], p.z + TEXT_AT_M[2])
        made = text_marker(self._pose.header.frame_id, f"{self.side}_text", 0, wrapped(text), at,
                           TEXT_GOOD if good else TEXT_BAD)
        if not text:
            made.action = made.DELETE
        return made
