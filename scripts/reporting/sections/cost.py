# SPDX-License-Identifier: GPL-3.0-or-later
"""Cost as the work grows: seconds and peak memory of `bake run`, each a process of its own."""
import json
import os

from ..fit import fitted, power_law
from ..plots import Series
from ..tools import run_measured, say, settings_options


def measure(campaign, name, description, settings, *options):
    target = campaign.work(f"cost_{name}.vdb")
    seconds, peak = run_measured("bake", "run", description, "-o", target, "--overwrite",
                                 *settings_options(campaign.settings | settings), *options)
    run = json.loads((target.with_name(target.name + ".work") / "run.json").read_text())
    return {"seconds": seconds, "peak": peak, "cells_seconds": run["cells_seconds"], "trace_seconds": run["trace_seconds"],
            "fit_seconds": run["fit_seconds"]}


def more_lamps(campaign, description, count):
    """temple_four_lamps with its first lamps only."""
    text = description.read_text()
    parts = text.split("[[light]]")
    cameras = parts[-1][parts[-1].index("[[camera]]"):]
    kept = parts[0] + "".join("[[light]]" + p for p in parts[1:1 + count])
    if count < len(parts) - 1:
        kept += cameras
    path = campaign.work(f"lamps_{count}.toml")
    path.write_text(kept.replace('geometry = "', f'geometry = "{description.parent}/', 1))
    return path


def subdivided(campaign, levels):
    """The Cornell box's walls as an OBJ whose quads are cut 4^levels times."""
    n = 2 ** levels
    corners = [((0, 0, 0), (1, 0, 0), (0, 0, 1)), ((0, 1, 0), (1, 0, 0), (0, 0, 1)), ((0, 0, 0), (0, 1, 0), (0, 0, 1)),
               ((1, 0, 0), (0, 1, 0), (0, 0, 1)), ((0, 0, 1), (1, 0, 0), (0, 1, 0)), ((0, 0, 0), (1, 0, 0), (0, 1, 0))]
    lines, base = ["o room"], 1
    for o, u, v in corners:
        for i in range(n + 1):
            for j in range(n + 1):
                p = [4 * (o[k] + u[k] * i / n + v[k] * j / n) for k in range(3)]
                lines.append("v " + " ".join(f"{x:.6g}" for x in p))
        for i in range(n):
            for j in range(n):
                a = base + i * (n + 1) + j
                lines += [f"f {a} {a + 1} {a + n + 2}", f"f {a} {a + n + 2} {a + n + 1}"]
        base += (n + 1) ** 2
    obj = campaign.work(f"room_{levels}.obj")
    obj.write_text("\n".join(lines) + "\n")
    toml = campaign.work(f"room_{levels}.toml")
    toml.write_text(f'[scene]\ngeometry = "{obj.name}"\n[grid]\ncells = 24\n[bake]\nphotons = 20000\n[[light]]\nname = "lamp"\n'
                    "power = [100, 100, 100]\nposition = [2, 2, 2]\nsamples = 60\n"
                    "domain = { min = [1, 1, 1], max = [3, 3, 3] }\n"
                    '[[camera]]\nname = "inside"\neye = [0.5, 2, 0.5]\ntarget = [3, 2, 3]\nsize = [64, 64]\n')
    return toml, 12 * 4 ** levels


def curve(page, name, what, points, note):
    """points: (x, measured)"""
    rows = [(x, m["seconds"]) for x, m in points]
    series = [Series("whole bake", [(x, m["seconds"], 0) for x, m in points], fit=fitted(rows))]
    series += [Series(part, [(x, m[f"{part}_seconds"], 0) for x, m in points if m[f"{part}_seconds"] > 0])
               for part in ("cells", "trace", "fit")]
    page.plot(f"cost_{name}", f"Bake time against {what}", what, "seconds", series, y_unit=" s", note=note)

    def exponent(key):
        pairs = [(x, m[key]) for x, m in points]
        return f"{power_law(pairs).slope:.2f}" if len(pairs) > 1 else "—"

    return [what, f"{points[0][0]:,} … {points[-1][0]:,}", *map(exponent, ("seconds", "trace_seconds", "fit_seconds", "peak")),
            f"{points[0][1]['peak'] / 1e6:.0f} … {points[-1][1]['peak'] / 1e6:.0f} MB"]


# axis: what grows, and what to know of it
AXES = {
    "photons": ("photons per position",
                "Finding the cells does not depend on it; tracing is linear once it outweighs writing each volume."),
    "positions": ("lamp positions", "Tracing and fitting are linear: the fit streams the volumes and factorises once."),
    "cells": ("cells along the longest side",
              "Patches grow with the square (surfaces), and with them fit, volumes and file; tracing only a little."),
    "triangles": ("triangles", "An empty room with its walls cut finer: rays take logarithmic time, the cutting into fragments "
                  "linear time."),
    "lamps": ("lamps", "Each lamp has its own positions, photons and polynomials."),
    "threads": ("threads", "−1 would be perfect: reading the scene and writing the map are done by one thread."),
}


def measure_all(campaign):
    say("cost as the work grows")
    temple = campaign.scenes["temple"]
    cells = max(campaign.plan(temple)["grid"])
    four = temple.parent / "temple_four_lamps.toml"
    few = {"photons": 10000}
    count = campaign.choose(2, 4)

    def one(settings, *options):
        return measure(campaign, "temple", temple, settings, *options)

    points = {"photons": [(n, one({"photons": n})) for n in (2500, 10000, 40000, 160000)[:count]],
              "positions": [(n, one({**few, "samples": n})) for n in (60, 120, 240, 480)[:count]]}
    if not campaign.quick:
        rooms = [subdivided(campaign, level) for level in (1, 3, 5, 7)]
        points["cells"] = [(n, one({**few, "cells": n})) for n in (cells // 2, cells, 2 * cells, 3 * cells)]
        points["triangles"] = [(n, measure(campaign, "room", toml, {})) for toml, n in rooms]
        points["lamps"] = [(n, measure(campaign, "lamps", more_lamps(campaign, four, n), few)) for n in (1, 2, 3, 4)]
    cores = os.cpu_count() or 1
    if cores > 1:
        points["threads"] = [(n, one(few, "--threads", n)) for n in sorted({1, 2, cores})]
    return points


def section(campaign, page):
    page.heading("Cost as the work grows")
    points = campaign.once("cost", lambda: measure_all(campaign))
    table = [curve(page, name, *AXES[name][:1], own, AXES[name][1]) for name, own in points.items()]
    page.table(["grows", "from … to", "exponent of the whole", "of tracing", "of the fit", "of peak memory", "peak memory"], table,
               "Exponents of power laws through the points; the base is `temple` with 10,000 photons, the triangles' a bare room.")
