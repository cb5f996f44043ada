# SPDX-License-Identifier: GPL-3.0-or-later
"""Where the error is: noise, polynomial, leak, grid."""
import json
import subprocess

from ..tools import bake, run, say

PARTS = ("noise", "polynomial", "leak", "grid")


def shares(parts):
    """The whole's squares and cross terms, in per cent of it."""
    whole, squares = parts["relative_square"], parts["relative_squares"]
    percent = 100 / whole if whole > 0 else 0
    own = [squares[j][j] * percent for j in range(4)]
    cross = [2 * squares[j][k] * percent for j in range(4) for k in range(j + 1, 4)]
    return own, cross


def signed_png(exr, png, scale):
    """Grey is 0, white more, black less."""
    subprocess.run(["oiiotool", exr, "--mulc", str(scale), "--addc", "0.5", "--clamp:min=0:max=1", "-d", "uint8", "-o", png],
                   check=True, capture_output=True)


def lit_png(exr, png, scale):
    subprocess.run(["oiiotool", exr, "--mulc", str(scale), "--colorconvert", "linear", "sRGB", "--clamp:min=0:max=1", "-d",
                    "uint8", "-o", png], check=True, capture_output=True)


def mean_of(exr):
    done = subprocess.run(["oiiotool", "--stats", exr], check=True, capture_output=True, text=True).stdout
    line = next(l for l in done.splitlines() if "Stats Avg" in l)
    values = [float(v) for v in line.split(":")[1].split("(")[0].split()[:3]]
    return sum(values) / 3


def pictures(campaign, page, name, map_file):
    """Maps of the parts over the first camera's picture, at the first unseen lamp position."""
    folder = campaign.work(f"{name}_parts")
    folder.mkdir(exist_ok=True)
    cameras = campaign.scenes[name].read_text().count("[[camera]]")
    run("bake", "evaluate", map_file, "--parts", "--pictures", folder, "--lights", 1, "--pixels", 40000 * cameras, "--paths",
        campaign.choose(32, 128))
    camera = next(folder.glob("*_map.exr")).name.removesuffix("_map.exr")
    mean = mean_of(folder / f"{camera}_reference.exr")
    for what in ("map", "reference"):
        lit_png(folder / f"{camera}_{what}.exr", folder / f"{what}.png", 0.35 / mean)
    for part in PARTS:
        signed_png(folder / f"{camera}_{part}.exr", folder / f"{part}.png", 2 / mean)
    page.slider(f"{name}_map_or_paths", f"`{name}`, camera `{camera}`, a lamp position that no fit has seen.", folder / "map.png",
                folder / "reference.png", "our map", "path tracing")
    page.pictures(f"{name}_parts", f"`{name}`: the parts of the error over the same picture; grey is 0, black and white a quarter of "
                  "the picture's mean and more.", [[folder / f"{part}.png" for part in PARTS]], column_labels=PARTS)


def worst_row(w):
    most = max(w["steps"], key=lambda part: sum(v * v for v in w["steps"][part]))
    where = f"{w.get('object', '')} ({w.get('material', '')})"
    return [w["camera"], f"({w['place'][0]:.3f}, {w['place'][1]:.3f})", f"{w['error_over_rms']:.1f}", most, where,
            f"{w.get('lamp_distance', 0):.2f}"]


def measure(campaign, name, description, options):
    map_file = bake(campaign, name, description)
    say(f"{name}: parts of the error")
    return json.loads(run("bake", "evaluate", map_file, "--parts", "--json", *options))


def section(campaign, page):
    page.heading("Where the error is")
    page.text("Controlled experiments at unseen lamp positions, along the same camera rays. From our picture to the truth in four "
              "steps: *noise* goes (the mean of maps baked with other random numbers), the *polynomial* goes (a density volume traced "
              "for the very position), the *leak* goes (of the same photons only those count that landed where the surface looked at "
              "can see them), the *grid* goes (path tracing). Each experiment runs twice with independent random numbers, so that the "
              "squares are unbiased (and may come out slightly negative); squares and cross terms sum to the whole by construction."
              .replace("*", "**"))
    rows, cross_rows, worst = [], [], {}
    for name, description in campaign.scenes.items():
        if campaign.quick and name != "temple":
            continue
        options = ("--lights", campaign.choose(3, 6), "--pixels", campaign.choose(500, 1500), "--paths", campaign.choose(64, 192))
        if campaign.quick:
            options += ("--own-photons", 4)
        parts = campaign.once(f"parts_{name}", lambda: measure(campaign, name, description, options))
        own, cross = shares(parts)
        rows.append([name, f"{max(0, parts['relative_square']) ** 0.5:.4f}",
                     *(f"{share:.0f} % ± {100 * c / parts['relative_square']:.0f}" if parts["relative_square"] > 0 else "—"
                       for share, c in zip(own, parts["confidence"])),
                     *(f"{parts['relrms'][part]:.4f}" for part in PARTS)])
        cross_rows.append([name, *(f"{value:.1f} %" for value in cross), f"{sum(own) + sum(cross):.6f} %"])
        worst[name] = parts["worst"][:4]
    page.table(["scene", "whole", *(f"{p}, share" for p in PARTS), *(f"{p}, alone" for p in PARTS)], rows,
               "Shares of the squared error (± 95 % over positions) and each part's own relative rms.")
    pairs = [f"2 · {PARTS[j]} · {PARTS[k]}" for j in range(4) for k in range(j + 1, 4)]
    page.table(["scene", *pairs, "sum of all"], cross_rows, "Cross terms, and the sum with the shares above.")
    page.table(["scene", "camera", "place", "times the rms", "mostly", "what is seen", "m from the lamp"],
               [[name, *worst_row(w)] for name, list_ in worst.items() for w in list_], "The worst pixels, and which part makes them.")
    for name in campaign.choose(("temple",), ("temple", "cornell", "cloister")):
        if name in campaign.scenes:
            pictures(campaign, page, name, bake(campaign, name, campaign.scenes[name]))
