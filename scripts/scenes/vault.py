# SPDX-License-Identifier: GPL-3.0-or-later
"""Groin vaults: two elliptical tunnels of one height that cross over a rectangular bay."""

import math

from scenes.mesh import Mesh, normalized


def groin_vault(name, material, centre, half, spring, rise, top, steps):
    """Solid over the bay of half extents (x, z) about `centre` (x, z): vaulted below, flat at the height `top`.
    Smooth but for the groins, where its four sectors meet, and the edges."""
    mesh = Mesh(name, material, [(centre[0], top, centre[1])], [], [(0.0, 1.0, 0.0)])
    for quarter in range(4):
        add_sector(mesh, centre, half, spring, rise, steps, quarter)
        add_side(mesh, top, steps, quarter)
    return mesh


def turned(u, v, quarter):
    """(u, v) turned by quarters, x towards z."""
    for _ in range(quarter):
        u, v = -v, u
    return u, v


def add_sector(mesh, centre, half, spring, rise, steps, quarter):
    """The quarter of the underside that begins at the crown and widens towards one side of the bay."""
    first = []
    across = half[1] if quarter % 2 == 0 else half[0]  # half width of the tunnel seen in this sector
    for i in range(steps + 1):
        first.append(len(mesh.positions))
        for j in range(-i, i + 1):
            along, angle = math.sin(0.5 * math.pi * i / steps), 0.5 * math.pi * j / steps
            x, z = turned(along, math.sin(angle), quarter)
            mesh.positions.append((centre[0] + half[0] * x, spring + rise * math.cos(angle), centre[1] + half[1] * z))
            nx, nz = turned(0.0, -math.sin(angle) * rise, quarter)
            mesh.normals.append(normalized((nx, -math.cos(angle) * across, nz)))
    for i in range(steps):
        row, wider = first[i] + i, first[i + 1] + i + 1  # middles of the two rows
        for j in range(-i, i + 1):
            mesh.triangles.append((row + j, wider + j, wider + j + 1))
            if j > -i:
                mesh.triangles.append((row + j - 1, wider + j, row + j))
        mesh.triangles.append((row - i, wider - i - 1, wider - i))


def add_side(mesh, top, steps, quarter):
    """The upright side over the arch that ends the sector made last, and the part of the flat top beside it."""
    count = 2 * steps + 1
    arch = mesh.positions[-count:]
    above = [(x, top, z) for x, _, z in arch]
    low, high, flat = (len(mesh.positions) + i * count for i in range(3))
    nx, nz = turned(1.0, 0.0, quarter)
    mesh.positions += arch + above + above
    mesh.normals += [(nx, 0.0, nz)] * (2 * count) + [(0.0, 1.0, 0.0)] * count
    for j in range(count - 1):
        mesh.triangles += [(low + j, high + j + 1, low + j + 1), (low + j, high + j, high + j + 1)]
        mesh.triangles.append((0, flat + j + 1, flat + j))
