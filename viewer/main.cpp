// SPDX-License-Identifier: GPL-3.0-or-later
#include <pim_version.h>

#include <CLI/CLI.hpp>

#include "common/core/command_line.h"
#include "common/core/error.h"
#include "viewer/headless.h"

namespace {

using namespace pim;

void add_options(CLI::App& app, HeadlessOptions& o, CommonOptions& common) {
    app.set_version_flag("--version", std::string("viewer ") + kVersion);
    app.add_option("FILE.vdb", o.map, "a map that `bake` made")->required();
    app.add_option("--geometry", o.geometry, "the geometry file, where it has moved");
    app.add_option("--output", o.output, "picture to write: .exr (linear) or .png (tone-mapped)");
    app.add_option("--light", o.lights, "NAME=x,y,z: put a lamp there (m)")->allow_extra_args(false);
    app.add_option("--gain", o.gains, "NAME=g: multiply a lamp's power; 0 turns it off")
        ->allow_extra_args(false);
    app.add_option("--camera", o.camera, "a camera of the scene (default: its first)");
    app.add_option("--size", o.size, "WxH in pixels (default: the camera's)");
    app.add_option("--direct", o.direct, "traced, baked or none (default: baked where the map holds it)");
    app.add_option("--indirect", o.indirect, "baked or none");
    app.add_option("--integrator", o.integrator, "polynomial or path (the reference)")->capture_default_str();
    app.add_option("--view", o.view, "radiance, irradiance, density or cells")->capture_default_str();
    app.add_option("--volume", o.volume, "a density volume of the work folder, for --view density");
    app.add_option("--spp", o.samples, "samples per pixel")
        ->check(CLI::Range(1, 1 << 20))
        ->capture_default_str();
    app.add_option("--exposure", o.exposure, "of PNG, in stops, or auto")->capture_default_str();
    app.add_flag("--show-lamps", o.show_lamps, "rectangular lamps are seen");
    app.add_option("--stats", o.stats, "timings and sizes as JSON");
    app.add_option("--threads", common.threads, "threads (default: all cores)")->check(CLI::Range(1, 4096));
    app.add_flag("--quiet", common.quiet, "no progress, no messages but errors");
    app.add_option("--log-level", common.log_level, "debug, info, warning, error or off");
}

}  // namespace

int main(int argc, char** argv) {
    CLI::App app{"viewer: pictures of a baked scene with its lamps moved"};
    HeadlessOptions options;
    CommonOptions common;
    add_options(app, options, common);
    try {
        app.parse(argc, argv);
    } catch (const CLI::ParseError& e) {
        return app.exit(e) == 0 ? kExitDone : kExitUsage;
    }
    return run_program(common, [&] {
        if (options.output.empty())
            throw UsageError(
                "there is no window yet: name a picture to write with --output FRAME.png or .exr");
        render_headless(options);
    });
}
