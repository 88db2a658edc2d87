"""extperfc-record from its command line on: bags, video files, topics of a running system, kills and wrong
arguments."""

import collections
import contextlib
import io
import os
import pathlib
import signal
import subprocess
import sys
import tempfile
import threading
import time
import unittest
from unittest import mock

REPO = pathlib.Path(__file__).resolve().parents[2]
sys.path[:0] = [str(REPO / "src"), str(REPO / "tools" / "lib")]
from extperfc.record.app import main  # noqa: E402  (before OpenCV, whose messages it turns off)

import cv2  # noqa: E402
import numpy  # noqa: E402
import rosbag  # noqa: E402
import rospy  # noqa: E402
from sensor_msgs.msg import CameraInfo, Image  # noqa: E402

from ros_session import free_port  # noqa: E402

TOOL = str(REPO / "tools" / "extperfc-record")
COLOR, DEPTH, INFO = "camera/color/image_raw", "camera/aligned_depth_to_color/image_raw", "camera/color/camera_info"
MASTER = "import sys, rosmaster.main as main; main.rosmaster_main(['--core', '-p', sys.argv[1]])"
WIDTH, HEIGHT = 160, 120


def scene(seed):
    """An image that differs from those of other seeds, BGR."""
    cells = numpy.random.default_rng(seed).integers(0, 255, (6, 8, 3), numpy.uint8)
    return cv2.resize(cells, (WIDTH, HEIGHT), interpolation=cv2.INTER_NEAREST)


def image(pixels, encoding, stamp):
    message = Image(height=HEIGHT, width=WIDTH, encoding=encoding, step=pixels.nbytes // HEIGHT, data=pixels.tobytes())
    message.header.stamp = stamp
    return message


def messages(seed, stamp):
    """Color, depth (7 ms later) and camera info of a scene."""
    info = CameraInfo(height=HEIGHT,
                      width=WIDTH,
                      distortion_model="plumb_bob",
                      D=[0.0] * 5,
                      K=[150, 0, 80, 0, 150, 60, 0, 0, 1])
    info.header.stamp = stamp
    depth = image(numpy.full((HEIGHT, WIDTH), 1000 + seed, numpy.uint16), "16UC1",
                  stamp + rospy.Duration.from_sec(0.007))
    return {COLOR: image(scene(seed)[..., ::-1].copy(), "rgb8", stamp), DEPTH: depth, INFO: info}


Done = collections.namedtuple("Done", "returncode stdout stderr")


def record(*arguments):
    """The program in this process: a process of its own loads ROS and OpenCV for a second each time."""
    out, errors = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(errors), open(os.devnull) as nothing, \
            mock.patch.object(sys, "stdin", nothing):
        try:
            code = main([str(argument) for argument in arguments])
        except SystemExit as end:
            code = end.code
    return Done(code, out.getvalue(), errors.getvalue())


class WithFolder(unittest.TestCase):
    def setUp(self):
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.path = pathlib.Path(temporary.name)
        self.out = self.path / "out"

    def names(self, folder="JPEGImages"):
        return sorted(file.name for file in (self.out / folder).glob("*"))

    def assert_scene(self, seed, name):
        """The pair of this name shows the scene, color and depth."""
        found = cv2.imread(str(self.out / "JPEGImages" / f"{name}.jpg"))
        self.assertLess(numpy.abs(found.astype(int) - scene(seed)).mean(), 6, name)
        depth = cv2.imread(str(self.out / "Depth" / f"{name}.png"), cv2.IMREAD_UNCHANGED)
        self.assertEqual({1000 + seed}, set(depth.ravel()), name)


class Arguments(WithFolder):
    def test_help_and_wrong_arguments(self):
        done = subprocess.run([TOOL, "--help"], capture_output=True, text=True, timeout=60)
        self.assertEqual((0, ""), (done.returncode, done.stderr))
        for text in ("--every", "--min-change", "Default: 15.0"):
            self.assertIn(text, done.stdout)
        for arguments in ((), (self.out, "--count", "0"), (self.out, "--every", "-1"), (self.out, "--nonsense"),
                          (self.out, "--bag", "a", "--camera", "0"), (self.out, "--camera-info", "a")):
            self.assertEqual(2, record(*arguments).returncode, arguments)
        self.assertFalse(self.out.exists())

    def test_missing_sources_are_named(self):
        for arguments, expected in ((("--bag", self.path / "gone.bag"),
                                     "gone.bag"), (("--camera", self.path / "gone.avi"), "gone.avi"),
                                    (("--camera", "0", "--camera-info", self.path / "gone.yaml"), "gone.yaml")):
            done = record(self.out, *arguments)
            self.assertEqual((1, 1), (done.returncode, len(done.stderr.splitlines())), done.stderr)
            self.assertIn(expected, done.stderr)
        with mock.patch.dict(os.environ, ROS_MASTER_URI=f"http://127.0.0.1:{free_port()}"):
            done = record(self.out)
        self.assertEqual(1, done.returncode)
        self.assertIn("no ROS master", done.stderr)
        self.assertFalse(self.out.exists())


class Bags(WithFolder):
    SEEDS = (1, 1, 2, 2, 2, 3)  # one scene per second

    def setUp(self):
        super().setUp()
        self.bag = self.path / "a.bag"
        with rosbag.Bag(str(self.bag), "w") as bag:
            for i, seed in enumerate(self.SEEDS):
                for topic, message in messages(seed, rospy.Time(100 + i)).items():
                    bag.write("/" + topic, message, message.header.stamp)

    def test_pairs_of_a_bag_without_near_duplicates(self):
        done = record(self.out, "--bag", self.bag, "--classes", "cone,cube")
        self.assertEqual(0, done.returncode, done.stderr)
        self.assertIn("3 saved, 3 near duplicates skipped, 6 frames", done.stdout)
        self.assertEqual(["000001.jpg", "000002.jpg", "000003.jpg"], self.names())
        for seed in (1, 2, 3):
            self.assert_scene(seed, f"00000{seed}")
        self.assertIn("150.0", (self.out / "camera.yaml").read_text())
        self.assertEqual("cone\ncube\n", (self.out / "labels.txt").read_text())

    def test_a_second_run_adds_only_what_is_new(self):
        self.assertEqual(0, record(self.out, "--bag", self.bag, "--count", 2).returncode)
        done = record(self.out, "--bag", self.bag)
        self.assertIn("going on with 2 images", done.stdout)
        self.assertEqual(["000001.jpg", "000002.jpg", "000003.jpg"], self.names())
        self.assert_scene(3, "000003")

    def test_all_images_and_color_only(self):
        done = record(self.out, "--bag", self.bag, "--min-change", 0, "--no-depth", "--every", 2)
        self.assertEqual(3, len(self.names()), done.stdout + done.stderr)
        self.assertFalse((self.out / "Depth").exists())

    def test_a_missing_topic_lists_those_of_the_bag(self):
        done = record(self.out, "--bag", self.bag, "--depth-topic", "/depth")
        self.assertEqual(1, done.returncode)
        for text in ("no topic /depth", COLOR, "--no-depth"):
            self.assertIn(text, done.stderr)

    def test_stamps_that_never_fit_are_explained(self):
        done = record(self.out, "--bag", self.bag, "--slop", 0.001)
        self.assertEqual(1, done.returncode)
        self.assertIn("--slop", done.stderr)

    def test_another_camera_is_refused_and_nothing_changes(self):
        self.assertEqual(0, record(self.out, "--bag", self.bag).returncode)
        text = (self.out / "camera.yaml").read_text()
        (self.out / "camera.yaml").write_text(text.replace("150.0", "333.0"))
        done = record(self.out, "--bag", self.bag, "--min-change", 0)
        self.assertEqual(1, done.returncode)
        self.assertIn("another camera", done.stderr)
        self.assertEqual(3, len(self.names()))


class Cameras(WithFolder):
    def test_keys_need_a_terminal(self):
        with mock.patch("extperfc.record.camera.CameraSource") as source:
            source.return_value.is_live = True
            done = record(self.out, "--camera", "0")
        self.assertEqual(1, done.returncode)
        self.assertIn("--every", done.stderr)

    def test_a_sequence_of_images(self):
        for i in range(4):
            cv2.imwrite(str(self.path / f"frame{i}.png"), scene(i))
        done = record(self.out, "--camera", self.path / "frame%d.png", "--every", 0, "--format", "png")
        self.assertEqual(0, done.returncode, done.stderr)
        numpy.testing.assert_array_equal(scene(3), cv2.imread(str(self.out / "JPEGImages" / "000004.png")))


class Publisher:
    """Publishes a scene again and again in a thread, so that a subscriber may come at any time."""

    def __init__(self, topics=(COLOR, DEPTH, INFO)):
        self.seed, self._publishers = 1, {
            topic: rospy.Publisher(topic, CameraInfo if topic == INFO else Image, queue_size=2)
            for topic in topics
        }
        self._end = threading.Event()
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._thread.start()

    def _run(self):
        while not self._end.wait(0.03):
            for topic, message in messages(self.seed, rospy.Time.from_sec(time.time())).items():
                if topic in self._publishers:
                    self._publishers[topic].publish(message)

    def close(self):
        self._end.set()
        self._thread.join()
        for publisher in self._publishers.values():
            publisher.unregister()


class Topics(WithFolder):
    @classmethod
    def setUpClass(cls):
        port = free_port()
        os.environ.update(ROS_MASTER_URI=f"http://127.0.0.1:{port}", ROS_IP="127.0.0.1")
        os.environ.pop("ROS_HOSTNAME", None)
        home = tempfile.TemporaryDirectory()
        cls.addClassCleanup(home.cleanup)
        os.environ["ROS_HOME"] = home.name
        master = subprocess.Popen(["/usr/bin/python3", "-c", MASTER, str(port)],
                                  stdout=subprocess.DEVNULL,
                                  stderr=subprocess.DEVNULL)
        cls.addClassCleanup(lambda: (master.kill(), master.wait()))
        rospy.init_node("recorded_camera", disable_signals=True)  # waits for the master
        cls.addClassCleanup(lambda: rospy.signal_shutdown("end"))

    def publisher(self, *topics):
        publisher = Publisher(*topics)
        self.addCleanup(publisher.close)
        return publisher

    def start(self, *arguments):
        process = subprocess.Popen([TOOL, str(self.out), *map(str, arguments)],
                                   stdin=subprocess.PIPE,
                                   stdout=subprocess.PIPE,
                                   stderr=subprocess.PIPE,
                                   text=True)
        self.addCleanup(lambda: (process.kill(), process.communicate()))
        return process

    def read_until(self, process, text):
        for line in process.stdout:
            if text in line:
                return
        self.fail(f"it ended before '{text}': {process.stderr.read()}")

    def wait_for_image(self, name, deadline_s=30):
        end = time.monotonic() + deadline_s
        while name not in self.names():
            self.assertLess(time.monotonic(), end, f"no {name} within {deadline_s} s")
            time.sleep(0.02)

    def whole_names(self):
        """Images without what a killed process had begun."""
        return [name for name in self.names() if not name.startswith(".")]

    def test_a_key_takes_an_image(self):
        publisher, process = self.publisher(), self.start()
        self.read_until(process, "Space: take")
        for key, expected in ((" ", "000001.jpg"), (" ", "skipped: it differs"), ("k", "000002.jpg")):
            process.stdin.write(key)
            process.stdin.flush()
            self.read_until(process, expected)
        rest, errors = process.communicate("q", timeout=20)
        self.assertEqual((0, ""), (process.returncode, errors))
        self.assertIn("2 saved, 1 near duplicates skipped", rest)
        self.assert_scene(publisher.seed, "000001")

    def test_intervals_and_the_end_by_ctrl_c(self):
        publisher, process = self.publisher(), self.start("--every", 0, "--min-change", 0)
        self.wait_for_image("000003.jpg")
        process.send_signal(signal.SIGINT)
        rest, errors = process.communicate(timeout=20)
        self.assertEqual((0, ""), (process.returncode, errors))
        self.assertIn("label them", rest)
        for name in self.names():
            self.assert_scene(publisher.seed, name[:6])

    def test_a_kill_leaves_whole_pairs_and_the_next_run_goes_on(self):
        self.publisher()
        process = self.start("--every", 0, "--min-change", 0)
        self.wait_for_image("000005.jpg")
        process.kill()
        process.wait()
        before = self.whole_names()
        for name in before:
            self.assert_scene(1, name[:6])
        process = self.start("--every", 0, "--min-change", 0, "--count", 2)
        _, errors = process.communicate(timeout=30)
        self.assertEqual((0, ""), (process.returncode, errors))
        self.assertEqual(len(before) + 2, len(self.whole_names()))
        listed = (self.out / "ImageSets" / "Main" / "trainval.txt").read_text().split()
        self.assertEqual([name[:6] for name in self.whole_names()], listed)

    def test_missing_publishers_are_named_with_what_there_is(self):
        self.publisher((COLOR,))
        process = self.start("--every", 1, "--timeout", 1)
        _, errors = process.communicate(timeout=30)
        self.assertEqual(1, process.returncode)
        for text in (f"no publisher of /{DEPTH}", f"/{COLOR}", "--no-depth"):
            self.assertIn(text, errors)


if __name__ == "__main__":
    unittest.main()
