"""Where tables are, by the points of a lidar that looks at them from below or from above. Without ROS."""

from extperfc.tasks.heights import Heights
from extperfc.tasks.views import SQUARE_M, around

LOW_M, HIGH_M = 0.35, 1.2    # heights of table tops above the floor
FLAT_M = 0.08                # a square whose points at such heights differ by more is a wall, a leg, the side of a cabinet
MIN_POINTS = 3               # of a square
MIN_NEIGHBOURS = 2           # of the eight around it: a square alone is an edge of something
MAX_SQUARES = 200_000        # 2,000 m2 of squares with points at such heights; further ones are not kept


class Tops:
    """Squares of the floor, as in extperfc.tasks.views, above which everything that was seen at the height of tables lies in
    one plane."""

    def __init__(self):
        self._heights = Heights(SQUARE_M, LOW_M, HIGH_M, MAX_SQUARES)

    def add(self, points):
        """Points (x, y, z), N x 3, in a frame that stands on the floor."""
        self._heights.add(points)

    def squares(self):
        """{(i, j)} of tops."""
        flat = {square for square, (count, low, high) in self._heights.spans.items() if count >= MIN_POINTS and high - low <= FLAT_M}
        return {one for one in flat if sum(near in flat for near in around(one)) >= MIN_NEIGHBOURS}
