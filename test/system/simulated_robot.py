"""Starts a simulated robot for a test case."""

import os
import tempfile

import rospy
from demo import wait_for_master
from ros_session import RosSession

QUICK = 4.0  # simulated seconds per second where only the end of a motion matters


def launch(case, node, launch_file, **arguments):
    """The RosSession of a launch file, in which the caller is the ROS node `node`, in simulated time. It ends with the
    tests of the class `case`."""
    folder = tempfile.TemporaryDirectory()
    case.addClassCleanup(folder.cleanup)
    session = RosSession(os.path.join(folder.name, "log"))
    case.addClassCleanup(session.close)
    session.launch("extperfc", launch_file, rviz="false", **arguments)
    wait_for_master(session)
    rospy.set_param("/use_sim_time", True)  # the launch may not have come to it yet, and a node asks once
    rospy.init_node(node, disable_signals=True)
    return session


def set_pace(factor):
    """Simulated seconds per second from now on: QUICK, or 1 where the time of a reaction matters."""
    from extperfc.srv import SetRealTimeFactor
    rospy.wait_for_service("sim/set_real_time_factor", 30)
    answer = rospy.ServiceProxy("sim/set_real_time_factor", SetRealTimeFactor)(factor)
    assert answer.success, answer.message
