"""Objects that must not be found: cans, bottles, slabs, furniture, people and more."""
import numpy as np

from . import render, solids, textures
from .textures import pick
from .scene_objects import SceneObject, any_rotation, box, edged, rotation, surface


def cylinder(rng):
    """A can, pipe, cup, bucket or lampshade."""
    bottom = rng.uniform(0.1, 0.5)
    top = bottom * pick(rng, (1, 1, 1, rng.uniform(.5, 1), rng.uniform(1, 1.5)))
    obj = SceneObject(-1).frustum((0, 0, 0), bottom, min(top, .5), rng.uniform(0.35, 1.0), surface(rng, solids.any_solid(rng)))
    obj.rests = [np.eye(3)] * 3 + [rotation((1, 0, 0), np.pi / 2)]
    return obj


def bottle(rng):
    """A bottle or vase of stacked rounds."""
    obj, radius, z = SceneObject(-1), rng.uniform(.1, .2), -.5
    body, neck = rng.uniform(.4, .6), rng.uniform(.03, .08)
    look = surface(rng, solids.any_solid(rng))
    plain = render.Surface(solids.solid(rng), None, look.gloss, look.shininess)
    obj.frustum((0, 0, z + body / 2), radius, radius, body, look)
    shoulder = rng.uniform(.1, .3)
    obj.frustum((0, 0, z + body + shoulder / 2), radius, neck, shoulder, plain)
    rest = 1 - body - shoulder
    obj.frustum((0, 0, .5 - rest / 2), neck, neck, rest, plain)
    obj.rests = [np.eye(3)] * 3 + [rotation((1, 0, 0), np.pi / 2)]
    return obj


def slab(rng):
    """A book, tablet, board or shelf: a flat box."""
    size = np.array([1.0, rng.uniform(.4, 1.0), rng.uniform(.015, .16)])
    obj = box(rng, -1, size)
    obj.rests = [np.eye(3)] * 2 + [rotation((1, 0, 0), np.pi / 2), rotation((0, 1, 0), np.pi / 2)]
    return obj


def post(rng):
    """A long bar, leg, pole or frame."""
    size = np.array([rng.uniform(.03, .28), rng.uniform(.03, .28), 1.0])
    obj = box(rng, -1, size)
    obj.rests = [np.eye(3)] * 2 + [rotation((1, 0, 0), np.pi / 2)]
    return obj


def pyramid(rng):
    """A pyramid or tent of three to five sides, or a prism."""
    obj, sides, radius = SceneObject(-1), int(rng.integers(3, 5)), rng.uniform(.3, .6)
    angles = np.arange(sides) * 2 * np.pi / sides
    ring = np.column_stack([np.cos(angles) * radius, np.sin(angles) * radius, np.full(sides, -.5)])
    ring2 = ring * (0, 0, -1) if rng.random() < .6 else ring * (1, 1, -1) * (rng.uniform(.3, 1.0), 1, 1)
    face = edged(rng, pick(rng, textures.PAINT)(rng))
    look = render.Surface(None, face)
    for i in range(sides):
        j = (i + 1) % sides
        quad = [ring[i], ring[j], ring2[j], ring2[i]]
        obj.polygon(quad if np.ptp(ring2[:, :2]) > 0 else [ring[i], ring[j], ring2[i]], look)
    obj.polygon(ring2 if np.ptp(ring2[:, :2]) > 0 else ring[::-1], look, True)
    return obj


def egg(rng):
    """A long or flat ellipsoid: rugby ball, melon, pebble, bowl."""
    radii = np.array([.5, rng.uniform(.15, .34), rng.uniform(.1, .36)])
    obj = SceneObject(-1).ellipsoid((0, 0, 0), radii, surface(rng, solids.any_ball(rng)), rotation((0, 0, 1), rng.uniform(0, 6)))
    obj.rests = [np.eye(3)] * 3 + [any_rotation(rng)]
    return obj


def capsule(rng):
    """A sausage of two ends and a middle."""
    radius, look = rng.uniform(.08, .2), surface(rng, solids.solid(rng))
    obj = SceneObject(-1).frustum((0, 0, 0), radius, radius, 1 - 2 * radius, look)
    for side in (-1, 1):
        obj.ellipsoid((0, 0, side * (.5 - radius)), (radius,) * 3, look)
    obj.rests = [np.eye(3), rotation((1, 0, 0), np.pi / 2), any_rotation(rng)]
    return obj


def torus(rng):
    """A ring, tyre or handle, as a mesh."""
    obj, tube = SceneObject(-1), rng.uniform(.06, .17)
    around = np.arange(21) * 2 * np.pi / 20
    over = np.arange(11) * 2 * np.pi / 10
    rgb = textures.colour(rng)
    look = render.Surface(None, textures.grain(rng, rgb, .03))

    def spot(a, b):
        reach = .5 - tube + tube * np.cos(b)
        return np.array([np.cos(a) * reach, np.sin(a) * reach, tube * np.sin(b)])
    for i in range(20):
        for j in range(10):
            obj.polygon([spot(around[i], over[j]), spot(around[i + 1], over[j]),
                           spot(around[i + 1], over[j + 1]), spot(around[i], over[j + 1])], look)
    obj.rests = [np.eye(3), np.eye(3), rotation((1, 0, 0), np.pi / 2)]
    return obj


def disc(rng):
    """A plate, coin, lid or wheel."""
    obj = SceneObject(-1).frustum((0, 0, 0), .5, rng.uniform(.4, .5), rng.uniform(.01, .14), surface(rng, solids.any_solid(rng)))
    obj.rests = [np.eye(3), np.eye(3), rotation((1, 0, 0), np.pi / 2), rotation((1, 0, 0), rng.uniform(0, 1.5))]
    return obj


def table(rng):
    """A table, stool or chair: a top, four legs, sometimes a back."""
    obj = SceneObject(-1)
    look = [render.Surface(None, pick(rng, (textures.wood, textures.plaster))(rng))]
    wide, deep, thick, leg = rng.uniform(.5, 1), rng.uniform(.4, 1), rng.uniform(.02, .1), rng.uniform(.03, .08)
    top = rng.uniform(0, .45)
    obj.box((0, 0, top), (wide, deep, thick), look)
    for x in (-1, 1):
        for y in (-1, 1):
            obj.box((x * (wide - leg) / 2, y * (deep - leg) / 2, (top - .5) / 2), (leg, leg, top + .5), look)
    if rng.random() < .4:
        obj.box((0, deep / 2, top + .25), (wide, leg, .5), look)
    return obj


SKIN = ((.86, .66, .54), (.76, .55, .42), (.6, .42, .3), (.4, .27, .19), (.93, .76, .66))


def limb(rng):
    """A hand or arm: fingers and a palm in the colour of skin."""
    skin = np.float32(pick(rng, SKIN)) * rng.uniform(.8, 1.1)
    look = render.Surface(solids.solid(rng, np.clip(skin, 0, 1)), None, .1)
    obj = SceneObject(-1).ellipsoid((0, 0, -.1), (.2, .08, .22), look)
    for i in range(4):
        bend = rotation((1, 0, 0), rng.uniform(-.2, .9))
        obj.ellipsoid((-.15 + .1 * i, .03, .2), (.045, .045, .2), look, bend)
    obj.ellipsoid((-.2, .04, .0), (.05, .05, .17), look, rotation((0, 1, 0), -.6))
    obj.frustum((0, 0, -.45), .1, .09, .5, look)
    obj.rests = [any_rotation(rng)]
    return obj


def person(rng):
    """A standing figure of a head, a body and limbs."""
    skin = render.Surface(solids.solid(rng, pick(rng, SKIN)))
    hair = render.Surface(solids.solid(rng, textures.colour(rng, 'dark')))
    shirt, trousers = surface(rng, solids.any_solid(rng)), surface(rng, solids.solid(rng))
    obj = SceneObject(-1).ellipsoid((0, 0, .43), (.045, .055, .07), skin)
    obj.ellipsoid((0, .012, .45), (.05, .055, .06), hair)
    obj.frustum((0, 0, .18), .075, .1, .34, shirt)
    for side in (-1, 1):
        swing = rotation((1, 0, 0), rng.normal(0, .4))
        obj.frustum((side * .05, 0, -.25), .04, .055, .5, trousers, rotation((1, 0, 0), rng.normal(0, .15)))
        obj.ellipsoid((side * .13, 0, .18), (.03, .03, .2), pick(rng, (skin, shirt)), swing)
    return obj


def portrait(rng):
    """Head and shoulders: the roundest object in many photographs that is no ball."""
    skin = render.Surface(solids.solid(rng, np.float32(pick(rng, SKIN)) * rng.uniform(.8, 1.1)), None, rng.uniform(0, .2))
    dark = render.Surface(solids.solid(rng, textures.colour(rng, 'dark')))
    wide, deep, tall = rng.uniform(.13, .16), rng.uniform(.15, .18), rng.uniform(.19, .22)
    obj = SceneObject(-1).ellipsoid((0, 0, .25), (wide, deep, tall), skin)
    if rng.random() < .85:
        hair = dark if rng.random() < .7 else surface(rng, solids.solid(rng))
        obj.ellipsoid((0, rng.uniform(.015, .05), .25 + rng.uniform(.02, .07)), (wide * 1.08, deep, tall), hair)
    for side in (-1, 1):
        obj.ellipsoid((side * wide * .4, -deep * .9, .28), (.022, .02, .012), dark)
        obj.ellipsoid((side * wide, .01, .25), (.02, .035, .05), skin)
    obj.ellipsoid((0, -deep, .22), (.02, .03, .04), skin)
    obj.ellipsoid((0, -deep * .88, .14), (.05, .02, .012), render.Surface(solids.solid(rng, (.6, .25, .25))))
    obj.frustum((0, .02, .03), .08, .08, .2, skin)
    obj.ellipsoid((0, .03, -.28), (.36, .17, .3), surface(rng, solids.any_solid(rng)))
    obj.rests = [rotation((0, 0, 1), rng.normal(0, .6))]
    return obj


def shelf(rng):
    """A board with a row of books, or a pile of them."""
    obj, x = SceneObject(-1), -.5
    pile = rng.random() < .4
    while x < .45:
        thick, tall = rng.uniform(.02, .09), rng.uniform(.25, .4)
        face = render.Surface(None, textures.printed(rng) if rng.random() < .3 else textures.flat(textures.colour(rng)))
        size = (tall, .28, thick) if pile else (thick, .28, tall)
        centre = (rng.normal(0, .02), 0, x + thick / 2) if pile else (x + thick / 2, 0, tall / 2)
        obj.box(centre, size, [face])
        x += thick * (1 if rng.random() < .9 else 2)
    if not pile:
        obj.box((0, 0, -.015), (1.05, .3, .03), [render.Surface(None, textures.wood(rng))])
    return obj


OTHERS = (cylinder, cylinder, bottle, slab, slab, post, pyramid, egg, capsule, torus, disc, table, limb, person,
          portrait, portrait, shelf)


def other(rng):
    """An object that must not be found."""
    return pick(rng, OTHERS)(rng)
