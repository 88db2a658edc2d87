"""Networks with random weights whose activations are as large as trained ones', for benchmarks and tests."""


def example_network(name, class_names, seed=0):
    """The network in evaluation mode. Its batch normalization has met seeded noise: without that, deep networks
    answer with values near zero, which some libraries compute slowly and every library alike."""
    import torch

    from . import build
    with torch.random.fork_rng(devices=[]):
        torch.manual_seed(seed)
        network = build(name, class_names)
        layers = [module for module in network.modules() if isinstance(module, torch.nn.BatchNorm2d)]
        momenta = [layer.momentum for layer in layers]
        for layer in layers:
            layer.momentum = 0.5
        with torch.no_grad():
            network.train()(torch.randn(2, 3, *reversed(network.input_size)))
        for layer, momentum in zip(layers, momenta):
            layer.momentum = momentum
    return network.eval()
