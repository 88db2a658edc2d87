"""Procedural planar textures for walls, floors and box faces, and colours.

Colours are R, G, B in display space (gamma encoded), float32, 0..1, unless a name says `linear`.
"""
import colorsys

import cv2
import numpy as np

SIZE = 192  # side of a planar texture [px]


def linear(colour):
    """Display colours to linear light, with the cheap gamma 2."""
    colour = np.asarray(colour, np.float32)
    return colour * colour


def pick(rng, items):
    """One item of a sequence, uniformly."""
    return items[int(rng.integers(len(items)))]


def colour(rng, kind=None):
    """A random colour (3,): kind is vivid, pastel, dark, neutral or any."""
    kind = kind or pick(rng, ('vivid', 'vivid', 'pastel', 'neutral', 'dark', 'any'))
    if kind == 'any':
        return rng.random(3).astype(np.float32)
    hue = rng.random()
    if kind == 'vivid':
        hue = pick(rng, (0.0, 0.04, 0.08, 0.14, 0.3, 0.38, 0.55, 0.62, 0.78, 0.92, hue)) + rng.normal(0, 0.015)
        hsv = (hue % 1.0, rng.uniform(0.65, 1.0), rng.uniform(0.55, 1.0))
    elif kind == 'pastel':
        hsv = (hue, rng.uniform(0.12, 0.5), rng.uniform(0.65, 1.0))
    elif kind == 'dark':
        hsv = (hue, rng.uniform(0.0, 0.7), rng.uniform(0.04, 0.3))
    else:
        hsv = (rng.uniform(0.04, 0.16), rng.uniform(0.0, 0.18), rng.uniform(0.15, 1.0))
    return np.float32(colorsys.hsv_to_rgb(*hsv))


def noise(rng, size=SIZE, base=4, octaves=4, decay=0.55):
    """Multi-octave value noise (size, size), zero mean and about unit deviation."""
    out = np.zeros((size, size), np.float32)
    weight = 1.0
    for octave in range(octaves):
        cells = min(size, base * 2 ** octave)
        grid = rng.standard_normal((cells, cells), dtype=np.float32)
        out += weight * cv2.resize(grid, (size, size), interpolation=cv2.INTER_LINEAR)
        weight *= decay
    return (out - out.mean()) / (out.std() + 1e-6)


def flat(rgb):
    """A texture of one colour."""
    return np.tile(np.asarray(rgb, np.float32), (SIZE, SIZE, 1))


def grain(rng, rgb, amount=0.05, base=4, octaves=5, decay=0.7):
    """One colour, lighter and darker by noise."""
    return np.clip(flat(rgb) + amount * noise(rng, SIZE, base, octaves, decay)[..., None], 0, 1)


def plaster(rng):
    """A painted wall."""
    return grain(rng, colour(rng, pick(rng, ('neutral', 'neutral', 'pastel', 'any'))), rng.uniform(0, 0.05))


def speckle(rng):
    """Carpet, asphalt or grass: fine noise, with a coarser one below."""
    kind = pick(rng, ('carpet', 'asphalt', 'grass', 'gravel'))
    base = {'carpet': colour(rng), 'asphalt': np.float32([.4, .4, .41]) * rng.uniform(0.5, 1.5),
            'grass': np.float32([rng.uniform(.2, .45), rng.uniform(.35, .6), rng.uniform(.08, .25)]),
            'gravel': np.float32([.55, .52, .48]) * rng.uniform(0.6, 1.4)}[kind]
    fine = noise(rng, SIZE, 96 if kind == 'gravel' else 192, 1)[..., None]
    tint = noise(rng, SIZE, 6, 5, 0.75)[..., None] * (rng.random(3) * 0.5 + 0.5).astype(np.float32)
    return np.clip(base * (1 + rng.uniform(.08, .35) * fine + rng.uniform(.03, .2) * tint), 0, 1)


def wood(rng):
    """Wood grain along the first axis of the image."""
    tone = pick(rng, ([.72, .53, .34], [.5, .33, .2], [.85, .72, .52], [.35, .22, .14], [.62, .58, .52]))
    lines = cv2.resize(rng.standard_normal((int(rng.integers(20, 90)), 3), dtype=np.float32), (SIZE, SIZE))
    lines += 0.4 * noise(rng, SIZE, 3, 4)
    return np.clip(np.float32(tone) * (1 + rng.uniform(0.04, 0.16) * lines[..., None]), 0, 1)


def tiles(rng):
    """Tiles, bricks or planks with joints."""
    kind = pick(rng, ('tile', 'brick', 'plank'))
    out = wood(rng) if kind == 'plank' else grain(rng, colour(rng), 0.04)
    rows = int(rng.integers(2, 9))
    cols = rows if kind == 'tile' else max(1, rows // int(rng.integers(2, 5)))
    ys, xs = np.mgrid[0:SIZE, 0:SIZE].astype(np.float32) / SIZE
    row = np.floor(ys * rows)
    shift = 0 if kind == 'tile' else row * rng.uniform(0.3, 0.7)
    col = np.floor(xs * cols + shift)
    shade = rng.normal(1, rng.uniform(0, 0.12), 256).astype(np.float32)
    out = out * shade[(row * 31 + (col % cols) * 7).astype(int) % 256][..., None]
    width = rng.uniform(0.01, 0.06)
    joint = (ys * rows % 1 < width * rows / 4) | ((xs * cols + shift) % 1 < width * cols / 4)
    out[joint] = colour(rng, pick(rng, ('neutral', 'dark')))
    return np.clip(out, 0, 1)


def checks(rng):
    """Checks or stripes of two colours."""
    ys, xs = np.mgrid[0:SIZE, 0:SIZE].astype(np.float32) / SIZE
    angle, count = pick(rng, (0, 0, np.pi / 4, rng.uniform(0, 3))), rng.uniform(2, 12)
    u = np.floor((xs * np.cos(angle) + ys * np.sin(angle)) * count)
    v = np.floor((ys * np.cos(angle) - xs * np.sin(angle)) * count)
    odd = (u + v if rng.random() < 0.5 else u) % 2
    return np.where(odd[..., None] > 0.5, colour(rng), colour(rng)).astype(np.float32)


def blotch(rng):
    """Two or three colours mixed by noise: marble, stains, camouflage."""
    mix = noise(rng, SIZE, int(rng.integers(2, 6)), 5)[..., None]
    if rng.random() < 0.5:
        mix = np.sin(mix * rng.uniform(1, 5))
    mix = 1 / (1 + np.exp(-mix * rng.uniform(0.7, 8)))
    return (mix * colour(rng) + (1 - mix) * colour(rng)).astype(np.float32)


def gradient(rng):
    """A linear blend of two colours."""
    ys, xs = np.mgrid[0:SIZE, 0:SIZE].astype(np.float32) / SIZE
    angle = rng.uniform(0, 2 * np.pi)
    t = np.clip(0.5 + (xs - .5) * np.cos(angle) + (ys - .5) * np.sin(angle), 0, 1)[..., None]
    return (t * colour(rng) + (1 - t) * colour(rng)).astype(np.float32)


def write_text(rng, out, box=None):
    """Draws a few words or bars into a texture, in place, inside box x0, y0, x1, y1."""
    x0, y0, x1, y1 = box or (8, 8, SIZE - 8, SIZE - 8)
    ink = tuple(float(c) for c in colour(rng, pick(rng, ('dark', 'vivid', 'neutral'))))
    letters = 'ABCDEFGHIKLMNOPRSTUVWXYZ0123456789'
    y = y0
    while y < y1:
        size = rng.uniform(0.35, 2.0)
        y += int(24 * size) + 3
        if y >= y1:
            break
        if rng.random() < 0.25:
            cv2.rectangle(out, (x0, y - 5), (int(rng.integers(x0 + 1, x1)), y), ink, -1)
            continue
        text = ''.join(pick(rng, letters) for _ in range(int(rng.integers(2, 12))))
        cv2.putText(out, text, (x0, y), int(rng.integers(0, 5)), size, ink, int(rng.integers(1, 4)), cv2.LINE_AA)
    return out


def printed(rng):
    """A package or poster: ground colour, coloured areas, discs, words."""
    out = pick(rng, (gradient, plaster, blotch, checks))(rng) if rng.random() < 0.4 else flat(colour(rng))
    for _ in range(int(rng.integers(0, 5))):
        ink = tuple(float(c) for c in colour(rng))
        a, b = rng.integers(0, SIZE, 2), rng.integers(0, SIZE, 2)
        kind = rng.integers(4)
        if kind == 0:
            cv2.circle(out, tuple(map(int, a)), int(rng.integers(8, 60)), ink, -1, cv2.LINE_AA)
        elif kind == 1:
            cv2.fillPoly(out, [rng.integers(0, SIZE, (3, 2)).astype(np.int32)], ink, cv2.LINE_AA)
        else:
            cv2.rectangle(out, tuple(map(int, a)), tuple(map(int, b)), ink, -1)
    if rng.random() < 0.7:
        write_text(rng, out)
    return out


def cardboard(rng):
    """Corrugated board: brown, sometimes with tape, a label or print."""
    tone = np.float32([.72, .56, .38]) * rng.uniform(0.7, 1.2) + rng.normal(0, 0.02, 3)
    out = grain(rng, tone, 0.02)
    lines = rng.standard_normal((SIZE, 1, 1), dtype=np.float32) * 0.012
    out += lines
    if rng.random() < 0.5:
        x = int(SIZE * rng.uniform(0.35, 0.6))
        band = out[:, x:x + int(rng.integers(8, 40))]
        band[:] = band * 0.4 + 0.6 * pick(rng, (np.float32([.75, .62, .42]), np.float32([.9, .88, .8]), colour(rng)))
    if rng.random() < 0.4:
        x, y = rng.integers(10, 110, 2)
        w, h = rng.integers(30, 80, 2)
        cv2.rectangle(out, (int(x), int(y)), (int(x + w), int(y + h)), (.93, .93, .92), -1)
        write_text(rng, out, (int(x) + 3, int(y) + 2, int(x + w), int(y + h)))
    elif rng.random() < 0.3:
        write_text(rng, out)
    return np.clip(out, 0, 1)


def window(rng):
    """A wall with a bright window, a door or paintings."""
    out = plaster(rng)
    for _ in range(int(rng.integers(1, 3))):
        x, y = rng.integers(0, 130, 2)
        w, h = rng.integers(25, 100, 2)
        frame = tuple(float(c) for c in colour(rng))
        cv2.rectangle(out, (int(x) - 4, int(y) - 4), (int(x + w) + 4, int(y + h) + 4), frame, -1)
        patch = pick(rng, (gradient, printed, blotch, wood))(rng)
        light = rng.uniform(1.0, 3.0) if rng.random() < 0.4 else 1.0
        area = out[y:y + h, x:x + w]
        area[:] = cv2.resize(patch, (area.shape[1], area.shape[0])) * light
    return out


def clutter(rng):
    """Many overlapping flat shapes of all sizes, which has the statistics of leaves, streets and full shelves."""
    out = flat(colour(rng))
    tints = np.stack([colour(rng) for _ in range(int(rng.integers(2, 9)))])
    upright = rng.random() < .5
    count = int(rng.integers(60, 350))
    sizes = SIZE * 0.3 * (1 - rng.random(count)) ** rng.uniform(.8, 2.5) + 2
    for size in sizes:
        ink = np.clip(pick(rng, tints) + rng.normal(0, .08) + rng.normal(0, .04, 3), 0, 1)
        at, yaw = rng.uniform(0, SIZE, 2), pick(rng, (0, np.pi / 2)) if upright else rng.uniform(0, 6.28)
        half = size * np.array([1, rng.uniform(.15, 1)]) / 2
        corners = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)]) * half * (1 + (0 if upright else rng.normal(0, .3, (4, 1))))
        spin = np.array([[np.cos(yaw), -np.sin(yaw)], [np.sin(yaw), np.cos(yaw)]])
        cv2.fillConvexPoly(out, np.int32((corners @ spin.T + at) * 8), tuple(float(c) for c in ink), cv2.LINE_AA, 3)
    return np.clip(out * (1 + rng.uniform(0, .2) * noise(rng, SIZE, 4, 5)[..., None]), 0, 1)


def muted(rng, make):
    """A texture for a floor or wall: mostly with less colour than objects have."""
    out = make(rng)
    if rng.random() < 0.75:
        grey = out.mean(2, keepdims=True)
        out = grey + (out - grey) * rng.uniform(0, 0.6)
        out = np.clip(out + (rng.uniform(.25, .75) - out.mean()) * rng.uniform(0, .6), 0, 3).astype(np.float32)
    return out


GROUND = (speckle, speckle, wood, tiles, tiles, plaster, blotch, checks, gradient)
WALL = (clutter, clutter, plaster, plaster, plaster, window, window, tiles, blotch, printed, wood, speckle, gradient)
PAINT = (plaster, printed, printed, cardboard, cardboard, wood, checks, gradient, blotch)


def ground(rng):
    """A floor or table texture."""
    return muted(rng, pick(rng, GROUND))


def wall(rng):
    """A wall texture."""
    return muted(rng, pick(rng, WALL))
