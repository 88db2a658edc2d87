"""What tools/demo tour can be asked for. Needs nothing but Python: its --help works before anything is installed."""

import argparse
import sys

from demo_options import ENOUGH_PROCESSORS, REPO, WS, speed_here

FEW_PROCESSORS_SPEED = 0.7

DESCRIPTION = """The simulated robot comes into a flat that it does not know: it explores and maps it, searches the tables for a cube,
picks the cube, and brings it to a table in another room. Mapping, navigation, perception and arms run at once.

A run succeeds when the robot says so and the simulator's truth agrees: the cube stands within 10 cm of where it should
on the other table, and the base touched nothing on its path. The seed decides on which table the cube is, and where.
With a display it opens rviz.
"""


def parse_arguments(argv):
    parser = argparse.ArgumentParser(prog="tools/demo tour", description=DESCRIPTION,
                                     formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--runs", type=int, default=1, metavar="N",
                        help="with the seeds SEED, SEED + 1, ..., each with a simulation of its own; default: 1")
    parser.add_argument("--seed", type=int, default=1, metavar="N", help="default: 1")
    parser.add_argument("--speed", type=float, default=speed_here(FEW_PROCESSORS_SPEED), metavar="FACTOR",
                        help=f"simulated seconds per second; default: 1, {FEW_PROCESSORS_SPEED} with fewer than {ENOUGH_PROCESSORS} processors")
    parser.add_argument("--limit", type=float, default=1200.0, metavar="S", help="simulated seconds for a run; default: 1200")
    parser.add_argument("--model", default=REPO / "models" / "shapes", metavar="FOLDER",
                        help="model folder, see models/README.md; default: models/shapes")
    parser.add_argument("--out", default=WS / "demo_tour", metavar="FOLDER",
                        help="results, logs, maps and paths; default: .ws/demo_tour")
    parser.add_argument("--slip", action="store_true", help="the cube slips out of the gripper once, back to where it was")
    parser.add_argument("--film", action="store_true", help="write an animation, tour.webp, too")
    parser.add_argument("--no-rviz", action="store_true", help="no window, even with a display")
    options = parser.parse_args(argv)
    if options.runs < 1 or not options.speed > 0 or not options.limit > 0:
        parser.error("--runs, --speed and --limit must be positive")
    if not 0 <= options.seed < 2**31 - options.runs:
        parser.error(f"--seed must be from 0 to 2147483647 less the runs, but is {options.seed}")
    return options


if __name__ == "__main__":
    parse_arguments(sys.argv[1:])
