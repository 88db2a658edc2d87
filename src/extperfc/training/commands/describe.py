"""makes a model folder of a YOLO (v5 to v11) or SSD in ONNX that another program trained

Finds the layout of the outputs from their shapes and writes model.yaml. Guide: docs/own_models.md.
"""

import pathlib


def add_arguments(parser):
    parser.add_argument("network", type=pathlib.Path, help="ONNX file")
    parser.add_argument("folder", type=pathlib.Path, help="model folder to write")
    parser.add_argument(
        "--classes",
        required=True,
        help="names in the order of training: cone,cube,sphere, or a file with one per"
        " line, or the YAML file of a YOLO data set",
    )
    parser.add_argument("--name", help="what logs call the model (default: the file's name)")
    parser.add_argument(
        "--size", type=int, nargs=2, metavar=("WIDTH", "HEIGHT"), help="of an input without fixed size [px]"
    )
    parser.add_argument("--color", choices=("rgb", "bgr"), help="instead of rgb")
    parser.add_argument(
        "--resize", choices=("stretch", "letterbox"), help="instead of letterbox (YOLO) and stretch (SSD)"
    )
    parser.add_argument(
        "--mean", type=float, nargs="+", help="one number or three, 8-bit units, instead of 0 (YOLO) and 127 (SSD)"
    )
    parser.add_argument("--scale", type=float, nargs="+", help="one or three, instead of 1/255 (YOLO) and 1/128 (SSD)")
    parser.add_argument("--source", default="", help="where the network comes from, for model.yaml")
    parser.add_argument("--license", default="", help="its terms, for model.yaml")


def run(options):
    from ..networks.describe import describe, read_classes
    from ..networks.network_error import NetworkError
    given = {key: getattr(options, key) for key in ("color", "resize") if getattr(options, key)}
    for key in ("mean", "scale"):
        values = getattr(options, key)
        if values is not None and len(values) not in (1, 3):
            raise NetworkError(f"--{key} takes one number or three, not {len(values)}")
        if values is not None:
            given[key] = values[0] if len(values) == 1 else values
    found = describe(options.network, read_classes(options.classes), options.folder, options.size, options.name, given,
                     options.source, options.license)
    for library, result in found.items():
        print(f"{library}: {result}")
    if "works" not in found.values():
        raise NetworkError(
            f"{options.network}: no library can run it: export it with opset 12 or lower and a fixed size"
        )
    print(
        f"{options.folder}: ready; tools/extperfc-model run {options.folder} IMAGE --out boxes.png shows what it finds"
    )
    return 0
