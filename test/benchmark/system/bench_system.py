"""The whole simulated robot: rates, latencies from sensor to result, CPU time and memory of each part. See --help."""

import argparse
import json
import os
import pathlib
import statistics
import sys
import tempfile

REPO = pathlib.Path(__file__).resolve().parents[3]
sys.path[:0] = [str(REPO / "src"), str(REPO / "tools" / "lib")]

from bench_machine import machine  # noqa: E402
from part_meter import PartMeter  # noqa: E402
from ros_session import RosSession, Stalled  # noqa: E402
from streams import CHAINS, Streams  # noqa: E402

DESCRIPTION = """\
The whole simulated robot at once, in the office: simulator, detection with depth, mapping, navigation, arms, health. Meanwhile the
base drives to and fro.

For each case: rates of the results, latencies from the sensor's message to the result (wall time; what rendering takes is not in
them), from a goal to the first motion, CPU time of each part in per cent of one core, and its memory.

  --cameras N ...   so many cameras, each with a detector of its own, on the simulated camera's images
  --slower F ...    simulated seconds per second: with 2 every part has half of the time for the same work, as on a computer half
                    as fast. Latencies are in simulated seconds then, as that computer would have them.
"""
READY_S, SETTLE_S = 120.0, 10.0  # of real time
GOALS_M = (0.5, 0.0)             # along x of the map, in turn
GOAL_PERIOD_S = 6.0              # simulated
TOPICS = {"images": "camera/color/camera_info", "3D detections": "detections_3d", "lidar sweeps": "velodyne_points", "planar scans": "scan",
          "poses in the map": "pose", "maps": "map", "odometry": "odom"}


def parse(arguments):
    parser = argparse.ArgumentParser(prog="tools/bench system", description=DESCRIPTION, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seconds", type=float, default=40.0, metavar="S", help="simulated, for each case; default: 40")
    parser.add_argument("--cameras", type=int, nargs="+", default=[1, 2, 4], metavar="N", help="default: 1 2 4")
    parser.add_argument("--slower", type=float, nargs="*", default=[2.0, 4.0], metavar="F",
                        help="with one camera; default: 2 4")
    parser.add_argument("--world", default="office", help="of the simulator; default: office")
    parser.add_argument("--json", type=pathlib.Path, metavar="FILE", help="write the results too")
    options = parser.parse_args(arguments)
    if options.seconds < 5 or min(options.cameras, default=1) < 1 or min(options.slower, default=1) <= 0:
        parser.error("--seconds must be at least 5, --cameras at least 1, --slower above 0")
    return options


def launch_file(folder, options, cameras, speed):
    """bringup.launch with so many cameras; the second and later ones look at the images of the first."""
    more = ",".join(f"camera_{number}" for number in range(2, cameras + 1))
    others = f"""
      <include file="$(find extperfc)/launch/cameras.launch">
        <arg name="cameras" value="{more}"/> <arg name="manager" value="more_cameras_manager"/>
        <arg name="color_topic" value="/camera/color/image_raw"/> <arg name="camera_info_topic" value="/camera/color/camera_info"/>
        <arg name="depth_topic" value="/camera/aligned_depth_to_color/image_raw"/> <arg name="target_frame" value="base_link"/>
      </include>""" if more else ""
    file = folder / "system.launch"
    file.write_text(f"""<launch>
      <include file="$(find extperfc)/launch/bringup.launch">
        <arg name="rviz" value="false"/> <arg name="world" value="{options.world}"/> <arg name="real_time_factor" value="{speed:g}"/>
      </include>{others}
    </launch>""")
    return file


def measure(options, cameras, speed):
    """Rows of one case, in a simulation and a ROS master of its own."""
    with tempfile.TemporaryDirectory() as folder, RosSession(os.path.join(folder, "launch.log")) as session:
        session.launch(None, launch_file(pathlib.Path(folder), options, cameras, speed))
        streams = Streams(session, {**TOPICS, **{f"3D detections of camera {n}": f"camera_{n}/detections_3d" for n in range(2, cameras + 1)}},
                          speed, READY_S)
        streams.wait_until_complete()
        streams.drive(SETTLE_S * speed, GOALS_M, GOAL_PERIOD_S)
        meter = PartMeter(os.environ["ROS_MASTER_URI"])
        streams.begin()
        meter.begin()
        streams.drive(options.seconds, GOALS_M, GOAL_PERIOD_S)
        used = meter.used()
        case = f"{cameras} camera{'s' if cameras > 1 else ''}" + (f", a computer {speed:g} times slower" if speed != 1 else "")
        return list(rows_of(case, streams, used, speed, options.seconds))


def row(case, metric, unit, ours, peer=None, peer_name=None):
    ratio = ours / peer if peer and ours is not None else None
    return {"case": case, "metric": metric, "unit": unit, "ours": ours, "peer": peer, "peer_name": peer_name, "ratio": ratio,
            "goal": None, "met": None}


def rows_of(case, streams, used, speed, seconds):
    yield row(case, "simulated seconds per second", "1", streams.pace(), speed, "asked for")
    asked = {"3D detections": "images", "planar scans": "lidar sweeps", "poses in the map": "planar scans"}
    for name in streams.names:
        source = asked.get(name, "images" if name.startswith("3D") else None)
        yield row(case, f"{name} per second", "Hz", streams.rate(name, seconds), source and streams.rate(source, seconds), source)
    for title, source, result in CHAINS:
        times = streams.latencies_ms(source, result)
        for figure, value in (("median", statistics.median(times) if times else None), ("p95", percentile(times, 0.95))):
            yield row(case, f"{title}, {figure}", "ms", value)
    motion = streams.goal_to_motion_ms
    yield row(case, "goal to motion, median", "ms", statistics.median(motion) if motion else None)
    for part, (cpu_s, memory_mb) in sorted(used.items(), key=lambda item: -item[1][0]):
        yield row(case, f"{part}: CPU", "% of a core", 100 * cpu_s / (seconds / speed))
        yield row(case, f"{part}: memory", "MB", memory_mb)
    yield row(case, "all but the simulator: CPU", "% of a core",
              100 * sum(cpu_s for part, (cpu_s, _) in used.items() if part != "simulator") / (seconds / speed))


def percentile(values, part):
    return sorted(values)[min(len(values) - 1, int(part * len(values)))] if values else None


def print_table(rows):
    """A line per metric, a column per case."""
    cases = list(dict.fromkeys(one["case"] for one in rows))
    metrics = list(dict.fromkeys((one["metric"], one["unit"]) for one in rows))
    of = {(one["case"], one["metric"]): one["ours"] for one in rows}
    lines = [("", *cases)]
    for metric, unit in metrics:
        values = [of.get((case, metric)) for case in cases]
        lines.append((f"{metric} [{unit}]", *("-" if value is None else f"{value:.1f}" for value in values)))
    widths = [max(len(line[column]) for line in lines) for column in range(len(lines[0]))]
    for line in lines:
        print("  ".join([line[0].ljust(widths[0]), *(cell.rjust(width) for cell, width in zip(line[1:], widths[1:]))]))


def in_child(options, cameras, speed):
    """Rows of a case, measured in a process of its own: rospy belongs to one master."""
    reader, writer = os.pipe()
    child = os.fork()
    if child == 0:
        os.close(reader)
        code = 1
        try:
            with os.fdopen(writer, "w") as out:
                json.dump(measure(options, cameras, speed), out)
            code = 0
        except Stalled as error:
            print(f"bench_system: {cameras} cameras, {speed:g} times: {error}", file=sys.stderr)
        except KeyboardInterrupt:
            code = 130
        finally:
            sys.stderr.flush()
            os._exit(code)
    os.close(writer)
    with os.fdopen(reader) as source:
        text = source.read()
    _, status = os.waitpid(child, 0)
    return json.loads(text) if os.waitstatus_to_exitcode(status) == 0 else None


def main(arguments=None):
    options = parse(arguments)
    rows, failed = [], False
    for cameras, speed in [*((count, 1.0) for count in options.cameras), *((1, factor) for factor in options.slower)]:
        print(f"{cameras} cameras, {speed:g} times ...", file=sys.stderr, flush=True)
        found = in_child(options, cameras, speed)
        failed = failed or found is None
        rows += found or []
    print(f"{machine()}, {options.seconds:g} simulated seconds for each case, {options.world}\n")
    print_table(rows)
    if options.json:
        options.json.write_text(json.dumps({"name": "system", "machine": machine(), "rows": rows}, indent=1) + "\n")
    return 1 if failed or not rows else 0


if __name__ == "__main__":
    sys.exit(main())
