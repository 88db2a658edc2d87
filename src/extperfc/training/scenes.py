"""Seeded generator of images with cones, cubes and spheres among other objects.

World frame: z up, the floor or table top at z = 0, metres. An image depends on nothing but its seed and size.
"""
from dataclasses import dataclass

import cv2
import numpy as np

from . import camera, others, polygons, render, rooms, scene_objects, textures
from .textures import pick

VERSION = 4
CLASSES = scene_objects.CLASSES
SIZE = (448, 336)  # width, height of training images [px]


@dataclass
class LabelledImage:
    """An image (H, W, 3) in RGB with depth [m] and, per labelled object, class, box x0, y0, x1, y1 and mask number."""

    image: np.ndarray
    depth: np.ndarray
    ids: np.ndarray
    labels: list
    boxes: list
    numbers: list
    ignored: list  # boxes of objects too much hidden to be asked for, yet not wrong to find


class World:
    """The camera's pose and the light; draws objects given in the world frame into a frame."""

    def __init__(self, rng, size, pose, focal, light):
        self.rng = rng
        self.rotation, self.place = pose  # rows: camera axes in the world; camera position [m]
        self.frame = render.Frame(size[0], size[1], focal, light)
        self.ground_id, self.count = 1, 1
        self.strength, self.softness = rng.uniform(.2, .9), rng.uniform(.03, .35)
        self.drawn = []  # (number, label, hull area in pixels)

    def to_camera(self, points):
        """World points (N, 3) in the camera frame."""
        return (np.asarray(points) - self.place) @ self.rotation.T

    def plane(self, origin, edge_u, edge_v, texture, repeat, ident=0, gloss=0.0):
        """Draws a textured rectangle spanned by two edges."""
        corners = self.to_camera([origin, origin + edge_u, origin + edge_u + edge_v, origin + edge_v])
        basis = (corners[0], corners[1] - corners[0], corners[3] - corners[0])
        polygons.polygon(self.frame, ident, corners, basis, render.Surface(None, texture, gloss, 20, 0, repeat), True)

    def shade(self, points, ident=None):
        """Draws the shadow of world points on the ground: a soft one from the sun, a dark one at the contact."""
        ident = self.ground_id if ident is None else ident
        seen, plane = self.to_camera(points), (self.to_camera([[0, 0, 0]])[0], self.rotation[:, 2])
        polygons.shadow(self.frame, seen, plane, self.frame.light.towards, ident, self.strength, self.softness)
        low = points[points[:, 2] < points[:, 2].min() + 0.3 * np.ptp(points[:, 2])]
        if low[:, 2].min() < 0.02 * np.ptp(points[:, 2]) + 1e-3:
            centre = low.mean(0)
            polygons.shadow(self.frame, self.to_camera(centre + (low - centre) * 1.12), plane, self.rotation[:, 2], ident, .5, .12)

    def draw(self, obj, rotation, place, scale):
        """Draws an object with world orientation and centre [m]; returns its number."""
        self.count += 1
        rot, t = self.rotation @ rotation, self.to_camera([place])[0]
        points = (obj.points() * scale) @ rot.T + t
        if points[:, 2].min() < render.NEAR:
            return None
        obj.draw(self.frame, self.count, rot, t, scale)
        hull = cv2.convexHull(np.float32(self.frame.project(points)))
        self.drawn.append((self.count, obj.label, max(1.0, cv2.contourArea(hull))))
        return self.count

    def labelled(self, image, min_fraction=0.35, min_size=12):
        """The labelled image; objects too hidden or too small are only listed as ignored (sizes at 320 px width)."""
        labels, boxes, numbers, ignored = [], [], [], []
        min_side = min_size * self.frame.width / 320
        for number, label, area in self.drawn:
            if label < 0:
                continue
            mask = self.frame.ids == number
            visible = int(np.count_nonzero(mask))
            if visible < max(12, 0.06 * area):
                continue
            x, y, w, h = cv2.boundingRect(np.uint8(mask))
            fraction = visible / area / (0.75 if label == scene_objects.CONE else 1.0)  # a cone with its plate does not fill its hull
            if fraction >= min_fraction and max(w, h) >= min_side and min(w, h) >= 0.4 * min_side:
                labels.append(label)
                boxes.append([x, y, x + w, y + h])
                numbers.append(number)
            else:
                ignored.append([x, y, x + w, y + h])
        return LabelledImage(image, self.frame.depth, self.frame.ids, labels, boxes, numbers, ignored)


def look(pitch, roll, yaw=0.0):
    """Rows: camera axes x (right), y (down), z (ahead) in the world, for a camera pitched down [rad]."""
    ahead = np.array([np.cos(pitch) * np.cos(yaw), np.cos(pitch) * np.sin(yaw), -np.sin(pitch)])
    right = np.array([np.sin(yaw), -np.cos(yaw), 0.0])
    down = np.cross(ahead, right)
    right, down = (np.cos(roll) * right + np.sin(roll) * down, np.cos(roll) * down - np.sin(roll) * right)
    return np.stack([right, down, ahead])


def random_light(rng, rotation):
    """Sun, sky and bounced light of random direction, colour and balance."""
    elevation, azimuth = rng.uniform(0.3, 1.45), rng.uniform(0, 2 * np.pi)
    towards = np.array([np.cos(elevation) * np.cos(azimuth), np.cos(elevation) * np.sin(azimuth), np.sin(elevation)])
    tint = np.exp(rng.normal(0, 0.08, (3, 3)))
    sun = rng.uniform(0.2, 1.4)
    sky = rng.uniform(0.3, 1.0)
    bounce = sky * rng.uniform(0.25, 0.9)
    return render.Light(rotation @ towards, rotation @ np.array([0, 0, 1.0]), np.float32(sun * tint[0]),
                        np.float32(sky * tint[1]), np.float32(bounce * tint[2]), pick(rng, (0.0, rng.uniform(0, .8))))


def _flat_shape(rng, world, spot, size):
    """A disc, polygon or long stripe drawn on the ground: looks like the outline of an object."""
    texture = textures.flat(textures.colour(rng))
    angle = rng.uniform(0, 6.28)
    sides = pick(rng, (3, 4, 4, 24, 24))
    ring = np.arange(sides) * 2 * np.pi / sides + np.pi / 4
    outline = np.column_stack([np.cos(ring), np.sin(ring), np.full(sides, .002)])
    if sides == 4 and rng.random() < .6:
        outline = outline * (rng.uniform(2, 12), rng.uniform(.1, .4), 1)
    points = world.to_camera(spot + size / 2 * outline @ scene_objects.rotation((0, 0, 1), angle).T)
    if points[:, 2].min() < render.NEAR:
        return
    basis = (points[0], points[1] - points[0], points[-1] - points[0])
    polygons.polygon(world.frame, 1, points, basis, render.Surface(None, texture), True)


def _stack(rng, placed):
    """Puts an object on top of the cube that was placed last."""
    below, rotation, place, scale = placed[-1]
    top = (below.points() @ rotation.T)[:, 2].max() * scale + place[2]
    obj = pick(rng, scene_objects.MAKERS)(rng)
    size = scale * rng.uniform(.5, 1)
    rotation = scene_objects.rotation((0, 0, 1), rng.uniform(0, 6.28))
    rise = top - (obj.points() @ rotation.T)[:, 2].min() * size
    placed.append((obj, rotation, np.array([place[0], place[1], rise]), size))


def _spot(rng, world, taken):
    """A free place on the ground in view: position, distance [m]; None when the search fails."""
    frame = world.frame
    for _ in range(20):
        pixel = np.array([rng.uniform(-.02, 1.02) * frame.width, rng.uniform(.05, 1.05) * frame.height, 1.0])
        inside = np.clip(pixel[:2], 0, (frame.width - 1, frame.height - 1)).astype(int)
        if frame.ids[inside[1], inside[0]] != world.ground_id:
            continue
        ray = np.array([(pixel[0] - frame.centre[0]) / frame.focal, (pixel[1] - frame.centre[1]) / frame.focal, 1.0]) @ world.rotation
        if ray[2] > -0.03:
            continue
        scale = -world.place[2] / ray[2]
        spot = world.place + scale * ray
        if all(np.hypot(*(spot - other)[:2]) > radius for other, radius in taken):
            return spot, scale
    return None


def _orientation(rng, obj):
    """A resting pose rotated about the vertical, seldom any pose at all."""
    if rng.random() < 0.06:
        return scene_objects.any_rotation(rng)
    yaw = rng.uniform(0, 2 * np.pi)
    if obj.label == scene_objects.CUBE and rng.random() < .2:
        yaw = rng.normal(0, 0.06)  # one face towards the camera
    return scene_objects.rotation((0, 0, 1), yaw) @ pick(rng, obj.rests)


def _pixels(rng, frame):
    """A wanted size in the image, log-uniform from 16 px at 320 px width to 70 % of the height."""
    low, high = 16 * frame.width / 320, 0.7 * frame.height
    return np.exp(rng.uniform(np.log(low), np.log(high)))


def _wanted(rng):
    """How many objects of each kind an image gets, shuffled: list of makers."""
    count = int(pick(rng, (0, 1, 1, 2, 2, 3, 3, 4, 5, 6, 6)))
    makers = [pick(rng, scene_objects.MAKERS + scene_objects.MAKERS + (scene_objects.cone,)) for _ in range(count)]
    makers += [others.other] * int(pick(rng, (0, 0, 1, 1, 2, 2, 3, 4, 6, 9)))
    order = rng.permutation(len(makers))
    return [makers[i] for i in order]


def _on_ground(rng, world):
    """Objects at rest on the ground, some held in the air, with shadows first."""
    taken, placed = [], []
    for _ in range(int(pick(rng, (0, 0, 0, 1, 2)))):
        found = _spot(rng, world, [])
        if found:
            _flat_shape(rng, world, found[0], min(_pixels(rng, world.frame) * found[1] / world.frame.focal, 2))
    common = _pixels(rng, world.frame)
    alike = rng.random() < .4
    for make in _wanted(rng):
        found = _spot(rng, world, taken)
        if found is None:
            continue
        spot, distance = found
        obj, pixels = make(rng), common * rng.uniform(.6, 1.5) if alike else _pixels(rng, world.frame)
        if obj.label < 0:
            pixels *= rng.uniform(1, 2)
        scale = pixels * distance / world.frame.focal
        scale = min(scale, 0.8 * distance)
        rotation = _orientation(rng, obj)
        points = obj.points() @ rotation.T * scale
        lift = scale * rng.uniform(0, 2) if rng.random() < .1 else 0.0
        place = spot + np.array([0, 0, lift - points[:, 2].min()])
        taken.append((spot, 0.45 * scale))
        placed.append((obj, rotation, place, scale))
        world.shade(points + place)
        if obj.label == scene_objects.CUBE and rng.random() < .15:
            _stack(rng, placed)
    for obj, rotation, place, scale in placed:
        world.draw(obj, rotation, place, scale)
        if obj.label >= 0 and rng.random() < (.1 if obj.label == scene_objects.SPHERE else .04):
            hand = others.limb(rng)
            world.draw(hand, scene_objects.any_rotation(rng), place + rng.normal(0, .35, 3) * scale, scale * rng.uniform(1, 2))


def _in_air(rng, world):
    """Objects in any pose before a collage."""
    frame = world.frame
    for make in _wanted(rng):
        obj, distance = make(rng), rng.uniform(1, 3)
        ray = np.array([rng.uniform(-.5, .5) * frame.width / frame.focal, rng.uniform(-.5, .5) * frame.height / frame.focal, 1])
        place = world.place + distance * ray @ world.rotation
        rotation = _orientation(rng, obj) if rng.random() < .7 else scene_objects.any_rotation(rng)
        world.draw(obj, rotation, place, _pixels(rng, frame) * distance / frame.focal)


def make_image(seed, size=SIZE):
    """The image of a seed; one seed in two sizes shows the same scene."""
    rng = np.random.default_rng(seed)
    pitch = np.radians(pick(rng, (rng.uniform(-3, 20), rng.uniform(5, 40), rng.uniform(20, 60), rng.uniform(50, 88))))
    rotation = look(pitch, rng.normal(0, np.radians(4)))
    place = np.array([0, 0, np.exp(rng.uniform(np.log(.2), np.log(2.2)))])
    world = World(rng, size, (rotation, place), size[0] * rng.uniform(.65, 1.6), random_light(rng, rotation))
    if rng.random() < .72:
        rooms.room(rng, world)
        _on_ground(rng, world)
    else:
        rooms.collage(rng, world.frame)
        _in_air(rng, world)
    image = camera.apply_camera_effects(rng, world.frame.colour, world.frame.depth)
    return world.labelled(image)
