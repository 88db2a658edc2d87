"""One process or several of torchrun, on one machine or many, behind one interface."""

import os

import torch
import torch.distributed

from .errors import SettingsError


class Processes:
    """Rank and number of the processes that train together, the device of this one, and what they exchange.

    A run without torchrun is one process. Several use NCCL on GPUs and Gloo on CPUs.
    """

    def __init__(self, device="auto"):
        self.rank = int(os.environ.get("RANK", 0))
        self.world = int(os.environ.get("WORLD_SIZE", 1))
        self.device = self._choose(device, int(os.environ.get("LOCAL_RANK", 0)))
        self._started = self.world > 1 and not torch.distributed.is_initialized()
        if self._started:
            torch.distributed.init_process_group("nccl" if self.device.type == "cuda" else "gloo")

    @staticmethod
    def _choose(name, local_rank):
        if name == "auto":
            name = "cuda" if torch.cuda.is_available() else "cpu"
        try:
            device = torch.device(name)
        except RuntimeError:
            raise SettingsError(f"training.device \"{name}\" is no device: write auto, cpu, cuda or cuda:N") from None
        if device.type not in ("cpu", "cuda"):
            raise SettingsError(f"training.device \"{name}\" is not supported: write auto, cpu, cuda or cuda:N")
        if device.type == "cuda":
            index = local_rank if device.index is None else device.index
            if index >= torch.cuda.device_count():
                raise SettingsError(
                    f"training.device: GPU {index} is not there ({torch.cuda.device_count()} found): write cpu, or"
                    " start fewer processes")
            device = torch.device("cuda", index)
            torch.cuda.set_device(device)
        return device

    @property
    def is_first(self):
        """Whether this process writes files and reports."""
        return self.rank == 0

    def broadcast(self, value):
        """The first process's value, on all."""
        if self.world == 1:
            return value
        box = [value]
        torch.distributed.broadcast_object_list(box, 0, device=self.device if self.device.type == "cuda" else None)
        return box[0]

    def broadcast_tensors(self, tensors):
        """Fills tensors of all processes with the first one's values."""
        if self.world > 1:
            for tensor in tensors:
                torch.distributed.broadcast(tensor, 0)

    def gather(self, value):
        """The values of all processes, by rank."""
        if self.world == 1:
            return [value]
        values = [None] * self.world
        torch.distributed.all_gather_object(values, value)
        return values

    def close(self):
        """Ends what the constructor began."""
        if self._started:
            torch.distributed.destroy_process_group()
