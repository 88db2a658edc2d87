"""People for a world that has too few: each walks up and down a straight line that is free on the true floor plan. Knows no ROS."""

import math
import random
import re

import numpy
import yaml

CLEARANCE_M = 0.35   # of a line to what stands around
SHORTEST_M = 4.0     # a shorter walk would be a person who stands
START_M = 2.0        # nobody begins nearer to the robot's start
TRIES = 20000


def with_people(world, people):
    """The text of a world file with these people in place of its own; entries as in the file; an empty list takes all away."""
    text = re.sub(r"^people:.*\n(?:[ \t#].*\n|\n)*", "", world, flags=re.M)
    return text + "\n" + yaml.safe_dump({"people": people}, default_flow_style=None) if people else text


def is_free_line(true_map, start, end):
    steps = max(2, int(math.dist(start, end) / 0.05))
    return all(true_map.clearance_at(x, y) > CLEARANCE_M
               for x, y in zip(numpy.linspace(start[0], end[0], steps), numpy.linspace(start[1], end[1], steps)))


def more_people(true_map, places, count, seed, robot_start=(0.0, 0.0)):
    """Entries for a world file's `people`, as many as wanted; `places`: an array of (x, y) that can be stood at."""
    rng = random.Random(seed)
    found = []
    for _ in range(TRIES):
        if len(found) == count:
            return found
        start, end = (tuple(round(float(value), 2) for value in places[rng.randrange(len(places))]) for _ in range(2))
        if math.dist(start, end) < SHORTEST_M or math.dist(start, robot_start) < START_M:
            continue
        if is_free_line(true_map, start, end):
            found.append({"name": f"walker_{len(found) + 1}", "path": [list(start), list(end)],
                          "speed": round(rng.uniform(0.6, 1.1), 2), "colour": [round(rng.uniform(0.2, 0.7), 2) for _ in "rgb"]})
    raise ValueError(f"the floor plan has no room for {count} walks of {SHORTEST_M:g} m in a straight line")
