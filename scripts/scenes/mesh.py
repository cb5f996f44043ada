# SPDX-License-Identifier: GPL-3.0-or-later
"""Triangle meshes and the shapes they are put together from.

Y is up, lengths are metres, triangles are counter-clockwise seen from the side that the normal points to:
outwards for solids, into the room for the walls of a room. Only smooth meshes carry normals.
"""

import math
from dataclasses import dataclass


@dataclass
class Mesh:
    """One named object. `kind` says what the self-check may expect of it:
    "solid": closed, normals outwards; "room": a part of the shell around the air; "sheet": anything open."""

    name: str
    material: str
    positions: list
    triangles: list
    normals: list | None = None
    texcoords: list | None = None
    kind: str = "solid"


def add(a, b):
    return (a[0] + b[0], a[1] + b[1], a[2] + b[2])


def subtract(a, b):
    return (a[0] - b[0], a[1] - b[1], a[2] - b[2])


def scaled(a, factor):
    return (a[0] * factor, a[1] * factor, a[2] * factor)


def dot(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def cross(a, b):
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def normalized(a):
    length = math.sqrt(dot(a, a))
    return scaled(a, 1.0 / length)


def merged(name, material, parts, kind="solid"):
    """One object out of several; all parts have normals, or none has."""
    positions, triangles, normals = [], [], []
    for part in parts:
        first = len(positions)
        positions += part.positions
        normals += part.normals or []
        triangles += [(a + first, b + first, c + first) for a, b, c in part.triangles]
    assert not normals or len(normals) == len(positions)
    return Mesh(name, material, positions, triangles, normals or None, kind=kind)


def moved(mesh, offset=(0.0, 0.0, 0.0), turn=0.0, name=None):
    """A copy turned about the y axis (radians, +z towards +x) and then shifted."""
    c, s = math.cos(turn), math.sin(turn)
    if abs(c) < 1e-12 or abs(s) < 1e-12:  # quarter turns stay exact
        c, s = float(round(c)), float(round(s))

    def turned(v):
        return (c * v[0] + s * v[2], v[1], -s * v[0] + c * v[2])

    positions = [add(turned(p), offset) for p in mesh.positions]
    normals = [turned(n) for n in mesh.normals] if mesh.normals else None
    return Mesh(name or mesh.name, mesh.material, positions, list(mesh.triangles), normals, mesh.texcoords, mesh.kind)


def quad(name, material, a, b, c, d, kind="room"):
    """Two triangles; a, b, c, d counter-clockwise seen from the side of the normal."""
    return Mesh(name, material, [a, b, c, d], [(0, 1, 2), (0, 2, 3)], kind=kind)


BOX_TRIANGLES = [
    (0, 2, 1), (0, 3, 2), (4, 5, 6), (4, 6, 7), (0, 1, 5), (0, 5, 4),
    (1, 2, 6), (1, 6, 5), (2, 3, 7), (2, 7, 6), (3, 0, 4), (3, 4, 7),
]  # fmt: skip


def hexahedron(name, material, corners):
    """Solid with eight corners: four of the z- side (x- y-, x+ y-, x+ y+, x- y+), then the same of the z+ side."""
    return Mesh(name, material, list(corners), list(BOX_TRIANGLES))


def box(name, material, low, high):
    """Axis-aligned solid box, 8 shared vertices."""
    (x0, y0, z0), (x1, y1, z1) = low, high
    front = [(x0, y0, z1), (x1, y0, z1), (x1, y1, z1), (x0, y1, z1)]
    return hexahedron(name, material, [(x0, y0, z0), (x1, y0, z0), (x1, y1, z0), (x0, y1, z0)] + front)


def standing_box(name, material, centre, size):
    """Box from the centre of its lower face and its size."""
    (x, y, z), (w, h, d) = centre, size
    return box(name, material, (x - w / 2, y, z - d / 2), (x + w / 2, y + h, z + d / 2))


def room(low, high, materials, open_sides=()):
    """The six sides of a box of air as quads with normals inwards, named floor, ceiling, wall_left (x-),
    wall_right (x+), wall_back (z-), wall_front (z+); `materials` maps these names to materials."""
    (x0, y0, z0), (x1, y1, z1) = low, high
    sides = {
        "floor": [(x0, y0, z0), (x0, y0, z1), (x1, y0, z1), (x1, y0, z0)],
        "ceiling": [(x0, y1, z0), (x1, y1, z0), (x1, y1, z1), (x0, y1, z1)],
        "wall_left": [(x0, y0, z0), (x0, y1, z0), (x0, y1, z1), (x0, y0, z1)],
        "wall_right": [(x1, y0, z0), (x1, y0, z1), (x1, y1, z1), (x1, y1, z0)],
        "wall_back": [(x0, y0, z0), (x1, y0, z0), (x1, y1, z0), (x0, y1, z0)],
        "wall_front": [(x0, y0, z1), (x0, y1, z1), (x1, y1, z1), (x1, y0, z1)],
    }
    return [quad(name, materials[name], *corners) for name, corners in sides.items() if name not in open_sides]


def square_ring(name, material, outer, inner, y0, y1):
    """Rectangular ring about the y axis; `outer` and `inner` are half extents (x, z)."""
    positions = []
    for y in (y0, y1):
        for hx, hz in (outer, inner):
            positions += [(-hx, y, -hz), (-hx, y, hz), (hx, y, hz), (hx, y, -hz)]
    triangles = []
    for k in range(4):
        n = (k + 1) % 4
        for a, b, c, d in ((k, n, n + 8, k + 8), (n + 4, k + 4, k + 12, n + 12),
                           (k + 8, n + 8, n + 12, k + 12), (n, k, k + 4, n + 4)):  # fmt: skip
            triangles += [(a, b, c), (a, c, d)]
    return Mesh(name, material, positions, triangles)


def profile_normals(profile):
    """Unit normals (radial, y) of a profile's points: the mean of the segments beside each, flat end caps left out."""
    segments = []
    for (r0, y0), (r1, y1) in zip(profile, profile[1:]):
        length = math.hypot(r1 - r0, y1 - y0)
        cap = y0 == y1 and (r0 == 0.0 or r1 == 0.0)
        segments.append(((y1 - y0) / length, (r0 - r1) / length, cap) if length > 0.0 else None)
    normals = []
    for i, (radius, _) in enumerate(profile):
        beside = [s for s in (segments[i - 1] if i else None, segments[i] if i < len(segments) else None) if s]
        walls = [s for s in beside if not s[2]] or beside
        nr, ny = sum(s[0] for s in walls), sum(s[1] for s in walls)
        if radius == 0.0:
            nr = 0.0
        length = math.hypot(nr, ny)
        normals.append((nr / length, ny / length))
    return normals


def lathe(name, material, profile, segments, centre=(0.0, 0.0, 0.0), flutes=None):
    """Smooth solid of revolution about a vertical axis. The profile (radius, y) runs from the lower pole, radius 0,
    to the upper; a point given twice is a crease. `flutes` = (count, depth, y0, y1) makes the radius wave."""
    positions, normals, rings = [], [], []
    for (radius, y), (nr, ny) in zip(profile, profile_normals(profile)):
        rings.append(len(positions))
        for j in range(segments if radius > 0.0 else 1):
            angle = 2.0 * math.pi * j / segments
            r, tilt = radius, 0.0
            if flutes and flutes[2] <= y <= flutes[3]:
                r = radius - flutes[1] * (0.5 - 0.5 * math.cos(flutes[0] * angle))
                tilt = math.atan2(0.5 * flutes[1] * flutes[0] * math.sin(flutes[0] * angle), r)
            positions.append((centre[0] + r * math.cos(angle), centre[1] + y, centre[2] + r * math.sin(angle)))
            normals.append((nr * math.cos(angle + tilt), ny, nr * math.sin(angle + tilt)))
    triangles = []
    for i in range(len(profile) - 1):
        if profile[i] != profile[i + 1]:
            triangles += band(rings[i], profile[i][0], rings[i + 1], profile[i + 1][0], segments)
    return Mesh(name, material, positions, triangles, normals)


def band(low, low_radius, high, high_radius, segments):
    """Triangles between two rings of a lathe, either of which may be a pole."""
    triangles = []
    for j in range(segments):
        n = (j + 1) % segments
        if high_radius > 0.0:
            triangles.append((low + (j if low_radius > 0.0 else 0), high + j, high + n))
        if low_radius > 0.0:
            triangles.append((low + j, high + (n if high_radius > 0.0 else 0), low + n))
    return triangles


def ball_profile(radius, rings, y=0.0):
    """Profile of a ball about (0, y): `rings` circles between the poles."""
    steps = [(i, math.pi * i / (rings + 1)) for i in range(rings + 2)]
    return [(0.0 if i in (0, rings + 1) else radius * math.sin(t), y - radius * math.cos(t)) for i, t in steps]


def ball(name, material, centre, radius, segments, rings):
    return lathe(name, material, ball_profile(radius, rings), segments, centre)


def icosphere(name, material, centre, radius, levels, inwards=False):
    """Near-uniform sphere of 20 * 4^levels triangles, no normals."""
    g = (1.0 + math.sqrt(5.0)) / 2.0
    corners = [(-1, g, 0), (1, g, 0), (-1, -g, 0), (1, -g, 0), (0, -1, g), (0, 1, g),
               (0, -1, -g), (0, 1, -g), (g, 0, -1), (g, 0, 1), (-g, 0, -1), (-g, 0, 1)]  # fmt: skip
    points = [normalized(p) for p in corners]
    faces = [(0, 11, 5), (0, 5, 1), (0, 1, 7), (0, 7, 10), (0, 10, 11), (1, 5, 9), (5, 11, 4), (11, 10, 2),
             (10, 7, 6), (7, 1, 8), (3, 9, 4), (3, 4, 2), (3, 2, 6), (3, 6, 8), (3, 8, 9), (4, 9, 5),
             (2, 4, 11), (6, 2, 10), (8, 6, 7), (9, 8, 1)]  # fmt: skip
    for _ in range(levels):
        points, faces = subdivided(points, faces)
    if inwards:
        faces = [(a, c, b) for a, b, c in faces]
    positions = [add(scaled(p, radius), centre) for p in points]
    return Mesh(name, material, positions, faces, kind="room" if inwards else "solid")


def subdivided(points, faces):
    """Each triangle of the unit sphere into four."""
    points, middle = list(points), {}

    def between(a, b):
        key = (min(a, b), max(a, b))
        if key not in middle:
            middle[key] = len(points)
            points.append(normalized(add(points[a], points[b])))
        return middle[key]

    finer = []
    for a, b, c in faces:
        ab, bc, ca = between(a, b), between(b, c), between(c, a)
        finer += [(a, ab, ca), (b, bc, ab), (c, ca, bc), (ab, bc, ca)]
    return points, finer


def prism(name, material, polygon, z0, z1):
    """Solid over a simple polygon of (x, y), counter-clockwise, from z0 to z1."""
    n = len(polygon)
    cap = ears(polygon)
    triangles = [(a, c, b) for a, b, c in cap] + [(a + n, b + n, c + n) for a, b, c in cap]
    for k in range(n):
        j = (k + 1) % n
        triangles += [(k, j, j + n), (k, j + n, k + n)]
    return Mesh(name, material, [(x, y, z) for z in (z0, z1) for x, y in polygon], triangles)


def ears(polygon):
    """Triangles of a simple counter-clockwise polygon: of all ears the roundest is cut first."""
    left, triangles = list(range(len(polygon))), []
    while len(left) > 3:
        best = max(range(len(left)), key=lambda k: ear_quality(polygon, left, k))
        a, b, c = left[best - 1], left[best], left[(best + 1) % len(left)]
        triangles.append((a, b, c))
        del left[best]
    return triangles + [tuple(left)]


def ear_quality(polygon, left, k):
    """Area over longest side squared of the ear at corner k; -1 where it is none."""
    a, b, c = polygon[left[k - 1]], polygon[left[k]], polygon[left[(k + 1) % len(left)]]
    area = turn(a, b, c)
    if area <= 1e-9:
        return -1.0
    corners = (a, b, c)
    for p in (polygon[i] for i in left):
        if p not in corners and turn(a, b, p) >= 0.0 and turn(b, c, p) >= 0.0 and turn(c, a, p) >= 0.0:
            return -1.0
    return area / max((p[0] - q[0]) ** 2 + (p[1] - q[1]) ** 2 for p, q in ((a, b), (b, c), (c, a)))


def turn(a, b, c):
    """Twice the signed area of a triangle in the plane."""
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])


def slab(name, material, rows, offset):
    """Solid between a grid of points and its copy shifted by `offset`. Seen from outside, with the shift
    leading away from the eye, a row runs to the right and the next row lies above."""
    count = len(rows[0])
    top = [p for row in rows for p in row]
    below = len(top)
    triangles = []
    for i in range(len(rows) - 1):
        for j in range(count - 1):
            a, b, c, d = i * count + j, i * count + j + 1, (i + 1) * count + j + 1, (i + 1) * count + j
            triangles += [(a, b, c), (a, c, d)]
            triangles += [(a + below, c + below, b + below), (a + below, d + below, c + below)]
    last = (len(rows) - 1) * count
    rim = list(range(count)) + [i * count + count - 1 for i in range(1, len(rows))]
    rim += [last + j for j in range(count - 2, -1, -1)] + [i * count for i in range(len(rows) - 2, 0, -1)]
    for k, a in enumerate(rim):
        b = rim[(k + 1) % len(rim)]
        triangles += [(a, a + below, b + below), (a, b + below, b)]
    return Mesh(name, material, top + [add(p, offset) for p in top], triangles)


def tube(name, material, path, cores, radius, sides):
    """Smooth closed tube along a closed path of points (a torus, a knot). `cores` holds a point beside each point
    of the path, never straight ahead of it, from which the cross-sections start: it keeps them from twisting."""
    count, positions, normals, triangles = len(path), [], [], []
    for i, p in enumerate(path):
        ahead = normalized(subtract(path[(i + 1) % count], path[i - 1]))
        out = subtract(p, cores[i])
        out = normalized(subtract(out, scaled(ahead, dot(out, ahead))))
        side = cross(ahead, out)
        for j in range(sides):
            t = 2.0 * math.pi * j / sides
            normal = add(scaled(out, math.cos(t)), scaled(side, math.sin(t)))
            positions.append(add(p, scaled(normal, radius)))
            normals.append(normal)
    for i in range(count):
        k = (i + 1) % count
        for j in range(sides):
            n = (j + 1) % sides
            a, b, c, d = i * sides + j, i * sides + n, k * sides + n, k * sides + j
            triangles += [(a, b, c), (a, c, d)]
    return Mesh(name, material, positions, triangles, normals)
