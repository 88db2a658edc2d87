"""Takes the simulated robot elsewhere without its localizer's knowledge, again and again, and counts how often the
localizer is right again in time. The robot drives on meanwhile, unaware of the kidnapping.

Each trial begins with a localizer that is right, and is a success when its pose is within 0.3 m and 10 degrees of the
truth 10 s of simulated time after the kidnapping at the latest, and stays so for 3 s more.
"""

import argparse
import math
import os
import pathlib
import random
import re
import sys

import yaml

from pose_errors import Pose, settled_after
from ros_session import Stalled, run_trial
from sim_robot import SimRobot, wander

REPO = pathlib.Path(__file__).resolve().parents[2]
WS = pathlib.Path(os.environ.get("EXTPERFC_WS", REPO / ".ws"))
MAX_M, MAX_RAD = 0.3, math.radians(10)
HOLD_S = 3.0          # that a recovered pose must stay right
MIN_DISTANCE_M = 2.0  # from where the robot was to where it is put
MOTIONS = ("wander", "rotate", "stand")


def parse_arguments(argv):
    parser = argparse.ArgumentParser(prog="tools/trial_kidnap", description=__doc__,
                                     formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--trials", type=int, default=20, metavar="N", help="default: 20")
    parser.add_argument("--goal", type=float, default=0.95, metavar="FRACTION",
                        help="minimum fraction of successes, else the exit code is 1; default: 0.95")
    parser.add_argument("--within", type=float, default=10.0, metavar="S", help="simulated seconds; default: 10")
    parser.add_argument("--motion", choices=MOTIONS, default="wander",
                        help="of the robot after the kidnapping; default: wander")
    parser.add_argument("--world", default="office", metavar="NAME",
                        help="of config/worlds, random_floor, or a file; default: office")
    parser.add_argument("--seed", type=int, default=1, metavar="N",
                        help="of the positions, the simulator's noise and random worlds; default: 1")
    parser.add_argument("--speed", type=float, default=1.0, metavar="FACTOR",
                        help="simulated seconds per second; default: 1")
    parser.add_argument("--param", action="append", default=[], metavar="KEY=VALUE",
                        help="parameter of the localizer in place of that of config/localizer.yaml; repeatable")
    parser.add_argument("--out", type=pathlib.Path, default=WS / "kidnap", metavar="FOLDER",
                        help="where the log and the parameters go; default: .ws/kidnap")
    options = parser.parse_args(argv)
    for text in options.param:
        if not re.fullmatch(r"\w+=.+", text):
            parser.error(f"--param must be KEY=VALUE, not {text}")
    if options.trials < 1 or options.speed <= 0 or options.within <= 0:
        parser.error("--trials, --speed and --within must be positive")
    return options


def write_params(options):
    """The localizer's configuration with the user's parameters."""
    params = yaml.safe_load((REPO / "config" / "localizer.yaml").read_text())
    for text in options.param:
        key, value = text.split("=", 1)
        params[key] = yaml.safe_load(value)
    file = options.out / "localizer.yaml"
    file.write_text(yaml.safe_dump(params))
    return file


def start(options, session):
    """Simulator and localizer; returns the robot, localized."""
    is_file = "/" in options.world or options.world.endswith(".yaml")
    session.launch("extperfc", "sim_localization.launch", rviz="false", seed=options.seed,
                   world=pathlib.Path(options.world).resolve() if is_file else options.world,
                   real_time_factor=options.speed, config=write_params(options))
    session.join("trial_kidnap")
    robot = SimRobot()
    robot.ready()
    relocalize(robot)
    return robot


def relocalize(robot):
    """Relocalizes by the true pose."""
    for _ in range(5):
        robot.set_true_pose()
        begin = robot.now()
        robot.wait_until(begin + 1.0)
        if robot.error_now()[0] < MAX_M:
            return
    raise Stalled("the localizer does not take the true pose")


def command_of(motion, robot, rng):
    """Velocity command after the kidnapping. It avoids walls by the true map, else the wheels would spin."""
    sign = rng.choice((-1, 1))
    if motion == "wander":
        return lambda here: wander(here, robot.clearance_at, sign)
    if motion == "rotate":
        return lambda _: (0.0, 0.0, 0.6 * sign)
    return None


def trial(robot, options, rng, positions):
    """Kidnaps once. Returns where to, when it was right again [s after it; None: not], and the error at the end, and
    the updates meanwhile."""
    here = robot.pose()
    while True:
        x, y = positions[rng.randrange(len(positions))]
        if math.hypot(x - here.x, y - here.y) > MIN_DISTANCE_M:
            break
    there = Pose(x, y, rng.uniform(-math.pi, math.pi))
    command = command_of(options.motion, robot, rng)
    robot.move(command)
    begin, updates = robot.put(there), robot.updates
    end = begin + options.within + HOLD_S
    try:
        robot.wait_until(end)
    finally:
        robot.move(None)
    stamps, errors = robot.errors(begin, end)
    settled = settled_after(stamps, errors, MAX_M, MAX_RAD)
    after = None if settled is None or settled > begin + options.within else settled - begin
    return there, after, errors[-1], robot.updates - updates


def run(options, robot):
    rng = random.Random(options.seed)
    positions = robot.free_places()
    if len(positions) == 0:
        raise Stalled("the map has no free position that is large enough for the robot")
    print(f"{'trial':>5} {'put at':>22} {'right after':>12} {'error at the end':>22} {'updates':>8}", flush=True)
    found = []
    for number in range(1, options.trials + 1):
        there, after, (metres, radians), updates = trial(robot, options, rng, positions)
        found.append(after)
        print(f"{number:5d} {there.x:7.2f} {there.y:7.2f} {math.degrees(there.yaw):4.0f} deg "
              f"{'--' if after is None else f'{after:.1f} s':>11} "
              f"{metres:9.2f} m {math.degrees(radians):6.1f} deg {updates:8d}", flush=True)
        if after is None:
            relocalize(robot)
    return found


def report(options, found):
    times = sorted(t for t in found if t is not None)
    fraction = len(times) / len(found)
    middle = f", median {times[len(times) // 2]:.1f} s, slowest {times[-1]:.1f} s" if times else ""
    print(f"{options.world}, seed {options.seed}, {options.motion}: right within {options.within:.0f} s in {len(times)} of "
          f"{len(found)} trials ({100 * fraction:.0f} %){middle}; goal: {100 * options.goal:.0f} %")
    return 0 if fraction >= options.goal else 1


def main(argv):
    options = parse_arguments(argv)
    options.out.mkdir(parents=True, exist_ok=True)  # start() writes the parameters into it
    return run_trial(options.out, lambda session: report(options, run(options, start(options, session))))


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
