"""Lets the simulated robot (dynamic mode) find, pick and place a cube, a sphere and a cone at given distances from its
camera, at random positions of a tray that is as high as each distance needs, and compares what it reports with the truth.

A trial succeeds when `pick` and `place` both report success and the truth agrees: the object rose with the gripper, and in
the end stands within 3 cm of where it should. A failure that is reported as one is counted as "reported", a success that
the truth denies as "false +", a failure after which the object is where it should be as "false -".

The arm node finds the object itself (objects:=true) and is asked for it by its class, as a user would; it knows
tray and column only. The truth puts objects and judges.
"""

import argparse
import json
import os
import pathlib
import random
import sys

import numpy

import grasp_scene as scene
from grasp_robot import GraspRobot, matrix
from ros_session import run_trial

REPO = pathlib.Path(__file__).resolve().parents[2]
WS = pathlib.Path(os.environ.get("EXTPERFC_WS", REPO / ".ws"))
LIFT_M = 0.10


def parse_arguments(argv):
    parser = argparse.ArgumentParser(prog="tools/trial_grasp", description=__doc__,
                                     formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--trials", type=int, default=60, metavar="N",
                        help="in all, divided among shapes and distances; default: 60")
    parser.add_argument("--goal", type=float, default=0.95, metavar="FRACTION",
                        help="minimum fraction of successes, else the exit code is 1; default: 0.95")
    parser.add_argument("--shapes", nargs="+", choices=sorted(scene.SHAPES), default=["cube", "sphere", "cone"], metavar="SHAPE",
                        help="default: cube sphere cone")
    parser.add_argument("--distances", nargs="+", type=float, default=[0.3, 0.4, 0.5], metavar="M",
                        help="of an object's middle from the camera; default: 0.3 0.4 0.5")
    parser.add_argument("--seed", type=int, default=1, metavar="N", help="of the places and the simulator's noise; default: 1")
    parser.add_argument("--speed", type=float, default=1.0, metavar="FACTOR", help="simulated seconds per second; default: 1")
    parser.add_argument("--without-arm", action="store_true", help="only puts and detects objects")
    parser.add_argument("--depth", action="store_true", help="what the depth camera sees is an obstacle, too (depth:=true)")
    parser.add_argument("--json", type=pathlib.Path, metavar="FILE", help="every trial, for programs")
    parser.add_argument("--out", type=pathlib.Path, default=WS / "grasp", metavar="FOLDER",
                        help="where the log goes; default: .ws/grasp")
    options = parser.parse_args(argv)
    if options.trials < 1 or options.speed <= 0 or any(d <= 0 for d in options.distances):
        parser.error("--trials, --speed and --distances must be positive")
    return options


def start(options, session):
    """Simulator, detection and arm node: a GraspRobot and its GraspArms, None without arm."""
    with_arm = str(not options.without_arm).lower()
    session.launch("extperfc", "sim_grasp.launch", rviz="false", seed=options.seed, real_time_factor=options.speed,
                   arm=with_arm, objects=with_arm, depth=str(options.depth).lower())
    session.join("trial_grasp")
    robot = GraspRobot(session.alive)
    robot.ready()
    if options.without_arm:
        return robot, None
    from grasp_arms import GraspArms
    arms = GraspArms(robot)
    arms.open_grippers()
    return robot, arms


def note_estimate(middle, size, shape, place_pose, found):
    error = middle - scene.middle(shape, place_pose)
    found["estimate_error_m"] = [round(float(e), 4) for e in error]
    found["estimated_size_m"] = [round(s, 4) for s in size]


def detect_only(robot, shape, place_pose, found):
    """Whether a detection is the object; adds error and time to `found`."""
    box, found["detect_s"] = robot.wait_detected(shape, scene.middle(shape, place_pose))
    if box is not None:
        found.update(outcome="success", message="")
        note_estimate(matrix(box.center)[:3, 3], (box.size.x, box.size.y, box.size.z), shape, place_pose, found)


def find(arms, shape, place_pose, found):
    """Waits until the arm node has the object in its scene; adds its error and the time to `found`."""
    scene_object, found["detect_s"], found["other_objects"] = arms.wait_found(shape, scene.middle(shape, place_pose))
    if scene_object is not None:
        from grasp_arms import size_of
        note_estimate(arms.place_of(scene_object)[:3, 3], size_of(scene_object), shape, place_pose, found)


def pick(robot, arms, shape, place_at, found):
    """True when the object is held, as reported and in truth; else `found` has the outcome."""
    before = robot.true_pose(shape)[2, 3]
    status = arms.pick(shape, LIFT_M, place_at)
    robot.sleep(1.0)
    held = scene.is_held(robot.true_pose(shape)[2, 3] - before, LIFT_M, robot.from_tip(shape))
    return judge(status, held, "pick", found)


def place(robot, arms, shape, place_pose, found):
    """The same for placing at the place pose."""
    status = arms.place(shape, place_pose)
    robot.sleep(1.0)
    pose = robot.true_pose(shape)
    found["placed_off_m"] = float(numpy.linalg.norm(pose[:2, 3] - (place_pose.x, place_pose.y)))
    true = scene.is_placed(shape, pose[:3, 3], pose[:3, :3], place_pose) and robot.from_tip(shape) > 0.05
    return judge(status, true, "place", found)


def judge(status, true, stage, found):
    """Writes down how a stage ended; an action without an answer is no report of a failure."""
    found["stage"], found[stage + "_s"] = stage, status.seconds
    found["code"], found["message"] = status.code, status.message
    found["outcome"] = scene.outcome(status.code == 0, true)
    if status.code is None:
        found["outcome"] = "false failure" if true else "false success"
    return found["outcome"] == "success"


def trial(robot, arms, rng, camera, shape, distance):
    place_pose = scene.draw_place_pose(rng, shape, distance, *camera)
    other = scene.draw_other(rng, place_pose)
    found = {"shape": shape, "distance_m": distance, "place_pose": place_pose._asdict(), "place_at": other._asdict(),
             "stage": "detect",
             "outcome": "reported failure", "code": None, "message": "not detected", "estimate_error_m": None}
    if arms is None:
        robot.put(shape, place_pose)
        detect_only(robot, shape, place_pose, found)
        return found
    robot.park_all()
    arms.forget_objects()
    home = arms.move_home()
    if home.code != 0:
        found.update(stage="home", code=home.code, message=home.message)
        return found
    robot.put(shape, place_pose)
    arms.show_support(place_pose)
    find(arms, shape, place_pose, found)
    # An object that was not found is still requested: the arm node has to report that it is not there.
    if pick(robot, arms, shape, other, found):
        place(robot, arms, shape, other, found)
    return found


def tidy_up(robot, arms):
    """After a failure: grippers are empty, and the arm node knows of the tray only, at its height."""
    robot.park_all()
    arms.open_grippers()
    arms.forget_objects()


def show(number, found):
    error = found.get("estimate_error_m")
    estimate = "not seen" if error is None else f"{1e3 * numpy.linalg.norm(error):5.1f} mm"
    off = found.get("placed_off_m")
    print(f"{number:5d} {found['shape']:<7}{found['distance_m']:4.1f} m  estimate {estimate}  "
          f"{'' if off is None else f'placed {1e3 * off:4.0f} mm off  '}{found['outcome']}"
          f"{'' if found['outcome'] == 'success' else ' in ' + found['stage'] + ': ' + found['message']}", flush=True)


def run(options, robot, arms):
    rng = random.Random(options.seed)
    camera = robot.camera()
    kinds = [(shape, distance) for distance in options.distances for shape in options.shapes]
    trials = []
    for number in range(options.trials):
        found = trial(robot, arms, rng, camera, *kinds[number % len(kinds)])
        trials.append(found)
        show(number + 1, found)
        if found["outcome"] != "success" and arms is not None:
            tidy_up(robot, arms)
    return trials


def report(options, trials):
    order = {(s, d): i for i, (s, d) in enumerate((s, d) for s in options.shapes for d in options.distances)}
    print("\n".join(scene.table(sorted(trials, key=lambda t: order[t["shape"], t["distance_m"]]))))
    good = sum(t["outcome"] == "success" for t in trials)
    misreported = sum(t["outcome"] in ("false success", "false failure") for t in trials)
    print(f"seed {options.seed}: {good} of {len(trials)} trials succeeded ({100 * good / len(trials):.0f} %), "
          f"{misreported} were reported wrongly; goal: {100 * options.goal:.0f} %, 0")
    if options.json:
        options.json.write_text(json.dumps({"seed": options.seed, "trials": trials}, indent=1))
    return 0 if good >= options.goal * len(trials) and not misreported else 1


def main(argv):
    options = parse_arguments(argv)
    return run_trial(options.out, lambda session: report(options, run(options, *start(options, session))),
                     scene.NoPlace)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
