"""What health says of the robot of bringup.launch, and whether its parts work."""

import threading
import time

import rospy
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus

from extperfc.srv import GetScene

SIMULATOR = "/robot_manager"
NODES = {  # node: the parts that end with it, and a topic that shows that they work again
    SIMULATOR: (("simulator",), "odom"),
    "/robot_state_publisher": (("robot_state_publisher",), "tf_static"),
    "/camera_manager": (("detector", "box_depth"), "detections_3d"),
    "/lidar_manager": (("cloud_to_scan",), "scan"),
    "/cloud_to_scan": (("cloud_to_scan",), "scan"),
    "/mapping_manager": (("mapper",), "pose"),
    "/navigator": (("navigator",), "navigation_status"),
    "/navigation_manager": (("navigator", "cmd_vel_mux"), "navigation_status"),
    "/arm_manager": (("arm",), None),  # its service arm/get_scene does
}
TRANSLATOR = {"/translator": (("translator",), "odom")}  # as NODES, where the robot is at another master


class Listener:
    """What health publishes, and when topics, by default those of NODES, brought a message (time.monotonic())."""

    def __init__(self, topics=tuple({topic for _, topic in NODES.values() if topic})):
        self.summary, self.messages, self.tree, self.arrivals = None, [], [], {}
        self.lock = threading.Lock()
        rospy.Subscriber("diagnostics_toplevel_state", DiagnosticStatus, self._on_summary)
        rospy.Subscriber("diagnostics_agg", DiagnosticArray, self._on_tree)
        for topic in topics:
            rospy.Subscriber(topic, rospy.AnyMsg, self._on_message, topic)

    def _on_summary(self, message):
        with self.lock:
            self.summary = message
            self.messages.append(message)

    def _on_tree(self, message):
        self.tree = message.status

    def _on_message(self, _, topic):
        self.arrivals[topic] = time.monotonic()

    def since(self, count):
        with self.lock:
            return self.messages[count:]

    @property
    def complete(self):
        return self.summary is not None and self.summary.level == DiagnosticStatus.OK

    def well(self, but=()):
        """Complete, but for warnings of these parts."""
        title, _, parts = self.summary.message.partition(": ") if self.summary else ("", "", "")
        return self.complete or (title == "warning" and set(parts.split(", ")) <= set(but))

    def works(self, topic, since, wait_s):
        """Whether a message came on the topic, or without one the arm's scene can be asked for."""
        if topic:
            return self.arrivals.get(topic, 0) > since
        rospy.wait_for_service("arm/get_scene", wait_s)
        return rospy.ServiceProxy("arm/get_scene", GetScene)() is not None


def named(message, title, part):
    """Whether a summary names the part under this title, e.g. missing."""
    sections = dict(section.split(": ", 1) for section in message.split("; ") if ": " in section)
    return part in sections.get(title, "").split(", ")


def runs(message, part):
    return not any(named(message, title, part) for title in ("missing", "silent", "starting", "refuses to start"))
