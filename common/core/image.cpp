// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/core/image.h"

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>
#include <fmt/format.h>

#include <array>
#include <cmath>

#include "common/core/error.h"
#include "common/core/file.h"

namespace pim {
namespace {

Image decode(OIIO::ImageInput& input) {
    const OIIO::ImageSpec spec = input.spec();
    const int channels = std::min(spec.nchannels, 3);
    std::vector<float> values(std::size_t(spec.width) * spec.height * channels);
    if (!input.read_image(0, 0, 0, channels, OIIO::TypeDesc::FLOAT, values.data()))
        throw Error(input.geterror());
    const bool encoded =
        spec.format.basetype == OIIO::TypeDesc::UINT8 || spec.format.basetype == OIIO::TypeDesc::UINT16;
    Image image(spec.width, spec.height);
    for (std::size_t i = 0; i < image.pixels.size(); ++i)
        for (int c = 0; c < 3; ++c) {
            const float v = values[i * channels + std::min(c, channels - 1)];
            image.pixels[i][c] = encoded ? srgb_decode(v) : v;
        }
    return image;
}

std::vector<uint8_t> to_srgb8(const Image& image, float exposure) {
    std::vector<uint8_t> bytes;
    bytes.reserve(image.pixels.size() * 3);
    for (const Rgb& pixel : image.pixels)
        for (int c = 0; c < 3; ++c)
            bytes.push_back(uint8_t(std::lround(255.0f * srgb_encode(pixel[c] * exposure))));
    return bytes;
}

}  // namespace

float automatic_exposure(const Image& image) {
    std::vector<float> values;
    for (const Rgb& pixel : image.pixels)
        if (const float y = luminance(pixel); y > 0 && std::isfinite(y)) values.push_back(y);
    if (values.empty()) return 1.0f;
    const auto place = values.begin() + std::ptrdiff_t(0.98 * double(values.size() - 1));
    std::nth_element(values.begin(), place, values.end());
    return 0.9f / *place;
}

float srgb_encode(float linear) {
    const float x = std::isfinite(linear) ? std::clamp(linear, 0.0f, 1.0f) : 0.0f;
    return x <= 0.0031308f ? 12.92f * x : 1.055f * std::pow(x, 1.0f / 2.4f) - 0.055f;
}

float srgb_decode(float encoded) {
    return encoded <= 0.04045f ? encoded / 12.92f : std::pow((encoded + 0.055f) / 1.055f, 2.4f);
}

void check_image_name(const std::filesystem::path& path) {
    if (path.extension() != ".exr" && path.extension() != ".png")
        throw UsageError(
            fmt::format("{}: pictures are written as .exr or .png; name the file so", path.string()));
}

void write_image(const std::filesystem::path& path, const Image& image, float exposure) {
    check_image_name(path);
    const std::string extension = path.extension().string();
    write_atomically(path, [&](const std::filesystem::path& temporary) {
        const auto output = OIIO::ImageOutput::create(temporary.string());
        const bool exr = extension == ".exr";
        OIIO::ImageSpec spec(image.width, image.height, 3,
                             exr ? OIIO::TypeDesc::FLOAT : OIIO::TypeDesc::UINT8);
        spec.attribute("DateTime", "1970:01:01 00:00:00");  // the same bytes whenever it is written
        if (!output || !output->open(temporary.string(), spec) ||
            !(exr ? output->write_image(OIIO::TypeDesc::FLOAT, image.pixels.data())
                  : output->write_image(OIIO::TypeDesc::UINT8, to_srgb8(image, exposure).data())) ||
            !output->close())
            throw Error(fmt::format("{}: cannot be written: {}", path.string(),
                                    output ? output->geterror() : OIIO::geterror()));
    });
}

Image read_image(const std::filesystem::path& path) {
    const auto input = OIIO::ImageInput::open(path.string());
    if (!input)
        throw Error(fmt::format("{}: the picture cannot be read: {}", path.string(), OIIO::geterror()));
    return decode(*input);
}

Image read_image(const void* data, std::size_t bytes, const std::string& name) {
    OIIO::Filesystem::IOMemReader memory(const_cast<void*>(data), bytes);
    for (const char* guess : {"x.png", "x.jpg", "x.webp", "x.tga", "x.bmp"}) {
        const auto input = OIIO::ImageInput::open(guess, nullptr, &memory);
        if (input) return decode(*input);
        (void)OIIO::geterror();
        memory.seek(0);
    }
    throw Error(fmt::format("{}: the embedded picture is of no format that OpenImageIO reads", name));
}

}  // namespace pim
