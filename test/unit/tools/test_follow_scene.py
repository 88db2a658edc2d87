"""Who walks where in tools/demo follow, and what counts as a ghost in its map."""

import itertools
import math
import pathlib
import sys
import tempfile
import unittest

import numpy
import yaml

REPO = pathlib.Path(__file__).resolve().parents[3]
sys.path.insert(0, str(REPO / "tools" / "lib"))

import driven_contacts  # noqa: E402
import follow_scene as scene  # noqa: E402


class Paths(unittest.TestCase):
    def test_they_are_long_enough_and_never_go_back(self):
        for seed in range(30):
            path = scene.leader_path(seed, 90.0)
            self.assertGreater(scene._length(path), 90.0)
            for a, _, c in zip(path[2:], path[3:], path[4:]):
                self.assertNotEqual(a, c, f"seed {seed}")
            for a, b in itertools.pairwise(path):
                self.assertTrue(a[0] == b[0] or a[1] == b[1], f"seed {seed}: along the corridors")

    def test_seeds_differ_and_a_seed_is_always_the_same(self):
        self.assertEqual(scene.leader_path(3, 90.0), scene.leader_path(3, 90.0))
        self.assertGreater(len({tuple(scene.leader_path(seed, 90.0)) for seed in range(10)}), 5)


class Files(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.file = pathlib.Path(folder.name) / "made"

    def test_the_world_has_the_two_and_everything_else(self):
        office = REPO / "config" / "worlds" / "office.yaml"
        scene.write_world(office, 1, 60.0, self.file)
        made, given = yaml.safe_load(self.file.read_text()), yaml.safe_load(office.read_text())
        self.assertEqual(["anna", "dan"], [person["name"] for person in made["people"]])
        self.assertEqual(list(scene.MEETING), made["people"][0]["path"][2], "the leader comes to the robot")
        self.assertEqual(given["objects"], made["objects"])

    def test_the_camera_looks_ahead(self):
        urdf = REPO / "urdf" / "mobile_baxter.urdf"
        scene.write_urdf(urdf, self.file, -0.05)
        made, given = self.file.read_text().splitlines(), urdf.read_text().splitlines()
        changed = [(new, old) for new, old in zip(made, given) if new != old]
        self.assertEqual(1, len(changed))
        self.assertIn('rpy="0 -0.05 0"', changed[0][0])
        self.assertTrue((self.file.parent / "meshes" / "chassis_hull.stl").exists())

    def test_a_robot_without_a_camera_is_refused(self):
        self.file.write_text("<robot/>")
        with self.assertRaisesRegex(ValueError, "no camera_joint"):
            scene.write_urdf(self.file, self.file)


class Ghosts(unittest.TestCase):
    """A free room of 4 x 4 m, mapped by a robot that began at (1, 1) and looked along y."""

    def setUp(self):
        truth = numpy.zeros((80, 80), numpy.int8)
        truth[[0, -1], :] = truth[:, [0, -1]] = 100
        self.truth = driven_contacts.TrueMap(truth, 0.05, 0.0, 0.0)
        self.start = (1.0, 1.0, math.pi / 2)
        self.cells = numpy.zeros((80, 80), numpy.int8)

    def mark(self, x, y, half):
        """Where the world's (x, y) is in the map: it lies ahead and to the left of the start."""
        ahead, left = y - 1.0, -(x - 1.0)
        column, row = round((ahead + 2.0) / 0.05), round((left + 4.0) / 0.05)
        self.cells[row - half:row + half, column - half:column + half] = 100

    def found(self):
        return scene.ghosts(self.cells, 0.05, (-2.0, -4.0), self.start, self.truth)

    def test_what_stands_where_nothing_is(self):
        self.mark(2.5, 2.0, 3)
        (x, y), = self.found()
        self.assertAlmostEqual(2.5, x, delta=0.06)
        self.assertAlmostEqual(2.0, y, delta=0.06)

    def test_walls_and_single_cells_are_none(self):
        self.mark(2.5, 2.0, 1)
        self.mark(2.0, 3.9, 3)
        self.assertEqual([], self.found())


if __name__ == "__main__":
    unittest.main()
