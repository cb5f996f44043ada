// SPDX-License-Identifier: GPL-3.0-or-later
// The cells themselves: each patch in one flat shade, dots at the centres of the cells (the thesis' figure
// 15).
#pragma once

#include "common/render/frame.h"
#include "common/render/map_radiance.h"

namespace pim {

Image render_cells(const Moment& moment, const Camera& camera, const FrameOptions& options);

}  // namespace pim
