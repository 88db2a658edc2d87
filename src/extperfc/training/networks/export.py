"""A trained network as a model folder: an ONNX file that OpenCV DNN 4.6 and OpenVINO read alike, and model.yaml."""

import pathlib
import warnings

import numpy as np

from .model_folder import input_tensor, read_description, write_description
from .network_error import NetworkError, RuntimeMissing
from .runtimes import OpenCv, OpenVino

OPSET = 10  # OpenCV 4.6 rejects ReLU6 of later sets
TOLERANCE = 1e-3  # of agreement()
INPUT = "images"


def export(network, folder, class_names, thresholds=None, source="trained by extperfc-train", license=""):
    """Writes `folder`, made if need be; returns it. thresholds: {"score", "nms_iou", "max_detections"} or some of them.

    NetworkError when a library reads the file differently, or python3-onnx is missing.
    """
    if tuple(class_names) != tuple(network.class_names):
        raise NetworkError(f"{network.name} was built for the classes {', '.join(network.class_names)}, not"
                           f" {', '.join(class_names)}")
    folder = pathlib.Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    module, names, output = network.export_form()
    was_training = network.training
    network.eval()
    write_onnx(module.eval(), network.input_size, names, folder / f"{network.name}.onnx")
    write_description(folder, describe(network, output, thresholds, source, license))
    difference = agreement(folder, [example_image(network.input_size)], network)
    network.train(was_training)
    if difference > TOLERANCE:
        raise NetworkError(
            f"{folder}: PyTorch, OpenCV and OpenVINO differ by {difference:.2g}, more than {TOLERANCE:g}: report"
            " the versions of these libraries"
        )
    return folder


def describe(network, output, thresholds, source, license):
    """model.yaml of a network."""
    width, height = network.input_size
    entry = {"name": INPUT, "width": width, "height": height, "color": network.preprocessing.color,
             "resize": network.preprocessing.resize, "mean": list(network.preprocessing.mean),
             "scale": [float(f"{value:.9g}") for value in network.preprocessing.scale]}
    return {"name": network.name, "file": f"{network.name}.onnx", "input": entry, "output": output,
            "classes": list(network.class_names), "thresholds": {"score": 0.5, "nms_iou": 0.45, **(thresholds or {})},
            "source": source, "license": license}


def write_onnx(module, input_size, names, file):
    """ONNX of a module in evaluation mode, each of its weights a tensor of its own."""
    import torch
    device = next(module.parameters()).device
    example = torch.zeros(1, 3, *reversed(input_size), device=device)
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore")  # onnx:Resize: nearest by a factor of two is the same in every set
        torch.onnx.export(module, example, str(file), opset_version=OPSET, input_names=[INPUT], output_names=names)
    expand_shared_weights(file)


def expand_shared_weights(file):
    """Copies weights that the exporter merged because they are equal: OpenCV 4.6 rejects the Identity nodes (its issue
    22446)."""
    try:
        import onnx
    except ImportError:
        raise NetworkError("exporting needs the Python package onnx: apt install python3-onnx") from None
    model = onnx.load(str(file))
    weights = {weight.name: weight for weight in model.graph.initializer}
    for node in [node for node in model.graph.node if node.op_type == "Identity" and node.input[0] in weights]:
        copy = model.graph.initializer.add()
        copy.CopyFrom(weights[node.input[0]])
        copy.name = node.output[0]
        model.graph.node.remove(node)
    onnx.checker.check_model(model)
    onnx.save(model, str(file))


def example_image(input_size):
    """Seeded noise, smooth enough to resemble an image: uint8 [H, W, 3]."""
    import cv2
    noise = np.random.default_rng(0).integers(0, 256, (12, 12, 3), np.uint8)
    return cv2.resize(noise, input_size, interpolation=cv2.INTER_CUBIC)


def agreement(folder, images, network=None):
    """Largest difference of any output value between OpenCV, OpenVINO and, if given, PyTorch's network, over images
    uint8 [H, W, 3] RGB; relative to the largest value of its tensor where that exceeds 1. OpenVINO is left out where
    it is not installed."""
    folder = pathlib.Path(folder)
    description = read_description(folder)
    names = description["output"]["names"]
    runs = [OpenCv(folder / description["file"], names).run]
    try:
        runs.append(OpenVino(folder / description["file"], names).run)
    except RuntimeMissing as missing:
        warnings.warn(f"{missing}; not compared", stacklevel=2)
    if network is not None:
        runs.append(lambda tensor: torch_outputs(network, tensor))
    largest = 0.0
    for image in images:
        tensor = input_tensor(image, description)
        answers = [[np.array(values) for values in run(tensor)] for run in runs]
        largest = max(
            [largest, *(deviation(first, other) for answer in answers[1:] for first, other in zip(answers[0], answer))]
        )
    return largest


def deviation(first, other):
    """Largest difference of two tensors, relative to the largest value where that exceeds 1."""
    return float(np.abs(first - other).max() / max(1.0, np.abs(first).max()))


def torch_outputs(network, tensor):
    """The exported tensors, by PyTorch."""
    import torch
    module = network.export_form()[0].eval()
    device = next(module.parameters()).device
    with torch.no_grad():
        return [values.cpu().numpy() for values in module(torch.from_numpy(tensor).to(device))]
