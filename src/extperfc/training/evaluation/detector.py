"""A detector for evaluation from a run, a weights file or a model folder."""

import pathlib

from ..data.dataset import DataError
from .average_precision import Truth
from .model_folder import FolderDetector

BATCH = 8


class TorchDetector:
    """Detections of RGB images by a weights.pt, in float32."""

    def __init__(self, file, device="auto"):
        from ..experiment import ExperimentError
        from ..networks import NETWORKS, build
        from ..strategies import read_weights
        content = read_weights(file)
        if content["network"] not in NETWORKS:
            raise ExperimentError(f"{file}: holds weights of {content['network']}: choose one of {', '.join(NETWORKS)}")
        self._start(build(content["network"], tuple(content["class_names"])), content["weights"], device)

    @classmethod
    def of_network(cls, network, weights, device="auto"):
        """Of a network that was built already."""
        detector = cls.__new__(cls)
        detector._start(network, weights, device)
        return detector

    def _start(self, network, weights, device):
        from ..detecting import LossModule
        from ..processes import Processes
        self.device = Processes(device).device
        network.load_state_dict(weights)
        self.network = network.eval().to(self.device)
        self.class_names, self.losses = tuple(network.class_names), LossModule(network)

    def detect(self, image):
        """Detections, in pixels of the image uint8 [H, W, 3] RGB."""
        return self.detect_many([image])[0]

    def detect_many(self, images):
        """The same for several images at once."""
        import torch

        from ..data.placement import make_input
        from ..detecting import to_numpy
        inputs = [make_input(i, self.network.input_size, self.network.preprocessing.resize) for i in images]
        pixels = torch.stack([torch.from_numpy(pixels) for pixels, _ in inputs]).to(self.device)
        with torch.no_grad():
            found = [to_numpy(d) for d in self.network.detect(self.losses.raw(pixels))]
        return [f._replace(boxes=placement.to_image(f.boxes, image.shape[1::-1]))
                for f, (_, placement), image in zip(found, inputs, images)]


def open_detector(path, backend="opencv", device="auto"):
    """The detector at `path`: weights.pt, the output folder of a run, or a model folder. DataError when it is neither."""
    path = pathlib.Path(path)
    if not path.exists():
        raise DataError(f"{path}: no such file or folder")
    if path.is_dir() and (path / "weights.pt").exists() and not (path / "model.yaml").exists():
        return TorchDetector(path / "weights.pt", device)
    return FolderDetector(path, backend) if path.is_dir() else TorchDetector(path, device)


def detect_all(detector, dataset, progress=None):
    """(Detections, Truths) of all samples, in pixels of their images."""
    detections = []
    for begin in range(0, len(dataset), BATCH):
        images = [sample.read_image() for sample in dataset.samples[begin:begin + BATCH]]
        many = getattr(detector, "detect_many", lambda batch: [detector.detect(image) for image in batch])
        detections += many(images)
        for _ in images:
            if progress:
                progress.step("images")
    return detections, [Truth(s.boxes, s.labels, s.difficult) for s in dataset.samples]
