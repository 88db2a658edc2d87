"""The paper's five networks: what extperfc-train trains, exports and quantizes."""

import dataclasses
import typing

from .network_error import NetworkError


@dataclasses.dataclass(frozen=True)
class NetworkSpec:
    """A network of the paper. parameters: ours for 3 classes; paper_parameters: what the paper reports for them."""

    title: str
    input_size: typing.Tuple[int, int]
    resize: str
    parameters: int
    paper_parameters: int


NETWORKS = {
    "mobilenet_v1_ssd": NetworkSpec("MobileNetV1-SSD", (300, 300), "stretch", 6_883_296, 6_883_296),
    "mobilenet_v2_ssd_lite": NetworkSpec("MobileNetV2-SSD-Lite", (300, 300), "stretch", 3_087_328, 3_087_328),
    "squeezenet_ssd_lite": NetworkSpec("SqueezeNet-SSD-Lite", (300, 300), "stretch", 1_639_648, 1_639_648),
    "vgg16_ssd": NetworkSpec("VGG16-SSD", (300, 300), "stretch", 24_013_744, 24_013_744),
    "yolov7_tiny_320": NetworkSpec("YOLOv7-tiny 320", (320, 320), "letterbox", 6_020_400, 6_652_669),
    "yolov7_tiny_640": NetworkSpec("YOLOv7-tiny 640", (640, 640), "letterbox", 6_020_400, 6_652_669),
}


def build(name, class_names, weights=None):
    """The DetectionNetwork `name` for these classes (without background), on the CPU, from torch's random generator.

    weights: None, 'torchvision' for ImageNet weights of the backbone in torch's cache, or their path. NetworkError when
    the name or the weights are unknown; nothing is downloaded.
    """
    try:
        from . import source_weights, ssd_networks, yolov7_tiny
    except ImportError as error:
        raise NetworkError(f"{error}; needed: apt install python3-torch python3-torchvision") from None
    if name not in NETWORKS:
        raise NetworkError(f"unknown network {name}: known are {', '.join(NETWORKS)}")
    if not class_names:
        raise NetworkError(f"{name}: there are no classes: name at least one")
    if name.startswith("yolov7_tiny_"):
        network = yolov7_tiny.YoloV7Tiny(class_names, NETWORKS[name].input_size[0])
    else:
        network = getattr(ssd_networks, name)(class_names)
    if weights is not None:
        source_weights.load(network, weights)
    return network
