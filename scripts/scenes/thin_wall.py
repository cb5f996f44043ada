# SPDX-License-Identifier: GPL-3.0-or-later
"""Two rooms parted by a wall much thinner than a cell; the lamp stays in one of them."""

from scenes.description import Camera, Description, Light, Scene
from scenes.flat_shapes import box, room
from scenes.glb import Material

ABOUT = """
Two rooms of 3 × 2.5 × 3 m side by side, parted by a wall of 2 cm in a grid of 12.5 cm cells: both faces of the wall
lie in the same layer of cells, well inside it. The lamp roams in the left room only (x < 3), and no light can reach
the right one: whatever irradiance is seen there has leaked through the cells. Floor, ceiling and long walls are
single quads that run through under both rooms.
"""


def scene():
    materials = [
        Material("plaster", (0.7, 0.7, 0.7)),
        Material("floor", (0.5, 0.42, 0.33)),
        Material("wall", (0.7, 0.6, 0.45)),
    ]
    sides = dict.fromkeys(("ceiling", "wall_left", "wall_right", "wall_back", "wall_front"), "plaster")
    shell = room((0.0, 0.0, 0.0), (6.02, 2.5, 3.0), sides | {"floor": "floor"})
    wall = box("thin_wall", "wall", (3.0, 0.0, 0.0), (3.02, 2.5, 3.0))
    lamp = Light("lamp", (40, 40, 40), (0.6, 0.9, 0.6), (2.4, 2.1, 2.4), 100, (1.5, 1.8, 1.5), clearance=0.35)
    cameras = [
        Camera("bright_room", (0.25, 1.6, 2.75), (2.6, 1.0, 0.6), 65.0, (256, 256)),
        Camera("dark_room", (5.77, 1.6, 2.75), (3.42, 1.0, 0.6), 65.0, (256, 256)),
    ]
    # half a cell of margin: neither floor, walls nor the thin wall lie on a border between cells
    bounds = ((-0.0625, -0.0625, -0.0625), (6.0825, 2.5625, 3.0625))
    return Scene(
        name="thin_wall",
        title="Two rooms parted by a thin wall",
        about=ABOUT,
        meshes=shell + [wall],
        materials=materials,
        descriptions={"thin_wall": Description([lamp], cameras, photons=100000, cell_size=0.125, bounds=bounds)},
        room_closed=True,
    )
