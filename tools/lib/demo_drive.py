"""Moves the simulated robot's base in the demonstration, so that its camera sees the table from several sides."""

import math
import threading

SWING_M = 0.22    # to each side of where the robot started
PERIOD_S = 12.0   # of one swing
AHEAD_M = 0.95    # the robot keeps looking at the place that lay so far ahead of it at the start
GAIN_1_S = 1.5    # of the correction towards the path


def swing(time_s):
    """Sideways position [m], heading [rad], and both of their rates [m/s, rad/s], as seen from the start."""
    phase = 2 * math.pi * time_s / PERIOD_S
    y, vy = SWING_M * math.sin(phase), SWING_M * 2 * math.pi / PERIOD_S * math.cos(phase)
    return y, -math.atan2(y, AHEAD_M), vy, -vy * AHEAD_M / (AHEAD_M ** 2 + y ** 2)


def command(time_s, x, y, yaw):
    """Velocity vx, vy [m/s], wz [rad/s] in the robot's own frame, for a robot at this pose, as seen from its start."""
    to_y, to_yaw, vy, wz = swing(time_s)
    ahead, side = -GAIN_1_S * x, vy + GAIN_1_S * (to_y - y)
    cos, sin = math.cos(yaw), math.sin(yaw)
    return cos * ahead + sin * side, -sin * ahead + cos * side, wz + GAIN_1_S * (to_yaw - yaw)


class Swing:
    """Drives by cmd_vel as long as the simulation publishes where the robot is (sim/truth/odom)."""

    def __init__(self):
        import geometry_msgs.msg
        import nav_msgs.msg
        import rospy

        self.twist = geometry_msgs.msg.Twist
        self.lock = threading.Lock()  # held while publishing, so that nothing is published after stop()
        self.driving = True
        self.start = None
        self.publisher = rospy.Publisher("cmd_vel", geometry_msgs.msg.Twist, queue_size=1)
        rospy.Subscriber("sim/truth/odom", nav_msgs.msg.Odometry, self._step, queue_size=1)

    def _step(self, message):
        pose, time_s = message.pose.pose, message.header.stamp.to_sec()
        here = (pose.position.x, pose.position.y, 2 * math.atan2(pose.orientation.z, pose.orientation.w), time_s)
        self.start = self.start or here
        x0, y0, yaw0, t0 = self.start
        dx, dy = here[0] - x0, here[1] - y0
        x, y = math.cos(yaw0) * dx + math.sin(yaw0) * dy, -math.sin(yaw0) * dx + math.cos(yaw0) * dy
        turned = math.remainder(here[2] - yaw0, 2 * math.pi)
        velocity = self.twist()
        velocity.linear.x, velocity.linear.y, velocity.angular.z = command(time_s - t0, x, y, turned)
        with self.lock:
            if self.driving:
                self.publisher.publish(velocity)

    def stop(self):
        """Call before the node shuts down; the base stops by itself when no command comes."""
        with self.lock:
            self.driving = False
