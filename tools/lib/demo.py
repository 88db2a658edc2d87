"""Runs what tools/demo shows: see demo_options.py."""

import os
import pathlib
import re
import subprocess
import sys
import time

from demo_drive import Swing
from demo_frames import OPTICAL_FRAME, TruthWatcher, Watcher
from demo_options import REPO, SECONDS_WITHOUT_DISPLAY, parse_arguments
from demo_tables import Table, TruthTable
from ros_session import RosSession, Stalled


def display_works():
    """True when an X server answers at $DISPLAY."""
    if not os.environ.get("DISPLAY"):
        return False
    return subprocess.run(["xset", "q"], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL).returncode == 0


def rviz_config(folder, fixed_frame):
    """The prepared configuration; for a camera that moves about the origin of a map, with a view of that origin."""
    prepared = REPO / "config" / "rviz" / "detection.rviz"
    if fixed_frame != "map":
        return prepared
    text = re.sub(r"Focal Point: \{.*\}", "Focal Point: {X: 0, Y: 0, Z: 0.2}", prepared.read_text())
    text = text.replace("Fixed Frame: base_link", f"Fixed Frame: {fixed_frame}")
    text = re.sub(r"Yaw: .*", "Yaw: 4.4", text)
    changed = folder / "demo.rviz"
    changed.write_text(text)
    return changed


def simulation_view(folder):
    """The simulation's rviz configuration with the detector's image in the place of the camera's."""
    text = (REPO / "config" / "rviz" / "simulation.rviz").read_text()
    changed = folder / "demo.rviz"
    changed.write_text(text.replace("Image Topic: /camera/color/image_raw", "Image Topic: /detections/image"))
    return changed


def count_frames(source):
    """Frames of a folder, to know when it was played once; 0 = not known."""
    associations = source / "associations.txt"
    if associations.exists():
        return sum(1 for line in associations.read_text().splitlines() if line.strip() and not line.startswith("#"))
    for name in ("rgb", "color"):
        if (source / name).is_dir():
            return sum(1 for file in (source / name).iterdir() if file.suffix.lower() in (".png", ".jpg", ".jpeg"))
    return 0


def watch(options, session, watcher, frames_once):
    """Waits until the time is up, the recording was played once, or Ctrl-C. Returns False when something broke."""
    first_frame_deadline = time.monotonic() + 60.0
    started = None
    while session.alive():
        if watcher.rospy.is_shutdown():
            return True
        now = time.monotonic()
        if started is None and watcher.complete > 0:
            started = now
        if started is None and now > first_frame_deadline:
            print("error: no frame came through within 60 s; see " + str(session.log_file), file=sys.stderr)
            return False
        if started is not None:
            if options.seconds is not None and now - started > options.seconds:
                return True
            if options.seconds is None and frames_once and watcher.complete >= frames_once:
                return True
        time.sleep(0.05)
    for line in session.errors() or ["something ended unexpectedly; see " + str(session.log_file)]:
        print("error: " + line, file=sys.stderr)
    return False


def launch_recording(options, session, with_rviz):
    """Starts detector and depth on a recording. Returns the frames after which it was played once; 0: not known."""
    source = options.source.resolve()
    is_rawlog = source.is_file()
    has_poses = (source / "groundtruth.txt").exists()
    fixed_frame = "map" if has_poses else "base_link"
    options.frame = options.frame or fixed_frame
    session.launch(
        "extperfc", "demo.launch", source=source, model=options.model.resolve(), rate_hz=options.rate,
        source_type="rawlog_source" if is_rawlog else "image_pair_source", backend=options.backend,
        device=options.device, fixed_camera=str(not has_poses).lower(),
        rviz_config=rviz_config(options.out, fixed_frame), depth_scale=options.depth_scale, rviz=str(with_rviz).lower(),
        camera_info=options.camera_info.resolve() if options.camera_info else "",
        target_frame="" if options.frame == OPTICAL_FRAME else options.frame)
    return 0 if with_rviz or is_rawlog else count_frames(source)


def launch_simulation(options, session, with_rviz):
    """Starts the simulated robot with detector and depth on its camera."""
    options.frame = "map"  # of the truth
    if options.seconds is None and not with_rviz:
        options.seconds = SECONDS_WITHOUT_DISPLAY
    is_file = "/" in options.world or options.world.endswith(".yaml")
    session.launch(
        "extperfc", "sim_demo.launch", seed=options.seed,
        world=pathlib.Path(options.world).resolve() if is_file else options.world,
        model=options.model.resolve(), backend=options.backend, device=options.device, rviz=str(with_rviz).lower(),
        rviz_config=simulation_view(options.out))
    return 0


def prepare(options):
    """Makes the folder of results. Returns whether rviz shall run."""
    with_rviz = not options.no_rviz and display_works()
    if not with_rviz and not options.no_rviz:
        print("No display here: going on without rviz; table and images follow.")
    options.out.mkdir(parents=True, exist_ok=True)
    for old in options.out.glob("[0-9]*.png"):
        old.unlink()
    return with_rviz


def run(options):
    import rospy
    with_rviz = prepare(options)
    launch = launch_recording if options.source else launch_simulation
    with RosSession(options.out / "launch.log") as session:
        frames_once = launch(options, session, with_rviz)
        table = (Table if options.source else TruthTable)(options.out, options.frame)
        try:
            session.join("demo_table", simulated=not options.source)
        except Stalled as error:
            raise SystemExit(f"error: {error}; see {session.log_file}") from None
        watcher = (Watcher if options.source else TruthWatcher)(options, table)
        swing = None if options.source or options.still else Swing()
        try:
            good = watch(options, session, watcher, frames_once)
        except KeyboardInterrupt:
            good = True
        if swing:
            swing.stop()
        rospy.signal_shutdown("done")
    table.close()
    if table.frames:
        print("\n" + "\n".join(table.summary()))
        print(f"Annotated images and table.csv: {options.out}")
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(run(parse_arguments(sys.argv[1:])))
