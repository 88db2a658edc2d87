"""Runs what tools/demo tour shows: see demo_tour_options.py."""

import dataclasses
import json
import math
import pathlib
import sys

import numpy
import py_trees

import tour_film
import tour_scene as scene
from demo import display_works
from demo_tour_options import REPO, parse_arguments
from each_seed import each_seed
from grasp_robot import GraspRobot
from ros_session import Stalled, run_trial

from extperfc import tasks
from extperfc.arm import ArmError
from extperfc.tasks.search import base_pose

MAX_ERROR_M = 0.10          # of the placed cube from where it should be: the map's error is part of it
HEADER = "  seed  cube in    explored  searched   fetched  delivered    total   driven   placed off  contacts  result"
STAGES = ("explore", "search", "fetch", "deliver")


def sequence(name, *children):
    return py_trees.composites.Sequence(name, memory=True, children=children)


def search():
    return tasks.Search("cube", "seen", max_size_m=0.1)


def fetch():
    """Picks the cube that was seen, from up to three places before it."""
    return sequence("fetch it", py_trees.decorators.Retry("3 places", sequence(
        "from a place before it", tasks.Approach(tasks.Key("seen"), clear_m=tasks.CLEAR_M), tasks.SeeAround(),
        tasks.SeeSupport(tasks.Key("seen")), tasks.pick_up("cube", frame="map")), num_failures=3), tasks.carry())


def bring_or_fetch_again(to):
    """Brings the cube; one that slipped out of the gripper is sought and fetched again, once."""
    lost = sequence("fetch it again", py_trees.decorators.Inverter("lost", tasks.StillHeld()), tasks.Say("lost it: looking again"),
                    search(), fetch(), tasks.bring(to))
    return py_trees.composites.Selector("bring, or fetch again", memory=True, children=[tasks.bring(to), lost])


def tree(to):
    """What the robot does: the cube goes to the point `to` of the map."""
    return sequence(
        "tour",
        sequence("explore", tasks.Explore(time_limit=600.0, name="map the flat"), tasks.Say("the flat is mapped")),
        sequence("search", search(),
                 tasks.Say("there is a cube at ({p.x:.2f}, {p.y:.2f}, {p.z:.2f})", p=tasks.Key("seen", "position"))),
        sequence("fetch", fetch(), tasks.Say("got it")),
        sequence("deliver", bring_or_fetch_again(to), tasks.MoveArm("both", "tuck"), tasks.Say("done")))


class Observer:
    """What the truth says meanwhile: distance driven, contacts, and when each stage ended."""

    def __init__(self, robot, root):
        import nav_msgs.msg
        import std_msgs.msg
        self.robot, self.root, self.begin = robot, root, robot.now()
        self.path, self.pose, self.bumps, self.stages_s, self.film = [], (0.0, 0.0, 0.0), 0, {}, None
        self.map_errors_m = {}  # at the end of each stage: how far the robot is from where it believes to be
        self._blocked = False
        robot.rospy.Subscriber("sim/truth/odom", nav_msgs.msg.Odometry, self._on_odom, queue_size=50)
        robot.rospy.Subscriber("sim/truth/blocked", std_msgs.msg.Bool, self._on_blocked)

    def _on_odom(self, message):
        p, q = message.pose.pose.position, message.pose.pose.orientation
        self.pose = (p.x, p.y, 2 * math.atan2(q.z, q.w))
        if not self.path or math.hypot(p.x - self.path[-1][0], p.y - self.path[-1][1]) > 0.02:
            self.path.append((p.x, p.y))

    def _on_blocked(self, message):
        self.bumps += message.data and not self._blocked
        self._blocked = message.data

    def on_tick(self):
        for stage in self.root.children:
            if stage.status == py_trees.common.Status.SUCCESS and stage.name not in self.stages_s:
                self.stages_s[stage.name] = self.robot.now() - self.begin
                self.map_errors_m[stage.name] = self.map_error_m()
        if self.film is not None:
            self.film.tick(next((stage.name for stage in self.root.children if stage.name not in self.stages_s), ""))

    def map_error_m(self):
        """The map begins where the robot began, at the world's origin. None: the robot does not know where it is."""
        try:
            return math.dist(base_pose("map")[:2], self.pose[:2])
        except ArmError:
            return None

    def driven_m(self):
        return float(numpy.linalg.norm(numpy.diff(numpy.array(self.path), axis=0), axis=1).sum()) if len(self.path) > 1 else 0.0


def put_cube(robot, task):
    """Where the seed wants it."""
    x, y, yaw = task.cube
    robot.move_body("cube", (x, y, task.top + scene.CUBE_M / 2 + scene.LIFT_M), yaw)


def put_objects(robot, task):
    """The cube, and sphere and cone on the same table."""
    put_cube(robot, task)
    for name, place in task.neighbours.items():
        robot.move_body(name, place)


def start(options, task, session):
    world = options.out / "flat.yaml"
    scene.write_world(REPO / "config" / "worlds" / "flat.yaml", task, world)
    with_rviz = not options.no_rviz and display_works()
    session.launch("extperfc", "sim_tour.launch", rviz=str(with_rviz).lower(), seed=options.seed, real_time_factor=options.speed,
                   world=world.resolve(), model=pathlib.Path(options.model).resolve())
    session.join("demo_tour")
    robot = GraspRobot(session.alive)
    robot.ready()
    return robot


def one_run(options, session):
    """The row of a seed."""
    task = scene.draw_task(options.seed)
    robot = start(options, task, session)
    put_objects(robot, task)
    to = task.to
    root = tree(to)
    observer = Observer(robot, root)
    if options.film:
        observer.film = tour_film.Film(observer)

    def alive():
        return session.alive() and robot.now() < observer.begin + options.limit

    slips = options.slip

    def on_tick(_):
        nonlocal slips
        observer.on_tick()
        if slips and "fetch" in observer.stages_s:
            slips = False
            put_cube(robot, task)

    done, why = tasks.run(root, alive=alive, on_tick=on_tick)
    robot.sleep(1.0)
    cube = robot.true_pose("cube")[:3, 3]
    off = math.hypot(cube[0] - to[0], cube[1] - to[1])
    stands = off < MAX_ERROR_M and abs(cube[2] - to[2]) < 0.01
    row = {"seed": options.seed, **dataclasses.asdict(task), "stages_s": observer.stages_s, "seconds": robot.now() - observer.begin,
           "map_errors_m": {**observer.map_errors_m, "end": observer.map_error_m()}, "cube_at": [*map(float, cube)],
           "driven_m": observer.driven_m(), "contacts": observer.bumps, "reported": done, "message": why,
           "placed_off_m": off, "placed": bool(stands), "path": observer.path}
    row["cause"] = cause(row)
    (options.out / "tour.json").write_text(json.dumps(row, indent=1))
    if observer.film is not None:
        observer.film.save(options.out / "tour.webp")
    show(row)
    return 0 if not row["cause"] else 1


def cause(row):
    """Why a run is no success; "" for a success."""
    checks = ((row["reported"], row["message"]), (row["placed"], f"the cube stands {row['placed_off_m']:.2f} m from where it should"),
              (not row["contacts"], f"the base touched something {row['contacts']} times"))
    return next((why for good, why in checks if not good), "")


def show(row):
    ends = row["stages_s"]
    times = [f"{ends[stage] - ends.get(before, 0.0):7.0f} s" if stage in ends else f"{'--':>9}"
             for stage, before in zip(STAGES, ("", *STAGES))]
    print(f"{row['seed']:6d}  {row['room']:<9}{' '.join(times)}{row['seconds']:9.0f} s{row['driven_m']:7.1f} m"
          f"{100 * row['placed_off_m']:10.1f} cm{row['contacts']:9d}   {'FAILED: ' + row['cause'] if row['cause'] else 'success'}", flush=True)


def series(options):
    """Each seed in a process of its own; returns the exit code."""
    flags = [f"--{name}" for name in ("film", "slip") if getattr(options, name)]
    arguments = ["--limit", str(options.limit), "--model", str(options.model), *flags]
    return each_seed("demo_tour.py", options, arguments, HEADER, "log and tour.json")


def main(argv):
    one = "--one" in argv
    options = parse_arguments([argument for argument in argv if argument != "--one"])
    options.out = pathlib.Path(options.out)
    if options.film and tour_film.Image is None:
        print("error: --film needs python3-pil: sudo apt-get install python3-pil", file=sys.stderr)
        return 2
    if not one:
        return series(options)
    return run_trial(options.out, lambda session: one_run(options, session), Stalled)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
