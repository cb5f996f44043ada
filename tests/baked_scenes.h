// SPDX-License-Identifier: GPL-3.0-or-later
// Scenes baked for tests, and path-traced irradiance on their surfaces.
#pragma once

#include <gtest/gtest.h>
#include <unistd.h>

#include <map>
#include <memory>

#include "bake/bake.h"
#include "common/core/log.h"
#include "common/core/sampling.h"
#include "common/map/baked_scene.h"
#include "common/render/path_radiance.h"

namespace pim {

namespace fs = std::filesystem;

// A folder of this process, removed at its end.
inline const fs::path& test_folder() {
    struct Folder {
        fs::path path = fs::temp_directory_path() / ("pim_test_" + std::to_string(getpid()));
        Folder() { fs::create_directories(path); }
        ~Folder() { fs::remove_all(path); }
    };
    static const Folder folder;
    return folder.path;
}

// A description, baked.
struct Baked {
    BakedScene baked;
    RayCaster caster;
    fs::path map_file;

    Baked(const fs::path& description, const fs::path& map)
        : baked(bake(description, map)), caster(baked.scene.geometry, InstructionSet::best), map_file(map) {}

    static BakedScene bake(const fs::path& description, const fs::path& map) {
        set_log_level("error");
        bake_run(description, {.output = map, .overwrite = true});
        return read_baked_scene(map, {});
    }
};

// A scene of data/, baked once for all tests of one program.
inline Baked& baked_scene(const std::string& name) {
    static std::map<std::string, std::unique_ptr<Baked>> all;
    auto& one = all[name];
    if (!one)
        one = std::make_unique<Baked>(fs::path(PIM_DATA) / name / (name + ".toml"),
                                      test_folder() / (name + ".vdb"));
    return *one;
}

inline std::vector<LightState> lamps_at_start(const Scene& scene) {
    std::vector<LightState> states;
    for (const Light& light : scene.lights) states.push_back({light.position, light.power});
    return states;
}

// Indirect irradiance by paths: E = pi mean(L) over cosine-distributed directions; and its standard error.
struct PathIrradiance {
    double mean = 0, error = 0;
};
inline PathIrradiance path_irradiance(const Baked& b, const PathScene& paths, const SurfacePoint& s,
                                      int count, RandomStream& random) {
    double sum = 0, squares = 0;
    for (int i = 0; i < count; ++i) {
        const float u1 = random.next(), u2 = random.next();
        const Vec3 out = Frame(s.shading_normal).to_world(sample_cosine_hemisphere(u1, u2));
        if (out.dot(s.geometric_normal) <= 0) continue;
        const double e =
            kPi *
            mean_channel(path_radiance(paths, {s.leave(out, b.caster.surface_offset()), out}, random).total);
        sum += e, squares += e * e;
    }
    const double mean = sum / count;
    return {mean, std::sqrt(std::max(0.0, squares / count - mean * mean) / count)};
}

}  // namespace pim
