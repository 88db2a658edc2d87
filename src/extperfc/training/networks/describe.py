"""A model folder for an ONNX file from elsewhere: finds out from its shapes how its outputs are laid out.

Known are what the exporters of YOLOv5 to v11 and of SSDs write (docs/own_models.md).
"""

import pathlib
import shutil
import typing

import yaml

from .model_folder import write_description
from .network_error import NetworkError, RuntimeMissing
from .runtimes import OpenCv, OpenVino, import_openvino, last_line

ANCHOR_SIZES = {
    8: [[10, 13], [16, 30], [33, 23]],
    16: [[30, 61], [62, 45], [59, 119]],
    32: [[116, 90], [156, 198], [373, 326]],
}
YOLO_INPUT = {"resize": "letterbox", "mean": 0.0, "scale": 0.00392156863}
SSD_INPUT = {"resize": "stretch", "mean": 127.0, "scale": 0.0078125}
MAX_END_TO_END = 1000  # rows of a network that suppresses overlaps itself
NO_LAYOUT = (
    "none of its outputs {shapes} is that of a detector with {count} classes: check the class list, and export raw"
    " detections without suppression, of a fixed size (docs/own_models.md)"
)


class Ports(typing.NamedTuple):
    """An ONNX file's input, {name: shape}, and outputs, {name: shape}; None: not fixed."""

    inputs: typing.Dict[str, tuple]
    outputs: typing.Dict[str, tuple]


def read_ports(file, size=None):
    """Ports of a file, with the input fixed to `size` (width, height) when given. NetworkError when it cannot be
    read."""
    openvino = import_openvino()
    if not pathlib.Path(file).is_file():
        raise NetworkError(f"{file}: no such file")
    try:
        model = openvino.Core().read_model(str(file))
        if size is not None:
            model.reshape([1, 3, size[1], size[0]])
    except RuntimeError as error:
        raise NetworkError(f"{file}: OpenVINO cannot read it: {last_line(error)}") from None

    def shapes(ports):
        return {port.get_any_name(): tuple(None if d.is_dynamic else d.get_length() for d in port.get_partial_shape())
                for port in ports}
    return Ports(shapes(model.inputs), shapes(model.outputs))


def input_entry(ports, file):
    """name, width and height of the section `input`."""
    if len(ports.inputs) != 1:
        raise NetworkError(
            f"{file}: has {len(ports.inputs)} inputs ({', '.join(ports.inputs)}), not one image: export it without"
            " preprocessing or thresholds in the graph"
        )
    (name, shape), = ports.inputs.items()
    if len(shape) != 4 or shape[1] != 3 or None in shape[2:]:
        raise NetworkError(
            f"{file}: its input {name} is {text(shape)}, not [1, 3, height, width]: export it with a fixed size"
            " (dynamic=False), or give --size WIDTH HEIGHT"
        )
    return {"name": name, "width": shape[3], "height": shape[2]}


def text(shape):
    """A shape in words."""
    return "[" + ", ".join("?" if n is None else str(n) for n in shape) + "]"


def find_layout(ports, classes, size):
    """The section `output` and defaults of the section `input` for a network with so many classes; NetworkError,
    without the file's name, when no layout fits."""
    for rule in (yolo_rows, yolo_columns, ssd, yolo_anchors):
        found = rule(ports.outputs, classes, size)
        if found is not None:
            return found
    for name, shape in ports.outputs.items():
        refuse_known(name, shape, classes)
    shapes = ", ".join(f"{name} {text(shape)}" for name, shape in ports.outputs.items())
    raise NetworkError(NO_LAYOUT.format(shapes=shapes, count=classes))


def refuse_known(name, shape, classes):
    """What exporters write under other options, with the option that helps."""
    if len(shape) == 5 and shape[-1] == 5 + classes:
        raise NetworkError(
            f"output {name} {text(shape)} has five axes, which OpenCV cannot run: export with the decoding in the"
            " graph (YOLOv7: export.py --grid; YOLOv5: export.py --include onnx)"
        )
    if len(shape) == 3 and shape[2] in (6, 7) and (shape[1] or 0) <= MAX_END_TO_END:
        raise NetworkError(
            f"output {name} {text(shape)} has suppressed overlaps itself: export raw detections (YOLOv8 to v11:"
            " nms=False; YOLOv7: without --end2end; YOLOv10 has no such form: use v8, v9 or v11)"
        )


def yolo_rows(outputs, classes, size):
    """[1, N, 5 + C]: YOLOv5 and v7, decoded. Further outputs, which YOLOv5 of 2020 and 2021 has, are left alone."""
    for name, shape in outputs.items():
        if len(shape) == 3 and shape[2] == 5 + classes and (shape[1] or 0) > MAX_END_TO_END // 10:
            return {"layout": "yolo_v7", "names": [name]}, YOLO_INPUT
    return None


def yolo_columns(outputs, classes, size):
    """[1, 4 + C, N]: YOLOv8, v9 and v11."""
    for name, shape in outputs.items():
        if len(outputs) == 1 and len(shape) == 3 and shape[1] == 4 + classes and (shape[2] or 0) > 4 + classes:
            return {"layout": "yolo_v8", "names": [name]}, YOLO_INPUT
    return None


def ssd(outputs, classes, size):
    """[1, N, 4] and [1, N, C] or [1, N, 1 + C], the background first: boxes decoded, scores after softmax."""
    if len(outputs) != 2 or any(len(shape) != 3 for shape in outputs.values()):
        return None
    boxes = [name for name, shape in outputs.items() if shape[2] == 4]
    if len(boxes) == 2:  # three classes and the background are four columns too
        boxes = [name for name in boxes if "box" in name.lower() or "loc" in name.lower()]
    if len(boxes) != 1:
        return None
    scores, = (name for name in outputs if name not in boxes)
    columns = outputs[scores][2]
    if columns not in (classes, classes + 1) or outputs[scores][1] != outputs[boxes[0]][1]:
        return None
    output = {"layout": "ssd", "names": [*boxes, scores]}
    if columns == classes + 1:
        output["background_class"] = 0
    return output, SSD_INPUT


def yolo_anchors(outputs, classes, size):
    """Per level [1, A * (5 + C), rows, columns]: raw heads of YOLOv5 and v7, with the anchors of COCO."""
    levels = []
    for name, shape in outputs.items():
        if len(shape) != 4 or shape[1] != 3 * (5 + classes) or not shape[3] or size[0] // shape[3] not in ANCHOR_SIZES:
            return None
        levels.append((size[0] // shape[3], name))
    anchors = [{"stride": stride, "sizes": ANCHOR_SIZES[stride]} for stride, _ in sorted(levels)]
    return {"layout": "yolo_anchors", "names": [name for _, name in sorted(levels)], "anchors": anchors}, YOLO_INPUT


def read_classes(classes):
    """Class names from a comma-separated list, a file with one per line, or the YAML file of a YOLO data set
    (`names`)."""
    file = pathlib.Path(classes)
    if not file.is_file():
        if file.suffix in (".txt", ".yaml", ".yml", ".names"):
            raise NetworkError(f"{file}: no such file")
        names = classes.split(",")
    elif file.suffix in (".yaml", ".yml"):
        names = (yaml.safe_load(file.read_text()) or {}).get("names")
        names = list(names.values()) if isinstance(names, dict) else names
    else:
        names = file.read_text().splitlines()
    names = [str(name).strip() for name in names or [] if str(name).strip()]
    if not names or len(set(names)) != len(names):
        raise NetworkError(f"{classes}: must name at least one class, each once")
    return names


def describe(file, class_names, folder, size=None, name=None, input_options=None, source="", license=""):
    """Copies an ONNX file into `folder` and writes model.yaml beside it.

    size: width and height in pixels, for a network whose input is not fixed. input_options: {"resize", "color", "mean",
    "scale"}, those that differ from the exporter's habit. Returns {library: "works" or why it does not}.
    """
    file, folder = pathlib.Path(file), pathlib.Path(folder)
    ports = read_ports(file, size)
    entry = input_entry(ports, file)
    try:
        output, habits = find_layout(ports, len(class_names), (entry["width"], entry["height"]))
    except NetworkError as error:
        raise NetworkError(f"{file}: {error}") from None
    folder.mkdir(parents=True, exist_ok=True)
    network = folder / file.name
    if network.resolve() != file.resolve():
        shutil.copyfile(file, network)
    write_description(
        folder,
        {
            "name": name or file.stem,
            "file": file.name,
            "input": {**entry, "color": "rgb", **habits, **(input_options or {})},
            "output": output,
            "classes": list(class_names),
            "source": source,
            "license": license,
        },
    )
    return {runtime.name: try_out(runtime, network, output["names"], entry) for runtime in (OpenVino, OpenCv)}


def try_out(runtime, network, names, entry):
    """"works", or why the library cannot run the network."""
    import numpy as np
    try:
        runtime(network, names).run(np.zeros((1, 3, entry["height"], entry["width"]), np.float32))
    except (NetworkError, RuntimeMissing) as error:
        return str(error)
    return "works"
