// SPDX-License-Identifier: GPL-3.0-or-later
// The picture of a state, ray by ray, as exact as the map allows. No OpenGL here.
#pragma once

#include <filesystem>
#include <optional>

#include "common/core/image.h"
#include "common/map/baked_scene.h"
#include "common/render/map_radiance.h"
#include "viewer/view_state.h"

namespace pim {

enum class Integrator { polynomial, path };

struct PictureOptions {
    ViewState state;
    Imath::V2i size{640, 480};
    Integrator integrator = Integrator::polynomial;
    std::optional<std::filesystem::path> volume;  // a density volume to show in place of the map
    int samples = 4;                              // per pixel
    uint64_t seed = 1;
};

// Linear: radiance in W/(m² sr); irradiance and density (grey) in W/m²; trust (residual over irradiance);
// albedo; normals as (n + 1)/2; false colours of the cells. Throws Error.
Image render_picture(const BakedScene& baked, const RayCaster& caster, const PictureOptions& options);

// Views that do not depend on the lamps.
Image render_unlit(View view, const Scene& scene, const IlluminationMap& map, const RayCaster& caster,
                   const Camera& camera, const Imath::V2i& size, int samples);

// Patches' irradiance of one density volume, all its components together, as the mean of its channels under
// lamps of 1 W. Throws Error: damaged, or of another map.
std::vector<Rgb> read_volume(const IlluminationMap& map, const std::filesystem::path& file);

// What a display shows of a linear picture of that view, sRGB still to be applied: views that measure are in
// false colours, lit ones exposed and curved.
Image displayed(const Image& linear, const ViewState& state, float exposure);

// .exr: the linear picture; .png: what a display shows. Throws Error.
void write_picture(const std::filesystem::path& path, const Image& linear, const ViewState& state,
                   float exposure);

}  // namespace pim
