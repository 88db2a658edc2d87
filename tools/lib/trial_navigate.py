"""Sends the simulated robot to random goals, with localizer and navigator running, and compares with the truth: how many
goals it reached, how often its true footprint touched the true map or a person, how fast and how far it drove.

A contact is counted when the base stands against something (the simulator says so), or when the middle of an occupied cell of
the true map (cells of 1 cm by default) comes under the chassis without padding. People stop in front of the robot and do not
step aside; a contact with one counts as caused by the robot while it moves.
"""

import argparse
import json
import math
import os
import pathlib
import random
import re
import sys

import cv2
import numpy
import yaml

from drive_world import REPO, places_of, prepare, sim_config
from driven_contacts import CHASSIS
from nav_robot import NavRobot, random_goal
from pose_errors import Pose
from ros_session import run_trial

WS = pathlib.Path(os.environ.get("EXTPERFC_WS", REPO / ".ws"))
COLUMNS = ("goal", "result", "end", "time", "planned", "driven", "ratio", "speed", "touched", "people")


def finite(text):
    """A number of the command line, not nan or inf."""
    value = float(text)
    if not math.isfinite(value):
        raise argparse.ArgumentTypeError(f"{text} is no place")
    return value


def parse_arguments(argv):
    parser = argparse.ArgumentParser(prog="tools/trial_navigate", description=__doc__,
                                     formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--goals", type=int, default=10, metavar="N", help="default: 10")
    parser.add_argument("--goal", type=finite, nargs=3, action="append", metavar=("X", "Y", "YAW"),
                        help="instead of random goals [m, rad]; of several, one after the other and again from the first;\n"
                        "repeatable")
    parser.add_argument("--world", default="office", metavar="NAME",
                        help="of config/worlds, random_floor, or a file; default: office")
    parser.add_argument("--seed", type=int, default=1, metavar="N",
                        help="of the goals, the simulator's noise and random worlds; default: 1")
    parser.add_argument("--speed", type=float, default=1.0, metavar="FACTOR",
                        help="simulated seconds per second; default: 1")
    parser.add_argument("--people", type=int, nargs="?", const=-1, default=0, metavar="N",
                        help="with the world's people; of random_floor: one in the corridor; with N, as many as that: the\n"
                        "people of the world's file first, then others by the seed who walk up and down straight lines;\n"
                        "default: none")
    parser.add_argument("--base", choices=("holonomic", "differential"), default="holonomic", help="default: holonomic")
    parser.add_argument("--map", type=pathlib.Path, metavar="FILE",
                        help="YAML file of a map in the world's frame, as tools/trial_explore writes it: localizer and navigator\n"
                        "know that one; default: the true one")
    parser.add_argument("--close-door", action="store_true",
                        help="a carton closes a door on its path, once for each goal whose path leads through one")
    parser.add_argument("--limit", type=float, default=300.0, metavar="S", help="simulated seconds for a goal; default: 300")
    parser.add_argument("--fine", type=float, default=0.01, metavar="M", help="cells of the true map; default: 0.01")
    parser.add_argument("--param", action="append", default=[], metavar="KEY=VALUE",
                        help="parameter of the navigator in place of that of config/navigator.yaml; repeatable")
    parser.add_argument("--json", type=pathlib.Path, metavar="FILE", help="write the results there")
    parser.add_argument("--out", type=pathlib.Path, default=WS / "navigate", metavar="FOLDER",
                        help="where the log, the parameters and the images of the paths go; default: .ws/navigate")
    options = parser.parse_args(argv)
    for text in options.param:
        if not re.fullmatch(r"\w+=.+", text):
            parser.error(f"--param must be KEY=VALUE, not {text}")
    if options.people < -1:
        parser.error("--people N must be positive")
    if options.map and not options.map.exists():
        parser.error(f"there is no map {options.map}: tools/trial_explore makes one")
    if options.goals < 1 or options.speed <= 0 or options.limit <= 0 or not 0.005 <= options.fine <= 0.1:
        parser.error("--goals, --speed and --limit must be positive, --fine within [0.005, 0.1]")
    return options


def write_params(options):
    """The navigator's configuration with the user's parameters."""
    params = yaml.safe_load((REPO / "config" / "navigator.yaml").read_text())
    params["holonomic_robot"] = options.base == "holonomic"
    for key in ("scan_timeout_s", "odom_timeout_s", "transform_tolerance"):  # latency of this computer counts more often
        params[key] *= max(1.0, options.speed)
    for text in options.param:
        key, value = text.split("=", 1)
        params[key] = yaml.safe_load(value)
    file = options.out / "navigator.yaml"
    file.write_text(yaml.safe_dump(params))
    return file


def start(options, world, session):
    session.launch("extperfc", "sim_navigation.launch", rviz="false", seed=options.seed, world=world,
                   real_time_factor=options.speed, sim_config=sim_config(options), config=write_params(options),
                   map_file=options.map.resolve() if options.map else "")
    session.join("trial_navigate")
    robot = NavRobot(session.alive)
    robot.ready()
    return robot


class DoorCloser:
    """Puts the carton of the office into a door that lies ahead on the path."""

    BODY, AHEAD_M = "n2_carton", 2.5

    def __init__(self, robot, doors):
        self.robot, self.doors, self.closed = robot, doors, None

    def __call__(self, here):
        with self.robot.lock:
            path = self.robot.paths[0] if self.robot.paths else None
        if path is None:
            return False
        for door in self.doors:
            near = numpy.linalg.norm(path - numpy.array(door), axis=1).min() < 0.4
            if near and 1.5 < math.hypot(door[0] - here.x, door[1] - here.y) < self.AHEAD_M:
                self._put(door)
                self.closed = door
                return True
        return False

    def _put(self, door):
        import extperfc.srv
        request = extperfc.srv.MoveBodyRequest(name=self.BODY)
        request.pose.position.x, request.pose.position.y, request.pose.position.z = door[0], door[1], 0.225
        request.pose.orientation.w = 1
        self.robot.rospy.ServiceProxy("sim/move_body", extperfc.srv.MoveBody)(request)


def doors_of(world):
    """Middles of the openings in a world's walls."""
    if not pathlib.Path(str(world)).exists():
        return []
    found = []
    for entry in yaml.safe_load(pathlib.Path(world).read_text())["objects"]:
        wall = entry.get("wall") or {}
        found += [tuple(opening["at"]) for opening in wall.get("openings", [])]
    return found


def row_of(number, drive, true_map):
    metres, radians = drive.error()
    driving, standing = drive.person_contacts()
    driven = drive.driven_m
    return {"goal": number, "x": drive.goal.x, "y": drive.goal.y, "yaw": drive.goal.yaw, "reached": drive.reached,
            "result": drive.text, "error_m": metres, "error_deg": math.degrees(radians), "seconds": drive.seconds,
            "planned_m": drive.planned_m, "driven_m": driven, "ratio": driven / drive.planned_m if drive.planned_m else None,
            "speed_m_s": driven / drive.seconds if drive.seconds else 0.0, "contacts": drive.contacts(true_map),
            "contact_places": drive.contact_places(true_map), "said": [] if drive.reached else drive.said,
            "person_contacts_driving": driving, "person_contacts_standing": standing}


def show(row):
    ratio = f"{row['ratio']:6.2f}" if row["ratio"] else "    --"
    print(f"{row['goal']:4d} {row['x']:7.2f} {row['y']:7.2f} {'reached' if row['reached'] else 'FAILED':>8} "
          f"{row['seconds']:7.1f} s {row['planned_m']:6.1f} m {row['driven_m']:6.1f} m {ratio} {row['speed_m_s']:6.2f} m/s "
          f"{row['contacts']:3d} {row['person_contacts_driving']:3d} {row['person_contacts_standing']:3d}"
          + ("" if row["reached"] else "  " + row["result"]), flush=True)


def draw(true_map, drives, rows, file):
    """The driven paths on the map: green reached, red failed, crosses where the footprint touched."""
    scale = max(1, int(round(0.025 / true_map.resolution_m)))
    occupied = true_map.occupied[::scale, ::scale]
    image = numpy.where(occupied[..., None], 60, 245).astype(numpy.uint8).repeat(3, -1)
    size = true_map.resolution_m * scale

    def pixel(x, y):
        return int((x - true_map.x0) / size), int((y - true_map.y0) / size)
    for drive, row in zip(drives, rows):
        points = numpy.array([pixel(p.x, p.y) for _, p in drive.samples[::5]], numpy.int32)
        colour = (60, 150, 40) if row["reached"] else (40, 40, 220)
        if len(points) > 1:
            cv2.polylines(image, [points], False, colour, 2, cv2.LINE_AA)
        cv2.circle(image, pixel(drive.goal.x, drive.goal.y), 5, colour, -1, cv2.LINE_AA)
        if row["contacts"]:
            for _, pose in drive.samples[::5]:
                if true_map.touches(pose):
                    cv2.drawMarker(image, pixel(pose.x, pose.y), (200, 0, 200), cv2.MARKER_TILTED_CROSS, 14, 2)
    if drives and not rows[-1]["reached"]:
        here = drives[-1].samples[-1][1]
        cos, sin = math.cos(here.yaw), math.sin(here.yaw)
        outline = [pixel(here.x + cos * x - sin * y, here.y + sin * x + cos * y) for x, y in CHASSIS]
        cv2.polylines(image, [numpy.array(outline, numpy.int32)], True, (40, 40, 220), 2)
    cv2.imwrite(str(file), image[::-1])


def run(options, robot, true_map, world):
    rng = random.Random(options.seed)
    places = places_of(true_map, robot.pose())
    doors = doors_of(world)
    print("goal       x       y   result      time  planned   driven  ratio     speed touched people (driving, standing)",
          flush=True)
    drives, rows = [], []
    for number in range(1, options.goals + 1):
        goal = Pose(*options.goal[(number - 1) % len(options.goal)]) if options.goal else random_goal(rng, places, robot.pose())
        closer = DoorCloser(robot, doors) if options.close_door else None
        drives.append(robot.drive(goal, options.limit, meanwhile=closer))
        rows.append(row_of(number, drives[-1], true_map))
        if closer:
            rows[-1]["closed_door"] = closer.closed
        show(rows[-1])
        save(options, rows)  # a series may be ended before its last goal
        draw(true_map, drives, rows, options.out / f"paths_{options.seed}.png")
    return rows


def summary_of(options, rows):
    reached = [row for row in rows if row["reached"]]
    seconds = sum(row["seconds"] for row in reached)
    planned = sum(row["planned_m"] for row in reached)
    return {"world": options.world, "seed": options.seed, "base": options.base, "people": options.people,
            "goals": len(rows), "reached": len(reached),
            "contacts": sum(row["contacts"] for row in rows),
            "person_contacts_driving": sum(row["person_contacts_driving"] for row in rows),
            "person_contacts_standing": sum(row["person_contacts_standing"] for row in rows),
            "speed_m_s": sum(row["driven_m"] for row in reached) / seconds if seconds else 0.0,
            "ratio": sum(row["driven_m"] for row in reached) / planned if planned else 0.0}


def save(options, rows):
    if options.json:
        options.json.write_text(json.dumps({"summary": summary_of(options, rows), "goals": rows}, indent=1) + "\n")


def report(options, rows):
    summary = summary_of(options, rows)
    print(f"{summary['world']}, seed {summary['seed']}, {summary['base']}{', people' if options.people else ''}: reached "
          f"{summary['reached']} of {summary['goals']}, contacts {summary['contacts']}, with people "
          f"{summary['person_contacts_driving']} while driving and {summary['person_contacts_standing']} while standing, "
          f"{summary['speed_m_s']:.2f} m/s, driven over planned {summary['ratio']:.2f}")
    return 0 if summary["reached"] == summary["goals"] and not summary["contacts"] else 1


def main(argv):
    options = parse_arguments(argv)
    world, true_map = prepare(options)
    return run_trial(options.out,
                     lambda session: report(options, run(options, start(options, world, session), true_map, world)))


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
