"""Lets the simulated robot map a floor that it does not know, and compares with the truth: how much of the floor that a
disc of 0.44 m gets to the map knows, how far the map is off, and what the robot touched.

A contact is counted as by tools/trial_navigate. The run succeeds when the explorer says that it has finished, the map knows
99 % of that floor, and nothing was touched.
"""

import argparse
import json
import math
import os
import pathlib
import sys
import time

import cv2
import numpy

from drive_world import PASSAGE_M, REPO, prepare, sim_config
from driven_contacts import reachable
from nav_robot import NavRobot
from pose_errors import Pose, compose, error, inverse
from ros_session import Stalled, run_trial

WS = pathlib.Path(os.environ.get("EXTPERFC_WS", REPO / ".ws"))
MIN_KNOWN = 0.99      # of that floor
OCCUPIED, FREE = 65, 20  # per cent
RASTER_M = 0.05       # at which maps are compared
ACTIVE = (0, 1, 6, 7)  # states of an action's goal that has not ended


def parse_arguments(argv):
    parser = argparse.ArgumentParser(prog="tools/trial_explore", description=__doc__,
                                     formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--world", default="office", metavar="NAME",
                        help="of config/worlds, random_floor, or a file; default: office")
    parser.add_argument("--seed", type=int, default=1, metavar="N", help="of the simulator's noise and random worlds; default: 1")
    parser.add_argument("--speed", type=float, default=1.0, metavar="FACTOR", help="simulated seconds per second; default: 1")
    parser.add_argument("--people", type=int, nargs="?", const=-1, default=0, metavar="N",
                        help="as of tools/trial_navigate; default: none")
    parser.add_argument("--limit", type=float, default=1200.0, metavar="S", help="simulated seconds; default: 1200")
    parser.add_argument("--fine", type=float, default=0.01, metavar="M", help="cells of the true map; default: 0.01")
    parser.add_argument("--json", type=pathlib.Path, metavar="FILE", help="write the result there")
    parser.add_argument("--out", type=pathlib.Path, default=WS / "explore", metavar="FOLDER",
                        help="where log, map (in the world's frame, for tools/trial_navigate --map) and its image\n"
                        "go; default: .ws/explore")
    options = parser.parse_args(argv)
    if options.people < -1:
        parser.error("--people N must be positive")
    if options.speed <= 0 or options.limit <= 0 or not 0.005 <= options.fine <= 0.1:
        parser.error("--speed and --limit must be positive, --fine within [0.005, 0.1]")
    return options


class Map:
    """The mapper's map, and where it lies in the world: it begins where the robot began."""

    def __init__(self, message, start):
        self.cells = numpy.array(message.data, numpy.int8).reshape(message.info.height, message.info.width)
        self.resolution_m, origin = message.info.resolution, message.info.origin.position
        self.x0, self.y0, self.start = origin.x, origin.y, start

    def cells_of(self, x, y):
        """Rows and columns of points of the world, perhaps outside."""
        cos, sin = math.cos(self.start.yaw), math.sin(self.start.yaw)
        dx, dy = x - self.start.x, y - self.start.y
        column = numpy.floor((cos * dx + sin * dy - self.x0) / self.resolution_m).astype(int)
        row = numpy.floor((-sin * dx + cos * dy - self.y0) / self.resolution_m).astype(int)
        return row, column

    def known(self, x, y):
        row, column = self.cells_of(x, y)
        inside = (row >= 0) & (column >= 0) & (row < self.cells.shape[0]) & (column < self.cells.shape[1])
        result = numpy.zeros(len(x), bool)
        result[inside] = self.cells[row[inside], column[inside]] >= 0
        return result


    def in_world(self):
        """The same cells in a grid along the world's axes, and the position of its lower left corner."""
        height, width = self.cells.shape
        cos, sin = math.cos(self.start.yaw), math.sin(self.start.yaw)
        corners = [(self.start.x + cos * x - sin * y, self.start.y + sin * x + cos * y)
                   for x in (self.x0, self.x0 + width * self.resolution_m)
                   for y in (self.y0, self.y0 + height * self.resolution_m)]
        low, high = numpy.min(corners, axis=0), numpy.max(corners, axis=0)
        columns, rows = numpy.round((high - low) / self.resolution_m).astype(int)
        x, y = numpy.meshgrid(low[0] + (numpy.arange(columns) + 0.5) * self.resolution_m,
                              low[1] + (numpy.arange(rows) + 0.5) * self.resolution_m)
        row, column = self.cells_of(x, y)
        inside = (row >= 0) & (column >= 0) & (row < height) & (column < width)
        cells = numpy.full(x.shape, -1, numpy.int8)
        cells[inside] = self.cells[row[inside], column[inside]]
        return cells, low


def save(grid, file):
    """As map_server reads it."""
    cells, low = grid.in_world()
    grey = numpy.full(cells.shape, 205, numpy.uint8)
    grey[(cells >= 0) & (cells < FREE)] = 254
    grey[cells >= OCCUPIED] = 0
    cv2.imwrite(str(file.with_suffix(".pgm")), grey[::-1])
    file.write_text(f"image: {file.with_suffix('.pgm').name}\nresolution: {grid.resolution_m:g}\n"
                    f"origin: [{low[0]:.6f}, {low[1]:.6f}, 0]\nnegate: 0\n"
                    f"occupied_thresh: {OCCUPIED / 100}\nfree_thresh: {FREE / 100}\n")


def floor_of(true_map, start):
    """Points (x, y) of the floor that the robot's inscribed circle covers somewhere."""
    passed = reachable(true_map, (start.x, start.y), PASSAGE_M).astype(numpy.uint8)
    size = 2 * int(PASSAGE_M / true_map.resolution_m) - 1
    covered = cv2.dilate(passed, cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (size, size))) > 0
    step = max(1, round(RASTER_M / true_map.resolution_m))
    rows, columns = numpy.nonzero(covered[::step, ::step])
    size_m = step * true_map.resolution_m
    return true_map.x0 + columns * size_m, true_map.y0 + rows * size_m


class Exploration:
    """Sends the goal and hears what comes of it; call after rospy.init_node."""

    def __init__(self, options, session):
        import actionlib
        import extperfc.msg
        import nav_msgs.msg
        import rospy
        import tf2_ros
        self.rospy, self.map = rospy, None
        self.robot = NavRobot(session.alive)
        self.goal = extperfc.msg.ExploreGoal(time_limit=options.limit)
        self.transforms = tf2_ros.Buffer()
        self.listener = tf2_ros.TransformListener(self.transforms)
        rospy.Subscriber("map", nav_msgs.msg.OccupancyGrid, self._on_map)
        self.client = actionlib.SimpleActionClient("explore", extperfc.msg.ExploreAction)
        self.robot.ready()
        self.robot.wait(lambda: self.map is not None, "the mapper's map")
        self.robot.wait(lambda: self.client.wait_for_server(rospy.Duration(0.1)), "the explorer")

    def _on_map(self, message):
        self.map = message

    def _on_feedback(self, feedback):
        at = feedback.goal.pose.position
        print(f"{self.robot.now() - self.begin:7.0f} s{feedback.known_area:7.0f} m2{feedback.frontiers:6d} frontiers, next "
              f"({at.x:.1f}, {at.y:.1f}){f', {feedback.failed_frontiers} failed' if feedback.failed_frontiers else ''}", flush=True)

    def run(self):
        """The result of the action, and the Drive."""
        self.robot.forget()
        self.begin, self.start = self.robot.now(), self.robot.pose()
        self.client.send_goal(self.goal, feedback_cb=self._on_feedback)
        while self.client.get_state() in ACTIVE:
            if not self.robot.alive():
                raise Stalled("roslaunch has ended")
            time.sleep(0.05)
        result = self.client.get_result()
        if result is None:
            raise Stalled("the explorer ended without a result")
        return result, self.robot.recorded(None, self.client.get_state(), result.message)

    def map_error_m(self):
        """How far the robot is from where it believes to be."""
        t = self.transforms.lookup_transform("map", "base_footprint", self.rospy.Time()).transform
        believed = Pose(t.translation.x, t.translation.y, 2 * math.atan2(t.rotation.z, t.rotation.w))
        return error(compose(inverse(self.start), self.robot.pose()), believed)[0]


def draw(grid, drive, unknown, file):
    """The map with the driven path; red is floor that it does not know."""
    image = numpy.full((*grid.cells.shape, 3), 160, numpy.uint8)
    image[(grid.cells >= 0) & (grid.cells < OCCUPIED)] = 245
    image[grid.cells >= OCCUPIED] = 40
    for row, column in zip(*grid.cells_of(*unknown)):
        if 0 <= row < image.shape[0] and 0 <= column < image.shape[1]:
            image[row, column] = (60, 60, 240)
    image = cv2.resize(image, None, fx=2, fy=2, interpolation=cv2.INTER_NEAREST)
    x, y = (numpy.array([getattr(pose, axis) for _, pose in drive.samples[::5]]) for axis in "xy")
    row, column = grid.cells_of(x, y)
    cv2.polylines(image, [numpy.stack([2 * column, 2 * row], 1).astype(numpy.int32)], False, (200, 110, 30), 2, cv2.LINE_AA)
    cv2.imwrite(str(file), image[::-1])


def run(options, world, true_map, session):
    session.launch("extperfc", "sim_exploration.launch", rviz="false", world=world, seed=options.seed,
                   real_time_factor=options.speed, sim_config=sim_config(options))
    session.join("trial_explore")
    exploration = Exploration(options, session)
    result, drive = exploration.run()
    row = {"world": options.world, "seed": options.seed, "people": options.people, "finished": drive.reached,
           "message": result.message, "goals_reached": result.goals_reached, "goals_failed": result.goals_failed,
           "seconds": drive.seconds, "driven_m": drive.driven_m, "contacts": drive.contacts(true_map),
           "contact_places": drive.contact_places(true_map), "person_contacts": sum(drive.person_contacts()),
           "map_error_m": exploration.map_error_m()}
    grid = Map(exploration.map, exploration.start)
    x, y = floor_of(true_map, exploration.start)
    known = grid.known(x, y)
    row.update(floor_m2=len(x) * RASTER_M ** 2, known=float(known.mean()))
    save(grid, options.out / f"map_{options.seed}.yaml")
    draw(grid, drive, (x[~known], y[~known]), options.out / f"map_{options.seed}.png")
    return report(options, row)


def report(options, row):
    if options.json:
        options.json.write_text(json.dumps(row, indent=1) + "\n")
    print(f"{row['world']}, seed {row['seed']}: {row['message']}\n"
          f"  {100 * row['known']:.1f} % of {row['floor_m2']:.0f} m2 known after {row['seconds']:.0f} s and "
          f"{row['driven_m']:.0f} m, {row['goals_failed']} goals failed\n"
          f"  contacts {row['contacts']}, with people {row['person_contacts']}; the robot is "
          f"{100 * row['map_error_m']:.1f} cm from where it believes to be")
    good = row["finished"] and row["known"] >= MIN_KNOWN and not row["contacts"] and not row["person_contacts"]
    return 0 if good else 1


def main(argv):
    options = parse_arguments(argv)
    world, true_map = prepare(options)
    return run_trial(options.out, lambda session: run(options, world, true_map, session))


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
