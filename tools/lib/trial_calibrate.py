"""Calibrates the camera of a simulated robot whose camera and board are not where its description says, and compares
the result with the truth.

Each trial writes a description of the robot with its camera moved by up to --offset-mm and --offset-degrees, and a
board in its gripper that is held askew. The arm moves to poses in which the board should be seen, and
tools/extperfc-calibrate, which knows neither, takes views from the topics.
"""

import argparse
import math
import os
import pathlib
import subprocess
import sys
import time

import numpy
import yaml

REPO = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(REPO / "src"))

import board_in_gripper  # noqa: E402
from ros_session import RosSession  # noqa: E402
from sim_arm import ArmKinematics, SimArm  # noqa: E402

from extperfc import robot_description as rd  # noqa: E402
from extperfc.calibrate import board as boards  # noqa: E402
from extperfc.calibrate import description, result, views  # noqa: E402

WS = pathlib.Path(os.environ.get("EXTPERFC_WS", REPO / ".ws"))
URDF = REPO / "urdf" / "mobile_baxter.urdf"
CAMERA, OPTICAL = "camera_link", "camera_color_optical_frame"
# The simulator's camera as config/simulator.yaml has it, for planning only: the tool reads camera_info.
PLANNED_CAMERA = views.Camera(640, 480, numpy.array([[615.0, 0, 319.5], [0, 615.0, 239.5], [0, 0, 1]]), numpy.zeros(5))
GRIP_M, GRIP_RAD = 0.015, math.radians(8)  # by which the board is held askew
GOAL_M, GOAL_RAD = 0.002, math.radians(0.3)
MAX_POSES = 80


class Failed(Exception):
    """A trial without a result; the text says why."""


def parse_arguments(argv):
    parser = argparse.ArgumentParser(prog="tools/trial_calibrate", description=__doc__,
                                     formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--trials", type=int, default=3, metavar="N", help="default: 3")
    parser.add_argument("--board", type=boards.parse_board, default=boards.Chessboard(9, 6, 0.02), metavar="BOARD",
                        help="as of extperfc-calibrate; default: chessboard:9x6:0.02")
    parser.add_argument("--views", type=int, default=20, metavar="N", help="default: 20")
    parser.add_argument("--side", choices=("left", "right"), default="left", help="arm with the board; default: left")
    parser.add_argument("--offset-mm", type=float, default=30.0, metavar="MM", help="default: 30")
    parser.add_argument("--offset-degrees", type=float, default=4.0, metavar="DEGREES", help="default: 4")
    parser.add_argument("--seed",
                        type=int,
                        default=1,
                        metavar="N",
                        help="of offsets, poses and the simulator's noise; default: 1")
    parser.add_argument("--speed",
                        type=float,
                        default=1.0,
                        metavar="FACTOR",
                        help="simulated seconds per second; default: 1")
    parser.add_argument("--out", type=pathlib.Path, default=WS / "calibrate", metavar="FOLDER",
                        help="views, results and logs, a folder per trial; default: .ws/calibrate")
    options = parser.parse_args(argv)
    if options.trials < 1 or options.speed <= 0:
        parser.error("--trials and --speed must be positive")
    return options


def write_robot(folder, options, random):
    """(URDF file with hidden offsets, true head_T_camera_link)."""
    urdf = URDF.read_text()
    head_T_camera = rd.RobotDescription(urdf).link_poses({}, "head")[CAMERA]
    head_T_camera = head_T_camera @ board_in_gripper.random_offset(random, options.offset_mm / 1000,
                                                                   math.radians(options.offset_degrees))
    grip = board_in_gripper.random_offset(random, GRIP_M, GRIP_RAD) @ board_in_gripper.nominal_grip(options.board)
    urdf = description.with_camera(urdf, "head", CAMERA, head_T_camera)
    file = folder / "urdf" / "robot.urdf"  # the simulator looks for package://extperfc/urdf/meshes beside it
    file.parent.mkdir(exist_ok=True)
    if not (file.parent / "meshes").is_symlink():
        (file.parent / "meshes").symlink_to(URDF.parent / "meshes")
    file.write_text(board_in_gripper.with_board(urdf, options.board, f"{options.side}_gripper", grip))
    return file, head_T_camera


def write_config(folder):
    """config/simulator.yaml with a camera that averages four rays per pixel, as a lens does; the file's path."""
    config = yaml.safe_load((REPO / "config" / "simulator.yaml").read_text())
    config["camera"]["supersampling"] = 2
    file = folder / "simulator.yaml"
    file.write_text(yaml.safe_dump(config))
    return file


class Waiter:
    """Simulated time, and waiting in real time, while the simulation runs."""

    def __init__(self, session):
        import rospy
        self._session, self._rospy = session, rospy

    def now(self):
        return self._rospy.Time.now().to_sec()

    def wait(self, condition, what, real_s=120.0):
        deadline = time.monotonic() + real_s
        while not condition():
            if not self._session.alive():
                raise Failed("; ".join(self._session.errors()) or f"the simulation ended; see {self._session.log_file}")
            if time.monotonic() > deadline:
                raise Failed(f"waited {real_s:.0f} s for {what}")
            time.sleep(0.02)


def start_tool(folder, options):
    """The running extperfc-calibrate."""
    fields = options.board.as_dict()
    sizes = [fields["square_m"]
             ] if fields["kind"] == "chessboard" else [fields["marker_m"], fields["gap_m"], fields["dictionary"]]
    board = ":".join(map(str, [fields["kind"], f"{fields['columns']}x{fields['rows']}", *sizes]))
    command = [
        str(REPO / "tools" / "extperfc-calibrate"), "collect",
        str(folder / "views"), "--board", board, "--camera-on", "head", "--board-on", f"{options.side}_gripper",
        "--views",
        str(options.views), "--out",
        str(folder / "camera_pose.yaml")
    ]
    with open(folder / "calibrate.log", "w", encoding="utf-8") as log:
        return subprocess.Popen(command, stdout=log, stderr=subprocess.STDOUT, stdin=subprocess.DEVNULL)


def move_until_done(arm, tool, options, random):
    """Shows the board in poses that the description makes visible, until the tool has ended."""
    robot = rd.RobotDescription.from_file(URDF)  # the tool and this function know no offset
    base_T_camera = robot.link_poses({}, "base")[OPTICAL]
    poses = board_in_gripper.arm_poses(ArmKinematics(robot, options.side), base_T_camera, options.board, PLANNED_CAMERA,
                                       random)
    for _, joints in zip(range(MAX_POSES), poses):
        if tool.poll() is not None:
            return
        arm.move(joints)
    if tool.poll() is None:
        raise Failed(f"extperfc-calibrate is not content with {MAX_POSES} poses")


def trial(number, options, session_of):
    """Calibrates a robot with hidden offsets; a dictionary of errors."""
    folder = options.out / f"trial_{number}"
    folder.mkdir(parents=True, exist_ok=True)
    for old in (folder / "views").glob("*"):
        old.unlink()
    random = numpy.random.default_rng([options.seed, number])
    urdf, truth = write_robot(folder, options, random)
    with session_of(folder, urdf) as session:
        waiter = Waiter(session)
        arm = SimArm(rd.RobotDescription.from_file(URDF), options.side, waiter.wait, waiter.now)
        tool = start_tool(folder, options)
        try:
            move_until_done(arm, tool, options, random)
        finally:
            if tool.poll() is None:
                tool.terminate()
            code = tool.wait()
    log = (folder / "calibrate.log").read_text()
    if code != 0:
        raise Failed(log.splitlines()[-1] if log else f"extperfc-calibrate ended with {code}")
    return compare(folder, truth)


def compare(folder, truth):
    parent, child, pose = result.read_pose(folder / "camera_pose.yaml")
    if (parent, child) != ("head", CAMERA):
        raise Failed(f"the result places {child} in {parent}")
    said = yaml.safe_load((folder / "camera_pose.yaml").read_text())["calibration"]
    difference = result.pose_difference(truth, pose)
    nominal = rd.RobotDescription.from_file(URDF).link_poses({}, "head")[CAMERA]
    offset = result.pose_difference(truth, nominal)
    return {"error_mm": 1000 * float(numpy.linalg.norm(difference[:3])),
            "error_degrees": math.degrees(numpy.linalg.norm(difference[3:])),
            "hidden_mm": 1000 * float(numpy.linalg.norm(offset[:3])),
            "hidden_degrees": math.degrees(numpy.linalg.norm(offset[3:])),
            "sigma_mm": said["sigma"]["mm"], "sigma_degrees": said["sigma"]["degrees"], "views": said["views"],
            "residual_px": said["residual_px"], "cross_validation": said["cross_validation"]}


def session_of(options):
    """A function that starts a simulation of a URDF; the ROS node of this process is made by the first."""
    def start(folder, urdf):
        session = RosSession(folder / "launch.log")
        session.launch("extperfc",
                       "sim.launch",
                       rviz="false",
                       lidar="false",
                       scan="false",
                       world="empty",
                       start_pose="neutral",
                       urdf=urdf.resolve(),
                       config=write_config(folder).resolve(),
                       seed=options.seed,
                       real_time_factor=options.speed)
        session.join("trial_calibrate")
        return session
    return start


def show(number, found):
    print(f"trial {number}: hidden offset {found['hidden_mm']:5.1f} mm {found['hidden_degrees']:5.2f} degrees; "
          f"error {found['error_mm']:5.2f} mm {found['error_degrees']:6.3f} degrees "
          f"(said: +- {found['sigma_mm']:.2f} mm {found['sigma_degrees']:.3f} degrees); {found['views']} views, "
          f"{found['residual_px']:.2f} px", flush=True)


def run_one_each(argv, options):
    """A ROS node belongs to one master, so each of several trials is a process."""
    codes = []
    for number in range(options.trials):
        command = [sys.executable, __file__, *argv, "--trials", "1", "--seed", str(options.seed + number),
                   "--out", str(options.out / f"seed_{options.seed + number}")]
        codes.append(subprocess.run(command, check=False).returncode)
    return max(codes)


def main(argv):
    options = parse_arguments(argv)
    if options.trials > 1:
        return run_one_each(argv, options)
    options.out.mkdir(parents=True, exist_ok=True)
    import rospy
    try:
        found = trial(0, options, session_of(options))
    except Failed as error:
        print(f"error: {error}", file=sys.stderr)
        return 1
    except KeyboardInterrupt:
        return 130
    finally:
        rospy.signal_shutdown("done")
    show(options.seed, found)
    return 0 if found["error_mm"] <= 1000 * GOAL_M and found["error_degrees"] <= math.degrees(GOAL_RAD) else 1


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
