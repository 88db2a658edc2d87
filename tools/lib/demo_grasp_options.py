"""What tools/demo grasp can be asked for. Needs nothing but Python: its --help works before anything is installed."""

import argparse
import sys

from demo_options import REPO, WS

DESCRIPTION = """The simulated robot finds a cube, a sphere and a cone on a tray 0.3, 0.4 and 0.5 m before its camera, estimates
how far each is, picks it, shows it to the camera, and puts it down elsewhere. Detection goes on all the while.

A run succeeds when the robot says so of all three objects and the simulator's truth agrees: each was in the gripper and
was detected while it was shown, stands within 3 cm of where it should, and no second passed without a detection. The
seed decides which object comes at which distance, and where. With a display it opens rviz.
"""


def parse_arguments(argv):
    parser = argparse.ArgumentParser(prog="tools/demo grasp", description=DESCRIPTION,
                                     formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--runs", type=int, default=1, metavar="N", help="with the seeds SEED, SEED + 1, ...; default: 1")
    parser.add_argument("--seed", type=int, default=1, metavar="N", help="default: 1")
    parser.add_argument("--speed", type=float, default=1.0, metavar="FACTOR", help="simulated seconds per second; default: 1")
    parser.add_argument("--model", default=REPO / "models" / "shapes", metavar="FOLDER",
                        help="model folder, see models/README.md; default: models/shapes")
    parser.add_argument("--out", default=WS / "demo_grasp", metavar="FOLDER",
                        help="grasp.json, log and images of what was shown; default: .ws/demo_grasp")
    parser.add_argument("--no-rviz", action="store_true", help="no window, even with a display")
    options = parser.parse_args(argv)
    if options.runs < 1 or not options.speed > 0:
        parser.error("--runs and --speed must be positive")
    if not 0 <= options.seed < 2**31 - options.runs:
        parser.error(f"--seed must be from 0 to 2147483647 less the runs, but is {options.seed}")
    return options


if __name__ == "__main__":
    parse_arguments(sys.argv[1:])
