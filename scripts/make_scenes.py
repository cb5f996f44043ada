#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes the scenes of data/ (Python's standard library only; the same bytes each time).

make_scenes.py [NAME...]            writes the named scenes, or all
make_scenes.py --check [NAME...]    writes nothing; checks counts, indices, closedness, and that lamps keep clear
"""

import argparse
import importlib
import sys
from pathlib import Path

sys.dont_write_bytecode = True

from scenes.check import problems  # noqa: E402
from scenes.description import counts, grid_counts, write_scene  # noqa: E402

NAMES = ["cornell", "sphere", "panel", "thin_wall", "temple", "cloister", "caustic", "gallery"]


def main():
    parser = argparse.ArgumentParser(description="Makes the scenes of data/.")
    parser.add_argument("names", nargs="*", metavar="NAME", help=f"of {', '.join(NAMES)}; default: all")
    parser.add_argument("--check", action="store_true", help="check the scenes, write nothing")
    parser.add_argument("--output", type=Path, default=Path(__file__).resolve().parent.parent / "data")
    arguments = parser.parse_args()
    unknown = [name for name in arguments.names if name not in NAMES]
    if unknown:
        parser.error(f"no scene is called {unknown[0]}; there are {', '.join(NAMES)}")

    failed = False
    for name in arguments.names or NAMES:
        scene = importlib.import_module(f"scenes.{name}").scene()
        folder = arguments.output / name
        if not arguments.check:
            write_scene(scene, folder)
        objects, vertices, triangles = counts(scene)
        grids = {tuple(grid_counts(d, scene.meshes)[0]) for d in scene.descriptions.values()}
        sizes = ", ".join(" x ".join(map(str, grid)) for grid in sorted(grids))
        print(f"{name}: {objects} objects, {vertices} vertices, {triangles} triangles, grid {sizes}")
        for problem in problems(scene, folder) if arguments.check else []:
            failed = True
            print(f"{name}: {problem}", file=sys.stderr)
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
