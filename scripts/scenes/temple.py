# SPDX-License-Identifier: GPL-3.0-or-later
"""A temple in a colonnade open to the sky; the lamp moves in the court, above the altar."""

import math

from scenes.description import Camera, Description, Light, Scene
from scenes.flat_shapes import box, prism, square_ring, standing_box
from scenes.glb import Material
from scenes.mesh import moved
from scenes.round_shapes import ball, lathe
from scenes.ornaments import (
    bowl_profile, closed_profile, cypress_profile, flattened, scaled_profile, statue_profile, tiled_slope,
    urn_profile,
)  # fmt: skip

COURT = 0.9  # height of the court's floor
SPACING = 2.64  # between the columns of the colonnade
CELLA = 1.35  # height of the temple's own floor

ABOUT = """
A square colonnade on three steps, open to the sky, its front half in ruins, and in its rear half a small temple: four
columns before a cella with a cult statue, a painted frieze, a gabled roof of terracotta. In the court an altar on a
mosaic, statues, bronze braziers and urns; cypresses at the corners. The lamp moves in the air above the altar.

**A stand-in.** The model is ours, with the counts of objects, vertices and triangles (97, 9,674, 19,230; each within
5 %), the grid (44,100 cells), photons (40,000) and lamp positions (182) that C.-H. Lin's thesis (2005) states for its
temple; it is not the thesis' model. The cameras are named after the thesis' figures; where they stand is our choice.

Lamp positions of the thesis' figures 28–30 (our stand-ins):

| figure | camera | first | second | third |
|---|---|---|---|---|
| 28 | `front_above` | [-2.2, 3.6, 4.8] | [0, 4.4, 3] | [2.2, 5.4, 1] |
| 29 | `side` | [0, 3.4, 5.2] | [0.6, 4.2, 2.9] | [1.5, 5.5, 0.7] |
| 30 | `oblique` | [-2.2, 3.5, 1] | [0, 4.4, 3] | [2.2, 5.2, 4.8] |

`temple_four_lamps.toml` is the same model with four lamps of different colours, each in a small domain of its own.
"""

MATERIALS = [
    Material("sand", (0.50, 0.40, 0.27)),
    Material("limestone", (0.68, 0.60, 0.47)),
    Material("marble", (0.74, 0.68, 0.58)),
    Material("mosaic_blue", (0.10, 0.24, 0.42)),
    Material("mosaic_red", (0.48, 0.14, 0.09)),
    Material("frieze", (0.56, 0.12, 0.08)),
    Material("gable", (0.12, 0.26, 0.46)),
    Material("terracotta", (0.60, 0.24, 0.12)),
    Material("bronze", (0.42, 0.28, 0.12)),
    Material("statue", (0.76, 0.70, 0.60)),
    Material("gold", (0.70, 0.48, 0.14)),
    Material("cypress", (0.09, 0.20, 0.07)),
]


def ground():
    parts = [box("ground", "sand", (-10.3, -0.2, -10.3), (10.3, 0.0, 10.3))]
    for k, half in enumerate((8.75, 8.30, 7.85)):
        low, high = (-half, 0.3 * k, -half), (half, 0.3 * (k + 1), half)
        parts.append(box(f"step_{k + 1}", "limestone", low, high))
    return parts


def column_profile(height):
    """Base, shaft and echinus in one."""
    base = [(0.46, 0.0), (0.50, 0.07), (0.46, 0.14), (0.385, 0.17), (0.365, 0.28)]
    shaft = [(0.355, 0.38 * height), (0.335, 0.68 * height), (0.30, height - 0.42)]
    neck = [(0.335, height - 0.37), (0.305, height - 0.31), (0.33, height - 0.20)]
    echinus = [(0.445, height - 0.07), (0.46, height)]
    return closed_profile(base + shaft + neck + echinus)


def column(name, x, floor, z, height):
    """A column and the square slab on it, `height` metres together."""
    shaft = lathe(f"column_{name}", "limestone", column_profile(height - 0.2), 16, (x, floor, z))
    return [shaft, standing_box(f"abacus_{name}", "limestone", (x, floor + height - 0.2, z), (1.04, 0.2, 1.04))]


def broken_column(name, x, floor, z, height, slant):
    """The lower part of a column, broken off aslant."""
    profile = [(r, y) for r, y in column_profile(4.2)[1:6]]
    profile += [(0.355, 0.6 * height), (0.35, height), (0.35, height)]
    mesh = lathe(f"column_{name}", "limestone", closed_profile(profile), 16)
    mesh.positions = [(a, y + (slant * a if y == height else 0.0), b) for a, y, b in mesh.positions]
    return moved(mesh, (x, floor, z))


def drum(name, x, z, length, turn):
    """A piece of a column's shaft that lies on the court."""
    radius = 0.35
    mesh = lathe(name, "limestone", closed_profile([(radius, 0.0)] * 2 + [(radius, length)] * 2), 16)
    mesh.positions = [(y - length / 2, radius + b, a) for a, y, b in mesh.positions]
    mesh.normals = [(y, b, a) for a, y, b in mesh.normals]
    return moved(mesh, (x, COURT, z), turn)


def plan_prism(name, material, plan, y0, y1):
    """Solid over a polygon in plan, points (x, z) clockwise seen from above."""
    mesh = prism(name, material, [(x, -z) for x, z in reversed(plan)], y0, y1)
    mesh.positions = [(x, y, -minus_z) for x, minus_z, y in mesh.positions]
    return mesh


def colonnade():
    """Sixteen columns that stand, four that are broken, and the entablature that is left: left side, rear, half the
    right side. The front is open, so that one looks into the court."""
    broken = {(2, 5): (1.5, 0.5), (3, 5): (1.2, -0.6), (5, 4): (1.9, 0.7), (5, 5): (2.9, -0.6)}
    places = [(a, b) for b in range(6) for a in range(6) if a in (0, 5) or b in (0, 5)]
    parts = []
    for k, (a, b) in enumerate(places, 1):
        x, z = (a - 2.5) * SPACING, (b - 2.5) * SPACING
        if (a, b) in broken:
            parts.append(broken_column(f"{k:02}", x, COURT, z, *broken[a, b]))
        else:
            parts += column(f"{k:02}", x, COURT, z, 4.4)
    line, end = 2.5 * SPACING, -0.5 * SPACING
    for name, material, half, y0, y1 in (
        ("architrave", "limestone", 0.42, 5.30, 5.85), ("frieze", "frieze", 0.36, 5.85, 6.25),
        ("cornice", "marble", 0.56, 6.25, 6.45),
    ):  # fmt: skip
        outer, inner, right = line + half, line - half, end + half + 0.3
        plan = [(-outer, outer), (-outer, -outer), (outer, -outer), (outer, right), (inner, right)]
        plan += [(inner, -inner), (-inner, -inner), (-inner, outer)]
        parts.append(plan_prism(f"colonnade_{name}", material, plan, y0, y1))
    return parts


def ruins():
    """What fell from the colonnade."""
    fallen = standing_box("fallen_abacus", "limestone", (0.0, 0.0, 0.0), (1.04, 0.2, 1.04))
    beam = standing_box("fallen_architrave", "limestone", (0.0, 0.0, 0.0), (0.8, 0.55, 1.35))
    return [
        drum("drum_1", 5.9, 2.6, 1.3, 0.5),
        drum("drum_2", 3.3, 6.2, 0.8, -0.9),
        moved(fallen, (6.9, COURT, 5.3), 0.4),
        moved(beam, (6.75, COURT, 0.0), 0.2),
    ]


def cella_front(z0, z1):
    """The wall with the door."""
    door = [(-0.85, CELLA), (-0.85, 4.6), (0.85, 4.6), (0.85, CELLA)]
    return prism("cella_front", "marble", [(-3.9, CELLA), *door, (3.9, CELLA), (3.9, 6.35), (-3.9, 6.35)], z0, z1)


def temple_house():
    """Podium, portico, cella, entablature, gables and roof; its middle lies at z = -3."""
    parts = [box("podium", "marble", (-4.5, COURT, -5.9), (4.5, CELLA, -0.2))]
    for k, x in enumerate((-3.6, -1.2, 1.2, 3.6), 21):
        parts += column(str(k), x, CELLA, -0.85, 5.0)
    parts += [
        cella_front(-2.75, -2.4),
        box("cella_left", "marble", (-3.9, CELLA, -5.2), (-3.55, 6.35, -2.75)),
        box("cella_right", "marble", (3.55, CELLA, -5.2), (3.9, 6.35, -2.75)),
        box("cella_back", "marble", (-3.9, CELLA, -5.55), (3.9, 6.35, -5.2)),
        standing_box("cella_ceiling", "limestone", (0.0, 6.6, -3.15), (7.4, 0.25, 4.2)),
    ]
    for name, material, half, y0, y1 in (
        ("architrave", "limestone", 4.05, 6.35, 6.85), ("frieze", "frieze", 3.98, 6.85, 7.30),
        ("cornice", "marble", 4.3, 7.30, 7.48),
    ):  # fmt: skip
        ring = square_ring(f"temple_{name}", material, (half, half - 1.25), (3.30, 2.05), y0, y1)
        parts.append(moved(ring, (0.0, 0.0, -3.15)))
    return parts + roof()


def roof():
    gable = prism("gable_front", "gable", [(-4.25, 7.48), (4.25, 7.48), (0.0, 9.15)], -0.62, -0.32)
    # the slopes lie on the gables: 0.1 m of tile above the line from (4.25, 7.48) to (0, 9.15)
    slope = tiled_slope("roof_right", "terracotta", (4.62, 7.44), (0.0, 9.26), (-6.35, 0.05), 15, 3, points=3)
    ridge = lathe("ridge", "terracotta", [(0.0, 0.0), (0.13, 0.0), (0.13, 6.4), (0.0, 6.4)], 8)
    ridge.positions = [(x, 9.30 + z, y - 6.35) for x, y, z in ridge.positions]
    ridge.normals = [(x, z, y) for x, y, z in ridge.normals]
    ridge.triangles = [(a, c, b) for a, b, c in ridge.triangles]
    parts = [gable, moved(gable, (0.0, 0.0, -5.36), name="gable_back"), slope]
    parts += [moved(slope, (0.0, 0.0, -6.3), turn=math.pi, name="roof_left"), ridge]
    for name, x, y in (("left", -4.45, 7.62), ("middle", 0.0, 9.38), ("right", 4.45, 7.62)):
        parts.append(lathe(f"acroterion_{name}", "gold", urn_profile(0.75), 10, (x, y, -0.35)))
    return parts


def altar():
    x, z = 0.0, 2.9
    return [
        lathe("mosaic_outer", "mosaic_blue", closed_profile([(2.3, 0.0), (2.3, 0.02)]), 28, (x, COURT, z)),
        lathe("mosaic_inner", "mosaic_red", closed_profile([(1.7, 0.0), (1.7, 0.02)]), 28, (x, COURT + 0.02, z)),
        standing_box("altar_foot", "marble", (x, COURT + 0.04, z), (1.7, 0.16, 1.2)),
        standing_box("altar_block", "limestone", (x, COURT + 0.20, z), (1.3, 0.62, 0.85)),
        standing_box("altar_slab", "marble", (x, COURT + 0.82, z), (1.55, 0.12, 1.05)),
        lathe("altar_bowl", "bronze", bowl_profile(0.36, 0.34), 18, (x, COURT + 0.94, z)),
    ]


def figures():
    """Statues, braziers, urns, balls and trees."""
    parts = []
    for k, (x, z) in enumerate(((-4.7, 1.0), (4.7, 1.0), (-4.7, 4.5), (4.7, 4.5)), 1):
        parts.append(standing_box(f"pedestal_{k}", "marble", (x, COURT, z), (0.85, 0.9, 0.85)))
        figure = flattened(lathe(f"statue_{k}", "statue", statue_profile(), 15), 0.75)
        parts.append(moved(figure, (x, COURT + 0.9, z), turn=0.5 * math.pi))
    idol = lathe("cult_statue", "gold", scaled_profile(statue_profile(), 1.35), 15)
    parts.append(moved(flattened(idol, 0.75), (0.0, CELLA, -4.5)))
    for k, x in enumerate((-2.6, 2.6), 1):
        parts.append(lathe(f"brazier_{k}", "bronze", bowl_profile(0.42, 1.15), 18, (x, COURT, 0.7)))
        parts.append(lathe(f"urn_{k}", "terracotta", urn_profile(1.25), 18, (x, COURT, 5.3)))
        parts.append(ball(f"ball_{k}", "marble", (0.52 * x, 0.36, 9.4), 0.36, 16, 9))
    for k, (x, z) in enumerate(((-9.5, -9.5), (9.5, -9.5), (-9.5, 9.5), (9.5, 9.5)), 1):
        parts.append(lathe(f"cypress_{k}", "cypress", cypress_profile(5.2), 12, (x, 0.0, z)))
    return parts


def one_lamp():
    return [Light("lamp", (700, 700, 700), (-2.5, 3.2, 0.4), (2.5, 5.7, 5.4), 182, (0.0, 4.4, 3.0), clearance=0.8)]


def four_lamps():
    return [
        Light("court", (420, 380, 300), (-1.5, 3.4, 2.0), (1.5, 5.0, 4.4), 60, (0.0, 4.2, 3.2), clearance=0.8),
        Light("cella", (320, 130, 40), (-0.8, 4.3, -3.8), (0.8, 5.2, -3.4), 60, (0.0, 4.7, -3.6), clearance=0.6),
        Light("left_aisle", (40, 90, 300), (-5.3, 2.0, -4.0), (-4.9, 4.0, -1.2), 60, (-5.1, 3.0, -2.4), clearance=0.6),
        Light("right_aisle", (60, 260, 90), (4.9, 2.0, -4.0), (5.3, 4.0, -1.2), 60, (5.1, 3.0, -2.4), clearance=0.6),
    ]


def scene():
    cameras = [
        Camera("front_above", (0.0, 12.5, 19.5), (0.0, 3.2, 0.6), 46.0, (393, 393)),
        Camera("side", (18.5, 9.5, 4.5), (0.0, 3.0, 0.3), 45.0, (393, 393)),
        Camera("oblique", (10.2, 10.0, 17.0), (-0.1, 3.1, 0.4), 44.0, (393, 393)),
    ]
    bounds = ((-10.5, -0.25, -10.5), (10.5, 12.25, 10.5))
    descriptions = {}
    for name, lights in (("temple", one_lamp()), ("temple_four_lamps", four_lamps())):
        descriptions[name] = Description(lights, cameras, photons=40000, cells=42, bounds=bounds)
    return Scene(
        name="temple",
        title="Temple, a stand-in for the thesis' model",
        about=ABOUT,
        meshes=ground() + colonnade() + ruins() + temple_house() + altar() + figures(),
        materials=MATERIALS,
        descriptions=descriptions,
        expected=(97, 9674, 19230),
    )
