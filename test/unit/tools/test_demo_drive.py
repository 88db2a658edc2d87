"""The demonstration's path of the base."""

import math
import unittest

from demo_drive import AHEAD_M, PERIOD_S, SWING_M, command, swing


class Path(unittest.TestCase):
    def test_rates_are_the_derivatives(self):
        step = 1e-5
        for i in range(50):
            time_s = i * PERIOD_S / 50
            before, after = swing(time_s - step), swing(time_s + step)
            for value, rate in ((0, 2), (1, 3)):
                self.assertAlmostEqual((after[value] - before[value]) / (2 * step), swing(time_s)[rate], places=6)

    def test_looks_at_the_same_place_and_stays_near(self):
        for i in range(50):
            y, yaw, _, _ = swing(i * 0.3)
            self.assertLessEqual(abs(y), SWING_M + 1e-9)
            self.assertAlmostEqual(0.0, y + AHEAD_M * math.tan(yaw))

    def test_a_robot_that_obeys_follows_from_a_wrong_start(self):
        x, y, yaw, step = 0.1, -0.1, 0.2, 0.02
        for i in range(1000):
            vx, vy, wz = command(i * step, x, y, yaw)
            x, y = (x + step * (math.cos(yaw) * vx - math.sin(yaw) * vy),
                    y + step * (math.sin(yaw) * vx + math.cos(yaw) * vy))
            yaw += step * wz
        to_y, to_yaw, _, _ = swing(1000 * step)
        for error in (x, y - to_y, yaw - to_yaw):
            self.assertAlmostEqual(0.0, error, delta=0.005)


if __name__ == "__main__":
    unittest.main()
