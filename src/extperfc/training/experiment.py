"""One training run: everything that decides about its result, in one YAML file."""

import dataclasses
import pathlib

import yaml

from .data.augmentation import Augmentation
from .errors import SettingsError
from .settings import choice, describe, flag, integer, names, number, read, resolve, section, text

STRATEGIES = ("random_weights", "feature_representation_transfer", "instance_transfer")


class ExperimentError(SettingsError):
    """An experiment cannot be run; the message lists every error."""


@dataclasses.dataclass(frozen=True)
class Data:
    """Which images."""

    path: str = text("", "Pascal VOC folder, COCO file or folder; relative to the YAML file")
    train: str = text("train", "split to learn from")
    validation: str = text("val", "split that curves, best weights and early stopping look at")
    classes: list = names([], "classes in the order of the network's outputs; empty: those of the data")


@dataclasses.dataclass(frozen=True)
class Training:
    """How long and how."""

    epochs: int = integer(100, 1, 100000, "passes over the images")
    batch_size: int = integer(16, 1, 4096, "images per step and process")
    optimizer: str = choice("adamw", ("adamw", "sgd"), "sgd has Nesterov momentum 0.9")
    learning_rate: float = number(0, 0, 10, "highest learning rate, for the batch of all processes together; 0: what suits the"
                                  " network")
    final_rate: float = number(0.01, 0, 1, "last learning rate over the highest one, at the end of the cosine")
    warmup_epochs: float = number(1, 0, 1000, "epochs until the highest learning rate")
    weight_decay: float = number(5e-4, 0, 1, "not for biases and batch normalization")
    gradient_limit: float = number(10, 0.001, 1e6, "gradients with a larger norm are scaled down to it")
    average_decay: float = number(0.999, 0, 0.999999,
                                  "of the running average of the weights, which is what is kept; 0: none")
    validate_epochs: int = integer(1, 1, 10000, "epochs between validations")
    monitor: str = choice("ap", ("ap", "loss"), "what the best weights have: highest AP, or lowest validation loss")
    early_stop: int = integer(0, 0, 10000, "stop after so many validations without a better result; 0: never")
    precision: str = choice(
        "auto", ("auto", "float32", "bfloat16", "float16"),
        "of the network's forward and backward pass; auto: bfloat16 on a GPU that has it, else float32")
    device: str = text("auto", "auto, cpu, cuda or cuda:N; auto takes a GPU when there is one")
    deterministic: bool = flag(True, "repeatable to the bit on the same machine; some GPU operations are slower")
    cuda_graphs: bool = flag(True, "record the network's operations on a GPU once and replay them as CUDA graphs; not with"
                             " torchrun")
    workers: int = integer(2, 0, 256, "processes that read images; 0: none besides the one that trains")
    threads: int = integer(0, 0, 256, "of PyTorch on the CPU; 0: PyTorch decides. Other numbers round differently")
    seed: int = integer(1, 0, 2**31 - 1, "of the first weights, the order of images and their augmentation")
    checkpoint_steps: int = integer(500, 1, 10**9,
                                    "steps between checkpoints; one more stands at the end of each epoch")
    keep_checkpoints: int = integer(2, 1, 1000, "older ones are deleted")
    max_steps: int = integer(0, 0, 10**9, "end after so many steps, for trials; 0: none")


@dataclasses.dataclass(frozen=True)
class Experiment:
    """Keys of the YAML file. Paths are relative to that file."""

    name: str = text("", "title of curves and reports; empty: the file's name")
    network: str = text("mobilenet_v2_ssd_lite", "extperfc-train networks lists them")
    strategy: str = choice("random_weights", STRATEGIES, "where the first weights come from, and what is trained")
    source: str = text("", "weights.pt of the source model, for the two transfers")
    output: str = text("", "folder of results; empty: runs/NAME beside the YAML file")
    data: Data = section(Data, "images and classes")
    training: Training = section(Training, "optimization")
    augmentation: Augmentation = section(Augmentation, "random changes of the training images")

    def as_dict(self):
        """For YAML and JSON."""
        return dataclasses.asdict(self)


HELP = "keys of the YAML file, with their defaults:\n\n" + "\n".join(describe(Experiment, "  "))
FREE_TO_CHANGE = {"output", "name"}  # on resuming; of training: the next line
FREE_TRAINING = {"device", "cuda_graphs", "workers", "checkpoint_steps", "keep_checkpoints"}


def load(file):
    """Experiment of a YAML file, with absolute paths. ExperimentError lists everything wrong with it."""
    file = pathlib.Path(file)
    try:
        values = yaml.safe_load(file.read_text())
    except FileNotFoundError:
        raise ExperimentError(f"{file}: no such file; extperfc-train train --help shows what it must hold") from None
    except (OSError, yaml.YAMLError) as error:
        raise ExperimentError(f"{file}: cannot be read: {error}") from None
    return make(values, file)


def make(values, file):
    """Experiment of a mapping; `file` is where relative paths count from."""
    errors = []
    found = read(Experiment, values, errors)
    errors += conflicts(found)
    if errors:
        raise ExperimentError("\n".join([f"{file}: {len(errors)} errors:", *(f"  {e}" for e in errors)]))
    base = file.resolve().parent
    name = found.name or file.stem
    return dataclasses.replace(
        found, name=name, source=str(resolve(base, found.source)) if found.source else "",
        output=str(resolve(base, found.output or f"runs/{name}")),
        data=dataclasses.replace(found.data, path=str(resolve(base, found.data.path))))


def conflicts(found):
    """What is wrong between values that are right each alone."""
    errors = []
    if not found.data.path:
        errors.append("data.path is missing: give a Pascal VOC folder or COCO file")
    if found.strategy != "random_weights" and not found.source:
        errors.append(f"source is missing: {found.strategy} needs the weights.pt of a source model (or strategy:"
                      " random_weights)")
    if found.strategy == "random_weights" and found.source:
        errors.append("source is given, but strategy random_weights copies no weights: choose"
                      " feature_representation_transfer or instance_transfer, or leave it out")
    if found.training.warmup_epochs >= found.training.epochs and found.training.epochs > 1:
        errors.append(f"training.warmup_epochs ({found.training.warmup_epochs:g}) must be less than training.epochs"
                      f" ({found.training.epochs})")
    if found.data.path and found.data.train == found.data.validation:
        errors.append("data.train and data.validation are the same split: the validation would show learned images")
    return errors


def differences(before, now):
    """Keys that keep a run from being resumed: those that decide about the result and differ."""
    def flat(experiment):
        values = {k: v for k, v in experiment.items() if not isinstance(v, dict) and k not in FREE_TO_CHANGE}
        for group in ("data", "training", "augmentation"):
            skipped = FREE_TRAINING if group == "training" else ()
            values.update({f"{group}.{k}": v for k, v in experiment[group].items() if k not in skipped})
        return values
    one, other = flat(before), flat(now)
    return sorted(key for key in one.keys() | other.keys() if one.get(key) != other.get(key))
