"""Layers of the package: which module may include which. See docs/architecture.md."""

import pathlib
import re
import unittest

REPO = pathlib.Path(__file__).resolve().parents[2]
MODULES = ("detect", "face", "depth", "track", "sources", "simulate", "scan", "translate", "mapping", "localize", "navigate",
           "offline", "arm")
BELOW = {"base": set(), "world": {"base"}, **{module: {"base", "world"} for module in MODULES}}
BELOW["face"] |= {"detect"}  # its networks run on the back ends of detect
BELOW["offline"] |= {"mapping", "sources"}  # programs that join modules: a recording goes in, a map comes out
ROS_HEADER = re.compile(r'#include\s*[<"](ros/(?!params|convert|health|detect|face|depth|track|sources|simulate|scan|translate|mapping|localize|map_server|navigate|explore|program|offline|arm)|tf2|nodelet/|pluginlib/|'
                        r'cv_bridge/|image_transport/|diagnostic_updater/|message_filters/|rosbag/|XmlRpc|[a-z_]+_msgs/)')
PARAMETER_READ = re.compile(r'(?<!")' r"\b(getParam|getParamCached|param\s*<|ros::param::get)\b|\.param\s*\(")
OWN_HEADER = re.compile(r'#include\s*[<"](?:extperfc/)?(\w+)/[\w/]+\.hpp[>"]')
# Folders of src/translate, a library each: what lies below it, and its public headers.
TRANSLATE = {
    "schema": (set(), {"bytes", "schema", "definition_store"}),
    "plan": ({"schema"}, {"plan", "rules"}),
    "rules": ({"schema", "plan"}, set()),
    "peer": ({"schema"}, {"event_loop", "frame", "peer", "rpc", "tcpros"}),
    "bridge": ({"schema", "plan", "peer"}, {"bridge", "clock_offset", "sntp_client"}),
    "tool": ({"schema", "plan", "rules", "peer"}, set()),
}
TRANSLATE_HEADER = re.compile(r'#include "(?:translate/(\w+)/\w+|extperfc/translate/(\w+))\.hpp"')
NAMESPACE = re.compile(r"^(?:inline )?namespace (\w[\w:]*) \{", re.MULTILINE)
# Third-party headers stay in the modules that own the library.
OWNERS = {
    r"openvino/": {"detect"},
    r"opencv2/dnn": {"detect"},
    r"yaml-cpp/": {"world", "detect", "face", "sources", "simulate", "translate"},
    r"nlohmann/": {"offline", "translate"},
    r"mrpt/": {"sources"},
    r"openssl/": {"base"},
    r"(btBullet|Bullet)": {"simulate", "arm"},
    r"kdl/": {"arm"},
    r"ompl/": {"arm"},
    r"tinyxml2": {"arm"},
    r"embree\d?/": {"simulate"},
    r"urdf": {"world"},
    r"pcl/": {"scan"},
    r"boost/iostreams": {"sources"},
    r"png\.h": {"world"},
}


def core_files():
    """(module, file) of every source and header outside src/ros."""
    for module in BELOW:
        for folder in (REPO / "src" / module, REPO / "include" / "extperfc" / module):
            for file in sorted(folder.rglob("*.[ch]pp")):
                yield module, file


def namespace_of(file):
    """The only namespace with a name that a source or header of the package may open."""
    folders = file.relative_to(REPO / "src" if REPO / "src" in file.parents else REPO / "include" / "extperfc").parts
    if folders[0] == "ros":
        return f"extperfc::ros_{folders[1]}"
    return "extperfc" if folders[0] in ("base", "world") else f"extperfc::{folders[0]}"


def violations(pattern, files):
    for file in files:
        for number, line in enumerate(file.read_text().splitlines(), 1):
            if pattern.search(line):
                yield f"{file.relative_to(REPO)}:{number}: {line.strip()}"


class Layers(unittest.TestCase):
    def test_core_exists(self):
        self.assertGreater(len(list(core_files())), 20)

    def test_no_ros_headers_outside_src_ros(self):
        self.assertEqual([], list(violations(ROS_HEADER, (f for _, f in core_files()))))

    def test_parameters_are_read_in_params_only(self):
        files = [f for f in sorted((REPO / "src").rglob("*.[ch]pp")) if "params" not in f.parts]
        self.assertEqual([], list(violations(PARAMETER_READ, files)))

    def test_modules_include_only_what_lies_below(self):
        wrong = []
        for module, file in core_files():
            for included in OWN_HEADER.findall(file.read_text()):
                if included in BELOW and included != module and included not in BELOW[module]:
                    wrong.append(f"{file.relative_to(REPO)} includes {included}/")
        self.assertEqual([], wrong)

    def test_folders_of_translate_point_one_way(self):
        folders = {header: folder for folder, (_, headers) in TRANSLATE.items() for header in headers}
        public = (REPO / "include/extperfc/translate").glob("*.hpp")
        self.assertEqual(sorted(folders), sorted(file.stem for file in public))
        wrong = []
        for folder, (below, _) in TRANSLATE.items():
            path = REPO / "src/translate" / folder
            target = f"extperfc_add_library(translate_{folder}\n" if folder != "tool" else "extperfc_add_program("
            self.assertIn(target, (path / "CMakeLists.txt").read_text())
            for file in (*path.glob("*.[ch]pp"), path / "CMakeLists.txt"):
                text = file.read_text()
                used = {inner or folders[header] for inner, header in TRANSLATE_HEADER.findall(text)}
                used |= set(re.findall(r"extperfc::translate_(\w+)", text))
                wrong += [f"{file.relative_to(REPO)} uses {other}" for other in sorted(used - below - {folder})]
        self.assertEqual([], wrong)

    def test_namespaces_are_modules(self):
        files = [file for top in ("src", "include") for file in sorted((REPO / top).rglob("*.[ch]pp"))]
        wrong = [f"{file.relative_to(REPO)} opens {name}, not {namespace_of(file)}" for file in files
                 for name in NAMESPACE.findall(file.read_text()) if name != namespace_of(file)]
        self.assertEqual([], wrong)

    def test_third_party_headers_stay_in_their_module(self):
        wrong = []
        for header, owners in OWNERS.items():
            pattern = re.compile(r'#include\s*[<"]' + header)
            wrong += [hit for module, file in core_files() if module not in owners
                      for hit in violations(pattern, [file])]
        self.assertEqual([], wrong)

    def test_patterns_find_what_they_should(self):
        for line in ("#include <ros/ros.h>", "#include <sensor_msgs/Image.h>", '#include "tf2_ros/buffer.h"'):
            self.assertRegex(line, ROS_HEADER)
        for line in ("nh.getParam(x, y)", "nh.param<int>(a, b)", "ros::param::get(k, v)", 'nh.param("a", b, c)'):
            self.assertRegex(line, PARAMETER_READ)


if __name__ == "__main__":
    unittest.main()
