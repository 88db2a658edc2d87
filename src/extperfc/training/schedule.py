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


class WeightAverage:
    """Exponential running average of a network's weights (Polyak averaging); statistics and frozen weights are copied.

    The decay grows with the number of updates n as min(decay, (1 + n) / (10 + n)), so that the first weights are
    forgotten.
    """

    def __init__(self, network, decay):
        self.network = copy.deepcopy(network).eval()
        self.network.requires_grad_(False)
        self.decay, self.updates = decay, 0

    @torch.no_grad()
    def update(self, network):
        """Takes the weights after an optimizer step."""
        decay = min(self.decay, (1 + self.updates) / (10 + self.updates)) if self.decay else 0.0
        self.updates += 1
        pairs = [*zip(self.network.parameters(), network.parameters())]
        learning = [pair for pair in pairs if pair[1].requires_grad]
        if learning:
            mine, theirs = (list(side) for side in zip(*learning))
            torch._foreach_mul_(mine, decay)  # as torch.optim does: one call for all tensors
            torch._foreach_add_(mine, theirs, alpha=1 - decay)
        frozen = [pair for pair in pairs if not pair[1].requires_grad]
        for value, now in [*frozen, *zip(self.network.buffers(), network.buffers())]:
            value.copy_(now)

    def state(self):
        return {"updates": self.updates, "weights": self.network.state_dict()}

    def load(self, state):
        self.updates = state["updates"]
        self.network.load_state_dict(state["weights"])
