"""One arm, or both, as an object."""

import collections
import dataclasses
import time

import control_msgs.msg
import geometry_msgs.msg
import numpy
import rospy
import std_srvs.srv
import trajectory_msgs.msg

import extperfc.msg
import extperfc.srv
from extperfc.arm import connection, goals, robot_state
from extperfc.arm import hands as robot_hands
from extperfc.arm.errors import ArmError, ClientCode
from extperfc.arm.scene import Scene

JOG_PERIOD_S = 0.02
OPEN_PERCENT, CLOSED_PERCENT = 100.0, 0.0
EMPTY_PERCENT = 3.0  # fingers with nothing between them close to less than this

StateCheck = collections.namedtuple("StateCheck", "free code message first second distance")
StateCheck.__doc__ = "Is a state free? Otherwise why not; the nearest pair of names and its distance [m], negative: depth."


@dataclasses.dataclass(frozen=True)
class Plan:
    """A motion that was planned and not executed yet."""
    trajectory: trajectory_msgs.msg.JointTrajectory
    fraction: float             # planned fraction of the requested path, [0, 1]
    planning_time_s: float
    message: str

    @property
    def duration_s(self):
        points = self.trajectory.points
        return points[-1].time_from_start.to_sec() if points else 0.0


class Arm:
    """One arm by the name of its gripper, of a Baxter "left" or "right", or "both": all arms of the robot.

    A goal is
    - the name of a state: "neutral", "tuck", "untuck";
    - joint values [rad], {"s0": 0.1, "e1": 0.75}: what is not named stays;
    - a pose of the tool (left_gripper, right_gripper) in `frame` (none: hands.frame, a Baxter's base):
      (x, y, z) with its present orientation,
      (x, y, z, roll, pitch, yaw), (x, y, z, qx, qy, qz, qw), a 4x4 array, a Pose, or a PoseStamped with its own frame;
    - with linear=True also a list of poses, straight from one to the next;
    - for both arms {"left": goal, "right": goal} with two poses or two of joint values, or one name of a state.
    Options beside the goal are the fields of goals.MotionOptions, e.g. frame="map", constraints=arm.keep_level(),
    velocity_scale=0.3, planning_time=2.0.

    namespace: of the robot and the arm node; none: this node's own. wait_s: how long to wait for servers, in real time.
    Names of arms, tools and joints are those of the arm node's parameter `grippers` and of robot_description.
    Makes the process a ROS node if necessary. Failures raise ArmError; invalid goals raise ValueError.
    A motion ends when it is interrupted with Ctrl-C, when its timeout is over, and when the program ends, unless it is
    killed with SIGKILL.
    """

    def __init__(self, side, namespace="", wait_s=connection.WAIT_S):
        connection.ensure_node()
        self.namespace, self.wait_s, self._which = namespace, wait_s, side
        robot_hands.wait_for(side, namespace, wait_s)
        self.scene = Scene(namespace, wait_s)
        self._joint_states = robot_state.joints(namespace)
        self._actions, self._services, self._publishers = {}, {}, {}

    @property
    def hands(self):
        """The robot's arms (extperfc.arm.hands.Hands)."""
        return robot_hands.of(self.namespace)

    @property
    def sides(self):
        """The names of these arms."""
        return self.hands.named(self._which)

    @property
    def side(self):
        """The name of the one arm, or "both"."""
        sides = self.sides
        return sides[0] if len(sides) == 1 else robot_hands.ALL

    # Motions.

    def plan(self, goal, linear=False, timeout=None, **options):
        """Plans without moving. Returns a Plan."""
        asked = self._request(goal, linear, options)
        result = self._send("plan", extperfc.msg.PlanAction, extperfc.msg.PlanGoal(asked)).wait(timeout)
        return Plan(result.trajectory, result.fraction, result.planning_time, result.message)

    def execute(self, plan, wait=True, timeout=None):
        """Executes a Plan, or a trajectory_msgs/JointTrajectory. Returns as move_to."""
        trajectory = getattr(plan, "trajectory", plan)
        if not trajectory.points:
            raise ValueError("the plan has no points")
        return self._move(extperfc.msg.MoveArmGoal(trajectory=trajectory), wait, timeout)

    def move_to(self, goal, linear=False, wait=True, timeout=None, replans=2, **options):
        """Plans and moves. linear: the tool moves along straight lines.

        wait=True: returns extperfc/MoveArmResult at the end; timeout: in seconds of real time, then it is cancelled.
        wait=False: returns a Motion at once (motion.wait(), motion.done, motion.cancel(), motion.feedback).
        replans: maximum number of new plans when the path is blocked.
        """
        if replans < 0:
            raise ValueError("replans must be 0 or more")
        asked = self._request(goal, linear, options)
        return self._move(extperfc.msg.MoveArmGoal(request=asked, replans=int(replans)), wait, timeout)

    def tuck(self, **options):
        """Folds the arm away, e.g. before driving. Returns as move_to."""
        return self.move_to("tuck", **options)

    def untuck(self, **options):
        """Brings the arm to the front."""
        return self.move_to("untuck", **options)

    def stop(self):
        """Stops all motions of the arm node, including those of other programs."""
        answer = self._call("arm/stop", std_srvs.srv.Trigger)
        if not answer.success:
            raise ArmError(extperfc.msg.ArmCode.INTERNAL, answer.message)

    def jog(self, twist=None, joints=None, frame="", duration=0.0):
        """Moves by velocities, as a joystick does; the node avoids collisions.

        twist: (vx, vy, vz, wx, wy, wz) [m/s, rad/s] of the tool along the axes of `frame` (empty: the tool's own);
        or joints: {joint: rad/s}. duration [s]: repeats the command so long and stops; 0: sends it once, and the node
        stops soon unless more follow.
        """
        side = self._one_side("jog")
        if (twist is None) == (joints is None):
            raise ValueError("jog: give either twist or joints")
        if twist is not None:
            send = self._publisher(f"arm/{side}/jog_twist", geometry_msgs.msg.TwistStamped)
            frame = frame or self.hands[side].tip
            command, stop = _twist(twist, frame), _twist((0,) * 6, frame)
        else:
            send = self._publisher(f"arm/{side}/jog_joints", control_msgs.msg.JointJog)
            command = _joint_jog(joints, side, self.hands)
            stop = _joint_jog(dict.fromkeys(joints, 0.0), side, self.hands)
        try:
            end = time.monotonic() + duration
            while True:
                command.header.stamp = rospy.Time.now()
                send.publish(command)
                if time.monotonic() >= end or rospy.is_shutdown():
                    return
                time.sleep(JOG_PERIOD_S)
        finally:
            if duration > 0:
                stop.header.stamp = rospy.Time.now()
                send.publish(stop)

    # Grasping.

    def pick(self, what, lift=0.0, planning_time=0.0, wait=True, timeout=None, place_at=None, any_yaw=True,
             frame=None):
        """Grasps an object of the scene, by its name or label, and lifts it [m] (0: the node's parameter).

        "both": the arm that reaches it better. place_at: a pose, or a list of poses, where it will be placed later,
        as for place(); only grasps count from which one of them can be reached. Returns extperfc/PickResult, or a Motion
        with wait=False.
        """
        places = place_at if isinstance(place_at, list) else [] if place_at is None else [place_at]
        goal = extperfc.msg.PickGoal(what, self._arm_name(), float(lift), float(planning_time),
                                     [self._pose_stamped(pose, frame) for pose in places], bool(any_yaw))
        return self._ended(self._send("pick", extperfc.msg.PickAction, goal), wait, timeout)

    def place(self, pose, what="", any_yaw=True, frame=None, retreat=0.0, planning_time=0.0, wait=True,
              timeout=None):
        """Places the held object. pose: of the object; any_yaw: any rotation about the vertical is accepted.
        retreat: back from it after opening [m], 0: the node's parameter. Returns extperfc/PlaceResult, or a Motion."""
        goal = extperfc.msg.PlaceGoal(what, self._arm_name(), self._pose_stamped(pose, frame), bool(any_yaw),
                                      float(retreat), float(planning_time))
        return self._ended(self._send("place", extperfc.msg.PlaceAction, goal), wait, timeout)

    def open(self, percent=OPEN_PERCENT, timeout=10.0):
        """Opens the gripper, of both arms one after the other, to a percentage of its opening."""
        for side in self.sides:
            self._grip(side, percent, timeout)

    def close(self, timeout=10.0):
        """Closes it. Returns True if an object is between the fingers, for both arms: of either."""
        ends = [self._grip(side, CLOSED_PERCENT, timeout) for side in self.sides]
        return any(end.stalled and end.position > EMPTY_PERCENT for end in ends)

    # State.

    @property
    def joints(self):
        """{joint: radians} as last heard from the robot."""
        return self._joint_states.of([joint for side in self.sides for joint in self.hands[side].joints], self.wait_s)

    def tool_pose(self, frame=None):
        """geometry_msgs/PoseStamped of the tool in a frame, by tf; good as a goal, too."""
        frame = frame or self.hands.frame
        found = robot_state.frames().lookup(frame, self.hands[self._one_side("tool_pose")].tip, self.wait_s)
        pose = geometry_msgs.msg.PoseStamped()
        pose.header.frame_id = frame  # stamp 0: as a goal it means now
        t = found.transform.translation
        pose.pose.position, pose.pose.orientation = geometry_msgs.msg.Point(t.x, t.y, t.z), found.transform.rotation
        return pose

    def solve_ik(self, pose, frame=None, seed=None, avoid_collisions=True):
        """{joint: radians} that bring the tool to a pose; seed: near these (none: near the present state)."""
        side = self._one_side("solve_ik")
        request = goals.motion_request(side, [pose], goals.MotionOptions(frame=frame or ""), False, self._rotation_now, self.hands)
        answer = self._call("arm/solve_ik", extperfc.srv.SolveArmIk, group=self.hands.group(side), goal=request.tool_goals[0],
                            seed=goals.joint_state(seed or {}, side, self.hands), avoid_collisions=bool(avoid_collisions))
        if answer.code != 0:
            raise ArmError(answer.code, answer.message, answer)
        return dict(zip(answer.joints.name, answer.joints.position))

    def check(self, joints=None):
        """Is a state free of collisions and within limits? Joints not named are where they are. Returns a StateCheck."""
        answer = self._call("arm/check_state", extperfc.srv.CheckArmState, group=self.hands.group(self.side),
                            joints=goals.joint_state(joints or {}, self.side, self.hands))
        return StateCheck(answer.code == 0, answer.code, answer.message, answer.first, answer.second, answer.distance)

    def keep_level(self, frame=None):
        """Constraints: keeps the held object upright (along the vertical of `frame`)."""
        return [goals.keep_axis(self._rotation_now(side, frame).T @ numpy.array([0.0, 0.0, 1.0]), self.hands[side].tip)
                for side in self.sides]

    # Implementation.

    def _one_side(self, what):
        if len(self.sides) > 1:
            raise ValueError(f"{what} needs one arm: " + " or ".join(f"Arm({side!r})" for side in self.sides))
        return self.side

    def _arm_name(self):
        return "" if len(self.sides) > 1 else self.side

    def _pose_stamped(self, pose, frame):
        return goals.pose_stamped(pose, frame or self.hands.frame)

    def _rotation_now(self, side, frame):
        return robot_state.frames().rotation(frame or self.hands.frame, self.hands[side].tip, self.wait_s)

    def _request(self, goal, linear, options):
        return goals.motion_request(self.side, goal, goals.MotionOptions(**options), linear, self._rotation_now, self.hands)

    def _send(self, name, action_type, goal, **more):
        if name not in self._actions:
            self._actions[name] = connection.Action(self.namespace, name, action_type, self.wait_s, **more)
        return self._actions[name].send(goal)

    def _ended(self, motion, wait, timeout):
        return motion.wait(timeout) if wait else motion

    def _move(self, goal, wait, timeout):
        return self._ended(self._send("move_arm", extperfc.msg.MoveArmAction, goal), wait, timeout)

    def _call(self, name, service_type, **fields):
        if name not in self._services:
            self._services[name] = connection.Service(self.namespace, name, service_type, self.wait_s)
        return self._services[name](**fields)

    def _publisher(self, name, message_type):
        """A publisher that has subscribers."""
        if name not in self._publishers:
            self._publishers[name] = rospy.Publisher(connection.join(self.namespace, name), message_type, queue_size=1)
        deadline = time.monotonic() + self.wait_s
        while self._publishers[name].get_num_connections() == 0:
            if time.monotonic() > deadline:
                raise ArmError(ClientCode.NOT_RUNNING,
                               f"no subscriber of {rospy.resolve_name(name)} after {self.wait_s:g} s: {connection.START}")
            time.sleep(0.01)
        return self._publishers[name]

    def _grip(self, side, percent, timeout):
        if not 0 <= percent <= 100:
            raise ValueError(f"opening {percent}: must be from 0 to 100 %")
        goal = control_msgs.msg.GripperCommandGoal()
        goal.command.position, goal.command.max_effort = float(percent), 0.0  # 0: the gripper's setting
        name = self.hands[side].action
        try:
            return self._send(name, control_msgs.msg.GripperCommandAction, goal,
                              start="does the robot have an electric gripper there, and is it enabled?").wait(timeout)
        except ArmError as error:
            if error.code != ClientCode.REJECTED:
                raise
            raise ArmError(extperfc.msg.ArmCode.GRIPPER_FAILED, f"{side} gripper: {error.message}", error.result) from None


def _twist(values, frame):
    array = numpy.asarray(values, float)
    if array.shape != (6,) or not numpy.all(numpy.isfinite(array)):
        raise ValueError(f"twist: {values!r} should be six numbers")
    message = geometry_msgs.msg.TwistStamped()
    message.header.frame_id = frame
    message.twist.linear = geometry_msgs.msg.Vector3(*array[:3].tolist())
    message.twist.angular = geometry_msgs.msg.Vector3(*array[3:].tolist())
    return message


def _joint_jog(joints, side, hands):
    state = goals.joint_state(joints, side, hands)
    if not state.name:
        raise ValueError("jog: no joints")
    return control_msgs.msg.JointJog(joint_names=list(state.name), velocities=list(state.position))
