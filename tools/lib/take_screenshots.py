#!/usr/bin/python3
"""Takes the images of README.md and docs/ again, in the simulator and under Xvfb: tools/lib/take_screenshots.py [NAME...]

Time stands still while rviz draws, so a slow computer makes the same images as a fast one. Needs the packages xvfb and
imagemagick, and a built workspace.
"""

import argparse
import contextlib
import math
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import time
import types

import cv2
import geometry_msgs.msg
import numpy
import rospy
import tf2_ros
from extperfc.srv import MoveBody, StepSimulation
from std_srvs.srv import SetBool

from demo_drive import PERIOD_S, Swing
from demo_frames import TruthWatcher
from grasp_scene import PlacePose, body_position
from ros_session import RosSession

REPO = pathlib.Path(__file__).resolve().parents[2]
IMAGES = REPO / "docs" / "images"
STEP_HZ = 240  # of the physics, config/simulator.yaml
WIDTH, HEIGHT = 1200, 800  # of rviz
LIGHT_YAW = -0.8  # of the frame `light` in map [rad]


@contextlib.contextmanager
def display():
    """An X server of our own, at $DISPLAY."""
    with subprocess.Popen(["Xvfb", "-displayfd", "1", "-screen", "0", f"{WIDTH}x{HEIGHT}x24"], stdout=subprocess.PIPE,
                          stderr=subprocess.DEVNULL) as server:
        os.environ.update(DISPLAY=":" + server.stdout.readline().decode().strip(), LIBGL_ALWAYS_SOFTWARE="1",
                          QT_X11_NO_MITSHM="1")
        try:
            yield
        finally:
            server.terminate()


@contextlib.contextmanager
def rviz(folder, config, edits=(), panels=False):
    """rviz over the whole screen, without panels and bars unless `panels`; `edits` are (pattern, replacement) of its
    configuration."""
    text = (REPO / "config" / "rviz" / config).read_text()
    if not panels:
        text = re.sub(r"(    - Class: rviz/Image\n(?:      .*\n)*?      Enabled:) true", r"\1 false", text)
    for pattern, replacement in ((r"\n  Height: .*", f"\n  Height: {HEIGHT}"), (r"\n  Width: .*", f"\n  Width: {WIDTH}"), *edits):
        text, count = re.subn(pattern, replacement, text)
        if count == 0:
            raise SystemExit(f"error: {config} has nothing like '{pattern}'")
    changed = folder / config
    changed.write_text(text)
    command = ["rviz", *([] if panels else ["--fullscreen"]), "-d", str(changed)]
    with subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL) as process:
        try:
            yield
        finally:
            process.terminate()


def screen():
    """What rviz shows now, BGR."""
    shown = subprocess.run(["import", "-silent", "-window", "root", "png:-"], check=True, capture_output=True).stdout
    return cv2.imdecode(numpy.frombuffer(shown, numpy.uint8), cv2.IMREAD_COLOR)


def write_label(image, text):
    """A white text on a dark bar along the upper edge."""
    image[:28] //= 3
    cv2.putText(image, text, (10, 20), cv2.FONT_HERSHEY_SIMPLEX, 0.55, (255, 255, 255), 1, cv2.LINE_AA)
    return image


class Simulation:
    """A launch file with the simulator, whose time passes in steps only."""

    def __init__(self, session, launch_file, **arguments):
        session.launch("extperfc", launch_file, rviz="false", **arguments)
        while session.alive() and subprocess.run(["rosparam", "get", "/use_sim_time"], capture_output=True).returncode:
            time.sleep(0.2)
        rospy.init_node("take_screenshots", disable_signals=True)
        self.broadcaster = self._publish_light()
        rospy.wait_for_service("sim/step", 60)
        rospy.ServiceProxy("sim/pause", SetBool)(True)
        self.move_service = rospy.ServiceProxy("sim/move_body", MoveBody)
        self.step_service = rospy.ServiceProxy("sim/step", StepSimulation)

    @staticmethod
    def _publish_light():
        """map -> light."""
        transform = geometry_msgs.msg.TransformStamped(child_frame_id="light")
        transform.header.frame_id = "map"
        transform.transform.rotation.z, transform.transform.rotation.w = math.sin(LIGHT_YAW / 2), math.cos(LIGHT_YAW / 2)
        broadcaster = tf2_ros.StaticTransformBroadcaster()
        broadcaster.sendTransform(transform)
        return broadcaster

    def move_body(self, name, position):
        pose = geometry_msgs.msg.Pose(geometry_msgs.msg.Point(*position), geometry_msgs.msg.Quaternion(0, 0, 0, 1))
        self.move_service(name=name, pose=pose)

    def step(self, seconds):
        self.step_service(steps=round(seconds * STEP_HZ))


class Latest(TruthWatcher):
    """Keeps the latest annotated image."""

    image = None

    def _report(self, stamp, rows, entry):
        self.image = cv2.imread(str(self.options.out / f"{self.complete:06d}.png"))


def settle(watcher, quiet_s=0.8, deadline_s=10.0):
    """Waits until no more frames come."""
    end, seen, since = time.monotonic() + deadline_s, watcher.complete, time.monotonic()
    while time.monotonic() < end and time.monotonic() - since < quiet_s:
        if watcher.complete != seen:
            seen, since = watcher.complete, time.monotonic()
        time.sleep(0.02)


def animate(folder, files, target):
    subprocess.run(["convert", "-delay", "10", "-loop", "0", *map(str, files), "-quality", "62", "-define",
                    "webp:method=4", str(target)], check=True, cwd=folder)


def view(distance, focal_point, yaw, pitch):
    """Edits of an rviz configuration: where its camera stands, in the frame map. rviz has one light, which shines along -x of
    its fixed frame; in the frame `light` it falls on the two sides of walls that a camera at this yaw sees."""
    cos, sin = math.cos(LIGHT_YAW), math.sin(LIGHT_YAW)
    x, y, z = focal_point
    placed = (cos * x + sin * y, -sin * x + cos * y, z)
    return ((r"(Current:(?:\n      .*)*?\n      Distance:).*", rf"\1 {distance}"),
            (r"(Current:(?:\n      .*)*?\n      Focal Point:).*", r"\1 {X: %.3f, Y: %.3f, Z: %.3f}" % placed),
            (r"(Current:(?:\n      .*)*?\n      Pitch:).*", rf"\1 {pitch}"),
            (r"(Current:(?:\n      .*)*?\n      Yaw:).*", rf"\1 {(yaw - LIGHT_YAW) % (2 * math.pi)}"),
            (r"(Current:(?:\n      .*)*?\n      Target Frame:).*", r"\1 <Fixed Frame>"), (r"Fixed Frame: .*", "Fixed Frame: light"))


WITHOUT_FRAMES = (r"(Name: Frames\n      Enabled:) true", r"\1 false")


def start(folder, session, launch_file, config, edits, panels=False, **arguments):
    """The simulation with rviz after some steps, and a watcher of the camera."""
    simulation = Simulation(session, launch_file, **arguments)
    watcher = Latest(types.SimpleNamespace(out=folder), types.SimpleNamespace(header=lambda: None))
    stack = contextlib.ExitStack()
    stack.enter_context(rviz(folder, config, edits, panels))
    for _ in range(12):
        simulation.step(0.2)
        time.sleep(2)  # rviz starts, loads meshes and draws
    return simulation, watcher, stack


def side_by_side(camera, scene, height, titles):
    """Both images at one height, with their titles."""
    images = [cv2.resize(image, (round(image.shape[1] * height / image.shape[0]), height), interpolation=cv2.INTER_AREA)
              for image in (camera, scene)]
    return numpy.hstack([write_label(image, title) for image, title in zip(images, titles)])


def demo(folder, session):
    """demo.webp: one swing of tools/demo: the camera's image with what was detected, and the robot in its laboratory."""
    edits = (*view(3.3, (0.45, 0.1, 0.75), -0.7, 0.58), WITHOUT_FRAMES)
    simulation, watcher, windows = start(folder, session, "sim_demo.launch", "simulation.rviz", edits)
    swing, files, step_s = Swing(), [], 0.2
    with windows:
        for index in range(-5, round(PERIOD_S / step_s)):
            simulation.step(step_s)
            settle(watcher)
            if index >= 0:
                files.append(folder / f"frame{index:03d}.png")
                cv2.imwrite(str(files[-1]), side_by_side(watcher.image, screen(), 427, (
                    "camera image, detected objects and their distances", "rviz: robot, lidar and estimated positions")))
    swing.stop()
    animate(folder, files, IMAGES / "demo.webp")


def grasp(folder, session):
    """arm_grasp.png: detected objects and the rest of the camera's view as obstacles of the arms."""
    simulation, watcher, windows = start(folder, session, "sim_grasp.launch", "grasp.rviz",
                                         view(1.7, (0.35, 0, 1.0), -0.6, 0.55), objects="true", depth="true")
    with windows:
        for shape, x, y in (("cube", 0.46, -0.08), ("sphere", 0.46, 0.08), ("cone", 0.53, 0.0)):
            simulation.move_body(shape, body_position(shape, PlacePose(x, y, 1.2, 0)))
        for _ in range(6):
            simulation.step(0.5)
            time.sleep(2)
        settle(watcher)
        save(side_by_side(watcher.image, screen(), 540, (
            "camera image with detections", "rviz: objects and voxels (yellow-green) that the arms avoid")), "arm_grasp.png")


def lab(folder, session):
    """simulation_rviz.png: the laboratory."""
    _, _, windows = start(folder, session, "sim_demo.launch", "simulation.rviz",
                          (*view(3.5, (0.5, 0.05, 0.75), -0.6, 0.5), WITHOUT_FRAMES))
    with windows:
        save(screen(), "simulation_rviz.png")


def office(folder, session):
    """simulation_office.png: the office floor from above."""
    _, _, windows = start(folder, session, "sim.launch", "simulation.rviz",
                          (*view(26, (-3, -0.5, 0), -0.8, 0.85), WITHOUT_FRAMES), world="office")
    with windows:
        save(screen(), "simulation_office.png")


def send_to(session, simulation, x, y, yaw):
    """Waits until the robot can navigate, and sends it to a pose in the map. Gives the robot."""
    from nav_robot import NavRobot, Pose
    robot = NavRobot(session.alive)
    for _ in range(20):
        simulation.step(0.1)
        time.sleep(0.3)
    robot.ready()
    robot.send(Pose(x, y, yaw))
    return robot


def navigation(folder, session):
    """navigation_rviz.png: on a path through the office: cost maps, footprint, paths, candidates, people."""
    edits = ((r"(Current:(?:\n      .*)*?\n      Scale:).*", r"\1 78"), (r"(Current:(?:\n      .*)*?\n      X:).*", r"\1 -1.5"),
             (r"(Current:(?:\n      .*)*?\n      Y:).*", r"\1 3.0"))
    simulation, _, windows = start(folder, session, "sim_navigation.launch", "navigation.rviz", edits)
    with windows:
        send_to(session, simulation, -3.6, 6.4, 1.57)
        for _ in range(125):
            simulation.step(0.05)
            time.sleep(0.15)  # localizer and navigator keep pace
        time.sleep(3)
        save(screen(), "navigation_rviz.png")


def bringup(folder, session):
    """bringup_rviz.png: the whole robot on a path through the laboratory while it maps and detects; rviz with its panels."""
    simulation, _, windows = start(folder, session, "bringup.launch", "bringup.rviz", (), panels=True)
    with windows:
        robot = send_to(session, simulation, -0.4, -1.5, 0.0)
        for _ in range(32):
            simulation.step(0.05)
            time.sleep(0.2)  # all parts keep pace
        if robot.status.state != "controlling":
            raise SystemExit(f"error: the robot does not drive: {robot.status}")
        time.sleep(4)
        save(screen(), "bringup_rviz.png")


def label(folder, _):
    """labelling_window.png, labelling_proposals.png, labelling_keys.png, labelling_statistics.png: extperfc-label with rendered
    images, some of which are labelled."""
    subprocess.run([REPO / "tools" / "extperfc-render", folder / "voc", "--count", "24", "--seed", "11"], check=True,
                   stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    for number in (8, 13, 16, 20, 21, 23, 24):
        (folder / "voc" / "Annotations" / f"{number:06d}.xml").unlink()
    subprocess.run([sys.executable, REPO / "tools" / "lib" / "label_screenshots.py", folder / "voc", folder], check=True)
    for name in ("window", "proposals", "keys", "statistics"):
        save(cv2.imread(str(folder / f"labelling_{name}.png")), f"labelling_{name}.png")


def save(image, name):
    """As a PNG of 256 colours, which is a third of the size."""
    file = IMAGES / name
    cv2.imwrite(str(file), image)
    subprocess.run(["convert", str(file), "-colors", "256", f"PNG8:{file}"], check=True)


IMAGES_BY_NAME = {"demo": demo, "grasp": grasp, "lab": lab, "office": office,
                  "navigation": navigation, "bringup": bringup, "label": label}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("names", nargs="*", metavar="NAME", help="of " + ", ".join(IMAGES_BY_NAME) + "; default: all")
    names = parser.parse_args().names or list(IMAGES_BY_NAME)
    if unknown := set(names) - set(IMAGES_BY_NAME):
        parser.error(f"there is no image {', '.join(sorted(unknown))}: use {', '.join(IMAGES_BY_NAME)}")
    if len(names) > 1:  # a process has one ROS node
        return max(subprocess.run([sys.executable, __file__, name]).returncode for name in names)
    with tempfile.TemporaryDirectory() as folder, display(), RosSession(pathlib.Path(folder) / "launch.log") as session:
        IMAGES_BY_NAME[names[0]](pathlib.Path(folder), session)
    return 0


if __name__ == "__main__":
    sys.exit(main())
