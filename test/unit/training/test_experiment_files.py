"""Experiment files: every error at once, unknown keys refused, help that lists all."""

import dataclasses
import pathlib
import sys
import tempfile
import unittest

import yaml

ROOT = pathlib.Path(__file__).resolve().parents[3]
sys.path.insert(0, str(ROOT / "src"))

from extperfc.training import experiment  # noqa: E402
from extperfc.training.experiment import Experiment, ExperimentError, differences, load, make  # noqa: E402

FILE = pathlib.Path("/somewhere/mine.yaml")


def errors_of(values):
    try:
        make(values, FILE)
    except ExperimentError as error:
        return str(error)
    return ""


class Files(unittest.TestCase):
    def test_defaults_and_paths(self):
        made = make({"data": {"path": "images"}}, FILE)
        self.assertEqual(("mine", "/somewhere/runs/mine", "/somewhere/images"),
                         (made.name, made.output, made.data.path))
        self.assertEqual(Experiment().training, made.training)
        self.assertEqual("/data", make({"data": {"path": "/data"}}, FILE).data.path)

    def test_every_error_is_reported_at_once(self):
        text = errors_of({
            "data": {
                "train": "x",
                "validation": "x"
            },
            "trainign": {},
            "strategy": "magic",
            "augmentation": [],
            "training": {
                "epochs": 0,
                "learning_rat": 1,
                "deterministic": 1,
                "precision": "half"
            }
        })
        for part in ("8 errors", "trainign is unknown; did you mean training?",
                     "strategy must be one of random_weights", "training.epochs must be a whole number from 1",
                     "training.learning_rat is unknown; did you mean learning_rate?",
                     "training.deterministic must be true or false", "training.precision must be one of auto",
                     "augmentation must be a mapping", "data.path is missing"):
            self.assertIn(part, text)

    def test_numbers(self):
        for key, value in (("learning_rate", "fast"), ("learning_rate", float("nan")), ("epochs", 2.5),
                           ("epochs", True), ("batch_size", -1), ("average_decay", 1.0)):
            self.assertIn(f"training.{key} must be", errors_of({
                "data": {
                    "path": "x"
                },
                "training": {
                    key: value
                }
            }), (key, value))

    def test_numbers_that_yaml_reads_as_text(self):
        values = yaml.safe_load("{data: {path: x}, training: {learning_rate: 1e-3}}")
        self.assertEqual(0.001, make(values, FILE).training.learning_rate)

    def test_values_that_do_not_fit_each_other(self):
        self.assertIn("source is missing", errors_of({"data": {"path": "x"}, "strategy": "instance_transfer"}))
        self.assertIn("copies no weights", errors_of({"data": {"path": "x"}, "source": "w.pt"}))
        self.assertIn("same split", errors_of({"data": {"path": "x", "validation": "train"}}))
        self.assertIn("must be less than",
                      errors_of({
                          "data": {
                              "path": "x"
                          },
                          "training": {
                              "epochs": 3,
                              "warmup_epochs": 3
                          }
                      }))

    def test_files_that_cannot_be_read(self):
        with tempfile.TemporaryDirectory() as folder:
            file = pathlib.Path(folder) / "a.yaml"
            with self.assertRaisesRegex(ExperimentError, "no such file"):
                load(file)
            file.write_text("data: [")
            with self.assertRaisesRegex(ExperimentError, "cannot be read"):
                load(file)
            file.write_text("- a list")
            with self.assertRaisesRegex(ExperimentError, "the file must be a mapping"):
                load(file)

    def test_what_is_written_is_read_as_the_same(self):
        with tempfile.TemporaryDirectory() as folder:
            made = make({"data": {"path": "x", "classes": ["a", "b"]}, "training": {"epochs": 7}}, FILE)
            file = pathlib.Path(folder) / "again.yaml"
            file.write_text(yaml.safe_dump(made.as_dict()))
            self.assertEqual(made, load(file))

    def test_help_lists_every_key(self):
        def keys(cls):
            for field in dataclasses.fields(cls):
                yield field.name
                if "section" in field.metadata:
                    yield from keys(field.metadata["section"])
        for key in keys(Experiment):
            self.assertRegex(experiment.HELP, rf"(?m)^ +{key}: ")

    def test_differences_that_keep_from_resuming(self):
        one = make({"data": {"path": "x"}}, FILE).as_dict()
        other = make({"data": {"path": "x"}, "output": "o", "augmentation": {"flip": 0.1},
                      "training": {"device": "cuda", "workers": 9, "learning_rate": 0.5}}, FILE).as_dict()
        self.assertEqual(["augmentation.flip", "training.learning_rate"], differences(one, other))


if __name__ == "__main__":
    unittest.main()
