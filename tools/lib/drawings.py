"""Makes the two drawings of docs/architecture.md: modules with their arrows, and the ROS graph of the whole robot.

The arrows between modules are the includes of their files. The ROS graph joins what the class comments of the nodes say that
they publish, subscribe to, serve and call (see nodelet_pages). Graphviz draws them.
"""

import functools
import hashlib
import itertools
import re
import subprocess

from nodelet_pages import REPO, launch_files, node

IMAGES = REPO / "docs" / "images"
INCLUDE = re.compile(r'#include\s*["<](?:src/|extperfc/)?(\w+)/')
# Headers of libraries, by what they begin with.
LIBRARIES = {"openvino/": "OpenVINO", "opencv2/": "OpenCV", "yaml-cpp/": "yaml-cpp", "mrpt/": "MRPT", "openssl/": "OpenSSL",
             "btBullet": "Bullet", "BulletCollision": "Bullet", "kdl/": "KDL", "ompl/": "OMPL", "tinyxml2": "tinyxml2",
             "embree": "Embree", "urdf": "urdfdom", "pcl/": "PCL", "boost/": "Boost", "png.h": "libpng", "Eigen/": "Eigen"}
STYLE = ('  graph [fontname="Helvetica", fontsize=13, nodesep=0.35, ranksep=0.6, bgcolor="white"]\n'
         '  node [fontname="Helvetica", fontsize=13, shape=box, style="rounded,filled", fillcolor="#eef3fa", color="#4a6fa5"]\n'
         '  edge [fontname="Helvetica", fontsize=11, color="#555555"]\n')


def files_of(module):
    for folder in (REPO / "src" / module, REPO / "include" / "extperfc" / module):
        yield from sorted(folder.rglob("*.[ch]pp"))


@functools.lru_cache(maxsize=None)
def modules():
    """Names of the modules, ros included: folders of src that hold C++."""
    return tuple(sorted(folder.name for folder in (REPO / "src").iterdir() if any(files_of(folder.name))))


def includes(module):
    """Other modules that this one includes."""
    text = "".join(file.read_text() for file in files_of(module))
    return {name for name in INCLUDE.findall(text) if name in modules() and name != module}


def libraries(module):
    text = "".join(file.read_text() for file in files_of(module))
    return sorted({name for header, name in LIBRARIES.items() if re.search(rf'#include\s*[<"]{re.escape(header)}', text)})


def reduced(arrows):
    """Without the arrows that a path of others implies."""
    def reaches(begin, end, skipped):
        return any((begin, following) != skipped and (following == end or reaches(following, end, skipped))
                   for following in arrows[begin])
    return {module: {other for other in others if not reaches(module, other, (module, other))}
            for module, others in arrows.items()}


def modules_dot():
    lines = ["digraph modules {", STYLE + "  rankdir=BT;"]
    folders = sorted(folder.name for folder in (REPO / "src/ros").iterdir() if folder.is_dir())
    rows = [", ".join(folders[i:i + 7]) for i in range(0, len(folders), 7)]
    for module in modules():
        text = [f"<b>{module}</b>"] + [", ".join(group) for group in batches(libraries(module), 2)]
        if module == "ros":
            text = ["<b>ros</b>: the only module with ROS headers", *rows]
        lines.append(f"  {module} [label=<{'<br/>'.join(text)}>];")
    level = [module for module in modules() if module not in ("base", "world", "ros", "face", "offline")]
    lines.append("  {rank=same; " + "; ".join(level) + "}")
    arrows = reduced({module: includes(module) for module in modules()})
    direct = includes("ros")
    arrows["ros"] = direct - {"base", "world"}  # all of them: a nodelet's folder uses the module of its name
    for module, others in arrows.items():
        lines.extend(f"  {other} -> {module} [dir=back];" for other in sorted(others))
    python = ", ".join(sorted(folder.name for folder in (REPO / "src/extperfc").iterdir() if (folder / "__init__.py").exists()))
    lines.append(f'  python [label=<<b>extperfc</b> (Python)<br/>{python}>, fillcolor="#f6f1e4", color="#a58a4a"];')
    lines.append('  launch [label=<<b>launch</b>, config>, fillcolor="#f6f1e4", color="#a58a4a"];')
    lines.append('  ros -> launch [dir=back];\n  ros -> python [dir=none, style=dashed, label="topics, services, actions"];')
    return "\n".join(lines) + "\n}\n"


def batches(items, size):
    return [items[i:i + size] for i in range(0, len(items), size)]


# Boxes of the ROS graph: title, classes whose comments describe them, cluster.
BOXES = {
    "robot": ("arms, grippers, head\n(Baxter, ROS Indigo)", ("RobotInterface",), "robot"),
    "camera": ("RGB-D camera", ("CameraSensor",), "drivers"),
    "lidar": ("lidar", ("LidarSensor",), "drivers"),
    "base": ("mobile base, IMU", ("BaseInterface",), "drivers"),
    "detector": ("extperfc/detector", ("DetectorNodelet",), "nodes"),
    "box_depth": ("extperfc/box_depth", ("BoxDepthNodelet",), "nodes"),
    "tracker": ("extperfc/tracker", ("TrackerNodelet",), "nodes"),
    "cloud_to_scan": ("extperfc/cloud_to_scan", ("CloudToScanNodelet",), "nodes"),
    "mapper": ("extperfc/mapper", ("MapperNodelet",), "nodes"),
    "localizer": ("extperfc/localizer", ("LocalizerNode",), "nodes"),
    "arm": ("extperfc/arm", ("ArmNode",), "nodes"),
}
CLUSTERS = {"robot": "the robot, with its own ROS master", "drivers": "drivers", "nodes": "extperfc"}
LINE = "\\l"  # Graphviz's end of a line that begins at the left
LEFT_OUT = re.compile(r"diagnostics|/tf|/tf_static|/clock|sim/.*|camera/.*/camera_info")


@functools.lru_cache(maxsize=None)
def remaps(box):
    """New names by the names in the comments, of the launch files with their defaults."""
    text = "".join((REPO / "launch" / file).read_text() for file in launch_files("extperfc/" + box))
    defaults = dict(re.findall(r'<arg name="(\w+)" default="([^"]*)"', text))
    return {old: defaults[new] for old, new in re.findall(r'<remap from="([^"]*)" to="\$\(arg (\w+)\)"', text)}


def names(box, *titles):
    """Topics, services or actions in these sections of a box's comments."""
    rows = itertools.chain.from_iterable(node(part).rows.get(title, ()) for part in BOXES[box][1] for title in titles)
    every = itertools.chain.from_iterable(name.split(", ") for _, name, _ in rows)
    return {name for name in (remaps(box).get(name, name) for name in every) if not LEFT_OUT.fullmatch(name)}


def joints():
    """(from, to, names) of every arrow between two boxes."""
    for begin, end in itertools.permutations(BOXES, 2):
        yield begin, end, names(begin, "Publishes") & names(end, "Subscribes")
        yield begin, end, names(begin, "Calls") & names(end, "Actions", "Services")


def ends():
    """(box, names that no box subscribes to, names that no box publishes or calls) for arrows to and from the user."""
    taken = set().union(*(names(box, "Subscribes") for box in BOXES))
    given = set().union(*(names(box, "Publishes", "Calls") for box in BOXES))
    for box in BOXES:
        out = {name for name in names(box, "Publishes") if name not in taken and not name.startswith("~")}
        yield box, out, names(box, "Subscribes", "Actions") - given


def shortened(topics):
    """Sorted; several names with the same first two parts become one."""
    heads = ["/".join(name.split("/")[:2]) for name in topics]
    return sorted({name if heads.count(head) == 1 else head + "/..." for name, head in zip(topics, heads)})


def box_label(box, out, into):
    """Title and what the box exchanges with programs that the drawing does not show."""
    lines = [f"<b>{line}</b>" for line in BOXES[box][0].split("\n")]
    for title, topics in (("in", into), ("out", out)):
        for batch in batches(shortened(topics), 2):
            text = ", ".join(batch).replace("<", "&lt;").replace(">", "&gt;")
            lines.append(f'<font point-size="11">{title}: {text}</font>')
    return "<" + '<br align="left"/>'.join(lines) + '<br align="left"/>>'


def ros_graph_dot():
    lines = ["digraph ros {", STYLE + "  rankdir=LR;"]
    labels = {box: box_label(box, out, into) for box, out, into in ends()}
    for cluster, title in CLUSTERS.items():
        lines.append(f'  subgraph cluster_{cluster} {{ label="{title}"; color="#bbbbbb"; style=rounded;')
        lines.extend(f"    {box} [label={labels[box]}];" for box in BOXES if BOXES[box][2] == cluster)
        lines.append("  }")
    lines.append("  translator [label=<<b>extperfc/translator</b><br/>joins two masters>];")
    with_robot = []  # by way of the translator
    for begin, end, topics in joints():
        if not topics:
            continue
        if "robot" in (begin, end):
            with_robot += [("&#8594; " if begin == "robot" else "&#8592; ") + name for name in sorted(topics)]
        else:
            lines.append(f'  {begin} -> {end} [label="{LINE.join(sorted(topics))}{LINE}"];')
    lines.append('  robot -> translator [dir=both, label="robot/..."];')
    lines.append(f'  translator -> arm [dir=both, label="{LINE.join(with_robot)}{LINE}"];')
    return "\n".join(lines) + "\n}\n"


DRAWINGS = {"modules": modules_dot, "ros_graph": ros_graph_dot}


def svg_of(dot):
    """The drawing, with the digest of what it was made of."""
    made = subprocess.run(["dot", "-Tsvg"], input=dot, text=True, capture_output=True, check=True).stdout
    return made.rstrip("\n") + f"\n<!-- made of {digest(dot)} -->\n"


def digest(dot):
    return hashlib.sha256(dot.encode()).hexdigest()
