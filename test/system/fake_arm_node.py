#!/usr/bin/python3
"""A stand-in for the arm node and the robot: joints, inverse kinematics, plans that are straight in joint values, a table.

  fake_arm_node.py URDF [--tf]

--tf: frames of the grippers, which otherwise another node computes from the joints.
Everything below z = -0.3 m in `base` collides with "the table", which only the tools' origins touch. Motions take a
quarter of their time; how each ended is published on motion_ended.
"""

import pathlib
import sys
import threading
import time

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "src"))

import actionlib  # noqa: E402
import numpy  # noqa: E402
import rospy  # noqa: E402
import tf2_ros  # noqa: E402
from control_msgs.msg import GripperCommandAction, GripperCommandResult  # noqa: E402
from geometry_msgs.msg import TransformStamped  # noqa: E402
from sensor_msgs.msg import JointState  # noqa: E402
from std_msgs.msg import String  # noqa: E402
from std_srvs.srv import Trigger  # noqa: E402
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint  # noqa: E402

import extperfc.msg  # noqa: E402
import extperfc.srv  # noqa: E402
from extperfc import robot_description as rd  # noqa: E402
from extperfc.arm import goals  # noqa: E402
from extperfc.arm.hands import BAXTER  # noqa: E402
from extperfc.msg import ArmCode  # noqa: E402

TABLE_Z_M = -0.3
STATES = {"neutral": (0, -0.55, 0, 0.75, 0, 1.26, 0), "untuck": (-0.08, -1.0, -1.19, 1.94, 0.67, 1.03, -0.5)}
NAMES = ("s0", "s1", "e0", "e1", "w0", "w1", "w2")


class Chain:
    """One arm: forward kinematics and a damped least-squares search."""

    def __init__(self, robot, tip):
        self.names = robot.joints_above(tip)
        links, link = [], tip
        while link != "base":
            joint, = [joint for joint in robot.joints.values() if joint.child == link]
            links.append(joint)
            link = joint.parent
        self.joints = links[::-1]
        self.lower = numpy.array([robot.joints[n].lower for n in self.names])
        self.upper = numpy.array([robot.joints[n].upper for n in self.names])

    def forward(self, values):
        """base_T_tip and the Jacobian (6, N) in base."""
        pose, at = numpy.eye(4), []
        for joint in self.joints:
            pose = pose @ joint.parent_T_child(0.0 if joint.kind == "fixed" else values[self.names.index(joint.name)])
            if joint.kind != "fixed":
                at.append((pose[:3, :3] @ joint.axis, pose[:3, 3]))
        rows = [numpy.concatenate([numpy.cross(axis, pose[:3, 3] - origin), axis]) for axis, origin in at]
        return pose, numpy.array(rows).T

    def inverse(self, goal, seed):
        """Joint values within 1 mm and 0.01 rad of a base_T_tip, or None."""
        q = numpy.clip(numpy.array(seed, float), self.lower, self.upper)
        for _ in range(150):
            pose, jacobian = self.forward(q)
            rotation = goal[:3, :3] @ pose[:3, :3].T
            vector = numpy.array([rotation[2, 1] - rotation[1, 2], rotation[0, 2] - rotation[2, 0], rotation[1, 0] - rotation[0, 1]]) / 2
            error = numpy.concatenate([goal[:3, 3] - pose[:3, 3], vector])
            if numpy.linalg.norm(error[:3]) < 1e-3 and numpy.linalg.norm(error[3:]) < 1e-2 and numpy.trace(rotation) > 0:
                return q
            step = jacobian.T @ numpy.linalg.solve(jacobian @ jacobian.T + 1e-3 * numpy.eye(6), error)
            q = numpy.clip(q + step, self.lower, self.upper)
        return None


class FakeArms:
    def __init__(self, urdf):
        robot = rd.RobotDescription.from_file(urdf)
        rospy.set_param("robot_description", pathlib.Path(urdf).read_text())
        self.chains = {side: Chain(robot, BAXTER[side].tip) for side in BAXTER.names}
        self.lock = threading.Lock()
        self.others = {j.name: robot.value_of(j, {}) for j in robot.joints.values() if j.kind != "fixed" and not j.mimic}
        self.values = {f"{side}_{n}": self.state_value("untuck", side, i) for side in BAXTER.names for i, n in enumerate(NAMES)}
        self.shown = rospy.Publisher("arm/display_trajectory", JointTrajectory, queue_size=1, latch=True)
        self.states = rospy.Publisher("robot/joint_states", JointState, queue_size=10)
        self.ends = rospy.Publisher("motion_ended", String, queue_size=10)
        self.frames = tf2_ros.TransformBroadcaster() if "--tf" in rospy.myargv() else None
        self.stop = threading.Event()
        rospy.Service("arm/solve_ik", extperfc.srv.SolveArmIk, self.on_ik)
        rospy.Service("arm/stop", Trigger, self.on_stop)
        self.servers = [self.serve("plan", extperfc.msg.PlanAction, self.on_plan),
                        self.serve("move_arm", extperfc.msg.MoveArmAction, self.on_move)]
        for side in BAXTER.names:
            name = f"robot/end_effector/{side}_gripper/gripper_action"
            self.servers.append(self.serve(name, GripperCommandAction, lambda goal: GripperCommandResult(
                position=goal.command.position, reached_goal=True)))

    @staticmethod
    def state_value(name, side, i):
        mirrored = side == "right" and name == "untuck" and i % 2 == 0
        return -STATES[name][i] if mirrored else float(STATES[name][i])

    def serve(self, name, kind, work):
        def execute(goal):
            result = work(goal)
            code = getattr(result, "code", 0)
            (server.set_succeeded if code == 0 else server.set_aborted)(result)
        server = actionlib.SimpleActionServer(name, kind, execute, False)
        server.start()
        return server

    def publish(self):
        with self.lock:
            joints = {**self.others, **self.values}
        message = JointState(name=list(joints), position=list(joints.values()))
        message.header.stamp = rospy.Time.now()
        self.states.publish(message)
        for side in BAXTER.names if self.frames else ():
            self.publish_frame(side, joints, message.header.stamp)

    def publish_frame(self, side, joints, stamp):
        chain, made = self.chains[side], TransformStamped(child_frame_id=BAXTER[side].tip)
        pose = goals.pose_of_matrix(chain.forward([joints[n] for n in chain.names])[0])
        made.header.stamp, made.header.frame_id = stamp, "base"
        made.transform.translation.x, made.transform.translation.y = pose.position.x, pose.position.y
        made.transform.translation.z, made.transform.rotation = pose.position.z, pose.orientation
        self.frames.sendTransform(made)

    def on_ik(self, request):
        side = "left" if request.group == "left_arm" else "right"
        chain, answer = self.chains[side], extperfc.srv.SolveArmIkResponse()
        with self.lock:
            known = {**self.values, **dict(zip(request.seed.name, request.seed.position))}
        goal = goals.matrix_of_pose(request.goal.pose)
        found = chain.inverse(goal, [known[n] for n in chain.names])
        if found is None:
            answer.code, answer.message = ArmCode.GOAL_UNREACHABLE, "no joint values bring the tool there: out of reach"
        elif request.avoid_collisions and goal[2, 3] < TABLE_Z_M:
            answer.code, answer.message = ArmCode.GOAL_IN_COLLISION, f"{side}_gripper collides with the table"
        else:
            answer.joints = JointState(name=chain.names, position=found.tolist())
        return answer

    def on_stop(self, _):
        self.stop.set()
        return True, "stopped"

    def goal_values(self, request):
        """Joint values of a request, or a code and a message."""
        values = dict(zip(request.joint_goal.name, request.joint_goal.position))
        sides = [side for side in BAXTER.names if request.group in (BAXTER.group(side), "both_arms")]
        if request.named_state:
            if request.named_state not in STATES:
                return ArmCode.INVALID_REQUEST, f"no state {request.named_state}"
            values = {f"{s}_{n}": self.state_value(request.named_state, s, i) for s in sides for i, n in enumerate(NAMES)}
        for tool in request.tool_goals:
            side = tool.link.split("_")[0]
            answer = self.on_ik(extperfc.srv.SolveArmIkRequest(group=BAXTER.group(side), goal=tool, avoid_collisions=True))
            if answer.code:
                return answer.code, answer.message
            values.update(zip(answer.joints.name, answer.joints.position))
        return 0, values

    def on_plan(self, goal):
        code, values = self.goal_values(goal.request)
        if code:
            return extperfc.msg.PlanResult(code=code, message=values)
        with self.lock:
            begin = [self.values[n] for n in values]
        duration = max(0.5, max(abs(a - b) for a, b in zip(values.values(), begin)) / 0.5) / (goal.request.velocity_scale or 1.0)
        trajectory = JointTrajectory(joint_names=list(values))
        for positions, time_s in ((begin, 0.0), (list(values.values()), duration)):
            trajectory.points.append(JointTrajectoryPoint(positions=positions, time_from_start=rospy.Duration(time_s)))
        self.shown.publish(trajectory)
        return extperfc.msg.PlanResult(trajectory=trajectory, fraction=1.0, planning_time=0.002, message="straight")

    def on_move(self, goal):
        trajectory = goal.trajectory
        if not trajectory.points:
            planned = self.on_plan(extperfc.msg.PlanGoal(goal.request))
            if planned.code:
                return extperfc.msg.MoveArmResult(code=planned.code, message=planned.message)
            trajectory = planned.trajectory
        begin, end = (numpy.array(trajectory.points[i].positions) for i in (0, -1))
        self.stop.clear()
        server, steps = self.servers[1], max(2, int(trajectory.points[-1].time_from_start.to_sec() / 4 / 0.02))
        for i in range(steps + 1):
            if self.stop.wait(0.02) or server.is_preempt_requested():
                self.ends.publish("cancelled")
                return extperfc.msg.MoveArmResult(code=ArmCode.CANCELLED, message="stopped before the end", executed=i / steps)
            with self.lock:
                self.values.update(zip(trajectory.joint_names, (begin + (end - begin) * i / steps).tolist()))
            self.publish()
            server.publish_feedback(extperfc.msg.MoveArmFeedback("executing", i / steps))
        self.ends.publish("there")
        return extperfc.msg.MoveArmResult(message="there", trajectory=trajectory, executed=1.0)


def main():
    rospy.init_node("fake_arms")
    arms = FakeArms(rospy.myargv()[1])
    while not rospy.is_shutdown():
        arms.publish()
        time.sleep(0.05)


if __name__ == "__main__":
    main()
