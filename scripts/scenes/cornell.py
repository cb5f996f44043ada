# SPDX-License-Identifier: GPL-3.0-or-later
"""The measured Cornell box, a hundredth of a metre to the millimetre, with a point lamp that roams its upper middle."""

from scenes.description import Camera, Description, Light, Scene
from scenes.flat_shapes import hexahedron, room
from scenes.glb import Material

WIDTH, HEIGHT, DEPTH = 5.528, 5.488, 5.592

# upper corners as measured, metres: in the order of a walk around the block
SHORT_BLOCK = [(1.30, 0.65), (0.82, 2.25), (2.40, 2.72), (2.90, 1.14)]
TALL_BLOCK = [(4.23, 2.47), (2.65, 2.96), (3.14, 4.56), (4.72, 4.06)]

ABOUT = """
The box of global illumination: white floor, ceiling and back wall, a red wall on the left, a green one on the right,
a short and a tall white block, the front open. A point lamp moves in the middle of its upper part, above the tall
block.

The numbers are the measured ones of the Cornell University Program of Computer Graphics ("The Cornell Box: data"),
which are facts; the model file is ours. One millimetre of the original is a hundredth of a metre here, so that the
box has the size of a room, 5.528 × 5.488 × 5.592 m. The slight slants of the measured walls (549.6 to 556.0 mm apart)
are snapped to a right box; there is no opening in the ceiling, because the lamp moves freely; the colours are the
customary RGB stand-ins for the measured spectra. The blocks are closed solids that stand on the floor.
"""


def block(name, corners, height):
    """Closed solid over four (x, z) corners."""
    lower, upper = ([(x, y, z) for x, z in corners] for y in (0.0, height))
    (a, b, c, d), (e, f, g, h) = lower, upper
    return hexahedron(name, "white", [a, d, h, e, b, c, g, f])


def scene():
    materials = [
        Material("white", (0.725, 0.71, 0.68)),
        Material("red", (0.63, 0.065, 0.05)),
        Material("green", (0.14, 0.45, 0.091)),
    ]
    # seen from the camera, which looks along +z, the wall at x = 0 is on the right
    sides = dict.fromkeys(("floor", "ceiling", "wall_front"), "white")
    sides |= {"wall_left": "green", "wall_right": "red"}
    shell = room((0.0, 0.0, 0.0), (WIDTH, HEIGHT, DEPTH), sides, open_sides=("wall_back",))
    seen_from_camera = {"wall_left": "wall_green", "wall_right": "wall_red", "wall_front": "wall_back"}
    for side in shell:
        side.name = seen_from_camera.get(side.name, side.name)
    lamp = Light(
        name="lamp",
        power=(100, 100, 100),
        domain_min=(0.15 * WIDTH, 0.65 * HEIGHT, 0.15 * DEPTH),
        domain_max=(0.85 * WIDTH, 0.90 * HEIGHT, 0.85 * DEPTH),
        samples=300,
        boxes=(2, 1, 2),
        position=(2.764, 4.6, 2.796),
        clearance=0.25,
    )
    camera = Camera("front", (2.78, 2.73, -8.0), (2.78, 2.73, 2.8), 39.3077, (512, 512))
    return Scene(
        name="cornell",
        title="Cornell box, the lamp free in its upper middle",
        about=ABOUT,
        meshes=shell + [block("short_block", SHORT_BLOCK, 1.65), block("tall_block", TALL_BLOCK, 3.30)],
        materials=materials,
        descriptions={"cornell": Description([lamp], [camera], photons=200000, cells=48)},
    )
