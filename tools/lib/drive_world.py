"""Worlds of the trials that drive the simulated robot: the world's file with as many people as are wanted, the simulator's
configuration for it, its true map with small cells, and where the robot may stand. `options` are a trial's: world, seed, people,
fine and out."""

import contextlib
import pathlib
import subprocess
import sys

import numpy
import yaml

from driven_contacts import TrueMap, reachable
from pose_errors import Pose
from ros_session import RosSession, Stalled
from walkers import more_people, with_people

REPO = pathlib.Path(__file__).resolve().parents[2]
GOAL_CLEARANCE_M = 0.65  # of goals: the robot may stand there in any direction
PASSAGE_M = 0.44         # of the robot's middle to what stands around on its path


def prepare(options):
    """The world of a trial with its people, and its true map; makes the folder `out`."""
    options.out.mkdir(parents=True, exist_ok=True)
    people_file(options).unlink(missing_ok=True)  # of an earlier run
    world = world_of(options)
    true_map = fine_map(options, world)
    try:
        add_people(options, world, true_map)
    except ValueError as error:
        raise SystemExit(f"error: {error}") from error
    return world, true_map


def world_of(options):
    """The world, without its people unless they are wanted."""
    file = pathlib.Path(options.world)
    if not file.suffix:
        file = REPO / "config" / "worlds" / (options.world + ".yaml")
    if not file.exists():
        return options.world  # a random one, made by the simulator
    text = file.read_text()
    if not options.people:
        text = with_people(text, [])
    copy = options.out / file.name
    copy.write_text(text)
    return copy.resolve()


def add_people(options, world, true_map):
    """Brings the number of people in a world to what is wanted."""
    if options.people <= 0:
        return
    is_file = isinstance(world, pathlib.Path)
    content = yaml.safe_load(world.read_text()) if is_file else {}
    here = (content.get("robot") or {}).get("at", (0.0, 0.0))
    people = (content.get("people") or [])[:options.people]
    places = places_of(true_map, Pose(here[0], here[1], 0.0))
    people += more_people(true_map, places, options.people - len(people), options.seed, here[:2])
    if is_file:
        world.write_text(with_people(world.read_text(), people))
    else:
        people_file(options).write_text(yaml.safe_dump({"people": people}))


def people_file(options):
    """Of people who are added to a world without a file."""
    return options.out.resolve() / "people.yaml"


def sim_config(options, resolution_m=None):
    params = yaml.safe_load((REPO / "config" / "simulator.yaml").read_text())
    params.setdefault("random_world", {})["person"] = 1.0 if options.people < 0 else 0.0
    if people_file(options).exists():
        params["people_file"] = str(people_file(options))
    if resolution_m:
        params.setdefault("truth", {})["map_resolution_m"] = resolution_m
    file = options.out / (f"simulator_{resolution_m:g}.yaml" if resolution_m else "simulator.yaml")
    file.write_text(yaml.safe_dump(params))
    return file


def fine_map(options, world):
    """The true map with small cells: of a simulator that runs for this alone, in a process with its own master."""
    file = options.out / f"map_{pathlib.Path(str(world)).stem}_{options.seed}_{options.fine:g}.npz"
    if not file.exists():
        command = [sys.executable, __file__, file, world, str(options.seed),
                   sim_config(options, options.fine), options.out / "map.log"]
        subprocess.run([str(part) for part in command], check=True, timeout=300)
    with numpy.load(file) as stored:
        return TrueMap(stored["cells"], float(stored["resolution"]), float(stored["x0"]), float(stored["y0"]))


def next_map(session):
    """The simulator's next true map."""
    import rospy
    from nav_msgs.msg import OccupancyGrid
    while session.alive():
        with contextlib.suppress(rospy.ROSException):  # none within this time
            return rospy.wait_for_message("sim/truth/map", OccupancyGrid, timeout=1)
    raise Stalled("the simulator does not start")


def save_map(file, world, seed, config, log):
    import rospy
    with RosSession(log) as session:
        session.launch("extperfc", "sim.launch", rviz="false", world=world, seed=seed, config=config, camera="false",
                       lidar="false", scan="false", paused="true")
        try:
            session.join("save_map")
            message = next_map(session)
        except Stalled as error:
            raise SystemExit(f"error: {error}; see {log}") from None
        info = message.info
        cells = numpy.array(message.data, numpy.int8).reshape(info.height, info.width)
        numpy.savez_compressed(file, cells=cells, resolution=round(info.resolution, 6), x0=info.origin.position.x,
                               y0=info.origin.position.y)
        rospy.signal_shutdown("done")


def places_of(true_map, here):
    """Where goals may be, as an array of (x, y): on a coarse raster, to which a disc of the passage's width gets."""
    mask = reachable(true_map, (here.x, here.y), PASSAGE_M) & (true_map.clearance_m > GOAL_CLEARANCE_M)
    step = max(1, int(0.1 / true_map.resolution_m))
    rows, columns = numpy.nonzero(mask[::step, ::step])
    if len(rows) == 0:
        raise Stalled("the map has no free position that is large enough for the robot")
    size = true_map.resolution_m * step
    return numpy.stack([true_map.x0 + columns * size, true_map.y0 + rows * size], 1)


if __name__ == "__main__":
    save_map(*sys.argv[1:])
