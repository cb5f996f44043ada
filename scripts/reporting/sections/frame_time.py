# SPDX-License-Identifier: GPL-3.0-or-later
"""Error against frame time: the map beside its rivals over the same scene."""
import json
import subprocess
import sys

from ..fit import line
from ..plots import Series
from ..tools import ROOT, bake, bake_seconds, has, run, run_json, say, view

SIZE = "393x393"
BOTH = ["direct", "indirect"]
THESIS_SCENES = ("temple", "cloister")
MOST_PHOTONS = 20_000_000  # that are kept at once
FINER = {"photons": 4, "samples": 2, "cells": 1.5}  # times the scene's own settings


def benchmark(map_file, *options):
    return run_json("viewer", map_file, "--benchmark", "--size", SIZE, *options)


def evaluated(campaign, map_file, *options, lights=None):
    lights = lights or campaign.choose(4, 12)
    return run_json("bake", "evaluate", map_file, "--json", "--lights", lights, "--pixels", campaign.choose(800, 2000),
                    "--paths", campaign.choose(128, 256), *options)


def ours(campaign, name, description):
    """(label, error, frame seconds): lamp moving, still camera, to 8 bits; direct light traced, and baked."""
    plain = bake(campaign, name, description)
    both = bake(campaign, f"{name}_both", description, components=BOTH)
    traced, baked = benchmark(plain, "--direct", "traced"), benchmark(both, "--direct", "baked")
    result = evaluated(campaign, plain)
    return [("map, direct light traced", result["relrmse"], traced["lamp_moving"]["median_ms"] / 1000),
            ("map, all light baked", evaluated(campaign, both)["relrmse"], baked["lamp_moving"]["median_ms"] / 1000)], result


def finer(campaign, name, description):
    """The same frame of a bake that takes some times as long."""
    settings = {key: round(FINER[key] * value) for key, value in campaign.described(description).items()}
    target = bake(campaign, f"{name}_finer", description, **settings)
    frame = benchmark(target, "--direct", "traced")["lamp_moving"]["median_ms"] / 1000
    return [f"finer map ({bake_seconds(target):.0f} s), direct light traced", evaluated(campaign, target)["relrmse"], frame]


def path_curve(campaign, map_file, evaluation, name):
    """Noise of n paths per pixel falls with its root from what the reference's own halves show."""
    paths = campaign.choose(128, 256)
    stats = view(map_file, campaign.work(f"{name}_path.exr"), "--integrator", "path", "--spp", 4, "--size", SIZE)
    second = stats["frame_seconds"] / 4
    noise = evaluation["reference_noise"] * paths ** 0.5
    return [(n, noise / n ** 0.5, n * second) for n in (1, 4, 16, 64, 256, 1024, 4096)]


def photon_map_curve(campaign, map_file, base_photons, positions, name):
    tries = [(base_photons, 50, 0), (4 * base_photons, 100, 0), (base_photons, 50, 16)]
    if not campaign.quick:
        tries += [(16 * base_photons, 200, 0), (base_photons, 50, 64), (4 * base_photons, 100, 64)]
        if base_photons * positions <= MOST_PHOTONS:  # as many as the whole bake
            tries += [(base_photons * positions, 50, 0), (base_photons * positions, 400, 0)]
    points = []
    for photons, nearest, gather in tries:
        options = ["--integrator", "photon_map", "--photons", photons, "--nearest", nearest, "--gather", gather]
        many = photons > 20 * base_photons
        stats = view(map_file, campaign.work(f"{name}_photon_map.exr"), *options, "--spp", 1, "--size", SIZE)
        error = evaluated(campaign, map_file, *options, lights=3 if many else campaign.choose(3, 6))["relrmse"]
        label = f"{photons:,} photons, {nearest} nearest" + (f", {gather} rays gathered" if gather else "")
        points.append({"label": label, "error": error, "seconds": stats["frame_seconds"], "photons": photons,
                       "nearest": nearest, "gather": gather})
    return points


def gathering_curve(campaign, map_file, photons, name):
    """Final gathering with more and more rays per hit: the cheapest of the photon maps where errors are small."""
    points = []
    for rays in (16, 32, 64, 128, 256):
        options = ["--integrator", "photon_map", "--photons", photons, "--nearest", 100, "--gather", rays]
        stats = view(map_file, campaign.work(f"{name}_photon_map.exr"), *options, "--spp", 1, "--size", SIZE)
        points.append([rays, evaluated(campaign, map_file, *options, lights=6)["relrmse"], stats["frame_seconds"]])
    return points


def gathering_to(points, error):
    """(rays, seconds) to an error, by e² = bias² + c / rays and seconds = s + t · rays through the points; None: never."""
    bias, c = line([(1 / n, e * e) for n, e, _ in points])
    start, slope = line([(n, t) for n, _, t in points])
    rays = c / (error * error - bias) if error * error > bias else None
    return rays and (rays, start + slope * rays)


def cycles_curve(campaign, name, description):
    """Noise and seconds of a few samples, to be scaled by roots. None where Blender is not there."""
    if campaign.quick or not has("blender"):
        return None
    done = campaign.work(f"{name}_cycles.json")
    command = [sys.executable, ROOT / "scripts/compare_cycles", description, "--size", SIZE, "--samples", "32", "--json", done]
    subprocess.run(list(map(str, command)), capture_output=True)
    if not done.exists():
        return None
    result = next(iter(json.loads(done.read_text())["scenes"].values()))
    samples, seconds = result["cycles_samples"], result["seconds"]["cycles"]["render"]
    noise = result["noise"]["cycles"] * samples ** 0.5
    return [(n, noise / n ** 0.5, seconds * n / samples) for n in (1, 4, 16, 64, 256, 1024, 4096)]


def seconds_to(curve, error):
    """On a curve of noise that falls with the root of the time."""
    _, e, t = curve[0]
    return t * (e / error) ** 2


def measure(campaign, name, description):
    say(f"{name}: error against frame time")
    frames, evaluation = ours(campaign, name, description)
    map_file = campaign.work(f"{name}.vdb")
    plan = campaign.plan(description)
    whitted = evaluated(campaign, map_file, "--integrator", "whitted", lights=campaign.choose(2, 4))["relrmse"]
    whitted_time = view(map_file, campaign.work(f"{name}_whitted.exr"), "--integrator", "whitted", "--spp", 1, "--size",
                        SIZE)["frame_seconds"]
    return {"ours": frames, "path": path_curve(campaign, map_file, evaluation, name),
            "photon_map": photon_map_curve(campaign, map_file, plan["photons_total"] // plan["light_samples"],
                                           plan["light_samples"], name),
            "cycles": cycles_curve(campaign, name, description), "whitted": [whitted, whitted_time],
            "texture_map": texture_map(campaign, name, map_file)}


def one_scene(campaign, page, name, description):
    m = campaign.once(f"frame_time_{name}", lambda: measure(campaign, name, description))
    frames, paths, maps, cycles = [*m["ours"]], m["path"], m["photon_map"], m["cycles"]
    (whitted, whitted_time), texture = m["whitted"], m["texture_map"]
    if not campaign.quick and name in THESIS_SCENES:
        frames.append(campaign.once(f"finer_{name}", lambda: finer(campaign, name, description)))
    page.heading(name, 3)
    series = [Series("our map", [(t, e, 0) for _, e, t in frames], line=False, marks=[l for l, _, _ in frames]),
              Series("path tracing (ours)", [(t, e, 0) for _, e, t in paths], marks=[str(n) for n, _, _ in paths])]
    if cycles:
        series.append(Series("path tracing (Cycles)", [(t, e, 0) for _, e, t in cycles]))
    series.append(Series("photon map", [(p["seconds"], p["error"], 0) for p in maps], line=False))
    series.append(Series("Whitted: direct light only", [(whitted_time, whitted, 0)], line=False))
    page.plot(f"{name}_frames", f"{name}, 393 × 393: the light after a lamp's move", "frame, s", "relative error", series,
              x_unit=" s", note="Marks on the paths' curve: samples per pixel.")
    rows = table_rows(frames, paths, maps, cycles, whitted, whitted_time)
    if not campaign.quick:
        photons = 4 * maps[0]["photons"]
        points = campaign.once(f"gathering_{name}",
                               lambda: gathering_curve(campaign, campaign.work(f"{name}.vdb"), photons, name))
        rows.insert(-1, gathering_row(photons, points, frames))
    page.table(["way", "error", "frame, s", *(f"time to the error of our {label} / our frame" for label, _, _ in frames)], rows)
    if texture:
        page.text(f"**Polynomial texture map** of this view (one lamp plane, one camera; `viewer --export-ptm`), against path "
                  f"tracing: error {texture['relrmse']:.3f}, of our map's pictures at the same lamp positions "
                  f"{texture['relrmse_map']:.3f}; parts of it: " +
                  ", ".join(f"{key} {value:.3f}" for key, value in texture["parts"].items()) + ".")


def texture_map(campaign, name, map_file):
    if name not in campaign.choose((), ("cornell", "temple")):
        return None
    stats = campaign.work(f"{name}_ptm.json")
    run("viewer", map_file, "--export-ptm", campaign.work(f"{name}.ptm"), "--integrator", "path", "--spp", 16, "--size",
        "128x128", "--stats", stats)
    return json.loads(stats.read_text())


def ratio_text(seconds, frame):
    return f"{seconds / frame:,.0f} ×"


def table_rows(frames, paths, maps, cycles, whitted, whitted_time):
    rows = [[label, f"{e:.4f}", f"{t:.5f}", *("1 ×" if i == column else "" for column in range(len(frames)))]
            for i, (label, e, t) in enumerate(frames)]
    for label, curve in (("path tracing (ours)", paths), ("path tracing (Cycles)", cycles)):
        if curve:
            rows.append([f"{label}, 1 sample", f"{curve[0][1]:.4f}", f"{curve[0][2]:.5f}",
                         *(ratio_text(seconds_to(curve, e), t) for _, e, t in frames)])
    for p in maps:
        rows.append([f"photon map, {p['label']}", f"{p['error']:.4f}", f"{p['seconds']:.3f}",
                     *(ratio_text(p["seconds"], t) if p["error"] <= e else f"not reached at {ratio_text(p['seconds'], t)}"
                       for _, e, t in frames)])
    rows.append(["Whitted", f"{whitted:.4f}", f"{whitted_time:.3f}", *(["never"] * len(frames))])
    return rows


def gathering_row(photons, points, frames):
    """What lies between the settings that were measured."""
    cells = []
    for _, error, seconds in frames:
        needed = gathering_to(points, error)
        if not needed:
            cells.append("never")
        elif needed[0] < points[0][0]:
            cells.append("no gathering needed")
        else:
            beyond = ", extrapolated" if needed[0] > points[-1][0] else ""
            cells.append(f"{ratio_text(needed[1], seconds)} ({needed[0]:.0f} rays{beyond})")
    measured = ", ".join(f"{n}: {e:.4f} in {t:.2f} s" for n, e, t in points)
    return [f"photon map, {photons:,} photons, 100 nearest, as many gathering rays as needed ({measured}; e² = bias² + c / rays)",
            "", "", *cells]


def section(campaign, page):
    page.heading("Error against frame time")
    times = ", ".join(f"{factor} × {key}" for key, factor in FINER.items())
    finer_too = f"; those of the thesis' two scenes also finer ({times}): a bake is paid once, a frame every time"
    page.text("A lamp moves, the camera rests: how long until the picture is right? Our frame is the viewer's own, from the lamp's "
              "move to 8 bits in memory (median of 120). Rivals start from the lamp's move too: photons are shot anew, paths traced "
              "anew; all use Embree and all cores. Errors of all but Cycles are taken along the same camera rays at unseen lamp "
              "positions (`bake evaluate --integrator`), so that no rival pays for antialiasing. Maps are baked with the settings of "
              f"the scenes' own descriptions, which take seconds{campaign.choose('', finer_too)}. The noise of n paths falls with "
              "√n from what two halves of the reference show; Cycles' noise comes from two of its own pictures. The thesis says "
              "24 × (temple) and 28 × (cloister) against its photon map: quotients of its tables, not at equal error.")
    for name in campaign.choose(("temple",), ("temple", "cloister", "cornell")):
        if name in campaign.scenes:
            one_scene(campaign, page, name, campaign.scenes[name])
