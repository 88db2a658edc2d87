"""urdf/ is what urdf/generate.py writes, a valid URDF, light enough to draw, and leaves the lidar its view."""

import math
import pathlib
import re
import shutil
import struct
import subprocess
import sys
import tempfile
import unittest
import xml.etree.ElementTree

REPO = pathlib.Path(__file__).resolve().parents[2]
URDF = REPO / "urdf/mobile_baxter.urdf"
MAX_TRIANGLES = 25_000
PREFIX = "package://extperfc/"


def generate(folder, *arguments):
    return subprocess.run([sys.executable, str(folder / "generate.py"), *arguments], capture_output=True, text=True)


def triangles(path):
    """Of a binary STL file, each as nine coordinates."""
    data = path.read_bytes()
    assert len(data) == 84 + 50 * struct.unpack_from("<I", data, 80)[0], f"{path} is damaged"
    return [values[3:12] for values in struct.iter_unpack("<12fH", data[84:])]


def meshes():
    """Path of every visual's mesh, as often as it is used."""
    names = re.findall(r'<mesh filename="([^"]+)"', URDF.read_text(encoding="utf-8"))
    return [REPO / name[len(PREFIX):] for name in names if name.startswith(PREFIX)]


class Generated(unittest.TestCase):
    def test_files_are_in_step_with_the_generator(self):
        done = generate(REPO / "urdf", "--check")
        self.assertEqual(0, done.returncode, done.stdout + done.stderr)

    def test_check_notices_changed_missing_and_stray_files(self):
        with tempfile.TemporaryDirectory() as folder:
            copy = pathlib.Path(folder) / "urdf"
            shutil.copytree(REPO / "urdf", copy)
            one, other = sorted((copy / "meshes").glob("*.stl"))[:2]
            one.unlink()
            damaged = bytearray(other.read_bytes())
            damaged[-20] ^= 0x40
            other.write_bytes(bytes(damaged))
            (copy / "meshes/stray.stl").write_bytes(b"")
            with open(copy / "mobile_baxter.urdf", "a", encoding="utf-8") as file:
                file.write("\n")
            done = generate(copy, "--check")
            self.assertEqual(1, done.returncode)
            for name in (one.name, other.name, "stray.stl", "mobile_baxter.urdf"):
                self.assertIn(name, done.stdout)
            self.assertEqual(0, generate(copy).returncode)
            self.assertEqual("urdf/ is in step\n", generate(copy, "--check").stdout)


class Description(unittest.TestCase):
    @unittest.skipUnless(shutil.which("check_urdf"), "check_urdf is not installed (Debian: liburdfdom-tools)")
    def test_check_urdf_accepts_it(self):
        done = subprocess.run(["check_urdf", str(URDF)], capture_output=True, text=True)
        self.assertEqual(0, done.returncode, done.stdout + done.stderr)
        self.assertIn("root Link: base_footprint", done.stdout)

    def test_every_material_has_a_colour(self):
        root = xml.etree.ElementTree.parse(URDF).getroot()
        coloured = {node.get("name") for node in root.findall("material") if node.find("color") is not None}
        used = {node.get("name") for node in root.findall("link/visual/material")}
        self.assertEqual(used, coloured)

    def test_meshes_are_few_and_closed(self):
        total = sum(len(triangles(path)) for path in meshes())
        self.assertLess(total, MAX_TRIANGLES)
        self.assertGreater(total, 1000)
        for path in sorted(set(meshes())):
            with self.subTest(path.name):
                self.assertGreater(volume(triangles(path)), 0, "turned inside out")
                self.assertEqual([], open_edges(triangles(path)) if path.name not in OPEN else [])


OPEN = {"lower_shoulder_caps.stl", "lower_elbow_caps.stl", "lower_forearm_caps.stl"}  # their open ends lie inside


def open_edges(solid):
    """Edges that are not passed once in each direction: a hole, or a triangle turned inside out."""
    edges = {}
    for values in solid:
        corners = [tuple(round(c, 5) for c in values[i:i + 3]) for i in (0, 3, 6)]
        for a, b in zip(corners, corners[1:] + corners[:1]):
            if a != b:
                edges[a, b] = edges.get((a, b), 0) + 1
    return [edge for edge, count in edges.items() if edges.get(edge[::-1], 0) != count]


def volume(solid):
    """Signed: positive when the triangles face outwards."""
    return sum(ax * (by * cz - bz * cy) + ay * (bz * cx - bx * cz) + az * (bx * cy - by * cx)
               for ax, ay, az, bx, by, bz, cx, cy, cz in solid) / 6


class Lidar(unittest.TestCase):
    def test_the_outer_rings_pass_between_chassis_and_plate(self):
        """15 degrees up and down, in every direction in which no post stands."""
        slope, scan = math.tan(math.radians(15)), 0.2872
        for name, above in (("birdcage_plate", True), ("chassis_deck", False)):
            for values in triangles(REPO / f"urdf/meshes/{name}.stl"):
                for x, y, z in (values[0:3], values[3:6], values[6:9]):
                    limit = slope * math.hypot(x, y)
                    self.assertGreater((z - scan) if above else (scan - z), limit - 1e-4, f"{name} {x} {y} {z}")


if __name__ == "__main__":
    unittest.main()
