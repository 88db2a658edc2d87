"""What tools/demo follow can be asked for. Needs nothing but Python: its --help works before anything is installed."""

import argparse
import pathlib
import sys

from demo_options import ENOUGH_PROCESSORS, REPO, WS, speed_here

FEW_PROCESSORS_SPEED = 0.6  # with faces

DESCRIPTION = """The simulated robot learns the face of a person who stands before it, follows that person through an office that it does not
know, and maps the office meanwhile. Another person walks there, too.

A run succeeds when the person was followed to the end, at 3 m or less for 90 % of the time, nothing was touched, and the map
shows nothing where the office is free. The seed decides on the person's path. With a display it opens rviz.

Faces need a face detector (docs/faces.md): the folder of a YuNet as --face-model. Without it the robot follows who walks
before it first.
"""


def parse_arguments(argv):
    parser = argparse.ArgumentParser(prog="tools/demo follow", description=DESCRIPTION,
                                     formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--runs", type=int, default=1, metavar="N",
                        help="with the seeds SEED, SEED + 1, ..., each with a simulation of its own; default: 1")
    parser.add_argument("--seed", type=int, default=1, metavar="N", help="default: 1")
    parser.add_argument("--seconds", type=float, default=150.0, metavar="S", help="simulated, from the first step on; default: 150")
    parser.add_argument("--speed", type=float, metavar="FACTOR",
                        help=f"simulated seconds per second; default: 1, {FEW_PROCESSORS_SPEED} with faces and fewer than "
                             f"{ENOUGH_PROCESSORS} processors")
    parser.add_argument("--face-model", type=pathlib.Path, default=REPO / "models" / "yunet", metavar="FOLDER",
                        help="of a YuNet; default: models/yunet, where it exists")
    parser.add_argument("--embedder", default="lbp", metavar="FILE",
                        help="network that distinguishes faces, see docs/faces.md; default: lbp, without one")
    parser.add_argument("--out", type=pathlib.Path, default=WS / "demo_follow", metavar="FOLDER",
                        help="results, logs, maps and paths; default: .ws/demo_follow")
    parser.add_argument("--no-rviz", action="store_true", help="no window, even with a display")
    options = parser.parse_args(argv)
    if not options.face_model.is_dir():
        if options.face_model != parser.get_default("face_model"):
            parser.error(f"--face-model {options.face_model} is no folder; docs/faces.md says what belongs there")
        options.face_model = None
    if options.speed is None:
        options.speed = speed_here(FEW_PROCESSORS_SPEED) if options.face_model else 1.0
    if options.runs < 1 or not options.speed > 0 or not options.seconds >= 10:
        parser.error("--runs and --speed must be positive, --seconds at least 10")
    if not 0 <= options.seed < 2**31 - options.runs:
        parser.error(f"--seed must be from 0 to 2147483647 less the runs, but is {options.seed}")
    return options


if __name__ == "__main__":
    parse_arguments(sys.argv[1:])
