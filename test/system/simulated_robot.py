"""Starts a simulated robot for a test case."""

import os
import tempfile
import time

import rospy
from ros_session import RosSession

DEADLINE_S = 120.0  # of what health is waited to say
QUICK = 4.0  # simulated seconds per second where only the end of a motion matters


class Supervised:
    """Of test cases that wait for what health says: they have a `session` and a robot_health.Listener `listener`."""

    @classmethod
    def wait(cls, condition, what):
        deadline = time.monotonic() + DEADLINE_S
        while not condition():
            if time.monotonic() > deadline or not cls.session.alive():
                raise AssertionError(f"waited for {what}: {cls.listener.summary}, {cls.session.errors()}")
            time.sleep(0.02)


def launch(case, node, launch_file, separate_master=False, **arguments):
    """The RosSession of a launch file, in which the caller is the ROS node `node`, in simulated time. It ends with the
    tests of the class `case`. separate_master: one that can end without the launch."""
    folder = tempfile.TemporaryDirectory()
    case.addClassCleanup(folder.cleanup)
    session = RosSession(os.path.join(folder.name, "log"))
    case.addClassCleanup(session.close)
    if separate_master:
        session.start_master()
    session.launch("extperfc", launch_file, rviz="false", **arguments)
    session.join(node)
    return session


def set_pace(factor):
    """Simulated seconds per second from now on: QUICK, or 1 where the time of a reaction matters."""
    from extperfc.srv import SetRealTimeFactor
    rospy.wait_for_service("sim/set_real_time_factor", 30)
    answer = rospy.ServiceProxy("sim/set_real_time_factor", SetRealTimeFactor)(factor)
    assert answer.success, answer.message
