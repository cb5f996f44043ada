# SPDX-License-Identifier: GPL-3.0-or-later
"""The thesis' tables and figures, with our numbers beside those of its that we know."""
import re

from ..plots import Series
from ..tools import bake, bake_seconds, description_with, run_json, say, view

SIZE = "393x393"
COUNTS = {"temple": (97, 9674, 19230), "cloister": (81, 40939, 81410)}
RATE = {"temple": 2.29, "cloister": 1.375}
# A lamp's cost in the thesis' table 7, from 2.041 frames/s with one.
LAMPS = {2: -22.6, 3: -33.3, 4: -41.5}
BOTH = ["direct", "indirect"]
NOTE = ("**Our scenes are stand-ins of equal counts, not the thesis' models**, and the machine is another: its numbers stand beside "
        "ours for orientation. The thesis' text was not at hand; where a number of its is missing here, we do not know it. For the same reason its "
        "figures 15 and 16, which we cannot name, have no counterpart below.")


def readme_table(description):
    """Rows of a scene's README: what | value"""
    text = (description.parent / "README.md").read_text()
    return dict(re.findall(r"^\| (objects|vertices|triangles) \| ([\d,]+) \|", text, flags=re.M))


def frame_rate(map_file, *options):
    return run_json("viewer", map_file, "--benchmark", "--size", SIZE, *options)["lamp_moving"]


def measure_tables(campaign, scenes):
    kept = {}
    for name in scenes:
        both = bake(campaign, f"{name}_both", campaign.scenes[name], components=BOTH)
        rival = lambda which: view(both, campaign.work(f"{which}.exr"), "--integrator", which, "--spp", 1, "--size",
                                   SIZE)["frame_seconds"]
        kept[name] = {"whitted": rival("whitted"), "photon_map": rival("photon_map"), "baked": bake_seconds(both),
                      "lamp_moving": frame_rate(both, "--direct", "baked"),
                      "plan": campaign.plan(campaign.scenes[name]),
                      "info": run_json("bake", "info", both, "--json")}
    if not campaign.quick:
        four = campaign.scenes["temple"].parent / "temple_four_lamps.toml"
        lamps = bake(campaign, "temple_four_lamps_both", four, components=BOTH, photons=10000)
        names = re.findall(r'^\[\[light\]\]\nname = "(.*)"', four.read_text(), flags=re.M)
        off = lambda n: (word for name in names[n:] for word in ("--gain", f"{name}=0"))
        kept["lamps"] = [frame_rate(lamps, *off(n))["median_ms"] for n in range(1, 5)]
    return kept


def tables(campaign, page):
    scenes = [n for n in campaign.choose(("temple",), ("temple", "cloister")) if n in campaign.scenes]
    page.heading("Tables 3 to 7", 3)
    kept = campaign.once("thesis_tables", lambda: measure_tables(campaign, scenes))
    rows, bakes, frames = [], [], []
    for name in scenes:
        ours, m = readme_table(campaign.scenes[name]), kept[name]
        plan, info, rate = m["plan"], m["info"], m["lamp_moving"]["frames_per_second"]
        rows.append([name, *(f"{o} ({t:,})" for o, t in zip((ours["objects"], ours["vertices"], ours["triangles"]), COUNTS[name]))])
        bakes.append([name, " × ".join(map(str, plan["grid"])), f"{plan['photons_total'] // plan['light_samples']:,}",
                      plan["light_samples"], f"{m['baked']:.1f}", f"{info['cells']:,}", f"{info['bytes'] / 1e6:.1f}"])
        frames.append([name, f"{1 / m['whitted']:.1f}", f"{1 / m['photon_map']:.2f}", f"{rate:.0f}", RATE[name],
                       f"{rate / RATE[name]:.0f} ×", f"{m['photon_map'] * rate:.0f} ×", {"temple": "24 ×", "cloister": "28 ×"}[name]])
    page.table(["scene", "objects", "vertices", "triangles"], rows, "Table 3, the models: ours (the thesis').")
    page.table(["scene", "grid", "photons per position", "positions", "baked, s", "cells kept", "MB"], bakes,
               "Tables 4 and 5, the bake (both components): grid, photons and positions are the thesis'; all else is ours.")
    page.table(["scene", "Whitted, frames/s", "photon map", "map, lamp moving", "the thesis' map", "ours / thesis'",
                "map / photon map, ours", "the same, thesis"], frames,
               "Table 6, 393 × 393, a lamp moving before a still camera; the photon map with the bake's photons per position. The "
               "last two columns are quotients of frame rates, not at equal error.")
    if "lamps" in kept:
        rates = kept["lamps"]
        page.table(["lamps", "ms", "frames/s against one lamp", "thesis", "ms per added lamp"],
                   [[n + 1, f"{ms:.2f}", f"{100 * (rates[0] / ms - 1):+.1f} %", f"{LAMPS[n + 1]:+.1f} %" if n else "0 %",
                     f"{(ms - rates[0]) / max(1, n):.3f}"] for n, ms in enumerate(rates)],
                   "Table 7, temple, 393 × 393: the cost of a lamp does not depend on the picture's size, the cost of the picture does.")


def figure_27(campaign, page):
    page.heading("Figure 27: one cell over all lamp positions", 3)
    map_file = bake(campaign, "temple", campaign.scenes["temple"])
    samples = campaign.once("figure_27", lambda: run_json("bake", "samples", map_file, "--count", 5, "--json"))
    for i, e in enumerate(samples):
        order = sorted(e["samples"], key=lambda s: s["measured"])
        points = lambda value: [(n + 1, value(s), 0) for n, s in enumerate(order)]
        page.plot(f"figure_27_{i}", f"temple, cell {e['cell']}, facing {e['facing']}" + (": the worst" if i == 0 else ""),
                  "lamp positions, sorted by density", "W/m² per watt",
                  [Series("measured", points(lambda s: s["measured"]), line=False),
                   Series("cubic", points(lambda s: s["fitted"]), line=False),
                   Series("difference", points(lambda s: s["measured"] - s["fitted"]), line=False)], log_x=False, log_y=False,
                  note=f"Mean {e['mean']:.3g}, residual {e['residual']:.3g}: {e['residual'] / e['mean']:.2f} of it.")


def figures_17_18(campaign, page):
    page.heading("Figures 17 and 18: photon map against one density volume", 3)
    map_file = bake(campaign, "temple", campaign.scenes["temple"])
    work = map_file.with_name(map_file.name + ".work")
    volume = sorted(p for p in work.rglob("*.vdb") if p.name != "cells.vdb")[0]
    place = ",".join(f"{v:.6g}" for v in campaign.data["figure_27"][0]["samples"][0]["position"])
    options = ("--size", "393x393", "--spp", 4)
    photon, density = campaign.work("figure_17.png"), campaign.work("figure_18.png")
    view(map_file, photon, "--integrator", "photon_map", "--view", "indirect", "--light", f"lamp={place}", *options)
    view(map_file, density, "--view", "density", "--volume", volume, *options)
    page.slider("figures_17_18", "`temple`: indirect light of 40,000 photons by a photon map (50 nearest), and one density volume of "
                "as many photons (grey), both for one lamp position. The volume keeps to its cells and is blotchy where few photons "
                "land; the fit over all positions is what makes the map smooth.",
                photon, density, "photon map", "density volume")


def figures_28_33(campaign, page):
    page.heading("Figures 28 to 33: three lamp positions, three cameras", 3)
    for name in campaign.choose(("temple",), ("temple", "cloister")):
        if name not in campaign.scenes:
            continue
        description = campaign.scenes[name]
        map_file = bake(campaign, name, description)
        readme = (description.parent / "README.md").read_text()
        rows, labels = [], []
        for figure, camera, *lamps in re.findall(r"^\| (\d+) \| `(\w+)` \| \[(.*?)\] \| \[(.*?)\] \| \[(.*?)\] \|", readme, flags=re.M):
            row = []
            for i, lamp in enumerate(lamps):
                picture = campaign.work(f"figure_{figure}_{i}.png")
                view(map_file, picture, "--camera", camera, "--light", f"lamp={lamp.replace(' ', '')}", "--size",
                     campaign.choose("160x160", "300x300"), "--spp", 16)
                row.append(picture)
            rows.append(row)
            labels.append(f"figure {figure}, {camera}")
        page.pictures(f"{name}_figures", f"`{name}`, our map, direct light ray traced.", rows, row_labels=labels,
                      column_labels=("first", "second", "third"))


def domain_changes(description, scale):
    """Shrinks a lamp's domain about its middle."""
    found = re.search(r"domain = \{ min = \[(.*?)\], max = \[(.*?)\] \}", description.read_text())
    low, high = ([float(v) for v in g.split(",")] for g in found.groups())
    middle = [(a + b) / 2 for a, b in zip(low, high)]
    text = lambda side: "[" + ", ".join(f"{m + scale * (v - m):.6g}" for m, v in zip(middle, side)) + "]"
    return [(r"^domain = .*$", f"domain = {{ min = {text(low)}, max = {text(high)} }}"),
            (r"^position = .*$", "position = [" + ", ".join(f"{m:.6g}" for m in middle) + "]")]


def evaluated(campaign, map_file):
    return run_json("bake", "evaluate", map_file, "--json", "--lights", campaign.choose(4, 12), "--pixels", campaign.choose(500, 1500),
                    "--paths", campaign.choose(64, 192))


def error_of(campaign, name, description, **settings):
    map_file = bake(campaign, name, description, **settings)
    return evaluated(campaign, map_file)["relrmse"], map_file


def measure_observations(campaign, temple):
    say("the thesis' observations")
    few = ("--json", "--lights", 4, "--pixels", 800, "--paths", 128)
    map_file = bake(campaign, "temple", temple)
    kept = {way: run_json("bake", "evaluate", map_file, "--integrator", way, *few)["relrmse_indirect"]
            for way in ("photon_map", "polynomial")}
    if campaign.quick:
        return kept
    shrunk = {s: description_with(temple, campaign.work(f"domain_{s}.toml"), domain_changes(temple, s)) for s in (0.125, 0.25, 0.5, 1)}
    kept["domain"] = {d: [(s, error_of(campaign, f"domain_{s}_{d}", toml, degree=d, components=BOTH)[0])
                          for s, toml in shrunk.items()] for d in (2, 3)}
    kept["shadows"] = [(n, error_of(campaign, f"positions_{n}", temple, components=["direct"], samples=n)[0])
                       for n in (40, 91, 182, 364)]
    kept["shadows_small"] = error_of(campaign, "shadows_small", shrunk[0.25], components=["direct"])[0]
    kept["cells"] = []
    for count in (21, 30, 42, 60):
        error, map_file = error_of(campaign, f"cells_{count}", temple, components=BOTH, cells=count)
        kept["cells"].append((count, error, bake_seconds(map_file), frame_rate(map_file, "--direct", "baked")["median_ms"]))
    return kept


def domain_row(page, domain):
    series = [Series(f"degree {degree}", [(s, e, 0) for s, e in points]) for degree, points in domain.items()]
    page.plot("domain", "temple, all light baked: cubic against quadratic as the domain grows", "domain, of the scene's own", "error",
              series)
    gain = [q[1] / c[1] for q, c in zip(domain["2"], domain["3"])]
    return ["a cubic is better than a quadratic, the more so the larger the domain",
            f"error of the quadratic over the cubic's: {gain[0]:.3f} in the smallest domain, {gain[-1]:.3f} in the whole",
            "confirmed" if gain[-1] > 1 and gain[-1] > gain[0] else "refuted"]


def shadows_row(page, direct, small):
    page.plot("shadows", "temple, direct light from the polynomials: shadows", "lamp positions", "error of the picture",
              [Series("whole domain", [(n, e, 0) for n, e in direct]),
               Series("a quarter of it each way", [(182, small, 0)], line=False)])
    grows = direct[-1][1] > 1.05 * direct[0][1]
    return ["shadows are blurred the more positions a polynomial serves",
            f"error {direct[0][1]:.3f} with {direct[0][0]} positions, {direct[-1][1]:.3f} with {direct[-1][0]} in the same domain; "
            f"{small:.3f} in a domain of a quarter each way",
            "confirmed" if grows else "confirmed for a growing domain; more positions in one domain do not blur"
            if small < direct[-1][1] else "refuted"]


def cells_row(cells):
    return ["finer cells are better and slower",
            "; ".join(f"{n} cells: error {e:.3f}, baked {t:.1f} s, frame {m:.2f} ms" for n, e, t, m in cells),
            "confirmed" if cells[-1][1] < cells[0][1] and cells[-1][3] > cells[0][3] else "refuted"]


def observations(campaign, page):
    """Sections 4.2 to 5.1, claim by claim."""
    page.heading("The thesis' observations", 3)
    kept = campaign.once("observations", lambda: measure_observations(campaign, campaign.scenes["temple"]))
    ours, photon = kept["polynomial"], kept["photon_map"]
    rows = [["the density map is smoother than a photon map", f"error of the indirect light {ours:.3f} against {photon:.3f}, photons per position alike",
             "confirmed of the fitted map (of a single volume: see figures 17 and 18)" if ours < photon else "refuted"]]
    if not campaign.quick:
        rows += [domain_row(page, kept["domain"]), shadows_row(page, kept["shadows"], kept["shadows_small"]), cells_row(kept["cells"])]
    if "lamps" in campaign.data.get("thesis_tables", {}):
        rates = campaign.data["thesis_tables"]["lamps"]
        added = [b - a for a, b in zip(rates, rates[1:])]
        rows.append(["each lamp costs the same", "ms added by the second, third and fourth lamp: " + ", ".join(f"{a:.3f}" for a in added),
                     "confirmed within the measurement's scatter" if max(added) < 3 * max(0.01, min(added)) else "refuted: see the figures"])
    page.table(["the thesis says", "here", "so"], rows)


def section(campaign, page):
    page.heading("The thesis' tables and figures")
    say("the thesis' tables and figures")
    page.text(NOTE)
    tables(campaign, page)
    observations(campaign, page)
    figure_27(campaign, page)
    figures_17_18(campaign, page)
    figures_28_33(campaign, page)
