# SPDX-License-Identifier: GPL-3.0-or-later
"""The focus under a glass ball: light finer than a cell."""
from ..tools import bake, say, view, run_json

SIZE = "320x320"


def section(campaign, page):
    if "caustic" not in campaign.scenes:
        return
    page.heading("A caustic")
    say("caustic")
    map_file = bake(campaign, "caustic", campaign.scenes["caustic"])
    pictures = {name: campaign.work(f"caustic_{name}.png") for name in ("path", "polynomial", "photon_map")}
    exposure = view(map_file, pictures["path"], "--integrator", "path", "--spp", campaign.choose(64, 512), "--size",
                    SIZE)["exposure"]
    view(map_file, pictures["polynomial"], "--spp", 16, "--size", SIZE, "--exposure", exposure)
    view(map_file, pictures["photon_map"], "--integrator", "photon_map", "--photons", campaign.choose(400000, 2000000), "--spp", 4,
         "--size", SIZE, "--exposure", exposure)
    photons = {"polynomial": (), "photon_map": ("--photons", campaign.choose(400000, 2000000))}
    errors = campaign.once("caustic", lambda: {
        name: run_json("bake", "evaluate", map_file, "--json", "--lights", campaign.choose(2, 6), "--pixels", 1000, "--paths",
                       campaign.choose(64, 256), "--integrator", name, *options) for name, options in photons.items()})
    page.text("Light of a point lamp that has passed glass: photons find it and the map holds it as indirect light; the eye's paths "
              "cannot find it, so `path` adds photons connected to the camera. A caustic is finer than a cell, so the map blurs it: "
              f"error {errors['polynomial']['relrmse']:.3f} (photon map with {campaign.choose('400,000', '2,000,000')} photons and a "
              f"caustic map of its own: {errors['photon_map']['relrmse']:.3f}).")
    page.slider("caustic_map", "Our map and the reference.", pictures["polynomial"], pictures["path"], "our map", "path tracing")
    page.slider("caustic_photons", "A photon map and the reference.", pictures["photon_map"], pictures["path"], "photon map",
                "path tracing")
