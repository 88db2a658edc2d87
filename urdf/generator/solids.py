"""Low-polygon solids as lists of triangles, and binary STL files of them.

A solid is a list of triangles; a triangle is three points, counter-clockwise from outside. Lengths in m.
"""

import math
import struct


def moved(solid, xyz=(0, 0, 0), rpy=(0, 0, 0)):
    """The solid turned by roll, pitch, yaw about the fixed axes, then shifted."""
    (cr, sr), (cp, sp), (cy, sy) = ((math.cos(a), math.sin(a)) for a in rpy)
    rows = ((cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr),
            (sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr),
            (-sp, cp * sr, cp * cr))

    def move(p):
        return tuple(r[0] * p[0] + r[1] * p[1] + r[2] * p[2] + t for r, t in zip(rows, xyz))
    return [tuple(move(p) for p in triangle) for triangle in solid]


def mirrored_y(solid):
    return [tuple((x, -y, z) for x, y, z in reversed(triangle)) for triangle in solid]


def skin(rings, cap_start=True, cap_end=True):
    """Surface through closed rings with equal numbers of points, counter-clockwise seen from the last ring."""
    solid = []
    for low, high in zip(rings, rings[1:]):
        n = len(low)
        for i in range(n):
            a, b, c, d = low[i], low[(i + 1) % n], high[(i + 1) % n], high[i]
            solid += [(a, b, c), (a, c, d)]
    if cap_start:
        solid += fan(rings[0][::-1])
    if cap_end:
        solid += fan(rings[-1])
    return [t for t in solid if area(t) > 1e-12]


def fan(ring):
    middle = tuple(sum(p[k] for p in ring) / len(ring) for k in range(3))
    return [(middle, ring[i], ring[(i + 1) % len(ring)]) for i in range(len(ring))]


def cross(triangle):
    (a, b, c) = triangle
    u, v = [b[k] - a[k] for k in range(3)], [c[k] - a[k] for k in range(3)]
    return (u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0])


def area(triangle):
    return math.hypot(*cross(triangle)) / 2


def ellipse(rx, ry, n, exponent=2.0):
    """Points of a superellipse: 2 is an ellipse, more is a rounded rectangle."""
    points = []
    for i in range(n):
        c, s = math.cos(2 * math.pi * (i + 0.5) / n), math.sin(2 * math.pi * (i + 0.5) / n)
        points.append((rx * math.copysign(abs(c) ** (2 / exponent), c),
                       ry * math.copysign(abs(s) ** (2 / exponent), s)))
    return points


def rounded_rectangle(length, width, radius, n_corner):
    """Points counter-clockwise, n_corner + 1 in each corner."""
    points = []
    for corner, (sx, sy) in enumerate(((1, 1), (-1, 1), (-1, -1), (1, -1))):
        for i in range(n_corner + 1):
            angle = math.pi / 2 * (corner + i / n_corner)
            points.append((sx * (length / 2 - radius) + radius * math.cos(angle),
                           sy * (width / 2 - radius) + radius * math.sin(angle)))
    return points


def hull(points):
    """Convex hull in the plane, counter-clockwise."""
    points = sorted(set(points))

    def half(ordered):
        chain = []
        for p in ordered:
            while len(chain) > 1 and ((chain[-1][0] - chain[-2][0]) * (p[1] - chain[-2][1])
                                      - (chain[-1][1] - chain[-2][1]) * (p[0] - chain[-2][0])) <= 1e-12:
                chain.pop()
            chain.append(p)
        return chain[:-1]
    return half(points) + half(points[::-1])


def inset(outline, distance):
    """A convex outline with every corner moved inwards along its bisector."""
    result = []
    for i, p in enumerate(outline):
        normals = []
        for a, b in ((outline[i - 1], p), (p, outline[(i + 1) % len(outline)])):
            length = math.hypot(b[0] - a[0], b[1] - a[1])
            normals.append(((a[1] - b[1]) / length, (b[0] - a[0]) / length))
        nx, ny = normals[0][0] + normals[1][0], normals[0][1] + normals[1][1]
        scale = distance * 2 / (nx * nx + ny * ny)
        result.append((p[0] + nx * scale, p[1] + ny * scale))
    return result


def prism(outline, z0, z1, bevel=0.0, steps=2):
    """A convex outline raised from z0 to z1, its edges rounded by `bevel`."""
    if bevel <= 0:
        return skin([[(x, y, z) for x, y in outline] for z in (z0, z1)])
    rings = []
    for z, direction in ((z0, 1), (z1, -1)):
        for i in range(steps + 1):
            angle = math.pi / 2 * i / steps
            rings.append([(x, y, z + direction * bevel * (1 - math.sin(angle)))
                          for x, y in inset(outline, bevel * (1 - math.cos(angle)))])
    return skin(sorted(rings, key=lambda ring: ring[0][2]))


def box(size, bevel=0.0):
    """A box around the origin; its edges are cut off by `bevel`."""
    x, y, z = size
    outline = rounded_rectangle(x, y, bevel, 1) if bevel > 0 else [
        (x / 2, y / 2), (-x / 2, y / 2), (-x / 2, -y / 2), (x / 2, -y / 2)]
    return prism(outline, -z / 2, z / 2, bevel, 1)


def revolved(profile, n, cap_start=True, cap_end=True):
    """Profile of (radius, z), z rising, turned about z in n steps."""
    rings = [[(r * math.cos(2 * math.pi * i / n), r * math.sin(2 * math.pi * i / n), z) for i in range(n)]
             for r, z in profile]
    return skin(rings, cap_start, cap_end)


def cylinder(radius, z0, z1, n, bevel=0.0):
    if bevel <= 0:
        return revolved([(radius, z0), (radius, z1)], n)
    k = bevel * (1 - math.sqrt(0.5))
    return revolved([(radius - bevel, z0), (radius - k, z0 + k), (radius, z0 + bevel),
                     (radius, z1 - bevel), (radius - k, z1 - k), (radius - bevel, z1)], n)


def loft(sections, n, exponent=2.0):
    """Surface through superellipses that lie across z: sections are (z, centre x, radius x, radius y)."""
    return skin([[(cx + x, y, z) for x, y in ellipse(rx, ry, n, exponent)] for z, cx, rx, ry in sections])


def torus(radius, thickness, n, n_tube):
    rings = []
    for i in range(n):
        angle = 2 * math.pi * i / n
        ring = []
        for k in range(n_tube):
            r = radius + thickness * math.cos(2 * math.pi * k / n_tube)
            ring.append((r * math.cos(angle), r * math.sin(angle), thickness * math.sin(2 * math.pi * k / n_tube)))
        rings.append(ring[::-1])
    return skin(rings + rings[:1], cap_start=False, cap_end=False)


def tube(start, end, radius, n, bevel=0.0):
    """A cylinder between two points."""
    d = [e - s for s, e in zip(start, end)]
    length = math.hypot(*d)
    return moved(cylinder(radius, 0, length, n, bevel), start, (0, math.acos(d[2] / length), math.atan2(d[1], d[0])))


def stl_bytes(solid):
    """A binary STL file; coordinates are rounded to 1 um so that every machine writes the same ones."""
    parts = [b"extperfc, made by urdf/generate.py".ljust(80, b" "), struct.pack("<I", len(solid))]
    for triangle in solid:
        points = tuple(tuple(round(c, 6) + 0.0 for c in p) for p in triangle)
        n = cross(triangle)
        length = math.hypot(*n)
        normal = tuple(round(c / length, 4) + 0.0 for c in n)
        parts.append(struct.pack("<12fH", *normal, *points[0], *points[1], *points[2], 0))
    return b"".join(parts)
