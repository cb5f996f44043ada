# SPDX-License-Identifier: GPL-3.0-or-later
"""A cloister: vaulted walks with round arches around a court; the lamp moves over the court."""

import math

from scenes.description import Camera, Description, Light, Scene
from scenes.flat_shapes import box, prism, square_ring, standing_box
from scenes.glb import Material
from scenes.mesh import Mesh, merged, moved
from scenes.ornaments import closed_profile, cypress_profile, tiled_slope, urn_profile
from scenes.round_shapes import ball, lathe
from scenes.vault import groin_vault

BAY = 2.0
BAYS = (8, 4)  # along x and z
LINE = (8.0, 4.0)  # half extents of the columns' line
WALL = (10.5, 6.5)  # half extents of the outer wall's inner face
WALK = 0.3  # height of the walks' floor
SPRING = 2.75  # height where arches and vaults begin
ARCH = 0.78  # radius of the arches
EAVE = 4.3  # top of the arcade walls
QUARTER = 0.5 * math.pi

ABOUT = """
A court of 15 × 7 m with a fountain, lawns, cypresses and pots; around it walks with groin vaults behind round arches
on fluted columns, under tiled roofs that slope to the court; over one corner a belfry. The lamp moves over the court
and shines through the arches into the walks.

**A stand-in.** The model is ours, with the counts of objects, vertices and triangles (81, 40,939, 81,410; each within
5 %), the grid (61,712 cells), photons (30,000) and lamp positions (96) that C.-H. Lin's thesis (2005) states for its
cloister; it is not the thesis' model. The cameras are named after the thesis' figures; where they stand is our
choice.

Lamp positions of the thesis' figures 31–33 (our stand-ins):

| figure | camera | first | second | third |
|---|---|---|---|---|
| 31 | `front` | [-2.6, 3.2, -1.5] | [0, 3.9, 0] | [2.6, 4.7, 1.5] |
| 32 | `oblique` | [2.6, 3.2, -1.6] | [0, 3.9, 0] | [-2.6, 4.6, 1.6] |
| 33 | `right` | [2.8, 3.1, 1.5] | [0.8, 3.9, 0.2] | [-2.4, 4.6, -1.5] |
"""

MATERIALS = [
    Material("paving", (0.52, 0.46, 0.38)),
    Material("tiles", (0.50, 0.26, 0.17)),
    Material("lawn", (0.16, 0.30, 0.08)),
    Material("stone", (0.70, 0.62, 0.49)),
    Material("column", (0.74, 0.68, 0.57)),
    Material("plaster", (0.72, 0.58, 0.40)),
    Material("vault", (0.74, 0.70, 0.62)),
    Material("rib", (0.58, 0.36, 0.25)),
    Material("roof", (0.58, 0.24, 0.13)),
    Material("water", (0.12, 0.32, 0.42)),
    Material("pot", (0.62, 0.30, 0.17)),
    Material("shrub", (0.14, 0.28, 0.08)),
    Material("bronze", (0.30, 0.34, 0.22)),
    Material("wood", (0.32, 0.18, 0.09)),
]


def arch(centre, radius, foot, rise, segments=20):
    """Points of a round or elliptical arch from its left foot to its right foot."""
    points = []
    for k in range(segments + 1):
        angle = math.pi * k / segments
        points.append((centre - radius * math.cos(angle), foot + rise * math.sin(angle)))
    points[0], points[-1] = (centre - radius, foot), (centre + radius, foot)
    return points


def arcade(name, bays, end):
    """One arcade wall along x about z = 0, from -end to end, with the slabs that its arches stand on."""
    outline = [(-end, SPRING)]
    for k in range(bays):
        outline += arch((k + 0.5 - bays / 2) * BAY, ARCH, SPRING, ARCH)
    outline += [(end, SPRING), (end, EAVE), (-end, EAVE)]
    parts = [prism(name, "stone", outline, -0.18, 0.18)]
    for k in range(1, bays):
        x = (k - bays / 2) * BAY
        parts.append(standing_box(name, "stone", (x, SPRING - 0.14, 0.0), (0.56, 0.14, 0.50)))
    return merged(name, "stone", parts)


def column_profile():
    """Base, shaft and bell capital of a slender column, 2.31 m."""
    base = [(0.27, 0.0), (0.29, 0.05), (0.27, 0.10), (0.20, 0.13), (0.225, 0.18), (0.20, 0.23), (0.155, 0.26)]
    shaft = [(0.155, 0.30), (0.158, 0.75), (0.155, 1.10), (0.150, 1.45), (0.142, 1.80)]
    capital = [(0.14, 1.84), (0.17, 1.87), (0.14, 1.90), (0.155, 2.00), (0.20, 2.14), (0.255, 2.24), (0.26, 2.31)]
    return closed_profile(base + shaft + capital)


def columns():
    places = [(k * BAY, side * LINE[1]) for side in (-1, 1) for k in range(-3, 4)]
    places += [(side * LINE[0], k * BAY) for side in (-1, 1) for k in range(-1, 2)]
    parts = []
    for k, (x, z) in enumerate(places, 1):
        shape = lathe(f"column_{k:02}", "column", column_profile(), 32, (x, WALK, z), flutes=(8, 0.03, 0.29, 1.81))
        parts.append(shape)
    for k, (x, z) in enumerate(((-1, -1), (1, -1), (1, 1), (-1, 1)), 1):
        foot = (x * LINE[0], WALK, z * LINE[1])
        parts.append(standing_box(f"pier_{k}", "stone", foot, (0.56, SPRING - WALK, 0.56)))
    return parts


def arcades():
    back = arcade("arcade_back", BAYS[0], LINE[0] + 0.18)
    side = arcade("arcade_left", BAYS[1], LINE[1] - 0.18)
    return [
        moved(back, (0.0, 0.0, -LINE[1])),
        moved(back, (0.0, 0.0, LINE[1]), name="arcade_front"),
        moved(side, (-LINE[0], 0.0, 0.0), QUARTER),
        moved(side, (LINE[0], 0.0, 0.0), QUARTER, name="arcade_right"),
    ]


def vaults():
    """A vault for each bay, one object for each walk and corner; they reach 1 cm into the walls."""
    depth = tuple(0.5 * (w - a - 0.18) + 0.01 for w, a in zip(WALL, LINE))  # half the walks' width
    middle = tuple(0.5 * (w + a + 0.18) for w, a in zip(WALL, LINE))

    def bay(x, z, half_x, half_z):
        return groin_vault("vault", "vault", (x, z), (half_x, half_z), SPRING, 0.92, 4.0, 6)

    parts = []
    for name, side in (("back", -1), ("front", 1)):
        bays = [bay((k + 0.5) * BAY, side * middle[1], 0.9, depth[1]) for k in range(-4, 4)]
        parts.append(merged(f"vault_{name}", "vault", bays))
    for name, side in (("left", -1), ("right", 1)):
        bays = [bay(side * middle[0], (k + 0.5) * BAY, depth[0], 0.9) for k in range(-2, 2)]
        parts.append(merged(f"vault_{name}", "vault", bays))
    for k, (x, z) in enumerate(((-1, -1), (1, -1), (1, 1), (-1, 1)), 1):
        corner = bay(x * middle[0], z * middle[1], depth[0], depth[1])
        corner.name = f"vault_corner_{k}"
        parts.append(corner)
    return parts


def ribs():
    """The arches across the walks, between the vaults and a little into them."""
    half = 0.5 * (WALL[1] - LINE[1] - 0.18) + 0.01
    outline = [(-half, SPRING - 0.25), *arch(0.0, half - 0.12, SPRING - 0.25, 1.03), (half, SPRING - 0.25)]
    outline += [(half, 3.95), (-half, 3.95)]
    parts = []
    for side in (-1, 1):
        for k in range(-4, 5):
            across = prism("ribs", "rib", outline, -0.13, 0.13)
            x = k * BAY + (0.05 if k == 4 else -0.05 if k == -4 else 0.0)
            parts.append(moved(across, (x, 0.0, side * 0.5 * (WALL[1] + LINE[1] + 0.18)), QUARTER))
        for k in range(-2, 3):
            across = prism("ribs", "rib", outline, -0.13, 0.13)
            z = k * BAY + (0.05 if k == 2 else -0.05 if k == -2 else 0.0)
            parts.append(moved(across, (side * 0.5 * (WALL[0] + LINE[0] + 0.18), 0.0, z)))
    return merged("ribs", "rib", parts)


def roofs():
    """Four lean-to roofs; at the corners the higher one covers the lower."""
    parts = []
    for name, line, wall, end, turn in (
        ("left", LINE[0], WALL[0], WALL[1], 0.0), ("right", LINE[0], WALL[0], WALL[1], 2 * QUARTER),
        ("front", LINE[1], WALL[1], WALL[0], QUARTER), ("back", LINE[1], WALL[1], WALL[0], -QUARTER),
    ):  # fmt: skip
        # made as the roof of the left walk, which falls towards +x
        eave, ridge = (-line + 0.45, EAVE + 0.27), (-wall - 0.02, EAVE + 0.27 + 0.52 * (wall + 0.47 - line))
        ends, tiles = (-end - 0.02, end + 0.02), round(2 * end / 0.35)
        slope = tiled_slope(f"roof_{name}", "roof", eave, ridge, ends, tiles, 5, points=3, wave=0.06)
        parts.append(moved(slope, turn=turn))
    return parts


def walls():
    door = [(-0.7, WALK), (0.7, WALK), *reversed(arch(0.0, 0.7, 1.9, 0.7))]
    return [
        box("ground", "paving", (-10.8, -0.15, -6.8), (10.8, 0.0, 6.8)),
        square_ring("walk_floor", "tiles", (10.5, 6.5), (7.6, 3.6), 0.0, WALK),
        square_ring("outer_wall", "plaster", (10.8, 6.8), WALL, 0.0, 6.0),
        square_ring("coping", "stone", (10.86, 6.86), (10.44, 6.44), 6.0, 6.14),
        square_ring("cornice", "rib", (8.30, 4.30), (7.72, 3.72), EAVE, EAVE + 0.14),
        prism("door", "wood", door, -6.5, -6.44),
    ]


def fountain():
    step = closed_profile([(1.75, 0.0), (1.75, 0.16), (1.75, 0.16)])
    outside = [(0.0, 0.0), (1.25, 0.0), (1.32, 0.06), (1.22, 0.14), (1.26, 0.30), (1.38, 0.46)]
    rim = [(1.42, 0.52), (1.40, 0.57)]
    inside = [(1.27, 0.58), (1.22, 0.52), (1.18, 0.10), (0.0, 0.08)]
    stem = [(0.0, 0.0), (0.30, 0.0), (0.28, 0.10), (0.14, 0.22), (0.12, 0.45), (0.17, 0.62), (0.12, 0.72)]
    cup = [(0.16, 0.80), (0.46, 0.92), (0.64, 1.06), (0.66, 1.12), (0.60, 1.12), (0.40, 1.00), (0.0, 0.96)]
    return [
        lathe("fountain_step", "stone", step, 40),
        lathe("fountain_basin", "column", outside + rim + inside, 48, (0.0, 0.16, 0.0)),
        lathe("fountain_water", "water", closed_profile([(1.17, 0.50), (1.17, 0.54)]), 40, (0.0, 0.10, 0.0)),
        lathe("fountain_stem", "column", stem + cup, 40, (0.0, 0.60, 0.0)),
        lathe("fountain_cup_water", "water", closed_profile([(0.52, 1.66), (0.56, 1.69)]), 32),
        ball("fountain_ball", "bronze", (0.0, 1.80, 0.0), 0.16, 24, 14),
    ]


def shrub(name, centre, radius):
    """A clipped ball of leaves with gentle bumps."""
    mesh = ball(name, "shrub", centre, radius, 20, 11)

    def bump(p):
        x, y, z = ((a - c) / radius for a, c in zip(p, centre))
        return 1.0 + 0.06 * math.sin(9.0 * x + 2.0) * math.sin(8.0 * y) * math.sin(10.0 * z + 1.0)

    mesh.positions = [tuple(c + (a - c) * bump(p) for a, c in zip(p, centre)) for p in mesh.positions]
    return mesh


def garden():
    parts = []
    signs = ((-1, -1), (1, -1), (1, 1), (-1, 1))
    for k, (x, z) in enumerate(signs, 1):
        low, high = sorted((x * 2.2, x * 7.0)), sorted((z * 0.7, z * 3.0))
        parts.append(box(f"lawn_{k}", "lawn", (low[0], 0.0, high[0]), (low[1], 0.09, high[1])))
    for k, (x, z) in enumerate(signs, 1):
        parts.append(lathe(f"cypress_{k}", "shrub", cypress_profile(3.6), 18, (x * 4.9, 0.09, z * 1.9)))
    places = [(x * 1.55, z * 2.85) for x, z in signs] + [(x * 6.9, z * 1.0) for x, z in signs]
    for k, (x, z) in enumerate(places, 1):
        y = 0.0 if k <= 4 else 0.09
        parts.append(lathe(f"pot_{k}", "pot", urn_profile(0.75), 24, (x, y, z)))
        parts.append(shrub(f"shrub_{k}", (x, y + 0.94, z), 0.30))
    return parts


def belfry():
    """A tower over the corner at the back on the left, its bell room open on four sides."""
    x, z, half = -9.35, -5.35, 1.28
    opening = arch(0.0, 0.62, 7.3, 0.62)
    outline = [(-half, 6.4), (-0.62, 6.4), *opening, (0.62, 6.4), (half, 6.4), (half, 8.4), (-half, 8.4)]
    narrow = [(u * (half - 0.3) / half if abs(u) == half else u, v) for u, v in outline]
    sides = [prism("belfry", "plaster", outline, d, d + 0.3) for d in (-half, half - 0.3)]
    sides += [moved(prism("belfry", "plaster", narrow, d, d + 0.3), turn=QUARTER) for d in (-half, half - 0.3)]
    r, y0, y1 = half + 0.22, 8.4, 9.75
    corners = [(-r, y0, -r), (-r, y0, r), (r, y0, r), (r, y0, -r), (0.0, y1, 0.0)]
    pyramid = [(0, 3, 2), (0, 2, 1), (0, 1, 4), (1, 2, 4), (2, 3, 4), (3, 0, 4)]
    bell = [(0.0, 0.0), (0.36, 0.0), (0.40, 0.03), (0.30, 0.22), (0.24, 0.50), (0.20, 0.66), (0.08, 0.74)]
    bell += [(0.05, 0.95), (0.0, 0.95)]
    return [
        standing_box("tower", "plaster", (x, 4.2, z), (2 * half, 2.2, 2 * half)),
        moved(merged("belfry", "plaster", sides), (x, 0.0, z)),
        moved(Mesh("belfry_roof", "roof", corners, pyramid), (x, 0.0, z)),
        lathe("bell", "bronze", bell, 24, (x, 7.2, z)),
    ]


def scene():
    lamp = Light("lamp", (600, 600, 600), (-3.0, 2.9, -2.0), (3.0, 4.9, 2.0), 96, (0.0, 3.9, 0.0), clearance=0.8)
    cameras = [
        Camera("front", (0.0, 5.5, 3.45), (0.0, 2.0, -2.7), 74.0, (393, 393)),
        Camera("oblique", (7.3, 5.4, 1.7), (-2.0, 1.7, -1.4), 62.0, (393, 393)),
        Camera("right", (10.2, 1.9, 1.7), (0.0, 2.4, -0.5), 70.0, (393, 393)),
    ]
    bounds = ((-10.875, -0.1875, -7.125), (10.875, 10.3125, 7.125))
    parts = walls() + columns() + arcades() + vaults() + [ribs()] + roofs() + fountain() + garden() + belfry()
    return Scene(
        name="cloister",
        title="Cloister, a stand-in for the thesis' model",
        about=ABOUT,
        meshes=parts,
        materials=MATERIALS,
        descriptions={"cloister": Description([lamp], cameras, photons=30000, cells=58, bounds=bounds)},
        expected=(81, 40939, 81410),
    )
