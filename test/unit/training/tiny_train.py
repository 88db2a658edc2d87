"""Trains the tiny network as a YAML file says, for tests that need a process to kill.

  tiny_train.py FILE [--resume] [--die-at step:N | save:N] [--digest FILE]

--die-at kills the process with SIGKILL after its N-th step, or in the middle of writing its N-th checkpoint.
--digest writes a checksum of this process's weights to FILE.RANK.
"""

import argparse
import hashlib
import os
import pathlib
import signal
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[3] / "src"))

import tiny_network  # noqa: E402
import torch  # noqa: E402

from extperfc.training import checkpoints, curves, experiment, trainer  # noqa: E402


def kill_this_process():
    os.kill(os.getpid(), signal.SIGKILL)


def die_after_step(number):
    step = trainer.Trainer._train_step

    def dying(self, *batch):
        result = step(self, *batch)
        dying.count += 1
        if dying.count == number:
            kill_this_process()
        return result
    dying.count = 0
    trainer.Trainer._train_step = dying


def die_in_save(number):
    save = torch.save

    def dying(content, stream):
        dying.count += "optimizer" in content
        if dying.count == number:
            stream.write(b"the first half of a checkpoint")
            stream.flush()
            kill_this_process()
        save(content, stream)
    dying.count = 0
    checkpoints.torch.save = dying


def digest(weights):
    text = hashlib.sha256()
    for name, value in sorted(weights.items()):
        text.update(name.encode() + value.cpu().numpy().tobytes())
    return text.hexdigest()


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("file")
    parser.add_argument("--resume", action="store_true")
    parser.add_argument("--die-at", default="")
    parser.add_argument("--digest")
    options = parser.parse_args()
    kind, _, number = options.die_at.partition(":")
    if kind:
        {"step": die_after_step, "save": die_in_save}[kind](int(number))
    curves.draw_run = lambda *arguments: None  # takes longer than such a run
    run = trainer.Trainer(experiment.load(options.file), options.resume, tiny_network.build)
    run.run()
    if options.digest:
        pathlib.Path(f"{options.digest}.{run.processes.rank}").write_text(digest(run.average.network.state_dict()))


if __name__ == "__main__":
    main()
