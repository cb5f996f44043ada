# SPDX-License-Identifier: GPL-3.0-or-later
"""What a scene is made of, and how its folder is written: geometry, description(s) and README."""

import math
from dataclasses import dataclass, field

from scenes.glb import write_glb


@dataclass
class Light:
    """Moves in the box domain_min..domain_max; `clearance` (metres) is what the self-check demands around it."""

    name: str
    power: tuple
    domain_min: tuple
    domain_max: tuple
    samples: int
    position: tuple
    size: tuple | None = None  # of a rectangle
    normal: tuple = (0, -1, 0)  # of a rectangle
    boxes: tuple | None = None
    clearance: float = 0.1


@dataclass
class Camera:
    name: str
    eye: tuple
    target: tuple
    vertical_fov: float
    size: tuple


@dataclass
class Description:
    """One TOML file. Of cells and cell_size one is None; bounds None: the geometry's box."""

    lights: list
    cameras: list
    photons: int
    cells: int | None = None
    cell_size: float | None = None
    bounds: tuple | None = None
    note: str = ""


@dataclass
class Scene:
    """A folder of data/. `descriptions` maps a file name without ending to its description."""

    name: str
    title: str
    about: str  # paragraphs of the README
    meshes: list
    materials: list
    descriptions: dict
    textures: dict = field(default_factory=dict)  # file name -> PNG bytes
    room_closed: bool = False  # all meshes of kind "room" together are watertight
    expected: tuple | None = None  # objects, vertices, triangles; each +- 5 %


def number(value):
    return repr(round(float(value), 6)) if isinstance(value, float) else str(value)


def array(values):
    return "[" + ", ".join(number(v) for v in values) + "]"


def box_text(low, high):
    return f"{{ min = {array(low)}, max = {array(high)} }}"


def geometry_box(meshes):
    points = [p for mesh in meshes for p in mesh.positions]
    return tuple(tuple(pick(p[axis] for p in points) for axis in range(3)) for pick in (min, max))


def grid_counts(description, meshes):
    """Cells along each axis and the cell's size: the rule of the scene description."""
    low, high = description.bounds or geometry_box(meshes)
    extent = [b - a for a, b in zip(low, high)]
    size = description.cell_size or max(extent) / description.cells
    return [max(1, math.ceil(e / size)) for e in extent], size


def light_text(light):
    lines = ["[[light]]", f'name = "{light.name}"', f'type = "{"rectangle" if light.size else "point"}"']
    if light.size:
        lines += [f"size = {array(light.size)}", f"normal = {array(light.normal)}"]
    lines += [f"power = {array(light.power)}", f"domain = {box_text(light.domain_min, light.domain_max)}"]
    if light.boxes:
        lines.append(f"boxes = {array(light.boxes)}")
    return lines + [f"samples = {light.samples}", f"position = {array(light.position)}", ""]


def camera_text(camera):
    first = f"eye = {array(camera.eye)}\ntarget = {array(camera.target)}\nup = [0, 1, 0]"
    rest = f"vertical_fov = {number(camera.vertical_fov)}\nsize = {array(camera.size)}"
    return ["[[camera]]", f'name = "{camera.name}"', first, rest, ""]


def description_text(scene, description):
    """The TOML file's text."""
    lines = ["# SPDX-License-Identifier: GPL-3.0-or-later", f"# {scene.title}"]
    lines += [f"# {line}" for line in description.note.splitlines()]
    lines += ["", "[scene]", f'geometry = "{scene.name}.glb"', "metres_per_unit = 1.0", "", "[grid]"]
    if description.cells:
        lines.append(f"cells = {description.cells}")
    else:
        lines.append(f"cell_size = {number(description.cell_size)}")
    if description.bounds:
        lines.append(f"bounds = {box_text(*description.bounds)}")
    lines += ["", "[bake]", f"photons = {description.photons}", "degree = 3", "seed = 1", ""]
    for light in description.lights:
        lines += light_text(light)
    for camera in description.cameras:
        lines += camera_text(camera)
    return "\n".join(lines)


def counts(scene):
    """Objects, their vertices (a place counts once, however many normals meet there), triangles."""
    vertices = sum(len({tuple(p) for p in mesh.positions}) for mesh in scene.meshes)
    return len(scene.meshes), vertices, sum(len(mesh.triangles) for mesh in scene.meshes)


def readme_text(scene):
    objects, vertices, triangles = counts(scene)
    lines = [f"# {scene.title}", "", scene.about.strip(), ""]
    lines += ["| | |", "|---|---|", f"| objects | {objects} |", f"| vertices | {vertices:,} |"]
    lines += [f"| triangles | {triangles:,} |", "| units | metres, y up |"]
    for name, description in scene.descriptions.items():
        (nx, ny, nz), size = grid_counts(description, scene.meshes)
        cells = f"{nx} × {ny} × {nz} = {nx * ny * nz:,} cells of {size:.4g} m"
        lines.append(f"| grid of `{name}.toml` | {cells}, empty ones included |")
    lines += ["", "Lamps, and where they may stand:", "", "| description | lamp | kind | domain (m) | start |"]
    lines.append("|---|---|---|---|---|")
    for name, description in scene.descriptions.items():
        for light in description.lights:
            kind = f"rectangle {light.size[0]} × {light.size[1]} m" if light.size else "point"
            axes = zip("xyz", light.domain_min, light.domain_max)
            domain = ", ".join(f"{axis} {number(a)} … {number(b)}" for axis, a, b in axes)
            lines.append(f"| `{name}.toml` | `{light.name}` | {kind} | {domain} | {array(light.position)} |")
    lines += ["", "Made by `scripts/make_scenes.py`; our own work, GPL-3.0-or-later.", ""]
    return "\n".join(lines)


def write_scene(scene, folder):
    """Writes the scene's whole folder; the same bytes each time."""
    folder.mkdir(parents=True, exist_ok=True)
    for name, content in scene.textures.items():
        (folder / name).write_bytes(content)
    write_glb(folder / f"{scene.name}.glb", scene.meshes, scene.materials)
    for name, description in scene.descriptions.items():
        (folder / f"{name}.toml").write_text(description_text(scene, description), encoding="utf-8")
    (folder / "README.md").write_text(readme_text(scene), encoding="utf-8")
