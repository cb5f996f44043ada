# SPDX-License-Identifier: GPL-3.0-or-later
"""Smooth shapes with normals (solids of revolution, tubes) and the icosphere, which is flat."""

import math

from scenes.mesh import Mesh, add, cross, dot, normalized, scaled, subtract


CREASE = math.radians(55)


def turn(a, b, c):
    """Angle by which a profile turns at b; 0 where a point is given twice."""
    u, v = (b[0] - a[0], b[1] - a[1]), (c[0] - b[0], c[1] - b[1])
    return abs(math.atan2(u[0] * v[1] - u[1] * v[0], u[0] * v[0] + u[1] * v[1])) if u != (0, 0) and v != (0, 0) else 0.0


def with_creases(profile):
    """Sharp edges and the rims of flat ends are creases."""
    creased = []
    for i, point in enumerate(profile):
        creased.append(point)
        if not 0 < i < len(profile) - 1 or point in (profile[i - 1], profile[i + 1]):
            continue
        ends_cap = i == 1 and profile[0] == (0.0, point[1])
        begins_cap = i == len(profile) - 2 and profile[-1] == (0.0, point[1])
        if ends_cap or begins_cap or turn(profile[i - 1], point, profile[i + 1]) > CREASE:
            creased.append(point)
    return creased


def profile_normals(profile):
    """Unit normals (radial, y) of a profile's points: the mean of the segments beside each."""
    segments = []
    for (r0, y0), (r1, y1) in zip(profile, profile[1:]):
        length = math.hypot(r1 - r0, y1 - y0)
        segments.append(((y1 - y0) / length, (r0 - r1) / length) if length > 0.0 else None)
    normals = []
    for i, (radius, _) in enumerate(profile):
        beside = [s for s in (segments[i - 1] if i else None, segments[i] if i < len(segments) else None) if s]
        nr, ny = sum(s[0] for s in beside), sum(s[1] for s in beside)
        if radius == 0.0:
            nr = 0.0
        length = math.hypot(nr, ny)
        normals.append((nr / length, ny / length))
    return normals


def lathe(name, material, profile, segments, centre=(0.0, 0.0, 0.0), flutes=None):
    """Smooth solid of revolution about a vertical axis. The profile (radius, y) runs from the lower pole, radius 0,
    to the upper; a point given twice is a crease. `flutes` = (count, depth, y0, y1) makes the radius wave."""
    positions, normals, rings = [], [], []
    profile = with_creases(profile)
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
