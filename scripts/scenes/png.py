# SPDX-License-Identifier: GPL-3.0-or-later
"""Writer of PNG pictures, 8 bits, RGB (ISO/IEC 15948)."""

import struct
import zlib


def png_bytes(width, height, pixel):
    """The file's bytes; `pixel(x, y)` gives (r, g, b), sRGB 0..255, the first row at the top."""
    rows = bytearray()
    before = bytes(3 * width)
    for y in range(height):
        row = bytes(value for x in range(width) for value in pixel(x, y))
        rows += best_filter(row, before)
        before = row

    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    header = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    body = chunk(b"IHDR", header) + chunk(b"sRGB", b"\0") + chunk(b"IDAT", zlib.compress(bytes(rows), 9))
    return b"\x89PNG\r\n\x1a\n" + body + chunk(b"IEND", b"")


def best_filter(row, before):
    """The row under the filter (none, left, above) with the smallest sum of differences."""
    left = bytes((value - (row[i - 3] if i >= 3 else 0)) & 255 for i, value in enumerate(row))
    above = bytes((value - before[i]) & 255 for i, value in enumerate(row))
    candidates = [(0, row), (1, left), (2, above)]
    kind, data = min(candidates, key=lambda c: sum(min(v, 256 - v) for v in c[1]))
    return bytes([kind]) + data
