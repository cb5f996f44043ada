// SPDX-License-Identifier: GPL-3.0-or-later
// What to show of a baked scene, and the image of it. No OpenGL here.
#pragma once

#include <filesystem>
#include <optional>

#include "common/map/baked_scene.h"
#include "common/render/map_radiance.h"

namespace pim {

enum class Integrator { polynomial, path };
enum class View { radiance, irradiance, density, cells };

struct PictureOptions {
    Camera camera;
    Imath::V2i size{640, 480};
    std::vector<LightState> lights;
    DirectLight direct = DirectLight::traced;
    bool indirect = true;
    bool show_lamps = false;
    Integrator integrator = Integrator::polynomial;
    View view = View::radiance;
    std::optional<std::filesystem::path> volume;  // a density volume to show in place of the map
    int samples = 4;                              // per pixel
};

// Linear: radiance in W/(m² sr), or irradiance and density in W/m² (grey), or false colours of the cells.
// Throws Error.
Image render_picture(const BakedScene& baked, const RayCaster& caster, const PictureOptions& options);

// Patches' irradiance of one density volume, all its components together, as the mean of its channels under
// lamps of 1 W; the volume must belong to the map. Throws Error.
std::vector<Rgb> read_volume(const IlluminationMap& map, const std::filesystem::path& file);

}  // namespace pim
