"""The three transfer learning strategies of the ExtPerFC paper (its part on 2D object detection).

In the terms of Pan and Yang, "A Survey on Transfer Learning" (2010): a domain D = {X, P(X)}, a task T = {Y, f}. The
source model f_S with weights (theta_S, phi_S) was trained on the source domain, theta being those of the backbone
(feature extractor) and phi those of the head; L is the network's loss over the labelled images of the target domain
D_T.
"""

import dataclasses
import pathlib
import typing

import torch

from .experiment import ExperimentError

FORMAT = 1  # of weights files


@dataclasses.dataclass(frozen=True)
class Transfer:
    """What a strategy did: names of copied tensors, of those that stayed random with the reason, and of frozen ones."""

    copied: typing.Tuple[str, ...] = ()
    initialized: typing.Dict[str, str] = dataclasses.field(default_factory=dict)
    frozen: typing.Tuple[str, ...] = ()

    def text(self):
        """One line for a terminal, and one for each reason why tensors stayed random."""
        head = (f"{len(self.copied)} tensors copied, {len(self.frozen)} frozen, {len(self.initialized)} initialized at"
                " random")
        reasons = {}
        for name, why in self.initialized.items():
            reasons.setdefault(why, []).append(name)
        return "\n".join([head, *(f"  {', '.join(names[:3])}{' ...' if len(names) > 3 else ''}: {why}"
                                  for why, names in reasons.items())])


class RandomWeights:
    """Random weights: (theta, phi)* = argmin L(theta, phi; D_T) from (theta, phi) drawn at random.

    No knowledge of a source domain; the reference that the transfers are compared with.
    """

    name = "random_weights"

    def start(self, network, source=None):
        """Leaves the network as it was built."""
        return Transfer()

    def set_train_mode(self, network):
        """All of the network learns."""
        network.train()


class FeatureRepresentationTransfer(RandomWeights):
    """Feature-representation transfer: theta = theta_S stays, phi* = argmin L(theta_S, phi; D_T) from random phi.

    The backbone is copied and frozen, its batch normalization statistics included: source and target domain have the
    same feature representation. The head is learned anew.
    """

    name = "feature_representation_transfer"

    def start(self, network, source=None):
        """Copies source["weights"] into the backbone and freezes it. ExperimentError when they do not fit."""
        state = {key: value for key, value in weights_of(source, network).items() if key in backbone_names(network)}
        copied, left = copy_matching(network, state, backbone_names(network))
        if left:
            raise ExperimentError(f"source: its backbone is not that of {network.name}: " + "; ".join(
                f"{name} {why}" for name, why in list(left.items())[:3]))
        frozen = []
        for parameter_name, parameter in network.named_parameters():
            if parameter_name in backbone_names(network):
                parameter.requires_grad_(False)
                frozen.append(parameter_name)
        head = {
            name: "the head is learned anew"
            for name in network.state_dict() if name not in backbone_names(network)
        }
        return Transfer(tuple(copied), head, tuple(frozen))

    def set_train_mode(self, network):
        """The head learns; the backbone keeps the statistics of its batch normalization."""
        network.train()
        network.backbone.eval()


class InstanceTransfer(RandomWeights):
    """Instance transfer: (theta, phi)* = argmin L(theta, phi; D_T) from (theta_S, phi_S), everything fine-tuned.

    Layers of the head whose shape depends on the number of classes fit only when both domains have as many; otherwise
    they start at random, and the report names them.
    """

    name = "instance_transfer"

    def start(self, network, source=None):
        """Copies all of source["weights"] that fits. ExperimentError when the backbone does not."""
        copied, left = copy_matching(network, weights_of(source, network), list(network.state_dict()))
        foreign = [name for name in left if name in backbone_names(network)]
        if foreign:
            raise ExperimentError(
                f"source: its backbone is not that of {network.name}: {foreign[0]} {left[foreign[0]]}")
        return Transfer(tuple(copied), left)


STRATEGIES = {cls.name: cls() for cls in (RandomWeights, FeatureRepresentationTransfer, InstanceTransfer)}


def backbone_names(network):
    """Names in state_dict() of the backbone's weights and statistics."""
    of_backbone = {id(tensor) for tensor in network.backbone.state_dict(keep_vars=True).values()}
    return {name for name, tensor in network.state_dict(keep_vars=True).items() if id(tensor) in of_backbone}


def weights_of(source, network):
    """The tensors of a source model; ExperimentError when it is another network."""
    if source is None:
        raise ExperimentError("source is missing: the strategy needs the weights.pt of a source model")
    if source.get("network") not in (None, network.name):
        raise ExperimentError(
            f"source holds weights of {source['network']}, not of {network.name}: train a source model of"
            " the same network")
    return source["weights"]


def copy_matching(network, state, names):
    """Copies tensors of the same name and shape; (names copied, {name: why not})."""
    copied, left = [], {}
    own = network.state_dict()
    for name in names:
        if name not in state:
            left[name] = "is not in the source model"
        elif state[name].shape != own[name].shape:
            left[name] = f"has shape {list(own[name].shape)}, in the source model {list(state[name].shape)}"
        else:
            own[name].copy_(state[name])
            copied.append(name)
    return copied, left


def read_weights(file):
    """The dictionary of a weights.pt: network, class_names, weights (tensors by name), about (JSON: metrics,
    experiment, git). ExperimentError for other files.

    A plain state dictionary, as torchvision saves them, is taken too; its network is None. Code in a file is never run.
    """
    file = pathlib.Path(file)
    try:
        content = torch.load(file, map_location="cpu", weights_only=True)
    except FileNotFoundError:
        raise ExperimentError(f"{file}: no such file; extperfc-train train writes it as weights.pt") from None
    except Exception as error:  # torch raises whatever its unpickler meets
        raise ExperimentError(f"{file}: is no weights file ({str(error).splitlines()[0][:120]})") from None
    if isinstance(content, dict) and content.get("format") == FORMAT and "weights" in content:
        return content
    if isinstance(content, dict) and content and all(isinstance(v, torch.Tensor) for v in content.values()):
        return {"format": FORMAT, "network": None, "class_names": (), "weights": content}
    raise ExperimentError(f"{file}: is no weights file of extperfc-train: give the weights.pt of a run")
