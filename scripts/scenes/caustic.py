# SPDX-License-Identifier: GPL-3.0-or-later
"""A glass ball and a mirror under a small rectangular lamp."""

from scenes.description import Camera, Description, Light, Scene
from scenes.flat_shapes import room, standing_box
from scenes.glb import Material
from scenes.mesh import moved, scaled, subtract
from scenes.round_shapes import icosphere

ABOUT = """
A room of 2 × 2 × 2 m with a glass ball (index of refraction 1.5, smooth normals), a standing mirror, a red block and
a small rectangular lamp under the ceiling: the ball gathers light to a bright spot on the floor, the mirror throws a
patch of light, and both show the room again.
"""

BALL, RADIUS = (-0.40, 0.301, -0.20), 0.30  # a millimetre above the floor


def glass_ball():
    mesh = icosphere("ball", "glass", BALL, RADIUS, 4)
    mesh.normals = [scaled(subtract(p, BALL), 1.0 / RADIUS) for p in mesh.positions]
    return mesh


def mirror():
    """A slab of metal before a wooden back, both on a wooden foot."""
    parts = [
        standing_box("mirror", "mirror", (0.0, 0.06, 0.0), (0.84, 1.30, 0.02)),
        standing_box("mirror_back", "wood", (0.0, 0.06, -0.022), (0.92, 1.36, 0.02)),
        standing_box("mirror_foot", "wood", (0.0, 0.0, -0.02), (0.96, 0.06, 0.30)),
    ]
    return [moved(part, (0.42, 0.0, -0.52), turn=-0.5) for part in parts]


def scene():
    materials = [
        Material("white", (0.73, 0.73, 0.71)),
        Material("orange", (0.65, 0.30, 0.10)),
        Material("blue", (0.14, 0.28, 0.55)),
        Material("red", (0.60, 0.08, 0.06)),
        Material("wood", (0.35, 0.20, 0.10)),
        Material("mirror", (0.92, 0.92, 0.92), kind="mirror"),
        Material("glass", (1.0, 1.0, 1.0), kind="glass", ior=1.5),
    ]
    sides = dict.fromkeys(("floor", "ceiling", "wall_back", "wall_front"), "white")
    shell = room((-1.0, 0.0, -1.0), (1.0, 2.0, 1.0), sides | {"wall_left": "orange", "wall_right": "blue"})
    block = moved(standing_box("block", "red", (0.0, 0.0, 0.0), (0.26, 0.26, 0.26)), (0.42, 0.0, 0.28), turn=0.4)
    lamp = Light(
        name="lamp",
        power=(20, 20, 20),
        domain_min=(-0.3, 1.75, -0.2),
        domain_max=(0.3, 1.95, 0.4),
        samples=100,
        position=(-0.1, 1.9, 0.1),
        size=(0.2, 0.2),
        clearance=0.04,
    )
    camera = Camera("front", (-0.02, 1.0, 0.97), (0.0, 0.66, -0.5), 74.0, (512, 512))
    return Scene(
        name="caustic",
        title="Glass ball and mirror",
        about=ABOUT,
        meshes=shell + [glass_ball(), *mirror(), block],
        materials=materials,
        descriptions={"caustic": Description([lamp], [camera], photons=200000, cells=40)},
        room_closed=True,
    )
