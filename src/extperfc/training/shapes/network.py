"""The shape detector's network: residual backbone, pyramid neck on strides 8, 16, 32, anchor-free decoupled head."""
import torch
from torch import nn
from torch.nn import functional

from . import HEIGHT, WIDTH

STRIDES = (8, 16, 32)
CLASS_COUNT = 3
MAX_LOG_REACH = 3.6  # exp of this, in strides, is the longest distance from a cell to a box edge


class Unit(nn.Sequential):
    """Convolution, batch normalisation, ReLU."""

    def __init__(self, inputs, outputs, kernel=3, stride=1, groups=1):
        super().__init__(nn.Conv2d(inputs, outputs, kernel, stride, kernel // 2, groups=groups, bias=False),
                         nn.BatchNorm2d(outputs, momentum=0.03), nn.ReLU(inplace=True))


class Residual(nn.Module):
    """Two 3 x 3 units with a bypass."""

    def __init__(self, channels):
        super().__init__()
        self.body = nn.Sequential(Unit(channels, channels), Unit(channels, channels))

    def forward(self, x):
        return x + self.body(x)


class Stage(nn.Module):
    """Cross-stage block: half of the channels pass through `depth` residual blocks, half bypass them."""

    def __init__(self, inputs, outputs, depth, residual=True):
        super().__init__()
        half = outputs // 2
        self.enter, self.bypass = Unit(inputs, half, 1), Unit(inputs, half, 1)
        block = Residual if residual else (lambda c: Unit(c, c))
        self.blocks = nn.Sequential(*[block(half) for _ in range(depth)])
        self.leave = Unit(outputs, outputs, 1)

    def forward(self, x):
        return self.leave(torch.cat([self.blocks(self.enter(x)), self.bypass(x)], 1))


class Pool(nn.Module):
    """Pools the coarsest map over growing neighbourhoods, so that every cell sees the whole image."""

    def __init__(self, channels):
        super().__init__()
        self.enter, self.leave = Unit(channels, channels // 2, 1), Unit(channels * 2, channels, 1)

    def forward(self, x):
        maps = [self.enter(x)]
        for _ in range(3):
            maps.append(functional.max_pool2d(maps[-1], 5, 1, 2))
        return self.leave(torch.cat(maps, 1))


class Backbone(nn.Module):
    """Maps at strides 8, 16 and 32 of an image (B, 3, H, W)."""

    def __init__(self, widths):
        super().__init__()
        stem, c4, c8, c16, c32 = widths
        self.to4 = nn.Sequential(Unit(3, stem, 3, 2), Unit(stem, c4, 3, 2), Stage(c4, c4, 1))
        self.to8 = nn.Sequential(Unit(c4, c8, 3, 2), Stage(c8, c8, 2))
        self.to16 = nn.Sequential(Unit(c8, c16, 3, 2), Stage(c16, c16, 2))
        self.to32 = nn.Sequential(Unit(c16, c32, 3, 2), Stage(c32, c32, 1), Pool(c32))

    def forward(self, x):
        c8 = self.to8(self.to4(x))
        c16 = self.to16(c8)
        return c8, c16, self.to32(c16)


class Neck(nn.Module):
    """Mixes the three maps from coarse to fine and back; all get `width` channels."""

    def __init__(self, channels, width):
        super().__init__()
        self.side = nn.ModuleList([Unit(c, width, 1) for c in channels])
        self.down = nn.ModuleList([Stage(2 * width, width, 1, False) for _ in range(2)])
        self.stride = nn.ModuleList([Unit(width, width, 3, 2) for _ in range(2)])
        self.up = nn.ModuleList([Stage(2 * width, width, 1, False) for _ in range(2)])

    def forward(self, maps):
        fine, middle, coarse = [side(m) for side, m in zip(self.side, maps)]
        middle = self.down[0](torch.cat([middle, functional.interpolate(coarse, scale_factor=2.0, mode='nearest')], 1))
        fine = self.down[1](torch.cat([fine, functional.interpolate(middle, scale_factor=2.0, mode='nearest')], 1))
        middle = self.up[0](torch.cat([middle, self.stride[0](fine)], 1))
        coarse = self.up[1](torch.cat([coarse, self.stride[1](middle)], 1))
        return fine, middle, coarse


class Head(nn.Module):
    """Per cell: class logits and the logarithms of the distances to left, top, right, bottom in strides."""

    def __init__(self, width):
        super().__init__()
        self.score = nn.Sequential(Unit(width, width), nn.Conv2d(width, CLASS_COUNT, 1))
        self.reach = nn.Sequential(Unit(width, width), nn.Conv2d(width, 4, 1))
        nn.init.constant_(self.score[-1].bias, -4.0)
        nn.init.constant_(self.reach[-1].bias, 0.7)

    def forward(self, x):
        return self.score(x), self.reach(x)


class ShapeNet(nn.Module):
    """The detector; `forward` gives logits (B, 3, N) and log distances (B, 4, N) of all N cells."""

    def __init__(self, widths=(16, 32, 72, 144, 224), neck=72):
        super().__init__()
        self.backbone = Backbone(widths)
        self.neck = Neck(widths[2:], neck)
        self.heads = nn.ModuleList([Head(neck) for _ in STRIDES])

    def forward(self, x):
        outputs = [head(m) for head, m in zip(self.heads, self.neck(self.backbone(x)))]
        return (torch.cat([s.flatten(2) for s, _ in outputs], 2), torch.cat([r.flatten(2) for _, r in outputs], 2))


def cells(width=WIDTH, height=HEIGHT):
    """Centres (N, 2) of all cells in input pixels and their strides (N,)."""
    centres, strides = [], []
    for stride in STRIDES:
        ys, xs = torch.meshgrid(torch.arange(height // stride), torch.arange(width // stride), indexing='ij')
        centres.append((torch.stack([xs, ys], -1).reshape(-1, 2) + 0.5) * stride)
        strides.append(torch.full((len(centres[-1]),), float(stride)))
    return torch.cat(centres), torch.cat(strides)


def corners(reach, centres, strides):
    """Boxes x0, y0, x1, y1 (B, N, 4) in input pixels from log distances (B, 4, N)."""
    far = torch.exp(reach.clamp(max=MAX_LOG_REACH)).transpose(1, 2) * strides[:, None]
    return torch.cat([centres - far[..., :2], centres + far[..., 2:]], -1)


class Exported(nn.Module):
    """The network with decoding in the graph: `output` (1, 7, N): centre x, y, width, height, three scores."""

    def __init__(self, net):
        super().__init__()
        self.net = net
        centres, strides = cells()
        self.register_buffer('centres', centres.t()[None].contiguous())
        self.register_buffer('strides', strides.expand(1, 4, -1).contiguous())

    def forward(self, images):
        scores, reach = self.net(images)
        far = torch.exp(reach) * self.strides
        before, after = far[:, :2], far[:, 2:]
        return torch.cat([self.centres + (after - before) * 0.5, before + after, torch.sigmoid(scores)], 1)
