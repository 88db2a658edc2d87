"""tools/extperfc-model as a user calls it."""

import pathlib
import re
import shutil
import subprocess
import tempfile
import unittest

REPO = pathlib.Path(__file__).resolve().parents[2]
SHAPES = REPO / "models" / "shapes"


def tool(*arguments):
    return subprocess.run([REPO / "tools" / "extperfc-model", *map(str, arguments)], capture_output=True, text=True,
                          timeout=120)


class ModelTool(unittest.TestCase):
    def test_help_and_usage(self):
        done = tool("--help")
        self.assertEqual(0, done.returncode)
        self.assertIn("check FOLDER", done.stdout)
        for arguments in ((), ("check",), ("nonsense", "x"), ("check", SHAPES, "--nonsense")):
            done = tool(*arguments)
            self.assertEqual(2, done.returncode, arguments)
            self.assertEqual(1, len(done.stderr.strip().splitlines()), done.stderr)

    def test_missing_folder_is_named(self):
        done = tool("check", "/no/such/folder")
        self.assertEqual(1, done.returncode)
        self.assertIn("/no/such/folder", done.stderr + done.stdout)

    def test_default_model_is_good(self):
        done = tool("check", SHAPES)
        self.assertEqual(0, done.returncode, done.stdout + done.stderr)
        for text in ("shapes", "cone", "cube", "sphere", "opencv"):
            self.assertIn(text, done.stdout)

    def test_every_problem_of_a_broken_model_at_once(self):
        with tempfile.TemporaryDirectory() as folder:
            copy = pathlib.Path(folder) / "model"
            shutil.copytree(SHAPES, copy)
            text = (copy / "model.yaml").read_text()
            text = re.sub(r"sha256: \w+", "sha256: " + "0" * 64, text)
            text = text.replace("yolo_v8", "yolo_v99") + "nonsense: 1\n"
            (copy / "model.yaml").write_text(text)
            done = tool("check", copy)
        self.assertEqual(1, done.returncode)
        for text in ("yolo_v99", "nonsense"):
            self.assertIn(text, done.stdout + done.stderr)

    def test_wrong_checksum_and_damaged_network(self):
        for damage, expected in ((b"x", "instead of"), (None, "ONNX")):
            with tempfile.TemporaryDirectory() as folder, self.subTest(expected):
                copy = pathlib.Path(folder) / "model"
                shutil.copytree(SHAPES, copy)
                network = copy / "shapes.onnx"
                if damage:
                    network.write_bytes(network.read_bytes() + damage)
                else:
                    network.write_bytes(network.read_bytes()[:5000])
                    text = (copy / "model.yaml").read_text()
                    (copy / "model.yaml").write_text(re.sub(r"sha256: \w+\n", "", text))
                done = tool("check", copy)
                self.assertEqual(1, done.returncode)
                self.assertIn(expected, done.stdout + done.stderr)

    def test_runs_on_an_image(self):
        with tempfile.TemporaryDirectory() as folder:
            subprocess.run([REPO / "tools" / "extperfc-render", folder, "--sequence", "--count", "2", "--seed", "11"],
                           check=True, stdout=subprocess.DEVNULL)
            annotated = pathlib.Path(folder) / "out.png"
            done = tool("run", SHAPES, pathlib.Path(folder) / "rgb" / "000001.png", "--out", annotated)
            self.assertEqual(0, done.returncode, done.stderr)
            self.assertRegex(done.stdout, r"(cone|cube|sphere)")
            self.assertGreater(annotated.stat().st_size, 1000)


if __name__ == "__main__":
    unittest.main()
