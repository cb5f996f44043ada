# SPDX-License-Identifier: GPL-3.0-or-later
"""The pictures of the gallery and its floor, computed: functions from pixel to sRGB."""

import math

from scenes.png import png_bytes


def noise(i, j):
    """A fixed pseudo-random number in 0..1 for a pair of integers."""
    n = (i * 374761393 + j * 668265263 + 1013904223) & 0xFFFFFFFF
    n = ((n ^ (n >> 13)) * 1274126177) & 0xFFFFFFFF
    return ((n ^ (n >> 16)) & 0xFFFF) / 65535.0


def mixed(a, b, t):
    return tuple(int(p + (q - p) * t + 0.5) for p, q in zip(a, b))


def planks(size=384, lines=6):
    """Floor boards along x, each with its own tint, joint and grain."""

    def pixel(x, y):
        board = y * lines // size
        inside = y - board * size // lines
        shift = int(noise(board, 7) * size)
        piece = ((x + shift) % size) * 2 // size
        if inside == 0 or (x + shift) % (size // 2) == 0:
            return (52, 33, 20)
        tint = noise(board, 20 + piece)
        bend = 0.35 * math.sin(2.0 * math.pi * (x / size + tint))
        wave = math.sin(2.0 * math.pi * (3.0 * inside * lines / size + bend) + 9.0 * tint)
        level = round(3.0 * (0.5 + 0.5 * wave) + 3.0 * tint) / 6.0
        return mixed((112, 72, 40), (166, 116, 68), level)

    return png_bytes(size, size, pixel)


def blocks(width=256, height=192):
    """Coloured fields between black bars."""
    columns, rows = (0.0, 0.14, 0.52, 0.81, 1.0), (0.0, 0.30, 0.62, 0.86, 1.0)
    fields = {(1, 0): (196, 40, 30), (3, 1): (240, 196, 44), (0, 2): (30, 70, 150), (2, 3): (28, 62, 132)}

    def pixel(x, y):
        u, v = x / width, y / height
        if any(abs(x - c * width) < 3.5 for c in columns[1:-1]) or any(abs(y - r * height) < 3.5 for r in rows[1:-1]):
            return (24, 22, 22)
        column, row = sum(u >= c for c in columns) - 1, sum(v >= r for r in rows) - 1
        return fields.get((column, row), (238, 234, 222))

    return png_bytes(width, height, pixel)


def dunes(width=256, height=192):
    """Hills, one behind the other, under a setting sun."""
    tints = [(206, 128, 84), (176, 92, 76), (128, 66, 78), (78, 48, 74), (42, 32, 58)]

    def pixel(x, y):
        u, v = x / width, y / height
        color = mixed((250, 214, 142), (236, 142, 96), min(1.0, round(10.0 * v) / 7.0))
        if (x - 0.68 * width) ** 2 + (y - 0.34 * height) ** 2 < 24.0**2:
            color = (255, 244, 214)
        for k, tint in enumerate(tints):
            crest = 0.42 + 0.12 * k + 0.05 * math.sin(6.0 * u + 2.1 * k) + 0.025 * math.sin(15.0 * u + 4.0 * k)
            color = tint if v > crest else color
        return color

    return png_bytes(width, height, pixel)


def discs(width=192, height=256):
    """Overlapping discs that turn each other's colours."""
    shapes = [(0.36, 0.30, 0.25, (214, 70, 48)), (0.64, 0.42, 0.27, (240, 178, 50)), (0.40, 0.62, 0.30, (40, 120, 140))]
    shapes += [(0.70, 0.76, 0.17, (232, 224, 206))]

    def pixel(x, y):
        color, inside = (30, 34, 52), 0
        for cx, cy, r, tint in shapes:
            if (x - cx * width) ** 2 + (y - cy * height) ** 2 < (r * width) ** 2:
                inside += 1
                color = tint if inside == 1 else mixed(color, tint, 0.5)
        return color

    return png_bytes(width, height, pixel)


def spiral(width=192, height=256):
    """A spiral of two colours around a pale eye."""

    def pixel(x, y):
        dx, dy = (x - 0.5 * width) / width, (y - 0.46 * height) / width
        radius, angle = math.hypot(dx, dy), math.atan2(dy, dx)
        if radius < 0.06:
            return (244, 236, 214)
        turn = math.sin(3.0 * angle + 9.0 * math.log(radius))
        tints = ((26, 84, 92), (44, 130, 124), (222, 204, 160), (196, 96, 52))
        return tints[min(3, int(2.0 + 2.0 * turn))]

    return png_bytes(width, height, pixel)


def bands(width=256, height=192):
    """Waves of blue and green."""
    tints = [(18, 38, 74), (26, 70, 112), (44, 112, 146), (92, 160, 168), (176, 208, 190), (236, 230, 204)]

    def pixel(x, y):
        u, v = x / width, y / height
        wave = v + 0.09 * math.sin(9.0 * u + 5.0 * v) + 0.04 * math.sin(23.0 * u - 9.0 * v)
        return tints[int(wave * 14.0) * 5 % len(tints)]

    return png_bytes(width, height, pixel)
