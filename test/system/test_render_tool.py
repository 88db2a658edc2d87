"""tools/extperfc-render as a user calls it."""

import pathlib
import re
import signal
import statistics
import struct
import subprocess
import tempfile
import time
import unittest
import xml.etree.ElementTree

REPO = pathlib.Path(__file__).resolve().parents[2]
TOOL = REPO / "tools" / "extperfc-render"
SMALL = ("--size", "160x120", "--supersampling", "1")


def render(*arguments):
    return subprocess.run([TOOL, *map(str, arguments)], capture_output=True, text=True, timeout=120)


def jpeg_size(file):
    """Width and height from the frame header of a JPEG file."""
    data = file.read_bytes()
    at = 2
    while data[at + 1] not in (0xC0, 0xC1, 0xC2):
        at += 2 + struct.unpack(">H", data[at + 2:at + 4])[0]
    height, width = struct.unpack(">HH", data[at + 5:at + 9])
    return width, height


def files_of(folder):
    return {str(file.relative_to(folder)): file.read_bytes() for file in folder.rglob("*") if file.is_file()}


class RenderTool(unittest.TestCase):
    def setUp(self):
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.folder = pathlib.Path(temporary.name)

    def images(self, name, *arguments):
        out = self.folder / name
        done = render(out, *SMALL, *arguments)
        self.assertEqual(0, done.returncode, done.stdout + done.stderr)
        return out

    def test_writes_pascal_voc(self):
        out = self.images("voc", "--count", 10, "--seed", 7, "--depth", "--val", 0.4)
        names = [f"{i:06d}" for i in range(1, 11)]
        for folder, suffix in (("JPEGImages", "jpg"), ("Annotations", "xml"), ("Depth", "png")):
            self.assertEqual([f"{name}.{suffix}" for name in names],
                             sorted(file.name for file in (out / folder).iterdir()))
        labels = (out / "labels.txt").read_text().split()
        self.assertEqual(["cone", "cube", "sphere"], labels)
        sets = {name: (out / "ImageSets" / "Main" / f"{name}.txt").read_text().split()
                for name in ("train", "val", "trainval")}
        self.assertEqual(names, sorted(sets["train"] + sets["val"]))
        self.assertEqual(names, sorted(sets["trainval"]))
        objects = [found for name in names for found in self.check_annotation(out, name, labels)]
        self.assertGreater(len(objects), 15)
        for name in names:
            header = (out / "Depth" / f"{name}.png").read_bytes()[16:25]
            self.assertEqual((160, 120, 16), struct.unpack(">IIB", header), "16-bit depth of the image's size")

    def check_annotation(self, out, name, labels):
        root = xml.etree.ElementTree.parse(out / "Annotations" / f"{name}.xml").getroot()
        image = out / "JPEGImages" / root.find("filename").text
        self.assertEqual((160, 120), jpeg_size(image))
        self.assertEqual(["160", "120", "3"], [root.find(f"size/{key}").text for key in ("width", "height", "depth")])
        for found in root.findall("object"):
            self.assertIn(found.find("name").text, labels)
            left, top, right, bottom = (int(found.find(f"bndbox/{key}").text)
                                        for key in ("xmin", "ymin", "xmax", "ymax"))
            self.assertTrue(1 <= left < right <= 160, (name, left, right))
            self.assertTrue(1 <= top < bottom <= 120, (name, top, bottom))
            for flag in ("truncated", "occluded", "difficult"):
                self.assertIn(found.find(flag).text, ("0", "1"))
            self.assertTrue(0 < float(found.find("visible").text) <= 1)
            if 1 < left and 1 < top and right < 160 and bottom < 120:
                self.assertEqual("0", found.find("truncated").text, f"{name}: within the image")
        return root.findall("object")

    def test_same_seed_same_files_whatever_the_threads(self):
        first = files_of(self.images("first", "--count", 9, "--seed", 3, "--threads", 1))
        second = files_of(self.images("second", "--count", 9, "--seed", 3, "--threads", 2))
        other = files_of(self.images("other", "--count", 9, "--seed", 4))
        self.assertEqual(first, second)
        self.assertNotEqual(first["JPEGImages/000001.jpg"], other["JPEGImages/000001.jpg"])

    def test_varied_scenes_differ_from_ordinary_ones(self):
        ordinary = files_of(self.images("ordinary", "--count", 6, "--seed", 3))
        varied = files_of(self.images("varied", "--count", 6, "--seed", 3, "--scenes", "varied"))
        mixed = files_of(self.images("mixed", "--count", 6, "--seed", 3, "--scenes", "mixed"))
        self.assertIn(b"random varied", varied["render.txt"])
        self.assertNotEqual(ordinary["JPEGImages/000001.jpg"], varied["JPEGImages/000001.jpg"])
        self.assertEqual(ordinary["JPEGImages/000001.jpg"], mixed["JPEGImages/000001.jpg"], "the first world is ordinary")
        self.assertEqual(varied["JPEGImages/000005.jpg"], mixed["JPEGImages/000005.jpg"], "the second one is varied")
        sizes = {len(data) for name, data in varied.items() if name.startswith("JPEGImages")}
        self.assertGreater(len(sizes), 3)

    def test_cameras_stand_as_near_as_asked_for(self):
        def sizes(name, *arguments):
            out = self.images(name, "--count", 24, "--seed", 3, "--size", "320x240", *arguments)
            boxes = [root.find("bndbox") for file in (out / "Annotations").iterdir()
                     for root in xml.etree.ElementTree.parse(file).getroot().iter("object")]
            return [int(box.find("xmax").text) - int(box.find("xmin").text) for box in boxes]
        near, usual = sizes("near", "--max-distance", 0.5), sizes("usual")
        self.assertGreater(statistics.median(near), 1.5 * statistics.median(usual))

    def test_a_recording_of_a_moving_camera(self):
        out = self.folder / "recording"
        done = render(out, "--sequence", *SMALL, "--count", 5, "--seed", 2)
        self.assertEqual(0, done.returncode, done.stderr)
        lines = (out / "associations.txt").read_text().splitlines()
        self.assertEqual(5, len(lines))
        for line in lines:
            stamp, image, other, depth = line.split()
            self.assertEqual(stamp, other)
            self.assertTrue((out / image).exists() and (out / depth).exists(), line)
        poses = [list(map(float, line.split())) for line in (out / "groundtruth.txt").read_text().splitlines()[1:]]
        self.assertEqual(5, len(poses))
        for _, _, _, _, *quaternion in poses:
            self.assertAlmostEqual(1.0, sum(q * q for q in quaternion), places=4)
        step = [sum((b - a) ** 2 for a, b in zip(one[1:4], other[1:4])) ** 0.5 for one, other in zip(poses, poses[1:])]
        self.assertTrue(all(0.05 < s < 0.5 for s in step), step)
        self.assertIn("image_width: 160", (out / "camera_info.yaml").read_text())
        again = render(out, "--sequence", *SMALL)
        self.assertEqual(1, again.returncode)
        self.assertIn("not an empty folder", again.stderr)

    def test_world_of_a_file(self):
        out = self.images("lab", "--count", 3, "--world", REPO / "config" / "worlds" / "lab.yaml", "--plain")
        self.assertEqual(3, len(list((out / "JPEGImages").iterdir())))
        broken = render(self.folder / "x", "--world", self.folder / "none.yaml")
        self.assertEqual(1, broken.returncode)
        self.assertIn("none.yaml", broken.stderr)
        self.assertFalse((self.folder / "x").exists(), "nothing is made for a world that cannot be read")

    def test_resumes_and_refuses_what_does_not_fit(self):
        out = self.images("set", "--count", 3, "--seed", 5)
        again = render(out, *SMALL, "--count", 3, "--seed", 5)
        self.assertEqual(1, again.returncode)
        self.assertIn("--resume", again.stderr)
        others = render(out, *SMALL, "--count", 3, "--seed", 6, "--resume")
        self.assertEqual(1, others.returncode)
        self.assertIn("other settings", others.stderr)
        (out / "Annotations" / "000002.xml").unlink()
        more = render(out, *SMALL, "--count", 6, "--seed", 5, "--resume")
        self.assertEqual(0, more.returncode, more.stderr)
        self.assertIn("6 images, 4 of them new", more.stdout)
        self.assertEqual(files_of(self.images("whole", "--count", 6, "--seed", 5)), files_of(out))

    def test_interruption_leaves_a_complete_folder(self):
        out = self.folder / "cut"
        process = subprocess.Popen([TOOL, out, "--count", "5000", *SMALL], stdout=subprocess.PIPE,
                                   stderr=subprocess.PIPE, text=True)
        deadline = time.monotonic() + 60
        while time.monotonic() < deadline and len(list(out.glob("Annotations/*.xml"))) < 3:
            time.sleep(0.02)
        process.send_signal(signal.SIGINT)
        stdout, stderr = process.communicate(timeout=60)
        self.assertEqual(130, process.returncode, stderr)
        count = int(re.search(r": (\d+) images", stdout).group(1))
        self.assertTrue(3 <= count < 5000, stdout)
        listed = (out / "ImageSets" / "Main" / "trainval.txt").read_text().split()
        for folder in ("Annotations", "JPEGImages"):
            self.assertEqual(sorted(listed), sorted(file.stem for file in (out / folder).iterdir()))

    def test_errors_name_what_is_wrong(self):
        for arguments, text in ((["--count", "0", "x"], "--count must be a number in [1, 999999]"),
                                (["--size", "640", "x"], "--size must be like 640x480"),
                                (["--colour", "x"], "unknown option --colour"),
                                (["--max-distance", "0.1", "x"], "--max-distance must be a number in [0.4, 10]"),
                                (["--scenes", "odd", "x"], "--scenes must be ordinary, varied or mixed"), ([], "give a folder"),
                                (["x", "--seed"], "--seed needs a value")):
            done = render(*arguments)
            self.assertEqual(2, done.returncode, arguments)
            self.assertIn(text, done.stderr)
        shown = render("--help")
        self.assertEqual(0, shown.returncode)
        self.assertIn("--supersampling", shown.stdout)


if __name__ == "__main__":
    unittest.main()
