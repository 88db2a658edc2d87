"""The node of tools/arm_markers.

  reads      robot_description (parameter), robot/joint_states, arm/display_trajectory
  asks       the actions plan, move_arm and the grippers', the services arm/solve_ik and arm/stop
  offers     arm/goals (interactive markers: arm/goals/update, /update_full, /feedback)
  publishes  arm/goal_ghost (visualization_msgs/MarkerArray): each arm at its dragged goal, and what is said of it
             arm/planned_path (visualization_msgs/MarkerArray): the planned motion, repeatedly, and the paths of the tools
  parameters ~frame (that of the arms, a Baxter's base): of the goals, a link of the robot; ~ik_rate (15 Hz): of questions while dragging;
             ~named_states ([neutral, tuck, untuck]): of the menu
"""

import sys

import rosgraph
import rospy
from interactive_markers.interactive_marker_server import InteractiveMarkerServer
from interactive_markers.menu_handler import MenuHandler
from trajectory_msgs.msg import JointTrajectory
from visualization_msgs.msg import InteractiveMarkerFeedback, MarkerArray

from extperfc.arm import Arm, goals, hands, robot_state
from extperfc.arm_markers.arm_goal import ArmGoal
from extperfc.arm_markers.commands import Commands
from extperfc.arm_markers.goal import goal_marker
from extperfc.arm_markers.player import PathPlayer
from extperfc.robot_description import RobotDescription


class Refused(Exception):
    """The node cannot start; the text says why."""


def read_parameters():
    """(RobotDescription, frame, rate [Hz], names of states)."""
    if not rospy.has_param("robot_description"):
        raise Refused(f"no parameter {rospy.resolve_name('robot_description')}: start the robot or the simulator first")
    try:
        robot = RobotDescription(rospy.get_param("robot_description"))
    except ValueError as error:
        raise Refused(f"robot_description: {error}") from None
    frame, rate_hz = rospy.get_param("~frame", hands.of().frame), float(rospy.get_param("~ik_rate", 15.0))
    if frame not in robot.links:
        raise Refused(f"~frame: {frame} is not a link of the robot")
    if not 0.1 <= rate_hz <= 200:
        raise Refused(f"~ik_rate: {rate_hz} is out of [0.1, 200] Hz")
    return robot, frame, rate_hz, list(rospy.get_param("~named_states", ["neutral", "tuck", "untuck"]))


class ArmMarkers:
    """Everything of the node, for the arms that the robot has."""

    def __init__(self):
        self._robot, self._frame, rate_hz, self._states = read_parameters()
        self._listener = robot_state.joints()
        self._ghosts = rospy.Publisher("arm/goal_ghost", MarkerArray, queue_size=10, latch=True)
        self._paths = rospy.Publisher("arm/planned_path", MarkerArray, queue_size=10)
        arms = hands.of()
        sides = [side for side in arms.names if arms[side].tip in self._robot.links]
        if not sides:
            raise Refused("the robot has none of the links " + ", ".join(arms[side].tip for side in arms.names))
        self._tips = {side: arms[side].tip for side in sides}
        self._await_joints()
        self._goals = {side: ArmGoal(side, arms, self._robot, self._frame, self._ghosts.publish, self._listener.positions, rate_hz)
                       for side in sides}
        self._commands = Commands({which: Arm(which) for which in (*sides, hands.ALL)}, self._goals, self._on_moved)
        self._player = PathPlayer(self._robot, self._tips, self._paths.publish, lambda: self._paths.get_num_connections() > 0,
                                  self._listener.positions)
        self._server, self._menus = InteractiveMarkerServer("arm/goals"), {}
        for side in sides:
            self._server.insert(goal_marker(side, self._goals[side].pose), self._on_feedback)
            self._menus[side] = self._menu(side)
            self._menus[side].apply(self._server, side)
        self._server.applyChanges()
        self._subscriber = rospy.Subscriber("arm/display_trajectory", JointTrajectory, self._on_trajectory, queue_size=1)

    def _await_joints(self):
        """Waits until every joint of the arms was published."""
        wanted = {name for tip in self._tips.values() for name in self._robot.joints_above(tip)}
        waited = 0
        while not wanted <= set(self._listener.positions()):
            if rospy.is_shutdown():
                raise Refused("shut down before joint states arrived")
            if waited == 100:
                rospy.logwarn("waiting for the arms' joints on %s", self._listener.topic)
            waited += 1
            rospy.rostime.wallsleep(0.05)

    def _on_feedback(self, feedback):
        if feedback.event_type != InteractiveMarkerFeedback.POSE_UPDATE:
            return
        frame = feedback.header.frame_id or self._frame
        self._goals[feedback.marker_name].drag(goals.pose_stamped(feedback.pose, frame))

    def _on_trajectory(self, trajectory):
        try:
            if trajectory.points:
                self._player.show(trajectory)
            else:
                self._player.clear()
        except ValueError as error:
            rospy.logwarn("arm/display_trajectory: %s", error)

    def _on_moved(self, which):
        """The arms have moved: clears the planned path and moves the goals to the tools."""
        self._player.clear()
        for side in self._goals if which == hands.ALL else (which,):
            self._settle(side)

    def _settle(self, side):
        self._server.setPose(side, self._goals[side].settle().pose)
        self._server.applyChanges()

    def _menu(self, side):
        menu, do = MenuHandler(), self._commands

        def entry(title, call, parent=None):
            return menu.insert(title, parent=parent, callback=lambda _: call())

        entry("Plan", lambda: do.plan(side))
        entry("Execute the plan", lambda: do.execute(side))
        entry("Plan and execute", lambda: do.plan_and_execute(side))
        if len(self._goals) == 2:
            entry("Plan both arms", lambda: do.plan(hands.ALL))
            entry("Plan and execute both arms", lambda: do.plan_and_execute(hands.ALL))
        entry("STOP", lambda: do.stop(side))
        straight = menu.insert("Straight line", callback=lambda feedback: self._toggle_linear(feedback.menu_entry_id))
        menu.setCheckState(straight, MenuHandler.UNCHECKED)
        entry("Goal to where the tool is", lambda: self._settle(side))
        states = menu.insert("Move to")
        for state in self._states:
            entry(state, lambda state=state: do.go_to(side, state), states)
        entry("Open gripper", lambda: do.open(side))
        entry("Close gripper", lambda: do.close(side))
        return menu

    def _toggle_linear(self, handle):
        """One switch for both arms: their menus are made alike, so that the entry has the same number."""
        state = next(iter(self._menus.values())).getCheckState(handle)
        linear = state != MenuHandler.CHECKED
        self._commands.set_linear(linear)
        for menu in self._menus.values():
            menu.setCheckState(handle, MenuHandler.CHECKED if linear else MenuHandler.UNCHECKED)
            menu.reApply(self._server)
        self._server.applyChanges()


def main():
    if {"-h", "--help"} & set(rospy.myargv()[1:]):
        print(__doc__)
        return 0
    if not rosgraph.is_master_online():
        print(f"arm_markers: no ROS master at {rosgraph.get_master_uri()}", file=sys.stderr)
        return 1
    rospy.init_node("arm_markers")
    try:
        markers = ArmMarkers()
    except Refused as error:
        rospy.logfatal("arm_markers: %s", error)
        return 1
    rospy.spin()
    del markers
    return 0
