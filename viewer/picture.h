// SPDX-License-Identifier: GPL-3.0-or-later
// The picture of a state, ray by ray, as exact as the map allows. No OpenGL here.
#pragma once

#include <filesystem>
#include <optional>

#include "common/core/image.h"
#include "common/map/baked_scene.h"
#include "common/render/map_radiance.h"
#include "common/render/photon_radiance.h"
#include "viewer/tone/false_colour.h"
#include "viewer/view_state.h"

namespace pim {

// How light is found: from the map, or by one of its rivals, which take from the file no more than the scene.
enum class Integrator { polynomial, photon_map, whitted, path };
inline bool is_rival(Integrator i) { return i == Integrator::photon_map || i == Integrator::whitted; }

struct PictureOptions {
    ViewState state;
    Imath::V2i size{640, 480};
    Integrator integrator = Integrator::polynomial;
    std::optional<std::filesystem::path> volume;  // a density volume to show in place of the map
    int samples = 4;                              // per pixel
    uint64_t seed = 1;
    PhotonMapOptions photon_map;
};

// Where the time of a picture went, s: shooting photons and building trees (0 but for the photon map), and
// the rays from the camera.
struct PictureTimes {
    double total = 0, photons = 0, trees = 0, render = 0;
};

struct Picture {
    Image image;
    PictureTimes seconds;
    std::size_t cut_values = 0;  // of the map's patches and channels: below zero, shown as 0
};

// Linear: radiance in W/(m² sr); irradiance and density (grey) in W/m²; trust (residual over irradiance);
// albedo; normals as (n + 1)/2; false colours of the cells. Throws Error.
Picture render_picture(const BakedScene& baked, const RayCaster& caster, const PictureOptions& options);

// Says in the log what light a picture by that integrator would lack.
void warn_of_missing_light(const BakedScene& baked, const PictureOptions& options);

// Views that do not depend on the lamps.
Image render_unlit(View view, const Scene& scene, const IlluminationMap& map, const RayCaster& caster,
                   const Camera& camera, const Imath::V2i& size, int samples);

// Patches' irradiance of one density volume, all its components together, as the mean of its channels under
// lamps of 1 W. Throws Error: damaged, or of another map.
std::vector<Rgb> read_volume(const IlluminationMap& map, const std::filesystem::path& file);

// Of the false colours in which views that measure are shown; none for the others.
std::optional<Scale> fitting_scale(View view, const Image& linear);

// From linear values to a display.
struct Exposure {
    float factor = 1;
    std::optional<Scale> scale = {};  // of false colours; absent: fits the picture
};

// What a display shows of a linear picture of that view, sRGB still to be applied: views that measure are in
// false colours, lit ones exposed and curved.
Image displayed(const Image& linear, const ViewState& state, const Exposure& exposure);

// .exr: the linear picture; .png: what a display shows. Throws Error.
void write_picture(const std::filesystem::path& path, const Image& linear, const ViewState& state,
                   const Exposure& exposure);

}  // namespace pim
