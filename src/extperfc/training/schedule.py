"""Learning rate and the running average of weights."""

import copy
import math

import torch


def rate_at(step, steps, warmup_steps, final_rate):
    """Factor of the highest learning rate at step 0, 1, ... of `steps`.

    Linear from 1 / (warmup_steps + 1) to 1, then half a cosine down to final_rate (Loshchilov and Hutter, "SGDR", 2017,
    equation 5, without restarts).
    """
    if step < warmup_steps:
        return (step + 1) / (warmup_steps + 1)
    progress = min(1.0, (step - warmup_steps) / max(1, steps - warmup_steps))
    return final_rate + (1 - final_rate) * 0.5 * (1 + math.cos(math.pi * progress))


def two_lists(pairs):
    """([first, ...], [second, ...])."""
    return [one for one, _ in pairs], [other for _, other in pairs]


def copy_all(tensors, others):
    """Copies others into tensors of the same type, pair by pair: by one call where this version of PyTorch has it."""
    if hasattr(torch, "_foreach_copy_"):
        torch._foreach_copy_(tensors, others)
    else:
        for tensor, other in zip(tensors, others):
            tensor.copy_(other)


class WeightAverage:
    """Exponential running average of a network's weights (Polyak averaging); statistics are copied, frozen weights stay.

    The decay grows with the number of updates n as min(decay, (1 + n) / (10 + n)), so that the first weights are
    forgotten. The network keeps its tensors: they are changed in place.
    """

    def __init__(self, network, decay):
        self.network = copy.deepcopy(network).eval()
        self.decay, self.updates = decay, 0
        # Finding a network's tensors takes longer than averaging them: once.
        pairs = zip(self.network.parameters(), network.parameters())
        self.learning = two_lists([pair for pair in pairs if pair[1].requires_grad])
        by_type = {}
        for pair in zip(self.network.buffers(), network.buffers()):
            by_type.setdefault(pair[0].dtype, []).append(pair)
        self.statistics = [two_lists(pairs) for pairs in by_type.values()]
        self.network.requires_grad_(False)

    @torch.no_grad()
    def update(self):
        """Takes the network's weights after an optimizer step."""
        decay = min(self.decay, (1 + self.updates) / (10 + self.updates)) if self.decay else 0.0
        self.updates += 1
        mine, theirs = self.learning
        if mine:
            torch._foreach_mul_(mine, decay)  # as torch.optim does: one call for all tensors
            torch._foreach_add_(mine, theirs, alpha=1 - decay)
        for copies, originals in self.statistics:
            copy_all(copies, originals)

    def state(self):
        return {"updates": self.updates, "weights": self.network.state_dict()}

    def load(self, state):
        self.updates = state["updates"]
        self.network.load_state_dict(state["weights"])
