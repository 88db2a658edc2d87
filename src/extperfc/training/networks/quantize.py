"""INT8 model folders by NNCF's post-training quantization: a quarter of the size, and two to four times as fast on a
CPU with VNNI."""

import os
import pathlib
import shutil
import subprocess
import sys
import tempfile

import numpy as np

from .model_folder import input_tensor, read_description, write_description
from .network_error import NetworkError
from .runtimes import import_openvino, last_line, workspace

MIN_IMAGES = 20
PACKAGES = "nncf onnxruntime 'onnx>=1.17' 'ml_dtypes<0.6' 'numpy<2'"


def nncf_python(python=None):
    """The interpreter that has NNCF: the given one, that of the workspace's folder nncf, or this one. NetworkError
    with the commands that install it when none has."""
    place = workspace() / "nncf"
    python = str(python or (place / "bin/python" if (place / "bin/python").exists() else sys.executable))
    script = "import sys; sys.modules['torch'] = None; import nncf, onnx, onnxruntime"
    try:
        tried = subprocess.run([python, "-c", script], capture_output=True, text=True, check=False)
    except OSError as error:
        raise NetworkError(f"{python}: cannot be run: {error.strerror}") from None
    if tried.returncode == 0:
        return python
    raise NetworkError(f"{python} has no NNCF ({last_line(tried.stderr)}). To install it: /usr/bin/python3 -m venv"
                       f" --system-site-packages {place} && {place}/bin/pip install {PACKAGES}")


def quantize(folder, calibration_images, output, evaluate=None, dataset=None, python=None):
    """Writes the INT8 model folder `output`; returns {"folder", "float": ..., "int8": ..., "ap_loss": ...}.

    calibration_images: at least 20 images uint8 [H, W, 3] RGB of the kind that the robot sees, none of the test split.
    evaluate(folder, dataset) -> {"mean_ap": ...} is called with both folders when given; ap_loss is the difference of
    both.
    """
    folder, output = pathlib.Path(folder), pathlib.Path(output)
    description = read_description(folder)
    if len(calibration_images) < MIN_IMAGES:
        raise NetworkError(
            f"{len(calibration_images)} calibration images are too few: give at least {MIN_IMAGES}, 100 or more"
            " are better"
        )
    if output.resolve() == folder.resolve():
        raise NetworkError(f"{output}: is the folder of the float network: give another one")
    python = nncf_python(python)
    output.mkdir(parents=True, exist_ok=True)
    name = pathlib.Path(description["file"]).stem + "_int8.onnx"
    with tempfile.TemporaryDirectory() as scratch:
        inputs = write_inputs(pathlib.Path(scratch) / "inputs.npy", calibration_images, description)
        run_nncf(python, folder / description["file"], inputs, output / name)
    copy_class_file(folder, output, description)
    source = "; ".join(part for part in (description.get("source"), "quantized to INT8 by NNCF") if part)
    write_description(output, {**{k: v for k, v in description.items() if k != "sha256"},
                               "name": description["name"] + "_int8", "file": name, "source": source})
    return {"folder": str(output), **ap_loss(folder, output, evaluate, dataset)}


def write_inputs(file, images, description):
    """Calibration inputs as a .npy file, one image in memory at a time."""
    entry = description["input"]
    shape = (len(images), 3, entry["height"], entry["width"])
    inputs = np.lib.format.open_memmap(file, "w+", np.float32, shape)
    for row, image in zip(inputs, images):
        row[:] = input_tensor(image, description)[0]
    inputs.flush()
    return file


def run_nncf(python, network, inputs, output):
    """Runs nncf_process.py; NetworkError with its last words."""
    script = pathlib.Path(__file__).with_name("nncf_process.py")
    environment = {key: value for key, value in os.environ.items() if key != "PYTHONPATH"}
    done = subprocess.run([python, str(script), str(network), str(inputs), str(output)], capture_output=True, text=True,
                          check=False, env=environment)
    if done.returncode != 0 or not output.is_file():
        raise NetworkError(f"{network}: NNCF failed: {last_line(done.stderr)}")


def copy_class_file(folder, output, description):
    """The list of classes, where it is a file."""
    if "classes_file" in description:
        shutil.copyfile(folder / description["classes_file"], output / description["classes_file"])


def ap_loss(folder, output, evaluate, dataset):
    """Results of both folders and the loss of mean AP."""
    if evaluate is None:
        return {}
    before, after = evaluate(folder, dataset), evaluate(output, dataset)
    return {"float": before, "int8": after, "ap_loss": before["mean_ap"] - after["mean_ap"]}


def evaluate_folder(folder, dataset):
    """Evaluation.as_dict() of a model folder on OpenVINO, which runs INT8 networks; see training/evaluation."""
    from ..evaluation import evaluate
    from ..evaluation.detector import detect_all
    from ..evaluation.model_folder import FolderDetector
    import_openvino()
    detector = FolderDetector(folder, "openvino")
    return evaluate(*detect_all(detector, dataset.with_classes(detector.class_names)), detector.class_names).as_dict()
