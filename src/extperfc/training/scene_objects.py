"""The objects in a scene, and how to make cones, cubes and spheres.

An object has unit size (its largest extent is about 1 m), z up, and is scaled when it is placed.
"""
from dataclasses import dataclass, field

import cv2
import numpy as np

from . import polygons, render, solids, textures
from .textures import pick

CLASSES = ('cone', 'cube', 'sphere')
CONE, CUBE, SPHERE = range(3)

_GOLDEN = np.pi * (3 - 5 ** 0.5)
_BALL = np.stack([np.array([np.cos(i * _GOLDEN) * (1 - z * z) ** .5, np.sin(i * _GOLDEN) * (1 - z * z) ** .5, z])
                  for i, z in enumerate(np.linspace(-1, 1, 90))])
_RING = np.stack([np.cos(np.arange(24) * np.pi / 12), np.sin(np.arange(24) * np.pi / 12)], 1)


def rotation(axis, angle):
    """Rotation matrix about an axis [rad]."""
    axis = np.asarray(axis, float) / np.linalg.norm(axis)
    cross = np.array([[0, -axis[2], axis[1]], [axis[2], 0, -axis[0]], [-axis[1], axis[0], 0]])
    return np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross


def any_rotation(rng):
    """A uniformly random rotation."""
    q, r = np.linalg.qr(rng.standard_normal((3, 3)))
    q = q * np.sign(np.diag(r))
    return q if np.linalg.det(q) > 0 else q[:, ::-1]


@dataclass
class SceneObject:
    """Parts to draw, points whose hull is the object, and its class (-1: not to be found)."""

    label: int
    parts: list = field(default_factory=list)
    rests: list = field(default_factory=lambda: [np.eye(3)])

    def points(self):
        """Sample points (N, 3) of all parts."""
        return np.concatenate([part[1] for part in self.parts])

    def ellipsoid(self, centre, radii, surface, rotation=None):
        """Adds an ellipsoid."""
        rotation = np.eye(3) if rotation is None else rotation
        centre = np.asarray(centre, float)
        points = (_BALL * radii) @ rotation.T + centre
        self.parts.append((lambda frame, ident, rot, t, s: render.ellipsoid(
            frame, ident, rot @ rotation, t + s * (rot @ centre), np.asarray(radii) * s, surface), points))
        return self

    def frustum(self, centre, bottom, top, height, surface, rotation=None):
        """Adds a cone, cylinder or disc."""
        rotation = np.eye(3) if rotation is None else rotation
        centre = np.asarray(centre, float)
        ends = ((bottom, -height / 2), (top, height / 2))
        rings = [np.column_stack([_RING * r, np.full(len(_RING), z)]) for r, z in ends]
        points = np.concatenate(rings) @ rotation.T + centre
        self.parts.append((lambda frame, ident, rot, t, s: render.frustum(
            frame, ident, rot @ rotation, t + s * (rot @ centre), bottom * s, top * s, height * s, surface), points))
        return self

    def polygon(self, points, surface, two_sided=False):
        """Adds a convex polygon, its texture spanned by the first, second and last corner."""
        points = np.asarray(points, float)

        def draw(frame, ident, rot, t, s):
            moved = (points * s) @ rot.T + t
            polygons.polygon(frame, ident, moved, (moved[0], moved[1] - moved[0], moved[-1] - moved[0]), surface, two_sided)
        self.parts.append((draw, points))
        return self

    def box(self, centre, size, surfaces, rotation=None):
        """Adds a box with one surface per face (six, or one for all)."""
        rotation = np.eye(3) if rotation is None else rotation
        for index in range(6):
            axis, sign = index // 2, (-1, 1)[index % 2]
            u, v = np.eye(3)[(axis + 1) % 3], np.eye(3)[(axis + 2) % 3] * sign
            middle = np.eye(3)[axis] * sign
            corners = np.array([middle - u - v, middle + u - v, middle + u + v, middle - u + v]) * np.asarray(size) / 2
            # The sign of v makes every face's normal point outwards.
            self.polygon(corners @ rotation.T + centre, surfaces[index % len(surfaces)])
        return self

    def draw(self, frame, ident, rot, t, scale):
        """Draws all parts with object-to-camera rotation and centre t [m]."""
        for part in self.parts:
            part[0](frame, ident, rot, t, scale)


def surface(rng, albedo=None, texture=None, **more):
    """A surface with random gloss and bumps."""
    gloss = float(pick(rng, (0, 0, rng.uniform(0, .3), rng.uniform(.2, 1.2))))
    bump = float(pick(rng, (0, 0, 0, rng.uniform(.02, .2))))
    return render.Surface(albedo, texture, gloss, float(10 ** rng.uniform(0.7, 2.5)), bump, **more)


def edged(rng, texture):
    """A face texture with worn or dark edges."""
    out = texture.copy()
    if rng.random() < 0.6:
        width, gain = int(rng.integers(1, 5)), rng.uniform(0.6, 1.4)
        for part in (out[:width], out[-width:], out[:, :width], out[:, -width:]):
            part *= gain
    return np.clip(out, 0, 3)


def sphere(rng):
    """A ball."""
    albedo = solids.any_ball(rng)
    if rng.random() < 0.35:
        albedo = solids.worn(rng, albedo)
    rotation = any_rotation(rng)
    squash = 1 + rng.normal(0, 0.01)
    return SceneObject(SPHERE).ellipsoid((0, 0, 0), (.5, .5, .5 * squash), surface(rng, albedo), rotation)


def dice_face(rng, ground, ink, count):
    """One face of a die."""
    out = textures.flat(ground)
    spots = {1: [(1, 1)], 2: [(0, 0), (2, 2)], 3: [(0, 0), (1, 1), (2, 2)], 4: [(0, 0), (0, 2), (2, 0), (2, 2)],
             5: [(0, 0), (0, 2), (2, 0), (2, 2), (1, 1)], 6: [(0, 0), (0, 1), (0, 2), (2, 0), (2, 1), (2, 2)]}[count]
    for x, y in spots:
        cv2.circle(out, (48 * x + 48, 48 * y + 48), 17, tuple(float(c) for c in ink), -1, cv2.LINE_AA)
    return out


def _letter_face(rng, ground, ink, _):
    """One face of a toy block: frame and letter."""
    out = textures.flat(ground)
    tint = tuple(float(c) for c in ink)
    cv2.rectangle(out, (10, 10), (182, 182), tint, int(rng.integers(4, 18)))
    cv2.putText(out, pick(rng, 'ABCDEFGHKMNPRSTUXZ23456789'), (45, 145), 0, 5, tint, 16, cv2.LINE_AA)
    return out


def _rubik_face(rng, ground, ink, _):
    """One face of a puzzle cube."""
    count = int(rng.integers(2, 5))
    out = textures.flat((.05, .05, .05))
    shades = [(.8, .1, .1), (.1, .3, .8), (.1, .6, .2), (.95, .85, .1), (.95, .45, .05), (.95, .95, .95)]
    step = textures.SIZE // count
    for i in range(count):
        for j in range(count):
            out[i * step + 5:(i + 1) * step - 4, j * step + 5:(j + 1) * step - 4] = pick(rng, shades)
    return out


def _faces(rng):
    """Six face textures of a box."""
    kind = rng.random()
    if kind < 0.18:
        make = pick(rng, (dice_face, _letter_face, _letter_face, _rubik_face))
        ground, ink = textures.colour(rng), textures.colour(rng)
        varied = rng.random() < 0.4 and make is _letter_face
        return [make(rng, textures.colour(rng) if varied else ground, ink, i + 1) for i in range(6)]
    if kind < 0.42:
        base = textures.cardboard(rng)
        return [base, textures.cardboard(rng) if rng.random() < .4 else base] * 3
    if kind < 0.62:
        rgb = textures.colour(rng)
        base = textures.grain(rng, rgb, rng.uniform(0, .05))
        return [base] * 6
    if kind < 0.72:
        return [textures.flat(textures.colour(rng)) for _ in range(6)]
    if kind < 0.80:
        base = textures.wood(rng)
        return [base] * 6
    make = pick(rng, textures.PAINT)
    three = [make(rng) for _ in range(3)]
    return [three[0], three[0], three[1], three[1], three[2], three[2]]


def box(rng, label, size):
    """A box of a class with random faces; size holds the proportions."""
    look = surface(rng)
    faces = [edged(rng, face) for face in _faces(rng)]
    looks = [render.Surface(None, face, look.gloss * .7, look.shininess) for face in faces]
    size = np.asarray(size) / max(size)
    obj = SceneObject(label).box((0, 0, 0), size, looks)
    if rng.random() < 0.08 and label == CUBE:  # open flaps of a carton
        for side in (-1, 1):
            out = rng.uniform(-.1, .3)
            x = side * size[0] / 2
            obj.polygon([(x, -size[1] / 2, size[2] / 2), (x, size[1] / 2, size[2] / 2),
                           (x + side * out, size[1] / 2, size[2] / 2 + .18), (x + side * out, -size[1] / 2, size[2] / 2 + .18)],
                          looks[0], True)
    return obj


def cube(rng):
    """A cube or a compact box, at rest on a face."""
    if rng.random() < 0.5:
        size = np.ones(3) * rng.uniform(0.97, 1.03, 3)
    else:
        size = rng.uniform(0.52, 1.0, 3)
        size[int(rng.integers(3))] = 1.0
    return box(rng, CUBE, size)


def _lying(alpha):
    """A cone's pose on its side, half angle alpha [rad]."""
    return rotation((1, 0, 0), np.pi / 2 + alpha)


def cone(rng):
    """A plain cone, a party hat or a traffic cone with its base plate."""
    obj = SceneObject(CONE)
    radius = rng.uniform(0.18, 0.52)
    tip = 0.0
    if rng.random() < 0.5:  # traffic cone
        albedo, body = solids.traffic_cone(rng)
        look = surface(rng, albedo)
        radius, tip = rng.uniform(.2, .34), rng.uniform(0.02, 0.075)
        plate, wide = rng.uniform(0.02, 0.07), radius * rng.uniform(1.1, 1.5)
        base = body if rng.random() < .6 else textures.colour(rng, 'dark')
        if rng.random() < 0.6:
            flat = render.Surface(None, textures.grain(rng, base, .03), look.gloss)
            obj.box((0, 0, -.5 + plate / 2), (2 * wide, 2 * wide, plate), [flat])
        elif rng.random() < 0.7:
            round_look = render.Surface(solids.solid(rng, base), None, look.gloss)
            obj.frustum((0, 0, -.5 + plate / 2), wide, wide * .95, plate, round_look)
        obj.frustum((0, 0, plate / 2), radius, tip, 1 - plate, look)
        obj.frustum((0, 0, .5), tip * .85, tip * .85, .004, render.Surface(solids.solid(rng, (.05, .04, .04))))
    else:
        tip = 0.0 if rng.random() < 0.7 else radius * rng.uniform(0.03, 0.22)
        look = surface(rng, solids.any_cone(rng))
        obj.frustum((0, 0, 0), radius, tip, 1.0, look)
        if rng.random() < 0.15:  # bobble on the tip
            size = rng.uniform(.04, .1)
            obj.ellipsoid((0, 0, .5), (size,) * 3, surface(rng, solids.solid(rng)))
    obj.rests = [np.eye(3)] * 9 + [_lying(np.arctan2(radius - tip, 1.0))]
    return obj


MAKERS = (cone, cube, sphere)
