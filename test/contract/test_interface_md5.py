#!/usr/bin/env python3
"""Contract: every type in interfaces/ has the MD5 of the published package of the same name.

The expected values in test/data/interface_md5.json are the published ones (Noetic's vision_msgs 0.0.2 and
control_msgs 1.5.2, baxter_core_msgs 1.2.0); they were not computed from the files that are tested here. The MD5s are
computed from the definition files with genmsg, so nothing needs to be built. A file without a published value fails,
and so does a published value without a file.

Run: /usr/bin/python3 test/contract/test_interface_md5.py
"""

import json
import os
import pathlib
import sys
import unittest

try:
    import genmsg
    from genmsg import msg_loader
except ImportError:
    genmsg = None

ROOT = pathlib.Path(__file__).resolve().parents[2]
INTERFACES = ROOT / "interfaces"
STORED = ROOT / "test" / "data" / "interface_md5.json"
FACTS = ROOT.parent / "shared" / "facts" / "md5.json"
PACKAGES = ("baxter_core_msgs", "control_msgs", "vision_msgs")
SYSTEM_PACKAGES = ("actionlib_msgs", "geometry_msgs", "sensor_msgs", "std_msgs", "trajectory_msgs")

HEADER_AND_ID = "Header header\nactionlib_msgs/GoalID goal_id\n"
HEADER_AND_STATUS = "Header header\nactionlib_msgs/GoalStatus status\n"


def system_message_folder(package):
    """Folder of a system package's .msg files: first hit in the sourced workspaces, /opt/ros, /usr."""
    prefixes = [p for p in os.environ.get("CMAKE_PREFIX_PATH", "").split(os.pathsep) if p]
    prefixes += sorted(str(p) for p in pathlib.Path("/opt/ros").glob("*")) + ["/usr"]
    for prefix in prefixes:
        folder = pathlib.Path(prefix) / "share" / package / "msg"
        if next(folder.glob("*.msg"), None):
            return folder
    raise FileNotFoundError(f"no .msg files of {package} below {prefixes}; on Debian: ros-{package.replace('_', '-')}")


def search_path():
    """Folders in which genmsg looks for embedded types. The tested packages come from interfaces/ only."""
    folders = {package: [str(system_message_folder(package))] for package in SYSTEM_PACKAGES}
    folders.update({package: [str(INTERFACES / package / "msg")] for package in PACKAGES})
    return folders


def action_messages(name, text):
    """The seven messages of an action, by name, as actionlib defines them. Raises ValueError unless three parts."""
    parts = [[]]
    for line in text.splitlines():
        if line.startswith(genmsg.base.IODELIM):
            parts.append([])
        else:
            parts[-1].append(line)
    goal, result, feedback = ("\n".join(part) + "\n" for part in parts)
    return {
        f"{name}Goal": goal,
        f"{name}Result": result,
        f"{name}Feedback": feedback,
        f"{name}ActionGoal": f"{HEADER_AND_ID}{name}Goal goal\n",
        f"{name}ActionResult": f"{HEADER_AND_STATUS}{name}Result result\n",
        f"{name}ActionFeedback": f"{HEADER_AND_STATUS}{name}Feedback feedback\n",
        f"{name}Action": f"{name}ActionGoal action_goal\n{name}ActionResult action_result\n"
                         f"{name}ActionFeedback action_feedback\n",
    }


def md5(context, folders, spec):
    msg_loader.load_depends(context, spec, folders)
    return genmsg.compute_md5(context, spec)


def action_md5s(context, folders, package, path):
    """MD5s of an action's seven messages, and of the action itself, which has that of its Action message."""
    specs = {name: msg_loader.load_msg_from_string(context, text, f"{package}/{name}")
             for name, text in action_messages(path.stem, path.read_text(encoding="utf-8")).items()}
    found = {f"{package}/{name}|msg": md5(context, folders, spec) for name, spec in specs.items()}
    found[f"{package}/{path.stem}|action"] = found[f"{package}/{path.stem}Action|msg"]
    return found


def package_md5s(package, folders):
    """MD5 of every msg, srv and action part that the package's files define, by 'package/Type|kind'."""
    found = {}
    context = genmsg.MsgContext.create_default()
    base = INTERFACES / package
    for path in sorted(base.glob("msg/*.msg")):
        spec = msg_loader.load_msg_from_file(context, str(path), f"{package}/{path.stem}")
        found[f"{package}/{path.stem}|msg"] = md5(context, folders, spec)
    for path in sorted(base.glob("srv/*.srv")):
        spec = msg_loader.load_srv_from_file(context, str(path), f"{package}/{path.stem}")
        found[f"{package}/{path.stem}|srv"] = md5(context, folders, spec)
    for path in sorted(base.glob("action/*.action")):
        found.update(action_md5s(context, folders, package, path))
    return found


def stored_md5s():
    return json.loads(STORED.read_text(encoding="utf-8"))


@unittest.skipIf(genmsg is None, "genmsg is not installed (Debian: python3-genmsg)")
class InterfaceMd5(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        folders = search_path()
        cls.computed = {}
        for package in PACKAGES:
            cls.computed.update(package_md5s(package, folders))

    def test_every_type_has_its_published_md5(self):
        stored = stored_md5s()
        for key in sorted(self.computed.keys() & stored.keys()):
            with self.subTest(key):
                self.assertEqual(self.computed[key], stored[key])

    def test_every_file_has_a_published_md5(self):
        self.assertEqual(sorted(self.computed.keys() - stored_md5s().keys()), [])

    def test_every_published_md5_has_a_file(self):
        self.assertEqual(sorted(stored_md5s().keys() - self.computed.keys()), [])


class BuildLists(unittest.TestCase):
    """A definition that CMakeLists.txt forgets would pass above and never be built."""

    def test_cmake_lists_every_definition(self):
        for package in PACKAGES:
            base = INTERFACES / package
            listed = {name for name in (base / "CMakeLists.txt").read_text(encoding="utf-8").split()
                      if name.endswith((".msg", ".srv", ".action"))}
            present = {path.name for kind in ("msg", "srv", "action") for path in base.glob(f"{kind}/*.{kind}")}
            with self.subTest(package):
                self.assertEqual(listed, present)


class StoredValues(unittest.TestCase):
    def test_sorted(self):
        self.assertEqual(list(stored_md5s()), sorted(stored_md5s()))

    @unittest.skipUnless(FACTS.is_file(), "the collection of published MD5s is not beside the repository")
    def test_agree_with_the_collection(self):
        noetic = json.loads(FACTS.read_text(encoding="utf-8"))["noetic"]
        # The collection also holds keys without a kind; they repeat the |msg entries.
        published = {key: value for key, value in noetic.items()
                     if key.split("/")[0] in PACKAGES and "|" in key}
        self.assertEqual(stored_md5s(), published)


if __name__ == "__main__":
    sys.exit(unittest.main(verbosity=2))
