# SPDX-License-Identifier: GPL-3.0-or-later
"""A room of a museum: textures, two point lamps and a rectangular one."""

import math

from scenes import paintings
from scenes.description import Camera, Description, Light, Scene
from scenes.flat_shapes import quad, room, square_ring, standing_box
from scenes.glb import Material
from scenes.mesh import moved
from scenes.round_shapes import lathe, tube

LOW, HIGH = (-4.0, 0.0, -3.0), (4.0, 4.0, 3.0)
PLANK_SIDE = 1.6  # metres that the floor's picture covers

ABOUT = """
A room of 8 × 4 × 6 m with a floor of boards, five framed pictures, a bench, a vase and a knot of stone on a plinth.
Two point lamps and one rectangular lamp, each with a domain of its own: three maps in one file. Floor and pictures
are textures (sRGB, PNG); the one of `picture_spiral` lies inside the geometry file, the others beside it. All are
computed by the script.
"""

# name, function, width, height, centre, turn about y (0: faces +z)
PICTURES = [
    ("blocks", paintings.blocks, 1.6, 1.2, (-2.45, 1.75, -3.0), 0.0),
    ("discs", paintings.discs, 1.2, 1.6, (0.0, 1.85, -3.0), 0.0),
    ("dunes", paintings.dunes, 1.6, 1.2, (2.45, 1.75, -3.0), 0.0),
    ("bands", paintings.bands, 1.8, 1.35, (-4.0, 1.75, 0.0), 0.5 * math.pi),
    ("spiral", paintings.spiral, 1.2, 1.6, (4.0, 1.85, -0.6), -0.5 * math.pi),
]


def floor():
    """The floor again, with coordinates of the boards' picture."""
    (x0, _, z0), (x1, _, z1) = LOW, HIGH
    mesh = quad("floor", "floor", (x0, 0.0, z0), (x0, 0.0, z1), (x1, 0.0, z1), (x1, 0.0, z0))
    mesh.texcoords = [((x - x0) / PLANK_SIDE, (z - z0) / PLANK_SIDE) for x, _, z in mesh.positions]
    return mesh


def picture(name, width, height, centre, turn):
    """A canvas, its front coloured by the texture, 5 mm before the wall, and the frame around it."""
    canvas = standing_box(f"picture_{name}", f"picture_{name}", (0.0, -height / 2, 0.0175), (width, height, 0.025))
    canvas.texcoords = [(0.5 + x / width, 0.5 - y / height) for x, y, _ in canvas.positions]
    half = (width / 2 + 0.06, height / 2 + 0.06)
    frame = square_ring(f"frame_{name}", "frame", half, (half[0] - 0.06, half[1] - 0.06), 0.002, 0.05)
    frame.positions = [(x, -z, y) for x, y, z in frame.positions]
    return [moved(canvas, centre, turn), moved(frame, centre, turn)]


def bench(x, z):
    parts = [standing_box("bench_seat", "leather", (x, 0.38, z), (1.8, 0.10, 0.55))]
    for name, dx in (("left", -0.7), ("right", 0.7)):
        parts.append(standing_box(f"bench_{name}", "frame", (x + dx, 0.0, z), (0.10, 0.38, 0.45)))
    return parts


def knot(centre, size, steps=160):
    """A trefoil knot on a torus."""
    path, cores = [], []
    for k in range(steps):
        t = 2.0 * math.pi * k / steps
        around, up = (1.0 + 0.42 * math.cos(3.0 * t)), 0.42 * math.sin(3.0 * t)
        x, y = math.cos(2.0 * t), math.sin(2.0 * t)
        path.append((centre[0] + size * around * x, centre[1] + size * around * y, centre[2] + size * up))
        cores.append((centre[0] + size * x, centre[1] + size * y, centre[2]))
    return tube("knot", "stone", path, cores, 0.22 * size, 16)


def vase(x, z):
    outside = [(0.0, 0.0), (0.16, 0.0), (0.17, 0.03), (0.13, 0.08), (0.20, 0.28), (0.27, 0.55), (0.25, 0.76)]
    neck = [(0.13, 0.94)]
    lip = [(0.10, 1.02), (0.12, 1.10), (0.17, 1.16), (0.15, 1.16), (0.09, 1.08), (0.08, 1.00), (0.0, 0.96)]
    return lathe("vase", "vase", outside + neck + lip, 32, (x, 0.0, z))


def furniture():
    parts = bench(-1.2, 0.9)
    parts += [
        standing_box("plinth", "plinth", (1.5, 0.0, -0.5), (0.7, 1.0, 0.7)),
        knot((1.5, 1.54, -0.5), 0.30),
        vase(-3.4, -2.4),
    ]
    return parts


def scene():
    materials = [
        Material("wall", (0.72, 0.69, 0.62)),
        Material("ceiling", (0.78, 0.78, 0.76)),
        Material("frame", (0.28, 0.17, 0.08)),
        Material("leather", (0.34, 0.10, 0.07)),
        Material("plinth", (0.74, 0.72, 0.68)),
        Material("stone", (0.62, 0.64, 0.66)),
        Material("vase", (0.10, 0.26, 0.42)),
        Material("floor", (1.0, 1.0, 1.0), texture="floor.png"),
    ]
    textures = {"floor.png": paintings.planks()}
    sides = dict.fromkeys(("wall_left", "wall_right", "wall_back", "wall_front"), "wall") | {"ceiling": "ceiling"}
    meshes = [floor(), *room(LOW, HIGH, sides, open_sides=("floor",))]
    for name, paint, width, height, centre, turn in PICTURES:
        embedded = paint() if name == "spiral" else None
        materials.append(Material(f"picture_{name}", (1.0, 1.0, 1.0), texture=f"{name}.png", embedded=embedded))
        if not embedded:
            textures[f"{name}.png"] = paint()
        meshes += picture(name, width, height, centre, turn)
    lamps = [
        Light("left_lamp", (60, 54, 44), (-3.2, 2.4, -1.6), (-1.2, 3.4, 1.6), 120, (-2.2, 3.0, -0.6), clearance=0.4),
        Light("right_lamp", (60, 54, 44), (1.2, 2.6, -1.6), (3.2, 3.4, 1.6), 120, (2.4, 3.0, 0.4), clearance=0.4),
        Light(
            name="skylight",
            power=(90, 100, 115),
            domain_min=(-0.6, 3.2, -0.6),
            domain_max=(0.6, 3.5, 0.6),
            samples=80,
            position=(0.0, 3.4, 0.0),
            size=(1.6, 0.8),
            clearance=0.4,
        ),
    ]
    cameras = [
        Camera("entrance", (2.9, 1.65, 2.75), (-0.55, 1.45, -2.0), 62.0, (640, 480)),
        Camera("bench", (-3.3, 1.5, 2.4), (1.6, 1.45, -1.6), 58.0, (640, 480)),
    ]
    return Scene(
        name="gallery",
        title="A gallery with three lamps and textures",
        about=ABOUT,
        meshes=meshes + furniture(),
        materials=materials,
        descriptions={"gallery": Description(lamps, cameras, photons=100000, cell_size=0.125)},
        textures=textures,
        room_closed=True,
    )
