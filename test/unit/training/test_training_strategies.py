"""The three transfer learning strategies with a tiny network."""

import unittest

from training_case import FAST, TrainingCase, torch

from extperfc.training import experiment
from extperfc.training.data import drawn
from extperfc.training.experiment import ExperimentError

if torch:
    import tiny_network

    from extperfc.training import trainer
    from extperfc.training.checkpoints import save_atomically
    from extperfc.training.strategies import STRATEGIES, backbone_names, read_weights


class Strategies(TrainingCase):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        drawn.write_drawn(cls.root / "source", "household", 20, 3, (96, 72))
        values = {
            "data": {
                "path": "source"
            },
            "output": "source_run",
            "training": {
                **FAST, "epochs": 1,
                "warmup_epochs": 0
            }
        }
        trainer.train(experiment.make(values, cls.root / "s.yaml"), build=tiny_network.build, report=str)
        cls.source = read_weights(cls.root / "source_run" / "weights.pt")

    def test_feature_representation_transfer_keeps_the_backbone_to_the_bit(self):
        run, reports = self.train("feature", {"epochs": 2}, strategy="feature_representation_transfer",
                                  source="source_run/weights.pt")
        names = backbone_names(run.network)
        self.assertIn("backbone.1.running_mean", names)
        for weights in (run.network.state_dict(), read_weights(self.root / "feature/weights.pt")["weights"]):
            for name in names:
                self.assertTrue(torch.equal(self.source["weights"][name], weights[name]), name)
        self.assertEqual({n
                          for n, p in run.network.named_parameters() if not p.requires_grad},
                         set(run.transfer.frozen))
        self.assertEqual(len(names), len(run.transfer.copied))
        self.assertIn("12 frozen", reports[0])

    def test_feature_representation_transfer_learns_the_head(self):
        network = tiny_network.TinyNetwork(("a",))
        before = {k: v.clone() for k, v in network.state_dict().items()}
        strategy = STRATEGIES["feature_representation_transfer"]
        strategy.start(network, self.source)
        strategy.set_train_mode(network)
        self.assertFalse(any(m.training for m in network.backbone.modules()))
        self.assertTrue(network.shared.training)
        for name in set(before) - backbone_names(network):
            self.assertTrue(torch.equal(before[name], network.state_dict()[name]), name)

    def test_instance_transfer_copies_everything_that_fits_and_reports_the_rest(self):
        network = tiny_network.TinyNetwork(("cone", "cube", "sphere"))
        transfer = STRATEGIES["instance_transfer"].start(network, self.source)
        self.assertEqual({"classes.weight", "classes.bias"}, set(transfer.initialized))
        self.assertIn("has shape [4], in the source model [17]", transfer.initialized["classes.bias"])
        for name in transfer.copied:
            self.assertTrue(torch.equal(self.source["weights"][name], network.state_dict()[name]), name)
        self.assertTrue(all(p.requires_grad for p in network.parameters()))
        same = tiny_network.TinyNetwork(self.source["class_names"])
        self.assertEqual({}, STRATEGIES["instance_transfer"].start(same, self.source).initialized)

    def test_instance_transfer_trains_everything(self):
        run, _ = self.train("instance", {"epochs": 1, "warmup_epochs": 0}, strategy="instance_transfer",
                            source="source_run/weights.pt")
        changed = [n for n in run.network.state_dict() if not torch.equal(
            run.network.state_dict()[n], self.source["weights"][n]) if n in run.transfer.copied]
        self.assertEqual(len(run.transfer.copied), len(changed))

    def test_foreign_sources_are_refused(self):
        network = tiny_network.TinyNetwork(("a",))
        with self.assertRaisesRegex(ExperimentError, "weights of other, not of tiny"):
            STRATEGIES["instance_transfer"].start(network, dict(self.source, network="other"))
        for name in ("instance_transfer", "feature_representation_transfer"):
            damaged = dict(self.source["weights"])
            damaged.pop("backbone.0.weight")
            with self.assertRaisesRegex(ExperimentError, "backbone is not that of tiny: backbone.0.weight is not in"):
                STRATEGIES[name].start(network, dict(self.source, weights=damaged))

    def test_files_that_are_no_weights_are_refused(self):
        (self.root / "text.pt").write_text("no weights")
        with self.assertRaisesRegex(ExperimentError, "is no weights file"):
            read_weights(self.root / "text.pt")
        with self.assertRaisesRegex(ExperimentError, "no such file"):
            read_weights(self.root / "nowhere.pt")
        save_atomically({"a": torch.zeros(2)}, self.root / "plain.pt")
        self.assertIsNone(read_weights(self.root / "plain.pt")["network"])

if __name__ == "__main__":
    unittest.main()
