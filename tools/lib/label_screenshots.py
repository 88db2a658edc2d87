"""Shows a folder of images in extperfc-label and writes images of its window: label_screenshots.py FOLDER OUTPUT. A
display is not needed; take_screenshots.py calls this."""

import os
import pathlib
import sys

os.environ["QT_QPA_PLATFORM"] = "offscreen"

from PyQt5.QtTest import QSignalSpy  # noqa: E402
from PyQt5.QtWidgets import QApplication  # noqa: E402

REPO = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(REPO / "src"))

from extperfc.label import statistics  # noqa: E402
from extperfc.label.dialogs import HelpDialog, StatisticsDialog  # noqa: E402
from extperfc.label.document import Document  # noqa: E402
from extperfc.label.folder import ImageFolder  # noqa: E402
from extperfc.label.theme import apply_theme  # noqa: E402
from extperfc.label.window import LabelWindow  # noqa: E402

LABELLED, UNLABELLED = "000019", "000020"  # of the shown images
WAIT_MS = 30000


def main():
    folder, output = map(pathlib.Path, sys.argv[1:3])
    application = QApplication([])
    apply_theme(application)

    def save(widget, name):
        widget.show()
        application.processEvents()
        widget.grab().save(str(output / f"labelling_{name}.png"))

    window = LabelWindow(Document(ImageFolder(folder)), REPO / "models" / "shapes")
    window.show()
    window.show_image(LABELLED)
    window.canvas.select({0})
    save(window, "window")
    window.show_image(UNLABELLED)
    found = QSignalSpy(window.proposer.proposed)
    window.propose()
    if not found and not found.wait(WAIT_MS):
        sys.exit("label_screenshots: the network proposed nothing; is models/shapes complete?")
    save(window, "proposals")
    save(HelpDialog(), "keys")
    save(StatisticsDialog(statistics.count(window.document)), "statistics")
    window.close()


if __name__ == "__main__":
    main()
