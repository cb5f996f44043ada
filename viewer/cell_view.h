// SPDX-License-Identifier: GPL-3.0-or-later
// The cells themselves: each patch in one flat shade, dots at the centres of the cells (the thesis' figure
// 15).
#pragma once

#include "common/map/illumination_map.h"
#include "common/render/frame.h"
#include "common/transport/surface.h"

namespace pim {

Image render_cells(const Scene& scene, const IlluminationMap& map, const RayCaster& caster,
                   const Camera& camera, const FrameOptions& options);

}  // namespace pim
