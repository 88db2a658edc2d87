"""Markers that look like links of a robot."""

import numpy
import std_msgs.msg
from geometry_msgs.msg import Point, Pose, Vector3
from visualization_msgs.msg import Marker, MarkerArray

from extperfc.arm.goals import pose_of_matrix

KINDS = {"box": Marker.CUBE, "cylinder": Marker.CYLINDER, "sphere": Marker.SPHERE, "mesh": Marker.MESH_RESOURCE}


def colour(rgba):
    return std_msgs.msg.ColorRGBA(*(float(v) for v in rgba))


def scale_of(shape):
    """Marker.scale of a robot_description.Shape."""
    if shape.kind == "cylinder":
        radius, length = shape.size
        return Vector3(2 * radius, 2 * radius, length)
    if shape.kind == "sphere":
        return Vector3(*(2 * shape.size[0],) * 3)
    return Vector3(*shape.size)


def mesh_address(name):
    """rviz reads package:// and file:// addresses."""
    return name if "://" in name else "file://" + name


def marker(frame, namespace, number, kind, rgba, scale, pose=None):
    """A marker that stays where its frame goes."""
    made = Marker(ns=namespace, id=number, type=kind, action=Marker.ADD, color=colour(rgba), scale=scale,
                  frame_locked=True)
    made.header.frame_id = frame
    made.pose = pose if pose is not None else pose_of_matrix(numpy.eye(4))
    return made


def text_marker(frame, namespace, number, text, xyz, rgba, height=0.045):
    """Text above a point [m] that faces the viewer."""
    pose = Pose(position=Point(*(float(v) for v in xyz)))
    pose.orientation.w = 1.0
    made = marker(frame, namespace, number, Marker.TEXT_VIEW_FACING, rgba, Vector3(0, 0, height), pose)
    made.text = text
    return made


def line_marker(frame, namespace, number, points, rgba, width=0.006):
    """A line through points (N, 3) [m]."""
    made = marker(frame, namespace, number, Marker.LINE_STRIP, rgba, Vector3(width, 0, 0))
    made.points = [Point(*(float(v) for v in point)) for point in points]
    return made



class Ghost:
    """Some links of a robot as see-through markers, in the frame of the robot's root."""

    def __init__(self, robot, link_names, namespace):
        self._robot, self.namespace = robot, namespace
        self._parts = [(name, shape) for name in link_names for shape in robot.links[name].shapes()]

    def markers(self, values, rgba):
        """For joint values by name [rad, m]. rgba: of all parts; None for r, g, b leaves them their own colours."""
        root_T_link = self._robot.link_poses(values)
        made = []
        for number, (link, shape) in enumerate(self._parts):
            own = shape.rgba[:3] if rgba[0] is None else rgba[:3]
            part = marker(self._robot.root, self.namespace, number, KINDS[shape.kind], (*own, rgba[3]), scale_of(shape),
                          pose_of_matrix(root_T_link[link] @ shape.link_T_shape))
            if shape.kind == "mesh":
                part.mesh_resource = mesh_address(shape.mesh)
            made.append(part)
        return made

    def removals(self):
        """Markers that take the ghost away. With a frame, since rviz lets those without one overtake others."""
        made = [Marker(ns=self.namespace, id=number, action=Marker.DELETE) for number in range(len(self._parts))]
        for part in made:
            part.header.frame_id = self._robot.root
        return made


def array(markers):
    return MarkerArray(list(markers))
