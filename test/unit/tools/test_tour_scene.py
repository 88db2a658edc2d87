"""Where tables, cube and goal are in tools/demo tour."""

import math
import pathlib
import sys
import tempfile
import unittest

import yaml

REPO = pathlib.Path(__file__).resolve().parents[3]
sys.path.insert(0, str(REPO / "tools" / "lib"))

import tour_scene as scene  # noqa: E402

FLAT = REPO / "config" / "worlds" / "flat.yaml"


def depth_on(table, x, y):
    """(distance from the near edge, along it from its middle)."""
    yaw = math.radians(table.yaw_deg)
    dx, dy = x - table.x, y - table.y
    return table.depth / 2 - (math.cos(yaw) * dx + math.sin(yaw) * dy), -math.sin(yaw) * dx + math.cos(yaw) * dy


class Tasks(unittest.TestCase):
    def setUp(self):
        self.tasks = [scene.draw_task(seed) for seed in range(60)]

    def test_cube_and_goal_are_within_reach_of_an_edge(self):
        for task in self.tasks:
            for room, (x, y) in ((task.room, task.cube[:2]), (task.other, task.to[:2])):
                from_edge, along = depth_on(task.tables[room], x, y)
                self.assertTrue(0.11 < from_edge < 0.21, (room, from_edge))
                self.assertLess(abs(along), task.tables[room].width / 2 - 0.3)

    def test_the_near_edge_looks_into_the_room(self):
        for task in self.tasks:
            for room, side in scene.ROOMS.items():
                table = task.tables[room]
                before = table.place(-0.7, 0.0)
                self.assertTrue(3.6 + 0.6 < before[0] < 6.4, (room, before))
                self.assertTrue(0.6 < side * before[1] < 3.0, (room, before))
                for along in (-0.5, 0.5):
                    for from_edge in (0.0, 1.0):
                        x, y = table.place(from_edge * table.depth, along * table.width)
                        self.assertTrue(3.6 < x < 6.48 and 0.06 < side * y < 3.1, "inside of the room and before its shelf")

    def test_neighbours_leave_room_for_a_gripper(self):
        for task in self.tasks:
            for x, y, z in task.neighbours.values():
                self.assertGreater(math.dist((x, y), task.cube[:2]), 0.2)
                self.assertGreater(z, task.top)
                from_edge, along = depth_on(task.tables[task.room], x, y)
                self.assertTrue(0.05 < from_edge < task.tables[task.room].depth - 0.05)
                self.assertLess(abs(along), task.tables[task.room].width / 2 - 0.05)

    def test_seeds_differ_and_a_seed_is_always_the_same(self):
        self.assertEqual(scene.draw_task(5), scene.draw_task(5))
        self.assertEqual({"study", "kitchen"}, {task.room for task in self.tasks})
        self.assertEqual(3, len({table.yaw_deg for task in self.tasks for table in task.tables.values()}))


class World(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.file = pathlib.Path(folder.name) / "flat.yaml"

    def test_tables_and_what_waits_on_them_are_replaced_and_nothing_else(self):
        task = scene.draw_task(3)
        scene.write_world(FLAT, task, self.file)
        made, given = yaml.safe_load(self.file.read_text())["objects"], yaml.safe_load(FLAT.read_text())["objects"]
        changed = {list(new.values())[0]["name"]: list(new.values())[0] for new, old in zip(made, given) if new != old}
        self.assertEqual({"study_table", "kitchen_table", "cube", "sphere", "cone"}, set(changed) | {"cube", "sphere", "cone"})
        for room, table in task.tables.items():
            self.assertEqual(table.yaw_deg, changed[f"{room}_table"]["yaw_deg"])
            self.assertAlmostEqual(table.height, changed[f"{room}_table"]["size"][2], places=3)

    def test_a_world_without_tables_is_refused(self):
        self.file.write_text("objects: []\n")
        with self.assertRaisesRegex(ValueError, "no study_table"):
            scene.write_world(self.file, scene.draw_task(1), self.file)


if __name__ == "__main__":
    unittest.main()
