"""package.xml, the Debian list of tools/setup, the plug-in list and the launch files agree with each other."""

import pathlib
import re
import subprocess
import unittest
import xml.etree.ElementTree

REPO = pathlib.Path(__file__).resolve().parents[2]


def keys_of(package_xml):
    root = xml.etree.ElementTree.parse(package_xml).getroot()
    return {node.text.strip() for node in root if node.tag.endswith("depend")}


def debian_list():
    lines = (REPO / "tools/lib/debian_packages.txt").read_text().splitlines()
    return dict(line.split(":", 1) for line in lines if line.strip() and not line.startswith("#"))


class Packages(unittest.TestCase):
    def test_every_dependency_has_debian_packages_and_back(self):
        own = {path.name for path in (REPO / "interfaces").iterdir()}
        needed = keys_of(REPO / "package.xml")
        for package in own:
            needed |= keys_of(REPO / "interfaces" / package / "package.xml")
        self.assertEqual(needed - own, set(debian_list()))

    def test_debian_knows_the_packages(self):
        names = sorted({name for value in debian_list().values() for name in value.split()})
        if not pathlib.Path("/etc/debian_version").exists():
            self.skipTest("not a Debian system")
        shown = subprocess.run(["dpkg-query", "-W", "-f", "${Package}\n", *names], capture_output=True, text=True)
        self.assertEqual("", shown.stderr)

    def test_every_interface_package_is_a_dependency_that_the_build_brings_along(self):
        own = {path.name for path in (REPO / "interfaces").iterdir()}
        self.assertLessEqual(own, keys_of(REPO / "package.xml"))
        built = re.search(r"foreach\(package IN ITEMS ([^)]*)\)", (REPO / "cmake/interfaces.cmake").read_text())
        self.assertEqual(own, set(built[1].split()))

    def test_every_package_that_cmake_asks_catkin_for_is_a_dependency(self):
        asked = re.search(r"find_package\(catkin REQUIRED COMPONENTS([^)]*)\)", (REPO / "cmake/ros.cmake").read_text())
        self.assertLessEqual(set(asked[1].split()), keys_of(REPO / "package.xml"))

    def test_every_rostest_is_registered_with_catkin(self):
        lists = "".join(file.read_text() for file in (REPO / "test/ros").rglob("CMakeLists.txt"))
        registered = set(re.findall(r"extperfc_add_ros_test\((\w+)", lists)) - {"name"}
        self.assertEqual({file.stem for file in (REPO / "test/ros").glob("*.test")}, registered)

    def test_every_plugin_has_a_source(self):
        root = xml.etree.ElementTree.parse(REPO / "config/nodelet_plugins.xml").getroot()
        exported = {node.get("type") for node in root.iter("class")}
        sources = "".join(f.read_text() for f in (REPO / "src/ros").rglob("*_nodelet.cpp"))
        defined = set(re.findall(r"PLUGINLIB_EXPORT_CLASS\(([\w:]+),", sources))
        self.assertEqual(exported, defined)

    def test_launch_arguments_are_documented_and_files_exist(self):
        for file in sorted([*(REPO / "launch").glob("*.launch"), *(REPO / "config" / "robots").rglob("*.launch")]):
            root = xml.etree.ElementTree.parse(file).getroot()
            for argument in root.findall("arg"):
                with self.subTest(file=file.name, argument=argument.get("name")):
                    self.assertTrue(argument.get("doc"))
            for path in re.findall(r"\$\(find extperfc\)/([\w./]+)", file.read_text()):
                with self.subTest(file=file.name, path=path):
                    self.assertTrue((REPO / path).exists())


    def test_a_robots_folder_is_complete(self):
        for folder in (path for path in (REPO / "config" / "robots").iterdir() if path.is_dir()):
            for name in ("robot.launch", "parameters.yaml", "self_volumes.yaml"):
                with self.subTest(folder.name, file=name):
                    self.assertTrue((folder / name).is_file())


if __name__ == "__main__":
    unittest.main()
