"""The office is mapped while twenty people walk about: they leave no trace in the map."""

import unittest

from test_mapping_office import OUT, OfficeCase

ROUNDS = 2
SECONDS = 1500
MIN_GOALS = 24  # of 54: people stand in its path for minutes, and the robot gives a goal up
# From where to where people walk, there and back.
WALKS = [((-9.5, y), (9.5, y)) for y in (2.8, 3.4, 4.0, -2.8, -3.4, -4.0)] + [
    ((-11.4, -3.9), (-11.4, 3.9)), ((-10.6, -3.9), (-10.6, 3.9)), ((11.4, -3.9), (11.4, 3.9)), ((10.6, -3.9), (10.6, 3.9)),
    ((-0.6, -3.8), (-0.6, 3.8)), ((0.6, -3.8), (0.6, 3.8)), ((-9.0, 3.1), (-1.5, 3.1)), ((1.5, 3.1), (9.0, 3.1)),
    ((-9.0, -3.1), (-1.5, -3.1)), ((1.5, -3.1), (9.0, -3.1)), ((-6.0, 3.7), (6.0, 3.7)), ((-6.0, -3.7), (6.0, -3.7)),
    ((-3.0, 2.9), (8.0, 2.9)), ((-8.0, -2.9), (3.0, -2.9))]


class MappingPeople(OfficeCase):
    # While the robot pushes against a person, until its wheels are known to spin.
    max_error_m, max_error_deg = 0.5, 5.0

    def test_people_leave_no_trace(self):
        """But for the moments above, the bounds are those of the drive without people: what they leave lowers the precision."""
        self.assertEqual(len(WALKS), 20)
        self.map_the_office(OUT / "people", WALKS, ROUNDS, SECONDS, MIN_GOALS)


if __name__ == "__main__":
    unittest.main()
