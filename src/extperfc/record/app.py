"""Command line of extperfc-record."""

import argparse
import os
import pathlib
import sys

os.environ.setdefault("OPENCV_LOG_LEVEL", "FATAL")  # read at import; our own message says what its warnings mean
import cv2  # noqa: E402

from extperfc.atomic_files import WriteError  # noqa: E402
from extperfc.record import near_duplicates  # noqa: E402
from extperfc.record.folder import FORMATS, FolderError, RecordingFolder, read_camera_yaml  # noqa: E402
from extperfc.record.frames import SourceError  # noqa: E402
from extperfc.record.recorder import HELP, Recorder  # noqa: E402
from extperfc.record.terminal import Keys, StatusLine  # noqa: E402

BAG_INTERVAL_S = 0.5

DESCRIPTION = """Records RGB-D images of objects for training, into a folder that extperfc-label opens.

Without --bag and --camera the images come from topics of the running ROS system. A recording goes on in a folder
that has images already: nothing is overwritten. Images that hardly differ from one that was kept are skipped.
"""
EPILOG = """examples:
  extperfc-record cubes                            key press, from the topics of a RealSense camera
  extperfc-record cubes --every 1                  one image per second where something changed
  extperfc-record cubes --bag kitchen.bag          a recording
  extperfc-record cubes --camera 0                 a webcam, without depth

exit status: 0 fine, 1 no images, full disk or a folder that does not fit, 2 wrong arguments
"""


def _number(low, high):
    def parse(text):
        value = float(text)
        if not low <= value <= high:
            raise argparse.ArgumentTypeError(f"must be in [{low:g}, {high:g}], not {text}")
        return value
    parse.__name__ = "number"
    return parse


def _parser():
    parser = argparse.ArgumentParser(prog="extperfc-record", description=DESCRIPTION, epilog=EPILOG,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", metavar="FOLDER", type=pathlib.Path, help="new folder, or one to go on with")
    source = parser.add_mutually_exclusive_group()
    source.add_argument("--bag", metavar="FILE", type=pathlib.Path, help="take the images of a bag")
    source.add_argument("--camera",
                        metavar="DEVICE",
                        help="take the images of a camera (0, /dev/video0) or a video file")
    parser.add_argument("--every",
                        metavar="S",
                        type=_number(0, 86400),
                        help="take images at intervals of at least S seconds; default: "
                        f"on key press from topics and cameras, {BAG_INTERVAL_S} from bags and video files")
    parser.add_argument("--count", metavar="N", type=int, help="end after N images")
    parser.add_argument(
        "--min-change",
        metavar="LEVELS",
        type=_number(0, 255),
        default=near_duplicates.DEFAULT_CHANGE,
        help=
        "grey levels by which an image must differ from every kept one in the 4 of its 32 x 24 cells that changed by "
        "the largest amounts; exposure does not count and tremor little (docs/labelling.md). 0 keeps all. "
        "Default: %(default)s")
    parser.add_argument("--format",
                        choices=FORMATS,
                        default="jpg",
                        help="of color images; png is lossless and five times as large")
    parser.add_argument("--classes", metavar="A,B", default="", help="class names for labels.txt")
    parser.add_argument("--color-topic", metavar="TOPIC", default="camera/color/image_raw", help="default: %(default)s")
    parser.add_argument("--depth-topic", metavar="TOPIC", default="camera/aligned_depth_to_color/image_raw",
                        help="aligned to color; default: %(default)s")
    parser.add_argument("--info-topic",
                        metavar="TOPIC",
                        default="camera/color/camera_info",
                        help="default: %(default)s")
    parser.add_argument("--no-depth", action="store_true", help="color only")
    parser.add_argument("--slop",
                        metavar="S",
                        type=_number(0, 10),
                        default=0.02,
                        help="largest difference between the stamps of color and "
                        "depth; default: %(default)s s")
    parser.add_argument("--camera-info",
                        metavar="FILE",
                        type=pathlib.Path,
                        help="camera.yaml of a calibration, for --camera")
    parser.add_argument("--timeout",
                        metavar="S",
                        type=_number(0.1, 3600),
                        default=5.0,
                        help="wait for the first image; default: %(default)s s")
    return parser


def _source(options):
    depth = None if options.no_depth else options.depth_topic
    if options.camera is not None:
        from extperfc.record.camera import CameraSource
        return CameraSource(options.camera, options.camera_info and read_camera_yaml(options.camera_info))
    try:
        if options.bag:
            from extperfc.record.bag import BagSource
            return BagSource(options.bag, options.color_topic, depth, options.info_topic, options.slop)
        from extperfc.record.topics import TopicSource
        return TopicSource(options.color_topic, depth, options.info_topic, options.slop)
    except ImportError as error:
        raise SourceError(f"ROS for Python is missing ({error}): run tools/setup, or source your workspace") from None


def _interval(options, source):
    """Seconds, or None for key press."""
    if options.every is not None or source.is_live:
        return options.every
    return BAG_INTERVAL_S


def _near_duplicates(options, folder, status):
    """With the images that the folder has already."""
    near, files = near_duplicates.NearDuplicates(options.min_change), folder.image_files()
    if files:
        status.say(f"going on with {len(files)} images in {folder.path}")
    if options.min_change > 0:
        for file in files:
            image = cv2.imread(str(file), cv2.IMREAD_REDUCED_COLOR_4)
            if image is not None:
                near.add(image)
    return near


def _run(options):
    source, status = _source(options), StatusLine()
    every_s = _interval(options, source)
    try:
        folder = RecordingFolder(options.folder, options.format, options.classes.split(","))
        recorder = Recorder(source, folder, _near_duplicates(options, folder, status), every_s, options.count,
                            options.timeout)
        with Keys() as keys:
            if every_s is None and not keys.is_usable():
                raise SourceError("no key can be pressed without a terminal: give --every S")
            if source.is_live:
                status.say(HELP)
            _record(recorder, keys, status)
    finally:
        source.close()
    print(f"label them: extperfc-label {options.folder}")


def _record(recorder, keys, status):
    """Ctrl+C ends a recording as q does; what was saved is named in errors as well."""
    try:
        recorder.run(keys, status)
    except KeyboardInterrupt:
        status.say(recorder.status())
    except (WriteError, FolderError, SourceError):
        if recorder.saved:
            status.say(f"{recorder.status()}; these are safe, and the same command goes on behind them")
        raise


def main(arguments=None):
    """Returns the exit status."""
    parser = _parser()
    options = parser.parse_args(arguments)
    if options.count is not None and options.count < 1:
        parser.error("--count must be positive")
    if options.camera_info and options.camera is None:
        parser.error("--camera-info belongs to --camera: topics and bags have their --info-topic")
    try:
        _run(options)
    except (SourceError, FolderError, WriteError) as error:
        print(f"extperfc-record: {error}", file=sys.stderr)
        return 1
    except KeyboardInterrupt:
        return 130
    finally:
        sys.stdout.flush()
    return 0
