"""Detections against the truth: overlap, matching, sums."""

import unittest

import numpy

from truth import Box, Score, TrueObject, match, nearest, overlap


class Overlap(unittest.TestCase):
    def test_closed_forms(self):
        a = (0, 0, 10, 10)
        self.assertEqual(1.0, overlap(a, a))
        self.assertAlmostEqual(1 / 3, overlap(a, (5, 0, 15, 10)))
        self.assertAlmostEqual(0.25, overlap(a, (0, 0, 5, 5)))
        self.assertEqual(0.0, overlap(a, (10, 0, 20, 10)), "a common edge is no overlap")
        self.assertEqual(0.0, overlap(a, (20, 20, 30, 30)))
        self.assertEqual(0.0, overlap((5, 5, 5, 5), (5, 5, 5, 5)), "boxes without area")

    def test_is_symmetric_and_between_0_and_1(self):
        random = numpy.random.default_rng(1)
        for _ in range(200):
            a, b = (numpy.sort(random.uniform(0, 10, (2, 2)), axis=0).ravel() for _ in range(2))
            self.assertAlmostEqual(overlap(a, b), overlap(b, a))
            self.assertTrue(0.0 <= overlap(a, b) <= 1.0)


class Match(unittest.TestCase):
    def test_the_object_that_overlaps_most(self):
        visible = [Box("cube", (0, 0, 10, 10)), Box("cube", (2, 0, 12, 10))]
        self.assertEqual([1], match([Box("cube", (2, 0, 12, 11))], visible))

    def test_the_class_must_be_right(self):
        self.assertEqual([None], match([Box("cone", (0, 0, 10, 10))], [Box("cube", (0, 0, 10, 10))]))

    def test_an_object_is_found_once(self):
        twice = [Box("cube", (0, 0, 10, 10)), Box("cube", (0, 0, 10, 9))]
        self.assertEqual([0, None], match(twice, [Box("cube", (0, 0, 10, 10))]))

    def test_too_little_overlap(self):
        visible = [Box("cube", (0, 0, 10, 10))]
        self.assertEqual([None], match([Box("cube", (4, 0, 14, 10))], visible))
        self.assertEqual([0], match([Box("cube", (4, 0, 14, 10))], visible, min_overlap=0.4))

    def test_a_bad_match_does_not_take_the_object(self):
        detections = [Box("cube", (8, 0, 18, 10)), Box("cube", (0, 0, 10, 10))]
        self.assertEqual([None, 0], match(detections, [Box("cube", (0, 0, 10, 10))]))

    def test_nothing(self):
        self.assertEqual([], match([], [Box("cube", (0, 0, 1, 1))]))
        self.assertEqual([None], match([Box("cube", (0, 0, 1, 1))], []))


class NearestObject(unittest.TestCase):
    def test_of_the_same_class(self):
        objects = [TrueObject("cube", (1, 0, 0)), TrueObject("cone", (0.1, 0, 0)), TrueObject("cube", (0, 0, 2))]
        found = nearest("cube", (0, 0, 0), objects)
        self.assertEqual(objects[0], found.object)
        self.assertAlmostEqual(1.0, found.error_m)
        self.assertIsNone(nearest("sphere", (0, 0, 0), objects))


class Sums(unittest.TestCase):
    def test_two_frames(self):
        score = Score()
        score.add(3, [0, None, 1], [0.01, 0.03])
        score.add(1, [0], [0.02])
        self.assertEqual((2, 4, 3, 1), (score.frames, score.visible, score.found, score.false))
        text = "\n".join(score.summary())
        self.assertIn("found 3 of 4 visible objects in 2 frames (75 %), 1 false detections", text)
        self.assertIn("mean error 2.0 cm, 95 % are below 2.9 cm", text)

    def test_nothing_visible(self):
        score = Score()
        self.assertEqual([], score.summary())
        score.add(0, [], [])
        self.assertEqual(["found 0 of 0 visible objects in 1 frames, 0 false detections"], score.summary())


if __name__ == "__main__":
    unittest.main()
