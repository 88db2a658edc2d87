"""torchvision's ImageNet weights for the backbones, where the user has them. Nothing is downloaded."""

import pathlib

import torch

from .network_error import NetworkError

# network: (torchvision's model, the file that torchvision's downloads are called, where `features.` begins in the
# backbone)
TORCHVISION = {
    "mobilenet_v2_ssd_lite": ("mobilenet_v2", "mobilenet_v2-b0353104.pth"),
    "squeezenet_ssd_lite": ("squeezenet1_1", "squeezenet1_1-b8a52dc0.pth"),
    "vgg16_ssd": ("vgg16", "vgg16-397923af.pth"),
}


def find_file(network_name, weights):
    """The file that `weights` means: a path, or 'torchvision' for the one in torch's cache. NetworkError when it is
    missing."""
    if weights != "torchvision":
        file = pathlib.Path(weights)
        if not file.is_file():
            raise NetworkError(
                f"{file}: no such file: give a file of weights, or 'torchvision' for those in torch's cache"
            )
        return file
    if network_name not in TORCHVISION:
        raise NetworkError(
            f"torchvision has no weights for the backbone of {network_name}: start from random weights, or from"
            f" a weights.pt of extperfc-train (torchvision has them for {', '.join(TORCHVISION)})"
        )
    model, name = TORCHVISION[network_name]
    file = pathlib.Path(torch.hub.get_dir()) / "checkpoints" / name
    if not file.is_file():
        raise NetworkError(f"{file} is missing, and nothing is downloaded unasked. To fetch it: python3 -c"
                           f" 'import torchvision; torchvision.models.{model}(weights=\"IMAGENET1K_V1\")'")
    return file


def layer_places(network):
    """{prefix in torchvision's state dictionary: module of the backbone}."""
    backbone = network.backbone
    if network.name == "mobilenet_v2_ssd_lite":
        return {"features": backbone.features}
    places, index = {}, 0
    for part in backbone.parts:
        for layer in (part if isinstance(part, torch.nn.Sequential) else [part]):
            places[f"features.{index}"] = layer
            index += 1
    return places


def load(network, weights):
    """Copies ImageNet weights into the backbone; layers that torchvision's model lacks stay random.

    NetworkError when the file is missing, or does not hold torchvision's model of this backbone.
    """
    file = find_file(network.name, weights)
    if network.name not in TORCHVISION:
        raise NetworkError(
            f"{file}: {network.name} has no torchvision backbone: start from a weights.pt of extperfc-train"
        )
    state = torch.load(file, map_location="cpu", weights_only=True)
    copied = 0
    for prefix, module in layer_places(network).items():
        own = {key[len(prefix) + 1:]: value for key, value in state.items() if key.startswith(prefix + ".")}
        if not own:
            continue
        try:
            module.load_state_dict(own)
        except RuntimeError as error:
            raise NetworkError(f"{file}: is not torchvision's {TORCHVISION[network.name][0]}: {error}") from None
        copied += len(own)
    if copied == 0:
        raise NetworkError(f"{file}: is not torchvision's {TORCHVISION[network.name][0]}: it has no features.*")
