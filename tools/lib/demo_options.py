"""What tools/demo can be asked for. Needs nothing but Python: its --help works before anything is installed."""

import argparse
import os
import pathlib
import sys

REPO = pathlib.Path(__file__).resolve().parents[2]
WS = pathlib.Path(os.environ.get("EXTPERFC_WS", REPO / ".ws"))
ENOUGH_PROCESSORS = 4  # for the whole robot and its simulation in real time
SECONDS_WITHOUT_DISPLAY = 20.0  # of the simulation, unless the user says otherwise
DESCRIPTION = """Detects objects, computes their 3D positions, and shows the result as a table and as images.

Without --source the simulated robot stands in its laboratory: detector and depth work on its camera, and the table
reports how far each estimated position is from the truth. With a display it opens rviz.

Tasks of the whole robot: tools/demo grasp, tools/demo tour, tools/demo follow (each has its --help).
"""


def parse_arguments(argv):
    parser = argparse.ArgumentParser(prog="tools/demo", description=DESCRIPTION, formatter_class=argparse.RawTextHelpFormatter)
    add_common(parser)
    add_simulation(parser.add_argument_group("simulation"))
    add_recording(parser.add_argument_group("recording, instead of the simulation"))
    options = parser.parse_args(argv)
    check(parser, options)
    return options


def speed_here(with_few):
    """Simulated seconds per second: 1, or so many where the processors are too few for the whole robot."""
    return 1.0 if len(os.sched_getaffinity(0)) >= ENOUGH_PROCESSORS else with_few


def add_common(parser):
    parser.add_argument("--model", type=pathlib.Path, default=REPO / "models" / "shapes", metavar="FOLDER",
                        help="model folder, see models/README.md; default: models/shapes")
    parser.add_argument("--seconds", type=float, metavar="N",
                        help="stop after N seconds; default: until Ctrl-C with a display; without one the\n"
                             f"simulation runs {SECONDS_WITHOUT_DISPLAY:.0f} s, a folder of images once through")
    parser.add_argument("--out", type=pathlib.Path, default=WS / "demo", metavar="FOLDER",
                        help="where annotated images and table.csv go; default: .ws/demo")
    parser.add_argument("--backend", choices=("auto", "openvino", "opencv"), default="auto",
                        help="default: the fastest that loads the model")
    parser.add_argument("--device", default="CPU", help="CPU, GPU, NPU or AUTO; default: CPU")
    parser.add_argument("--no-rviz", action="store_true", help="no window, even with a display")


def add_simulation(group):
    group.add_argument("--world", default="lab", metavar="NAME",
                       help="a world of config/worlds, random_table, random_floor, or a file; default: lab")
    group.add_argument("--seed", type=int, default=1, metavar="N",
                       help="of noise and of random worlds, 0 to 2147483647; default: 1")
    group.add_argument("--still", action="store_true", help="the robot stays where it is, instead of swinging sideways")


def add_recording(group):
    group.add_argument("--source", type=pathlib.Path, metavar="PATH",
                       help="folder of aligned colour and depth images (TUM associations.txt, or equal names in\n"
                            "rgb/ and depth/), or an MRPT .rawlog file; tools/extperfc-render --sequence makes a folder")
    group.add_argument("--rate", type=float, default=10.0, metavar="HZ", help="frames per second; default: 10")
    group.add_argument("--frame", metavar="FRAME",
                       help="tf frame of x y z; default: map where the recording knows its camera's poses\n"
                            "(groundtruth.txt), else base_link, the floor 1 m below the camera.\n"
                            "camera_color_optical_frame: as the camera sees it")
    group.add_argument("--camera-info", type=pathlib.Path, metavar="FILE",
                       help="calibration file (camera_calibration YAML); default: what the recording brings")
    group.add_argument("--depth-scale", type=float, default=1000.0, metavar="UNITS",
                       help="units per metre of depth files; default: 1000, TUM's own recordings: 5000")


def check(parser, options):
    """Ends the program with one line when an argument cannot work."""
    if options.seconds is not None and not options.seconds > 0:
        parser.error(f"--seconds must be positive, not {options.seconds}")
    if not options.rate > 0:
        parser.error(f"--rate must be positive, not {options.rate}")
    if not 0 <= options.seed < 2**31:
        parser.error(f"--seed must be from 0 to 2147483647, but is {options.seed}")
    if options.frame and not options.source:
        parser.error("--frame goes with --source: the simulation's truth is in the frame map")
    for path in (options.source, options.model, options.camera_info):
        if path is not None and not path.exists():
            parser.error(f"{path} does not exist")


if __name__ == "__main__":
    parse_arguments(sys.argv[1:])
