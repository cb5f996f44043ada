# SPDX-License-Identifier: GPL-3.0-or-later
"""Shapes with flat faces, whose vertices the faces share: boxes, rooms, rings, prisms, slabs."""

from scenes.mesh import Mesh, add


def quad(name, material, a, b, c, d, kind="room"):
    """Two triangles; a, b, c, d counter-clockwise seen from the side of the normal."""
    return Mesh(name, material, [a, b, c, d], [(0, 1, 2), (0, 2, 3)], kind=kind)


BOX_TRIANGLES = [
    (0, 2, 1), (0, 3, 2), (4, 5, 6), (4, 6, 7), (0, 1, 5), (0, 5, 4),
    (1, 2, 6), (1, 6, 5), (2, 3, 7), (2, 7, 6), (3, 0, 4), (3, 4, 7),
]  # fmt: skip  # fmt: skip


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
    area = doubled_area(a, b, c)
    if area <= 1e-9:
        return -1.0
    corners = (a, b, c)
    for p in (polygon[i] for i in left):
        if p not in corners and doubled_area(a, b, p) >= 0.0 and doubled_area(b, c, p) >= 0.0 and doubled_area(c, a, p) >= 0.0:
            return -1.0
    return area / max((p[0] - q[0]) ** 2 + (p[1] - q[1]) ** 2 for p, q in ((a, b), (b, c), (c, a)))


def doubled_area(a, b, c):
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
