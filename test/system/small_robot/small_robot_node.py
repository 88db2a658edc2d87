#!/usr/bin/python3
"""A differential base with a planar lidar and an arm with a gripper, in the room of drawn_room.py. On the pillar of PILLAR stands
a cube, which the gripper can hold. Motion without mass: joints are where their trajectory wants them.

  reads      cmd_vel
  publishes  odom, tf odom -> base_footprint, scan, robot/joint_states, truth/cube (geometry_msgs/PoseStamped in odom)
  actions    manipulator/follow_joint_trajectory, claw/gripper_action (positions in per cent of the opening)
"""

import math
import pathlib
import sys
import threading

FOLDER = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(FOLDER.parent))

import actionlib  # noqa: E402
import numpy  # noqa: E402
import rospy  # noqa: E402
import tf2_ros  # noqa: E402
from control_msgs.msg import (FollowJointTrajectoryAction, FollowJointTrajectoryResult, GripperCommandAction,  # noqa: E402
                              GripperCommandResult)
from geometry_msgs.msg import PoseStamped, TransformStamped, Twist  # noqa: E402
from nav_msgs.msg import Odometry  # noqa: E402
from sensor_msgs.msg import JointState, LaserScan  # noqa: E402

from drawn_room import ANGLES, compose, ranges_from  # noqa: E402
from extperfc import robot_description as rd  # noqa: E402
from extperfc.arm.goals import pose_of_matrix  # noqa: E402

RATE_HZ = 50
SCAN_EVERY = 5     # steps
TIMEOUT_S = 0.3    # after the last command the base stands
JOINTS = ("swing", "lean", "bend", "roll", "nod", "twist")
OPEN_M = 0.035     # of each finger
PINCH_M_S = 0.05
PILLAR, PILLAR_TOP_M, CUBE_M = (-0.3, 0.3, 2.7, 3.3), 0.3, 0.04  # x and y of its sides in odom
CUBE_AT = (0.05, 2.85)
START = {"lean": -0.9, "bend": 2.4, "nod": 1.57}  # tucked


class Cube:
    """Stands, or is held."""

    def __init__(self):
        self.odom_T_cube, self._claw_T_cube = rd.transform((*CUBE_AT, PILLAR_TOP_M + CUBE_M / 2)), None

    @property
    def held(self):
        return self._claw_T_cube is not None

    def grip(self, odom_T_claw):
        """The fingers close there. Returns the cube's width between them [m], 0 beside it."""
        claw_T_cube = rd.inverse(odom_T_claw) @ self.odom_T_cube
        along, across, out = numpy.abs(claw_T_cube[:3, 3])
        if along > CUBE_M / 2 or across > OPEN_M - CUBE_M / 2 or out > CUBE_M / 2:
            return 0.0
        self._claw_T_cube = claw_T_cube
        return CUBE_M * float(numpy.abs(claw_T_cube[1, :3]).max() ** -1)

    def carry(self, odom_T_claw):
        if self.held:
            self.odom_T_cube = odom_T_claw @ self._claw_T_cube

    def release(self):
        """It falls onto what is below."""
        if not self.held:
            return
        self._claw_T_cube = None
        x, y = self.odom_T_cube[:2, 3]
        on_pillar = PILLAR[0] < x < PILLAR[1] and PILLAR[2] < y < PILLAR[3]
        self.odom_T_cube[2, 3] = (PILLAR_TOP_M if on_pillar else 0.0) + CUBE_M / 2


class SmallRobot:
    def __init__(self):
        self.pose, self.command, self.commanded = (0.0, 0.0, 0.0), (0.0, 0.0), rospy.Time()
        self.description, self.lock, self.cube = rd.RobotDescription.from_file(FOLDER / "small_robot.urdf"), threading.Lock(), Cube()
        self.values = {**dict.fromkeys(JOINTS, 0.0), **START, "pinch": OPEN_M}
        self.odom = rospy.Publisher("odom", Odometry, queue_size=5)
        self.scan = rospy.Publisher("scan", LaserScan, queue_size=2)
        self.joints = rospy.Publisher("robot/joint_states", JointState, queue_size=5)
        self.truth = rospy.Publisher("truth/cube", PoseStamped, queue_size=5)
        self.broadcaster = tf2_ros.TransformBroadcaster()
        rospy.Subscriber("cmd_vel", Twist, self.on_command, queue_size=1)
        self.arm = actionlib.SimpleActionServer("manipulator/follow_joint_trajectory", FollowJointTrajectoryAction, self.follow, False)
        self.claw = actionlib.SimpleActionServer("claw/gripper_action", GripperCommandAction, self.pinch, False)
        self.arm.start()
        self.claw.start()

    def on_command(self, twist):
        """linear.y is lost: two wheels cannot move sideways."""
        self.command, self.commanded = (twist.linear.x, twist.angular.z), rospy.Time.now()

    def follow(self, goal):
        """Straight between the trajectory's points."""
        trajectory, begin = goal.trajectory, max(goal.trajectory.header.stamp, rospy.Time.now())
        times = [point.time_from_start.to_sec() for point in trajectory.points]
        while not rospy.is_shutdown():
            now_s = (rospy.Time.now() - begin).to_sec()
            if self.arm.is_preempt_requested():
                return self.arm.set_preempted()
            with self.lock:
                for index, name in enumerate(trajectory.joint_names):
                    self.values[name] = float(numpy.interp(now_s, times, [point.positions[index] for point in trajectory.points]))
            if now_s >= times[-1]:
                return self.arm.set_succeeded(FollowJointTrajectoryResult())
            rospy.sleep(1 / RATE_HZ)
        return None

    def pinch(self, goal):
        """Moves the fingers to a percentage of their opening, or to the cube."""
        wanted_m, width_m = OPEN_M * min(100.0, max(0.0, goal.command.position)) / 100, 0.0
        with self.lock:
            if wanted_m < self.values["pinch"] and not self.cube.held:
                width_m = self.cube.grip(self.odom_T_claw())
            elif self.cube.held and wanted_m > CUBE_M / 2:
                self.cube.release()
            elif self.cube.held:
                width_m = CUBE_M
        end_m = max(wanted_m, width_m / 2)
        while not rospy.is_shutdown() and abs(self.values["pinch"] - end_m) > 1e-6:
            if self.claw.is_preempt_requested():
                return self.claw.set_preempted()
            with self.lock:
                step_m = PINCH_M_S / RATE_HZ
                self.values["pinch"] += min(step_m, max(-step_m, end_m - self.values["pinch"]))
            rospy.sleep(1 / RATE_HZ)
        return self.claw.set_succeeded(GripperCommandResult(position=100 * end_m / OPEN_M, stalled=end_m > wanted_m,
                                                            reached_goal=end_m == wanted_m))

    def odom_T_claw(self):
        x, y, yaw = self.pose
        return rd.transform((x, y, 0.0), rd.rotation_of_rpy(0.0, 0.0, yaw)) @ self.description.link_poses(self.values)["claw"]

    def run(self):
        rate, step = rospy.Rate(RATE_HZ), 0
        while not rospy.is_shutdown():
            now = rospy.Time.now()
            speed, yaw_rate = self.command if (now - self.commanded).to_sec() < TIMEOUT_S else (0.0, 0.0)
            with self.lock:
                self.pose = compose(self.pose, (speed / RATE_HZ, 0.0, yaw_rate / RATE_HZ))
                self.cube.carry(self.odom_T_claw())
                values = {**self.values, "other_pinch": self.values["pinch"]}
            self.publish_pose(now, speed, yaw_rate)
            self.joints.publish(JointState(name=list(values), position=list(values.values()), header=self.header(now, "")))
            if step % SCAN_EVERY == 0:
                self.publish_scan(now)
                self.truth.publish(PoseStamped(header=self.header(now, "odom"), pose=pose_of_matrix(self.cube.odom_T_cube)))
            step += 1
            rate.sleep()

    @staticmethod
    def header(stamp, frame):
        return rospy.Header(stamp=stamp, frame_id=frame)

    def publish_pose(self, now, speed, yaw_rate):
        transform = TransformStamped(header=self.header(now, "odom"), child_frame_id="base_footprint")
        transform.transform.translation.x, transform.transform.translation.y = self.pose[:2]
        rotation = transform.transform.rotation
        rotation.z, rotation.w = math.sin(self.pose[2] / 2), math.cos(self.pose[2] / 2)
        self.broadcaster.sendTransform(transform)
        odometry = Odometry(header=transform.header, child_frame_id="base_footprint")
        odometry.pose.pose.position.x, odometry.pose.pose.position.y = self.pose[:2]
        odometry.pose.pose.orientation = rotation
        odometry.twist.twist.linear.x, odometry.twist.twist.angular.z = speed, yaw_rate
        self.odom.publish(odometry)

    def publish_scan(self, now):
        self.scan.publish(LaserScan(
            header=self.header(now, "laser"), angle_min=ANGLES[0], angle_max=ANGLES[-1],
            angle_increment=ANGLES[1] - ANGLES[0], scan_time=SCAN_EVERY / RATE_HZ, range_min=0.05, range_max=30.0,
            ranges=ranges_from(self.pose)))


if __name__ == "__main__":
    rospy.init_node("small_robot")
    try:
        SmallRobot().run()
    except rospy.ROSInterruptException:
        pass
