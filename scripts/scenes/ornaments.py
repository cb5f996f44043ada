# SPDX-License-Identifier: GPL-3.0-or-later
"""Bodies of revolution and other pieces that several scenes furnish themselves with. Profiles are (radius, y)."""

import math

from scenes.flat_shapes import slab
from scenes.mesh import Mesh, normalized
from scenes.round_shapes import ball_profile


def scaled_profile(profile, factor):
    return [(r * factor, h * factor) for r, h in profile]


def closed_profile(profile):
    """The profile with a pole in the plane of each of its ends."""
    return [(0.0, profile[0][1]), *profile, (0.0, profile[-1][1])]


def statue_profile():
    """A robed figure of 1.9 m on a round foot; the head is a ball on the neck."""
    robe = [(0.30, 0.0), (0.33, 0.06), (0.27, 0.12), (0.25, 0.45), (0.205, 0.85), (0.18, 1.05), (0.225, 1.28)]
    shoulders = [(0.23, 1.42), (0.16, 1.52), (0.07, 1.56), (0.065, 1.62)]
    head = [(r, y) for r, y in ball_profile(0.125, 6, 1.76) if y > 1.66]
    return [(0.0, 0.0), *robe, *shoulders, *head]


def bowl_profile(radius, height):
    """A fire bowl on a slender foot, hollow above."""
    foot = [(0.0, 0.0), (0.50, 0.0), (0.46, 0.05), (0.16, 0.12), (0.12, 0.45)]
    outside = [(0.22, 0.52), (0.70, 0.68), (0.95, 0.88), (1.0, 1.0)]
    inside = [(0.92, 1.0), (0.60, 0.78), (0.0, 0.70)]
    return [(r * radius, h * height) for r, h in foot + outside + inside]


def urn_profile(height):
    """A bellied urn with a lip, hollow down to half its height."""
    outside = [(0.0, 0.0), (0.20, 0.0), (0.21, 0.05), (0.12, 0.10), (0.24, 0.28), (0.345, 0.50), (0.33, 0.66)]
    neck = [(0.22, 0.80), (0.17, 0.87), (0.20, 0.95), (0.26, 1.0), (0.22, 0.985), (0.13, 0.87)]
    inside = [(0.20, 0.72), (0.22, 0.56), (0.0, 0.50)]
    return scaled_profile(outside + neck + inside, height)


def cypress_profile(height):
    """A slim evergreen on a short trunk."""
    trunk = [(0.0, 0.0), (0.030, 0.0), (0.028, 0.08)]
    crown = [(0.09, 0.10), (0.125, 0.22), (0.12, 0.42), (0.09, 0.66), (0.045, 0.88), (0.0, 1.0)]
    return scaled_profile(trunk + crown, height)


def flattened(mesh, factor):
    """The mesh squeezed along z, normals with it."""
    mesh.positions = [(x, y, z * factor) for x, y, z in mesh.positions]
    mesh.normals = [normalized((x, y, z / factor)) for x, y, z in mesh.normals]
    return mesh


def tiled_slope(name, material, eave, ridge, ends, tiles, courses, points=4, wave=0.045, thickness=0.1) -> Mesh:
    """A roof slope that falls towards +x, from the ridge (x, y) to the eave (x, y), between two z: a solid slab
    with a wave for each line of tiles and a step for each course."""
    (xe, ye), (xr, yr), (z0, z1) = eave, ridge, ends
    rows, count = [], tiles * points
    for course in range(courses):
        for t, lift in ((course / courses, 0.05), ((course + 1) / courses - 0.004, 0.0)):
            x, y = xe + (xr - xe) * t, ye + (yr - ye) * t + lift
            rows.append([])
            for k in range(count + 1):
                height = wave * abs(math.sin(math.pi * k / points)) if points > 2 else 0.0
                rows[-1].append((x, y + height, z1 + (z0 - z1) * k / count))
    return slab(name, material, rows, (0.0, -thickness, 0.0))
