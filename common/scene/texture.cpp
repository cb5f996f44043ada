// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/scene/texture.h"

#include <cmath>

namespace pim {

Rgb sample_texture(const Image& texture, const Vec2& uv) {
    const float x = (uv.x - std::floor(uv.x)) * float(texture.width) - 0.5f;
    const float y = (1.0f - (uv.y - std::floor(uv.y))) * float(texture.height) - 0.5f;
    if (!std::isfinite(x) || !std::isfinite(y)) return Rgb(0);
    const int x0 = int(std::floor(x)), y0 = int(std::floor(y));
    const float fx = x - float(x0), fy = y - float(y0);
    const auto texel = [&](int i, int j) {
        const int w = texture.width, h = texture.height;
        return texture.at((i % w + w) % w, (j % h + h) % h);
    };
    return (texel(x0, y0) * (1 - fx) + texel(x0 + 1, y0) * fx) * (1 - fy) +
           (texel(x0, y0 + 1) * (1 - fx) + texel(x0 + 1, y0 + 1) * fx) * fy;
}

}  // namespace pim
