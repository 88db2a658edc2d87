"""Whole runs of the trainer with a tiny network."""

import json
import os
import signal
import unittest

from training_case import TrainingCase, equal, torch

from extperfc.training import experiment
from extperfc.training.data import drawn
from extperfc.training.errors import DataError, TrainingError
from extperfc.training.experiment import ExperimentError

if torch:
    import tiny_network

    from extperfc.training import trainer
    from extperfc.training.strategies import read_weights


class Runs(TrainingCase):
    def test_learning_rate_is_the_networks_where_none_is_given(self):
        for given, highest in ((0, tiny_network.TinyNetwork.learning_rate), (0.01, 0.01)):
            run = trainer.Trainer(self.make(f"rate{given}", {"epochs": 2, "learning_rate": given}), build=tiny_network.build)
            run.run()
            self.assertAlmostEqual(highest, max(row["learning_rate"] for row in run.history), delta=0.3 * highest)

    def test_learns_and_leaves_everything_to_repeat_it(self):
        run = trainer.Trainer(self.make("all", {"epochs": 8, "learning_rate": 0.01}), build=tiny_network.build)
        run.run()
        output = self.root / "all"
        self.assertLess(run.history[-1]["validation_loss"], 0.8 * run.history[0]["validation_loss"])
        self.assertEqual(
            {"weights.pt", "experiment.yaml", "provenance.json", "history.json", "curves.png", "checkpoints"},
            {file.name
             for file in output.iterdir()} - {"tensorboard"})
        record = json.loads((output / "provenance.json").read_text())
        self.assertEqual(self.data.split("train").checksum(), record["data_sha256"]["train"])
        self.assertEqual(torch.__version__, record["libraries"]["torch"])
        self.assertEqual(1, record["experiment"]["training"]["seed"])
        self.assertEqual(run.history, json.loads((output / "history.json").read_text()))
        self.assertEqual(2, len(list((output / "checkpoints").iterdir())))
        self.assertEqual(experiment.load(output / "experiment.yaml"), run.experiment)
        best = read_weights(output / "weights.pt")
        self.assertEqual(max(row["ap"] for row in run.history), json.loads(best["about"])["metrics"]["ap"])
        self.assertEqual(["cone", "cube", "sphere"], best["class_names"])

    def test_the_same_settings_give_the_same_bits_and_another_seed_does_not(self):
        one, other, third = (self.train(f"same{i}", {"epochs": 2, "seed": seed})[0] for i, seed in enumerate((1, 1, 2)))
        self.assertTrue(equal(one.network.state_dict(), other.network.state_dict()))
        self.assertEqual(one.history, other.history)
        self.assertFalse(equal(one.network.state_dict(), third.network.state_dict()))

    def test_loading_processes_change_nothing(self):
        one, other = (self.train(f"workers{n}", {"epochs": 2, "workers": n})[0] for n in (0, 2))
        self.assertTrue(equal(one.network.state_dict(), other.network.state_dict()))

    def test_bfloat16_computes_nearly_the_same(self):
        one, other = (self.train(name, {"epochs": 1, "warmup_epochs": 0, "precision": name})[0].history[0]["loss"]
                      for name in ("float32", "bfloat16"))
        self.assertNotEqual(one, other)
        self.assertAlmostEqual(one, other, delta=0.02 * one)

    def test_stops_early(self):
        run, _ = self.train("early", {
            "epochs": 30,
            "early_stop": 2,
            "learning_rate": 1e-8,
            "monitor": "loss",
            "average_decay": 0
        })
        self.assertLess(run.history[-1]["epoch"], 30)
        losses = [row["validation_loss"] for row in run.history]
        self.assertGreaterEqual(min(losses[-2:]), min(losses[:-2]))

    def test_max_steps(self):
        run, _ = self.train("steps", {"epochs": 50, "max_steps": 7})
        self.assertEqual((7, 7), (run.step, run.history[-1]["step"]))
        self.assertIn("ap", run.history[-1])

    def test_a_loss_that_is_not_finite_ends_training_with_the_remedy(self):
        class Broken(tiny_network.TinyNetwork):
            def loss(self, raw, targets):
                return {name: value * float("nan") for name, value in super().loss(raw, targets).items()}
        run = trainer.Trainer(self.make("nan", {"epochs": 9}), build=lambda e, names: Broken(names), report=str)
        before = {k: v.clone() for k, v in run.network.state_dict().items() if "running" not in k and "num_" not in k}
        with self.assertRaisesRegex(TrainingError, "lower training.learning_rate"):
            run.run()
        self.assertTrue(equal(before, {k: v for k, v in run.network.state_dict().items() if k in before}))

    def test_folders_with_results_are_not_written_over(self):
        self.train("taken", {"epochs": 1, "warmup_epochs": 0})
        with self.assertRaisesRegex(ExperimentError, "holds results already: give --resume"):
            self.train("taken")
        with self.assertRaisesRegex(ExperimentError, "begun with other settings .training.seed"):
            self.train("taken", {"epochs": 1, "warmup_epochs": 0, "seed": 9}, resume=True)

    def test_data_that_changed_are_not_gone_on_with(self):
        own = self.root / "own"
        drawn.write_drawn(own, "solids", 12, 5, (96, 72))
        values = self.values("changed", {"epochs": 2})
        values["data"]["path"] = "own"
        made = experiment.make(values, self.root / "x.yaml")
        trainer.Trainer(made, build=tiny_network.build, report=str)._save_checkpoint()
        labels = own / "Annotations" / "000001.xml"
        labels.write_text(labels.read_text().replace("<difficult>0", "<difficult>1"))
        with self.assertRaisesRegex(ExperimentError, "labels have changed since"):
            trainer.Trainer(made, True, tiny_network.build, str)

    def test_a_split_without_images_is_refused(self):
        own = self.root / "empty"
        drawn.write_drawn(own, "solids", 12, 5, (96, 72))
        (own / "ImageSets/Main/val.txt").write_text("")
        values = self.values("none")
        values["data"]["path"] = "empty"
        with self.assertRaisesRegex(DataError, 'split "val" has no image'):
            trainer.Trainer(experiment.make(values, self.root / "x.yaml"), build=tiny_network.build)

    def test_devices_and_precisions_that_are_not_there(self):
        for training, text in (({"device": "tpu9"}, "is no device"), ({"precision": "float16"}, "needs a GPU")):
            with self.assertRaisesRegex(ValueError, text):
                self.train("bad", training)
        if not torch.cuda.is_available():
            with self.assertRaisesRegex(ValueError, "GPU 0 is not there"):
                self.train("bad", {"device": "cuda"})

    @unittest.skipUnless(torch and torch.cuda.is_available(), "no GPU here")
    def test_recorded_steps_learn_what_steps_one_by_one_do(self):
        on_gpu = {"epochs": 3, "device": "cuda", "precision": "float32"}
        one_by_one, _ = self.train("one_by_one", {**on_gpu, "cuda_graphs": False})
        recorded, _ = self.train("recorded", on_gpu)
        self.assertFalse(recorded.to_record)
        for before, now in zip(one_by_one.history, recorded.history):
            for name in ("loss", "validation_loss"):
                self.assertAlmostEqual(before[name], now[name], delta=0.05 * before[name])

    @unittest.skipUnless(torch and torch.cuda.is_available(), "no GPU here")
    def test_a_recording_leaves_weights_and_statistics(self):
        run = trainer.Trainer(self.make("left", {"device": "cuda"}), build=tiny_network.build, report=str)
        run.strategy.set_train_mode(run.network)
        before = {k: v.clone() for k, v in run.network.state_dict().items()}
        run.losses.record(next(iter(run.loader))[0].cuda())
        self.assertTrue(equal(before, run.network.state_dict()))

    def test_sigterm_leaves_a_checkpoint_that_goes_on_to_the_same_weights(self):
        whole, _ = self.train("whole_term")
        run = trainer.Trainer(self.make("term"), build=tiny_network.build, report=str)
        step = run._train_step

        def interrupting(*batch):
            result = step(*batch)
            if run.step == 7:
                os.kill(os.getpid(), signal.SIGTERM)
            return result
        run._train_step = interrupting
        with self.assertRaises(KeyboardInterrupt):
            run.run()
        self.assertEqual(7, json.loads(run.checkpoints.load_newest()["numbers"])["step"])
        again, _ = self.train("term", resume=True)
        self.assertTrue(equal(whole.network.state_dict(), again.network.state_dict()))

if __name__ == "__main__":
    unittest.main()
