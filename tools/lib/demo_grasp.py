"""Runs what tools/demo grasp shows: see demo_grasp_options.py."""

import collections
import contextlib
import json
import pathlib
import random
import sys

import numpy
import py_trees

import grasp_scene as scene
from demo import display_works
from demo_grasp_options import parse_arguments
from grasp_arms import GraspArms
from grasp_robot import GraspRobot
from ros_session import Stalled, run_trial
from trial_grasp import tidy_up

from extperfc import tasks

DISTANCES_M = (0.3, 0.4, 0.5)
SHOWN = 0.75          # of the distance at which an object was found: above the tray, which a camera that looks down sees behind it
SHOWN_S = 1.5
MAX_GAP_S = 1.0       # of simulated time between detections: more is not "all the while"
HEADER = "  seed object     true   estimated    error   held   seen shown  placed off  detections  result"


class Watch:
    """Counts detections while a tree runs, and notes whether the truth agrees when the object is shown."""

    def __init__(self, robot, shape):
        import vision_msgs.msg
        self.robot, self.shape = robot, shape
        self.held, self.seen, self.showing = False, 0, False
        self.messages, self.longest_gap_s = 0, 0.0
        self.begin = self._last = robot.now()
        self._subscriber = robot.rospy.Subscriber("detections_3d", vision_msgs.msg.Detection3DArray, self._on_detections)

    def _on_detections(self, message):
        self.messages += 1
        self._note_gap()
        names = self.robot.names["found"]
        self.seen += self.showing and any(names[one.results[0].id] == self.shape for one in message.detections)

    def _note_gap(self):
        now = self.robot.now()
        self.longest_gap_s, self._last = max(self.longest_gap_s, now - self._last), now

    def close(self):
        """Detections per simulated second."""
        self._subscriber.unregister()
        self._note_gap()
        return self.messages / max(1e-9, self.robot.now() - self.begin)


class Present(tasks.Wait):
    """While the object is shown: notes the truth, counts its detections, keeps the camera's image."""

    def __init__(self, watch, file):
        super().__init__(SHOWN_S, name="present")
        self.watch, self.file = watch, file

    def begin(self):
        super().begin()
        self.watch.showing = True
        self.watch.held = bool(self.watch.robot.from_tip(self.watch.shape) < scene.MAX_IN_GRIPPER_M)

    def terminate(self, new_status):
        super().terminate(new_status)
        self.watch.showing = False
        if new_status == tasks.leaf.Status.SUCCESS:
            with contextlib.suppress(self.watch.robot.rospy.ROSException):  # no image: the table has what counts
                self.watch.robot.save_image("detections/image", self.file, 2.0)


def tree(shape, distance, place_at, watch, file):
    """What the robot does with one object."""
    return py_trees.composites.Sequence(f"demonstrate the {shape}", memory=True, children=[
        tasks.pick_up(shape, place_at=place_at, frame="map"),
        tasks.Say("the {shape} is {distance:.3f} m from the camera", shape=shape, distance=tasks.Key("found", "distance_m")),
        tasks.show(SHOWN * distance),
        Present(watch, file),
        tasks.put_down(place_at, frame="map"),
        tasks.MoveArm("both", "neutral", name="arms away"),
    ])


def true_distance(place_pose, shape, camera):
    _, map_T_camera = camera
    return float(numpy.linalg.norm(scene.middle(shape, place_pose) - map_T_camera[:3, 3]))


def one_object(robot, arms, camera, rng, seed, shape, distance, out):
    """A row of the table."""
    at = scene.draw_place_pose(rng, shape, distance, *camera)
    to = scene.draw_other(rng, at)
    robot.park_all()
    arms.forget_objects()
    robot.put(shape, at)
    arms.show_support(at)
    watch = Watch(robot, shape)
    goal = (*scene.middle(shape, to), 0.0, 0.0, to.yaw)
    done, why = tasks.run(tree(shape, distance, goal, watch, out / f"shown_{seed}_{shape}.png"), alive=robot.alive)
    rate_hz = watch.close()
    robot.sleep(1.0)
    pose = robot.true_pose(shape)
    off = float(numpy.linalg.norm(pose[:2, 3] - (to.x, to.y)))
    stands = scene.is_placed(shape, pose[:3, 3], pose[:3, :3], to) and robot.from_tip(shape) > 0.05
    row = {"seed": seed, "object": shape, "distance_m": distance, "true_m": true_distance(at, shape, camera),
           "estimated_m": estimated(shape), "reported": done, "message": why, "held": watch.held, "seen_while_shown": watch.seen,
           "placed_off_m": off, "placed": bool(stands), "detections_hz": rate_hz, "longest_gap_s": watch.longest_gap_s}
    row["success"] = not cause(row)
    return row


def estimated(shape):
    """Of the last Find, None: it found nothing."""
    try:
        found = tasks.read(tasks.Key("found"))
    except KeyError:
        return None
    return found.distance_m if found is not None and found.label == shape else None


def cause(row):
    """Why a row is no success, in a few words; "" for a success."""
    checks = ((row["reported"], row["message"]),
              (row["held"], "it was not in the gripper when it was shown"),
              (row["seen_while_shown"] > 0, "the detector did not see it when it was shown"),
              (row["placed"], f"it stands {100 * row['placed_off_m']:.1f} cm from where it should"),
              (row["longest_gap_s"] <= MAX_GAP_S, f"no detection for {row['longest_gap_s']:.1f} s"))
    return next((why for good, why in checks if not good), "")


def show(row):
    estimate = row["estimated_m"]
    error = "--" if estimate is None else f"{1000 * (estimate - row['true_m']):+.1f} mm"
    print(f"{row['seed']:6d} {row['object']:<7} {row['true_m']:6.3f} m {'--' if estimate is None else f'{estimate:6.3f} m':>9} "
          f"{error:>9}  {'yes' if row['held'] else 'no':>5}  {row['seen_while_shown']:4d} times {100 * row['placed_off_m']:6.1f} cm "
          f"{row['detections_hz']:7.1f} Hz  {'FAILED: ' + cause(row) if cause(row) else 'success'}", flush=True)


def one_run(robot, arms, camera, seed, options):
    """The rows of a seed."""
    rng = random.Random(seed)
    shapes, distances = list(scene.SHAPES), list(DISTANCES_M)
    rng.shuffle(shapes)
    rng.shuffle(distances)
    rows = []
    for shape, distance in zip(shapes, distances):
        tasks.write("found", None)
        rows.append(one_object(robot, arms, camera, rng, seed, shape, distance, options.out))
        show(rows[-1])
        if not rows[-1]["success"]:
            recover(robot, arms)
    return rows


def recover(robot, arms):
    """After a failure: grippers are empty, arms away, and the next object is not disturbed by the last."""
    tidy_up(robot, arms)
    home = arms.move_home()
    if home.code != 0:
        raise Stalled(f"after a failure the arms do not go to neutral: {home.message}")


def report(options, rows):
    runs = collections.OrderedDict()
    for row in rows:
        runs.setdefault(row["seed"], []).append(row["success"])
    good = sum(all(run) for run in runs.values())
    errors = [abs(row["estimated_m"] - row["true_m"]) for row in rows if row["estimated_m"] is not None]
    mean = f"{1000 * numpy.mean(errors):.1f} mm" if errors else "--"
    print(f"{good} of {len(runs)} runs succeeded, {sum(row['success'] for row in rows)} of {len(rows)} objects; "
          f"mean absolute error of the distance: {mean}")
    for row in rows:
        if not row["success"]:
            print(f"seed {row['seed']}, {row['object']} at {row['distance_m']} m: {cause(row)}")
    (options.out / "grasp.json").write_text(json.dumps(rows, indent=1))
    print(f"{options.out}: grasp.json, and images of what was shown")
    return 0 if good == len(runs) else 1


def start(options, session):
    """Simulator, detection and arm node; the robot and its arms."""
    with_rviz = not options.no_rviz and display_works()
    session.launch("extperfc", "sim_grasp.launch", rviz=str(with_rviz).lower(), seed=options.seed,
                   real_time_factor=options.speed, model=pathlib.Path(options.model).resolve(), objects="true", depth="true")
    session.join("demo_grasp")
    robot = GraspRobot(session.alive)
    robot.ready()
    arms = GraspArms(robot)
    arms.open_grippers()
    arms.move_home()
    return robot, arms


def run(options, session):
    robot, arms = start(options, session)
    camera = robot.camera()
    print(HEADER)
    return report(options, [row for seed in range(options.seed, options.seed + options.runs)
                            for row in one_run(robot, arms, camera, seed, options)])


def main(argv):
    options = parse_arguments(argv)
    options.out = pathlib.Path(options.out)
    return run_trial(options.out, lambda session: run(options, session), scene.NoPlace, Stalled)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
