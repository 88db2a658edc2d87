"""Networks of ONNX files on the libraries that can run them: OpenCV DNN, OpenVINO, ONNX Runtime.

Each runtime is made from (file, output names, device, threads; 0 threads: the library chooses) and has run(input
float32 [1, 3, H, W]) -> list of tensors, and `execution`: what it runs on. RuntimeMissing when the library cannot be
imported.
"""

import os
import pathlib
import sys

import cv2
import numpy as np

from .network_error import NetworkError, RuntimeMissing

OPENCV_WARNINGS = 3  # its default level of messages

def workspace():
    """The folder that tools/setup builds in."""
    checkout = pathlib.Path(__file__).resolve().parents[4]
    if "EXTPERFC_WS" in os.environ:
        return pathlib.Path(os.environ["EXTPERFC_WS"])
    return checkout / "build/ws" if (checkout / "build/ws").is_dir() else checkout / ".ws"


def import_openvino():
    """The module `openvino`: an installed one, else that of tools/setup."""
    place = str(workspace() / "openvino")
    if place not in sys.path:
        sys.path.append(place)
    try:
        import openvino
    except ImportError as error:
        raise RuntimeMissing(f"OpenVINO cannot be imported ({error}): run tools/setup") from None
    return openvino


class OpenCv:
    """OpenCV's DNN module on the CPU; the number of threads holds for the whole process."""

    name = "opencv"

    def __init__(self, file, names=None, device="CPU", threads=0):
        if device != "CPU":
            raise NetworkError(f"OpenCV DNN runs on the CPU only, not on {device}")
        cv2.setLogLevel(0)  # its errors say the same
        try:
            self.net = cv2.dnn.readNetFromONNX(str(file))
        except cv2.error as error:
            raise NetworkError(f"{file}: OpenCV {cv2.__version__} cannot read it: {last_line(error)}") from None
        finally:
            cv2.setLogLevel(OPENCV_WARNINGS)
        if threads:
            cv2.setNumThreads(threads)
        self.names = names or list(self.net.getUnconnectedOutLayersNames())
        self.execution = f"CPU f32, {cv2.getNumThreads()} threads"

    @staticmethod
    def devices():
        return ["CPU"]

    @staticmethod
    def version():
        return cv2.__version__

    def run(self, tensor):
        self.net.setInput(tensor)
        try:
            return [np.asarray(values) for values in self.net.forward(self.names)]
        except cv2.error as error:
            raise NetworkError(f"OpenCV {cv2.__version__} cannot run the network: {last_line(error)}") from None


class OpenVino:
    """OpenVINO with f32 arithmetic (left alone it takes bf16, which is slower for small networks); quantized layers
    stay INT8."""

    name = "openvino"

    def __init__(self, file, names=None, device="CPU", threads=0):
        self.openvino = import_openvino()
        config = {"INFERENCE_PRECISION_HINT": "f32", "PERFORMANCE_HINT": "LATENCY"}
        if threads and device == "CPU":
            config["INFERENCE_NUM_THREADS"] = threads
        try:
            self.compiled = self.openvino.Core().compile_model(str(file), device, config)
        except RuntimeError as error:
            raise NetworkError(f"{file}: OpenVINO cannot compile it for {device}: {last_line(error)}") from None
        self.request = self.compiled.create_infer_request()
        self.ports = [self.compiled.output(name) for name in names] if names else self.compiled.outputs
        self.execution = " ".join([*self.compiled.get_property("EXECUTION_DEVICES"), "f32"])

    @staticmethod
    def devices():
        return list(import_openvino().Core().available_devices)

    @staticmethod
    def version():
        return import_openvino().__version__

    def run(self, tensor):
        self.request.set_input_tensor(self.openvino.Tensor(tensor, shared_memory=True))
        self.request.infer()
        return [self.request.get_tensor(port).data for port in self.ports]


class OnnxRuntime:
    """ONNX Runtime on the CPU, where its Python package is installed; the C++ detector does not use it."""

    name = "onnxruntime"

    def __init__(self, file, names=None, device="CPU", threads=0):
        onnxruntime = self._library()
        if device != "CPU":
            raise NetworkError(f"ONNX Runtime is measured on the CPU only, not on {device}")
        options = onnxruntime.SessionOptions()
        options.intra_op_num_threads = threads
        self.session = onnxruntime.InferenceSession(str(file), options, providers=["CPUExecutionProvider"])
        self.names, self.input = names, self.session.get_inputs()[0].name
        self.execution = "CPU f32"

    @staticmethod
    def _library():
        try:
            import onnxruntime
        except ImportError:
            raise RuntimeMissing("ONNX Runtime is not installed: python3 -m pip install onnxruntime") from None
        return onnxruntime

    @classmethod
    def devices(cls):
        cls._library()
        return ["CPU"]

    @classmethod
    def version(cls):
        return cls._library().__version__

    def run(self, tensor):
        return self.session.run(self.names, {self.input: tensor})


RUNTIMES = {runtime.name: runtime for runtime in (OpenCv, OpenVino, OnnxRuntime)}


def last_line(error):
    """What a library complains of: the last line that says something."""
    lines = [line.strip("> ") for line in str(error).splitlines() if line.strip("> ")]
    return lines[-1][:200] if lines else type(error).__name__
