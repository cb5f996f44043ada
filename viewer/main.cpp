// SPDX-License-Identifier: GPL-3.0-or-later
#include <pim_version.h>

#include <CLI/CLI.hpp>

#include "common/core/command_line.h"
#include "common/core/error.h"
#include "common/core/file.h"
#include "viewer/benchmark.h"
#include "viewer/headless.h"
#include "viewer/window/application.h"

namespace {

using namespace pim;

void add_state_options(CLI::App& app, Arguments& a) {
    app.add_option("--light", a.lights, "NAME=x,y,z: put a lamp there (m)")->allow_extra_args(false);
    app.add_option("--gain", a.gains, "NAME=g: multiply a lamp's power; 0 turns it off")
        ->allow_extra_args(false);
    app.add_option("--colour", a.colours, "NAME=r,g,b: multiply a lamp's power channel by channel")
        ->allow_extra_args(false);
    app.add_option("--camera", a.camera, "a camera of the scene (default: its first)");
    app.add_option("--eye", a.eye, "x,y,z: where the camera stands (m)");
    app.add_option("--target", a.target, "x,y,z: where it looks");
    app.add_option("--up", a.up, "x,y,z: what is up in the picture");
    app.add_option("--fov", a.fov, "vertical field of view, degrees");
    app.add_option("--size", a.size, "WxH in pixels (default: the camera's; with panels 1280x800)");
    app.add_option("--direct", a.direct, "traced, baked or none (default: baked where the map holds it)");
    app.add_option("--indirect", a.indirect, "baked or none");
    app.add_option("--view", a.view,
                   "radiance, irradiance, direct, indirect, density, cells, normals, albedo or trust");
    app.add_option("--exposure", a.exposure, "of PNG and window, in stops, or auto");
    app.add_option("--tone-curve", a.tone_curve, "of PNG and window: none, reinhard or aces");
    app.add_flag("--show-lamps", a.show_lamps, "rectangular lamps are seen");
    app.add_option("--setup", a.setup, "a lighting set-up saved in the window (TOML)");
}

void add_job_options(CLI::App& app, Arguments& a) {
    app.add_option("--output", a.output, "picture to write: .exr (linear) or .png (tone-mapped)");
    app.add_option("--integrator", a.integrator,
                   "polynomial, photon_map, whitted (direct light only) or path (the reference)")
        ->capture_default_str();
    app.add_option("--photons", a.photons, "of the photon map, per lamp (default: as baked)")
        ->check(CLI::Range(uint64_t{1}, kMostPhotons));
    app.add_option("--nearest", a.nearest, "of the photon map: photons per estimate (default: 50)")
        ->check(CLI::Range(2, 100000));
    app.add_option("--gather", a.gather, "of the photon map: final gathering rays per hit (default: none)")
        ->check(CLI::Range(0, 1 << 20));
    app.add_option("--volume", a.volume, "a density volume of the work folder, for --view density");
    app.add_option("--spp", a.samples, "samples per pixel")
        ->check(CLI::Range(1, 1 << 20))
        ->capture_default_str();
    app.add_option("--seed", a.seed, "of the random numbers: another one, other noise")
        ->capture_default_str();
    app.add_option("--stats", a.stats, "timings and sizes as JSON");
    app.add_flag("--ui", a.panels, "the picture with the window's panels, without a display");
    app.add_option("--path", a.paths,
                   "film: CSV of lamps' keys or camera keys (may be given twice); --output frame_%04d.png")
        ->allow_extra_args(false);
    app.add_option("--fps", a.frames_per_second, "of a film")->capture_default_str();
    app.add_flag("--overwrite", a.overwrite, "a film begins anew");
    app.add_option("--probe", a.probe, "CSV of points x,y,z,nx,ny,nz: writes their irradiance to stdout");
    app.add_option("--export-scene", a.exported,
                   "a folder for geometry, materials, lamps and camera as JSON and EXR, for other renderers");
    app.add_option("--export-ptm", a.ptm,
                   "a polynomial texture map (.ptm) of the view under one lamp; its error as JSON to stdout");
    app.add_option("--ptm-lamp", a.ptm_lamp, "the lamp that moves in it (default: the first that shines)");
    app.add_flag("--benchmark", a.benchmark, "frame times as JSON to stdout");
    app.add_option("--vector-unit", a.vector_unit, "auto, plain, avx2 or avx512")->capture_default_str();
}

void add_options(CLI::App& app, Arguments& a, CommonOptions& common) {
    app.set_version_flag("--version", std::string("viewer ") + kVersion);
    app.add_option("FILE.vdb", a.map, "a map that `bake` made")->required();
    app.add_option("--geometry", a.geometry, "the geometry file, where it has moved");
    add_state_options(app, a);
    add_job_options(app, a);
    app.add_option("--threads", common.threads, "threads (default: all cores)")->check(CLI::Range(1, 4096));
    app.add_flag("--quiet", common.quiet, "no progress, no messages but errors");
    app.add_option("--log-level", common.log_level, "debug, info, warning, error or off");
}

// An option that the job would not heed is refused.
void check_jobs(const Arguments& a) {
    const bool measures = a.benchmark || a.probe, film = !a.paths.empty() && !a.output.empty() && !a.panels;
    const auto refuse = [](bool given, const char* what) {
        if (given) throw UsageError(what);
    };
    refuse(a.benchmark && a.probe, "--benchmark, --probe: one at a time");
    refuse(measures && !a.output.empty(), "--output: --benchmark and --probe write to stdout");
    refuse(measures && !a.paths.empty(), "--path: belongs to a film or the window");
    refuse(a.ptm && (measures || a.exported || !a.output.empty() || !a.paths.empty() || a.panels),
           "--export-ptm: without --output, --ui, --path, --probe, --benchmark and --export-scene only");
    refuse(!a.ptm && !a.ptm_lamp.empty(), "--ptm-lamp: of --export-ptm only");
    const bool still = !measures && !film && !a.panels && !a.output.empty();
    refuse(!still && !a.ptm && a.integrator != "polynomial",
           "--integrator: of a single picture only (--output FILE, without --ui)");
    refuse(!still && a.volume, "--volume: of a single picture without --ui only");
    refuse(!still && !a.ptm && a.stats, "--stats: of a single picture without --ui only");
    refuse(!film && a.overwrite, "--overwrite: of a film only");
    parse_vector_unit(a);
}

void run(const Arguments& a) {
    check_jobs(a);
    check_input(a.map);  // before a window opens
    if (a.benchmark) return print_benchmark(a);
    if (a.probe) return print_probe(a);
    if (a.exported) return write_scene(a);
    if (a.ptm) return write_texture_map(a);
    if (a.output.empty() && a.panels)
        throw UsageError("--ui: name a picture to write with --output SHOT.png");
    if (a.panels) return render_panels(a);
    if (!a.paths.empty() && !a.output.empty()) return render_film(a);
    if (!a.output.empty()) return render_still(a);
    run_window(a);
}

}  // namespace

int main(int argc, char** argv) {
    CLI::App app{"viewer: a baked scene with its lamps moved; without --output it opens a window"};
    Arguments arguments;
    CommonOptions common;
    add_options(app, arguments, common);
    try {
        app.parse(argc, argv);
    } catch (const CLI::ParseError& e) {
        return app.exit(e) == 0 ? kExitDone : kExitUsage;
    }
    return run_program(common, [&] { run(arguments); });
}
