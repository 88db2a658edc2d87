"""trains a network as a YAML file says

Results go to its output folder: weights.pt (the best weights), curves.png, history.json, tensorboard/, provenance.json
with everything needed to repeat the run, checkpoints/. --resume goes on after a kill, with the same result as without
it. Several GPUs or machines: torchrun --nproc_per_node N tools/extperfc-train train FILE.
"""

import dataclasses
import pathlib

from ..experiment import HELP as EPILOG  # noqa: F401


def add_arguments(parser):
    parser.add_argument("experiment", type=pathlib.Path, help="YAML file with the keys below")
    parser.add_argument("--resume", action="store_true", help="go on with what the output folder holds")
    parser.add_argument("--device", help="instead of training.device: auto, cpu, cuda or cuda:N")
    parser.add_argument("--check", action="store_true", help="only read the file and the data, and report every error")


def run(options):
    from ..experiment import load
    experiment = load(options.experiment)
    if options.device:
        experiment = dataclasses.replace(experiment,
                                         training=dataclasses.replace(experiment.training, device=options.device))
    if options.check:
        return show(experiment)
    from .. import trainer
    trainer.train(experiment, options.resume)
    print(f"weights, curves and history are in {experiment.output}")
    return 0


def show(experiment):
    """What would be trained on."""
    from ..trainer import read_data
    for split, dataset in read_data(experiment).items():
        print(f"{split}: {len(dataset)} images; " + ", ".join(f"{name} {count}"
                                                              for name, count in dataset.counts().items()))
    return 0
