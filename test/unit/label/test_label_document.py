#!/usr/bin/python3
"""The labelled folder while it is edited: history, saving, filters, statistics, edits of boxes, zoom and pan."""

import pathlib
import random
import shutil
import sys
import tempfile
import unittest

import cv2
import numpy

REPO = pathlib.Path(__file__).resolve().parents[3]
sys.path.insert(0, str(REPO / "src"))

from extperfc.label import boxes, editing, filters, shortcuts, statistics  # noqa: E402
from extperfc.label.boxes import Box  # noqa: E402
from extperfc.label.document import Document  # noqa: E402
from extperfc.label.folder import ImageFolder  # noqa: E402
from extperfc.label.viewport import Viewport  # noqa: E402

SIZE = (160, 120)


class WithFolder(unittest.TestCase):
    COUNT = 4

    def setUp(self):
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.path = pathlib.Path(temporary.name)
        for i in range(1, self.COUNT + 1):
            cv2.imwrite(str(self.path / f"{i}.png"), numpy.zeros((SIZE[1], SIZE[0], 3), numpy.uint8))

    def open(self):
        return Document(ImageFolder(self.path))

    def state(self, document):
        return {name: document.boxes(name) if document.is_labelled(name) else None for name in document.names}


class History(WithFolder):
    def test_every_change_is_on_the_disk_at_once(self):
        document = self.open()
        for count in range(1, 6):
            document.change("1", [Box("cone", i, i, i + 20, i + 20) for i in range(count)], "draw")
            self.assertEqual(document.boxes("1"), self.open().boxes("1"))

    def test_random_edits_are_undone_and_done_again_exactly(self):
        seed = 5
        rng, document = random.Random(seed), self.open()
        states = [self.state(document)]
        for _ in range(300):
            name = rng.choice(document.names)
            wanted = rng.choice(
                (None, (), [Box(rng.choice("ab"), x, x, x + 9, x + 9) for x in rng.sample(range(90), 3)]))
            if document.change(name, wanted, "edit"):
                states.append(self.state(document))
        self.assertGreater(len(states), 200, f"seed {seed}")
        for state in reversed(states[:-1]):
            document.undo()
            self.assertEqual(state, self.state(document), f"seed {seed}")
        self.assertIsNone(document.undo())
        self.assertEqual(states[0], self.state(self.open()), "on the disk")
        for state in states[1:]:
            document.redo()
            self.assertEqual(state, self.state(document), f"seed {seed}")
        self.assertIsNone(document.redo())
        self.assertEqual(states[-1], self.state(self.open()), "on the disk")

    def test_a_change_after_undo_ends_what_could_be_done_again(self):
        document = self.open()
        document.change("1", (), "a")
        document.undo()
        document.change("2", (), "b")
        self.assertIsNone(document.next_redo)
        self.assertEqual(("2", "b"), (document.next_undo.name, document.next_undo.title))

    def test_equal_boxes_make_no_step_and_steps_with_a_key_are_merged(self):
        document = self.open()
        document.change("1", (Box("a", 0, 0, 9, 9),), "draw")
        self.assertFalse(document.change("1", (Box("a", 0, 0, 9, 9),), "move"))
        for x in range(1, 8):
            document.change("1", (Box("a", x, 0, x + 9, 9),), "move", ("move", (0,)))
        self.assertEqual(0, document.undo().before[0].x0)
        self.assertEqual((Box("a", 0, 0, 9, 9),), document.boxes("1"))
        document.redo()
        self.assertEqual(7, document.boxes("1")[0].x0)

    def test_unlabelled_is_not_the_same_as_without_objects(self):
        document = self.open()
        document.change("1", (), "empty")
        self.assertTrue(self.open().is_labelled("1"))
        document.undo()
        self.assertFalse(self.open().is_labelled("1"))

    def test_header_and_unknown_elements_of_a_file_survive_edits(self):
        document = self.open()
        document.change("1", (Box("a", 0, 0, 9, 9),), "draw")
        file = self.path / "Annotations" / "1.xml"
        file.write_text(file.read_text().replace("extperfc-label</database>",
                                                 "by hand</database>").replace("<pose>", "<part/><pose>"))
        document = self.open()
        document.change("1", (*document.boxes("1"), Box("b", 5, 5, 20, 20)), "draw")
        self.assertIn("<database>by hand</database>", file.read_text())
        self.assertIn("<part />", file.read_text())

    def test_boxes_beyond_the_image_are_clipped(self):
        document = self.open()
        document.change("1", (Box("a", 0, 0, 9, 9),), "draw")
        file = self.path / "Annotations" / "1.xml"
        file.write_text(file.read_text().replace("<xmax>9<", "<xmax>900<").replace("<ymin>1<", "<ymin>-4<"))
        self.assertEqual((0, 0, SIZE[0], 9), self.open().boxes("1")[0].corners)


class Faults(WithFolder):
    def test_what_cannot_be_saved_stays_and_is_tried_again(self):
        document = self.open()
        (self.path / "Annotations").write_text("a file in the place of the folder")
        document.change("1", (Box("a", 0, 0, 9, 9),), "draw")
        document.change("2", (Box("b", 0, 0, 9, 9),), "draw")
        self.assertEqual({"1", "2"}, set(document.unsaved))
        self.assertIn("Annotations", document.unsaved["1"])
        self.assertFalse(document.retry())
        (self.path / "Annotations").unlink()
        self.assertTrue(document.retry())
        again = self.open()
        self.assertEqual(("a", "b"), (again.boxes("1")[0].name, again.boxes("2")[0].name))

    def test_the_next_change_saves_the_rest(self):
        document = self.open()
        (self.path / "Annotations").write_text("")
        document.change("1", (), "empty")
        (self.path / "Annotations").unlink()
        document.change("2", (), "empty")
        self.assertEqual({}, document.unsaved)
        self.assertTrue(self.open().is_labelled("1"))

    def test_a_damaged_file_is_reported_and_kept_under_another_name(self):
        (self.path / "Annotations").mkdir()
        file = self.path / "Annotations" / "2.xml"
        file.write_text("<annotation><obj")
        document = self.open()
        self.assertIn("2.xml", document.damaged["2"])
        document.change("2", (Box("a", 0, 0, 9, 9),), "draw")
        self.assertEqual("<annotation><obj", file.with_suffix(".xml.damaged").read_text())
        self.assertEqual({}, self.open().damaged)

    def test_a_damaged_image_is_a_reason_and_no_crash(self):
        (self.path / "2.png").write_bytes(b"no image")
        document = self.open()
        document.change("2", (), "empty")
        self.assertIn("2.png", document.unsaved["2"])
        (self.path / "Annotations").mkdir(exist_ok=True)
        (self.path / "Annotations" / "2.xml").write_text(
            "<annotation><object><name>a</name><bndbox><xmin>1</xmin><ymin>1</ymin>"
            "<xmax>9</xmax><ymax>9</ymax></bndbox>"
            "</object></annotation>")
        self.assertIn("2.png", self.open().damaged["2"])

    def test_leftovers_of_a_killed_write_do_not_matter(self):
        document = self.open()
        document.change("1", (Box("a", 0, 0, 9, 9),), "draw")
        shutil.copy(self.path / "Annotations" / "1.xml", self.path / "Annotations" / ".1.xml.abc.partial")
        self.assertEqual(document.boxes("1"), self.open().boxes("1"))


class Filters(WithFolder):
    def setUp(self):
        super().setUp()
        self.document = self.open()
        self.document.change("1", (Box("cone", 0, 0, 9, 9, difficult=True), Box("cone", 50, 50, 90, 90)), "draw")
        self.document.change("3", (), "empty")

    def test_each_filter(self):
        for choice, expected in ((filters.ALL, ["1", "2", "3", "4"]), (filters.UNLABELLED, ["2", "4"]),
                                 (filters.LABELLED, ["1", "3"]), (filters.EMPTY, ["3"]), (filters.DIFFICULT, ["1"]),
                                 (filters.TRUNCATED, []), ("with cone", ["1"])):
            self.assertEqual(expected, filters.shown(self.document, choice), choice)
            self.assertIn(choice, filters.choices(self.document.classes()))
        self.assertEqual(["3"], filters.shown(self.document, filters.LABELLED, "3"))

    def test_next_unlabelled_goes_round(self):
        self.assertEqual("2", filters.next_unlabelled(self.document, "1"))
        self.assertEqual("2", filters.next_unlabelled(self.document, "4"))
        self.assertEqual("4", filters.next_unlabelled(self.document, "1", -1))
        for name in ("2", "4"):
            self.document.change(name, (), "empty")
        self.assertIsNone(filters.next_unlabelled(self.document, "1"))

    def test_statistics(self):
        found = statistics.count(self.document)
        self.assertEqual((4, 2, 1, 2), (found.images, found.labelled, found.empty, found.boxes))
        cone = found.by_class["cone"]
        self.assertEqual((2, 1, 1, 1, 24.5), (cone.boxes, cone.images, cone.difficult, cone.small, cone.median_side_px))
        self.assertIn("cone       2       1", statistics.as_text(found))


class Edits(unittest.TestCase):
    A, B = Box("a", 10, 10, 50, 50), Box("b", 20, 20, 30, 30)

    def test_a_press_takes_the_smallest_box_and_edges_of_the_selected_one(self):
        both = (self.A, self.B)
        self.assertEqual((1, frozenset()), editing.hit(both, set(), 25, 25, 3))
        self.assertEqual((0, frozenset()), editing.hit(both, set(), 12, 12, 3))
        self.assertEqual((0, frozenset({"left", "top"})), editing.hit(both, {0}, 9, 12, 3))
        self.assertEqual((0, frozenset({"right"})), editing.hit(both, {0}, 51, 30, 3))
        self.assertEqual((0, frozenset({"bottom"})), editing.hit(both, {0, 1}, 40, 49, 3))
        self.assertIsNone(editing.hit(both, {0}, 90, 90, 3))

    def test_boxes_move_together_and_stay_in_the_image(self):
        moved = editing.shifted((self.A, self.B), {0, 1}, -50, 500, SIZE)
        self.assertEqual((0, 80, 40, 120), moved[0].corners)
        self.assertEqual((10, 90, 20, 100), moved[1].corners)

    def test_edges_do_not_cross(self):
        self.assertEqual((48, 10, 50, 50), boxes.resized(self.A, {"left"}, 99, 0, *SIZE).corners)
        self.assertEqual((10, 10, 160, 12), boxes.resized(self.A, {"right", "bottom"}, 999, -99, *SIZE).corners)

    def test_flags_are_set_on_all_then_cleared(self):
        one = editing.with_flag_toggled((self.A, self.B), {0}, "difficult")
        both = editing.with_flag_toggled(one, {0, 1}, "difficult")
        self.assertEqual([True, True], [box.difficult for box in both])
        self.assertEqual([False, False],
                         [box.difficult for box in editing.with_flag_toggled(both, {0, 1}, "difficult")])

    def test_pasting_clips_and_does_not_double(self):
        pasted, added = editing.with_added((self.A,),
                                           (self.A, self.B, Box("c", 150, 0, 400, 50), Box("d", 500, 0, 600, 50)), SIZE)
        self.assertEqual(["a", "b", "c"], [box.name for box in pasted])
        self.assertEqual((150, 0, 160, 50), pasted[2].corners)
        self.assertEqual({1, 2}, added)

    def test_drawing_in_any_direction_and_too_small(self):
        self.assertEqual((10, 20, 31, 40), editing.drawn("a", (30.6, 39.7), (10.2, 20.4), SIZE).corners)
        self.assertEqual((0, 0, 160, 120), editing.drawn("a", (-9, -9), (999, 999), SIZE).corners)
        self.assertIsNone(editing.drawn("a", (10, 10), (11, 40), SIZE))

    def test_overlap(self):
        self.assertEqual(100 / 1600, boxes.iou(self.A, self.B))
        self.assertEqual(0, boxes.iou(self.B, Box("c", 30, 20, 40, 30)))
        near = Box("a", 11, 10, 50, 50)
        self.assertEqual([self.B], boxes.without_known([near, self.B, self.B], [self.A]))


class Viewing(unittest.TestCase):
    def viewport(self):
        port = Viewport()
        port.set_view(800, 600)
        port.set_image(640, 480)
        return port

    def test_points_come_back(self):
        port = self.viewport()
        port.zoom(3.7, (100, 200))
        port.pan(13, -8)
        for point in ((0, 0), (639, 479), (33.3, 44.4)):
            for a, b in zip(point, port.to_image(*port.to_view(*point))):
                self.assertAlmostEqual(a, b)

    def test_zoom_keeps_the_point_under_the_pointer(self):
        port = self.viewport()
        before = port.to_image(300, 250)
        port.zoom(2.0, (300, 250))
        for a, b in zip(before, port.to_image(300, 250)):
            self.assertAlmostEqual(a, b)

    def test_fitted_image_follows_the_window_and_a_zoomed_one_does_not(self):
        port = self.viewport()
        port.set_view(400, 600)
        self.assertLess(port.to_view(640, 0)[0], 400)
        port.zoom(2)
        scale = port.scale
        port.set_view(800, 600)
        self.assertEqual(scale, port.scale)
        port.set_image(640, 480)
        self.assertEqual(scale, port.scale, "the same size keeps the zoom")
        port.set_image(320, 240)
        self.assertNotEqual(scale, port.scale)

    def test_the_image_cannot_be_lost(self):
        port = self.viewport()
        port.pan(1e6, -1e6)
        x, y = port.to_image(800 - 1, 1)
        self.assertTrue(0 <= x <= 640 and 0 <= y <= 480, (x, y))
        port.zoom(1e9)
        self.assertLessEqual(port.scale, 40)
        port.zoom(1e-9)
        self.assertGreater(port.scale, 0.05)


class Keys(unittest.TestCase):
    def test_no_key_has_two_meanings(self):
        keys = [key for row in shortcuts.SHORTCUTS for key in row.keys]
        self.assertEqual(len(keys), len(set(keys)))

    def test_the_page_lists_every_key(self):
        page = (REPO / "docs" / "labelling.md").read_text()
        for row in shortcuts.SHORTCUTS:
            with self.subTest(row.text):
                self.assertIn(f"| {shortcuts.keys_text(row)} | {row.text} |", page)


if __name__ == "__main__":
    unittest.main()
