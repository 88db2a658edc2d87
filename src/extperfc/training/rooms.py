"""What lies around and behind the objects: floor, table, walls, sky, or a collage."""
import cv2
import numpy as np

from . import textures
from .textures import pick


def _sky(rng, frame, rotation):
    """Fills the image above the horizon: gradient, clouds, a line of trees or houses."""
    rays = frame.rays((slice(0, frame.height), slice(0, frame.width)))
    up = rays @ np.float32(rotation[:, 2])
    t = np.clip(up * 2, 0, 1)[..., None]
    top, low = textures.colour(rng, pick(rng, ('pastel', 'neutral'))), np.float32([.85, .88, .92])
    if rng.random() < .6:
        top = np.float32([.35, .55, .85])
    sky = top * t + low * (1 - t)
    clouds = cv2.resize(textures.noise(rng, 128, 3, 4), (frame.width, frame.height))[..., None]
    sky = np.clip(sky + rng.uniform(0, .12) * clouds, 0, 1)
    if rng.random() < .7:
        edge = cv2.resize(textures.noise(rng, 128, 8, 5)[:1], (frame.width, 1))
        trees = np.float32(pick(rng, ([.2, .3, .12], [.3, .36, .2], [.5, .45, .4]))) * (1 + .3 * clouds)
        sky = np.where((up < .08 + .05 * edge)[..., None], np.clip(trees, 0, 1), sky)
    frame.colour[:] = textures.linear(sky) * rng.uniform(.8, 1.6)


def collage(rng, frame):
    """Fills the image with a texture and random shapes, lines and words."""
    texture = textures.clutter(rng) if rng.random() < .4 else pick(rng, textures.GROUND + textures.WALL)(rng)
    image = cv2.resize(texture, (frame.width, frame.height))
    unit = frame.width / 448
    for _ in range(int(rng.integers(0, 25))):
        ink = tuple(float(c) for c in textures.colour(rng))
        at = np.array([rng.uniform(0, frame.width), rng.uniform(0, frame.height)])
        size = unit * np.exp(rng.uniform(np.log(8), np.log(200)))
        kind = rng.integers(5)
        if kind == 0:
            cv2.fillPoly(image, [np.int32(at + size * rng.normal(0, 1, (int(rng.integers(3, 7)), 2)))], ink, cv2.LINE_AA)
        elif kind == 1:
            end = tuple(np.int32(at + size * rng.normal(0, 2, 2)))
            cv2.line(image, tuple(np.int32(at)), end, ink, int(rng.integers(1, 12)), cv2.LINE_AA)
        elif kind == 2:
            axes = (int(size), int(size * rng.uniform(.2, .7)))
            angle, width = rng.uniform(0, 180), int(pick(rng, (-1, 2, 5)))
            cv2.ellipse(image, tuple(np.int32(at)), axes, angle, 0, 360, ink, width, cv2.LINE_AA)
        elif kind == 3:
            end = tuple(np.int32(at + size * rng.uniform(.3, 2, 2)))
            cv2.rectangle(image, tuple(np.int32(at)), end, ink, int(pick(rng, (-1, -1, 3))))
        else:
            patch = cv2.resize(pick(rng, textures.WALL)(rng), (int(size) + 2, int(size * rng.uniform(.5, 2)) + 2))
            x, y = np.int32(at)
            part = image[y:y + patch.shape[0], x:x + patch.shape[1]]
            part[:] = patch[:part.shape[0], :part.shape[1]]
    if rng.random() < .5:
        image = cv2.GaussianBlur(image, (0, 0), unit * rng.uniform(.5, 8))
    frame.colour[:] = textures.linear(image)


def room(rng, world):
    """Draws walls, floor and perhaps a table; the ground at z = 0 gets the number that shadows look for."""
    height, far = world.place[2], world.place[2] * rng.uniform(1.5, 12)
    tabletop = rng.random() < 0.4
    if rng.random() < 0.3:
        _sky(rng, world.frame, world.rotation)
        wide = 80.0
    else:
        wide = far
        _walls(rng, world, far)
    repeat = rng.uniform(1, 6) * wide / max(height, .3)
    repeat = max(1.0, round(min(repeat, 60)))
    floor = -height * rng.uniform(.5, 2) if tabletop else 0.0
    ident = 0 if tabletop else 1
    world.plane(np.array([-wide, -wide, floor]), np.array([2 * wide, 0, 0]), np.array([0, 2 * wide, 0]),
                textures.ground(rng), (repeat, repeat), ident, float(pick(rng, (0, rng.uniform(0, .5)))))
    if tabletop:
        size = height * rng.uniform(1.0, 4, 2)
        x0, y0 = height * rng.uniform(.0, 1.0), -size[1] * rng.uniform(.3, .7)
        ground = textures.ground(rng)
        edge = [size[0], size[1], -height * rng.uniform(.02, .1)]
        side = textures.flat(ground.mean((0, 1)) * .7)
        world.plane(np.array([x0, y0, 0]), np.array([0, size[1], 0]), np.array([0, 0, edge[2]]), side, (1, 1))
        world.plane(np.array([x0, y0, 0]), np.array([size[0], 0, 0]), np.array([0, size[1], 0]), ground,
                    (max(1, round(rng.uniform(.6, 3))),) * 2, 1, float(pick(rng, (0, rng.uniform(0, .6)))))


def _walls(rng, world, far):
    """Three walls around the scene, with posters and flat drawn shapes on them."""
    yaw, tall = rng.uniform(-.7, .7), world.place[2] * rng.uniform(1.5, 6) + 1
    base = textures.wall(rng)
    for index in range(3):
        angle = yaw + (index - 1) * np.pi / 2
        ahead = np.array([np.cos(angle), np.sin(angle), 0])
        side = np.array([-np.sin(angle), np.cos(angle), 0])
        texture = base if rng.random() < .6 else textures.wall(rng)
        middle = ahead * far * rng.uniform(.7, 1)
        world.plane(middle - side * far * 1.5 + np.array([0, 0, -tall]), side * far * 3, np.array([0, 0, 2.5 * tall]),
                    texture, (int(rng.integers(1, 4)), 1))
        for _ in range(int(rng.integers(0, 3))):
            size = far * rng.uniform(.1, .5)
            at = middle * .995 + side * far * rng.uniform(-1, .8) + np.array([0, 0, world.place[2] * rng.uniform(-.2, 1.2)])
            poster = pick(rng, (textures.printed, textures.window, textures.wood, textures.gradient, textures.blotch))(rng)
            world.plane(at, side * size, np.array([0, 0, size * rng.uniform(.5, 2)]), poster, (1, 1))
