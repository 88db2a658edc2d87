"""Command line of tools/extperfc-calibrate."""

import argparse
import datetime
import pathlib
import sys

from extperfc.calibrate import board as boards
from extperfc.calibrate import collector as collecting
from extperfc.calibrate import description, drawing, motions, result, robot_poses, solver, views

DESCRIPTION = """Finds where a camera sits on the robot, from images of a board.

The camera is fixed to one link (--camera-on) and the board to another (--board-on):
  board in the gripper, camera on the head:  --camera-on head --board-on left_gripper
  camera on the hand, board on the table:    --camera-on left_hand --board-on base

  extperfc-calibrate board   --board chessboard:9x6:0.025 board.svg
  extperfc-calibrate collect --board chessboard:9x6:0.025 --camera-on head --board-on left_gripper views/
  extperfc-calibrate solve   views/ --out camera_pose.yaml
  extperfc-calibrate urdf    camera_pose.yaml --urdf robot.urdf --out calibrated.urdf
"""
FAILURES = (boards.BoardError, views.ViewsError, motions.DegenerateError, solver.SolverError)


def board_of_text(text):
    """For argparse, which shows the texts of its own errors only."""
    try:
        return boards.parse_board(text)
    except boards.BoardError as error:
        raise argparse.ArgumentTypeError(error) from None


def add_collect(commands):
    parser = commands.add_parser(
        "collect",
        help="take views, from topics or a bag, and solve",
        description="Takes views from the topics of a running robot or from a bag into a folder, says which "
        "motion is missing, and solves.")
    parser.add_argument("folder", type=pathlib.Path, help="new folder of views")
    parser.add_argument(
        "--board",
        type=board_of_text,
        required=True,
        metavar="BOARD",
        help="chessboard:COLUMNSxROWS:SQUARE (inner corners, metres) or aruco:COLUMNSxROWS:MARKER:GAP[:DICTIONARY]")
    parser.add_argument("--camera-on", required=True, metavar="LINK", help="link that the camera is fixed to")
    parser.add_argument("--board-on", required=True, metavar="LINK", help="link that the board is fixed to")
    parser.add_argument("--bag", type=pathlib.Path, metavar="FILE", help="take views from a bag instead of topics")
    parser.add_argument("--views", type=int, default=collecting.DEFAULT_VIEWS, metavar="N",
                        help=f"views to take from topics; default: {collecting.DEFAULT_VIEWS}")
    parser.add_argument("--color", default="/camera/color/image_raw", metavar="TOPIC", help="default: %(default)s")
    parser.add_argument("--camera-info",
                        default="/camera/color/camera_info",
                        metavar="TOPIC",
                        help="default: %(default)s")
    parser.add_argument("--joint-states",
                        default="/robot/joint_states",
                        metavar="TOPIC",
                        help="with --urdf; default: %(default)s")
    parser.add_argument("--urdf", type=pathlib.Path, metavar="FILE",
                        help="compute the links' poses from joint states by this description; default: tf")
    parser.add_argument("--camera-frame",
                        default="",
                        metavar="FRAME",
                        help="optical frame; default: that of the camera info")
    parser.add_argument(
        "--mount",
        default="camera_link",
        metavar="FRAME",
        help="frame on which the driver hangs the camera's frames, which the result places; default: %(default)s")
    add_output(parser)
    parser.set_defaults(function=collect)


def add_output(parser):
    parser.add_argument("--out", type=pathlib.Path, metavar="FILE",
                        help="the result, for the launch argument camera_pose; default: camera_pose.yaml in the folder")
    parser.add_argument("--image",
                        type=pathlib.Path,
                        metavar="FILE",
                        help="image of the result; default: camera_pose.png beside it")


def parse(argv):
    parser = argparse.ArgumentParser(prog="extperfc-calibrate", description=DESCRIPTION,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    commands = parser.add_subparsers(dest="command", required=True)
    one = commands.add_parser("board", help="draw a board in true size (SVG), to be printed without scaling")
    one.add_argument("file", type=pathlib.Path, help="SVG file to write")
    one.add_argument("--board", type=board_of_text, required=True, metavar="BOARD", help="as of collect")
    one.set_defaults(function=draw_board)
    add_collect(commands)
    one = commands.add_parser("solve", help="compute the camera's pose from a folder of views")
    one.add_argument("folder", type=pathlib.Path, help="folder of views; docs/calibration.md describes it")
    add_output(one)
    one.set_defaults(function=solve)
    one = commands.add_parser("urdf", help="write a robot's description with the camera at its calibrated pose")
    one.add_argument("pose", type=pathlib.Path, help="result of solve")
    one.add_argument("--urdf", type=pathlib.Path, required=True, metavar="FILE", help="the robot's description")
    one.add_argument("--out", type=pathlib.Path, required=True, metavar="FILE", help="the corrected description")
    one.set_defaults(function=write_urdf)
    options = parser.parse_args(argv)
    if getattr(options, "views", motions.MIN_VIEWS) < motions.MIN_VIEWS:
        parser.error(f"--views must be {motions.MIN_VIEWS} or more, not {options.views}")
    return options


def report(text):
    print(text, flush=True)


def draw_board(options):
    options.file.write_text(boards.svg(options.board))
    _, _, width, height = options.board.outline()
    report(
        f"{options.file}: {1000 * width:.0f} x {1000 * height:.0f} mm; print it without scaling, glue it to something "
        "flat and stiff, and measure a square")


def solve(options):
    return finish(options, views.load(options.folder))


def finish(options, view_set):
    """Solves, reports, writes the files."""
    found = result.calibrate(view_set)
    for line in result.report(found, view_set):
        report(line)
    out = options.out or options.folder / "camera_pose.yaml"
    out.write_text(result.as_yaml(found, view_set, datetime.date.today().isoformat()))
    image = options.image or out.with_suffix(".png")
    try:
        drawing.draw(found, view_set, image)
        report(f"image of the result: {image}")
    except ImportError:
        report("no image of the result: install python3-matplotlib")
    for need in motions.missing(found.diversity, view_set.frames.carrier):
        report("advice: " + need)
    child, _ = view_set.frames.child_T_camera()
    report(
        f"{out} places {child} in {view_set.frames.parent}; use it by the launch argument\n"
        f"  camera_pose:={out.resolve()}")


def collect(options):
    frames = views.Frames(options.camera_on, options.board_on, options.camera_frame, options.mount)
    topics = {"color": options.color, "camera_info": options.camera_info, "joint_states": options.joint_states}
    urdf = robot_poses.read_urdf(options.urdf) if options.urdf else None
    if options.bag:
        from extperfc.calibrate.recording import Recording
        recording = Recording(options.bag, topics, frames, urdf)
        try:
            recording.collect(options.folder, options.board, options.views, report)
        finally:
            recording.close()
    else:
        collect_live(options, topics, frames, urdf)
    return finish(options, views.load(options.folder))


def collect_live(options, topics, frames, urdf):
    import rosgraph
    import rospy
    if not rosgraph.is_master_online():
        raise views.ViewsError("no ROS master answers: start the robot's nodes first, or give --bag")
    rospy.init_node("extperfc_calibrate", anonymous=True, disable_signals=True)
    from extperfc.calibrate import live
    try:
        collector = live.collect(live.LiveSource(topics, frames, urdf), options.folder, options.board, options.views,
                                 report)
    except KeyboardInterrupt:
        report(f"stopped; {options.folder} keeps the views taken")
        return
    finally:
        rospy.signal_shutdown("done")
    report(f"{len(collector.poses)} views in {options.folder}")


def write_urdf(options):
    parent, child, parent_T_child = result.read_pose(options.pose)
    urdf = description.with_camera(robot_poses.read_urdf(options.urdf), parent, child, parent_T_child)
    options.out.write_text(urdf)
    report(f"{options.out}: {options.urdf.name} with {child} where {options.pose} says")


def main(argv=None):
    options = parse(sys.argv[1:] if argv is None else argv)
    try:
        options.function(options)
    except FAILURES as error:
        print(f"error: {error}", file=sys.stderr)
        return 1
    except OSError as error:
        print(f"error: {error.filename}: {error.strerror}", file=sys.stderr)
        return 1
    except KeyboardInterrupt:
        return 130
    return 0
