"""The four SSD networks of the paper at 300 x 300, on torchvision's backbones where it has them.

Layers beyond the backbones are those whose parameter counts the paper reports (docs/training_networks.md has the
counts).
"""

import torchvision
from torch import nn

from .priors import PriorLevel
from .ssd import Ssd, start_convolution

LEVELS = (PriorLevel(19, 16, 60, 105), PriorLevel(10, 32, 105, 150), PriorLevel(5, 64, 150, 195),
          PriorLevel(3, 100, 195, 240), PriorLevel(2, 150, 240, 285), PriorLevel(1, 300, 285, 330))
SQUEEZENET_LEVELS = (PriorLevel(17, 16, 60, 105), *LEVELS[1:])
VGG_LEVELS = (PriorLevel(38, 8, 30, 60, (2,)), PriorLevel(19, 16, 60, 111), PriorLevel(10, 32, 111, 162),
              PriorLevel(5, 64, 162, 213), PriorLevel(3, 100, 213, 264, (2,)), PriorLevel(1, 300, 264, 315, (2,)))


class Split(nn.Module):
    """Layers one after the other; gives the maps after each of `parts`."""

    def __init__(self, *parts):
        super().__init__()
        self.parts = nn.ModuleList(parts)

    def forward(self, images):
        maps = []
        for part in self.parts:
            images = part(images)
            maps.append(images)
        return maps


def normalized(inputs, outputs, stride=1, kernel=3, groups=1):
    """Convolution without bias, batch normalization, ReLU."""
    return [nn.Conv2d(inputs, outputs, kernel, stride, kernel // 2, groups=groups, bias=False), nn.BatchNorm2d(outputs),
            nn.ReLU(inplace=True)]


def separable(inputs, outputs, stride=1, padding=1, normalize=True):
    """SSD-Lite's replacement of a 3 x 3 convolution: depthwise, then 1 x 1 (Sandler et al. 2018, section 6.2)."""
    return nn.Sequential(nn.Conv2d(inputs, inputs, 3, stride, padding, groups=inputs),
                         *([nn.BatchNorm2d(inputs)] if normalize else []), nn.ReLU(inplace=True),
                         nn.Conv2d(inputs, outputs, 1))


def plain_predictor(inputs, outputs, is_last):
    """3 x 3 convolution, as in the SSD paper."""
    return nn.Conv2d(inputs, outputs, 3, padding=1)


def lite_predictor(inputs, outputs, is_last):
    """Separable, but on the last map, which is one cell, a 1 x 1 convolution."""
    return nn.Conv2d(inputs, outputs, 1) if is_last else separable(inputs, outputs)


def bare_lite_predictor(inputs, outputs, is_last):
    """The same without batch normalization, which SqueezeNet has nowhere."""
    return nn.Conv2d(inputs, outputs, 1) if is_last else separable(inputs, outputs, normalize=False)


def plain_extra(inputs, middle, outputs, stride=2, padding=1):
    """1 x 1, then 3 x 3 convolution to the next map."""
    return nn.Sequential(nn.Conv2d(inputs, middle, 1), nn.ReLU(inplace=True),
                         nn.Conv2d(middle, outputs, 3, stride, padding), nn.ReLU(inplace=True))


def mobilenet_v1_layers():
    """Howard et al., "MobileNets", 2017, table 1, without the classifier; (layers to stride 16, layers to stride
    32)."""
    def block(inputs, outputs, stride=1):
        return [*normalized(inputs, inputs, stride, groups=inputs), *normalized(inputs, outputs, kernel=1)]
    fine = [
        *normalized(3, 32, 2),
        *block(32, 64),
        *block(64, 128, 2),
        *block(128, 128),
        *block(128, 256, 2),
        *block(256, 256),
        *block(256, 512, 2),
    ]
    for _ in range(5):
        fine += block(512, 512)
    return fine, [*block(512, 1024, 2), *block(1024, 1024)]


def mobilenet_v1_ssd(class_names):
    """MobileNetV1 (Howard et al. 2017) with SSD's extras and predictors on six maps."""
    fine, coarse = mobilenet_v1_layers()
    extras = [
        plain_extra(1024, 256, 512),
        plain_extra(512, 128, 256),
        plain_extra(256, 128, 256),
        plain_extra(256, 128, 256),
    ]
    return Ssd("mobilenet_v1_ssd", class_names, Split(nn.Sequential(*fine), nn.Sequential(*coarse)), extras,
               (512, 1024, 512, 256, 256, 256), plain_predictor, LEVELS)


class MobileNetV2(nn.Module):
    """torchvision's MobileNetV2 (Sandler et al. 2018): the expanded map of block 14 at stride 16, the last map at
    stride 32."""

    def __init__(self, features):
        super().__init__()
        self.features = features

    def forward(self, images):
        for layer in self.features[:14]:
            images = layer(images)
        expanded = self.features[14].conv[0](images)
        images = self.features[14].conv[1:](expanded)
        for layer in self.features[15:]:
            images = layer(images)
        return [expanded, images]


def mobilenet_v2_ssd_lite(class_names):
    """MobileNetV2 with SSD-Lite (Sandler et al. 2018, section 6.2); extras are inverted residual blocks."""
    def extra(inputs, outputs, expansion):
        return torchvision.models.mobilenetv2.InvertedResidual(inputs, outputs, 2, expansion)
    extras = [extra(1280, 512, 0.2), extra(512, 256, 0.25), extra(256, 256, 0.5), extra(256, 64, 0.25)]
    return Ssd("mobilenet_v2_ssd_lite", class_names, MobileNetV2(torchvision.models.mobilenet_v2().features), extras,
               (576, 1280, 512, 256, 256, 64), lite_predictor, LEVELS)


def squeezenet_ssd_lite(class_names):
    """SqueezeNet 1.1 (Iandola et al. 2016) with SSD-Lite's predictors."""
    layers = torchvision.models.squeezenet1_1().features
    for layer in layers:
        if isinstance(layer, nn.MaxPool2d):
            layer.ceil_mode = False  # 17 x 17 cells of 300 pixels, which the priors cover
    def extra(inputs, middle, outputs, padding=1):
        return nn.Sequential(nn.Conv2d(inputs, middle, 1), nn.ReLU(inplace=True),
                             separable(middle, outputs, 2, padding, normalize=False))
    extras = [extra(512, 256, 512, padding=2), extra(512, 256, 512), extra(512, 128, 256), extra(256, 128, 256),
              extra(256, 128, 256)]
    return Ssd(
        "squeezenet_ssd_lite",
        class_names,
        Split(layers[:12], layers[12]),
        extras,
        (512, 512, 512, 256, 256, 256),
        bare_lite_predictor,
        SQUEEZENET_LEVELS,
        predicted=1,
    )


def vgg16_ssd(class_names):
    """VGG16 (Simonyan and Zisserman 2015) as in the SSD paper, section 3: fc6 and fc7 are convolutions, the first
    atrous."""
    layers = torchvision.models.vgg16().features
    layers[16].ceil_mode = True  # 75 to 38 cells
    layers[30] = nn.MaxPool2d(3, 1, 1)
    fully_connected = nn.Sequential(nn.Conv2d(512, 1024, 3, padding=6, dilation=6), nn.ReLU(inplace=True),
                                    nn.Conv2d(1024, 1024, 1), nn.ReLU(inplace=True)).apply(start_convolution)
    coarse = nn.Sequential(*layers[23:], *fully_connected)
    extras = [plain_extra(1024, 256, 512), plain_extra(512, 128, 256), plain_extra(256, 128, 256, 1, 0),
              plain_extra(256, 128, 256, 1, 0)]
    return Ssd("vgg16_ssd", class_names, Split(layers[:23], coarse), extras, (512, 1024, 512, 256, 256, 256),
               plain_predictor, VGG_LEVELS, scaling=nn.BatchNorm2d(512), learning_rate=3e-4)
