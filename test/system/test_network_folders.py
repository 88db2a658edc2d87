"""Networks on their way to the robot: exported, quantized, or described from another program's ONNX file, then run by
extperfc-model."""

import hashlib
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest

import numpy as np
import yaml

REPO = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(REPO / "src"))

try:
    import onnx
    import torch
    import torchvision  # noqa: F401
except ImportError as missing:
    raise unittest.SkipTest(f"{missing}: tools/setup --tests installs what training needs")

from extperfc.training.networks import NETWORKS, describe, network_error, quantize, runtimes  # noqa: E402
from extperfc.training.networks.example import example_network  # noqa: E402
from extperfc.training.networks.export import agreement, example_image, expand_shared_weights, export  # noqa: E402

torch.set_num_threads(1)
CLASSES = ("cone", "cube", "sphere")
EXPORTED = [name for name in NETWORKS if name != "yolov7_tiny_640"]  # the 320 has the same graph


def tool(name, *arguments):
    """A command-line tool; (exit code, stdout, stderr)."""
    done = subprocess.run(
        [str(REPO / "tools" / name), *map(str, arguments)], capture_output=True, text=True, timeout=200
    )
    return done.returncode, done.stdout, done.stderr


class Folders(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        place = tempfile.TemporaryDirectory()
        cls.addClassCleanup(place.cleanup)
        cls.root = pathlib.Path(place.name)


class Export(Folders):
    """All five networks with random weights."""

    def test_opencv_and_openvino_agree_and_the_detector_loads_them(self):
        for name in EXPORTED:
            with self.subTest(name):
                network = example_network(name, CLASSES)
                folder = export(network, self.root / name, CLASSES, {"score": 0.4})
                difference = agreement(folder, [example_image((640, 480))])  # PyTorch's answer is compared by export()
                print(f"{name}: largest difference {difference:.1e}")
                self.assertLess(difference, 1e-3)
                description = yaml.safe_load((folder / "model.yaml").read_text())
                content = (folder / description["file"]).read_bytes()
                self.assertEqual(hashlib.sha256(content).hexdigest(), description["sha256"])
                self.assertEqual(0.4, description["thresholds"]["score"])
                code, said, complaint = tool("extperfc-model", "check", folder)
                self.assertEqual((0, ""), (code, complaint), said)
                self.assertNotIn("FAILS", said)

    def test_equal_weights_are_tensors_of_their_own(self):
        class Twins(torch.nn.Module):
            def __init__(self):
                super().__init__()
                self.one, self.two = torch.nn.Conv2d(3, 3, 1), torch.nn.Conv2d(3, 3, 1)
                self.two.load_state_dict(self.one.state_dict())

            def forward(self, x):
                return self.two(self.one(x))
        file = self.root / "twins.onnx"
        torch.onnx.export(Twins().eval(), torch.zeros(1, 3, 8, 8), str(file), opset_version=10)

        def merged():
            return [node for node in onnx.load(str(file)).graph.node if node.op_type == "Identity"]
        self.assertTrue(merged(), "PyTorch merges no equal weights any more: expand_shared_weights() is not needed")
        expand_shared_weights(file)
        self.assertEqual([], merged())
        self.assertEqual((1, 3, 8, 8), runtimes.OpenCv(file).run(np.zeros((1, 3, 8, 8), np.float32))[0].shape)

    def test_the_command_writes_what_a_run_learned(self):
        network = example_network("squeezenet_ssd_lite", CLASSES)
        torch.save({"format": 1, "network": network.name, "class_names": CLASSES, "weights": network.state_dict()},
                   self.root / "weights.pt")
        code, said, complaint = tool("extperfc-train", "export", self.root, self.root / "model", "--score", "0.3")
        self.assertEqual((0, ""), (code, complaint), said)
        self.assertEqual(list(CLASSES), yaml.safe_load((self.root / "model/model.yaml").read_text())["classes"])
        code, _, complaint = tool("extperfc-train", "export", self.root, self.root / "model", "--score", "3")
        self.assertEqual((2, "extperfc-train: --score must be from 0 to 1, not 3\n"), (code, complaint))


class Quantization(Folders):
    """INT8."""

    def images(self, count):
        return [np.random.default_rng(seed).integers(0, 256, (48, 64, 3), np.uint8) for seed in range(count)]

    def test_int8_answers_nearly_alike_and_reports_the_loss(self):
        try:
            quantize.nncf_python()
        except network_error.NetworkError as missing:
            self.skipTest(str(missing))
        folder = export(example_network("squeezenet_ssd_lite", CLASSES), self.root / "float", CLASSES)
        asked = []

        def evaluate(where, dataset):
            asked.append((pathlib.Path(where).name, dataset))
            return {"mean_ap": 0.9 if len(asked) == 1 else 0.875}
        report = quantize.quantize(folder, self.images(20), self.root / "int8", evaluate, "test split")
        self.assertEqual([("float", "test split"), ("int8", "test split")], asked)
        self.assertAlmostEqual(0.025, report["ap_loss"])
        names = ["offsets", "logits"]
        tensor = np.random.default_rng(9).normal(size=(1, 3, 300, 300)).astype(np.float32)
        before = runtimes.OpenVino(folder / "squeezenet_ssd_lite.onnx", names).run(tensor)
        after = runtimes.OpenVino(self.root / "int8/squeezenet_ssd_lite_int8.onnx", names).run(tensor)
        for one, other in zip(before, after):
            error = np.abs(one - other).mean() / np.abs(one).mean()
            self.assertLess(error, 0.2)
            self.assertGreater(error, 1e-5, "nothing was rounded")
        code, said, complaint = tool("extperfc-model", "check", self.root / "int8", "--backend", "openvino")
        self.assertEqual((0, ""), (code, complaint), said)

    def test_bad_input_is_one_clear_error(self):
        (self.root / "empty").mkdir()
        with self.assertRaisesRegex(network_error.NetworkError, "no model.yaml"):
            quantize.quantize(self.root / "empty", [], self.root / "out")
        with self.assertRaisesRegex(network_error.NetworkError, "3 calibration images are too few: give at least 20"):
            quantize.quantize(REPO / "models/shapes", self.images(3), self.root / "out")
        with self.assertRaisesRegex(network_error.NetworkError, "cannot be run"):
            quantize.nncf_python("/nowhere/python")


class Fake(torch.nn.Module):
    """A network whose every cell says the same box: outputs of the shapes that an exporter writes."""

    def __init__(self, channels, arrange, size=64):
        super().__init__()
        self.convolution = torch.nn.Conv2d(3, len(channels), 3, 16, 1)
        torch.nn.init.zeros_(self.convolution.weight)
        self.convolution.bias.data = torch.tensor(channels, dtype=torch.float32)
        self.arrange, self.size = arrange, size

    def forward(self, images):
        return self.arrange(self.convolution(images))


def columns(x):
    """[1, 4 + C, N], as YOLOv8, v9 and v11 write it."""
    return x.flatten(2)


def rows(x):
    """[1, N, 5 + C], as YOLOv5 and v7 write it."""
    return x.flatten(2).transpose(1, 2)


class Describe(Folders):
    """ONNX files from other programs."""

    BOX = (160.0, 120.0, 100.0, 80.0)

    def write(self, name, channels, arrange, outputs, size=320, opset=12, **options):
        file = self.root / f"{name}.onnx"
        torch.onnx.export(Fake(channels, arrange).eval(), torch.zeros(1, 3, size, size), str(file), opset_version=opset,
                          input_names=["images"], output_names=outputs, **options)
        return file

    def found(self, file, *options):
        """What extperfc-model finds in a grey image of 320 x 320 after the recipe's command: (class, score, box)."""
        folder = self.root / file.stem
        code, said, complaint = tool(
            "extperfc-train", "describe", file, folder, "--classes", "cone,cube,sphere", *options
        )
        self.assertEqual((0, ""), (code, complaint), said)
        self.assertIn("opencv: works", said)
        image = self.root / "grey.ppm"
        image.write_bytes(b"P6 320 320 255\n" + bytes([114]) * 320 * 320 * 3)
        code, said, complaint = tool("extperfc-model", "run", folder, image, "--backend", "opencv")
        self.assertEqual((0, ""), (code, complaint), said)
        self.assertIn("1 detections", said)
        name, score, *box = said.split()[:6]
        return name, float(score), [float(value) for value in box]

    def check(self, file, *options):
        name, score, box = self.found(file, *options)
        self.assertEqual("cube", name)
        self.assertAlmostEqual(0.9, score, places=2)
        self.assertEqual([110, 80, 210, 160], [round(value) for value in box])

    def test_yolov8_to_v11(self):
        self.check(self.write("v8", [*self.BOX, 0.0, 0.9, 0.1], columns, ["output0"]))

    def test_yolov5_and_v7(self):
        self.check(self.write("v5", [*self.BOX, 1.0, 0.0, 0.9, 0.1], rows, ["output0"]))

    def test_raw_heads_of_yolov5_and_v7(self):
        # The first of 20 x 20 cells' three anchors says (61 * 4 * 0.25, ...): a box of 30 x 61 px in every cell.
        file = self.write("raw", [0.0] * 4 + [9.0, -9.0, 9.0, -9.0] + [-9.0] * 16, lambda x: x, ["p4"])
        code, said, complaint = tool(
            "extperfc-train", "describe", file, self.root / "raw", "--classes", "cone,cube,sphere"
        )
        self.assertEqual((0, ""), (code, complaint), said)
        output = yaml.safe_load((self.root / "raw/model.yaml").read_text())["output"]
        self.assertEqual(("yolo_anchors", [{"stride": 16, "sizes": [[30, 61], [62, 45], [59, 119]]}]),
                         (output["layout"], output["anchors"]))
        self.assertEqual(0, tool("extperfc-model", "check", self.root / "raw")[0])

    def test_ssd_with_the_background_first(self):
        corners = [110 / 320, 80 / 320, 210 / 320, 160 / 320]
        file = self.write("ssd", [0.05, 0.0, 0.9, 0.05, *corners], lambda x: (rows(x)[..., :4], rows(x)[..., 4:]),
                          ["scores", "boxes"])
        self.check(file)
        written = yaml.safe_load((self.root / "ssd/model.yaml").read_text())
        self.assertEqual(
            (["boxes", "scores"], 0, 127),
            (written["output"]["names"], written["output"]["background_class"], written["input"]["mean"]),
        )

    def refused(self, file, *options, classes="cone,cube,sphere"):
        code, _, complaint = tool("extperfc-train", "describe", file, self.root / "no", "--classes", classes, *options)
        self.assertEqual(2, code)
        self.assertEqual(1, len(complaint.splitlines()), complaint)
        self.assertFalse((self.root / "no").exists())
        return complaint

    def test_what_cannot_be_read_names_the_option_that_helps(self):
        heads = self.write("five_axes", [0.0] * 24, lambda x: x.view(1, 3, 8, 20, 20).permute(0, 1, 3, 4, 2), ["p"])
        self.assertRegex(self.refused(heads), "five axes.*--grid")
        ended = self.write("v10", [0.0] * 6, lambda x: rows(x)[:, :300], ["output0"])
        self.assertRegex(self.refused(ended), r"\[1, 300, 6\] has suppressed overlaps itself.*nms=False")
        eight = self.write("eight", [*self.BOX, 0.0, 0.9, 0.1], columns, ["output0"])
        self.assertRegex(self.refused(eight, classes="cone,cube"), r"output0 \[1, 7, 400\].*detector with 2 classes")
        dynamic = self.write("dynamic", [*self.BOX, 0.0, 0.9, 0.1], columns, ["output0"],
                             dynamic_axes={"images": {2: "height", 3: "width"}})
        self.assertRegex(self.refused(dynamic), "dynamic=False.*--size")
        self.assertRegex(self.refused(self.root / "missing.onnx"), "missing.onnx: no such file")
        self.assertRegex(self.refused(eight, classes="cone,cone"), "each once")

    def test_class_lists(self):
        text = self.root / "labels.txt"
        text.write_text("cone\ncube\n\n")
        data = self.root / "data.yaml"
        data.write_text("names: {0: cone, 1: cube}\n")
        for classes in ("cone, cube", text, data):
            self.assertEqual(["cone", "cube"], describe.read_classes(classes))


class List(unittest.TestCase):
    def test_networks_are_listed_with_their_parameters(self):
        code, said, complaint = tool("extperfc-train", "networks")
        self.assertEqual((0, ""), (code, complaint))
        for name, spec in NETWORKS.items():
            self.assertRegex(said, re.escape(name) + r" .*" + f"{spec.parameters:,}")


if __name__ == "__main__":
    unittest.main()
