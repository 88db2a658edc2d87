"""Writing model folders: an ONNX file and its model.yaml (models/README.md has the format)."""

import hashlib
import pathlib

import cv2
import numpy as np
import yaml

from ..data.placement import make_input
from .network_error import NetworkError


def write_description(folder, description):
    """model.yaml with the SHA-256 of the network beside it; `description` has the keys of models/README.md. Its
    path."""
    folder = pathlib.Path(folder)
    network = folder / description["file"]
    content = {"name": description["name"], "file": description["file"],
               "sha256": hashlib.sha256(network.read_bytes()).hexdigest()}
    content.update({key: value for key, value in description.items() if key not in content})
    file = folder / "model.yaml"
    file.write_text(yaml.safe_dump(content, sort_keys=False, default_flow_style=None, width=120))
    return file


def read_description(folder):
    """The mapping of a folder's model.yaml; NetworkError when the folder has none or its network is missing."""
    file = pathlib.Path(folder) / "model.yaml"
    if not file.is_file():
        raise NetworkError(f"{folder}: no model.yaml: give a model folder, as extperfc-train export writes it")
    description = yaml.safe_load(file.read_text())
    if not (file.parent / description["file"]).is_file():
        raise NetworkError(f"{file}: there is no {description['file']} beside it: export the network again")
    return description


def input_tensor(image, description):
    """float32 [1, 3, H, W] of an image uint8 [H, W, 3] RGB, as the section `input` of model.yaml says."""
    return placed_input(image, description)[0]


def placed_input(image, description):
    """The same, and the Placement of the image in it."""
    entry = description["input"]
    interpolation = cv2.INTER_AREA if entry.get("interpolation") == "area" else cv2.INTER_LINEAR
    pixels, placement = make_input(image, (entry["width"], entry["height"]), entry.get("resize", "stretch"), interpolation)
    if entry.get("color", "rgb") == "bgr":
        pixels = pixels[..., ::-1]
    mean, scale = (np.broadcast_to(np.float32(entry.get(key, value)), 3) for key, value in (("mean", 0), ("scale", 1)))
    return np.ascontiguousarray(((pixels.astype(np.float32) - mean) * scale).transpose(2, 0, 1)[None]), placement
