"""The planning scene: collision objects and objects that grippers hold."""

import pathlib
import struct

import geometry_msgs.msg
import numpy
import shape_msgs.msg

import extperfc.srv
from extperfc.arm import connection, hands
from extperfc.arm.errors import ArmError
from extperfc.arm.goals import pose_stamped
from extperfc.msg import ArmCode, SceneObject

Primitive = shape_msgs.msg.SolidPrimitive


class Scene:
    """Objects of the node's scene.

    Poses are given as to pose_stamped: (x, y, z), (x, y, z, roll, pitch, yaw), Pose, PoseStamped, ... of the object's
    middle (box, cylinder, sphere, cone) or origin (mesh), in `frame` (none: that of the robot's arms, a Baxter's base) unless
    they bring their own. Cylinders and cones stand along z, a cone's tip upwards. An object of a known name is replaced.
    Raises ArmError; ValueError for numbers that make no sense.
    """

    def __init__(self, namespace="", wait_s=connection.WAIT_S):
        self._namespace = namespace
        self._apply = connection.Service(namespace, "arm/apply_scene", extperfc.srv.ApplyScene, wait_s)
        self._get = connection.Service(namespace, "arm/get_scene", extperfc.srv.GetScene, wait_s)

    def add_box(self, name, size, pose, frame=None, label=""):
        """size: x, y, z [m]."""
        self._add(name, Primitive.BOX, size, 3, pose, frame, label)

    def add_cylinder(self, name, radius, height, pose, frame=None, label=""):
        self._add(name, Primitive.CYLINDER, (height, radius), 2, pose, frame, label)

    def add_sphere(self, name, radius, pose, frame=None, label=""):
        self._add(name, Primitive.SPHERE, (radius,), 1, pose, frame, label)

    def add_cone(self, name, radius, height, pose, frame=None, label=""):
        self._add(name, Primitive.CONE, (height, radius), 2, pose, frame, label)

    def add_mesh(self, name, file, pose, frame=None, label="", scale=1.0):
        """file: STL or OBJ, also package://...; counts as its convex hull. scale: one number or one for each axis."""
        made = SceneObject(operation=SceneObject.ADD, name=_named(name), label=label, pose=self._stamped(pose, frame))
        made.meshes = [mesh_message(*read_mesh(file), scale)]
        made.mesh_poses = [geometry_msgs.msg.Pose(orientation=geometry_msgs.msg.Quaternion(w=1.0))]
        self.apply([made])

    def move(self, name, pose, frame=None):
        self.apply([SceneObject(operation=SceneObject.MOVE, name=_named(name), pose=self._stamped(pose, frame))])

    def remove(self, name):
        self.apply([SceneObject(operation=SceneObject.REMOVE, name=_named(name))])

    def clear(self):
        """Removes all objects, including held ones."""
        self.apply([SceneObject(operation=SceneObject.REMOVE)])

    def attach(self, name, link, touch_links=()):
        """From now on a link, e.g. left_gripper, carries the object. touch_links: others that may touch it, e.g. fingers."""
        self.apply([SceneObject(operation=SceneObject.ATTACH, name=_named(name), link=link, touch_links=list(touch_links))])

    def detach(self, name):
        """The object stays where it is now."""
        self.apply([SceneObject(operation=SceneObject.DETACH, name=_named(name))])

    def apply(self, objects):
        """extperfc/SceneObject messages: applies all of them or, on an error, none."""
        answer = self._apply(objects=objects)
        if not answer.success:
            raise ArmError(ArmCode.INVALID_REQUEST, answer.message)

    @property
    def objects(self):
        """{name: extperfc/SceneObject}, each with its pose in its frame; operation ATTACH for held objects."""
        return {found.name: found for found in self._get().objects}

    def _stamped(self, pose, frame):
        return pose_stamped(pose, frame or hands.of(self._namespace).frame)

    def _add(self, name, kind, dimensions, count, pose, frame, label):
        primitive = Primitive(type=kind, dimensions=_lengths(name, dimensions, count))
        self.apply([SceneObject(operation=SceneObject.ADD, name=_named(name), label=label, pose=self._stamped(pose, frame),
                                primitives=[primitive],
                                primitive_poses=[geometry_msgs.msg.Pose(orientation=geometry_msgs.msg.Quaternion(w=1.0))])])


def _named(name):
    if not isinstance(name, str) or not name:
        raise ValueError("an object needs a name")
    return name


def _lengths(name, values, count):
    array = numpy.asarray(values, float)
    if array.shape != (count,) or not numpy.all(numpy.isfinite(array)) or not numpy.all(array > 0):
        raise ValueError(f"{name}: its size {tuple(values)} should be {count} lengths above 0")
    return [float(v) for v in array]


def mesh_message(vertices, triangles, scale=1.0):
    """shape_msgs/Mesh of vertices (N, 3) [m] and triangles (M, 3) of their indices."""
    scaled = numpy.asarray(vertices, float) * numpy.asarray(scale, float)
    return shape_msgs.msg.Mesh(
        [shape_msgs.msg.MeshTriangle([int(i) for i in triangle]) for triangle in triangles],
        [geometry_msgs.msg.Point(*(float(v) for v in vertex)) for vertex in scaled])


def find_file(address):
    """A path of a file name or a package:// or file:// address. Raises ValueError."""
    text = str(address)
    if text.startswith("package://"):
        import rospkg
        package, _, rest = text[len("package://"):].partition("/")
        try:
            return pathlib.Path(rospkg.RosPack().get_path(package)) / rest
        except rospkg.ResourceNotFound:
            raise ValueError(f"{text}: no package {package} here") from None
    return pathlib.Path(text[len("file://"):] if text.startswith("file://") else text).expanduser()


def read_mesh(address):
    """(vertices (N, 3) in the file's units, each of them once, triangles (M, 3)) of an STL or OBJ file.
    Raises ValueError where it holds no triangles, OSError where it cannot be read."""
    path = find_file(address)
    if path.suffix.lower() == ".stl":
        corners = _stl_corners(path.read_bytes(), path)
    elif path.suffix.lower() == ".obj":
        corners = _obj_corners(path.read_text(errors="replace"), path)
    else:
        raise ValueError(f"{path}: STL and OBJ files can be read")
    if len(corners) == 0 or not numpy.all(numpy.isfinite(corners)):
        raise ValueError(f"{path}: no triangles, or numbers that are none")
    vertices, indices = numpy.unique(corners, axis=0, return_inverse=True)
    return vertices, indices.reshape(-1, 3)


def _stl_corners(data, path):
    """Three corners per triangle (3 M, 3). A file that has the size of a binary one is one, independent of its first bytes."""
    if len(data) >= 84 and len(data) == 84 + 50 * struct.unpack_from("<I", data, 80)[0]:
        records = numpy.frombuffer(data, numpy.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("rest", "<u2")]),
                                   offset=84)
        return records["corners"].reshape(-1, 3).astype(float)
    tokens = [line.split() for line in data.decode(errors="replace").splitlines()]
    try:
        corners = numpy.array([[float(v) for v in line[1:4]] for line in tokens if line[:1] == ["vertex"]], float)
    except ValueError:
        raise ValueError(f"{path}: neither a binary nor a text STL file") from None
    if corners.ndim != 2 or corners.shape[1] != 3 or len(corners) % 3:
        raise ValueError(f"{path}: neither a binary nor a text STL file")
    return corners


def _obj_corners(text, path):
    """The same of an OBJ file; polygons are cut into fans."""
    vertices, corners = [], []
    try:
        for line in text.splitlines():
            tokens = line.split()
            if tokens[:1] == ["v"]:
                vertices.append([float(v) for v in tokens[1:4]])
            elif tokens[:1] == ["f"]:
                numbers = [int(token.split("/")[0]) for token in tokens[1:]]
                face = [vertices[n - 1 if n > 0 else len(vertices) + n] for n in numbers]
                for i in range(1, len(face) - 1):
                    corners += [face[0], face[i], face[i + 1]]
        return numpy.array(corners, float).reshape(-1, 3)
    except (ValueError, IndexError):
        raise ValueError(f"{path}: no OBJ file") from None
