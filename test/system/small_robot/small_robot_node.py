#!/usr/bin/python3
"""A differential base with a planar lidar and an arm that stands still, in the room of drawn_room.py.

  reads      cmd_vel
  publishes  odom, tf odom -> base_footprint, scan, robot/joint_states
"""

import math
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))

import rospy  # noqa: E402
import tf2_ros  # noqa: E402
from geometry_msgs.msg import TransformStamped, Twist  # noqa: E402
from nav_msgs.msg import Odometry  # noqa: E402
from sensor_msgs.msg import JointState, LaserScan  # noqa: E402

from drawn_room import ANGLES, compose, ranges_from  # noqa: E402

RATE_HZ = 50
SCAN_EVERY = 5     # steps
TIMEOUT_S = 0.3    # after the last command the base stands
JOINTS = ("shoulder", "elbow")


class SmallRobot:
    def __init__(self):
        self.pose, self.command, self.commanded = (0.0, 0.0, 0.0), (0.0, 0.0), rospy.Time()
        self.odom = rospy.Publisher("odom", Odometry, queue_size=5)
        self.scan = rospy.Publisher("scan", LaserScan, queue_size=2)
        self.joints = rospy.Publisher("robot/joint_states", JointState, queue_size=5)
        self.broadcaster = tf2_ros.TransformBroadcaster()
        rospy.Subscriber("cmd_vel", Twist, self.on_command, queue_size=1)

    def on_command(self, twist):
        """linear.y is lost: two wheels cannot move sideways."""
        self.command, self.commanded = (twist.linear.x, twist.angular.z), rospy.Time.now()

    def run(self):
        rate, step = rospy.Rate(RATE_HZ), 0
        while not rospy.is_shutdown():
            now = rospy.Time.now()
            speed, yaw_rate = self.command if (now - self.commanded).to_sec() < TIMEOUT_S else (0.0, 0.0)
            self.pose = compose(self.pose, (speed / RATE_HZ, 0.0, yaw_rate / RATE_HZ))
            self.publish_pose(now, speed, yaw_rate)
            self.joints.publish(JointState(name=JOINTS, position=[0.0, 0.0], header=self.header(now, "")))
            if step % SCAN_EVERY == 0:
                self.publish_scan(now)
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
