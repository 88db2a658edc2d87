"""Colours of curved surfaces: functions from positions N x 3 in -1..1 to display colours N x 3."""
import cv2
import numpy as np

from .textures import blotch, checks, colour, gradient, grain, pick, printed, SIZE, speckle, wood


def _great_circles(p, width, normals):
    return np.min(np.abs(p @ np.float32(normals).T), axis=1) < width


_PHI = (1 + 5 ** 0.5) / 2
_ICOSA = np.float32([(0, a, b * _PHI) for a in (-1, 1) for b in (-1, 1)]
                    + [(a, b * _PHI, 0) for a in (-1, 1) for b in (-1, 1)]
                    + [(b * _PHI, 0, a) for a in (-1, 1) for b in (-1, 1)]) / np.hypot(1, _PHI)
_DODECA = np.float32([(a, b, c) for a in (-1, 1) for b in (-1, 1) for c in (-1, 1)]
                     + [(0, a * _PHI, b / _PHI) for a in (-1, 1) for b in (-1, 1)]
                     + [(a * _PHI, b / _PHI, 0) for a in (-1, 1) for b in (-1, 1)]
                     + [(b / _PHI, 0, a * _PHI) for a in (-1, 1) for b in (-1, 1)]) / 3 ** 0.5


def football(rng):
    """Albedo of the ball of 12 pentagons and 20 hexagons."""
    light, dark = np.float32([.95, .95, .95]), np.float32([.06, .06, .07])
    if rng.random() < 0.4:
        light, dark = colour(rng), colour(rng)
    seam = dark if rng.random() < 0.5 else light * 0.6
    width = rng.uniform(0.004, 0.02)

    def albedo(p):
        pent, hexa = p @ _ICOSA.T, p @ _DODECA.T
        best_hex = np.partition(hexa, -2, axis=1)[:, -2:]
        best_pent = pent.max(1) + 0.02
        out = np.where((best_pent > best_hex[:, 1])[:, None], dark, light)
        edge = np.minimum(np.abs(best_pent - best_hex[:, 1]), best_hex[:, 1] - best_hex[:, 0]) < width
        out[edge] = seam
        return out
    return albedo


def patches(rng):
    """Albedo of a modern football: irregular patches in two or three colours, sometimes with seams."""
    centres = rng.standard_normal((int(rng.integers(6, 33)), 3))
    centres = np.float32(centres / np.linalg.norm(centres, axis=1, keepdims=True))
    shades = np.stack([np.float32([.95, .95, .95]), colour(rng), colour(rng)])[rng.integers(0, 3, len(centres))]
    width = pick(rng, (0.0, rng.uniform(.01, .04)))

    def albedo(p):
        near = p @ centres.T
        out = shades[near.argmax(1)]
        if width:
            top = np.partition(near, -2, axis=1)
            out[top[:, -1] - top[:, -2] < width] *= 0.4
        return out
    return albedo


def sectors(rng, along=2):
    """Albedo of a beach ball or party hat: coloured sectors about the axis, sometimes white ends."""
    count = int(rng.integers(3, 8)) * 2
    shades = np.stack([colour(rng, 'vivid') if i % 2 or rng.random() < .5 else np.float32([.95, .95, .93])
                       for i in range(count)])
    cap = rng.uniform(0.9, 1.0)

    def albedo(p):
        angle = np.arctan2(p[:, 1], p[:, 0]) / (2 * np.pi) + 0.5
        out = shades[np.minimum((angle * count).astype(int), count - 1)]
        out[np.abs(p[:, along]) > cap] = .95
        return out
    return albedo


def bands(rng):
    """Albedo in bands along the axis: stripes, two halves, rings."""
    count = int(rng.integers(2, 9))
    shades = np.stack([colour(rng) for _ in range(2)] * count)[:count]
    if rng.random() < 0.4:
        shades = np.stack([colour(rng) for _ in range(count)])
    edges = np.sort(rng.uniform(-0.9, 0.9, count - 1)) if rng.random() < .5 else np.linspace(-1, 1, count + 1)[1:-1]
    return lambda p: shades[np.searchsorted(edges, p[:, 2])]


def basketball(rng):
    """Albedo of a basketball: orange brown with dark seams."""
    ground_rgb = np.float32([.78, .38, .14]) * rng.uniform(0.7, 1.2) if rng.random() < .8 else colour(rng)
    line, width = colour(rng, 'dark'), rng.uniform(0.015, 0.04)

    def albedo(p):
        seam = _great_circles(p, width, ((1, 0, 0), (0, 1, 0)))
        seam |= np.abs(np.abs(p[:, 0]) - 0.52 - 0.3 * p[:, 1] ** 2) < width
        return np.where(seam[:, None], line, np.clip(ground_rgb, 0, 1))
    return albedo


def tennis(rng):
    """Albedo of a tennis ball or baseball: one curved seam."""
    felt = pick(rng, ([.78, .88, .22], [.82, .9, .35], [.7, .8, .15], [.92, .9, .86], colour(rng)))
    line, width = np.float32(pick(rng, ([.95, .95, .9], [.95, .95, .9], [.7, .1, .1]))), rng.uniform(0.03, 0.08)
    fuzz = rng.uniform(0.0, 0.08)
    salt = int(rng.integers(1 << 30))

    def albedo(p):
        seam = np.abs(p[:, 2] - 0.9 * (p[:, 0] ** 2 - p[:, 1] ** 2)) < width
        out = np.where(seam[:, None], line, np.float32(felt))
        grain_ = np.random.default_rng(salt).standard_normal((len(p), 1), dtype=np.float32)
        return out * (1 + fuzz * grain_)
    return albedo


def volleyball(rng):
    """Albedo of a ball of six faces with three panels each."""
    shades = np.stack([colour(rng) for _ in range(3)])
    if rng.random() < .4:
        shades[:] = shades[0]
    line = colour(rng, 'dark') if rng.random() < .5 else shades[0] * 0.7

    def albedo(p):
        axis = np.argmax(np.abs(p), axis=1)
        rows = np.arange(len(p))
        side = p[rows, (axis + 1) % 3] / np.abs(p[rows, axis])
        other = p[rows, (axis + 2) % 3] / np.abs(p[rows, axis])
        strip = np.clip(np.floor((side + 1) * 1.5), 0, 2)
        out = shades[((strip + axis) % 3).astype(int)]
        edge = (np.abs((side + 1) * 1.5 - np.round((side + 1) * 1.5)) < .06) | (np.abs(other) > .96)
        out[edge] = line
        return out
    return albedo


def solid(rng, rgb=None):
    """Albedo of one colour, sometimes with stains."""
    rgb = colour(rng) if rgb is None else np.float32(rgb)
    amount = rng.uniform(0.02, 0.15)
    if rng.random() < 0.5:
        return lambda p: np.tile(rgb, (len(p), 1))
    return mapped(grain(rng, rgb, amount, int(rng.integers(2, 24))), rng)


def mapped(texture, rng):
    """Albedo looked up in a planar texture, projected along a random axis of the surface."""
    scale = rng.uniform(0.2, 0.5) * SIZE
    axis = int(rng.integers(3))
    smooth = cv2.GaussianBlur(texture, (0, 0), 0.8)

    def albedo(p):
        uv = ((np.delete(p, axis, 1) + 1.01) * scale).astype(int) % SIZE
        return smooth[uv[:, 1], uv[:, 0]]
    return albedo


def wrapped(texture, rng):
    """Albedo looked up by angle and height: a label around a can, a pattern around a hat."""
    revolutions = int(rng.integers(1, 4))

    def albedo(p):
        u = ((np.arctan2(p[:, 1], p[:, 0]) / (2 * np.pi) + 0.5) * revolutions * SIZE).astype(int) % SIZE
        v = ((0.5 - 0.499 * np.clip(p[:, 2], -1, 1)) * SIZE).astype(int) % SIZE
        return texture[v, u]
    return albedo


def number_ball(rng):
    """Albedo of a billiard ball: one colour or a belt, with a white disc."""
    rgb, belt = colour(rng, 'vivid'), rng.random() < 0.4
    spot = rng.standard_normal(3)
    spot = np.float32(spot / np.linalg.norm(spot))

    def albedo(p):
        out = np.tile(rgb, (len(p), 1))
        if belt:
            out[np.abs(p[:, 2]) > 0.55] = .93
        out[p @ spot > 0.92] = .93
        return out
    return albedo


def any_solid(rng):
    """A random albedo for any curved object."""
    kind = rng.random()
    if kind < 0.45:
        return solid(rng)
    if kind < 0.6:
        return bands(rng)
    if kind < 0.75:
        return mapped(pick(rng, (blotch, printed, checks, wood, speckle))(rng), rng)
    if kind < 0.9:
        return wrapped(pick(rng, (blotch, printed, checks, gradient))(rng), rng)
    return sectors(rng)


def any_ball(rng):
    """A random albedo of a ball."""
    kind = rng.random()
    table = ((0.30, solid), (0.39, football), (0.44, patches), (0.51, basketball), (0.60, tennis), (0.67, sectors),
             (0.72, volleyball), (0.77, number_ball), (0.86, bands))
    for limit, make in table:
        if kind < limit:
            return make(rng)
    if kind < 0.90:
        return solid(rng, np.clip(np.float32([.95, .52, .08]) + rng.normal(0, .06, 3), 0, 1))
    return any_solid(rng)


def worn(rng, albedo):
    """An albedo with stains and dust over it."""
    stains = mapped(grain(rng, (.5, .5, .5), rng.uniform(.03, .15), int(rng.integers(2, 16))), rng)
    return lambda p: np.clip(albedo(p) * (0.5 + stains(p)), 0, 1)


def any_cone(rng):
    """A random albedo of a plain cone or party hat, by surface position with height -1..1."""
    kind = rng.random()
    if kind < 0.45:
        return solid(rng)
    if kind < 0.6:
        return bands(rng)
    if kind < 0.75:
        return sectors(rng)
    return any_solid(rng)


def traffic_cone(rng):
    """Albedo of a traffic cone: vivid, with no, one, two or three pale stripes."""
    body = np.float32([rng.uniform(.85, 1), rng.uniform(.2, .5), rng.uniform(.02, .2)])
    if rng.random() < 0.25:
        body = colour(rng, 'vivid')
    stripe = np.float32(pick(rng, ([.93, .93, .93], [.93, .93, .93], [.75, .75, .78], [.1, .1, .1], [1, .9, .2])))
    count = int(rng.integers(0, 4))
    centres = np.linspace(-0.35, 0.6, 3)[:count] + rng.normal(0, 0.1, count)
    half = rng.uniform(0.08, 0.24)
    dirt = rng.uniform(0, 0.12)
    stains = mapped(grain(rng, (.5, .5, .5), dirt), rng)

    def albedo(p):
        inside = np.zeros(len(p), bool)
        for centre in centres:
            inside |= np.abs(p[:, 2] - centre) < half
        return np.clip(np.where(inside[:, None], stripe, body) * (0.5 + stains(p)), 0, 1)
    return albedo, body
