// SPDX-License-Identifier: GPL-3.0-or-later
#include "viewer/view_state.h"

#include <algorithm>

namespace pim {

ViewState initial_state(const Scene& scene, const IlluminationMap& map) {
    ViewState state;
    for (const Light& light : scene.lights) state.lamps.push_back({.position = light.position});
    state.camera = scene.cameras.front();
    state.direct = map.has(Component::direct) ? DirectLight::baked : DirectLight::traced;
    state.indirect = map.has(Component::indirect);
    return state;
}

DirectLight direct_part(const ViewState& state) {
    if (state.view == View::indirect) return DirectLight::none;
    const bool map_alone = state.view == View::density || state.view == View::trust;
    return map_alone && state.direct == DirectLight::traced ? DirectLight::none : state.direct;
}

bool indirect_part(const ViewState& state) { return state.indirect && state.view != View::direct; }

bool shows_radiance(View view) {
    return view == View::radiance || view == View::direct || view == View::indirect;
}

bool is_unlit(View view) { return view == View::cells || view == View::normals || view == View::albedo; }

std::vector<LightState> shining(const Scene& scene, const ViewState& state) {
    const bool any_solo = std::ranges::any_of(state.lamps, &LampControl::solo);
    std::vector<LightState> lights;
    for (std::size_t l = 0; l < scene.lights.size(); ++l) {
        const LampControl& lamp = state.lamps[l];
        const bool shines = lamp.on && (lamp.solo || !any_solo);
        lights.push_back({lamp.position, shines ? scene.lights[l].power * lamp.colour * lamp.gain : Rgb(0)});
    }
    return lights;
}

}  // namespace pim
