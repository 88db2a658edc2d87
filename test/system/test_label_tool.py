"""extperfc-label from its command line on: work without a window, a kill in the middle of an edit, and proposals
against src/detect."""

import json
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest

import cv2
import numpy

REPO = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(REPO / "src"))

from extperfc.label.boxes import Box  # noqa: E402
from extperfc.label.detector import Detector  # noqa: E402
from extperfc.label.document import Document  # noqa: E402
from extperfc.label.folder import ImageFolder  # noqa: E402

TOOL = str(REPO / "tools" / "extperfc-label")
SHAPES = REPO / "models" / "shapes"

# Labels with the mouse until it is killed: reports each box when the window's method returns, and ends in the middle
# of a drag.
VICTIM = """
import sys
from PyQt5.QtCore import QEvent, QPointF, QPoint, Qt
from PyQt5.QtGui import QMouseEvent
from PyQt5.QtTest import QTest
from PyQt5.QtWidgets import QApplication
sys.path.insert(0, sys.argv[1])
from extperfc.label.document import Document
from extperfc.label.folder import ImageFolder
from extperfc.label.window import LabelWindow
application = QApplication([])
folder = ImageFolder(sys.argv[2])
folder.lock()
window = LabelWindow(Document(folder))
window.show()
canvas = window.canvas
at = lambda x, y: QPoint(*map(round, canvas.viewport.to_view(x, y)))
def drag(x, y):
    QTest.mousePress(canvas, Qt.LeftButton, Qt.ShiftModifier, at(x, y))
    QApplication.sendEvent(canvas, QMouseEvent(QEvent.MouseMove, QPointF(at(x + 30, y + 20)), Qt.NoButton,
    Qt.LeftButton, Qt.NoModifier))
for i in range(int(sys.argv[3])):
    drag(10 + 3 * i, 10 + 2 * i)
    QTest.mouseRelease(canvas, Qt.LeftButton, Qt.NoModifier, at(40 + 3 * i, 30 + 2 * i))
    print(i + 1, flush=True)
drag(200, 150)
print("dragging", flush=True)
application.exec_()
"""


class WithFolder(unittest.TestCase):
    def setUp(self):
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.path = pathlib.Path(temporary.name) / "voc"
        (self.path / "JPEGImages").mkdir(parents=True)
        for i in range(1, 4):
            cv2.imwrite(str(self.path / "JPEGImages" / f"{i:06d}.jpg"), numpy.full((240, 320, 3), 50 * i, numpy.uint8))
        (self.path / "labels.txt").write_text("cone\n")

    def label(self, *arguments):
        environment = {
            key: value
            for key, value in os.environ.items() if key not in ("DISPLAY", "WAYLAND_DISPLAY", "QT_QPA_PLATFORM")
        }
        return subprocess.run([TOOL, *map(str, arguments)], capture_output=True, text=True, timeout=60, env=environment)

    def open(self):
        return Document(ImageFolder(self.path))


class WithoutWindow(WithFolder):
    def test_export_import_and_statistics(self):
        document, file = self.open(), self.path / "out.json"
        document.change("000001", (Box("cone", 10, 20, 60, 80, truncated=True),), "draw")
        done = self.label(self.path, "--export-coco", file, "--statistics")
        self.assertEqual((0, ""), (done.returncode, done.stderr))
        self.assertIn("1 boxes of 1 labelled images; 2 unlabelled images left out", done.stdout)
        self.assertRegex(done.stdout, r"cone +1 +1 +0 +1 ")
        self.assertEqual([10, 20, 50, 60], json.loads(file.read_text())["annotations"][0]["bbox"])
        before = document.boxes("000001")
        document.change("000001", None, "remove")
        done = self.label(self.path, "--import-coco", file)
        self.assertEqual((0, ""), (done.returncode, done.stderr))
        self.assertEqual(before, self.open().boxes("000001"))

    def test_problems_are_one_line_with_their_remedy(self):
        for arguments, expected in (((self.path / "gone",), "there is no folder"),
                                    ((self.path,), "there is no display"), ((self.path, "--image", "7"), "no image 7"),
                                    ((self.path, "--model", self.path),
                                     "no model.yaml"), ((self.path, "--import-coco", self.path / "gone.json"),
                                                        "gone.json"), ((self.path, "--export-coco",
                                                                        self.path / "gone" / "a.json"), "gone/a.json")):
            done = self.label(*arguments)
            self.assertEqual((1, 1), (done.returncode, len(done.stderr.splitlines())), done.stderr)
            self.assertIn(expected, done.stderr)


class Kill(WithFolder):
    def test_every_box_survives_a_kill_in_the_middle_of_a_drag(self):
        """Twice, since the second window also goes on behind the first one's boxes and its lock."""
        wanted = 0
        for count in (4, 25):
            process = subprocess.Popen(
                ["/usr/bin/python3", "-c", VICTIM,
                 str(REPO / "src"), str(self.path),
                 str(count)],
                text=True,
                stdout=subprocess.PIPE,
                stderr=subprocess.DEVNULL,
                env={**os.environ, "QT_QPA_PLATFORM": "offscreen"})
            self.addCleanup(process.stdout.close)
            self.assertEqual([*map(str, range(1, count + 1)), "dragging"],
                             [process.stdout.readline().strip() for _ in range(count + 1)])
            name = "000001" if wanted == 0 else "000002"  # the first unlabelled one
            self.assertIn("another extperfc-label", self.label(self.path, "--statistics").stderr)
            process.kill()
            process.wait()
            document = self.open()
            wanted += count
            self.assertEqual(wanted, sum(len(document.boxes(one)) for one in document.names))
            self.assertEqual(count, len(document.boxes(name)))
            self.assertEqual((10, 10, 40, 30), document.boxes(name)[0].corners)
            self.assertEqual({}, document.damaged)

    def test_a_kill_between_or_during_writes_leaves_whole_files(self):
        process = subprocess.Popen(
            ["/usr/bin/python3", "-c", VICTIM,
             str(REPO / "src"), str(self.path), "1000"],
            text=True,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            env={**os.environ, "QT_QPA_PLATFORM": "offscreen"})
        self.addCleanup(process.stdout.close)
        for _ in range(12):
            line = process.stdout.readline()
        process.kill()
        process.wait()
        reported = [int(line), *map(int, process.stdout.read().split())][-1]
        document = self.open()
        self.assertEqual({}, document.damaged)
        self.assertIn(len(document.boxes("000001")), (reported, reported + 1))


class Proposals(unittest.TestCase):
    def test_boxes_are_those_of_the_detector_in_cpp(self):
        """On rendered images, with a threshold at which both find many."""
        with tempfile.TemporaryDirectory() as folder:
            subprocess.run([
                REPO / "tools" / "extperfc-render", f"{folder}/voc", "--count", "3", "--seed", "11", "--size", "320x240"
            ],
                           check=True,
                           capture_output=True,
                           timeout=120)
            network, total = Detector(SHAPES), 0
            for file in sorted(pathlib.Path(folder, "voc", "JPEGImages").iterdir()):
                done = subprocess.run(
                    [REPO / "tools" / "extperfc-model", "run", SHAPES, file, "--backend", "opencv", "--score", "0.05"],
                    check=True,
                    capture_output=True,
                    text=True,
                    timeout=60)
                expected = [(row[0], *map(float, row[1:]))
                            for row in re.findall(r"^(\w+) +([\d.]+) +" + r"(-?[\d.]+) +" * 3 +
                                                  r"(-?[\d.]+)$", done.stdout, re.M)]
                found = [(name, score, *corners)
                         for name, score, corners in network.detect(cv2.imread(str(file)), 0.05)]
                self.assertEqual([row[0] for row in expected], [row[0] for row in found], done.stdout)
                for ours, theirs in zip(found, expected):
                    numpy.testing.assert_allclose(ours[1:2], theirs[1:2], atol=0.01)
                    numpy.testing.assert_allclose(ours[2:], theirs[2:], atol=0.2)
                total += len(found)
            self.assertGreater(total, 5)


if __name__ == "__main__":
    unittest.main()
