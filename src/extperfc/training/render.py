"""A small renderer on numpy and OpenCV: z-buffered polygons and ray-cast quadrics with a pinhole camera.

Camera frame: x right, y down, z forward, metres. Light is linear; `Frame.colour` is H x W x 3, R, G, B.
"""
from dataclasses import dataclass, field
from typing import Callable, Optional

import cv2
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
    wrap: float = 0.0  # 0: a point-like sun; towards 1: a large soft lamp that reaches around things

    def direct(self, normals):
        """Share of the sun's light that normals (..., 3) receive."""
        return np.maximum((normals @ self.towards + self.wrap) / (1 + self.wrap), 0)

    def ambient(self, normals):
        """Light from all around for normals (..., 3)."""
        share = 0.5 + 0.5 * (normals @ self.up)
        return self.bounce + share[..., None] * (self.sky - self.bounce)


@dataclass
class Frame:
    """Picture, depth [m], and the number of the thing at each pixel (0: background)."""

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


def _clip(frame, points):
    """Cuts a convex polygon (N, 3) at the near plane and at twice the field of view."""
    wide, high = frame.width / frame.focal, frame.height / frame.focal
    planes = np.array([(0, 0, 1, -NEAR), (1, 0, wide, 0), (-1, 0, wide, 0), (0, 1, high, 0), (0, -1, high, 0)])
    for plane in planes:
        value = points @ plane[:3] + plane[3]
        if (value >= 0).all():
            continue
        out = []
        for i in range(len(points)):
            j = (i + 1) % len(points)
            if value[i] >= 0:
                out.append(points[i])
            if (value[i] >= 0) != (value[j] >= 0):
                out.append(points[i] + value[i] / (value[i] - value[j]) * (points[j] - points[i]))
        points = np.array(out)
        if len(points) < 3:
            return points
    return points


def _inside(pixels, shape):
    """Mask (h, w) of the pixel centres in a convex polygon (N, 2); neighbours share edges without teeth or gaps."""
    after = np.roll(pixels, -1, axis=0)
    turn = np.sign(np.sum(pixels[:, 0] * after[:, 1] - pixels[:, 1] * after[:, 0]))
    xs, ys = np.arange(shape[1]), np.arange(shape[0])[:, None]
    mask = np.ones(shape, bool)
    for (x0, y0), (x1, y1) in zip(pixels, after):
        mask &= turn * ((x1 - x0) * (ys - y0) - (y1 - y0) * (xs - x0)) >= 0
    return mask


def _lookup(frame, texture, basis, repeat, area, depth, distance):
    """Texture colours of a window; fine texture fades to a blurred one where pixels cover several texels."""
    origin, edge_u, edge_v = basis
    rows, cols = area
    size = texture.shape[0]
    place = frame.matrix @ np.stack([edge_u, edge_v, origin], 1)
    shift = np.array([[1, 0, cols.start], [0, 1, rows.start], [0, 0, 1.0]])
    lookup = np.diag([size * repeat[0], size * repeat[1], 1]) @ np.linalg.pinv(place) @ shift
    flags = {'flags': cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP, 'borderMode': cv2.BORDER_REFLECT}
    image = cv2.warpPerspective(texture, lookup, depth.shape[::-1], **flags)
    if repeat == (1.0, 1.0):
        return image
    texel = np.linalg.norm(edge_u) / (size * repeat[0])
    footprint = depth * depth / (frame.focal * max(distance, 1e-3) * texel)
    weight = np.clip((footprint - 1.5) / 5, 0, 1)[..., None]
    soft = cv2.warpPerspective(cv2.blur(texture, (13, 13)), lookup, depth.shape[::-1], **flags)
    return image + weight * (soft - image)


def polygon(frame, ident, points, basis, surface, two_sided=False):
    """Draws a convex polygon (N, 3) with a texture; basis is (origin, u edge, v edge) of the texture square."""
    origin, edge_u, edge_v = basis
    normal = np.cross(edge_u, edge_v)
    normal = normal / (np.linalg.norm(normal) + 1e-12)
    if normal @ origin > 0:
        if not two_sided:
            return None
        normal = -normal
    points = _clip(frame, points)
    area = frame.window(points, 1) if len(points) > 2 else None
    if area is None or abs(normal @ origin) < 1e-6:
        return None
    rows, cols = area
    shape = (rows.stop - rows.start, cols.stop - cols.start)
    mask = _inside(frame.project(points) - (cols.start, rows.start), shape)
    rays = frame.rays(area)
    with np.errstate(divide='ignore'):
        depth = np.float32(normal @ origin) / (rays @ normal.astype(np.float32))
    mask &= (depth > 0) & (depth < frame.depth[area])
    image = _lookup(frame, surface.texture, basis, surface.repeat, area, depth, abs(normal @ origin))
    light = frame.light
    lit = light.ambient(normal) + light.direct(normal) * light.sun
    out = textures.linear(image[mask]) * np.float32(lit)
    if surface.gloss > 0.1:
        out = _gloss(frame, rays[mask], normal, out, surface)
    frame.colour[area][mask] = out
    frame.depth[area][mask] = depth[mask]
    frame.ids[area][mask] = ident
    return area, mask


def _gloss(frame, rays, normal, out, surface):
    """Adds the highlight of a flat face."""
    view = rays / np.linalg.norm(rays, axis=1, keepdims=True)
    mirror = view - 2 * (view @ normal)[:, None] * normal
    spot = np.maximum(mirror @ frame.light.towards, 0) ** surface.shininess
    return out + np.float32(surface.gloss) * (spot[:, None] * frame.light.sun).astype(np.float32)


def shadow(frame, points, plane, towards, ident, strength, softness):
    """Darkens the pixels of thing `ident` (a plane: point, normal) where points (N, 3) shade it from the sun."""
    origin, normal = plane
    fall = normal @ towards
    if fall < 0.05:
        return
    height = (points - origin) @ normal
    ground = points - np.maximum(height, 0)[:, None] * towards / fall
    if ground[:, 2].min() < NEAR:
        return
    hull = cv2.convexHull(np.float32(frame.project(ground)))
    hull = hull.reshape(-1, 2)
    low, high = hull.min(0), hull.max(0)
    sigma = max(0.6, softness * min(high - low))
    x0, y0 = np.maximum(0, (low - 3 * sigma).astype(int))
    x1, y1 = np.minimum((frame.width, frame.height), (high + 3 * sigma).astype(int) + 1)
    if x1 - x0 < 2 or y1 - y0 < 2:
        return
    step = max(1.0, sigma / 2)
    size = (max(2, int((x1 - x0) / step)), max(2, int((y1 - y0) / step)))
    mask = np.zeros((size[1], size[0]), np.float32)
    scale = np.array(size) / (x1 - x0, y1 - y0)
    cv2.fillConvexPoly(mask, np.int32(np.round((hull - (x0, y0)) * scale * 16)), 1.0, cv2.LINE_AA, 4)
    mask = cv2.GaussianBlur(mask, (0, 0), max(0.4, sigma / step))
    mask = cv2.resize(mask, (int(x1 - x0), int(y1 - y0)))
    area = (slice(y0, y1), slice(x0, x1))
    mask = mask * (frame.ids[area] == ident) * strength
    frame.colour[area] *= (1 - mask)[..., None]
