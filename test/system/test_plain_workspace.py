"""A plain catkin workspace with a copy of this repository in src/ builds, tests, installs and runs without a step by hand,
whether the system has the message packages of interfaces/ or not."""

import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

REPO = pathlib.Path(__file__).resolve().parents[2]
sys.path[:0] = [str(REPO / "tools" / "lib")]

import ros_session  # noqa: E402
from test_tiers import long_scenario  # noqa: E402

INTERFACES = ("baxter_core_msgs", "control_msgs", "vision_msgs")
SETUP = "/usr/share/catkin/cmake/toplevel.cmake", "/opt/ros/noetic/share/catkin/cmake/toplevel.cmake"
LAUNCH = """
export ROS_MASTER_URI=http://127.0.0.1:{port} ROS_IP=127.0.0.1 ROS_HOME={home}
roslaunch -p {port} extperfc sim.launch rviz:=false >{home}.log 2>&1 & launch=$!
timeout 60 bash -c 'until rostopic echo -n 1 /robot/joint_states 2>/dev/null; do sleep 0.2; done' || cat {home}.log
kill -TERM $launch; wait $launch; true
"""


def known_files():
    """What a clone of this checkout would hold, with what is not committed yet."""
    listed = subprocess.run(["git", "ls-files", "-co", "--exclude-standard", "-z"], cwd=REPO, capture_output=True,
                            text=True)
    names = listed.stdout.split("\0") if listed.returncode == 0 else [
        str(file.relative_to(REPO)) for file in REPO.rglob("*") if ".ws" not in file.parts]
    return [name for name in names if name and (REPO / name).is_file()]


def plain_environment(**more):
    """As a user's new shell: without the workspace of tools/setup."""
    ours = ("CMAKE_PREFIX_PATH", "ROS_PACKAGE_PATH", "PYTHONPATH", "LD_LIBRARY_PATH", "PKG_CONFIG_PATH", "EXTPERFC_WS",
            "CATKIN_TEST_RESULTS_DIR", "ROS_TEST_RESULTS_DIR")
    kept = {name: value for name, value in os.environ.items() if name not in ours}
    path = os.pathsep.join(part for part in kept["PATH"].split(os.pathsep) if "/.ws/" not in part)
    return dict(kept, PATH=path, ROS_LANG_DISABLE="genlisp", **more)


class Workspace:
    """A workspace in a temporary folder whose src/ holds this package."""

    def __init__(self):
        self._folder = tempfile.TemporaryDirectory(prefix="extperfc_workspace_")
        self.root = pathlib.Path(self._folder.name).resolve()
        self.package = self.root / "src" / "extperfc"
        for name in known_files():
            target = self.package / name
            target.parent.mkdir(parents=True, exist_ok=True)
            shutil.copy2(REPO / name, target)

    def close(self):
        self._folder.cleanup()

    def run(self, *command, timeout=300, **environment):
        """Runs a command in the workspace's folder; returns its output, raises with it when the command fails."""
        done = subprocess.run(command, cwd=self.root, env=plain_environment(PWD=str(self.root), **environment),
                              stdout=subprocess.PIPE,
                              stderr=subprocess.STDOUT, stdin=subprocess.DEVNULL, text=True, timeout=timeout)
        if done.returncode != 0:
            raise AssertionError(f"{' '.join(command)} ended with {done.returncode}:\n{done.stdout[-6000:]}")
        return done.stdout

    def catkin_make(self, *arguments, timeout=240, **environment):
        return self.run("catkin_make", *arguments, "-DPYTHON_EXECUTABLE=/usr/bin/python3", timeout=timeout, **environment)

    def in_space(self, space, script, timeout=120):
        """Runs a shell script after the setup file of the devel or install space."""
        return self.run("bash", "-c", f". {self.root}/{space}/setup.bash && {script}", timeout=timeout)


def built_from(output):
    """{message package: where CMake took it from}."""
    return dict(re.findall(r"^-- (\w+_msgs): (?!\d+ messages)(.*)$", output, re.M))


class MessagePackages(unittest.TestCase):
    def setUp(self):
        self.workspace = Workspace()
        self.addCleanup(self.workspace.close)

    def test_built_here_when_the_system_lacks_them(self):
        first = built_from(self.workspace.catkin_make("vision_msgs_generate_messages"))
        lacking = [package for package in INTERFACES if "built here" in first[package]]
        if not lacking:
            self.skipTest("this system has all message packages")
        for package in lacking:
            found = self.workspace.in_space("devel", f"/usr/bin/python3 -c '"
                                            f"import rospkg; print(rospkg.RosPack().get_path(\"{package}\"))'")
            self.assertEqual(str(self.workspace.package / "interfaces" / package), found.strip())
        if "vision_msgs" in lacking:
            self.workspace.in_space("devel", "/usr/bin/python3 -c 'import vision_msgs.msg' && rosmsg show vision_msgs/Detection3D")
            self.assertTrue((self.workspace.root / "devel/include/vision_msgs/Detection3D.h").exists())
        again = built_from(self.workspace.run("cmake", "build"))
        self.assertEqual(first, again, "what the first run left in the devel space is not the system's")

    def test_taken_from_the_system_or_the_workspace(self):
        prefix = self.workspace.root / "system"
        build = self.workspace.root / "build_vision_msgs"
        self.workspace.run("cmake", "-S", str(self.workspace.package / "interfaces/vision_msgs"), "-B", str(build),
                           f"-DCMAKE_INSTALL_PREFIX={prefix}", "-DPYTHON_EXECUTABLE=/usr/bin/python3",
                           "-DCATKIN_ENABLE_TESTING=OFF")
        self.workspace.run("make", "-C", str(build), "install")
        shutil.copytree(self.workspace.package / "interfaces/control_msgs", self.workspace.root / "src/control_msgs")
        toplevel = next(file for file in SETUP if pathlib.Path(file).exists())
        (self.workspace.root / "src/CMakeLists.txt").symlink_to(toplevel)
        output = self.workspace.run("cmake", "-S", "src", "-B", "build", f"-DCMAKE_PREFIX_PATH={prefix}",
                                    f"-DCATKIN_DEVEL_PREFIX={self.workspace.root}/devel",
                                    "-DPYTHON_EXECUTABLE=/usr/bin/python3")
        taken = built_from(output)
        self.assertEqual(str(prefix / "share/vision_msgs/cmake"), taken["vision_msgs"])
        self.assertEqual("a package of this workspace", taken["control_msgs"])
        self.assertFalse((self.workspace.root / "devel/share/vision_msgs").exists())


class NestedWorkspace(unittest.TestCase):
    def test_packages_are_found_once_beside_the_workspace_of_setup(self):
        """Somebody ran tools/setup in a clone that lies in a workspace: rosrun must not find programs twice."""
        workspace = Workspace()
        self.addCleanup(workspace.close)
        (workspace.root / ".catkin_workspace").touch()
        place = workspace.run("bash", "-c", ". src/extperfc/tools/lib/places.sh; echo $WS").strip()
        # rosrun searches the folder of a package, hidden folders too, except build/.
        self.assertEqual(f"{workspace.package}/build/ws", place)
        (workspace.root / ".catkin_workspace").unlink()
        place = workspace.run("bash", "-c", ". src/extperfc/tools/lib/places.sh; echo $WS").strip()
        self.assertEqual(f"{workspace.package}/.ws", place)


@long_scenario("compiles the whole package; MessagePackages configures it in a minute")
class WholeBuild(unittest.TestCase):
    def test_build_tests_install_and_launch(self):
        workspace = Workspace()
        self.addCleanup(workspace.close)
        workspace.catkin_make(timeout=5400)
        self.check_tools_of_the_checkout(workspace)
        workspace.catkin_make("run_tests_extperfc_gtest_test_base_sha256", "run_tests_extperfc_rostest_test_ros_params.test",
                              "run_tests_extperfc_python_all", timeout=1800)
        results = workspace.run("catkin_test_results", "build/test_results")
        self.assertIn(" 0 errors, 0 failures", results)
        workspace.catkin_make("install", timeout=600)
        shutil.rmtree(workspace.root / "build")
        shutil.rmtree(workspace.root / "devel")
        shutil.move(workspace.package, workspace.root / "away")
        self.check_installed(workspace)

    def check_tools_of_the_checkout(self, workspace):
        self.assertIn("recording", workspace.run(str(workspace.package / "tools/extperfc-map"), "--help"))

    def check_installed(self, workspace):
        tools = workspace.root / "install/share/extperfc/tools"
        for tool in ("extperfc-map", "extperfc-model", "extperfc-translate", "arm_markers", "train_shapes"):
            workspace.run(str(tools / tool), "--help")
        for package in INTERFACES:
            workspace.in_space("install", f"/usr/bin/python3 -c 'import {package}.msg'")
        state = workspace.in_space("install", LAUNCH.format(port=ros_session.free_port(), home=workspace.root / "ros"),
                                   timeout=120)
        self.assertIn("right_s0", state)


if __name__ == "__main__":
    unittest.main()
