"""Who walks where in tools/demo follow, and what its map should not show. Knows no ROS."""

import math
import random
import re

import cv2
import numpy

from walkers import with_people

# Of config/worlds/office.yaml: a passage and two rings of corridors, which meet at its ends.
NORTH, SOUTH = (0.0, 3.75), (0.0, -3.5)
ROUTES = {"passage": [], "west": [(-11.0, 3.75), (-11.0, -3.5)], "east": [(11.0, 3.75), (11.0, -3.5)]}
START, MEETING = (4.0, 3.75), (0.0, 1.4)  # out of the robot's sight, and before the robot, to which the leader comes
LEADER, SPEED_M_S, STANDS_S = "anna", 0.55, (8.0, 0.0, 8.0)
OTHER = {"name": "dan", "speed": 0.7, "colour": [0.3, 0.3, 0.32]}
OTHER_Y, OTHER_X = -2.9, (3.0, 9.5)  # walks up and down the south corridor, along its wall, so that the robot can pass
WALL_M = 0.2        # from the true map's obstacles to a ghost, at least
GHOST_CELLS = 12    # in a group: a leg's width of cells is noise


def leader_path(seed, length_m):
    """Corners from START on, through passage and rings without going back, at least so long."""
    rng = random.Random(f"follow {seed}")
    corners, at, last = [START, NORTH, MEETING, NORTH], NORTH, "passage"
    while _length(corners) < length_m:
        last = rng.choice([one for one in sorted(ROUTES) if one != last])
        corners += ROUTES[last] if at == NORTH else ROUTES[last][::-1]
        at = SOUTH if at == NORTH else NORTH
        corners.append(at)
    return corners


def meets_s():
    """When the leader walks away from the robot, from the start of the simulation on."""
    return sum(STANDS_S) + _length([START, NORTH, MEETING]) / SPEED_M_S


def _length(corners):
    return sum(math.dist(a, b) for a, b in zip(corners, corners[1:]))


def write_world(office, seed, seconds, file):
    """The office with the leader and another person."""
    path = leader_path(seed, SPEED_M_S * seconds + 20.0)
    leader = {"name": LEADER, "path": [list(corner) for corner in path], "speed": SPEED_M_S, "stands": list(STANDS_S),
              "colour": [0.62, 0.24, 0.20]}
    rng = random.Random(f"other {seed}")
    other = {**OTHER, "path": [[round(rng.uniform(*OTHER_X), 2), OTHER_Y], [round(-rng.uniform(*OTHER_X), 2), OTHER_Y]]}
    file.write_text(with_people(office.read_text(), [leader, other]))


def write_urdf(urdf, file, pitch_rad=-0.05):
    """The robot with its camera looking ahead, at faces, and its meshes beside it."""
    joint = re.compile(r'(<joint name="camera_joint".*?<origin[^>]*rpy=")[^"]*(")', re.S)
    text, found = joint.subn(rf"\g<1>0 {pitch_rad:g} 0\g<2>", urdf.read_text(), count=1)
    if found != 1:
        raise ValueError(f"{urdf} has no camera_joint with an origin")
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_text(text)
    meshes = file.parent / "meshes"
    if not meshes.exists():
        meshes.symlink_to(urdf.resolve().parent / "meshes")


def ghosts(cells, resolution_m, origin, world_T_map, true_map):
    """Middles (x, y) in the world of groups of occupied cells of a map that stand where the true map is free, WALL_M from
    everything. cells[y, x]; world_T_map: (x, y, yaw); true_map: driven_contacts.TrueMap."""
    rows, columns = numpy.nonzero(cells >= 65)
    x, y = origin[0] + (columns + 0.5) * resolution_m, origin[1] + (rows + 0.5) * resolution_m
    cos, sin = math.cos(world_T_map[2]), math.sin(world_T_map[2])
    world = numpy.column_stack([world_T_map[0] + cos * x - sin * y, world_T_map[1] + sin * x + cos * y])
    wrong = numpy.array([true_map.clearance_at(*place) > WALL_M for place in world], bool)
    image = numpy.zeros(cells.shape, numpy.uint8)
    image[rows[wrong], columns[wrong]] = 1
    _, labels, stats, _ = cv2.connectedComponentsWithStats(image, connectivity=8)
    group = labels[rows, columns]
    return [tuple(world[wrong & (group == one)].mean(axis=0)) for one in range(1, len(stats))
            if stats[one, cv2.CC_STAT_AREA] >= GHOST_CELLS]
