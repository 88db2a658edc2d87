"""Where tables, cube and goal are in tools/demo tour. Knows no ROS."""

import math
import random
import re
from dataclasses import dataclass

ROOMS = {"study": 1.0, "kitchen": -1.0}  # of config/worlds/flat.yaml: sign of y; mirror images but for what stands at their outer walls
CUBE_M = 0.045
FROM_EDGE_M = (0.12, 0.20)  # of the cube's middle from the table's near edge
FROM_END_M = 0.35           # and from the ends of this edge
NEIGHBOURS = {"sphere": (0.05, 0.025), "cone": (0.06, 0.0225)}  # on the cube's table, so that it is not alone: width, origin's height
LIFT_M = 5e-4               # of what is put onto a table


@dataclass(frozen=True)
class Table:
    """A table; yaw_deg 180: its near edge looks along -x; 90: along +y; -90: along -y."""
    x: float
    y: float
    yaw_deg: float
    depth: float
    width: float
    height: float

    def place(self, from_edge, along):
        """(x, y): so far from the near edge, and along it from its middle."""
        yaw = math.radians(self.yaw_deg)
        ahead = self.depth / 2 - from_edge
        return (self.x + ahead * math.cos(yaw) - along * math.sin(yaw), self.y + ahead * math.sin(yaw) + along * math.cos(yaw))

    def draw(self, rng):
        """A place near the edge."""
        room = self.width / 2 - FROM_END_M
        return self.place(rng.uniform(*FROM_EDGE_M), rng.uniform(-room, room))


@dataclass(frozen=True)
class Task:
    """cube: (x, y, yaw) on the table of `room`; to: (x, y, z) of its middle on the other."""
    tables: dict
    room: str
    cube: tuple
    other: str
    to: tuple
    neighbours: dict  # name: (x, y, z)

    @property
    def top(self):
        return self.tables[self.room].height


def draw_table(rng, side):
    """Of a room: at its far wall, or at the wall between the rooms, which its near edge looks away from."""
    depth, width, height = rng.uniform(0.6, 0.8), rng.uniform(1.2, 1.6), round(rng.uniform(0.62, 0.76), 3)
    if rng.random() < 0.5:
        return Table(6.46 - depth / 2, side * rng.uniform(1.3, 2.1), 180.0, depth, width, height)
    return Table(rng.uniform(5.2, 5.6), side * (0.08 + depth / 2), 90.0 * side, depth, width, height)


def draw_task(seed):
    rng = random.Random(f"tour {seed}")
    tables = {room: draw_table(rng, side) for room, side in ROOMS.items()}
    room, other = rng.sample(sorted(ROOMS), 2)
    cube = (*tables[room].draw(rng), rng.uniform(-math.pi, math.pi))
    to = (*tables[other].draw(rng), tables[other].height + CUBE_M / 2)
    neighbours = {}
    for name, (width, origin) in NEIGHBOURS.items():
        neighbours[name] = (*_beside(rng, tables[room], [cube, *neighbours.values()], width), tables[room].height + origin + LIFT_M)
    return Task(tables, room, cube, other, to, neighbours)


def _beside(rng, table, others, width):
    """A place on a table, a hand's breadth from others."""
    for _ in range(1000):
        place = table.place(rng.uniform(0.15, table.depth - 0.1), rng.uniform(0.1 - table.width / 2, table.width / 2 - 0.1))
        if all(math.dist(place, other[:2]) > 0.16 + width for other in others):
            return place
    raise ValueError("the table is too small")


def write_world(flat, task, file):
    """The flat with the tables of a task."""
    text = flat.read_text()
    for room, table in task.tables.items():
        wanted = (f"{{name: {room}_table, at: [{table.x:.3f}, {table.y:.3f}], yaw_deg: {table.yaw_deg:g}, "
                  f"size: [{table.depth:.3f}, {table.width:.3f}, {table.height:.3f}],")
        text, found = re.subn(rf"\{{name: {room}_table, at: \[[^\]]*\], size: \[[^\]]*\],", wanted, text)
        if found != 1:
            raise ValueError(f"{flat} has no {room}_table with at and size")
    at = task.tables[task.room]
    for name in ("cube", "sphere", "cone"):  # they wait in the middle of a table; the demo puts them where they belong
        text = re.sub(rf"(name: {name}, on: )\w+, at: \[[^\]]*\]",
                      rf"\g<1>{task.room}_table, at: [{at.x:.3f}, {at.y + {'cube': 0, 'sphere': 0.12, 'cone': -0.12}[name]:.3f}]", text)
    file.write_text(text)
