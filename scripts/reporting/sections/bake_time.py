# SPDX-License-Identifier: GPL-3.0-or-later
"""Error against bake time: what each second of a bake buys."""
import json

from ..fit import approach, curve
from ..plots import Series
from ..tools import half_width, run_json, say

EVALUATE = ("--lights", 12, "--pixels", 1500, "--paths", 192)
SEVERAL_SEEDS = ("cornell", "temple", "cloister")
EVERY_AXIS = ("temple",)
QUICK = ("--lights", 6, "--pixels", 600, "--paths", 96)


def sweep(campaign, name, description, *axes):
    axes += tuple(f"{key}={value}" for key, value in campaign.settings.items())
    options = [word for axis in axes for word in ("--axis", axis)]
    folder = campaign.work(f"sweep_{name}")
    return run_json("bake", "sweep", description, *options, "-o", folder, "--json",
                    *campaign.choose(QUICK, EVALUATE))


def listed(values):
    return ",".join(json.dumps(v, separators=(",", ":")) for v in values)


def photon_runs(campaign, name, description, base):
    shares = campaign.choose([1 / 16, 1 / 4, 1], [1 / 64, 1 / 16, 1 / 4, 1])
    if name not in SEVERAL_SEEDS:
        shares = [1 / 16, 1]
    elif name == "temple" and not campaign.quick:
        shares.append(4)
    photons = [max(1, round(base["photons"] * s)) for s in shares]
    seeds = campaign.choose([1], [1, 2, 3] if name in SEVERAL_SEEDS else [1])
    return sweep(campaign, name, description, f"photons={listed(photons)}", f"seed={listed(seeds)}")


def other_axes(campaign, name, description, base):
    """Each setting alone, the others as described but for a quarter of the photons."""
    few = f"photons={max(1, base['photons'] // 4)}"
    if campaign.quick:
        return {"degree": sweep(campaign, name, description, few, "degree=0,1,2,3")}
    cells = [round(base["cells"] * f) for f in (0.5, 0.7, 1, 1.4)]
    axes = {"cells": f"cells={listed(cells)}",
            "samples": f"samples={listed([max(24, base['samples'] // 4), base['samples'] // 2, base['samples'], 2 * base['samples']])}",
            "boxes": f"boxes={listed([[1, 1, 1], [2, 1, 2], [2, 2, 2]])}",
            "degree": "degree=0,1,2,3", "facings": "facings=true,false",
            "estimator": 'estimator="area","sphere"', "robust": 'robust="off","auto"'}
    return {axis: sweep(campaign, name, description, few, values) for axis, values in axes.items()}


def by_photons(runs, key):
    """(photons, mean error, half width over seeds, mean seconds)"""
    groups = {}
    for r in runs:
        groups.setdefault(r["settings"]["photons"], []).append(r)
    return [(n, sum(r[key] for r in g) / len(g), half_width([r[key] for r in g]),
             sum(r["bake_seconds"] for r in g) / len(g)) for n, g in sorted(groups.items())]


def pareto(runs):
    """Runs that no other beats in both error and time."""
    best, front = float("inf"), []
    for r in sorted(runs, key=lambda r: r["bake_seconds"]):
        if r["relrmse"] < best:
            best = r["relrmse"]
            front.append(r)
    return front


def text_of(settings, hidden):
    return ", ".join(f"{key} {json.dumps(value)}" for key, value in settings.items() if key not in hidden)


def measure(campaign, name, description):
    say(f"{name}: error against bake time")
    base = campaign.described(description)
    with_others = name in EVERY_AXIS
    return {"base": base, "photons": photon_runs(campaign, name, description, base),
            "others": other_axes(campaign, name, description, base) if with_others else {}}


def one_scene(campaign, page, name, description):
    measured = campaign.once(f"bake_time_{name}", lambda: measure(campaign, name, description))
    photons, others = measured["photons"], measured["others"]
    page.heading(f"{name}", 3)
    for key, what in (("relrmse_indirect", "indirect light"), ("relrmse", "whole picture")):
        points = by_photons(photons, key)
        pairs = [(n, e) for n, e, _, _ in points]
        law = approach(pairs)
        floor = law.floor if law else 0
        note = ""
        if law and len(pairs) > 3:
            note = (f"e² = floor² + c / N^p: floor {floor:.4f}; above it the error falls with the power {-law.power / 2:.2f} (−0.5: "
                    "plain photon noise; less: the filter among patches takes away more where there is more).").replace("-", "−")
        elif law:
            note = f"e² = floor² + c / N through too few counts of photons for more: floor {floor:.4f}."
        page.plot(f"{name}_photons_{key}", f"{name}: {what}", "photons per lamp position", "relative error",
                  [Series("measured" + (", three seeds" if not campaign.quick and points[0][2] else ""),
                          [(n, e, d) for n, e, d, _ in points], fit=law and ("e² = floor² + c / N^p", curve(pairs, law.error)))],
                  lines=[(floor, "floor")] if floor else [], note=note)
    series = [Series("photons", [(t, e, d) for _, e, d, t in by_photons(photons, "relrmse")])]
    for axis, runs in others.items():
        series.append(Series(axis, [(r["bake_seconds"], r["relrmse"], 0) for r in runs],
                             marks=[json.dumps(r["settings"][axis]) for r in runs]))
    page.plot(f"{name}_time", f"{name}: every axis", "bake, s", "relative error of the picture", series, x_unit=" s")
    rows = [[text_of(r["settings"], {"seed", *campaign.settings}), f"{r['bake_seconds']:.1f}", f"{r['bytes'] / 1e6:.1f}",
             f"{r['relrmse']:.4f}", f"{r['relrmse_indirect']:.4f}"] for r in pareto(photons + [r for runs in others.values() for r in runs])]
    page.table(["settings", "baked, s", "MB", "error", "indirect"], rows,
               "The Pareto front: nothing tried is both faster and better. What is not named is as in the scene's file.")


def section(campaign, page):
    page.heading("Error against bake time")
    page.text("One setting at a time is moved away from the scene's own file (other settings than photons at a quarter of the "
              "photons). Errors are those of `bake evaluate`, against path tracing at lamp positions that no fit has seen. "
              + campaign.choose("Quick run: one scene, one seed, and in all bakes only 2²⁰ photons that look for surface in "
                                "the light's reach.", "Bars: 95 % over three seeds, where three were run."))
    for name, description in campaign.scenes.items():
        if not campaign.quick or name == "temple":
            one_scene(campaign, page, name, description)
