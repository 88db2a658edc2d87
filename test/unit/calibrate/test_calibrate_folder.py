"""From images to files: collecting, solving, the result's files, and what is said about bad input."""

import contextlib
import io
import math
import pathlib
import shutil
import sys
import tempfile
import unittest

import numpy
import yaml

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
import rendered  # noqa: E402

from extperfc import robot_description as rd  # noqa: E402
from extperfc.calibrate import board as boards  # noqa: E402
from extperfc.calibrate import collector, program, result, robot_poses, views  # noqa: E402

BOARD = boards.Chessboard(7, 4, 0.03)
PARENT_T_CAMERA = rd.transform((0.2, 0.0, 0.3), rd.rotation_of_rpy(-2.3, 0.1, -1.6))
CARRIER_T_BOARD = rd.transform((0.0, 0.05, 0.1), rd.rotation_of_rpy(0.4, 0.1, 0.0))
CAMERA_T_MOUNT = rd.transform((-0.015, 0.0, 0.0), rd.rotation_of_rpy(0.0, -math.pi / 2, math.pi / 2))
FRAMES = views.Frames("head", "left_gripper", "camera_optical", "camera_link", CAMERA_T_MOUNT)
TILTS = [(0.1, 0.0, 0.0), (0.5, 0.1, 0.2), (-0.5, 0.1, -0.3), (0.1, 0.5, 0.3), (0.0, -0.5, -0.2), (0.4, 0.4, 0.6),
         (-0.4, 0.4, -0.6), (0.4, -0.4, 1.0), (-0.4, -0.4, -1.0), (0.3, -0.2, 1.5)]
MIDDLES = [(0.0, 0.0), (0.1, 0.05), (-0.1, -0.05), (0.1, -0.05), (-0.1, 0.05)]
URDF = """<robot name="r"><link name="base"/><link name="head"/><link name="camera_link"/><link name="bracket"/>
<joint name="pan" type="revolute"><parent link="base"/><child link="head"/><axis xyz="0 0 1"/><limit lower="-1" upper="1"/></joint>
<joint name="mount" type="fixed"><origin xyz="1 0 0" rpy="0 0 0"/><parent link="head"/><child link="bracket"/></joint>
<joint type="fixed" name="camera"><parent link="bracket"/><origin xyz="0 0.5 0"/><child link="camera_link"/></joint></robot>"""


def poses():
    """camera_T_board of every view."""
    return [rendered.pose(BOARD, 0.5 + 0.02 * i, tilt, MIDDLES[i % len(MIDDLES)]) for i, tilt in enumerate(TILTS)]


def carrier_pose(camera_T_board):
    return PARENT_T_CAMERA @ camera_T_board @ rd.inverse(CARRIER_T_BOARD)


class Folder(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        temporary = tempfile.TemporaryDirectory()
        cls.addClassCleanup(temporary.cleanup)
        cls.root = pathlib.Path(temporary.name)
        cls.folder = cls.root / "views"
        cls.collector = collector.Collector(cls.folder, rendered.CAMERA, BOARD, FRAMES, wanted_views=len(TILTS))
        cls.answers = [cls.collector.offer(rendered.render(BOARD, pose, seed=i), carrier_pose(pose))
                       for i, pose in enumerate(poses())]

    def run_tool(self, *arguments):
        """(exit code, what it prints)."""
        text = io.StringIO()
        with contextlib.redirect_stdout(text), contextlib.redirect_stderr(text):
            code = program.main(list(map(str, arguments)))
        return code, text.getvalue()

    def copy(self, name):
        shutil.copytree(self.folder, self.root / name)
        return self.root / name

    def change(self, folder, change):
        fields = yaml.safe_load((folder / views.FILE).read_text())
        change(fields)
        (folder / views.FILE).write_text(yaml.safe_dump(fields))

    def test_the_guide_takes_views_until_there_are_enough(self):
        self.assertTrue(all(answer.taken for answer in self.answers), [answer.text for answer in self.answers])
        self.assertIn("view_00.png taken (1); next: rotate left_gripper", self.answers[0].text)
        self.assertIn(f"1 more views ({len(TILTS) - 1} of {len(TILTS)})", self.answers[-2].text)
        self.assertTrue(self.collector.is_complete())

    def test_the_guide_says_why_an_image_is_not_taken(self):
        pose = poses()[0]
        image = rendered.render(BOARD, pose)
        self.assertIn("like one before", self.collector.offer(image, carrier_pose(pose)).text)
        far = carrier_pose(pose) @ rd.transform((0.2, 0, 0))
        self.assertIn("moves", self.collector.offer(image, far, is_still=False).text)
        self.assertIn("not seen", self.collector.offer(numpy.full_like(image, 90), far).text)

    def test_the_pose_is_found_and_written_for_the_launch_files(self):
        out = self.root / "pose.yaml"
        code, text = self.run_tool("solve", self.folder, "--out", out)
        self.assertEqual(0, code, text)
        parent, child, pose = result.read_pose(out)
        self.assertEqual(("head", "camera_link"), (parent, child))
        off = result.pose_difference(PARENT_T_CAMERA @ CAMERA_T_MOUNT, pose)
        self.assertLess(1000 * numpy.linalg.norm(off[:3]), 1.0)
        self.assertLess(math.degrees(numpy.linalg.norm(off[3:])), 0.15)
        self.assertIn(f"camera_pose:={out}", text)
        self.assertIn("Park-Martin", text)
        self.assertGreater(out.with_suffix(".png").stat().st_size, 10000)
        said = yaml.safe_load(out.read_text())["calibration"]
        self.assertLess(said["residual_px"], 0.5)
        self.assertEqual(len(TILTS), said["views"])

    def test_the_camera_of_a_urdf_moves_to_the_found_pose(self):
        out, urdf, changed = self.root / "for_urdf.yaml", self.root / "robot.urdf", self.root / "calibrated.urdf"
        self.run_tool("solve", self.folder, "--out", out)
        urdf.write_text(URDF)
        code, text = self.run_tool("urdf", out, "--urdf", urdf, "--out", changed)
        self.assertEqual(0, code, text)
        _, _, pose = result.read_pose(out)
        there = rd.RobotDescription.from_file(changed).link_poses({}, "head")["camera_link"]
        self.assertLess(numpy.abs(there - pose).max(), 1e-5)
        urdf.write_text(URDF.replace('<joint name="mount" type="fixed">', '<joint name="mount" type="continuous">'))
        code, text = self.run_tool("urdf", out, "--urdf", urdf, "--out", changed)
        self.assertEqual(1, code)
        self.assertIn("joint mount between head and camera_link moves: calibrate with --camera-on bracket", text)

    def test_too_few_views_are_refused(self):
        folder = self.copy("few")
        self.change(folder, lambda fields: fields.update(views=fields["views"][:6]))
        code, text = self.run_tool("solve", folder)
        self.assertEqual(1, code)
        self.assertRegex(text, r"error: the views do not determine the camera's pose: .*2 more views \(6 of 8\)")

    def test_bad_folders_are_refused_with_a_remedy(self):
        def wrong_pose(fields):
            fields["views"][2]["parent_T_carrier"] = [0, 0, 0, 0, 0, 0, 0]

        def missing_image(fields):
            fields["views"][1]["image"] = "nowhere.png"

        def other_size(fields):
            fields["camera"]["width"] = 1280
        changes = {"pose": (wrong_pose, "is no pose"), "image": (missing_image, "nowhere.png is missing"),
                   "size": (other_size, "640 x 480 pixels, the camera's calibration is for 1280 x 480"),
                   "frames": (lambda fields: fields.pop("frames"), "frames missing"),
                   "focal": (lambda fields: fields["camera"].update(K=[0] * 9), "not calibrated"),
                   "model": (lambda fields: fields["camera"].update(model="odd"), "plumb_bob"),
                   "board": (lambda fields: fields["board"].update(kind="paper"), "kind must be one of")}
        for name, (change, message) in changes.items():
            with self.subTest(name):
                folder = self.copy("bad_" + name)
                self.change(folder, change)
                code, text = self.run_tool("solve", folder)
                self.assertEqual(1, code, text)
                self.assertIn(message, text)
        self.assertIn("collect views first", self.run_tool("solve", self.root / "none")[1])

    def test_views_are_not_overwritten(self):
        with self.assertRaisesRegex(views.ViewsError, "holds views already"):
            collector.Collector(self.folder, rendered.CAMERA, BOARD, FRAMES)

    def test_images_without_the_board_are_named(self):
        folder = self.copy("unseen")
        blank = rendered.render(BOARD, rendered.pose(BOARD, middle=(0.4, 0.0)))
        rendered.cv2.imwrite(str(folder / "view_03.png"), blank)
        self.assertEqual(["view_03.png"], views.load(folder).unseen)
        self.assertIn("no board in view_03.png", self.run_tool("solve", folder)[1])


class Stamp:
    def __init__(self, seconds):
        self.seconds = seconds

    def to_sec(self):
        return self.seconds


class JointStates(unittest.TestCase):
    class Message:
        def __init__(self, stamp_s, **positions):
            self.header = type("Header", (), {"stamp": Stamp(stamp_s)})
            self.name, self.position = list(positions), list(positions.values())

    def setUp(self):
        self.poses = robot_poses.JointPoses(URDF, "base", "camera_link")

    def test_positions_are_interpolated(self):
        for stamp, angle in ((1.0, 0.0), (1.1, 0.2), (1.05, 9.0), (1.2, 0.4)):  # the third comes late
            self.poses.add(self.Message(stamp, pan=angle, other=1.0))
        expected = rd.RobotDescription(URDF).link_poses({"pan": 0.3}, "base")["camera_link"]
        self.assertLess(numpy.abs(self.poses.at(1.15) - expected).max(), 1e-12)

    def test_times_without_joint_states_have_no_pose(self):
        for stamp in (1.0, 1.1, 2.0):
            self.poses.add(self.Message(stamp, pan=0.0))
        self.assertIsNotNone(self.poses.at(1.0))
        for stamp in (0.9, 1.5, 2.1):
            self.assertIsNone(self.poses.at(stamp), stamp)

    def test_unknown_links_are_named(self):
        with self.assertRaisesRegex(views.ViewsError, "no link hand"):
            robot_poses.JointPoses(URDF, "base", "hand")


if __name__ == "__main__":
    unittest.main()
