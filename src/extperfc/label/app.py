"""Command line of extperfc-label."""

import argparse
import os
import pathlib
import signal
import sys

from extperfc.atomic_files import WriteError
from extperfc.label import coco, statistics, voc
from extperfc.label.document import Document
from extperfc.label.folder import FolderError, ImageFolder
from extperfc.label.model_folder import ModelError

DESCRIPTION = """Labels the objects in the images of a folder with boxes.

FOLDER is one that extperfc-record or extperfc-render wrote (JPEGImages, Annotations, labels.txt), or any folder of
images.
Labels are Pascal VOC files in FOLDER/Annotations; each change is saved at once. Keys: F1 in the window, or
docs/labelling.md.
"""


def _parser():
    parser = argparse.ArgumentParser(prog="extperfc-label",
                                     description=DESCRIPTION,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", metavar="FOLDER", type=pathlib.Path, help="folder of images")
    parser.add_argument("--classes", metavar="A,B", help="classes to add to labels.txt")
    parser.add_argument("--model",
                        metavar="MODEL",
                        type=pathlib.Path,
                        help="model folder that proposes boxes, e.g. models/shapes")
    parser.add_argument("--image", metavar="NAME", help="image to begin with; default: the first unlabelled one")
    parser.add_argument("--import-coco",
                        metavar="FILE",
                        type=pathlib.Path,
                        help="take over a COCO file, print what was done and end")
    parser.add_argument("--replace",
                        action="store_true",
                        help="let --import-coco replace the labels of labelled images")
    parser.add_argument("--export-coco", metavar="FILE", type=pathlib.Path, help="write a COCO file and end")
    parser.add_argument("--statistics", action="store_true", help="print counts and end")
    return parser


def _import(document, options):
    done = coco.import_file(document, options.import_coco, options.replace)
    for what, why in done.skipped:
        print(f"skipped {what}: {why}")
    print(f"{options.import_coco}: {done.boxes} boxes of {done.images} images taken over, {done.replaced} replaced, "
          f"{len(done.skipped)} entries skipped")
    if document.unsaved:
        raise WriteError(next(iter(document.unsaved.values())))


def _run_headless(document, options):
    """What works without a window. Returns the exit status: 1 when an annotation file could not be read."""
    for problem in document.damaged.values():
        print(f"extperfc-label: {problem}", file=sys.stderr)
    if options.import_coco:
        _import(document, options)
    if options.export_coco:
        images, boxes = coco.export_file(document, options.export_coco)
        print(
            f"{options.export_coco}: {boxes} boxes of {images} labelled images; {len(document.names) - images} "
            f"unlabelled images "
            "left out")
    if options.statistics:
        print(statistics.as_text(statistics.count(document)), end="")
    return 1 if document.damaged else 0


def _open_window(document, options):
    if not (os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY") or os.environ.get("QT_QPA_PLATFORM")):
        raise FolderError("there is no display: log in on the desktop, use ssh -X, or work without a window (--help)")
    # Debian's OpenCV and PyQt5 use the same Qt; PyPI's brings plug-ins of another one.
    os.environ.pop("QT_QPA_PLATFORM_PLUGIN_PATH", None)
    try:
        from PyQt5.QtCore import Qt
        from PyQt5.QtWidgets import QApplication
    except ImportError:
        raise FolderError("PyQt5 is missing: apt install python3-pyqt5") from None
    from extperfc.label.theme import apply_theme
    from extperfc.label.window import LabelWindow
    signal.signal(signal.SIGINT, signal.SIG_DFL)  # Ctrl+C in the terminal ends the window; everything is saved
    QApplication.setAttribute(Qt.AA_EnableHighDpiScaling)
    application = QApplication(sys.argv[:1])
    apply_theme(application)
    window = LabelWindow(document, options.model)
    if options.image:
        window.show_image(options.image)
    window.show()
    return application.exec_()


def _run(options):
    folder = ImageFolder(options.folder)
    folder.lock()
    for name in (options.classes or "").split(","):
        if name.strip():
            folder.add_class(name)
    document = Document(folder)
    if options.image and options.image not in folder.files:
        raise FolderError(
            f"there is no image {options.image} in {folder.image_folder}: give a file's name without its suffix")
    if options.model and not (options.model / "model.yaml").is_file():
        raise ModelError(
            f"{options.model} has no model.yaml: give a model folder, e.g. models/shapes (models/README.md)")
    if options.import_coco or options.export_coco or options.statistics:
        return _run_headless(document, options)
    return _open_window(document, options)


def main(arguments=None):
    """Returns the exit status: 0 fine, 1 something is wrong with files, 2 wrong arguments."""
    options = _parser().parse_args(arguments)
    try:
        return _run(options)
    except (FolderError, WriteError, ModelError, coco.CocoError, voc.FormatError) as error:
        print(f"extperfc-label: {error}", file=sys.stderr)
        return 1
