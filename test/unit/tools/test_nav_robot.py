"""What a drive touched, and where. Without ROS."""

import pathlib
import sys
import unittest

import numpy

REPO = pathlib.Path(__file__).resolve().parents[3]
sys.path.insert(0, str(REPO / "tools" / "lib"))

from driven_contacts import TrueMap  # noqa: E402
from nav_robot import Drive  # noqa: E402
from pose_errors import Pose  # noqa: E402


def wall_at(x):
    """A map of 4 x 4 m about the origin with a wall along y."""
    cells = numpy.zeros((400, 400), numpy.int8)
    cells[:, int((x + 2) / 0.01)] = 100
    return TrueMap(cells, 0.01, -2.0, -2.0)


def drive(samples, bumps=(), people=(), said=()):
    return Drive(Pose(1, 0, 0), 3, "", samples, people, 1.0, bumps, said)


class ContactPlaces(unittest.TestCase):
    def test_where_each_begins_and_what_the_navigator_said(self):
        xs = (0.0, 0.4, 0.65, 0.66, 0.3, 0.7)
        samples = [(float(i), Pose(x, 0.0, 0.0)) for i, x in enumerate(xs)]
        places = drive(samples, said=[(0.0, "controlling"), (4.0, "recovering: back off")]).contact_places(wall_at(1.05))
        self.assertEqual([(2.0, 0.65, "controlling"), (5.0, 0.7, "recovering: back off")],
                         [(place["time_s"], place["x"], place["navigator"]) for place in places])

    def test_what_it_stands_against_counts_too(self):
        samples = [(0.0, Pose(0, 0, 0)), (1.0, Pose(0.1, 0, 0))]
        places = drive(samples, bumps=[1.0]).contact_places(wall_at(1.5))
        self.assertEqual([("stands against something", 0.1, "")], [(place["what"], place["x"], place["navigator"]) for place in places])

    def test_a_person_is_named(self):
        places = drive([(0.0, Pose(0, 0, 0))], bumps=[0.0], people=[(0.0, [(0.7, 0.0)])]).contact_places(wall_at(1.5))
        self.assertEqual(["stands before a person"], [place["what"] for place in places])

    def test_none(self):
        self.assertEqual([], drive([(0.0, Pose(0, 0, 0))]).contact_places(wall_at(1.5)))


if __name__ == "__main__":
    unittest.main()
