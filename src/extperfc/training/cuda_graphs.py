"""A network's passes as CUDA graphs, which a GPU starts as a whole instead of call by call."""
import torch


def recorded(module, inputs):
    """The module with one graph of its forward and one of its backward pass, for inputs of these shapes. Statistics and
    weights stay; the module's training mode must, too. RuntimeError where that is not possible.
    """
    statistics = [buffer.clone() for buffer in module.buffers()]
    try:
        return torch.cuda.make_graphed_callables(module, inputs, allow_unused_input=True)
    finally:
        for buffer, before in zip(module.buffers(), statistics):  # recording runs the network a few times
            buffer.copy_(before)
