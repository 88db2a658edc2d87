#!/usr/bin/python3
"""The labelling window, with mouse and keys as a user has them, on an invisible screen."""

import os
import pathlib
import sys
import tempfile
import time
import unittest
from unittest import mock

os.environ["QT_QPA_PLATFORM"] = "offscreen"

import cv2  # noqa: E402
import numpy  # noqa: E402
from PyQt5.QtCore import QEvent, QPoint, QPointF, Qt  # noqa: E402
from PyQt5.QtGui import QMouseEvent  # noqa: E402
from PyQt5.QtTest import QSignalSpy, QTest  # noqa: E402
from PyQt5.QtWidgets import QApplication, QInputDialog, QMessageBox  # noqa: E402

REPO = pathlib.Path(__file__).resolve().parents[3]
sys.path.insert(0, str(REPO / "src"))

from extperfc.label import dialogs, filters, shortcuts, statistics, theme  # noqa: E402
from extperfc.label.boxes import Box  # noqa: E402
from extperfc.label.document import Document  # noqa: E402
from extperfc.label.folder import ImageFolder  # noqa: E402
from extperfc.label.window import LabelWindow  # noqa: E402

SIZE = (320, 240)
MODEL = REPO / "models" / "shapes"


def setUpModule():
    global application
    application = QApplication([])
    theme.apply_theme(application)


class WithWindow(unittest.TestCase):
    def setUp(self):
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.path = pathlib.Path(temporary.name)
        for i in range(1, 5):
            cv2.imwrite(str(self.path / f"{i}.png"), numpy.full((SIZE[1], SIZE[0], 3), 50 * i, numpy.uint8))
        (self.path / "labels.txt").write_text("cone\ncube\nsphere\n")
        self.window = self.open()

    def until(self, condition):
        """Another thread's signal is seen by a spy before the window's own slot has run."""
        end = time.monotonic() + 20
        while not condition() and time.monotonic() < end:
            QTest.qWait(10)
        self.assertTrue(condition())

    def open(self, model=None):
        window = LabelWindow(Document(ImageFolder(self.path)), model)
        window.show()
        QTest.qWaitForWindowExposed(window)
        self.addCleanup(window.close)
        return window

    def boxes(self, name=None):
        return self.window.document.boxes(name or self.window.current)

    def saved(self, name=None):
        """The boxes that another program finds on the disk."""
        return Document(ImageFolder(self.path)).boxes(name or self.window.current)

    def at(self, x, y):
        return QPoint(*map(round, self.window.canvas.viewport.to_view(x, y)))

    def press(self, x, y, modifiers=Qt.NoModifier):
        QTest.mousePress(self.window.canvas, Qt.LeftButton, modifiers, self.at(x, y))

    def move(self, x, y):
        self.move_on_screen(self.at(x, y))

    def move_on_screen(self, point, button=Qt.LeftButton):
        """QTest.mouseMove asks the screen for a pointer, which an invisible one has not."""
        event = QMouseEvent(QEvent.MouseMove, QPointF(point), Qt.NoButton, button, Qt.NoModifier)
        QApplication.sendEvent(self.window.canvas, event)

    def release(self, x, y):
        QTest.mouseRelease(self.window.canvas, Qt.LeftButton, Qt.NoModifier, self.at(x, y))

    def drag(self, start, end, modifiers=Qt.NoModifier):
        self.press(*start, modifiers)
        self.move((start[0] + end[0]) / 2, (start[1] + end[1]) / 2)
        self.move(*end)
        self.release(*end)

    def click(self, x, y, modifiers=Qt.NoModifier):
        QTest.mouseClick(self.window.canvas, Qt.LeftButton, modifiers, self.at(x, y))

    def key(self, key, modifiers=Qt.NoModifier):
        QTest.keyClick(self.window.canvas, key, modifiers)

    def assert_corners(self, expected, box, tolerance=1):
        for wanted, found in zip(expected, box.corners):
            self.assertLessEqual(abs(wanted - found), tolerance, (expected, box.corners))


class Mouse(WithWindow):
    def test_draws_moves_and_resizes_and_saves_each_time(self):
        self.drag((40, 50), (120, 130))
        self.assert_corners((40, 50, 120, 130), self.saved()[0])
        self.assertEqual("cone", self.saved()[0].name)
        self.drag((80, 90), (100, 100))
        self.assert_corners((60, 60, 140, 140), self.saved()[0])
        self.drag((140, 140), (200, 180))
        self.assert_corners((60, 60, 200, 180), self.saved()[0])
        self.assertEqual(1, len(self.saved()))

    def test_drawing_beyond_the_image_is_clipped_and_a_click_draws_nothing(self):
        self.drag((300, 200), (900, 900))
        self.assert_corners((300, 200, *SIZE), self.saved()[0])
        self.click(50, 50)
        self.assertEqual((1, set()), (len(self.boxes()), self.window.canvas.selection))

    def test_shift_draws_on_top_of_a_box(self):
        self.drag((40, 40), (200, 200))
        self.drag((80, 80), (120, 120), Qt.ShiftModifier)
        self.assertEqual(2, len(self.saved()))

    def test_ctrl_selects_more_and_they_move_together(self):
        self.drag((20, 20), (60, 60))
        self.drag((100, 20), (140, 60))
        self.click(40, 40)
        self.click(120, 40, Qt.ControlModifier)
        self.assertEqual({0, 1}, self.window.canvas.selection)
        self.drag((40, 40), (50, 80))
        self.assert_corners((30, 60, 70, 100), self.saved()[0])
        self.assert_corners((110, 60, 150, 100), self.saved()[1])

    def test_escape_ends_a_drag_without_a_trace(self):
        self.drag((20, 20), (60, 60))
        before = self.boxes()
        self.press(40, 40)
        self.move(100, 100)
        self.key(Qt.Key_Escape)
        self.release(100, 100)
        self.assertEqual(before, self.boxes())
        self.assertEqual(before, self.window.canvas.boxes)

    def test_boxes_are_right_when_zoomed(self):
        self.key(Qt.Key_Plus)
        self.key(Qt.Key_Plus)
        self.assertGreater(self.window.canvas.viewport.scale, 2)
        self.drag((120, 90), (180, 140))
        self.assert_corners((120, 90, 180, 140), self.saved()[0])
        self.key(Qt.Key_0)
        self.assertTrue(self.window.canvas.viewport.fitted)

    def test_the_middle_button_moves_the_view(self):
        port, canvas = self.window.canvas.viewport, self.window.canvas
        x = port.x
        QTest.mousePress(canvas, Qt.MiddleButton, Qt.NoModifier, QPoint(200, 200))
        self.move_on_screen(QPoint(240, 210), Qt.MiddleButton)
        QTest.mouseRelease(canvas, Qt.MiddleButton, Qt.NoModifier, QPoint(240, 210))
        self.assertEqual(40, port.x - x)
        self.assertEqual((), self.boxes())


class Keyboard(WithWindow):
    def test_a_whole_image_without_the_mouse(self):
        self.key(Qt.Key_2)
        self.key(Qt.Key_B)
        box = self.boxes()[0]
        self.assertEqual("cube", box.name)
        self.key(Qt.Key_Right)
        self.key(Qt.Key_Down, Qt.ShiftModifier)
        self.key(Qt.Key_Right, Qt.AltModifier)
        self.assertEqual((box.x0 + 1, box.y0 + 10, box.x1 + 2, box.y1 + 10), self.saved()[0].corners)
        for key, flag in ((Qt.Key_D, "difficult"), (Qt.Key_T, "truncated"), (Qt.Key_O, "occluded")):
            self.key(key)
            self.assertTrue(getattr(self.saved()[0], flag), flag)
        self.key(Qt.Key_3)
        self.assertEqual("sphere", self.saved()[0].name)
        self.key(Qt.Key_Delete)
        self.assertEqual((), self.saved())

    def test_pages_and_unlabelled_images(self):
        self.assertEqual("1", self.window.current)
        for key, expected in ((Qt.Key_PageDown, "2"), (Qt.Key_End, "4"), (Qt.Key_PageDown, "4"), (Qt.Key_PageUp, "3"),
                              (Qt.Key_Home, "1"), (Qt.Key_Right, "2"), (Qt.Key_Left, "1")):
            self.key(key)
            self.assertEqual(expected, self.window.current)
        self.window.document.change("2", (), "empty")
        self.key(Qt.Key_U)
        self.assertEqual("3", self.window.current)
        self.key(Qt.Key_U, Qt.ShiftModifier)
        self.assertEqual("1", self.window.current)

    def test_copies_to_the_next_image(self):
        self.drag((20, 20), (60, 60))
        self.drag((100, 20), (140, 60))
        self.key(Qt.Key_Escape)
        self.key(Qt.Key_C)
        self.assertEqual("2", self.window.current)
        self.assertEqual(self.saved("1"), self.saved("2"))
        self.click(40, 40)
        self.key(Qt.Key_C)
        self.assertEqual(self.saved("1")[:1], self.saved("3"))
        self.key(Qt.Key_End)
        self.key(Qt.Key_V, Qt.ControlModifier)
        self.assertEqual(self.saved("1")[:1], self.saved("4"))

    def test_undo_and_redo_go_across_images(self):
        self.drag((20, 20), (60, 60))
        self.key(Qt.Key_C)
        self.key(Qt.Key_PageDown)
        self.assertEqual("3", self.window.current)
        self.key(Qt.Key_Z, Qt.ControlModifier)
        self.assertEqual(("2", ()), (self.window.current, self.saved("2")))
        self.key(Qt.Key_Z, Qt.ControlModifier)
        self.assertEqual(("1", ()), (self.window.current, self.saved("1")))
        self.key(Qt.Key_Z, Qt.ControlModifier | Qt.ShiftModifier)
        self.key(Qt.Key_Y, Qt.ControlModifier)
        self.assertEqual((1, 1), (len(self.saved("1")), len(self.saved("2"))))
        self.assertEqual({0}, self.window.canvas.selection)

    def test_tab_goes_through_the_boxes(self):
        for x in (20, 100, 180):
            self.drag((x, 20), (x + 40, 60))
        self.key(Qt.Key_Escape)
        seen = []
        for _ in range(4):
            self.key(Qt.Key_Tab)
            seen.append(self.window.canvas.selection)
        self.assertEqual([{0}, {1}, {2}, {0}], seen)
        self.key(Qt.Key_Backtab, Qt.ShiftModifier)
        self.assertEqual({2}, self.window.canvas.selection)
        self.key(Qt.Key_A, Qt.ControlModifier)
        self.assertEqual({0, 1, 2}, self.window.canvas.selection)

    def test_marks_images_without_objects(self):
        self.key(Qt.Key_E)
        self.assertTrue((self.path / "Annotations" / "1.xml").exists())
        self.key(Qt.Key_E)
        self.assertFalse((self.path / "Annotations" / "1.xml").exists())
        self.drag((20, 20), (60, 60))
        self.key(Qt.Key_E)
        self.assertEqual(1, len(self.saved()))

    def test_letters_go_into_the_search(self):
        self.key(Qt.Key_F, Qt.ControlModifier)
        QTest.keyClicks(self.window.images.search, "3")
        self.assertEqual(["3"], self.window.images.model.names)
        QTest.keyClick(self.window.images.search, Qt.Key_Return)
        self.assertEqual("3", self.window.current)
        self.assertEqual("cone", self.window.canvas.current_class)

    def test_every_action_of_the_table_is_in_a_menu(self):
        shown = {action for menu in self.window.menuBar().actions() for action in menu.menu().actions()}
        for row in shortcuts.SHORTCUTS:
            if row.action:
                self.assertIn(self.window.actions_by_name[row.action], shown, row.action)
                self.assertTrue(all(not key.isEmpty() for key in self.window.actions_by_name[row.action].shortcuts()),
                                row.action)


class Lists(WithWindow):
    def test_progress_filter_and_boxes(self):
        self.drag((20, 20), (60, 60))
        self.assertEqual("1 of 4 labelled", self.window.images.progress.text())
        self.assertEqual("1 BOX IN THIS IMAGE", self.window.panel.count.text())
        combo = self.window.images.filter
        combo.setCurrentIndex(combo.findText(filters.UNLABELLED))
        combo.activated.emit(combo.currentIndex())
        self.assertEqual(["2", "3", "4"], self.window.images.model.names)
        self.key(Qt.Key_PageDown)
        self.assertEqual("2", self.window.current)

    def test_lists_choose_boxes_classes_and_images(self):
        self.drag((20, 20), (60, 60))
        self.drag((100, 20), (140, 60))
        rows = self.window.panel.boxes
        QTest.mouseClick(rows.viewport(), Qt.LeftButton, Qt.NoModifier, rows.visualItemRect(rows.item(0)).center())
        self.assertEqual({0}, self.window.canvas.selection)
        self.window.panel.classes.itemClicked.emit(self.window.panel.classes.item(1))
        self.assertEqual(["cube", "cone"], [box.name for box in self.saved()])
        self.window.images.list.clicked.emit(self.window.images.model.index(2))
        self.assertEqual("3", self.window.current)

    def test_a_new_class_goes_to_the_file(self):
        with mock.patch.object(QInputDialog, "getText", return_value=("cup", True)):
            self.key(Qt.Key_N)
        self.assertEqual("cup", self.window.canvas.current_class)
        self.assertEqual("cone\ncube\nsphere\ncup\n", (self.path / "labels.txt").read_text())

    def test_the_first_box_asks_for_its_class(self):
        (self.path / "labels.txt").unlink()
        self.window = self.open()
        with mock.patch.object(QInputDialog, "getText", return_value=("cup", True)) as asked:
            self.drag((20, 20), (60, 60))
            self.drag((100, 20), (140, 60))
        asked.assert_called_once()
        self.assertEqual(["cup", "cup"], [box.name for box in self.saved()])

    def test_dialogs_show_the_tables(self):
        self.drag((20, 20), (60, 60))
        help_dialog, counts = dialogs.HelpDialog(self.window), dialogs.StatisticsDialog(
            statistics.count(self.window.document), self.window)
        text = " ".join(label.text() for label in help_dialog.findChildren(dialogs.QLabel))
        for row in shortcuts.SHORTCUTS:
            self.assertIn(row.text.replace("'", "&#x27;"), text)
        table = counts.findChild(dialogs.QTableWidget)
        self.assertEqual(["cone", "1", "1"], [table.item(0, i).text() for i in range(3)])


class Proposals(WithWindow):
    PROPOSED = [(Box("cube", 20, 20, 60, 60), 0.9), (Box("ball", 100, 20, 140, 60), 0.6)]

    def test_one_or_all_are_accepted(self):
        self.window.canvas.show_proposals(self.PROPOSED)
        self.assertEqual((), self.saved())
        self.click(120, 40)
        self.assertEqual(["ball"], [box.name for box in self.saved()])
        self.key(Qt.Key_Return)
        self.assertEqual(["ball", "cube"], [box.name for box in self.saved()])
        self.assertEqual([], self.window.canvas.proposals)
        self.assertIn("ball\n", (self.path / "labels.txt").read_text())
        self.key(Qt.Key_Z, Qt.ControlModifier)
        self.assertEqual(["ball"], [box.name for box in self.saved()])

    def test_escape_drops_them(self):
        self.window.canvas.show_proposals(self.PROPOSED)
        self.key(Qt.Key_Escape)
        self.assertEqual(([], ()), (self.window.canvas.proposals, self.saved()))

    def test_a_network_proposes_for_the_image_that_is_shown(self):
        self.window = self.open(MODEL)
        spy = QSignalSpy(self.window.proposer.proposed)
        self.key(Qt.Key_P)
        self.until(lambda: len(spy) > 0)
        name, found = spy[0]
        self.assertEqual("1", name)
        self.until(lambda: self.window.canvas.proposals == found)

    def test_proposals_for_another_image_are_not_shown(self):
        self.window._on_proposed("2", self.PROPOSED)
        self.assertEqual([], self.window.canvas.proposals)

    def test_a_broken_model_is_a_message(self):
        (self.path / "model").mkdir()
        (self.path / "model" / "model.yaml").write_text("name: x\n")
        self.window = self.open(self.path / "model")
        self.key(Qt.Key_P)
        self.until(lambda: "model.yaml" in self.window.statusBar().currentMessage())


class Faults(WithWindow):
    def block_saving(self):
        (self.path / "Annotations").write_text("a file in the place of the folder")

    def test_a_banner_stands_until_everything_is_saved(self):
        self.block_saving()
        self.drag((20, 20), (60, 60))
        self.assertTrue(self.window.banner.isVisible())
        self.assertIn("1 image is not saved", self.window.banner.text())
        (self.path / "Annotations").unlink()
        self.window._retry.timeout.emit()
        self.assertFalse(self.window.banner.isVisible())
        self.assertEqual(1, len(self.saved()))

    def test_closing_asks_when_something_is_not_saved(self):
        self.block_saving()
        self.drag((20, 20), (60, 60))
        with mock.patch.object(QMessageBox, "question", return_value=QMessageBox.Cancel) as asked:
            self.assertFalse(self.window.close())
        asked.assert_called_once()
        (self.path / "Annotations").unlink()
        self.assertTrue(self.window.close())
        self.assertEqual(1, len(self.saved("1")))

    def test_a_damaged_image_cannot_be_labelled(self):
        (self.path / "2.png").write_bytes(b"no image")
        self.key(Qt.Key_PageDown)
        self.assertIn("2.png", self.window.statusBar().currentMessage())
        self.drag((20, 20), (60, 60))
        self.key(Qt.Key_B)
        self.key(Qt.Key_E)
        self.assertEqual((), self.boxes())
        self.assertFalse((self.path / "Annotations").exists())
        self.key(Qt.Key_PageDown)
        self.assertEqual("3", self.window.current)

    def test_a_damaged_annotation_is_a_message(self):
        (self.path / "Annotations").mkdir()
        (self.path / "Annotations" / "2.xml").write_text("<oops")
        self.window = self.open()
        self.key(Qt.Key_PageDown)
        self.assertIn("2.xml", self.window.statusBar().currentMessage())


if __name__ == "__main__":
    unittest.main()
