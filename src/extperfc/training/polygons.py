"""Flat parts of the renderer: textured convex polygons and the shadows that objects cast on a plane."""
import cv2
import numpy as np

from . import textures
from .render import NEAR


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
    winding = np.sign(np.sum(pixels[:, 0] * after[:, 1] - pixels[:, 1] * after[:, 0]))
    xs, ys = np.arange(shape[1]), np.arange(shape[0])[:, None]
    mask = np.ones(shape, bool)
    for (x0, y0), (x1, y1) in zip(pixels, after):
        mask &= winding * ((x1 - x0) * (ys - y0) - (y1 - y0) * (xs - x0)) >= 0
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
    """Darkens the pixels of object `ident` (a plane: point, normal) where points (N, 3) shade it from the sun."""
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
