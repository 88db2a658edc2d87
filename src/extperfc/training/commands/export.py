"""writes trained weights as a model folder that the detector loads

The folder has an ONNX file (opset 10) and model.yaml. PyTorch, OpenCV DNN and OpenVINO must give the same answer, or
the command fails.
"""

import pathlib


def add_arguments(parser):
    parser.add_argument("weights", type=pathlib.Path, help="weights.pt, or the output folder of a run")
    parser.add_argument("folder", type=pathlib.Path, help="model folder to write")
    parser.add_argument(
        "--score",
        type=float,
        default=0.5,
        help="score threshold of the model (default: 0.5); extperfc-train evaluate prints"
        " the one of the best F1",
    )
    parser.add_argument("--nms-iou", type=float, default=0.45, help="of two boxes that overlap more the better stays"
                        " (default: 0.45)")
    parser.add_argument("--license", default="", help="terms of the weights, for model.yaml")


def run(options):
    from ..networks import build
    from ..networks.export import export
    from ..networks.network_error import NetworkError
    from ..strategies import read_weights
    for name in ("score", "nms_iou"):
        if not 0 <= getattr(options, name) <= 1:
            raise NetworkError(f"--{name.replace('_', '-')} must be from 0 to 1, not {getattr(options, name):g}")
    file = options.weights / "weights.pt" if options.weights.is_dir() else options.weights
    content = read_weights(file)
    if content["network"] is None:
        raise NetworkError(f"{file}: does not say which network it is of: give a weights.pt of extperfc-train")
    network = build(content["network"], tuple(content["class_names"]))
    network.load_state_dict(content["weights"])
    export(network, options.folder, network.class_names, {"score": options.score, "nms_iou": options.nms_iou},
           license=options.license)
    print(f"{options.folder}: {content['network']}; tools/extperfc-model check {options.folder} measures it")
    return 0
