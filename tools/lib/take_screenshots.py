#!/usr/bin/python3
"""Takes the images of README.md and docs/ again, in the simulator and under Xvfb: tools/lib/take_screenshots.py [NAME...]

Time stands still while rviz draws, so a slow computer makes the same images as a fast one. Needs the packages xvfb and
imagemagick, and a built workspace.
"""

import argparse
import contextlib
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import time
import types

import cv2
import numpy

from demo_drive import PERIOD_S, Swing
from demo_frames import TruthWatcher
from ros_session import RosSession

REPO = pathlib.Path(__file__).resolve().parents[2]
IMAGES = REPO / "docs" / "images"
STEP_HZ = 240  # of the physics, config/simulator.yaml
WIDTH, HEIGHT = 1200, 800  # of rviz


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
def rviz(folder, config, edits=()):
    """rviz without panels and bars, over the whole screen; `edits` are (pattern, replacement) of its configuration."""
    text = (REPO / "config" / "rviz" / config).read_text()
    for pattern, replacement in ((r"\n  Height: .*", f"\n  Height: {HEIGHT}"), (r"\n  Width: .*", f"\n  Width: {WIDTH}"),
                                 (r"(    - Class: rviz/Image\n(?:      .*\n)*?      Enabled:) true", r"\1 false"), *edits):
        text, count = re.subn(pattern, replacement, text)
        if count == 0:
            raise SystemExit(f"error: {config} has nothing like '{pattern}'")
    changed = folder / config
    changed.write_text(text)
    with subprocess.Popen(["rviz", "--fullscreen", "-d", str(changed)], stdout=subprocess.DEVNULL,
                          stderr=subprocess.DEVNULL) as process:
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
        import rospy
        session.launch("extperfc", launch_file, rviz="false", **arguments)
        while session.alive() and subprocess.run(["rosparam", "get", "/use_sim_time"], capture_output=True).returncode:
            time.sleep(0.2)
        rospy.init_node("take_screenshots", disable_signals=True)
        rospy.wait_for_service("sim/step", 60)
        from extperfc.srv import StepSimulation
        from std_srvs.srv import SetBool
        rospy.ServiceProxy("sim/pause", SetBool)(True)
        self.step_service = rospy.ServiceProxy("sim/step", StepSimulation)

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
                    "webp:method=6", str(target)], check=True, cwd=folder)


def demo(folder, session):
    """demo.webp: one swing of tools/demo: the camera's image with what was detected, and the robot in its laboratory."""
    simulation = Simulation(session, "sim_demo.launch")
    quiet = types.SimpleNamespace(header=lambda: None)
    watcher = Latest(types.SimpleNamespace(out=folder), quiet)
    swing, files, step_s = Swing(), [], 0.2
    view = ((r"Distance: 3.5", "Distance: 3.3"), (r"Focal Point: \{X: 0.6", "Focal Point: {X: 0.45"),
            (r"(Name: Frames\n      Enabled:) true", r"\1 false"), (r"(?<!Saved:\n)Target Frame: base_footprint", "Target Frame: map"))
    with rviz(folder, "simulation.rviz", view):
        for index in range(-10, round(PERIOD_S / step_s)):
            simulation.step(step_s)
            settle(watcher)
            if index < 0 or watcher.image is None:
                time.sleep(2)  # rviz starts
                continue
            files.append(folder / f"frame{index:03d}.png")
            right = cv2.resize(screen(), (640, 427), interpolation=cv2.INTER_AREA)
            left = cv2.resize(watcher.image, (569, 427), interpolation=cv2.INTER_AREA)
            cv2.imwrite(str(files[-1]), numpy.hstack([write_label(left, "camera image, detected objects and their distances"),
                                                      write_label(right, "rviz: robot, lidar and estimated positions")]))
    swing.stop()
    animate(folder, files, IMAGES / "demo.webp")


IMAGES_BY_NAME = {"demo": demo}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("names", nargs="*", metavar="NAME", help="of " + ", ".join(IMAGES_BY_NAME) + "; default: all")
    names = parser.parse_args().names or list(IMAGES_BY_NAME)
    if unknown := set(names) - set(IMAGES_BY_NAME):
        parser.error(f"there is no image {', '.join(sorted(unknown))}: use {', '.join(IMAGES_BY_NAME)}")
    for name in names:
        with tempfile.TemporaryDirectory() as folder, display(), RosSession(pathlib.Path(folder) / "launch.log") as session:
            IMAGES_BY_NAME[name](pathlib.Path(folder), session)
    return 0


if __name__ == "__main__":
    sys.exit(main())
