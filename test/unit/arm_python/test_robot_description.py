"""Descriptions of robots, and where their links are."""

import math
import pathlib
import random
import unittest

import numpy

from extperfc import robot_description as rd

URDF = pathlib.Path(__file__).resolve().parents[3] / "urdf" / "mobile_baxter.urdf"

# Joint values (s0 s1 e0 e1 w0 w1 w2) of the left arm and its gripper's place in `base` by the manufacturer's description.
LEFT = {
    "tuck": ((-1.0, -2.07, 3.0, 2.55, 0.0, 0.01, 0.0), (-0.134718, 0.371985, -0.070326)),
    "untuck": ((-0.08, -1.0, -1.19, 1.94, 0.67, 1.03, -0.5), (0.579711, 0.183294, 0.1137)),
    "neutral": ((0, -0.55, 0, 0.75, 0, 1.26, 0), (0.646258, 0.84126, 0.062618)),
}
MIRROR = (-1, 1, -1, 1, -1, 1, -1)
NAMES = ("s0", "s1", "e0", "e1", "w0", "w1", "w2")

# A forearm of 1 m along z on an elbow that turns about y, 0.5 m above the ground; a finger and one that mimics it.
TWO_LINKS = """<robot name="two">
  <material name="green"><color rgba="0 1 0 1"/></material>
  <link name="ground"/>
  <link name="forearm"><visual><origin xyz="0 0 0.5"/><geometry><cylinder radius="0.1" length="1"/></geometry>
    <material name="green"/></visual><collision><geometry><sphere radius="0.2"/></geometry></collision></link>
  <link name="finger"><collision><geometry><box size="1 2 3"/></geometry></collision></link>
  <link name="other"/>
  <joint name="elbow" type="revolute"><parent link="ground"/><child link="forearm"/><origin xyz="0 0 0.5"/>
    <axis xyz="0 2 0"/><limit lower="0.25" upper="2" effort="1" velocity="1"/></joint>
  <joint name="slide" type="prismatic"><parent link="forearm"/><child link="finger"/><origin xyz="0 0 1"/>
    <axis xyz="1 0 0"/><limit lower="0" upper="0.1" effort="1" velocity="1"/></joint>
  <joint name="follow" type="prismatic"><parent link="forearm"/><child link="other"/><origin xyz="0 0 1"/>
    <axis xyz="1 0 0"/><mimic joint="slide" multiplier="-1" offset="0.01"/>
    <limit lower="-1" upper="1" effort="1" velocity="1"/></joint>
</robot>"""


class Baxter(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.robot = rd.RobotDescription.from_file(URDF)

    def test_grippers_are_where_the_manufacturer_says(self):
        for state, (values, xyz) in LEFT.items():
            for side, sign in (("left", 1), ("right", -1)):
                signs = (1,) * 7 if side == "left" or state == "neutral" else MIRROR
                joints = {f"{side}_{n}": s * v for n, s, v in zip(NAMES, signs, values)}
                here = self.robot.link_poses(joints, "base")[f"{side}_gripper"][:3, 3]
                numpy.testing.assert_allclose(here, (xyz[0], sign * xyz[1], xyz[2]), atol=2e-6, err_msg=f"{state} {side}")

    def test_frame_of_the_poses(self):
        poses, base_T = self.robot.link_poses({}), self.robot.link_poses({}, "base")
        self.assertEqual("base_footprint", self.robot.root)
        self.assertAlmostEqual(0.6309, poses["base"][2, 3])
        for link in ("left_gripper", "head", "chassis"):
            numpy.testing.assert_allclose(poses["base"] @ base_T[link], poses[link], atol=1e-12)

    def test_joints_and_links_of_an_arm(self):
        self.assertEqual([f"left_{n}" for n in NAMES], self.robot.joints_above("left_gripper"))
        below = self.robot.links_below(["left_s0"])
        for link in ("left_upper_shoulder", "left_gripper", "l_gripper_r_finger_tip"):
            self.assertIn(link, below)
        self.assertFalse([link for link in below if link.startswith(("right", "r_")) or link in ("base", "left_arm_mount")])
        self.assertEqual(len(below), len(set(below)))

    def test_every_link_that_has_a_body_can_be_drawn(self):
        drawn = {link.name for link in self.robot.links.values() if link.shapes()}
        self.assertIn("left_upper_forearm", drawn)
        mesh = self.robot.links["left_upper_shoulder"].visuals[1]
        self.assertEqual(("mesh", (0.72, 0.09, 0.075, 1.0)), (mesh.kind, mesh.rgba))
        self.assertTrue(mesh.mesh.startswith("package://extperfc/"))


class TwoLinks(unittest.TestCase):
    def setUp(self):
        self.robot = rd.RobotDescription(TWO_LINKS)

    def test_turning_and_sliding(self):
        poses = self.robot.link_poses({"elbow": math.pi / 2, "slide": 0.1})
        numpy.testing.assert_allclose(poses["finger"][:3, 3], (1.0, 0, 0.5 - 0.1), atol=1e-12)

    def test_mimic(self):
        poses = self.robot.link_poses({"elbow": 0.0, "slide": 0.1}, "forearm")
        numpy.testing.assert_allclose(poses["other"][:3, 3], (-0.1 + 0.01, 0, 1), atol=1e-12)

    def test_joints_of_which_nothing_is_said_stay_within_limits(self):
        rotation = self.robot.link_poses({})["forearm"][:3, :3]
        numpy.testing.assert_allclose(rotation, rd.rotation_of_rpy(0, 0.25, 0), atol=1e-12)

    def test_shapes(self):
        forearm, finger = self.robot.links["forearm"], self.robot.links["finger"]
        self.assertEqual([("cylinder", (0.1, 1.0), (0, 1, 0, 1))], [(s.kind, s.size, s.rgba) for s in forearm.shapes()])
        self.assertEqual([("box", (1, 2, 3))], [(s.kind, s.size) for s in finger.shapes()])

    def test_what_is_no_tree_is_refused(self):
        broken = {
            "no URDF": "<robot",
            "begins with": "<sdf/>",
            "2 roots": TWO_LINKS.replace('<link name="ground"/>', '<link name="ground"/><link name="sky"/>'),
            "two parents": TWO_LINKS.replace('<child link="other"/>', '<child link="finger"/>'),
            "does not have": TWO_LINKS.replace('<child link="other"/>', '<child link="nobody"/>'),
            "floating": TWO_LINKS.replace('type="revolute"', 'type="floating"'),
            "no direction": TWO_LINKS.replace('xyz="0 2 0"', 'xyz="0 0 0"'),
            "3 numbers": TWO_LINKS.replace('size="1 2 3"', 'size="1 2"'),
        }
        for what, text in broken.items():
            with self.assertRaisesRegex(ValueError, what):
                rd.RobotDescription(text)


class Rotations(unittest.TestCase):
    def setUp(self):
        self.rng = random.Random(1)

    def test_quaternions_there_and_back(self):
        exact = [(0, 0, 0, 1), (1, 0, 0, 0), (0, 1, 0, 0), (0, 0, 1, 0), (0.6, 0.8, 0, 0)]
        for q in exact + [[self.rng.gauss(0, 1) for _ in range(4)] for _ in range(200)]:
            unit = numpy.array(q) / numpy.linalg.norm(q)
            back = numpy.array(rd.quaternion_of_rotation(rd.rotation_of_quaternion(*q)))
            self.assertGreaterEqual(back[3], 0)
            self.assertAlmostEqual(1.0, abs(float(unit @ back)), places=12)

    def test_axis_and_rpy_agree(self):
        for axis in range(3):
            angle = self.rng.uniform(-3, 3)
            rpy = [angle if i == axis else 0.0 for i in range(3)]
            numpy.testing.assert_allclose(rd.rotation_of_rpy(*rpy), rd.rotation_about(numpy.eye(3)[axis], angle), atol=1e-12)
        r, p, y = 0.3, -0.7, 1.9
        numpy.testing.assert_allclose(
            rd.rotation_of_rpy(r, p, y), rd.rotation_of_rpy(0, 0, y) @ rd.rotation_of_rpy(0, p, 0) @ rd.rotation_of_rpy(r, 0, 0))

    def test_inverse(self):
        pose = rd.transform((1, 2, 3), rd.rotation_of_rpy(0.1, 0.2, 0.3))
        numpy.testing.assert_allclose(rd.inverse(pose) @ pose, numpy.eye(4), atol=1e-12)

    def test_no_quaternion(self):
        for q in ((0, 0, 0, 0), (0, 0, 0, math.nan)):
            with self.assertRaises(ValueError):
                rd.rotation_of_quaternion(*q)


if __name__ == "__main__":
    unittest.main()
