"""Compares the distance of an object by detector and depth with the arm's forward kinematics, as figure 9 of the paper.

The simulated robot holds a cube, a sphere and a cone in turn at given distances before its camera. Detector and
box_depth see the simulated colour and depth images; the reference is the distance from the camera to the object's
middle, computed from the joint positions (tf) and where the object is in the gripper, which is measured once, after
the fingers have closed. The same images are judged with the boxes of the network and with the true boxes of the
visible parts, so that the depth part is judged alone, too. Gravity is off, so that an object floats until the fingers
close on it.
"""

import argparse
import json
import math
import os
import pathlib
import sys
import threading
import time

import numpy
import yaml

REPO = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(REPO / "src"))

import depth_scores as scores  # noqa: E402
import grasp_scene as scene  # noqa: E402
from grasp_robot import OPTICAL_FRAME, GraspRobot, matrix  # noqa: E402
from ros_session import Stalled, run_trial  # noqa: E402
from sim_arm import SimArm  # noqa: E402

from extperfc import robot_description as rd  # noqa: E402

WS = pathlib.Path(os.environ.get("EXTPERFC_WS", REPO / ".ws"))
NEAR_M = 0.15          # an estimate that is farther from the object is of something else
MIN_RANGE_M = 0.195    # nearer centres have surfaces at or below the camera's minimum depth (0.175 m)
IMAGES_S = 20.0        # of simulated time for the images of one distance
TAKE_M = 0.4          # where an object is put between the fingers
AWAY = (-1.4, -1.5)    # where tray and column go, out of the image
TILTS_DEG, AZIMUTHS_DEG = range(0, 95, 10), range(0, 360, 30)
# The object's z axis (a cone's axis) is the gripper's x axis, which is up in the image; the fingers close along y.
GRIPPER_T_OBJECT = rd.transform(rotation=numpy.array([[0.0, 0, 1], [0, 1, 0], [-1, 0, 0]]))


def parse_arguments(argv):
    parser = argparse.ArgumentParser(prog="tools/trial_depth",
                                     description=__doc__,
                                     formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--shapes", nargs="+", choices=list(scene.SHAPES), default=list(scene.SHAPES), metavar="SHAPE",
                        help="default: cube sphere cone")
    parser.add_argument("--ranges", nargs="+", type=float, default=list(numpy.linspace(0.2, 0.9, 20)), metavar="M",
                        help="of the object's centre from the camera; default: 20 from 0.2 to 0.9")
    parser.add_argument("--near", nargs="*", type=float, default=[0.12, 0.15, 0.18], metavar="M",
                        help="distances below the camera's minimum range, reported apart; default: 0.12 0.15 0.18")
    parser.add_argument("--images", type=int, default=5, metavar="N", help="per distance; default: 5")
    parser.add_argument("--boxes", nargs="+", choices=list(scores.BOXES), default=list(scores.BOXES), metavar="BOXES",
                        help="network, truth; default: both, from the same images")
    parser.add_argument("--estimator",
                        default="nearest_mode",
                        choices=("nearest_mode", "median", "trimmed_mean", "mean"),
                        help="of box_depth; mean is the paper's; default: nearest_mode")
    parser.add_argument("--model", type=pathlib.Path, default=REPO / "models" / "shapes", metavar="FOLDER",
                        help="model folder, see models/README.md; default: models/shapes")
    parser.add_argument("--side",
                        choices=("left", "right"),
                        default="right",
                        help="arm that holds the objects; default: right")
    parser.add_argument("--seed", type=int, default=1, metavar="N", help="of the simulator's noise; default: 1")
    parser.add_argument("--speed",
                        type=float,
                        default=1.0,
                        metavar="FACTOR",
                        help="simulated seconds per second; default: 1")
    parser.add_argument("--out", type=pathlib.Path, default=WS / "depth", metavar="FOLDER",
                        help="depth_kinematics.csv, .json and .png, and the log; default: .ws/depth")
    options = parser.parse_args(argv)
    if options.images < 1 or options.speed <= 0 or not all(0.05 <= r <= 1.2 for r in options.ranges + options.near):
        parser.error("--images and --speed must be positive, distances 0.05 to 1.2 m")
    if not (options.model / "model.yaml").is_file():
        parser.error(f"{options.model} holds no model.yaml: name a model folder")
    return options


def write_config(folder):
    """config/simulator.yaml without gravity; the file's path."""
    config = yaml.safe_load((REPO / "config" / "simulator.yaml").read_text())
    config["physics"]["gravity_m_s2"] = 0.0
    file = folder / "simulator.yaml"
    file.write_text(yaml.safe_dump(config))
    return file


class Estimates:
    """Detections and their positions of one kind of boxes, as they come."""

    def __init__(self, boxes):
        import rospy
        import vision_msgs.msg
        self.boxes, self._lock, self._messages, self._names = boxes, threading.Lock(), {}, []
        prefix = {"network": "", "truth": "truth/"}[boxes]
        detections, info = {"network": ("detections", "vision_info"),
                            "truth": ("sim/truth/detections", "sim/truth/vision_info")}[boxes]
        self._rospy = rospy
        rospy.Subscriber(info, vision_msgs.msg.VisionInfo, self._on_info)
        rospy.Subscriber(detections, vision_msgs.msg.Detection2DArray, self._add, "boxes", queue_size=20)
        for topic, kind in ((prefix + "detections_3d", "centre"), (prefix + "detections_3d/surface", "surface")):
            rospy.Subscriber(topic, vision_msgs.msg.Detection3DArray, self._add, kind, queue_size=20)

    def _on_info(self, message):
        self._names = self._rospy.get_param(message.database_location, [])

    def _add(self, message, kind):
        with self._lock:
            self._messages.setdefault(message.header.stamp.to_sec(), {})[kind] = message
            for stamp in sorted(self._messages)[:-60]:
                del self._messages[stamp]

    def complete(self, since_s):
        """(stamp [s], {kind: message}) of the images after a time of which all has come, oldest first."""
        with self._lock:
            return [(stamp, dict(parts)) for stamp, parts in sorted(self._messages.items())
                    if stamp > since_s and len(parts) == 3]

    def label(self, detection):
        index = detection.results[0].id
        return self._names[index] if 0 <= index < len(self._names) else ""


class Holder:
    """Holds an object at distances before the camera."""

    def __init__(self, options, session):
        self.options = options
        self.robot = GraspRobot(session.alive)
        self.robot.wait(lambda: self.robot.now() > 0 and self.robot.truth is not None and "truth" in self.robot.names,
                        "the simulator's truth")
        self.description = rd.RobotDescription.from_file(REPO / "urdf" / "mobile_baxter.urdf")
        self.arm = SimArm(self.description, options.side, self.robot.wait, self.robot.now)
        self.robot.camera()
        self.base_T_camera = self.robot.transform("base", OPTICAL_FRAME)
        self.random = numpy.random.default_rng(options.seed)
        self._last = None  # (tilt, azimuth, joints) of the last pose
        self.gripper_T_object = GRIPPER_T_OBJECT  # of the middle of what is held, measured when the fingers had closed
        for body in ("tray", "column"):
            self.robot.move_body(body, (*AWAY, 0.0))

    def _gripper_pose(self, range_m, tilt_deg, azimuth_deg):
        """base_T_gripper with the object on the camera's axis; the gripper points to the camera, tilted by an angle."""
        tilt = (rd.rotation_about((0, 0, 1), math.radians(azimuth_deg)) @ rd.rotation_about(
            (1, 0, 0), math.radians(tilt_deg)))
        z = tilt @ numpy.array([0.0, 0, -1])
        up = numpy.array([0.0, -1, 0])
        x = up - z * (up @ z)
        if numpy.linalg.norm(x) < 0.2:
            return None
        x /= numpy.linalg.norm(x)
        return self.base_T_camera @ rd.transform((0, 0, range_m), numpy.column_stack([x, numpy.cross(z, x), z]))

    def _candidates(self):
        if self._last is not None:
            yield self._last[:2]
        for tilt in TILTS_DEG:
            yield from ((tilt, azimuth) for azimuth in (AZIMUTHS_DEG if tilt else (0,)))

    def move_to(self, range_m):
        """Brings the gripper to a distance, pointing to the camera as straight as the arm can. Raises Stalled."""
        for tilt, azimuth in self._candidates():
            pose = self._gripper_pose(range_m, tilt, azimuth)
            start = self._last[2] if self._last is not None else None
            joints = None if pose is None else self.arm.kinematics.solve(pose, self.random, tries=2, start=start)
            if joints is not None:
                self._last = (tilt, azimuth, joints)
                self.arm.move(joints)
                return
        raise Stalled(f"the {self.options.side} arm does not reach {range_m} m before the camera")

    def take(self, shape):
        """The gripper opens, the object is put between the fingers, they close."""
        self.robot.park_all()
        self.arm.grip(100)
        map_T_object = self.robot.transform("map", self.arm.link) @ GRIPPER_T_OBJECT
        self.robot.move_body_to(shape, scene.body_of(shape, map_T_object))
        self.arm.grip(0)
        self.robot.sleep(0.5)
        self.gripper_T_object = self._in_gripper(shape)
        off = numpy.linalg.norm(self.gripper_T_object[:3, 3])
        if off > 0.02:
            raise Stalled(f"the gripper does not hold the {shape}: it is {1000 * off:.0f} mm away")

    def _in_gripper(self, shape):
        """True gripper_T_object, of the object's middle."""
        map_T_object = self.robot.true_pose(shape) @ numpy.linalg.inv(scene.body_of(shape, numpy.eye(4)))
        return numpy.linalg.inv(self.robot.transform("map", self.arm.link)) @ map_T_object

    def slipped(self, shape):
        """How far [m] the object has moved in the gripper since it was taken."""
        return float(numpy.linalg.norm((self._in_gripper(shape) - self.gripper_T_object)[:3, 3]))

    def camera_T_object(self):
        """By forward kinematics."""
        return self.robot.transform(OPTICAL_FRAME, self.arm.link) @ self.gripper_T_object


def judge(estimates, parts, shape, range_m, camera_T_object, measures):
    """(boxes of the object, estimates) of one image; adds the Measures."""
    found = sum(estimates.label(one) == shape for one in parts["boxes"].detections)
    best = None
    for centre, surface in zip(parts["centre"].detections, parts["surface"].detections):
        point = matrix(centre.bbox.center)[:3, 3]
        away = numpy.linalg.norm(point - camera_T_object[:3, 3])
        if estimates.label(centre) == shape and away < NEAR_M and (best is None or away < best[0]):
            best = away, point, matrix(surface.bbox.center)[:3, 3]
    if best is None:
        return min(found, 1), 0
    _, centre, surface = best
    computed = float(numpy.linalg.norm(camera_T_object[:3, 3]))
    measures.append(
        scores.Measure(shape, estimates.boxes, "centre", range_m, float(numpy.linalg.norm(centre)), computed))
    distance = float(numpy.linalg.norm(surface))
    hit = scores.ray_hits(shape, camera_T_object, surface / distance)
    if hit is not None:
        measures.append(scores.Measure(shape, estimates.boxes, "surface", range_m, distance, float(hit)))
    return min(found, 1), 1


def measure(holder, sources, shape, range_m, measures, seen):
    """Takes the images of one distance."""
    robot, images = holder.robot, holder.options.images
    begin = robot.now()
    robot.wait(lambda: robot.now() > begin + IMAGES_S or all(len(s.complete(begin)) >= images for s in sources),
               "images", 300.0)
    camera_T_object = holder.camera_T_object()  # the arm stands still
    for source in sources:
        complete = source.complete(begin)[:images]
        counts = [judge(source, parts, shape, range_m, camera_T_object, measures) for _, parts in complete]
        seen.append(
            scores.Seen(shape, source.boxes, range_m, len(counts), sum(c[0] for c in counts),
                        sum(c[1] for c in counts)))


def run(options, session):
    holder = Holder(options, session)
    sources = [Estimates(boxes) for boxes in options.boxes]
    measures, seen, slips = [], [], []
    for shape in options.shapes:
        holder.move_to(TAKE_M)
        holder.take(shape)
        holder.robot.save_image("camera/color/image_raw", options.out / f"held_{shape}.png", 60.0)
        for range_m in sorted(options.near + options.ranges, reverse=True):
            holder.move_to(range_m)
            measure(holder, sources, shape, range_m, measures, seen)
            slips.append(holder.slipped(shape))
            counts = ", ".join(f"{one.estimates} of {one.images} by {scores.BOXES[one.boxes]}"
                               for one in seen[-len(sources):])
            print(f"{shape:<7}{range_m:6.3f} m  gripper tilted by {holder._last[0]:2d} degrees  estimates: {counts}",
                  flush=True)
    return measures, seen, max(slips)


def report(options, measures, seen, slip_m, seconds):
    print("\n".join(scores.table(measures, seen, MIN_RANGE_M)))
    print(
        f"seed {options.seed}, {options.estimator}, {options.model.name}; objects slipped in the gripper by {1000 * slip_m:.1f} mm at "
        f"the most; {seconds:.0f} s")
    name = options.out / "depth_kinematics"
    scores.write_csv(measures, name.with_suffix(".csv"))
    summary = {"seed": options.seed, "estimator": options.estimator, "model": options.model.name,
               "max_slip_in_gripper_m": slip_m, **scores.as_dict(measures, seen, MIN_RANGE_M)}
    name.with_suffix(".json").write_text(json.dumps(summary, indent=1))
    try:
        scores.plot(measures, MIN_RANGE_M, name.with_suffix(".png"))
    except ImportError:
        print("no plot: install python3-matplotlib", file=sys.stderr)
    print(f"{name}.csv, .json and .png")
    return 0 if measures else 1


def main(argv):
    options = parse_arguments(argv)
    options.out.mkdir(parents=True, exist_ok=True)
    begin = time.monotonic()

    def body(session):
        session.launch(None,
                       REPO / "tools" / "lib" / "depth_trial.launch",
                       config=write_config(options.out),
                       seed=options.seed,
                       real_time_factor=options.speed,
                       model=options.model.resolve(),
                       estimator=options.estimator)
        session.join("trial_depth")
        return report(options, *run(options, session), time.monotonic() - begin)

    return run_trial(options.out, body)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
