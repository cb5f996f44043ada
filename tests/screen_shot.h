// SPDX-License-Identifier: GPL-3.0-or-later
// Pictures of a screen as 8-bit values, and how much two of them differ.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstring>
#include <ostream>
#include <string>

#include "common/core/error.h"
#include "common/core/image.h"
#include "viewer/display/rgba_image.h"

namespace pim {

// Big-endian words at the head of an X window dump (XWDFile.h).
inline uint32_t dump_word(const std::string& dump, std::size_t index) {
    uint32_t value = 0;
    for (std::size_t i = 0; i < 4; ++i) value = value << 8 | uint8_t(dump.at(4 * index + i));
    return value;
}

// An X window dump of 32 bits a pixel, blue first, as Xvfb keeps of its screen. Throws Error for others.
inline Rgba8Image parse_dump(const std::string& dump) {
    const auto word = [&](std::size_t index) { return dump_word(dump, index); };
    if (word(1) != 7 || word(7) != 0 || word(11) != 32) throw Error("another kind of window dump");
    const std::size_t start = word(0) + 12 * word(19), line = word(12);  // after header and colours
    Rgba8Image image(int(word(4)), int(word(5)));
    for (int y = 0; y < image.height; ++y)
        for (int x = 0; x < image.width; ++x) {
            const char* pixel = &dump.at(start + line * std::size_t(y) + 4 * std::size_t(x));
            for (int c = 0; c < 3; ++c) image.at(x, y)[c] = uint8_t(pixel[2 - c]);
            image.at(x, y)[3] = 255;
        }
    return image;
}

// The part must lie inside.
inline Rgba8Image cut_out(const Rgba8Image& image, const Imath::V2i& place, const Imath::V2i& size) {
    Rgba8Image part(size.x, size.y);
    for (int y = 0; y < size.y; ++y)
        std::memcpy(part.at(0, y), image.at(place.x, place.y + y), 4 * std::size_t(size.x));
    return part;
}

inline Rgba8Image read_png(const std::filesystem::path& file) {
    const Image image = read_image(file);
    Rgba8Image bytes(image.width, image.height);
    for (int y = 0; y < image.height; ++y)
        for (int x = 0; x < image.width; ++x) {
            for (int c = 0; c < 3; ++c)
                bytes.at(x, y)[c] = uint8_t(std::lround(255 * srgb_encode(image.at(x, y)[c])));
            bytes.at(x, y)[3] = 255;
        }
    return bytes;
}

struct PixelRegion {
    int left = 0, top = 0, right = 0, bottom = 0;  // pixels; right and bottom are outside
    bool contains(int x, int y) const { return x >= left && x < right && y >= top && y < bottom; }
};

// Of 8-bit values. As it stands: of pictures of two sizes.
struct Difference {
    int largest = 256;
    double mean = 256, share_above_8 = 1;  // of all values; of pixels
};

inline std::ostream& operator<<(std::ostream& out, const Difference& d) {
    return out << "largest difference " << d.largest << " of 255, mean " << d.mean << ", more than 8 in "
               << 100 * d.share_above_8 << " % of pixels";
}

inline Difference compare(const Rgba8Image& a, const Rgba8Image& b, const PixelRegion& left_out = {}) {
    if (a.width != b.width || a.height != b.height) return {};
    int largest = 0;
    double sum = 0, count = 0, above = 0;
    for (int y = 0; y < a.height; ++y)
        for (int x = 0; x < a.width; ++x) {
            if (left_out.contains(x, y)) continue;
            int most = 0;
            for (int c = 0; c < 3; ++c) {
                const int difference = std::abs(int(a.at(x, y)[c]) - int(b.at(x, y)[c]));
                most = std::max(most, difference);
                sum += difference;
            }
            largest = std::max(largest, most);
            above += most > 8;
            ++count;
        }
    return {largest, sum / (3 * count), above / count};
}

}  // namespace pim
