"""Lets the simulated robot (dynamic mode) find, pick and place a cube, a sphere and a cone at given distances from its
camera, at random positions of a tray that is as high as each distance needs, and compares what it reports with the truth.

A trial succeeds when `pick` and `place` both report success and the truth agrees: the object rose with the hand, and in
the end stands within 3 cm of where it should. A failure that is reported as one is counted as "reported", a success that
is none as "false +", a failure after which the object is where it should be as "false -".
"""

import argparse
import json
import os
import pathlib
import random
import sys

import numpy

import grasp_scene as scene
from grasp_robot import GraspRobot, Stalled, matrix
from ros_session import RosSession

REPO = pathlib.Path(__file__).resolve().parents[2]
WS = pathlib.Path(os.environ.get("EXTPERFC_WS", REPO / ".ws"))
LIFT_M = 0.10


def parse_arguments(argv):
    parser = argparse.ArgumentParser(prog="tools/trial_grasp", description=__doc__,
                                     formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--trials", type=int, default=60, metavar="N",
                        help="in all, shared among shapes and distances in turn; default: 60")
    parser.add_argument("--goal", type=float, default=0.95, metavar="SHARE",
                        help="least share of successes, else the exit code is 1; default: 0.95")
    parser.add_argument("--shapes", nargs="+", choices=sorted(scene.SHAPES), default=["cube", "sphere", "cone"], metavar="SHAPE",
                        help="default: cube sphere cone")
    parser.add_argument("--distances", nargs="+", type=float, default=[0.3, 0.4, 0.5], metavar="M",
                        help="of an object's middle from the camera; default: 0.3 0.4 0.5")
    parser.add_argument("--seed", type=int, default=1, metavar="N", help="of the places and the simulator's noise; default: 1")
    parser.add_argument("--speed", type=float, default=1.0, metavar="FACTOR", help="simulated seconds per second; default: 1")
    parser.add_argument("--without-arm", action="store_true", help="puts and detects objects, and nothing else")
    parser.add_argument("--json", type=pathlib.Path, metavar="FILE", help="every trial, for programs")
    parser.add_argument("--out", type=pathlib.Path, default=WS / "grasp", metavar="FOLDER",
                        help="where the log goes; default: .ws/grasp")
    options = parser.parse_args(argv)
    if options.trials < 1 or options.speed <= 0 or any(d <= 0 for d in options.distances):
        parser.error("--trials, --speed and --distances must be positive")
    return options


def start(options, session, rospy):
    """Simulator, detection and arm node."""
    session.launch("extperfc", "sim_grasp.launch", rviz="false", seed=options.seed, real_time_factor=options.speed,
                   arm=str(not options.without_arm).lower())
    from demo import wait_for_master
    wait_for_master(session)
    rospy.set_param("/use_sim_time", True)  # the launch may not have come to it yet, and a node asks once
    rospy.init_node("trial_grasp", disable_signals=True)
    robot = GraspRobot(session.alive, with_arm=not options.without_arm)
    robot.ready()
    if not options.without_arm:
        robot.open_grippers()
    return robot


def detect(robot, shape, spot, found):
    """The detector's part of a trial: adds error and time to `found`; the estimated box, None when the object was not seen."""
    box, found["detect_s"] = robot.wait_detected(shape, scene.middle(shape, spot))
    found["detected"] = box is not None
    if box is None:
        found["estimate_error_m"] = None
    else:
        error = matrix(box.center)[:3, 3] - scene.middle(shape, spot)
        found["estimate_error_m"] = [round(float(e), 4) for e in error]
        found["estimated_size_m"] = [round(s, 4) for s in (box.size.x, box.size.y, box.size.z)]
    return box


def pick(robot, shape, found):
    """True when the object is held, as reported and in truth; else `found` has the outcome."""
    before = robot.true_pose(shape)[2, 3]
    result, found["pick_s"] = robot.pick(shape, LIFT_M)
    robot.sleep(1.0)
    held = scene.is_held(robot.true_pose(shape)[2, 3] - before, LIFT_M, robot.from_tip(shape))
    return judge(result, held, "pick", found)


def place(robot, shape, spot, found):
    """The same for placing at the spot."""
    result, found["place_s"] = robot.place(shape, spot)
    robot.sleep(1.0)
    pose = robot.true_pose(shape)
    found["placed_off_m"] = float(numpy.linalg.norm(pose[:2, 3] - (spot.x, spot.y)))
    true = scene.is_placed(shape, pose[:3, 3], pose[:3, :3], spot) and robot.from_tip(shape) > 0.05
    return judge(result, true, "place", found)


def judge(result, true, stage, found):
    """Writes down how a stage ended; an action without an answer is no report of a failure."""
    reported = result is not None and result.code == 0
    found["stage"], found["outcome"] = stage, scene.outcome(reported, true)
    found["code"] = None if result is None else result.code
    found["message"] = "no answer" if result is None else result.message
    if result is None:
        found["outcome"] = "false failure" if true else "false success"
    return found["outcome"] == "success"


def trial(robot, options, rng, camera, shape, distance):
    spot = scene.draw_spot(rng, shape, distance, *camera)
    other = scene.draw_other(rng, spot)
    found = {"shape": shape, "distance_m": distance, "spot": spot._asdict(), "place_at": other._asdict(),
             "stage": "detect", "outcome": "reported failure", "code": None, "message": "not detected"}
    if not options.without_arm:
        robot.park(shape)
        home = robot.move_home()
        if home:
            found.update(stage="home", message=home)
            return found
        robot.show_support(spot)
    robot.put(shape, spot)
    seen = detect(robot, shape, spot, found)
    if options.without_arm:
        if seen is not None:
            found.update(outcome="success", message="")
        return found
    if seen is not None:
        robot.show_object(shape, seen)
    # An object that was not seen is asked for all the same: the arm node has to say that it is not there.
    if pick(robot, shape, found):
        place(robot, shape, other, found)
    return found


def show(number, found):
    error = found.get("estimate_error_m")
    estimate = "not seen" if error is None else f"{1e3 * numpy.linalg.norm(error):5.1f} mm"
    off = found.get("placed_off_m")
    print(f"{number:5d} {found['shape']:<7}{found['distance_m']:4.1f} m  estimate {estimate}  "
          f"{'' if off is None else f'placed {1e3 * off:4.0f} mm off  '}{found['outcome']}"
          f"{'' if found['outcome'] == 'success' else ' in ' + found['stage'] + ': ' + found['message']}", flush=True)


def run(options, robot):
    rng = random.Random(options.seed)
    camera = robot.camera()
    kinds = [(shape, distance) for distance in options.distances for shape in options.shapes]
    trials = []
    for number in range(options.trials):
        found = trial(robot, options, rng, camera, *kinds[number % len(kinds)])
        trials.append(found)
        show(number + 1, found)
        if found["outcome"] != "success" and not options.without_arm:
            robot.park(found["shape"])
            robot.open_grippers()
    return trials


def report(options, trials):
    order = {(s, d): i for i, (s, d) in enumerate((s, d) for s in options.shapes for d in options.distances)}
    print("\n".join(scene.table(sorted(trials, key=lambda t: order[t["shape"], t["distance_m"]]))))
    good = sum(t["outcome"] == "success" for t in trials)
    untold = sum(t["outcome"] in ("false success", "false failure") for t in trials)
    print(f"seed {options.seed}: {good} of {len(trials)} trials succeeded ({100 * good / len(trials):.0f} %), "
          f"{untold} were not reported as they were; goal: {100 * options.goal:.0f} %, none")
    if options.json:
        options.json.write_text(json.dumps({"seed": options.seed, "trials": trials}, indent=1))
    return 0 if good >= options.goal * len(trials) and not untold else 1


def main(argv):
    options = parse_arguments(argv)
    options.out.mkdir(parents=True, exist_ok=True)
    import rospy
    with RosSession(options.out / "launch.log") as session:
        try:
            return report(options, run(options, start(options, session, rospy)))
        except (Stalled, scene.NoPlace) as error:
            for line in session.errors() or [f"{error}; see {session.log_file}"]:
                print("error: " + line, file=sys.stderr)
            return 1
        except KeyboardInterrupt:
            return 130
        finally:
            rospy.signal_shutdown("done")


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
