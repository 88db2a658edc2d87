"""RGB-D sequences: a camera moves around a table or floor with several cones, cubes and spheres.

World frame: z up, the table top or floor with the objects at z = 0, metres. Needs numpy and OpenCV only.
"""
import json
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np

from . import render, scene_objects, scenes, solids, textures

WIDTH, HEIGHT, FOCAL = 640, 480, 615.0  # [px], like the colour camera of a RealSense D435i
RATE_HZ = 15.0
SUBPIXEL, DEPTH_FOCAL, BASELINE_M = 0.08, 424.0, 0.05  # stereo error, focal length [px], baseline of a D435i


@dataclass
class Placed:
    """An object of the scene: orientation, centre [m], scale [m], and its kind as text."""

    obj: scene_objects.SceneObject
    rotation: np.ndarray
    place: np.ndarray
    scale: float
    kind: str

    def extent(self):
        """Size along the object's own axes [m]."""
        return np.ptp(self.obj.points(), axis=0) * self.scale


def _ball(albedo, gloss=0.25):
    return lambda rng: scene_objects.SceneObject(scene_objects.SPHERE).ellipsoid(
        (0, 0, 0), (.5, .5, .5), render.Surface(albedo(rng), None, gloss, 40), scene_objects.any_rotation(rng))


def _block(face):
    def make(rng):
        looks = [render.Surface(None, scene_objects.edged(rng, texture), .1) for texture in face(rng)]
        return scene_objects.SceneObject(scene_objects.CUBE).box((0, 0, 0), (1, 1, 1), looks)
    return make


def _carton(rng):
    base = [render.Surface(None, scene_objects.edged(rng, textures.cardboard(rng))) for _ in range(2)]
    return scene_objects.SceneObject(scene_objects.CUBE).box((0, 0, 0), (1, rng.uniform(.75, .95), rng.uniform(.65, .9)), base)


def _traffic_cone(rng):
    albedo, body = solids.traffic_cone(rng)
    plate = render.Surface(None, textures.grain(rng, body, .02), .2)
    obj = scene_objects.SceneObject(scene_objects.CONE).box((0, 0, -.48), (.62, .62, .04), [plate])
    obj.frustum((0, 0, .02), .25, .04, .96, render.Surface(albedo, None, .2, 30))
    return obj


def _hat(rng):
    look = render.Surface(solids.solid(rng, textures.colour(rng, 'vivid')), None, .3, 40)
    return scene_objects.SceneObject(scene_objects.CONE).frustum((0, 0, 0), rng.uniform(.3, .42), 0, 1, look)


def _dice(rng):
    ink = textures.colour(rng, 'dark')
    return [scene_objects.dice_face(rng, (.94, .93, .9), ink, i + 1) for i in range(6)]


def _painted(rng):
    return [textures.grain(rng, textures.colour(rng, 'vivid'), .015)] * 6


KINDS = {  # name: (maker, height on a table [m], height on a floor [m])
    'traffic cone': (_traffic_cone, .16, .5), 'carton': (_carton, .17, .42), 'football': (_ball(solids.football), .12, .22),
    'party hat': (_hat, .15, .32), 'die': (_block(_dice), .09, .25), 'tennis ball': (_ball(solids.tennis, 0), .067, .12),
    'painted block': (_block(_painted), .08, .26), 'beach ball': (_ball(solids.sectors), .14, .36),
    'orange cone': (_traffic_cone, .2, .45), 'wooden block': (_block(lambda rng: [textures.wood(rng)] * 6), .1, .3),
    'marble': (_ball(lambda rng: solids.mapped(textures.blotch(rng), rng), .6), .09, .2)}


class Scene:
    """A seeded room with objects at rest on a table or on the floor."""

    def __init__(self, seed, count=7):
        rng = np.random.default_rng(seed)
        self.seed, self.table = seed, bool(rng.random() < 0.5)
        self.radius = 0.42 if self.table else 1.15  # of the area with objects [m]
        self.floor = textures.tiles(rng) if rng.random() < .4 else textures.wood(rng)
        self.top = textures.wood(rng) if rng.random() < .7 else textures.plaster(rng)
        self.paint = textures.grain(rng, textures.colour(rng, 'neutral') * .4 + .5, .01)
        self.posters = [textures.window(rng), textures.printed(rng), textures.wood(rng), textures.blotch(rng)]
        self.placed = []
        self._fill(rng, count)

    def _fill(self, rng, count):
        """Chooses objects of all classes and finds free places for them."""
        names, taken = list(KINDS), []
        order = [names[i] for i in rng.permutation(len(names))]
        firsts = [next(n for n in order if self._class(n) == c) for c in (scene_objects.CONE, scene_objects.CUBE, scene_objects.SPHERE)]
        for name in firsts + [n for n in order if n not in firsts][:max(0, count - 3)]:
            make, small, large = KINDS[name]
            obj, scale = make(rng), small if self.table else large
            for _ in range(200):
                spot = rng.uniform(-1, 1, 2) * self.radius * (1.25, .8)
                if all(np.hypot(*(spot - other)) > .75 * (scale + size) for other, size in taken):
                    break
            else:
                continue
            rotation = scene_objects.rotation((0, 0, 1), rng.uniform(0, 2 * np.pi))
            low = (obj.points() @ rotation.T)[:, 2].min() * scale
            taken.append((spot, scale))
            self.placed.append(Placed(obj, rotation, np.array([spot[0], spot[1], -low]), scale, name))

    @staticmethod
    def _class(name):
        return KINDS[name][0](np.random.default_rng(0)).label

    def pose(self, fraction):
        """Camera axes in the world (rows) and position [m] at a fraction 0..1 of the arc."""
        ease = fraction * fraction * (3 - 2 * fraction)
        azimuth = np.radians(-150 + 120 * ease + (self.seed % 5) * 7)
        distance = self.radius * (2.5 - 1.0 * np.sin(np.pi * fraction)) + .12
        height = self.radius * (1.25 + .45 * np.cos(2 * np.pi * fraction)) + .05
        place = np.array([np.cos(azimuth) * distance, np.sin(azimuth) * distance, height])
        target = np.array([.1 * np.sin(3 * fraction), .1 * np.cos(2 * fraction), .1]) * self.radius * 1.2
        ahead = target - place
        pitch = np.arctan2(-ahead[2], np.hypot(ahead[0], ahead[1]))
        return scenes.look(pitch, .02 * np.sin(5 * fraction), np.arctan2(ahead[1], ahead[0])), place

    def _room(self, world):
        """Floor, walls with window, painting, door; the table."""
        ground = -0.74 if self.table else 0.0
        half, tall = 3.2, 2.6
        world.plane(np.array([-half, -half, ground]), np.array([2 * half, 0, 0]), np.array([0, 2 * half, 0]), self.floor,
                    (5.0, 5.0), 0 if self.table else 1, .12)
        for index in range(4):
            angle = index * np.pi / 2
            ahead, side = np.array([np.cos(angle), np.sin(angle), 0]), np.array([-np.sin(angle), np.cos(angle), 0])
            corner = ahead * half - side * half + np.array([0, 0, ground])
            world.plane(corner, side * 2 * half, np.array([0, 0, tall]), self.paint, (2.0, 1.0))
            world.plane(corner - .01 * ahead, side * 2 * half, np.array([0, 0, .1]), textures.flat((.9, .9, .88)), (1.0, 1.0))
            wide, high, base = ((1.6, 1.1, .95), (.9, .7, 1.2), (.95, 2.05, 0.0), (1.2, .8, 1.2))[index]
            start = ahead * (half - .012) + side * (index * .7 - 1.6) + np.array([0, 0, ground + base])
            world.plane(start, side * wide, np.array([0, 0, high]), self.posters[index], (1.0, 1.0))
        if self.table:
            x, y = self.radius * 1.9, self.radius * 1.35
            edge = render.Surface(None, self.top * .8)
            obj = scene_objects.SceneObject(-1).box((0, 0, -.016), (2 * x, 2 * y, .03), [edge])
            for a, b in ((-1, -1), (-1, 1), (1, -1), (1, 1)):
                obj.box((a * (x - .05), b * (y - .05), -.38), (.06, .06, .7), [edge])
            world.draw(obj, np.eye(3), np.zeros(3), 1.0)
            world.plane(np.array([-x, -y, 0]), np.array([2 * x, 0, 0]), np.array([0, 2 * y, 0]), self.top, (1.0, 1.0), 1, .15)

    def render(self, fraction):
        """The image at a fraction of the arc: `scenes.LabelledImage` and the truth of each labelled object (list of dicts)."""
        rng = np.random.default_rng([self.seed, 1])
        rotation, place = self.pose(fraction)
        light = scenes.random_light(rng, rotation)
        light.sun, light.sky = light.sun * 0.6 + .35, light.sky * 0.4 + .3
        light.bounce, light.wrap = light.sky * .6, .3
        world = scenes.World(rng, (WIDTH, HEIGHT), (rotation, place), FOCAL, light)
        world.strength, world.softness = .5, .12
        self._room(world)
        for item in self.placed:
            world.shade(item.obj.points() @ item.rotation.T * item.scale + item.place)
        numbers = {world.draw(i.obj, i.rotation, i.place, i.scale): i for i in self.placed}
        sample = world.labelled(_apply_camera_effects(world.frame))
        truth = []
        for number, label, box in zip(sample.numbers, sample.labels, sample.boxes):
            item = numbers[number]
            middle = (item.obj.points().max(0) + item.obj.points().min(0)) / 2
            centre = world.to_camera([item.place + item.scale * (item.rotation @ middle)])[0]
            truth.append({'class': scenes.CLASSES[label], 'kind': item.kind, 'box': [int(v) for v in box],
                          'position': [round(float(v), 4) for v in centre], 'size': [round(float(v), 4) for v in item.extent()]})
        return sample, truth


def _apply_camera_effects(frame):
    """Linear light to 8-bit RGB: fixed exposure, smoothed edges."""
    image = np.sqrt(np.clip(frame.colour * 0.62, 0, 1))
    soft = cv2.GaussianBlur(image, (0, 0), 0.7)
    jump = cv2.morphologyEx(np.float32(frame.ids), cv2.MORPH_GRADIENT, np.ones((3, 3), np.uint8)) > 0
    image = np.where(jump[..., None], soft, image)
    return np.uint8(np.clip(image * 255 + 0.5, 0, 255))


def sensed_depth(rng, depth, noise):
    """Depth [m] as 16-bit millimetres, 0 where it is missing; with noise, like a stereo camera of D435i size."""
    out = np.where(np.isfinite(depth), depth, 0).astype(np.float32)
    if noise:
        error = cv2.GaussianBlur(rng.standard_normal(out.shape, dtype=np.float32), (0, 0), 1.2)
        error /= error.std()
        valid = out > 0
        edge = cv2.morphologyEx(out, cv2.MORPH_GRADIENT, np.ones((3, 3), np.uint8)) > 0.06 * (out + 1e-3)
        out = out + out * out * (SUBPIXEL / (DEPTH_FOCAL * BASELINE_M)) * error
        lost = edge & (rng.random(out.shape) < 0.7)
        out[lost | ~valid] = 0
    return np.uint16(np.clip(out * 1000 + 0.5, 0, 65535))


CAMERA_INFO = '''image_width: {w}
image_height: {h}
camera_name: generated
camera_matrix:
  rows: 3
  cols: 3
  data: [{f}, 0.0, {cx}, 0.0, {f}, {cy}, 0.0, 0.0, 1.0]
distortion_model: plumb_bob
distortion_coefficients:
  rows: 1
  cols: 5
  data: [0.0, 0.0, 0.0, 0.0, 0.0]
rectification_matrix:
  rows: 3
  cols: 3
  data: [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]
projection_matrix:
  rows: 3
  cols: 4
  data: [{f}, 0.0, {cx}, 0.0, 0.0, {f}, {cy}, 0.0, 0.0, 0.0, 1.0, 0.0]
'''


def pose_line(stamp, axes, place):
    """Pose of the optical frame in the world as TUM's recordings write it: stamp, position [m], quaternion x y z w."""
    r = np.asarray(axes).T  # columns: the camera's axes in the world
    w = .5 * np.sqrt(max(0.0, 1 + r[0, 0] + r[1, 1] + r[2, 2]))
    x = .5 * np.copysign(np.sqrt(max(0.0, 1 + r[0, 0] - r[1, 1] - r[2, 2])), r[2, 1] - r[1, 2])
    y = .5 * np.copysign(np.sqrt(max(0.0, 1 - r[0, 0] + r[1, 1] - r[2, 2])), r[0, 2] - r[2, 0])
    z = .5 * np.copysign(np.sqrt(max(0.0, 1 - r[0, 0] - r[1, 1] + r[2, 2])), r[1, 0] - r[0, 1])
    return f'{stamp:.6f} ' + ' '.join(f'{v:.6f}' for v in (*place, x, y, z, w)) + '\n'


def write(folder, frames, seed, noise=True, count=7):
    """Writes a sequence into a folder: rgb, depth, camera_info.yaml, associations.txt, groundtruth.txt, truth.json."""
    folder = Path(folder)
    for name in ('rgb', 'depth'):
        (folder / name).mkdir(parents=True, exist_ok=True)
    scene, rng, truth, lines, poses = Scene(seed, count), np.random.default_rng([seed, 2]), [], [], []
    for index in range(frames):
        sample, objects = scene.render(index / max(1, frames - 1))
        name, stamp = f'{index:06d}.png', index / RATE_HZ
        cv2.imwrite(str(folder / 'rgb' / name), sample.image[..., ::-1], [cv2.IMWRITE_PNG_COMPRESSION, 1])
        cv2.imwrite(str(folder / 'depth' / name), sensed_depth(rng, sample.depth, noise))
        lines.append(f'{stamp:.6f} rgb/{name} {stamp:.6f} depth/{name}\n')
        poses.append(pose_line(stamp, *scene.pose(index / max(1, frames - 1))))
        truth.append({'frame': index, 'stamp': round(stamp, 6), 'objects': objects})
    text = CAMERA_INFO.format(w=WIDTH, h=HEIGHT, f=FOCAL, cx=(WIDTH - 1) / 2, cy=(HEIGHT - 1) / 2)
    (folder / 'camera_info.yaml').write_text(text)
    (folder / 'associations.txt').write_text(''.join(lines))
    (folder / 'groundtruth.txt').write_text('# stamp tx ty tz qx qy qz qw: optical frame in the world\n' + ''.join(poses))
    (folder / 'truth.json').write_text(json.dumps({'seed': seed, 'frames': truth}, indent=1) + '\n')
