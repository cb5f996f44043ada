# SPDX-License-Identifier: GPL-3.0-or-later
"""Linear pictures through oiiotool, without further packages."""
import re
import subprocess
import sys


def load(path):
    """(x, y): the first three channels, y from the top."""
    text = subprocess.run(["oiiotool", "--dumpdata", path], check=True, capture_output=True, text=True).stdout
    pixels = {}
    for x, y, values in re.findall(r"Pixel \((\d+), (\d+)\): ([^\n(]*)", text):
        pixels[int(x), int(y)] = [float(v) for v in values.split()][:3]
    if not pixels:
        sys.exit(f"{path}: cannot be read")
    return pixels


def header(path):
    """What stands in the file beside its pixels, as text."""
    text = subprocess.run(["oiiotool", "--info", "-v", path], check=True, capture_output=True, text=True).stdout
    return {key: value.strip('"') for key, value in re.findall(r"^ +([\w.:]+): (.*)$", text, re.MULTILINE)}
