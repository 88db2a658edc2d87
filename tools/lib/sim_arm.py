"""An arm of the simulated robot, moved to poses of its gripper: inverse kinematics by the robot's description, and
motions by its trajectory action. Collisions are not looked at: kinematic arms (dynamic:=false) pass through
everything that is fixed."""

import math

import numpy

from extperfc import robot_description as rd

JOINTS = ("s0", "s1", "e0", "e1", "w0", "w1", "w2")
NEUTRAL = {"left": (0.0, -0.55, 0.0, 0.75, 0.0, 1.26, 0.0), "right": (0.0, -0.55, 0.0, 0.75, 0.0, 1.26, 0.0)}
MAX_STEPS = 80
DAMPING = 1e-3
REACHED_M, REACHED_RAD = 1e-4, 1e-3
LIMIT_MARGIN_RAD = 0.02
SPEED_RAD_S = 0.7
SETTLE_S = 0.6  # of simulated time


def rotation_vector(rotation):
    """Axis times angle of a 3 x 3 rotation [rad]."""
    x, y, z, w = rd.quaternion_of_rotation(rotation)
    length = math.sqrt(x * x + y * y + z * z)
    return numpy.array([x, y, z]) * (2 * math.atan2(length, w) / length if length > 1e-12 else 2.0)


class ArmKinematics:
    """base_T_gripper of an arm of a robot_description.RobotDescription, and the joints for one."""

    def __init__(self, robot, side, base="base"):
        above = {joint.child: joint for joint in robot.joints.values()}
        chain, link = [], f"{side}_gripper"
        while link != robot.root:
            chain.append(above[link])
            link = above[link].parent
        self.names = [f"{side}_{joint}" for joint in JOINTS]
        self._chain = chain[::-1]  # from the root to the gripper
        self._base_T_root = rd.inverse(robot.link_poses({})[base])
        moving = [robot.joints[name] for name in self.names]
        self.lower = numpy.array([joint.lower for joint in moving]) + LIMIT_MARGIN_RAD
        self.upper = numpy.array([joint.upper for joint in moving]) - LIMIT_MARGIN_RAD
        self.neutral = numpy.array(NEUTRAL[side])

    def forward(self, positions):
        """base_T_gripper, and 6 x 7 derivatives: translation and rotation in the base's axes."""
        pose, axes, origins = self._base_T_root, [], []
        values = dict(zip(self.names, positions))
        for joint in self._chain:
            if joint.name in values:
                at = pose @ joint.parent_T_joint
                axes.append(at[:3, :3] @ joint.axis)
                origins.append(at[:3, 3])
            pose = pose @ joint.parent_T_child(values.get(joint.name, 0.0))
        axes = numpy.array(axes)
        return pose, numpy.concatenate([numpy.cross(axes, pose[:3, 3] - numpy.array(origins)), axes], axis=1).T

    def inverse(self, base_T_gripper, start):
        """7 joint positions [rad] near `start`, within the limits; None when the iteration (damped least squares)
        does not come there."""
        positions = numpy.clip(start, self.lower, self.upper)
        for _ in range(MAX_STEPS):
            pose, jacobian = self.forward(positions)
            error = numpy.concatenate([base_T_gripper[:3, 3] - pose[:3, 3],
                                       rotation_vector(base_T_gripper[:3, :3] @ pose[:3, :3].T)])
            if numpy.linalg.norm(error[:3]) < REACHED_M and numpy.linalg.norm(error[3:]) < REACHED_RAD:
                return positions
            step = jacobian.T @ numpy.linalg.solve(jacobian @ jacobian.T + DAMPING * numpy.eye(6), error)
            positions = numpy.clip(positions + step * min(1.0, 0.5 / numpy.abs(step).max()), self.lower, self.upper)
        return None

    def solve(self, base_T_gripper, random, tries=6, start=None):
        """7 joint positions [rad] from several starts, drawn from a numpy Generator after `start` and neutral; None:
        none."""
        for tried in range(tries):
            first = [self.neutral] if start is None else [start, self.neutral]
            begin = first[tried] if tried < len(first) else random.uniform(self.lower, self.upper)
            found = self.inverse(base_T_gripper, begin)
            if found is not None:
                return found
        return None


class SimArm:
    """Moves one arm and its gripper; call after rospy.init_node. `wait(condition, what)` waits until a condition
    holds, `now()` is the simulated time [s]."""

    def __init__(self, robot, side, wait, now):
        import actionlib
        import control_msgs.msg
        import rospy

        from extperfc.arm.robot_state import joints
        self.rospy, self.control, self.wait, self.now = rospy, control_msgs.msg, wait, now
        self.kinematics, self.link = ArmKinematics(robot, side), f"{side}_gripper"
        self._joints = joints()
        self._arm = actionlib.SimpleActionClient(f"robot/limb/{side}/follow_joint_trajectory",
                                                 control_msgs.msg.FollowJointTrajectoryAction)
        self._gripper = actionlib.SimpleActionClient(f"robot/end_effector/{side}_gripper/gripper_action",
                                                     control_msgs.msg.GripperCommandAction)
        wait(lambda: now() > 0, "simulated time")  # without it the next line would wait for ever
        for client, what in ((self._arm, "the arm's action"), (self._gripper, "the gripper's action")):
            wait(lambda client=client: client.wait_for_server(rospy.Duration(0.001)), what)

    def positions(self):
        """7 joint positions [rad] as last heard."""
        found = self._joints.of(tuple(self.kinematics.names), 30.0)
        return numpy.array([found[name] for name in self.kinematics.names])

    def move(self, positions):
        """To 7 joint positions [rad] along a cubic; returns when the arm has come to rest there."""
        import trajectory_msgs.msg
        distance_rad = numpy.abs(positions - self.positions()).max()
        point = trajectory_msgs.msg.JointTrajectoryPoint(positions=list(map(float, positions)),
                                                         velocities=[0.0] * len(positions))
        point.time_from_start = self.rospy.Duration(1.5 * distance_rad / SPEED_RAD_S + 0.3)
        goal = self.control.FollowJointTrajectoryGoal()
        goal.trajectory.joint_names, goal.trajectory.points = self.kinematics.names, [point]
        self._act(self._arm, goal, "the arm to move")
        rest_s = self.now() + SETTLE_S
        self.wait(lambda: self.now() >= rest_s, "the arm to come to rest")

    def grip(self, percent):
        """Opens (100) or closes (0) the gripper."""
        goal = self.control.GripperCommandGoal()
        goal.command.position = float(percent)
        self._act(self._gripper, goal, "the gripper to move")

    def _act(self, client, goal, what):
        ended = []
        client.send_goal(goal, done_cb=lambda *_: ended.append(True))
        self.wait(lambda: ended, what)
