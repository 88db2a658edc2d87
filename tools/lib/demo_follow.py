"""Runs what tools/demo follow shows: see demo_follow_options.py."""

import json
import math
import pathlib
import sys
import threading

import cv2
import numpy
import py_trees

import follow_scene as scene
from demo import display_works
from demo_follow_options import REPO, parse_arguments
from driven_contacts import PERSON_RADIUS_M, TrueMap, distance_to_footprint
from each_seed import each_seed
from pose_errors import Pose
from ros_session import Stalled, run_trial

from extperfc import tasks

FAR_M = 3.0          # the robot should not be farther from the leader
FOLLOWED = 0.9       # of the time
READY_S = 60.0       # of real time, for the stack to come up
HEADER = "  seed   faces  followed    mean    most  lost    driven  contacts  ghosts     map  result"


def tree(options):
    """What the robot does."""
    children = []
    if options.face_model:
        children = [tasks.EnrollFace(scene.LEADER, timeout_s=60.0), tasks.Say(f"that is {scene.LEADER}")]
    name = scene.LEADER if options.face_model else ""
    children += [tasks.Follow(name, seconds=options.seconds), tasks.Say("enough")]
    return py_trees.composites.Sequence("follow", memory=True, children=children)


class Observer:
    """What the truth says meanwhile."""

    def __init__(self, session):
        import extperfc.msg
        import nav_msgs.msg
        import rosgraph_msgs.msg
        import rospy
        import std_msgs.msg
        import vision_msgs.msg
        self.rospy, self.session, self.lock = rospy, session, threading.Lock()
        self.now_s, self.robot, self.leader, self.classes = 0.0, None, scene.START, None
        self.samples, self.bumps, self.near_person, self.faces, self.named, self.newest_faces = [], 0, 0, 0, 0, []
        self.map = self.true_map = self.start = None
        self.navigator = None  # its newest NavigationStatus
        self._blocked = self._was_near = False
        rospy.Subscriber("clock", rosgraph_msgs.msg.Clock, self._on_clock, queue_size=1)
        rospy.Subscriber("sim/truth/odom", nav_msgs.msg.Odometry, self._on_odom, queue_size=50)
        rospy.Subscriber("sim/truth/blocked", std_msgs.msg.Bool, self._on_blocked)
        rospy.Subscriber("sim/truth/vision_info", vision_msgs.msg.VisionInfo, self._on_info)
        rospy.Subscriber("sim/truth/objects", vision_msgs.msg.Detection3DArray, self._on_objects, queue_size=5)
        rospy.Subscriber("sim/truth/map", nav_msgs.msg.OccupancyGrid, self._on_true_map)
        rospy.Subscriber("map", nav_msgs.msg.OccupancyGrid, self._on_map)
        rospy.Subscriber("faces", extperfc.msg.FaceArray, self._on_faces, queue_size=5)
        rospy.Subscriber("navigation_status", extperfc.msg.NavigationStatus,
                         lambda message: setattr(self, "navigator", message), queue_size=5)

    def wait_until_ready(self):
        import time
        end = time.monotonic() + READY_S
        while self.robot is None or self.map is None or self.true_map is None or not self.samples:
            if not self.session.alive() or time.monotonic() > end:
                raise Stalled("simulator, mapper and navigator did not come up")
            time.sleep(0.1)

    def _on_clock(self, message):
        self.now_s = message.clock.to_sec()

    def _on_odom(self, message):
        p, q = message.pose.pose.position, message.pose.pose.orientation
        self.robot = Pose(p.x, p.y, 2 * math.atan2(q.z, q.w))
        self.start = self.start or self.robot

    def _on_blocked(self, message):
        self.bumps += message.data and not self._blocked
        self._blocked = message.data

    def _on_info(self, message):
        self.classes = self.rospy.get_param(message.database_location, [])

    def _on_objects(self, message):
        if self.classes is None or self.robot is None:
            return
        person = self.classes.index("person") if "person" in self.classes else -1
        people = [(d.bbox.center.position.x, d.bbox.center.position.y) for d in message.detections
                  if d.results and d.results[0].id == person]
        if not people:
            return
        self.leader = min(people, key=lambda one: math.dist(one, self.leader))
        near = min(distance_to_footprint(self.robot, *one) for one in people) < PERSON_RADIUS_M
        before = self.samples[-1][2] if self.samples else (self.robot.x, self.robot.y)
        moves = math.dist(before, (self.robot.x, self.robot.y)) > 0.005
        self.near_person += near and moves and not self._was_near
        self._was_near = near
        self.samples.append((message.header.stamp.to_sec(), self.leader, (self.robot.x, self.robot.y)))

    def _on_faces(self, message):
        self.faces += len(message.faces)
        self.named += sum(face.name == scene.LEADER for face in message.faces)
        self.newest_faces = [(face.name, face.similarity, face.bbox.size_x) for face in message.faces]

    def _on_true_map(self, message):
        self.true_map = TrueMap(_cells(message), message.info.resolution, message.info.origin.position.x,
                                message.info.origin.position.y)

    def _on_map(self, message):
        self.map = message

    def distances_m(self):
        """Between robot and leader, since the leader has walked."""
        walked = [sample for sample in self.samples if sample[0] > scene.meets_s() + 5.0]
        return numpy.array([math.dist(leader, robot) for _, leader, robot in walked])

    def driven_m(self):
        path = numpy.array([robot for _, _, robot in self.samples])[::5]
        return float(numpy.linalg.norm(numpy.diff(path, axis=0), axis=1).sum()) if len(path) > 1 else 0.0


def _cells(message):
    return numpy.array(message.data, numpy.int8).reshape(message.info.height, message.info.width)


def start(options, session):
    world, urdf = options.out / "office.yaml", options.out / "urdf" / "robot.urdf"
    scene.write_world(REPO / "config" / "worlds" / "office.yaml", options.seed, options.seconds, world)
    scene.write_urdf(REPO / "urdf" / "mobile_baxter.urdf", urdf)
    with_rviz = not options.no_rviz and display_works()
    session.launch("extperfc", "sim_follow.launch", rviz=str(with_rviz).lower(), seed=options.seed, world=world.resolve(),
                   urdf=urdf.resolve(), real_time_factor=options.speed, embedder=options.embedder,
                   face_model=options.face_model.resolve() if options.face_model else "")
    session.join("demo_follow")
    observer = Observer(session)
    observer.wait_until_ready()
    return observer


def one_run(options, session):
    """The exit code of a seed's run."""
    observer = start(options, session)
    trace = []
    done, why = tasks.run(tree(options), alive=session.alive, on_tick=lambda root: note(trace, root, observer))
    (options.out / "trace.json").write_text(json.dumps(trace))
    row = {"seed": options.seed, "reported": done, "message": why, **measured(observer)}
    row["cause"] = cause(row)
    (options.out / "follow.json").write_text(json.dumps(row, indent=1))
    draw(observer, row, options.out / "follow.png")
    show(row)
    return 0 if not row["cause"] else 1


def note(trace, root, observer):
    """What the robot believes, twice a second, beside the truth: for who looks for the cause of a failure."""
    leaf = root.tip()
    if leaf is None or not isinstance(leaf, tasks.Follow) or trace and observer.now_s - trace[-1]["time_s"] < 0.5:
        return
    trace.append({"time_s": observer.now_s, "says": leaf.feedback_message, "track": leaf.leader.track, "leader": leaf.leader.position,
                  "people": [(one.track, *one.position, *one.velocity, one.seen) for one in leaf.people], "goal": leaf.goal,
                  "navigator": said_by(observer.navigator), "faces": observer.newest_faces,
                  "true_leader": observer.leader, "true_robot": (observer.robot.x, observer.robot.y, observer.robot.yaw)})


def said_by(navigator):
    """Of a NavigationStatus, None before the first."""
    return navigator and {name: getattr(navigator, name) for name in ("state", "reason", "distance_left", "speed", "recoveries")}


def measured(observer):
    distances = observer.distances_m()
    info = observer.map.info
    ghosts = scene.ghosts(_cells(observer.map), info.resolution, (info.origin.position.x, info.origin.position.y),
                          (observer.start.x, observer.start.y, observer.start.yaw), observer.true_map)
    leader = tasks.read(tasks.Key("leader"))
    return {"faces": observer.faces, "named": observer.named, "followed": float((distances <= FAR_M).mean()) if len(distances) else 0.0,
            "mean_m": float(distances.mean()) if len(distances) else None, "most_m": float(distances.max()) if len(distances) else None,
            "lost": leader.lost, "driven_m": observer.driven_m(), "bumps": observer.bumps, "touched_people": observer.near_person,
            "ghosts": ghosts, "map_m2": float((_cells(observer.map) >= 0).sum() * info.resolution ** 2)}


def cause(row):
    """Why a run is no success; "" for a success."""
    checks = ((row["reported"], row["message"]),
              (row["followed"] >= FOLLOWED, f"nearer than {FAR_M:g} m for {100 * row['followed']:.0f} % of the time only"),
              (row["bumps"] + row["touched_people"] == 0, f"it touched something {row['bumps']} times, people {row['touched_people']} times"),
              (not row["ghosts"], "the map shows something at " + ", ".join(f"({x:.1f}, {y:.1f})" for x, y in row["ghosts"][:3])))
    return next((why for good, why in checks if not good), "")


def show(row):
    metres = [f"{row[key]:6.2f} m" if row[key] is not None else "      --" for key in ("mean_m", "most_m")]
    print(f"{row['seed']:6d}  {row['named']:6d}{100 * row['followed']:8.0f} %{metres[0]}{metres[1]}{row['lost']:6d}"
          f"{row['driven_m']:8.1f} m{row['bumps'] + row['touched_people']:10d}{len(row['ghosts']):8d}{row['map_m2']:5.0f} m2"
          f"  {'FAILED: ' + row['cause'] if row['cause'] else 'success'}", flush=True)


def draw(observer, row, file):
    """The map that was made, both paths on it: the leader's orange, the robot's blue, ghosts red."""
    info, cells = observer.map.info, _cells(observer.map)
    image = numpy.full((*cells.shape, 3), 205, numpy.uint8)
    image[(cells >= 0) & (cells < 50)] = 252
    image[cells >= 50] = 40
    cos, sin = math.cos(observer.start.yaw), math.sin(observer.start.yaw)

    def pixel(place):
        dx, dy = place[0] - observer.start.x, place[1] - observer.start.y
        x, y = cos * dx + sin * dy, -sin * dx + cos * dy
        return int((x - info.origin.position.x) / info.resolution), int((y - info.origin.position.y) / info.resolution)

    for index, colour in ((1, (30, 130, 250)), (2, (200, 90, 20))):
        points = numpy.array([pixel(sample[index]) for sample in observer.samples[::5]], numpy.int32)
        cv2.polylines(image, [points], False, colour, 2, cv2.LINE_AA)
    for ghost in row["ghosts"]:
        cv2.circle(image, pixel(ghost), 8, (40, 40, 230), 2, cv2.LINE_AA)
    rows, columns = numpy.nonzero(cells >= 0)
    image = image[max(0, rows.min() - 10):rows.max() + 10, max(0, columns.min() - 10):columns.max() + 10]
    cv2.imwrite(str(file), image[::-1])


def series(options):
    """Each seed in a process of its own; returns the exit code."""
    arguments = ["--seconds", str(options.seconds), "--embedder", options.embedder,
                 *(["--face-model", str(options.face_model)] if options.face_model else [])]
    return each_seed("demo_follow.py", options, arguments, HEADER, "log, follow.json and follow.png")


def main(argv):
    one = "--one" in argv
    options = parse_arguments([argument for argument in argv if argument != "--one"])
    options.out = pathlib.Path(options.out)
    options.out.mkdir(parents=True, exist_ok=True)
    if not one:
        return series(options)
    return run_trial(options.out, lambda session: one_run(options, session), Stalled)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
