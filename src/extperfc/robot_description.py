"""A robot's description (URDF) as data, and forward kinematics.

Transforms are 4x4 arrays named target_T_source; lengths in metres, angles in radians. No ROS is needed.
"""

import dataclasses
import math
import pathlib
import xml.etree.ElementTree

import numpy


def rotation_of_rpy(roll, pitch, yaw):
    """3x3 rotation: about the fixed x, then y, then z axis [rad]."""
    cr, sr, cp, sp, cy, sy = (f(a) for a in (roll, pitch, yaw) for f in (math.cos, math.sin))
    return numpy.array([[cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
                        [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
                        [-sp, cp * sr, cp * cr]])


def rotation_of_quaternion(x, y, z, w):
    """3x3 rotation of a quaternion of any length but 0. Raises ValueError."""
    norm = math.sqrt(x * x + y * y + z * z + w * w)
    if not (math.isfinite(norm) and norm > 1e-9):
        raise ValueError(f"({x}, {y}, {z}, {w}) is no quaternion of a rotation")
    x, y, z, w = x / norm, y / norm, z / norm, w / norm
    return numpy.array([[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
                        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
                        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]])


def quaternion_of_rotation(rotation):
    """(x, y, z, w) with w >= 0 of a 3x3 rotation, from the largest of the four, so that nothing small is divided by."""
    r = numpy.asarray(rotation, float)
    squares = numpy.array([1 + r[0, 0] - r[1, 1] - r[2, 2], 1 - r[0, 0] + r[1, 1] - r[2, 2],
                           1 - r[0, 0] - r[1, 1] + r[2, 2], 1 + r[0, 0] + r[1, 1] + r[2, 2]])  # 4x^2, 4y^2, 4z^2, 4w^2
    xw, yw, zw = r[2, 1] - r[1, 2], r[0, 2] - r[2, 0], r[1, 0] - r[0, 1]
    xy, xz, yz = r[1, 0] + r[0, 1], r[0, 2] + r[2, 0], r[2, 1] + r[1, 2]
    rows = numpy.array([[squares[0], xy, xz, xw], [xy, squares[1], yz, yw], [xz, yz, squares[2], zw],
                        [xw, yw, zw, squares[3]]])  # 4 q q^T
    q = rows[numpy.argmax(squares)]
    q = q / numpy.linalg.norm(q)
    return tuple(float(v) for v in (q if q[3] >= 0 else -q))


def transform(xyz=(0, 0, 0), rotation=None):
    """4x4 transform of a translation [m] and a 3x3 rotation."""
    made = numpy.eye(4)
    made[:3, 3] = xyz
    if rotation is not None:
        made[:3, :3] = rotation
    return made


def inverse(target_T_source):
    rotation = target_T_source[:3, :3].T
    return transform(-rotation @ target_T_source[:3, 3], rotation)


def rotation_about(axis, angle):
    """3x3 rotation about an axis of length 1 (Rodrigues' formula)."""
    x, y, z = axis
    cross = numpy.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return numpy.eye(3) + math.sin(angle) * cross + (1 - math.cos(angle)) * (cross @ cross)


@dataclasses.dataclass(frozen=True)
class Shape:
    """What a link looks like, or takes part in collisions as."""
    kind: str                   # box, cylinder, sphere, mesh
    size: tuple                 # box: x y z [m]; cylinder: radius, length [m]; sphere: radius [m]; mesh: scale x y z
    link_T_shape: numpy.ndarray
    mesh: str = ""              # file name or package:// address
    rgba: tuple = (0.7, 0.7, 0.7, 1.0)


@dataclasses.dataclass
class Link:
    name: str
    visuals: list
    collisions: list

    def shapes(self):
        """What to draw: its looks or, where it has none, its collision shapes."""
        return self.visuals or self.collisions


@dataclasses.dataclass
class Joint:
    name: str
    kind: str                   # fixed, revolute, continuous, prismatic
    parent: str
    child: str
    parent_T_joint: numpy.ndarray
    axis: numpy.ndarray
    lower: float
    upper: float
    mimic: tuple = None         # (joint, multiplier, offset)

    def parent_T_child(self, value):
        """For a joint value in rad or m."""
        if self.kind == "fixed":
            return self.parent_T_joint
        if self.kind == "prismatic":
            return self.parent_T_joint @ transform(self.axis * value)
        return self.parent_T_joint @ transform(rotation=rotation_about(self.axis, value))


class RobotDescription:
    """Links and joints of a URDF, and where the links are. Raises ValueError where the text describes no tree of links."""

    def __init__(self, urdf):
        root = _parse(urdf)
        materials = {m.get("name"): _rgba(m) for m in root.findall("material") if m.find("color") is not None}
        self.name = root.get("name", "")
        self.links = {e.get("name"): Link(e.get("name"), _shapes(e, "visual", materials), _shapes(e, "collision", {}))
                      for e in root.findall("link")}
        self.joints = {}
        for element in root.findall("joint"):
            joint = _joint(element)
            self.joints[joint.name] = joint
        self._order_joints()

    @classmethod
    def from_file(cls, path):
        return cls(pathlib.Path(path).read_text())

    def _order_joints(self):
        """Parents before children."""
        above = {}
        for joint in self.joints.values():
            if joint.parent not in self.links or joint.child not in self.links:
                raise ValueError(f"joint {joint.name} joins links that the URDF does not have")
            if joint.child in above:
                raise ValueError(f"link {joint.child} has two parents")
            above[joint.child] = joint
        roots = [name for name in self.links if name not in above]
        if len(roots) != 1:
            raise ValueError(f"the URDF has {len(roots)} roots: {', '.join(roots[:5])}")
        self.root, self._above = roots[0], above
        self._below = {name: [] for name in self.links}
        for joint in self.joints.values():
            self._below[joint.parent].append(joint)
        self._ordered, todo = [], [self.root]
        while todo:
            joints = self._below[todo.pop()]
            self._ordered += joints
            todo += [joint.child for joint in joints]
        if len(self._ordered) != len(self.joints):
            raise ValueError("the URDF's joints form a loop")

    def value_of(self, joint, values):
        """A joint's value [rad or m] from a dictionary of values; 0, within its limits, where nothing is said."""
        if joint.mimic is not None and joint.name not in values:
            other, multiplier, offset = joint.mimic
            return multiplier * self.value_of(self.joints[other], values) + offset
        if joint.name in values:
            return float(values[joint.name])
        return min(max(0.0, joint.lower), joint.upper) if joint.lower <= joint.upper else 0.0

    def link_poses(self, values, frame=None):
        """frame_T_link of every link, for joint values by name. `frame`: a link; none: the root."""
        root_T_link = {self.root: numpy.eye(4)}
        for joint in self._ordered:
            root_T_link[joint.child] = root_T_link[joint.parent] @ joint.parent_T_child(self.value_of(joint, values))
        if frame is None or frame == self.root:
            return root_T_link
        frame_T_root = inverse(root_T_link[frame])
        return {name: frame_T_root @ pose for name, pose in root_T_link.items()}

    def joints_above(self, link):
        """Names of the moving joints between the root and a link, in this order."""
        found = []
        while link in self._above:
            joint = self._above[link]
            if joint.kind != "fixed":
                found.append(joint.name)
            link = joint.parent
        return found[::-1]

    def links_below(self, joint_names):
        """Names of the links that move when one of these joints does."""
        found, todo = [], [self.joints[name].child for name in joint_names]
        while todo:
            link = todo.pop()
            if link not in found:
                found.append(link)
                todo += [joint.child for joint in self._below[link]]
        return found


def _parse(urdf):
    try:
        root = xml.etree.ElementTree.fromstring(urdf)
    except xml.etree.ElementTree.ParseError as error:
        raise ValueError(f"this is no URDF: {error}") from None
    if root.tag != "robot":
        raise ValueError(f"this is no URDF: it begins with <{root.tag}>")
    return root


def _numbers(text, count):
    values = tuple(float(token) for token in text.split())
    if len(values) != count or not all(math.isfinite(v) for v in values):
        raise ValueError(f"'{text}' should be {count} numbers")
    return values


def _origin(element):
    origin = element.find("origin")
    if origin is None:
        return numpy.eye(4)
    return transform(_numbers(origin.get("xyz", "0 0 0"), 3), rotation_of_rpy(*_numbers(origin.get("rpy", "0 0 0"), 3)))


def _rgba(element):
    return _numbers(element.find("color").get("rgba"), 4)


def _shapes(link, tag, materials):
    return [shape for shape in (_shape(element, materials) for element in link.findall(tag)) if shape is not None]


def _shape(element, materials):
    geometry = element.find("geometry")
    kind = geometry[0] if geometry is not None and len(geometry) else None
    if kind is None:
        return None
    material = element.find("material")
    rgba = Shape.rgba
    if material is not None:
        rgba = _rgba(material) if material.find("color") is not None else materials.get(material.get("name"), rgba)
    if kind.tag == "box":
        return Shape("box", _numbers(kind.get("size"), 3), _origin(element), rgba=rgba)
    if kind.tag == "cylinder":
        return Shape("cylinder", (float(kind.get("radius")), float(kind.get("length"))), _origin(element), rgba=rgba)
    if kind.tag == "sphere":
        return Shape("sphere", (float(kind.get("radius")),), _origin(element), rgba=rgba)
    if kind.tag == "mesh":
        return Shape("mesh", _numbers(kind.get("scale", "1 1 1"), 3), _origin(element), kind.get("filename"), rgba)
    return None


def _joint(element):
    kind = element.get("type")
    if kind not in ("fixed", "revolute", "continuous", "prismatic"):
        raise ValueError(f"joint {element.get('name')}: type {kind} is not known here")
    axis = element.find("axis")
    axis = numpy.array(_numbers(axis.get("xyz"), 3) if axis is not None else (1.0, 0.0, 0.0))
    length = numpy.linalg.norm(axis)
    if kind != "fixed" and length < 1e-9:
        raise ValueError(f"joint {element.get('name')}: its axis has no direction")
    limit, mimic = element.find("limit"), element.find("mimic")
    lower, upper = (-math.inf, math.inf)
    if limit is not None and kind in ("revolute", "prismatic"):
        lower, upper = float(limit.get("lower", 0)), float(limit.get("upper", 0))
    if mimic is not None:
        mimic = (mimic.get("joint"), float(mimic.get("multiplier", 1)), float(mimic.get("offset", 0)))
    return Joint(element.get("name"), kind, element.find("parent").get("link"), element.find("child").get("link"),
                 _origin(element), axis / length if length > 1e-9 else axis, lower, upper, mimic)
