"""A small renderer on numpy: z-buffered, ray-cast quadrics with a pinhole camera (polygons.py has the flat parts).

Camera frame: x right, y down, z forward, metres. Light is linear; `Frame.colour` is H x W x 3, R, G, B.
"""
from dataclasses import dataclass, field
from typing import Callable, Optional

import numpy as np

from . import textures

NEAR = 0.04  # [m]


@dataclass
class Surface:
    """How a surface looks: `albedo` maps N x 3 positions in -1..1 to display colours, `texture` is planar."""

    albedo: Optional[Callable] = None
    texture: Optional[np.ndarray] = None
    gloss: float = 0.0
    shininess: float = 30.0
    bump: float = 0.0
    repeat: tuple = (1.0, 1.0)


@dataclass
class Light:
    """Sun and sky in the camera frame: `towards` is the unit vector to the sun, `up` that against gravity."""

    towards: np.ndarray
    up: np.ndarray
    sun: np.ndarray
    sky: np.ndarray
    bounce: np.ndarray
    wrap: float = 0.0  # 0: a point-like sun; towards 1: a large soft light that reaches around objects

    def direct(self, normals):
        """Fraction of the sun's light that normals (..., 3) receive."""
        return np.maximum((normals @ self.towards + self.wrap) / (1 + self.wrap), 0)

    def ambient(self, normals):
        """Light from all around for normals (..., 3)."""
        fraction = 0.5 + 0.5 * (normals @ self.up)
        return self.bounce + fraction[..., None] * (self.sky - self.bounce)


@dataclass
class Frame:
    """Image, depth [m], and the number of the object at each pixel (0: background)."""

    width: int
    height: int
    focal: float
    light: Light
    centre: tuple = None
    colour: np.ndarray = field(init=False)
    depth: np.ndarray = field(init=False)
    ids: np.ndarray = field(init=False)

    def __post_init__(self):
        self.centre = self.centre or ((self.width - 1) / 2, (self.height - 1) / 2)
        self.colour = np.zeros((self.height, self.width, 3), np.float32)
        self.depth = np.full((self.height, self.width), np.inf, np.float32)
        self.ids = np.zeros((self.height, self.width), np.int16)
        self.matrix = np.array([[self.focal, 0, self.centre[0]], [0, self.focal, self.centre[1]], [0, 0, 1.0]])

    def project(self, points):
        """Pixels (N, 2) of points (N, 3) in front of the camera."""
        return points[:, :2] / points[:, 2:3] * self.focal + self.centre

    def window(self, points, margin=2):
        """Slice of rows and columns around projected points; None when empty or too near."""
        if points[:, 2].min() < NEAR:
            return None
        pixels = self.project(points)
        low = np.floor(pixels.min(0)).astype(int) - margin
        high = np.ceil(pixels.max(0)).astype(int) + margin + 1
        x0, y0 = max(0, low[0]), max(0, low[1])
        x1, y1 = min(self.width, high[0]), min(self.height, high[1])
        return (slice(y0, y1), slice(x0, x1)) if x1 > x0 and y1 > y0 else None

    def rays(self, area):
        """Rays (h, w, 3) with z = 1 through the pixels of a window."""
        rows, cols = area
        out = np.ones((rows.stop - rows.start, cols.stop - cols.start, 3), np.float32)
        out[..., 0] = (np.arange(cols.start, cols.stop, dtype=np.float32) - self.centre[0]) / self.focal
        out[..., 1] = ((np.arange(rows.start, rows.stop, dtype=np.float32) - self.centre[1]) / self.focal)[:, None]
        return out


def _shade(frame, normals, rays, albedo, surface):
    """Linear colour (N, 3) of surface points with unit normals, seen along rays (N, 3)."""
    light = frame.light
    lit = light.ambient(normals) + light.direct(normals)[:, None] * light.sun
    out = textures.linear(albedo) * lit
    if surface.gloss > 0:
        view = rays / np.linalg.norm(rays, axis=1, keepdims=True)
        cosine = np.sum(view * normals, 1, keepdims=True)
        mirror = view - 2 * cosine * normals
        spot = np.maximum(mirror @ light.towards, 0) ** surface.shininess
        rim = (1 - np.minimum(1, np.abs(cosine))) ** 4
        above = np.clip(0.5 + 3 * (mirror @ light.up), 0, 1)[:, None]
        out = out + surface.gloss * (spot[:, None] * light.sun * 1.5
                                     + (0.04 + 0.6 * rim) * (light.bounce + above * (light.sky - light.bounce)))
    return out


def _paint(frame, ident, area, mask, depth, direction, local, normal, surface):
    """Shades the pixels of `mask` in a window and writes them; vectors are N x 3 for those pixels."""
    if surface.bump > 0:
        cells = (np.abs(local[:, [0, 2]]) * 60 + np.abs(local[:, [1, 0]]) * 31).astype(int) % textures.SIZE
        normal = normal + surface.bump * _BUMPS[:, cells[:, 0], cells[:, 1]].T
    normal = normal / np.linalg.norm(normal, axis=1, keepdims=True)
    frame.colour[area][mask] = _shade(frame, normal, direction, surface.albedo(local), surface)
    frame.depth[area][mask] = depth
    frame.ids[area][mask] = ident


_BUMPS = np.stack([textures.noise(np.random.default_rng(i), textures.SIZE, 48, 2) for i in range(3)])


def ellipsoid(frame, ident, rotation, centre, radii, surface):
    """Draws an ellipsoid; rotation takes object axes to the camera frame."""
    radii = np.asarray(radii, np.float32)
    corners = np.array([(a, b, c) for a in (-1, 1) for b in (-1, 1) for c in (-1, 1)]) * radii
    area = frame.window(corners @ rotation.T + centre)
    if area is None:
        return
    rays = frame.rays(area)
    along = (rays @ rotation.astype(np.float32)) / radii
    start = np.float32(-(centre @ rotation)) / radii
    a, b = np.einsum('ijk,ijk->ij', along, along), along @ start
    root = b * b - a * (start @ start - 1)
    scale = (-b - np.sqrt(np.maximum(root, 0))) / a
    mask = (root > 0) & (scale > NEAR) & (scale < frame.depth[area])
    scale = scale[mask]
    local = start + scale[:, None] * along[mask]
    _paint(frame, ident, area, mask, scale, rays[mask], local, (local / radii) @ rotation.T.astype(np.float32), surface)


def _frustum_hits(along, start, bottom, top, height):
    """Nearest hit of rays with a frustum about z from -height/2 to height/2; returns scale and side (0, -1, 1)."""
    slope, middle = (top - bottom) / height, (top + bottom) / 2
    radius0, radius1 = middle + slope * start[2], slope * along[..., 2]
    a = along[..., 0] ** 2 + along[..., 1] ** 2 - radius1 ** 2
    b = along[..., 0] * start[0] + along[..., 1] * start[1] - radius0 * radius1
    c = start[0] ** 2 + start[1] ** 2 - radius0 ** 2
    root = b * b - a * c
    rooted = np.sqrt(np.maximum(root, 0))
    a = np.where(np.abs(a) < 1e-9, 1e-9, a)
    best = np.full(a.shape, np.inf, np.float32)
    side = np.zeros(a.shape, np.int8)
    for scale in ((-b - rooted) / a, (-b + rooted) / a):
        z = start[2] + scale * along[..., 2]
        good = (root > 0) & (scale > NEAR) & (np.abs(z) <= height / 2) & (radius0 + scale * radius1 >= 0) & (scale < best)
        best[good] = scale[good]
    with np.errstate(divide='ignore', invalid='ignore'):
        for sign, radius in ((-1, bottom), (1, top)):
            scale = (sign * height / 2 - start[2]) / along[..., 2]
            x, y = start[0] + scale * along[..., 0], start[1] + scale * along[..., 1]
            good = (x * x + y * y <= radius * radius) & (scale > NEAR) & (scale < best)
            best[good], side[good] = scale[good], sign
    return best, side


def frustum(frame, ident, rotation, centre, bottom, top, height, surface):
    """Draws a cone, cylinder or disc about its z axis; centre is at half its height."""
    wide = max(bottom, top)
    corners = np.array([(a, b, c) for a in (-1, 1) for b in (-1, 1) for c in (-1, 1)]) * (wide, wide, height / 2)
    area = frame.window(corners @ rotation.T + centre)
    if area is None:
        return
    rays = frame.rays(area)
    along = rays @ rotation.astype(np.float32)
    start = np.float32(-(centre @ rotation))
    scale, side = _frustum_hits(along, start, bottom, top, height)
    mask = scale < frame.depth[area]
    scale, side = scale[mask], side[mask]
    local = start + scale[:, None] * along[mask]
    normal = np.zeros_like(local)
    reach = np.hypot(local[:, 0], local[:, 1]) + 1e-9
    normal[:, :2] = local[:, :2] / reach[:, None]
    normal[:, 2] = (bottom - top) / height
    normal[side != 0] = 0
    normal[side != 0, 2] = side[side != 0]
    local = local / np.float32((wide, wide, height / 2))
    _paint(frame, ident, area, mask, scale, rays[mask], local, normal @ rotation.T.astype(np.float32), surface)
