"""makes an INT8 model folder from a float one, and reports the loss of AP

Calibration images are the training split of the data; the loss is measured on the split of --split. Needs NNCF from
PyPI, which the command says how to install. INT8 networks run on OpenVINO only.
"""

import json
import pathlib


def add_arguments(parser):
    parser.add_argument("model", type=pathlib.Path, help="model folder, as extperfc-train export writes it")
    parser.add_argument("data", type=pathlib.Path, help="Pascal VOC folder, COCO file or folder")
    parser.add_argument("folder", type=pathlib.Path, help="model folder to write")
    parser.add_argument("--calibrate", default="train", help="split of the calibration images (default: train)")
    parser.add_argument("--images", type=int, default=100, help="calibration images at most (default: 100)")
    parser.add_argument("--split", default="test", help="images of the loss of AP (default: test)")
    parser.add_argument("--without-ap", action="store_true", help="measure no loss of AP")
    parser.add_argument("--python", help="interpreter that has NNCF (default: that of the workspace's folder nncf)")
    parser.add_argument("--json", type=pathlib.Path, help="write both evaluations there")


def run(options):
    from ..data import read_dataset
    from ..networks.quantize import evaluate_folder, quantize
    dataset = read_dataset(options.data)
    samples = spread(dataset.split(options.calibrate).samples, options.images)
    evaluated = None if options.without_ap else dataset.split(options.split)
    report = quantize(options.model, [sample.read_image() for sample in samples], options.folder,
                      None if options.without_ap else evaluate_folder, evaluated, options.python)
    print(f"{options.folder}: INT8, calibrated on {len(samples)} images")
    if evaluated is not None:
        for key, title in (("mean_ap50", "AP at IoU 0.50"), ("mean_ap", "AP over IoU 0.01 to 1.00")):
            before, after = report["float"][key], report["int8"][key]
            print(f"  {title}: {before:.4f} float, {after:.4f} INT8, loss {before - after:+.4f}"
                  f" ({len(evaluated)} images of {options.split})")
    if options.json:
        options.json.write_text(json.dumps(report, indent=1) + "\n")
    return 0


def spread(samples, count):
    """At most `count` samples, evenly over all of them."""
    count = max(1, min(count, len(samples)))
    return [samples[i * len(samples) // count] for i in range(count)] if samples else []
