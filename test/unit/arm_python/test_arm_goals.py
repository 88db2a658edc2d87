"""Messages of the Python client from what people write."""

import math
import pathlib
import struct
import tempfile
import unittest

import geometry_msgs.msg
import numpy
import sensor_msgs.msg

from extperfc import robot_description as rd
from extperfc.arm import goals, scene
from extperfc.msg import ArmRequest, ToolConstraint

TURNED = rd.rotation_of_rpy(0, 0, math.pi / 2)


def request(side, goal, linear=False, **options):
    return goals.motion_request(side, goal, goals.MotionOptions(**options), linear, lambda side, frame: TURNED)


def xyz(pose):
    return (pose.position.x, pose.position.y, pose.position.z)


class Poses(unittest.TestCase):
    def test_every_way_to_write_one_means_the_same(self):
        matrix = rd.transform((1, 2, 3), TURNED)
        half = math.sqrt(0.5)
        pose = geometry_msgs.msg.Pose(geometry_msgs.msg.Point(1, 2, 3), geometry_msgs.msg.Quaternion(0, 0, half, half))
        for written in (matrix, pose, (1, 2, 3, 0, 0, math.pi / 2), [1, 2, 3, 0, 0, 2, 2], numpy.array([1, 2, 3, 0, 0, 1, 1])):
            stamped = goals.pose_stamped(written, "map")
            self.assertEqual("map", stamped.header.frame_id)
            self.assertTrue(stamped.header.stamp.is_zero())
            numpy.testing.assert_allclose(goals.matrix_of_pose(stamped), matrix, atol=1e-12)

    def test_a_stamped_pose_keeps_its_frame(self):
        stamped = geometry_msgs.msg.PoseStamped()
        stamped.header.frame_id = "camera"
        self.assertIs(stamped, goals.pose_stamped(stamped, "map"))

    def test_what_is_no_pose_is_refused(self):
        sheared = numpy.eye(4)
        sheared[0, 1] = 0.5
        mirrored = numpy.diag([1, 1, -1, 1])
        for written in ((1, 2), (1, 2, math.nan), "neutral", {"s0": 1}, (1, 2, 3, 0, 0, 0, 0), sheared, mirrored, None):
            with self.assertRaises(ValueError):
                goals.pose_stamped(written)


class Requests(unittest.TestCase):
    def test_named_state(self):
        made = request("both", "neutral", planning_time=2.0, velocity_scale=0.5, planner="lbkpiece", seed=7, improve=True)
        self.assertEqual(("both_arms", "neutral", 2.0, 0.5, "lbkpiece", 7, True), (
            made.group, made.named_state, made.planning_time, made.velocity_scale, made.planner, made.seed, made.improve))
        self.assertEqual((ArmRequest.FREE, [], []), (made.motion, made.tool_goals, made.joint_goal.name))

    def test_joints_with_and_without_the_side(self):
        made = request("right", {"s0": 0.1, "right_e1": 1})
        self.assertEqual((["right_s0", "right_e1"], [0.1, 1.0]), (made.joint_goal.name, made.joint_goal.position))
        state = sensor_msgs.msg.JointState(name=["left_s0"], position=[0.2])
        self.assertEqual(["left_s0"], request("left", state).joint_goal.name)

    def test_three_numbers_leave_the_tool_turned_as_it_is(self):
        tool, = request("left", (0.7, 0.3, 0.1), frame="torso").tool_goals
        self.assertEqual(("left_gripper", "torso", (0.7, 0.3, 0.1)), (tool.link, tool.pose.header.frame_id, xyz(tool.pose.pose)))
        numpy.testing.assert_allclose(goals.matrix_of_pose(tool.pose)[:3, :3], TURNED, atol=1e-12)

    def test_tolerances(self):
        tool, = request("left", (0, 0, 0), position_tolerance=0.01, orientation_tolerance=(0, 0, math.pi)).tool_goals
        self.assertEqual((0.01, 0.01, 0.01), (tool.position_tolerance.x, tool.position_tolerance.y, tool.position_tolerance.z))
        self.assertEqual((0, math.pi), (tool.orientation_tolerance.x, tool.orientation_tolerance.z))

    def test_a_line_through_several_poses(self):
        made = request("left", [(0, 0, 0), (0, 0, 1)], linear=True, minimum_fraction=0.5)
        self.assertEqual((ArmRequest.LINEAR, 2, 0.5), (made.motion, len(made.tool_goals), made.minimum_fraction))
        with self.assertRaisesRegex(ValueError, "linear"):
            request("left", [(0, 0, 0), (0, 0, 1)])

    def test_both_arms(self):
        made = request("both", {"left": (0, 1, 0), "right": (0, -1, 0)})
        self.assertEqual(["left_gripper", "right_gripper"], [tool.link for tool in made.tool_goals])
        made = request("both", {"left": {"s0": 1}, "right": {"s0": 2}})
        self.assertEqual((["left_s0", "right_s0"], [1, 2]), (made.joint_goal.name, made.joint_goal.position))
        made = request("both", {"left_s0": 1, "right_s0": 2})
        self.assertEqual(["left_s0", "right_s0"], made.joint_goal.name)

    def test_constraints(self):
        kept = [goals.keep_axis((0, 0, 2)), [goals.keep_line((1, 0, 0), "map", "left_gripper")]]
        made = request("left", "neutral", constraints=kept)
        self.assertEqual([ToolConstraint.KEEP_AXIS, ToolConstraint.KEEP_LINE], [c.kind for c in made.constraints])
        self.assertEqual(("map", 1, "left_gripper"), (made.constraints[1].frame_id, made.constraints[1].axis.x,
                                                      made.constraints[1].link))
        made = request("left", "neutral", constraints=goals.keep_orientation())
        self.assertEqual([ToolConstraint.KEEP_ORIENTATION], [c.kind for c in made.constraints])
        relative = goals.keep_relative()
        self.assertEqual(("left_gripper", "right_gripper"), (relative.link, relative.other_link))
        for axis in ((0, 0, 0), (1, 0), (math.inf, 0, 0)):
            with self.assertRaises(ValueError):
                goals.keep_plane(axis)

    def test_what_makes_no_sense_is_refused_here(self):
        wrong = [("both", (0, 0, 0), {}), ("both", {"s0": 1}, {}), ("left", {"right": (0, 0, 0)}, {}), ("left", 5, {}),
                 ("left", [], {}), ("left", {}, {}), ("left", {"s0": math.nan}, {}), ("left", {"s0": "1"}, {}),
                 ("left", {"s0": 1, "left_s0": 2}, {}), ("both", {"left": (0, 0, 0), "right": {"s0": 1}}, {}),
                 ("both", {"left": "tuck"}, {}), ("left", "tuck", {"velocity_scale": 1.5}),
                 ("left", "tuck", {"planning_time": -1.0}), ("left", (0, 0, 0), {"position_tolerance": (1, 2)})]
        for side, goal, options in wrong:
            with self.assertRaises(ValueError, msg=f"{side} {goal} {options}"):
                request(side, goal, **options)
        with self.assertRaises(TypeError):
            request("left", "tuck", velocity=0.5)

    def test_requests_can_be_sent(self):
        """Every field has a type that the message takes."""
        import io
        for made in (request("left", [(0, 0, 0), (0, 0, 1, 0, 0, 0)], linear=True, constraints=goals.keep_axis(numpy.eye(3)[2])),
                     request("both", {"left": {"s0": numpy.float32(1)}, "right": {"s0": 2}}, start={"left_s0": 1})):
            buffer = io.BytesIO()
            made.serialize(buffer)
            self.assertEqual(made, ArmRequest().deserialize(buffer.getvalue()))


# A tetrahedron of 1 m edges along the axes.
CORNERS = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)]
FACES = [(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)]


def text_stl():
    lines = ["solid corner"]
    for face in FACES:
        lines += ["facet normal 0 0 0", "outer loop"] + ["vertex {} {} {}".format(*CORNERS[i]) for i in face]
        lines += ["endloop", "endfacet"]
    return "\n".join(lines + ["endsolid corner", ""]).encode()


def binary_stl(header=b"solid though binary"):
    data = header.ljust(80, b" ") + struct.pack("<I", len(FACES))
    for face in FACES:
        data += struct.pack("<12fH", 0, 0, 0, *(v for i in face for v in CORNERS[i]), 0)
    return data


def obj(first=1):
    return "\n".join(["v {} {} {}".format(*c) for c in CORNERS] +
                     ["f " + " ".join(f"{i + first if first > 0 else i - 4}/7/8" for i in face) for face in FACES]).encode()


class Meshes(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)

    def file(self, name, content):
        path = pathlib.Path(self.folder.name) / name
        path.write_bytes(content)
        return path

    def test_the_same_body_from_every_format(self):
        for name, content in (("a.stl", text_stl()), ("b.STL", binary_stl()), ("c.obj", obj()), ("d.obj", obj(-1))):
            vertices, triangles = scene.read_mesh(self.file(name, content))
            self.assertEqual(sorted(CORNERS), [tuple(v) for v in vertices], name)
            found = [tuple(tuple(vertices[i]) for i in triangle) for triangle in triangles]
            self.assertEqual([tuple(CORNERS[i] for i in face) for face in FACES], found, name)

    def test_polygons_become_triangles(self):
        _, triangles = scene.read_mesh(self.file("square.obj", b"v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n"))
        self.assertEqual(2, len(triangles))

    def test_scale(self):
        message = scene.mesh_message(CORNERS, FACES, (0.001, 0.001, 0.002))
        self.assertEqual((4, 0.002), (len(message.triangles), message.vertices[3].z))

    def test_what_is_no_mesh_is_refused(self):
        broken = [("a.stl", b""), ("b.stl", binary_stl()[:-1]), ("c.stl", b"solid\nvertex 1 2\n"), ("d.obj", b"v 0 0 0\n"),
                  ("e.obj", b"v 0 0 0\nf 1 2 3\n"), ("f.stl", b"vertex a b c\n"), ("g.dae", b"<dae/>"),
                  ("h.stl", text_stl().replace(b"vertex 1 0 0", b"vertex nan 0 0"))]
        for name, content in broken:
            with self.assertRaises(ValueError, msg=name):
                scene.read_mesh(self.file(name, content))
        with self.assertRaises(OSError):
            scene.read_mesh("/nowhere/a.stl")


if __name__ == "__main__":
    unittest.main()
