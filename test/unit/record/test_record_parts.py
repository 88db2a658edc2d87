#!/usr/bin/python3
"""Parts of the recorder: messages as images, near duplicates, the folder, decisions."""

import errno
import io
import os
import pathlib
import sys
import tempfile
import types
import unittest
from unittest import mock

import cv2
import numpy
import yaml

REPO = pathlib.Path(__file__).resolve().parents[3]
sys.path.insert(0, str(REPO / "src"))

from extperfc.atomic_files import WriteError  # noqa: E402
from extperfc.record import frames  # noqa: E402
from extperfc.record.folder import FolderError, RecordingFolder, read_camera_yaml  # noqa: E402
from extperfc.record.frames import Frame, Intrinsics, SourceError  # noqa: E402
from extperfc.record.near_duplicates import DEFAULT_CHANGE, NearDuplicates, change, signature  # noqa: E402
from extperfc.record.recorder import Recorder  # noqa: E402
from extperfc.record.terminal import Keys, StatusLine  # noqa: E402

CAMERA = Intrinsics(64, 48, (60.0, 0.0, 32.0, 0.0, 61.0, 24.0, 0.0, 0.0, 1.0), "plumb_bob", (0.1, -0.2, 0.0, 0.0, 0.0))


def message(encoding, pixels, padding=0, bigendian=False):
    rows = [row.tobytes() + bytes(padding) for row in pixels]
    return types.SimpleNamespace(encoding=encoding,
                                 width=pixels.shape[1],
                                 height=pixels.shape[0],
                                 step=len(rows[0]),
                                 data=b"".join(rows),
                                 is_bigendian=bigendian)


def scene(seed, size=(640, 480)):
    """An image with structure of all sizes."""
    rng = numpy.random.default_rng(seed)
    image = sum(
        cv2.resize(rng.uniform(0, 1, (4 << i, 5 << i, 3)), size, interpolation=cv2.INTER_CUBIC) / 2 ** i
        for i in range(5))
    return numpy.uint8(255 * (image - image.min()) / (image.max() - image.min()))


class Messages(unittest.TestCase):
    def test_color_encodings(self):
        bgr = scene(1, (6, 4))
        for encoding, pixels in (("bgr8", bgr), ("rgb8", bgr[..., ::-1]), ("bgra8", numpy.dstack([bgr, bgr[..., 0]])),
                                 ("rgba8", numpy.dstack([bgr[..., ::-1], bgr[..., 0]]))):
            for padding in (0, 5):
                numpy.testing.assert_array_equal(bgr, frames.color_of(message(encoding, pixels, padding)), encoding)
        numpy.testing.assert_array_equal(numpy.dstack([bgr[..., 0]] * 3), frames.color_of(message("mono8", bgr[...,
                                                                                                               0])))

    def test_compressed_color(self):
        image = scene(2, (32, 24))
        data = cv2.imencode(".png", image)[1].tobytes()
        numpy.testing.assert_array_equal(image, frames.color_of(types.SimpleNamespace(format="png", data=data)))
        with self.assertRaisesRegex(SourceError, "cannot be decoded"):
            frames.color_of(types.SimpleNamespace(format="jpeg", data=b"no image"))

    def test_depth_in_millimetres_and_metres(self):
        depth = numpy.uint16([[0, 1, 500], [65535, 7, 300]])
        numpy.testing.assert_array_equal(depth, frames.depth_of(message("16UC1", depth, 2)))
        numpy.testing.assert_array_equal(depth, frames.depth_of(message("16UC1", depth.astype(">u2"), 2, True)))
        metres = numpy.float32([[numpy.nan, 0.0014, 0.5], [70.0, -1.0, numpy.inf]])
        numpy.testing.assert_array_equal([[0, 1, 500], [0, 0, 0]], frames.depth_of(message("32FC1", metres)))

    def test_unusable_images_are_explained(self):
        image = numpy.zeros((4, 6), numpy.uint8)
        with self.assertRaisesRegex(SourceError, "bayer_rggb8.*image_proc"):
            frames.color_of(message("bayer_rggb8", image))
        with self.assertRaisesRegex(SourceError, "mono8.*16UC1"):
            frames.depth_of(message("mono8", image))
        short = message("bgr8", image)
        with self.assertRaisesRegex(SourceError, "defective"):
            frames.color_of(short)

    def test_depth_of_another_size_is_not_aligned(self):
        color = message("mono8", numpy.zeros((4, 6), numpy.uint8))
        color.header = types.SimpleNamespace(stamp=types.SimpleNamespace(to_sec=lambda: 1.5))
        with self.assertRaisesRegex(SourceError, "3 x 2.*6 x 4.*align_depth"):
            frames.pair(color, message("16UC1", numpy.zeros((2, 3), numpy.uint16)), None)
        self.assertEqual(1.5, frames.pair(color, message("16UC1", numpy.zeros((4, 6), numpy.uint16)), None).stamp_s)


class Alike(unittest.TestCase):
    """The threshold lies between what a resting camera and what a small moved object changes."""

    def test_noise_exposure_and_compression_are_no_change(self):
        rng, image = numpy.random.default_rng(3), scene(3)
        noisy = numpy.uint8(numpy.clip(image + rng.normal(0, 8, image.shape), 0, 255))
        darker = numpy.uint8(image * 0.8)
        packed = cv2.imdecode(cv2.imencode(".jpg", image, [cv2.IMWRITE_JPEG_QUALITY, 40])[1], cv2.IMREAD_COLOR)
        for name, other in (("noise", noisy), ("exposure", darker), ("JPEG", packed)):
            self.assertLess(change(signature(image), signature(other)), DEFAULT_CHANGE, name)

    def test_a_small_object_that_moves_is_a_change(self):
        table = numpy.full((480, 640, 3), 120, numpy.uint8)
        first, second = table.copy(), table.copy()
        cv2.circle(first, (300, 240), 18, (30, 60, 200), -1)
        cv2.circle(second, (340, 240), 18, (30, 60, 200), -1)
        self.assertGreater(change(signature(first), signature(second)), DEFAULT_CHANGE)

    def test_a_moved_camera_is_a_change_and_a_tremor_much_less(self):
        image = scene(4, (720, 480))
        moved = change(signature(image[:, :640]), signature(image[:, 80:]))
        self.assertGreater(moved, 2 * DEFAULT_CHANGE)
        self.assertLess(change(signature(image[:, :640]), signature(image[:, 4:644])), moved / 3)

    def test_new_images_are_compared_with_all_kept_ones(self):
        near = NearDuplicates()
        for seed in range(100):
            near.add(scene(seed, (160, 120)))
        for seed in (0, 50, 99):
            self.assertTrue(near.has_like(scene(seed, (160, 120))), seed)
        self.assertFalse(near.has_like(scene(200, (160, 120))))

    def test_zero_keeps_all(self):
        near = NearDuplicates(0)
        near.add(scene(1))
        self.assertFalse(near.has_like(scene(1)))

    def test_a_reduced_image_from_the_disk_counts_as_the_same(self):
        near = NearDuplicates()
        near.add(cv2.resize(scene(5), None, fx=0.25, fy=0.25, interpolation=cv2.INTER_AREA))
        self.assertLess(near.smallest_change(scene(5)), 1)


class WithFolder(unittest.TestCase):
    def setUp(self):
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.path = pathlib.Path(temporary.name) / "new" / "voc"

    def frame(self, seed=1, depth=True, camera=CAMERA, size=(64, 48), stamp_s=0.0):
        return Frame(stamp_s, scene(seed, size),
                     numpy.full(size[::-1], 1000 + seed, numpy.uint16) if depth else None, camera)

    def files(self):
        return sorted(str(file.relative_to(self.path)) for file in self.path.rglob("*") if file.is_file())


class Folder(WithFolder):
    def test_layout(self):
        folder = RecordingFolder(self.path, classes=["cone", " cube", "cone"])
        for seed in (1, 2):
            folder.write(self.frame(seed))
        self.assertEqual([
            "Depth/000001.png", "Depth/000002.png", "ImageSets/Main/trainval.txt", "JPEGImages/000001.jpg",
            "JPEGImages/000002.jpg", "camera.yaml", "labels.txt"
        ], self.files())
        depth = cv2.imread(str(self.path / "Depth" / "000002.png"), cv2.IMREAD_UNCHANGED)
        self.assertEqual((numpy.uint16, 1002), (depth.dtype, depth[0, 0]))
        self.assertEqual("cone\ncube\n", (self.path / "labels.txt").read_text())
        self.assertEqual(["000001", "000002"], (self.path / "ImageSets/Main/trainval.txt").read_text().split())
        self.assertEqual(CAMERA, read_camera_yaml(self.path / "camera.yaml"))
        self.assertEqual([60, 0, 32, 0, 0, 61, 24, 0, 0, 0, 1, 0],
                         yaml.safe_load((self.path / "camera.yaml").read_text())["projection_matrix"]["data"])

    def test_png_is_lossless_and_depth_optional(self):
        frame = self.frame(3, depth=False, camera=None)
        file = RecordingFolder(self.path, "png").write(frame)
        numpy.testing.assert_array_equal(frame.color, cv2.imread(str(file)))
        self.assertEqual(["ImageSets/Main/trainval.txt", "JPEGImages/000001.png"], self.files())

    def test_goes_on_behind_every_number_that_is_used(self):
        RecordingFolder(self.path, classes=["cone"]).write(self.frame(1))
        (self.path / "Annotations").mkdir()
        (self.path / "Annotations" / "000007.xml").write_text("")
        before = (self.path / "JPEGImages" / "000001.jpg").read_bytes()
        folder = RecordingFolder(self.path, classes=["cube"])
        self.assertEqual("000008.jpg", folder.write(self.frame(2)).name)
        self.assertEqual(before, (self.path / "JPEGImages" / "000001.jpg").read_bytes())
        self.assertEqual("cone\ncube\n", (self.path / "labels.txt").read_text())
        self.assertEqual(["000001", "000008"], (self.path / "ImageSets/Main/trainval.txt").read_text().split())

    def test_lists_images_that_a_kill_left_out(self):
        RecordingFolder(self.path).write(self.frame(1))
        (self.path / "ImageSets/Main/trainval.txt").unlink()
        RecordingFolder(self.path).write(self.frame(2))
        self.assertEqual(["000001", "000002"], (self.path / "ImageSets/Main/trainval.txt").read_text().split())

    def test_never_overwrites_what_another_program_wrote(self):
        folder = RecordingFolder(self.path)
        (self.path / "JPEGImages" / "000001.jpg").write_bytes(b"precious")
        with self.assertRaisesRegex(FolderError, "000001.jpg.*another program"):
            folder.write(self.frame(1))
        self.assertEqual(b"precious", (self.path / "JPEGImages" / "000001.jpg").read_bytes())
        self.assertFalse((self.path / "Depth" / "000001.png").exists())

    def test_a_full_disk_leaves_no_half_pair(self):
        folder = RecordingFolder(self.path)
        folder.write(self.frame(1))
        before, calls, real = self.files(), [], os.fsync

        def full_at_second(handle):
            calls.append(handle)
            if len(calls) == 2:  # depth goes first
                raise OSError(errno.ENOSPC, "No space left on device")
            real(handle)

        with mock.patch("os.fsync", side_effect=full_at_second), self.assertRaisesRegex(WriteError, "disk is full"):
            folder.write(self.frame(2))
        self.assertEqual(before, self.files())
        self.assertEqual("000002.jpg", folder.write(self.frame(2)).name)

    def test_another_camera_is_refused(self):
        RecordingFolder(self.path).write(self.frame(1))
        folder = RecordingFolder(self.path)
        with self.assertRaisesRegex(FolderError, "32 x 24.*64 x 48.*new folder"):
            folder.write(self.frame(1, camera=None, size=(32, 24)))
        other = Intrinsics(64, 48, (90.0, *CAMERA.matrix[1:]))
        with self.assertRaisesRegex(FolderError, "another camera.*60.0.*90.0"):
            folder.write(self.frame(1, camera=other))
        with self.assertRaisesRegex(FolderError, "--info-topic"):
            folder.write(self.frame(1, size=(32, 24)))
        self.assertEqual(1, len(folder.image_files()))

    def test_a_damaged_camera_file_is_named(self):
        self.path.mkdir(parents=True)
        (self.path / "camera.yaml").write_text("image_width: [")
        with self.assertRaisesRegex(FolderError, "camera.yaml is no camera file"):
            RecordingFolder(self.path)

    def test_a_file_in_its_place_is_named(self):
        self.path.parent.mkdir(parents=True)
        self.path.write_text("")
        with self.assertRaisesRegex(FolderError, "is a file"):
            RecordingFolder(self.path)


class Source:
    """Frames from a list; None stands for a frame that did not come in time."""

    is_live, info_topic = False, "camera_info"

    def __init__(self, found):
        self._found = iter(found)

    def next_frame(self, _):
        try:
            return next(self._found)
        except StopIteration:
            raise EOFError from None

    def await_intrinsics(self, _):
        return CAMERA

    def why_silent(self):
        return "no publisher of x"


class Typed:
    """Keys, one string per call."""

    def __init__(self, *typed):
        self._typed = list(typed)

    def pressed(self):
        return self._typed.pop(0) if self._typed else ""


class Decisions(WithFolder):
    def run_recorder(self, found, keys=(), **options):
        self.log = io.StringIO()
        recorder = Recorder(Source(found), RecordingFolder(self.path), NearDuplicates(), **options)
        recorder.run(Typed(*keys), StatusLine(self.log))
        return recorder

    def test_intervals_count_by_the_clock_of_the_source(self):
        found = [self.frame(i, stamp_s=0.1 * i) for i in range(10)]
        self.assertEqual(4, self.run_recorder(found, every_s=0.29).saved)

    def test_a_clock_that_jumps_back_begins_anew(self):
        found = [self.frame(i, stamp_s=stamp) for i, stamp in enumerate((100.0, 100.1, 5.0, 5.1))]
        self.assertEqual(2, self.run_recorder(found, every_s=1.0).saved)

    def test_near_duplicates_are_counted_and_the_first_change_is_taken(self):
        found = [self.frame(seed, stamp_s=i) for i, seed in enumerate((1, 1, 1, 2, 1))]
        recorder = self.run_recorder(found, every_s=0)
        self.assertEqual((2, 3, 5), (recorder.saved, recorder.alike, recorder.frames))
        self.assertIn("2 saved, 3 near duplicates skipped, 5 frames", self.log.getvalue())

    def test_keys_take_force_and_end(self):
        found = [self.frame(1, stamp_s=i) for i in range(20)]
        recorder = self.run_recorder(found, keys=("", " ", "", " ", "k", "", "q"))
        self.assertEqual((2, 1, 6), (recorder.saved, recorder.alike, recorder.frames))
        self.assertIn("k takes it anyway", self.log.getvalue())

    def test_ends_after_a_count(self):
        self.assertEqual(3, self.run_recorder([self.frame(i) for i in range(9)], every_s=0, max_count=3).saved)

    def test_the_first_image_gets_its_intrinsics(self):
        self.run_recorder([self.frame(1, camera=None)], every_s=0)
        self.assertTrue((self.path / "camera.yaml").exists())

    def test_silence_is_explained(self):
        with self.assertRaisesRegex(SourceError, "no publisher of x"):
            self.run_recorder([None] * 5, timeout_s=0.0)
        with self.assertRaisesRegex(SourceError, "no publisher of x"):
            self.run_recorder([])
        self.run_recorder([self.frame(1), None, None], timeout_s=0.0, every_s=0)
        self.assertIn("no image for", self.log.getvalue())


class Terminal(unittest.TestCase):
    def test_keys_of_a_pipe(self):
        reader, writer = os.pipe()
        with os.fdopen(reader) as stream, Keys(stream) as keys:
            self.assertTrue(keys.is_usable())
            self.assertEqual("", keys.pressed())
            os.write(writer, b" k")
            self.assertEqual(" k", keys.pressed())
            os.close(writer)
            self.assertEqual("", keys.pressed())
            self.assertFalse(keys.is_open)
        with open(os.devnull) as stream:
            self.assertFalse(Keys(stream).is_usable())

    def test_a_terminal_is_restored(self):
        import termios
        controller, terminal = os.openpty()
        with os.fdopen(terminal, "r+b", buffering=0) as stream:
            before = termios.tcgetattr(stream)
            with Keys(stream) as keys:
                self.assertNotEqual(before, termios.tcgetattr(stream))
                os.write(controller, b"q")  # without Enter
                self.assertEqual("q", keys.pressed())
            self.assertEqual(before, termios.tcgetattr(stream))
        os.close(controller)


if __name__ == "__main__":
    unittest.main()
