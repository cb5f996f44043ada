// SPDX-License-Identifier: GPL-3.0-or-later
// Pictures: linear RGB in memory, EXR (linear) or PNG (sRGB) on disk.
#pragma once

#include <filesystem>
#include <vector>

#include "common/core/vector.h"

namespace pim {

struct Image {
    int width = 0, height = 0;
    std::vector<Rgb> pixels;  // row by row from the top

    Image() = default;
    Image(int w, int h) : width(w), height(h), pixels(std::size_t(w) * h, Rgb(0)) {}
    Rgb& at(int x, int y) { return pixels[std::size_t(y) * width + x]; }
    const Rgb& at(int x, int y) const { return pixels[std::size_t(y) * width + x]; }
};

// The factor that brings the picture's 98th percentile of luminance to 0.9; 1 for a black picture.
float automatic_exposure(const Image& image);

float srgb_encode(float linear);  // IEC 61966-2-1, clamped to [0,1]
float srgb_decode(float encoded);

void check_image_name(const std::filesystem::path& path);  // throws UsageError unless .exr or .png

// .exr: 32-bit float, linear, `exposure` not applied. .png: 8 bits, image * exposure, sRGB, clipped.
// Atomic. Throws Error on other extensions or when the file cannot be written.
void write_image(const std::filesystem::path& path, const Image& image, float exposure);

// Any file that OpenImageIO reads, 8- and 16-bit formats decoded from sRGB. Throws Error.
Image read_image(const std::filesystem::path& path);
// The same of an encoded file (PNG, JPEG, ...) in memory; `name` is for messages.
Image read_image(const void* data, std::size_t bytes, const std::string& name);

}  // namespace pim
