"""Leaves that drive the base."""

import math

import geometry_msgs.msg
import move_base_msgs.msg

import extperfc.msg
from extperfc.arm.connection import Action
from extperfc.arm.goals import pose_stamped
from extperfc.tasks.blackboard import read
from extperfc.tasks.leaf import ActionLeaf

SERVER_WAIT_S = 30.0  # of real time
START = "is the navigator running (roslaunch extperfc navigation.launch)?"
START_EXPLORER = "is the explorer running (roslaunch extperfc exploration.launch)?"


class GoTo(ActionLeaf):
    """Drives the base to a pose by the action `move_base`: (x, y, yaw) in `frame`, a PoseStamped, or a Key for one."""

    _action = None

    def __init__(self, pose, frame="map", name=None):
        super().__init__(name or "go")
        self.pose, self.frame = pose, frame

    def motion(self):
        GoTo._action = GoTo._action or Action("", "move_base", move_base_msgs.msg.MoveBaseAction, SERVER_WAIT_S, START)
        return GoTo._action.send(move_base_msgs.msg.MoveBaseGoal(target_pose=planar_pose(read(self.pose), self.frame)))


def planar_pose(pose, frame):
    """PoseStamped of (x, y, yaw) in a frame, or of what pose_stamped() accepts."""
    if isinstance(pose, (tuple, list)) and len(pose) == 3:
        x, y, yaw = pose
        return pose_stamped((x, y, 0.0, 0.0, 0.0, math.sin(yaw / 2), math.cos(yaw / 2)), frame)
    return pose_stamped(pose, frame)


class Explore(ActionLeaf):
    """Drives to the borders of the known map until none is left, by the action `explore`.

    bounds: corners (x, y) of a polygon in the map's frame, none: everywhere; time_limit [s], 0: none.
    """

    _action = None

    def __init__(self, bounds=(), time_limit=0.0, name=None):
        super().__init__(name or "explore")
        self.goal = extperfc.msg.ExploreGoal(time_limit=time_limit)
        self.goal.bounds.header.frame_id = "map"
        self.goal.bounds.polygon.points = [geometry_msgs.msg.Point32(float(x), float(y), 0.0) for x, y in bounds]

    def motion(self):
        Explore._action = Explore._action or Action("", "explore", extperfc.msg.ExploreAction, SERVER_WAIT_S, START_EXPLORER)
        return Explore._action.send(self.goal)

    def step(self):
        ended = super().step()
        if ended is None and self._motion.feedback is not None:
            feedback = self._motion.feedback
            self.feedback_message = f"{feedback.known_area:.0f} m2 known, {feedback.frontiers} frontiers left"
        return ended
