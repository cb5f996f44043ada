// SPDX-License-Identifier: GPL-3.0-or-later
// A finished picture as a display shows it: sRGB-encoded bytes, no arithmetic left to do.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace pim {

struct Rgba8Image {
    int width = 0, height = 0;
    std::vector<uint8_t> rgba;  // row by row from the top, 4 bytes a pixel

    Rgba8Image() = default;
    Rgba8Image(int w, int h) : width(w), height(h), rgba(std::size_t(w) * std::size_t(h) * 4) {}
    uint8_t* at(int x, int y) { return &rgba[4 * (std::size_t(y) * std::size_t(width) + std::size_t(x))]; }
    const uint8_t* at(int x, int y) const {
        return &rgba[4 * (std::size_t(y) * std::size_t(width) + std::size_t(x))];
    }
};

}  // namespace pim
