"""Trains one network as an Experiment says, on one device or several; goes on after a kill as if there had been none.

Repeatability: the order of images depends on (seed, epoch), an image's augmentation on (seed, epoch, index), the
random numbers inside the network on (seed, step, process). Nothing depends on the state of a generator, so that a
checkpoint in the middle of an epoch needs none, and a resumed run has the same weights to the bit as one that was not
interrupted (same machine, number of processes and threads, `deterministic: true`).

Results in the output folder: weights.pt (the best running average of the weights), experiment.yaml, provenance.json,
history.json, curves.png, tensorboard/, checkpoints/.
"""

import contextlib
import dataclasses
import json
import os
import pathlib
import signal
import time

import numpy as np
import torch
import yaml

from . import curves, provenance
from .checkpoints import CheckpointFolder, save_atomically
from .data import read_dataset
from .data.torch_dataset import DetectionDataset, StepSampler, collate
from .detecting import LossModule, to_numpy, truth_of
from .errors import DataError, TrainingError
from .evaluation import evaluate
from .experiment import Experiment, ExperimentError, differences
from .processes import Processes
from .progress import Progress
from .schedule import WeightAverage, rate_at
from .strategies import FORMAT, STRATEGIES, read_weights
from .text_files import write_text_atomically

MAX_BAD_STEPS = 20  # one after another with gradients that are not finite
CURVES_EVERY_S = 30.0
RESTORED = ("epoch", "epoch_step", "step", "bad_steps", "since_best", "best", "history")
PRECISIONS = {"float32": torch.float32, "bfloat16": torch.bfloat16, "float16": torch.float16}


def build_network(experiment, class_names):
    """The experiment's network with random weights."""
    from .networks import NETWORKS, build
    if experiment.network not in NETWORKS:
        raise ExperimentError(f"network \"{experiment.network}\" is unknown: choose one of {', '.join(NETWORKS)}")
    return build(experiment.network, class_names)


def read_data(experiment):
    """{split: Dataset} of training and validation images, with the experiment's classes. DataError when unusable."""
    dataset = read_dataset(experiment.data.path)
    if experiment.data.classes:
        dataset = dataset.with_classes(tuple(experiment.data.classes))
    parts = {split: dataset.split(split) for split in (experiment.data.train, experiment.data.validation)}
    for split, part in parts.items():
        if not len(part):
            raise DataError(f"{experiment.data.path}: the split \"{split}\" has no image: make the splits again with"
                            f" extperfc-train split {experiment.data.path} --replace")
    return parts


def choose_precision(name, device):
    """torch's type of a precision; ExperimentError where the device lacks it."""
    has_bfloat16 = device.type == "cpu" or torch.cuda.is_bf16_supported()
    if name == "auto":
        return torch.bfloat16 if device.type == "cuda" and has_bfloat16 else torch.float32
    if name == "float16" and device.type == "cpu":
        raise ExperimentError("training.precision float16 needs a GPU: choose bfloat16 or float32")
    if name == "bfloat16" and not has_bfloat16:
        raise ExperimentError("training.precision bfloat16 is not supported by this GPU: choose float16 or float32")
    return PRECISIONS[name]


def highest_rate(network, training):
    """The learning rate after warm-up."""
    return training.learning_rate or network.learning_rate


def make_optimizer(network, training, rate):
    """Decays matrices and filters, not biases and batch normalization."""
    learning = [p for p in network.parameters() if p.requires_grad]
    groups = [{"params": [p for p in learning if p.ndim > 1], "weight_decay": training.weight_decay},
              {"params": [p for p in learning if p.ndim <= 1], "weight_decay": 0.0}]
    groups = [group for group in groups if group["params"]]
    if training.optimizer == "sgd":
        return torch.optim.SGD(groups, lr=rate, momentum=0.9, nesterov=True)
    on_gpu = all(p.is_cuda for p in learning)
    return torch.optim.AdamW(groups, lr=rate, **({"fused": True} if on_gpu else {}))


def make_scaler(enabled):
    """Loss scaling for float16, by the name that this version of PyTorch has for it."""
    if hasattr(torch.amp, "GradScaler"):
        return torch.amp.GradScaler("cuda", enabled=enabled)
    return torch.cuda.amp.GradScaler(enabled=enabled)


def start_worker(_):
    """Loading processes compute with one thread each."""
    import cv2
    cv2.setNumThreads(0)
    torch.set_num_threads(1)


def is_better(monitor, value, best):
    """Whether a validation beats the best one so far."""
    if best is None or value != value:
        return best is None
    return value > best if monitor == "ap" else value < best


class Trainer:
    """One run. history: a dictionary per epoch with losses, learning rate and, where validated, AP."""

    def __init__(self, experiment, resume=False, build=build_network, report=print):
        self.experiment, self.options = experiment, experiment.training
        self.output = pathlib.Path(experiment.output)
        self.processes = Processes(self.options.device)
        self.report = report if self.processes.is_first else lambda text: None
        self.checkpoints = CheckpointFolder(self.output / "checkpoints", self.options.keep_checkpoints)
        saved = self._saved(resume)
        self._make_repeatable()
        self.datasets = read_data(experiment)
        self.checksums = {n: d.checksum() for n, d in self.datasets.items()} if self.processes.is_first else None
        self._build(build, transfer=saved is None)
        self._make_loaders()
        self.epoch = self.epoch_step = self.step = self.bad_steps = self.since_best = 0
        self.best, self.history, self.sums, self.interrupted, self.drawn = None, [], {}, False, -CURVES_EVERY_S
        if saved is not None:
            self._restore(saved)
        elif self.processes.is_first:
            self._write_provenance()

    @property
    def class_names(self):
        return self.datasets[self.experiment.data.train].class_names

    @property
    def total_steps(self):
        """Optimizer steps of the whole run."""
        steps = self.options.epochs * self.sampler.steps
        return min(steps, self.options.max_steps) if self.options.max_steps else steps

    @property
    def is_finished(self):
        stop = self.options.early_stop and self.since_best >= self.options.early_stop
        return self.epoch >= self.options.epochs or self.step >= self.total_steps or bool(stop)

    def run(self):
        """Trains to the end; returns the history. Ctrl-C and SIGTERM leave a checkpoint and raise KeyboardInterrupt."""
        board = curves.TensorBoard(self.output / "tensorboard", self.step + 1) if self.processes.is_first else None
        self.progress = Progress(self.total_steps, self.step, enabled=self.processes.is_first)
        try:
            with self._interruptible():
                while not self.is_finished:
                    self._train_epoch()
                    row = self._finish_epoch()
                    if board:
                        board.add(row)
        finally:
            if board:
                board.close()
            self.processes.close()
        return self.history

    # --- beginning --------------------------------------------------------------------------------

    def _saved(self, resume):
        """The newest checkpoint on all processes, None for a new run. ExperimentError for a foreign folder."""
        fault, saved = None, None
        if self.processes.is_first:
            saved = self.checkpoints.load_newest(self.report) if resume else None
            fault = self._folder_fault(resume, saved)
        fault, saved = self.processes.broadcast((fault, saved))
        if fault:
            raise ExperimentError(fault)
        return saved

    def _folder_fault(self, resume, saved):
        if not resume and self.output.exists() and any(self.output.iterdir()):
            return f"{self.output} holds results already: give --resume to go on with them, or another output"
        if saved is not None:
            begun = json.loads(saved["numbers"])
            changed = differences(begun["experiment"], self.experiment.as_dict())
            if changed:
                return (f"{self.output} was begun with other settings ({', '.join(changed)}): restore them, or give"
                        " another output")
            if begun["world"] != self.processes.world:
                return (f"{self.output} was begun with {begun['world']} processes, not {self.processes.world}: start"
                        " as many")
        return None

    def _make_repeatable(self):
        if self.options.threads:
            torch.set_num_threads(self.options.threads)
        torch.backends.cudnn.benchmark = not self.options.deterministic
        if self.options.deterministic:
            os.environ.setdefault("CUBLAS_WORKSPACE_CONFIG", ":4096:8")
            torch.use_deterministic_algorithms(True, warn_only=True)
            if hasattr(torch.utils, "deterministic"):  # since PyTorch 2.1, which else writes NaN into every new tensor
                torch.utils.deterministic.fill_uninitialized_memory = False

    def _build(self, build, transfer):
        device = self.processes.device
        torch.manual_seed(self.options.seed)
        self.network = build(self.experiment, self.class_names)
        self.strategy = STRATEGIES[self.experiment.strategy]
        source = read_weights(self.experiment.source) if self.experiment.source else None
        self.transfer = self.strategy.start(self.network, source)
        if transfer and source:
            self.report(f"{self.experiment.strategy}: {self.transfer.text()}")
        self.network.to(device)
        precision = choose_precision(self.options.precision, device)
        if device.type == "cuda" and precision != torch.float32:
            self.network.to(memory_format=torch.channels_last)  # what the units for 16 bits compute in
        self.learning = [parameter for parameter in self.network.parameters() if parameter.requires_grad]
        self.average = WeightAverage(self.network, self.options.average_decay)
        self.highest_rate = highest_rate(self.network, self.options)
        self.optimizer = make_optimizer(self.network, self.options, self.highest_rate)
        self.scaler = make_scaler(precision == torch.float16)
        self.losses = LossModule(self.network, precision)
        self.average_losses = LossModule(self.average.network, precision)
        self.model = self.losses
        self.to_record = self.options.cuda_graphs and device.type == "cuda" and self.processes.world == 1
        if self.processes.world > 1:
            devices = [device.index] if device.type == "cuda" else None
            self.model = torch.nn.parallel.DistributedDataParallel(self.losses, devices)

    def _make_loaders(self):
        data, options = self.experiment.data, self.options
        size, resize = self.network.input_size, self.network.preprocessing.resize
        rank, world = self.processes.rank, self.processes.world
        training = DetectionDataset(self.datasets[data.train], size, resize, self.experiment.augmentation, options.seed)
        self.sampler = StepSampler(len(training), options.batch_size, options.seed, rank, world)
        common = {"num_workers": options.workers, "collate_fn": collate, "worker_init_fn": start_worker,
                  "pin_memory": self.processes.device.type == "cuda"}
        self.loader = torch.utils.data.DataLoader(training, batch_sampler=self.sampler,
                                                  persistent_workers=options.workers > 0, **common)
        validation = DetectionDataset(self.datasets[data.validation], size, resize)
        mine = range(rank, len(validation), world)
        self.validation_loader = torch.utils.data.DataLoader(validation,
                                                             options.batch_size,
                                                             sampler=list(mine),
                                                             **common)

    def _write_provenance(self):
        self.output.mkdir(parents=True, exist_ok=True)
        record = provenance.describe(self.experiment, self.datasets, self.checksums, self.processes)
        record["transfer"] = dataclasses.asdict(self.transfer)
        write_text_atomically(json.dumps(record, indent=1) + "\n", self.output / "provenance.json")
        write_text_atomically(yaml.safe_dump(self.experiment.as_dict(), sort_keys=False),
                              self.output / "experiment.yaml")

    # --- an epoch ---------------------------------------------------------------------------------

    def _train_epoch(self):
        self.sampler.epoch, self.sampler.first_step = self.epoch, self.epoch_step
        self.strategy.set_train_mode(self.network)
        self._record_once()
        for images, targets in self.loader:
            if self.step >= self.total_steps:
                break
            losses = self._train_step(images, targets)
            self.progress.step(lambda: f"epoch {self.epoch + 1}, loss {float(sum(losses.values())):.3f}")
            if self.interrupted:
                self._save_checkpoint()
                raise KeyboardInterrupt
            if self.step % self.options.checkpoint_steps == 0 and self.epoch_step < self.sampler.steps:
                self._save_checkpoint()

    def _train_step(self, images, targets):
        images = images.to(self.processes.device, non_blocking=True)
        torch.manual_seed((self.options.seed * 1_000_003 + self.step) * 4099 + self.processes.rank)
        self._set_rate()
        self.optimizer.zero_grad(set_to_none=True)
        losses = self.model(images, targets)
        self.scaler.scale(sum(losses.values())).backward()
        self.scaler.unscale_(self.optimizer)
        norm = torch.nn.utils.clip_grad_norm_(self.learning, self.options.gradient_limit)
        self._count_bad_steps(bool(torch.isfinite(norm)))
        if self.bad_steps == 0 or self.scaler.is_enabled():
            self.scaler.step(self.optimizer)
        self.scaler.update()
        self.average.update()
        self.step, self.epoch_step = self.step + 1, self.epoch_step + 1
        if self.bad_steps == 0:
            for name, value in losses.items():
                self.sums[name] = self.sums.get(name, 0.0) + value.detach().double()
            self.sums["steps"] = self.sums.get("steps", 0) + 1
        return losses

    def _record_once(self):
        """On one GPU the network's operations become CUDA graphs, which are started as a whole.

        Before the loader begins: its thread takes memory of the GPU's driver, which no recording bears.
        """
        wanted, self.to_record = self.to_record, False
        if not wanted:
            return
        width, height = self.network.input_size
        shape = (self.options.batch_size, height, width, 3)
        try:
            self.losses.record(torch.zeros(shape, dtype=torch.uint8, device=self.processes.device))
        except RuntimeError as error:
            self.report(f"training.cuda_graphs: not possible here ({str(error).splitlines()[0]}); going on without")

    def _set_rate(self):
        warmup = round(self.options.warmup_epochs * self.sampler.steps)
        factor = rate_at(self.step, self.total_steps, min(warmup, self.total_steps - 1), self.options.final_rate)
        for group in self.optimizer.param_groups:
            group["lr"] = self.highest_rate * factor

    def _count_bad_steps(self, is_finite):
        """A step whose gradients are not finite changes no weight; float16 begins with some."""
        self.bad_steps = 0 if is_finite else self.bad_steps + 1
        if self.bad_steps >= MAX_BAD_STEPS:
            raise TrainingError(f"the loss is not finite since {MAX_BAD_STEPS} steps (step {self.step}): lower"
                                " training.learning_rate or training.gradient_limit, or use precision float32")


    def _finish_epoch(self):
        row = {"epoch": self.epoch + 1, "step": self.step, "learning_rate": self.optimizer.param_groups[0]["lr"]}
        row.update(self._mean_losses())
        self.epoch, self.epoch_step, self.sums = self.epoch + 1, 0, {}
        if self.epoch % self.options.validate_epochs == 0 or self.is_finished:
            row.update(self.validate())
            self._keep_best(row)
        self.history.append(row)
        if self.processes.is_first:
            self.progress.line(line_of(row, self.options.epochs))
            write_text_atomically(json.dumps(self.history, indent=1) + "\n", self.output / "history.json")
            self._draw_curves()
        self._save_checkpoint()
        return row

    def _draw_curves(self):
        """Drawing takes a second, which short epochs would notice."""
        now = time.monotonic()
        if self.is_finished or now - self.drawn >= CURVES_EVERY_S:
            curves.draw_run(self.history, self.output / "curves.png", self.experiment.name)
            self.drawn = now

    def _mean_losses(self):
        """Mean training losses of the epoch over all processes."""
        sums = self.processes.gather({k: float(v) for k, v in self.sums.items()})
        steps = max(1.0, sum(s.get("steps", 0) for s in sums))
        means = {k: sum(s.get(k, 0.0) for s in sums) / steps for k in sums[0] if k != "steps"}
        return {"loss": sum(means.values()), **{f"loss/{k}": v for k, v in means.items()}}

    @torch.no_grad()
    def validate(self):
        """Loss and AP of the averaged weights on the validation images, the same on every process."""
        # Weights are the same everywhere, but each process has seen other images for its batch statistics.
        self.processes.broadcast_tensors(self.average.network.buffers())
        self.average.network.eval()
        images_seen, sums, found = 0, {}, []
        for images, targets in self.validation_loader:
            images = images.to(self.processes.device, non_blocking=True)
            raw = self.average_losses.raw(images)
            for name, value in self.average.network.loss(raw, targets).items():
                sums[name] = sums.get(name, 0.0) + float(value) * len(images)
            images_seen += len(images)
            detections = self.average.network.detect(raw)
            found += [(t["index"], to_numpy(d), truth_of(t)) for d, t in zip(detections, targets)]
        parts = self.processes.gather((images_seen, sums, found))
        rows = sorted((row for part in parts for row in part[2]), key=lambda row: row[0])
        result = evaluate([r[1] for r in rows], [r[2] for r in rows], self.class_names)
        count = max(1, sum(part[0] for part in parts))
        losses = {name: sum(part[1].get(name, 0.0) for part in parts) / count for part in parts for name in part[1]}
        return {"validation_loss": sum(losses.values()), **{f"validation_loss/{k}": v for k, v in losses.items()},
                "ap": number_of(result.mean_ap()), "ap50": number_of(result.mean_ap(0.5)),
                "ap75": number_of(result.mean_ap(0.75))}

    def _keep_best(self, row):
        value = row["ap" if self.options.monitor == "ap" else "validation_loss"]
        if not is_better(self.options.monitor, value, self.best):
            self.since_best += 1
            return
        self.best, self.since_best = value, 0
        if self.processes.is_first:
            save_atomically(self._weights(row), self.output / "weights.pt")

    def _weights(self, row):
        """Content of weights.pt; strategies.read_weights() reads it."""
        about = {"metrics": row, "experiment": self.experiment.as_dict(), "git": provenance.git_version()}
        return {
            "format": FORMAT,
            "network": self.network.name,
            "class_names": list(self.class_names),
            "weights": {
                k: v.cpu()
                for k, v in self.average.network.state_dict().items()
            },
            "about": json.dumps(about)
        }

    # --- kill and resume --------------------------------------------------------------------------

    def _save_checkpoint(self):
        if not self.processes.is_first:
            return
        # Numbers are JSON, which keeps every bit: what reads tensors only, and runs no code of a file, takes no floats.
        numbers = {name: getattr(self, name) for name in RESTORED}
        numbers["data"] = self.checksums
        numbers.update(experiment=self.experiment.as_dict(),
                       world=self.processes.world,
                       scaler=self.scaler.state_dict(),
                       sums={
                           k: float(v)
                           for k, v in self.sums.items()
                       })
        self.checkpoints.save({
            "numbers": json.dumps(numbers), "network": self.network.state_dict(), "average": self.average.state(),
            "optimizer": self.optimizer.state_dict()["state"]}, self.step)

    def _restore(self, saved):
        numbers = json.loads(saved["numbers"])
        if self.processes.broadcast(self.checksums != numbers["data"]):
            raise ExperimentError(f"{self.experiment.data.path}: the images or labels have changed since {self.output} was"
                                  " begun: restore them, or give another output")
        for name in RESTORED:
            setattr(self, name, numbers[name])
        self.sums = numbers["sums"]
        self.network.load_state_dict(saved["network"])
        self.average.load(saved["average"])
        groups = self.optimizer.state_dict()["param_groups"]
        self.optimizer.load_state_dict({"state": saved["optimizer"], "param_groups": groups})
        self.scaler.load_state_dict(numbers["scaler"])
        self.report(f"going on with epoch {self.epoch + 1} at step {self.step} of {self.total_steps}")

    @contextlib.contextmanager
    def _interruptible(self):
        """Turns SIGINT and SIGTERM into a checkpoint at the end of the step; only the main thread can."""
        def note(*_):
            self.interrupted = True
        try:
            before = {number: signal.signal(number, note) for number in (signal.SIGINT, signal.SIGTERM)}
        except ValueError:
            before = {}
        try:
            yield
        finally:
            for number, handler in before.items():
                signal.signal(number, handler)


def number_of(value):
    """AP without any object is 0 in a history, which JSON and TensorBoard can hold."""
    return 0.0 if np.isnan(value) else float(value)


def line_of(row, epochs):
    """One line per epoch for a terminal."""
    text = f"epoch {row['epoch']}/{epochs}: loss {row['loss']:.3f}"
    if "ap" in row:
        text += (f", validation loss {row['validation_loss']:.3f}, AP {row['ap']:.3f} (mean over IoU),"
                 f" {row['ap50']:.3f} (IoU 0.50)")
    return text


def train(experiment: Experiment, resume=False, build=build_network, report=print):
    """Runs an experiment to its end; returns its history."""
    return Trainer(experiment, resume, build, report).run()
