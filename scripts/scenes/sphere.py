# SPDX-License-Identifier: GPL-3.0-or-later
"""The inside of a diffuse sphere, whose indirect light is known in closed form."""

from scenes.description import Camera, Description, Light, Scene
from scenes.glb import Material
from scenes.round_shapes import icosphere

ABOUT = """
The inside of a grey diffuse sphere of radius 1 m (an icosphere of five subdivisions, faces inwards, flat). Whatever
the lamp's place, the indirect irradiance of a true sphere is the same everywhere: ρΦ / ((1 − ρ) 4πR²), which with
albedo ρ = 0.5 is Φ / (4π). So every coefficient of the cubic but the constant must vanish, within the noise of the
photons. The vertices lie on the sphere, so the polyhedron's area is a trifle (0.03 %) smaller than 4πR².
"""


def scene():
    lamp = Light("lamp", (100, 100, 100), (-0.4, -0.4, -0.4), (0.4, 0.4, 0.4), 100, (0.2, 0.1, -0.1), clearance=0.25)
    camera = Camera("inside", (0.0, 0.0, 0.9), (0.0, 0.0, 0.0), 70.0, (256, 256))
    return Scene(
        name="sphere",
        title="Inside of a diffuse sphere",
        about=ABOUT,
        meshes=[icosphere("sphere", "grey", (0.0, 0.0, 0.0), 1.0, 5, inwards=True)],
        materials=[Material("grey", (0.5, 0.5, 0.5))],
        descriptions={"sphere": Description([lamp], [camera], photons=100000, cells=16)},
        room_closed=True,
    )
