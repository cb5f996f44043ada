# SPDX-License-Identifier: GPL-3.0-or-later
"""The self-check of a scene: what a baker may rely on."""

import math
import struct
from collections import Counter

from scenes.description import counts, geometry_box
from scenes.glb import DECIMALS, read_glb
from scenes.mesh import add, cross, dot, scaled, subtract

LAMP_STEPS = 5  # sampled positions along each axis of a lamp's domain


def problems(scene, folder):
    """Sentences about what is wrong; empty if nothing is."""
    found = count_problems(scene) + file_problems(scene, folder)
    for mesh in scene.meshes:
        found += mesh_problems(mesh)
    rooms = [mesh for mesh in scene.meshes if mesh.kind == "room"]
    if scene.room_closed and open_edges(rooms):
        found.append(f"the room has {open_edges(rooms)} open edges")
    found += duplicate_problems(scene.meshes)
    for name, description in scene.descriptions.items():
        found += bounds_problems(name, scene, description)
        for light in description.lights:
            found += lamp_problems(name, scene, light)
    return found


def count_problems(scene):
    if not scene.expected:
        return []
    rows = zip(("objects", "vertices", "triangles"), counts(scene), scene.expected)
    return [f"{n} {what}, not {m} +- 5 %" for what, n, m in rows if abs(n - m) > 0.05 * m]


def file_problems(scene, folder):
    """The file written holds the same meshes."""
    path = folder / f"{scene.name}.glb"
    if not path.exists():
        return [f"{path.name} is missing"]
    gltf, data = read_glb(path)
    if [node["name"] for node in gltf["nodes"]] != [mesh.name for mesh in scene.meshes]:
        return [f"{path.name} holds other objects"]
    found = []
    for mesh, entry in zip(scene.meshes, gltf["meshes"]):
        accessor = gltf["accessors"][entry["primitives"][0]["attributes"]["POSITION"]]
        start = gltf["bufferViews"][accessor["bufferView"]]["byteOffset"]
        stored = struct.unpack_from(f"<{3 * accessor['count']}f", data, start)
        made = [round(v, DECIMALS) for p in mesh.positions for v in p]
        if len(stored) != len(made) or max(abs(a - b) for a, b in zip(stored, made)) > 1e-5:
            found.append(f"{path.name}: {mesh.name} differs from what the script makes")
    images = [image["uri"] for image in gltf.get("images", []) if "uri" in image]
    return found + [f"{name} is missing" for name in images if not (folder / name).exists()]


def mesh_problems(mesh):
    found, n = [], len(mesh.positions)
    if not all(math.isfinite(v) for row in mesh.positions + (mesh.normals or []) for v in row):
        found.append("is not finite")
    if any(not 0 <= i < n for t in mesh.triangles for i in t):
        return [f"{mesh.name}: has an index out of range"]
    if len({i for t in mesh.triangles for i in t}) != n:
        found.append("has vertices that no triangle uses")
    thin = sum(triangle_height(*(mesh.positions[i] for i in t)) < 1e-4 for t in mesh.triangles)
    if thin:
        found.append(f"has {thin} triangles lower than 0.1 mm")
    for what, rows in (("normals", mesh.normals), ("texture coordinates", mesh.texcoords)):
        if rows is not None and len(rows) != n:
            found.append(f"has {len(rows)} {what} for {n} vertices")
    if mesh.normals and any(abs(dot(v, v) - 1.0) > 1e-6 for v in mesh.normals):
        found.append("has normals that are not of length 1")
    if mesh.normals and mesh.kind == "solid" and backward_normals(mesh):
        found.append(f"has {backward_normals(mesh)} triangles whose shading normals all point inwards")
    if mesh.kind == "solid" and open_edges([mesh]):
        found.append(f"has {open_edges([mesh])} open edges")
    elif mesh.kind == "solid" and volume(mesh) <= 0.0:
        found.append("is inside out")
    return [f"{mesh.name}: {sentence}" for sentence in found]


def triangle_height(a, b, c):
    """Height over the longest side."""
    sides = [subtract(b, a), subtract(c, b), subtract(a, c)]
    longest = math.sqrt(max(dot(s, s) for s in sides))
    n = cross(sides[0], sides[1])
    return math.sqrt(dot(n, n)) / longest if longest > 0.0 else 0.0


def backward_normals(mesh):
    count = 0
    for t in mesh.triangles:
        a, b, c = (mesh.positions[i] for i in t)
        face = cross(subtract(b, a), subtract(c, a))
        count += all(dot(face, mesh.normals[i]) < 0.0 for i in t)
    return count


def key(p):
    return tuple(round(v, 6) + 0.0 for v in p)


def open_edges(meshes):
    """Edges not met by exactly one neighbour of the same orientation; vertices at one place count as one."""
    edges = Counter()
    for mesh in meshes:
        keys = [key(p) for p in mesh.positions]
        for a, b, c in mesh.triangles:
            for i, j in ((a, b), (b, c), (c, a)):
                edges[(keys[i], keys[j])] += 1
    return sum(edges[(b, a)] != n for (a, b), n in edges.items())


def volume(mesh):
    origin = mesh.positions[0]
    p = [subtract(q, origin) for q in mesh.positions]
    return sum(dot(p[a], cross(p[b], p[c])) for a, b, c in mesh.triangles) / 6.0


def duplicate_problems(meshes):
    """Triangles at the same three places, whatever their orientation."""
    seen = Counter()
    for mesh in meshes:
        keys = [key(p) for p in mesh.positions]
        seen.update(tuple(sorted(keys[i] for i in t)) for t in mesh.triangles)
    count = sum(n > 1 for n in seen.values())
    return [f"{count} triangles lie twice at the same place"] if count else []


def bounds_problems(name, scene, description):
    """All that is there lies in the cells, to the rounding of single precision."""
    if not description.bounds:
        return []
    low, high = geometry_box(scene.meshes)
    inside = all(a - 1e-6 <= b for a, b in zip(description.bounds[0], low))
    inside = inside and all(a + 1e-6 >= b for a, b in zip(description.bounds[1], high))
    return [] if inside else [f"{name}.toml: the bounds leave out a part of {low} .. {high}"]


def lamp_problems(name, scene, light):
    """The lamp keeps its clearance everywhere in its domain, and is in no solid."""
    who = f"{name}.toml: {light.name}"
    low, high = light.domain_min, light.domain_max
    if not all(a <= p <= b for a, p, b in zip(low, light.position, high)):
        return [f"{who} starts outside its domain"]
    nearest, nearest_name = math.inf, ""
    points = lamp_points(light)
    for mesh in scene.meshes:
        for t in mesh.triangles:
            corners = [mesh.positions[i] for i in t]
            if box_gap(low, high, corners) < min(nearest, light.clearance):
                distance = min(point_triangle_distance(p, *corners) for p in points)
                if distance < nearest:
                    nearest, nearest_name = distance, mesh.name
    found = []
    if nearest < light.clearance - 1e-9:
        found.append(f"{who} comes {nearest:.3f} m close to {nearest_name}, less than {light.clearance} m")
    centre = scaled(add(low, high), 0.5)
    inside = [mesh.name for mesh in scene.meshes if mesh.kind == "solid" and is_inside(centre, mesh)]
    return found + [f"{who} is inside {solid}" for solid in inside]


def lamp_points(light):
    """Sampled positions, and for a rectangle also its corners at each."""
    axes = []
    for a, b in zip(light.domain_min, light.domain_max):
        axes.append([a + (b - a) * k / (LAMP_STEPS - 1) for k in range(LAMP_STEPS)])
    centres = [(x, y, z) for x in axes[0] for y in axes[1] for z in axes[2]]
    if not light.size:
        return centres
    w, h = light.size[0] / 2, light.size[1] / 2  # all our rectangles look straight down
    return centres + [add(p, (dx, 0.0, dz)) for p in centres for dx in (-w, w) for dz in (-h, h)]


def box_gap(low, high, corners):
    """A lower bound of the distance between a box and a triangle."""
    square = 0.0
    for axis in range(3):
        values = [c[axis] for c in corners]
        gap = max(low[axis] - max(values), min(values) - high[axis], 0.0)
        square += gap * gap
    return math.sqrt(square)


def point_triangle_distance(p, a, b, c):
    """Ericson, Real-Time Collision Detection (2005), 5.1.5."""
    ab, ac, ap = subtract(b, a), subtract(c, a), subtract(p, a)
    d1, d2 = dot(ab, ap), dot(ac, ap)
    if d1 <= 0.0 and d2 <= 0.0:
        return length(ap)
    bp = subtract(p, b)
    d3, d4 = dot(ab, bp), dot(ac, bp)
    if d3 >= 0.0 and d4 <= d3:
        return length(bp)
    vc = d1 * d4 - d3 * d2
    if vc <= 0.0 and d1 >= 0.0 and d3 <= 0.0:
        return length(subtract(ap, scaled(ab, d1 / (d1 - d3))))
    cp = subtract(p, c)
    d5, d6 = dot(ab, cp), dot(ac, cp)
    if d6 >= 0.0 and d5 <= d6:
        return length(cp)
    vb = d5 * d2 - d1 * d6
    if vb <= 0.0 and d2 >= 0.0 and d6 <= 0.0:
        return length(subtract(ap, scaled(ac, d2 / (d2 - d6))))
    va = d3 * d6 - d5 * d4
    if va <= 0.0 and d4 >= d3 and d5 >= d6:
        return length(subtract(bp, scaled(subtract(c, b), (d4 - d3) / ((d4 - d3) + (d5 - d6)))))
    normal = cross(ab, ac)
    return abs(dot(normal, ap)) / length(normal)


def length(v):
    return math.sqrt(dot(v, v))


def is_inside(point, mesh):
    """Parity of the crossings of a ray in a direction that no edge of ours follows."""
    direction = (0.5377, 0.7311, 0.4201)
    crossings = 0
    for t in mesh.triangles:
        a, b, c = (mesh.positions[i] for i in t)
        e1, e2, s = subtract(b, a), subtract(c, a), subtract(point, a)
        h = cross(direction, e2)
        det = dot(e1, h)
        if abs(det) < 1e-14:
            continue
        q = cross(s, e1)
        u, v, distance = dot(s, h) / det, dot(direction, q) / det, dot(e2, q) / det
        crossings += u >= 0.0 and v >= 0.0 and u + v <= 1.0 and distance > 0.0
    return crossings % 2 == 1
