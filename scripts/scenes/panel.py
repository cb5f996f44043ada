# SPDX-License-Identifier: GPL-3.0-or-later
"""A room where a bake by cells goes wrong first: a board before its wall, a table, a floor on a border."""

from scenes.description import Camera, Description, Light, Scene
from scenes.flat_shapes import box, room, standing_box
from scenes.glb import Material

ABOUT = """
A room of 4 × 2.8 × 5 m. A board of 2 × 1 m, 2 cm thick, hangs with its back 1 cm before the back wall: board and wall
share their cells, and no light gets behind the board. A table and closed boxes stand on the floor: their undersides
and the floor below them share cells with lit surfaces. The floor is a slab of 0.2 m; with cells of 0.1 m its top, y =
0, lies exactly on a border between cells.
"""


def table(x, z):
    """A table top on four legs, standing on the floor around (x, z)."""
    parts = [standing_box("table_top", "wood", (x, 0.70, z), (1.4, 0.04, 0.8))]
    for k, (dx, dz) in enumerate(((-0.63, -0.33), (0.63, -0.33), (0.63, 0.33), (-0.63, 0.33)), 1):
        parts.append(standing_box(f"table_leg_{k}", "wood", (x + dx, 0.0, z + dz), (0.06, 0.70, 0.06)))
    return parts


def scene():
    materials = [
        Material("plaster", (0.72, 0.70, 0.66)),
        Material("floor", (0.45, 0.38, 0.30)),
        Material("board", (0.16, 0.38, 0.30)),
        Material("wood", (0.55, 0.36, 0.20)),
        Material("crate", (0.60, 0.48, 0.20)),
        Material("red", (0.60, 0.14, 0.10)),
        Material("blue", (0.14, 0.24, 0.55)),
    ]
    walls = dict.fromkeys(("ceiling", "wall_left", "wall_right", "wall_back", "wall_front"), "plaster")
    shell = room((0.0, 0.0, 0.0), (4.0, 2.8, 5.0), walls, open_sides=("floor",))
    solids = [
        box("floor", "floor", (0.0, -0.2, 0.0), (4.0, 0.0, 5.0)),
        box("board", "board", (1.0, 1.0, 0.01), (3.0, 2.0, 0.03)),
        standing_box("crate_large", "crate", (0.55, 0.0, 0.75), (0.7, 0.7, 0.7)),
        standing_box("crate_small", "red", (0.55, 0.70, 0.70), (0.4, 0.35, 0.4)),
        standing_box("chest", "blue", (3.45, 0.0, 1.6), (0.6, 0.45, 1.1)),
    ]
    lamp = Light("lamp", (60, 60, 60), (1.0, 2.1, 1.25), (3.0, 2.6, 3.75), 240, (2.0, 2.4, 2.5), boxes=(2, 1, 2), clearance=0.15)
    camera = Camera("corner", (0.5, 1.75, 4.7), (2.25, 0.85, 0.9), 58.0, (512, 512))
    bounds = ((0.0, -0.2, 0.0), (4.0, 2.8, 5.0))
    return Scene(
        name="panel",
        title="A room with a board, a table and closed boxes",
        about=ABOUT,
        meshes=shell + solids + table(2.2, 2.2),
        materials=materials,
        descriptions={"panel": Description([lamp], [camera], photons=100000, cell_size=0.1, bounds=bounds)},
    )
