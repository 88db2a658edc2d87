"""Places and verdicts of the grasp trials."""

import math
import random
import unittest

import numpy

import grasp_scene as scene

CAMERA = (640, 480, 615.0, 319.5, 239.5)


def camera_pose():
    """The head's camera: 1.507 m above the floor, 50 degrees down."""
    pitch = math.radians(50)
    pose = numpy.eye(4)
    pose[:3, 0], pose[:3, 2] = (0, -1, 0), (math.cos(pitch), 0, -math.sin(pitch))
    pose[:3, 1] = numpy.cross(pose[:3, 2], pose[:3, 0])
    pose[:3, 3] = (0.23, 0.03, 1.507)
    return pose


def rotation_about(axis, angle):
    """Rotation about x (0), y (1) or z (2)."""
    c, s = math.cos(angle), math.sin(angle)
    a, b = [(1, 2), (2, 0), (0, 1)][axis]
    result = numpy.eye(3)
    result[a, a] = result[b, b] = c
    result[a, b], result[b, a] = -s, s
    return result


class Places(unittest.TestCase):
    def test_objects_are_as_far_as_wanted_in_the_image_and_on_the_tray(self):
        rng, pose = random.Random(1), camera_pose()
        for shape in scene.SHAPES:
            for distance in (0.3, 0.4, 0.5):
                for _ in range(50):
                    place_pose = scene.draw_place_pose(rng, shape, distance, CAMERA, pose)
                    middle = scene.middle(shape, place_pose)
                    self.assertAlmostEqual(distance, numpy.linalg.norm(middle - pose[:3, 3]), places=9)
                    self.assertTrue(scene.on_tray(place_pose.x, place_pose.y))
                    size = scene.SHAPES[shape]
                    for corner in ((i, j, k) for i in (-1, 1) for j in (-1, 1) for k in (-1, 1)):
                        point = middle + numpy.array(corner) * (size.width / 2, size.width / 2, size.height / 2)
                        x, y, z = (numpy.linalg.inv(pose) @ numpy.append(point, 1))[:3]
                        self.assertTrue(0 < 615 * x / z + 319.5 < 640 and 0 < 615 * y / z + 239.5 < 480, (shape, distance))

    def test_the_body_is_where_it_was_put_when_the_middle_is_known(self):
        place_pose = scene.PlacePose(0.5, 0.1, 1.1, 0.7)
        for shape in scene.SHAPES:
            middle = numpy.eye(4)
            middle[:3, :3], middle[:3, 3] = rotation_about(2, place_pose.yaw), scene.middle(shape, place_pose)
            body = scene.body_of(shape, middle)
            self.assertLess(abs(body[:3, 3] - scene.body_position(shape, place_pose)).max(), 1e-12, shape)
            self.assertTrue((body[:3, :3] == middle[:3, :3]).all(), shape)
        lying = numpy.eye(4)
        lying[:3, :3] = rotation_about(1, math.pi / 2)  # its tip points along x, so that its heavy end is behind the middle
        self.assertAlmostEqual(-0.0225, scene.body_of("cone", lying)[0, 3])

    def test_a_distance_that_cannot_be_is_told(self):
        with self.assertRaises(scene.NoPlace):
            scene.draw_place_pose(random.Random(1), "cube", 3.0, CAMERA, camera_pose())

    def test_the_other_pose_is_at_some_distance_on_the_same_tray(self):
        rng = random.Random(2)
        for _ in range(200):
            place_pose = scene.draw_place_pose(rng, "cone", 0.4, CAMERA, camera_pose())
            other = scene.draw_other(rng, place_pose)
            self.assertTrue(scene.on_tray(other.x, other.y))
            self.assertEqual(place_pose.top, other.top)
            self.assertGreaterEqual(math.hypot(other.x - place_pose.x, other.y - place_pose.y), scene.OTHER_PLACE_M[0] - 1e-9)

    def test_the_same_seed_gives_the_same_places(self):
        draw = lambda seed: scene.draw_place_pose(random.Random(seed), "cube", 0.4, CAMERA, camera_pose())  # noqa: E731
        self.assertEqual(draw(3), draw(3))
        self.assertNotEqual(draw(3), draw(4))


class Verdicts(unittest.TestCase):
    place_pose = scene.PlacePose(0.5, 0.1, 1.1, 0.0)

    def placed(self, shape, off=(0, 0, 0), rotation=numpy.eye(3)):
        return scene.is_placed(shape, scene.body_position(shape, self.place_pose) + off, rotation, self.place_pose)

    def test_what_stands_there_is_placed(self):
        for shape in scene.SHAPES:
            self.assertTrue(self.placed(shape, (0.01, -0.02, 0.001), rotation_about(2, 1.0)))

    def test_what_is_elsewhere_fell_or_hangs_in_the_air_is_not(self):
        for shape in scene.SHAPES:
            self.assertFalse(self.placed(shape, (0.04, 0, 0)))
            self.assertFalse(self.placed(shape, (0, 0, 0.02)))
            self.assertFalse(self.placed(shape, (0, 0, -1.1)))
        self.assertFalse(self.placed("cone", rotation=rotation_about(1, 1.5)))
        self.assertFalse(self.placed("cone", rotation=rotation_about(0, math.pi)), "upside down")
        self.assertFalse(self.placed("cube", rotation=rotation_about(0, 0.5)))

    def test_a_cube_may_stand_on_any_face_and_a_sphere_anyhow(self):
        self.assertTrue(self.placed("cube", rotation=rotation_about(0, math.pi / 2)))
        self.assertTrue(self.placed("sphere", rotation=rotation_about(0, 0.5)))

    def test_held_is_what_rose_with_the_hand(self):
        self.assertTrue(scene.is_held(0.099, 0.1, 0.01))
        self.assertFalse(scene.is_held(0.0, 0.1, 0.01), "the hand is there, the object stands")
        self.assertFalse(scene.is_held(0.1, 0.1, 0.3), "it flew away")

    def test_what_is_said_is_held_against_what_is(self):
        self.assertEqual(["success", "false success", "false failure", "reported failure"],
                         [scene.outcome(said, true) for said, true in
                          ((True, True), (True, False), (False, True), (False, False))])

    def test_the_table_counts_by_shape_and_distance_and_lists_failures(self):
        trials = [{"shape": "cube", "distance_m": 0.3, "outcome": o, "stage": "pick", "code": c, "message": m, "pick_s": 12.0}
                  for o, c, m in (("success", 0, ""), ("reported failure", 31, "no grasp"), ("false success", 0, "fine"))]
        lines = scene.table(trials)
        self.assertEqual(["cube", "0.3", "m", "1", "3", "1", "1", "0", "12.0", "s", "--"], lines[1].split())
        self.assertEqual(4, len(lines))
        self.assertIn("code 31: no grasp", lines[2])


if __name__ == "__main__":
    unittest.main()
