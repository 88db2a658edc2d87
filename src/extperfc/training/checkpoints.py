"""Checkpoints on disk: whole or not there, the newest few kept, damaged ones passed over."""

import os
import pathlib
import re

import torch

NAME = re.compile(r"step_(\d{9})\.pt")


def save_atomically(content, file):
    """torch.save to `file`, which is at any moment the old one or the whole new one, also after a power failure."""
    file = pathlib.Path(file)
    file.parent.mkdir(parents=True, exist_ok=True)
    partial = file.with_name(f".{file.name}.partial")
    with partial.open("wb") as stream:
        torch.save(content, stream)
        stream.flush()
        os.fsync(stream.fileno())
    os.replace(partial, file)
    folder = os.open(file.parent, os.O_RDONLY)
    try:
        os.fsync(folder)
    finally:
        os.close(folder)


class CheckpointFolder:
    """Checkpoints step_N.pt of one run; keeps the `keep` newest."""

    def __init__(self, folder, keep):
        self.folder, self.keep = pathlib.Path(folder), keep

    def files(self):
        """Checkpoints, the oldest first."""
        return sorted(f for f in self.folder.glob("step_*.pt") if NAME.fullmatch(f.name))

    def save(self, content, step):
        """Writes a checkpoint, then deletes old ones and what a killed process left unfinished."""
        file = self.folder / f"step_{step:09d}.pt"
        save_atomically(content, file)
        for old in self.files()[:-self.keep]:
            old.unlink()
        for leftover in self.folder.glob(".step_*.partial"):
            leftover.unlink()
        return file

    def load_newest(self, report=print):
        """The newest checkpoint that can be read, or None; a damaged one is reported and passed over."""
        for file in reversed(self.files()):
            try:
                return torch.load(file, map_location="cpu", weights_only=True)
            except Exception as error:  # torch raises whatever a truncated file makes it meet
                report(f"{file}: damaged ({str(error).splitlines()[0][:80]}); taking the one before")
        return None
