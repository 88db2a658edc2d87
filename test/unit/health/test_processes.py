"""Processes as the health node sees them, on this machine and in a folder like /proc."""

import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

from extperfc.health.processes import Process, ProcessTable, node_of, resolve

URI = "http://127.0.0.1:11999"


class Names(unittest.TestCase):
    def test_resolve(self):
        self.assertEqual("/a/b", resolve("b", "/a"))
        self.assertEqual("/b", resolve("b", "/"))
        self.assertEqual("/c", resolve("/c", "/a"))

    def test_nodes_and_loaders(self):
        self.assertEqual(("/m", None), node_of(["nodelet", "manager", "__name:=m"], {}))
        self.assertEqual(("/n/arm", "/n/m"), node_of(["nodelet", "load", "x/arm", "m", "a:=b", "__name:=arm"], {"ROS_NAMESPACE": "n"}))
        self.assertEqual(("/arm", "/far/m"), node_of(["nodelet", "load", "--no-bond", "x/arm", "/far/m", "__name:=arm"], {}))
        self.assertIsNone(node_of(["bash"], {}))


class Table(unittest.TestCase):
    def setUp(self):
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.root = pathlib.Path(temporary.name)
        (self.root / "uptime").write_text("1 1")

    def process(self, pid, started, *arguments, uri=URI + "/", state="S"):
        folder = self.root / str(pid)
        folder.mkdir(exist_ok=True)
        (folder / "stat").write_text(f"{pid} (a) b) {state} " + "0 " * 18 + f"{started} 0 0")
        (folder / "cmdline").write_text("\0".join(arguments) + "\0")
        (folder / "environ").write_text(f"HOME=/\0ROS_MASTER_URI={uri}\0")

    def test_nodes_of_this_master_only(self):
        self.process(5, 50, "nodelet", "manager", "__name:=m")
        self.process(6, 60, "nodelet", "load", "x/y", "m", "__name:=y")
        self.process(7, 70, "nodelet", "manager", "__name:=far", uri="http://other:11311")
        self.process(8, 80, "bash")
        self.process(9, 90, "zombie", "__name:=z", state="Z")
        self.assertEqual({"/m": Process(5, 50, "/m"), "/y": Process(6, 60, "/y", "/m")}, ProcessTable(URI, self.root).scan())

    def test_known_nodes_alone_are_looked_at(self):
        table = ProcessTable(URI, self.root)
        self.process(5, 50, "x", "__name:=m")
        self.process(6, 60, "x", "__name:=n")
        table.scan()
        self.process(7, 70, "x", "__name:=new")
        self.process(6, 60, "x", "__name:=n", state="Z")
        self.assertEqual({"/m"}, set(table.scan_known()))
        self.assertEqual({"/m", "/new"}, set(table.scan()))

    def test_a_pid_that_is_used_again_is_another_process(self):
        table = ProcessTable(URI, self.root)
        self.process(5, 50, "x", "__name:=m")
        old = table.scan()["/m"]
        self.assertTrue(table.alive(old))
        self.process(5, 51, "x", "__name:=n")
        self.assertFalse(table.alive(old))
        self.assertEqual({"/n"}, set(table.scan()))

    def test_a_process_becomes_a_node_when_it_has_replaced_its_program(self):
        table = ProcessTable(URI, self.root)
        self.process(5, 50, "python3", "roslaunch")
        self.assertEqual({}, table.scan())
        self.process(5, 50, "x", "__name:=m")
        self.assertEqual({"/m"}, set(table.scan()))

    def test_a_real_process(self):
        sleeper = [sys.executable, "-c", "import time; time.sleep(60)", "__name:=sleeper"]
        with subprocess.Popen(sleeper, env={**os.environ, "ROS_MASTER_URI": URI, "ROS_NAMESPACE": "/home"}) as child:
            table = ProcessTable(URI)
            while not (found := table.scan()):  # until the program runs
                self.assertIsNone(child.poll())
            child.kill()
            self.assertEqual({"/home/sleeper": child.pid}, {name: process.pid for name, process in found.items()})
            while table.alive(found["/home/sleeper"]):  # not yet waited for: a zombie
                pass
            self.assertEqual({}, table.scan())


if __name__ == "__main__":
    unittest.main()
