"""Detects objects in a recording, puts them into space, and shows the result as a table and as pictures.

Without arguments it plays pictures that the repository generates with the default model. With a display it opens rviz.
"""

import argparse
import csv
import os
import pathlib
import re
import statistics
import subprocess
import sys
import threading
import time

import cv2
import numpy

from ros_session import RosSession

REPO = pathlib.Path(__file__).resolve().parents[2]
WS = pathlib.Path(os.environ.get("EXTPERFC_WS", REPO / ".ws"))
OPTICAL_FRAME = "camera_color_optical_frame"
COLUMNS = ("frame", "class", "score", "box x0 y0 x1 y1 [px]", "depth [m]", "x y z [m]", "+- [cm]")
WIDTHS = (6, 14, 6, 22, 10, 22, 8)


def parse_arguments(argv):
    parser = argparse.ArgumentParser(prog="tools/demo", description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--source", type=pathlib.Path, metavar="PATH",
                        help="folder of aligned colour and depth pictures (TUM associations.txt, or equal names in\n"
                             "rgb/ and depth/), or an MRPT .rawlog file; default: generated pictures")
    parser.add_argument("--model", type=pathlib.Path, default=REPO / "models" / "shapes", metavar="FOLDER",
                        help="model folder, see models/README.md; default: models/shapes")
    parser.add_argument("--seconds", type=float, metavar="N",
                        help="stop after N seconds of playing; default: until Ctrl-C with a display, once through without")
    parser.add_argument("--rate", type=float, default=10.0, metavar="HZ", help="frames per second; default: 10")
    parser.add_argument("--out", type=pathlib.Path, default=WS / "demo", metavar="FOLDER",
                        help="where annotated pictures and table.csv go; default: .ws/demo")
    parser.add_argument("--backend", choices=("auto", "openvino", "opencv"), default="auto",
                        help="default: the fastest that loads the model")
    parser.add_argument("--device", default="CPU", help="CPU, GPU, NPU or AUTO; default: CPU")
    parser.add_argument("--camera-info", type=pathlib.Path, metavar="FILE",
                        help="calibration file (camera_calibration YAML); default: what the recording brings")
    parser.add_argument("--depth-scale", type=float, default=1000.0, metavar="UNITS",
                        help="units per metre of depth files; default: 1000, TUM's own recordings: 5000")
    parser.add_argument("--frame", metavar="FRAME",
                        help="tf frame of x y z; default: map where the recording knows its camera's poses\n"
                             "(groundtruth.txt), else base_link, the floor 1 m below the camera.\n"
                             "camera_color_optical_frame: as the camera sees it")
    parser.add_argument("--no-rviz", action="store_true", help="no window, even with a display")
    options = parser.parse_args(argv)
    if options.seconds is not None and not options.seconds > 0:
        parser.error(f"--seconds must be positive, not {options.seconds}")
    if not options.rate > 0:
        parser.error(f"--rate must be positive, not {options.rate}")
    for path in (options.source, options.model, options.camera_info):
        if path is not None and not path.exists():
            parser.error(f"{path} does not exist")
    return options


def generated_pictures():
    """Folder of pictures made by tools/generate_pictures; made on first use."""
    folder = WS / "demo_pictures"
    if not (folder / "associations.txt").exists():
        print("Generating pictures (once)", flush=True)
        subprocess.run(["/usr/bin/python3", REPO / "tools" / "generate_pictures", "--out", folder, "--frames", "60",
                        "--seed", "7"], check=True, stdout=subprocess.DEVNULL)
    return folder


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


def count_frames(source):
    """Frames of a folder, to know when it was played once; 0 = not known."""
    associations = source / "associations.txt"
    if associations.exists():
        return sum(1 for line in associations.read_text().splitlines() if line.strip() and not line.startswith("#"))
    for name in ("rgb", "color"):
        if (source / name).is_dir():
            return sum(1 for file in (source / name).iterdir() if file.suffix.lower() in (".png", ".jpg", ".jpeg"))
    return 0


class Table:
    """Prints one line per object, keeps totals, writes table.csv."""

    def __init__(self, folder, frame_id):
        self.frame_id = frame_id
        self.frames = 0
        self.objects = 0
        self.latencies_ms = []
        self.file = open(folder / "table.csv", "w", newline="")
        self.csv = csv.writer(self.file)
        self.csv.writerow(("frame", "stamp", "class", "score", "x0", "y0", "x1", "y1", "depth_m", "x_m", "y_m", "z_m",
                           "sigma_m"))

    def header(self):
        print(f"\nPositions in frame {self.frame_id}; depth along the camera's axis\n")
        print("  ".join(name.ljust(width) for name, width in zip(COLUMNS, WIDTHS)))
        print("  ".join("-" * width for width in WIDTHS), flush=True)

    def frame(self, stamp, rows, latency_ms):
        self.latencies_ms.append(latency_ms)
        for row in rows or [None]:
            self._line(row)
            if row:
                self.csv.writerow((self.frames, f"{stamp.to_sec():.6f}", row["class"], f"{row['score']:.3f}",
                                   *(f"{v:.1f}" for v in row["box"]), *(f"{v:.4f}" for v in row.get("xyz_csv", ()))))
        self.frames += 1
        self.objects += len(rows)
        sys.stdout.flush()

    def _line(self, row):
        if row is None:
            cells = (str(self.frames), "(nothing)", "", "", "", "", "")
        else:
            located = "position" in row
            cells = (str(self.frames), row["class"], f"{row['score']:.2f}",
                     " ".join(f"{v:5.0f}" for v in row["box"]),
                     f"{row['depth']:.3f}" if located else "none",
                     " ".join(f"{v:6.2f}" for v in row["position"]) if located else "",
                     f"{100 * row['sigma']:.1f}" if located else "")
        print("  ".join(cell.ljust(width) for cell, width in zip(cells, WIDTHS)))

    def close(self):
        self.file.close()


class Watcher:
    """Joins detections, 3D detections and annotated pictures of one stamp and hands complete frames on."""

    KEPT = 20  # stamps waited for at the same time

    def __init__(self, options, table):
        import rospy
        import sensor_msgs.msg
        import tf2_ros
        import vision_msgs.msg

        self.rospy = rospy
        self.options = options
        self.table = table
        self.names = []
        self.parts = {}
        self.lock = threading.Lock()
        self.complete = 0
        self.tf = tf2_ros.Buffer()
        self.listener = tf2_ros.TransformListener(self.tf)
        rospy.Subscriber("detections", vision_msgs.msg.Detection2DArray, self._add, "boxes", queue_size=20)
        rospy.Subscriber("detections/image", sensor_msgs.msg.Image, self._add, "image", queue_size=20, buff_size=2**24)
        rospy.Subscriber("vision_info", vision_msgs.msg.VisionInfo, self._info)
        # Last, because the recording starts when this chain is wanted.
        rospy.Subscriber("detections_3d", vision_msgs.msg.Detection3DArray, self._add, "objects", queue_size=20)

    def _info(self, message):
        self.names = self.rospy.get_param(message.database_location, [])

    def _add(self, message, part):
        with self.lock:
            entry = self.parts.setdefault(message.header.stamp, {})
            entry[part] = message
            if part == "objects":
                entry["latency_ms"] = 1e3 * (self.rospy.Time.now() - message.header.stamp).to_sec()
            if {"boxes", "image", "objects"} <= entry.keys():
                self._finish(message.header.stamp, self.parts.pop(message.header.stamp))
            while len(self.parts) > self.KEPT:
                del self.parts[min(self.parts)]

    def _finish(self, stamp, entry):
        rows = self._rows(entry["boxes"], entry["objects"])
        if self.complete == 0:
            self.table.header()
        self._write_picture(entry["image"], rows)
        self.table.frame(stamp, rows, entry["latency_ms"])
        self.complete += 1

    def _rows(self, boxes, objects):
        """One row per box; boxes without depth are missing in `objects`, the order is the same."""
        rows, rest = [], list(objects.detections)
        for detection in boxes.detections:
            best, box = detection.results[0], detection.bbox
            x, y, w, h = box.center.x, box.center.y, box.size_x, box.size_y
            row = {"class": self.names[best.id] if best.id < len(self.names) else str(best.id), "score": best.score,
                   "box": (x - w / 2, y - h / 2, x + w / 2, y + h / 2)}
            if rest and (rest[0].results[0].id, rest[0].results[0].score) == (best.id, best.score):
                self._locate(row, rest.pop(0))
            rows.append(row)
        return rows

    def _locate(self, row, item):
        hypothesis = item.results[0].pose
        p = hypothesis.pose.position
        row["position"] = (p.x, p.y, p.z)
        covariance = numpy.array(hypothesis.covariance).reshape(6, 6)[:3, :3]
        row["sigma"] = float(numpy.sqrt(max(numpy.linalg.eigvalsh(covariance)[-1], 0.0)))
        row["depth"] = self._depth(item)
        row["xyz_csv"] = (row["depth"], *row["position"], row["sigma"])

    def _depth(self, item):
        """Distance along the optical axis [m]; the boxes' axes are those of the optical frame, so its third is that axis."""
        q = item.results[0].pose.pose.orientation
        axis = numpy.array([2 * (q.x * q.z + q.y * q.w), 2 * (q.y * q.z - q.x * q.w), 1 - 2 * (q.x * q.x + q.y * q.y)])
        surface = item.results[0].pose.pose.position
        camera = self._camera_position(item.header)
        return float(axis @ (numpy.array([surface.x, surface.y, surface.z]) - camera))

    def _camera_position(self, header):
        """Where the camera was when it took the picture, in the table's frame [m]."""
        if header.frame_id == OPTICAL_FRAME:
            return numpy.zeros(3)
        found = self.tf.lookup_transform(header.frame_id, OPTICAL_FRAME, header.stamp, self.rospy.Duration(0.5))
        t = found.transform.translation
        return numpy.array([t.x, t.y, t.z])

    def _write_picture(self, message, rows):
        limit = 300  # pictures; a demo that runs for hours must not fill the disk
        if self.complete >= limit:
            return
        picture = numpy.frombuffer(message.data, numpy.uint8).reshape(message.height, message.step)
        picture = picture[:, :message.width * 3].reshape(message.height, message.width, 3).copy()
        for row in rows:
            if "depth" in row:
                x0, y0, x1, y1 = row["box"]
                text, font, scale = f"{row['depth']:.2f} m", cv2.FONT_HERSHEY_SIMPLEX, 0.5
                (width, _), _ = cv2.getTextSize(text, font, scale, 1)
                origin = (int((x0 + x1 - width) / 2), int((y0 + y1) / 2))
                cv2.putText(picture, text, origin, font, scale, (0, 0, 0), 3, cv2.LINE_AA)
                cv2.putText(picture, text, origin, font, scale, (255, 255, 255), 1, cv2.LINE_AA)
        cv2.imwrite(str(self.options.out / f"{self.complete:06d}.png"), picture)


def wait_for_master(session, deadline_s=20.0):
    import rosgraph
    end = time.monotonic() + deadline_s
    while time.monotonic() < end and session.alive():
        if rosgraph.is_master_online():
            return
        time.sleep(0.05)
    raise SystemExit("error: the ROS master did not start; see " + str(session.log_file))


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


def run(options):
    source = options.source.resolve() if options.source else generated_pictures()
    with_rviz = not options.no_rviz and display_works()
    if not with_rviz and not options.no_rviz:
        print("No display here: going on without rviz; table and pictures follow.")
    options.out.mkdir(parents=True, exist_ok=True)
    for old in options.out.glob("[0-9]*.png"):
        old.unlink()
    is_rawlog = source.is_file()
    has_poses = (source / "groundtruth.txt").exists()
    fixed_frame = "map" if has_poses else "base_link"
    options.frame = options.frame or fixed_frame
    table = Table(options.out, options.frame)
    with RosSession(options.out / "launch.log") as session:
        session.launch(
            "extperfc", "demo.launch", source=source, model=options.model.resolve(), rate_hz=options.rate,
            source_type="rawlog_source" if is_rawlog else "image_pair_source", backend=options.backend,
            device=options.device, fixed_camera=str(not has_poses).lower(),
            rviz_config=rviz_config(options.out, fixed_frame), depth_scale=options.depth_scale, rviz=str(with_rviz).lower(),
            camera_info=options.camera_info.resolve() if options.camera_info else "",
            target_frame="" if options.frame == OPTICAL_FRAME else options.frame)
        wait_for_master(session)
        import rospy
        rospy.init_node("demo_table", disable_signals=True)
        watcher = Watcher(options, table)
        once = 0 if with_rviz or is_rawlog else count_frames(source)
        try:
            good = watch(options, session, watcher, once)
        except KeyboardInterrupt:
            good = True
        rospy.signal_shutdown("done")
    table.close()
    if table.frames:
        print(f"\n{table.frames} frames, {table.objects} objects; from picture to 3D detections "
              f"{statistics.median(table.latencies_ms):.1f} ms (median)")
        print(f"Annotated pictures and table.csv: {options.out}")
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(run(parse_arguments(sys.argv[1:])))
