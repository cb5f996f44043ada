# SPDX-License-Identifier: GPL-3.0-or-later
"""Triangle meshes and what is done with whole ones.

Y is up, lengths are metres, triangles are counter-clockwise seen from the side that the normal points to:
outwards for solids, into the room for the walls of a room. Only smooth meshes carry normals.
"""

import math
from dataclasses import dataclass



@dataclass
class Mesh:
    """One named object. `kind` says what the self-check may expect of it:
    "solid": closed, normals outwards; "room": a part of the shell around the air; "sheet": anything open."""

    name: str
    material: str
    positions: list
    triangles: list
    normals: list | None = None
    texcoords: list | None = None
    kind: str = "solid"


def add(a, b):
    return (a[0] + b[0], a[1] + b[1], a[2] + b[2])


def subtract(a, b):
    return (a[0] - b[0], a[1] - b[1], a[2] - b[2])


def scaled(a, factor):
    return (a[0] * factor, a[1] * factor, a[2] * factor)


def dot(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def cross(a, b):
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def normalized(a):
    length = math.sqrt(dot(a, a))
    return scaled(a, 1.0 / length)


def merged(name, material, parts, kind="solid"):
    """One object out of several; all parts have normals, or none has."""
    positions, triangles, normals = [], [], []
    for part in parts:
        first = len(positions)
        positions += part.positions
        normals += part.normals or []
        triangles += [(a + first, b + first, c + first) for a, b, c in part.triangles]
    assert not normals or len(normals) == len(positions)
    return Mesh(name, material, positions, triangles, normals or None, kind=kind)


def moved(mesh, offset=(0.0, 0.0, 0.0), turn=0.0, name=None):
    """A copy turned about the y axis (radians, +z towards +x) and then shifted."""
    c, s = math.cos(turn), math.sin(turn)
    if abs(c) < 1e-12 or abs(s) < 1e-12:  # quarter turns stay exact
        c, s = float(round(c)), float(round(s))

    def turned(v):
        return (c * v[0] + s * v[2], v[1], -s * v[0] + c * v[2])

    positions = [add(turned(p), offset) for p in mesh.positions]
    normals = [turned(n) for n in mesh.normals] if mesh.normals else None
    return Mesh(name or mesh.name, mesh.material, positions, list(mesh.triangles), normals, mesh.texcoords, mesh.kind)
