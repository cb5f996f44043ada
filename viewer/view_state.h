// SPDX-License-Identifier: GPL-3.0-or-later
// All that decides a picture of a baked scene: what a person sets in the window, what a set-up file keeps,
// what a path animates.
#pragma once

#include <vector>

#include "common/map/illumination_map.h"
#include "common/render/map_radiance.h"
#include "common/scene/scene.h"

namespace pim {

// What of the scene is shown. `direct` and `indirect`: radiance of that part alone. `density`: irradiance of
// the map as grey (the thesis' figure 16). `trust`: the map's residual over its irradiance.
enum class View { radiance, irradiance, direct, indirect, density, cells, normals, albedo, trust };

// To the display: none (cut at 1), Reinhard's x / (1 + x), or Narkowicz' fit of the ACES curve.
enum class ToneCurve { none, reinhard, aces };

struct LampControl {
    Vec3 position{0};  // local, inside the lamp's domain
    bool on = true, solo = false;
    float gain = 1;  // >= 0
    Rgb colour{1};   // times the described power, channel by channel
    bool operator==(const LampControl&) const = default;
};

struct ViewState {
    std::vector<LampControl> lamps;  // in the scene's order
    Camera camera;
    View view = View::radiance;
    DirectLight direct = DirectLight::traced;
    bool indirect = true;
    bool show_lamps = false;
    bool automatic_exposure = true;
    float exposure = 0;  // stops; counts where not automatic
    ToneCurve tone_curve = ToneCurve::none;
    bool operator==(const ViewState&) const = default;
};

// As the scene stands when it is opened; direct light baked where the map holds it.
ViewState initial_state(const Scene& scene, const IlluminationMap& map);

// What the view shows of the light.
DirectLight direct_part(const ViewState& state);
bool indirect_part(const ViewState& state);
bool shows_radiance(View view);  // radiance, direct, indirect
bool is_unlit(View view);        // does not depend on the lamps: cells, normals, albedo

// Lamps as they shine: power · gain · colour; 0 for lamps that are off, or not solo where another one is.
std::vector<LightState> shining(const Scene& scene, const ViewState& state);

}  // namespace pim
