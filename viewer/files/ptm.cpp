// SPDX-License-Identifier: GPL-3.0-or-later
#include "viewer/files/ptm.h"

#include <fmt/format.h>

#include <cmath>
#include <sstream>

#include "common/core/error.h"
#include "common/core/file.h"

namespace pim {
namespace {

constexpr float kFull = 255;
constexpr int kChannels = 3, kLargestSide = 32768;
constexpr const char* kVersionLine = "PTM_1.2";
constexpr const char* kFormatLine = "PTM_FORMAT_LRGB";

// Between a coefficient, 1 being full, and its byte.
struct Quantiser {
    float scale = 1;
    int bias = 0;

    char encode(float a) const {
        return char(uint8_t(std::clamp(std::round(kFull * a / scale) + float(bias), 0.0f, 255.0f)));
    }
    float decode(char byte) const { return float(int(uint8_t(byte)) - bias) * scale / kFull; }
};

using Quantisers = std::array<Quantiser, kPtmTerms>;

// 0 is always in the range, so that biases are bytes too; 254 steps are enough wherever the whole number
// `bias` puts it.
Quantiser quantiser(float least, float most) {
    if (!(most > least)) return {};
    const float scale = kFull * (most - least) / 254;
    return {scale, int(std::ceil(-kFull * least / scale))};
}

Quantisers quantisers(const Ptm& ptm) {
    Quantisers all;
    for (std::size_t i = 0; i < kPtmTerms; ++i) {
        float least = 0, most = 0;
        for (const auto& a : ptm.luminance) least = std::min(least, a[i]), most = std::max(most, a[i]);
        all[i] = quantiser(least, most);
    }
    return all;
}

std::string header_text(const Ptm& ptm, const Quantisers& quantisers) {
    std::string scales, biases;
    for (const Quantiser& q : quantisers) {
        const char* space = scales.empty() ? "" : " ";
        scales += fmt::format("{}{}", space, q.scale);
        biases += fmt::format("{}{}", space, q.bias);
    }
    return fmt::format("{}\n{}\n{}\n{}\n{}\n{}\n", kVersionLine, kFormatLine, ptm.width, ptm.height, scales,
                       biases);
}

// Calls visit(pixel) in the order of the file.
template <class Visit>
void for_each_pixel(const Ptm& ptm, Visit visit) {
    for (int y = ptm.height - 1; y >= 0; --y)
        for (int x = 0; x < ptm.width; ++x) visit(std::size_t(y) * std::size_t(ptm.width) + std::size_t(x));
}

struct Header {
    int width = 0, height = 0;
    Quantisers quantisers;
};

// Leaves `stream` at the first byte of the pixels. Numbers may stand on one line or on several.
Header read_header(std::istream& stream, const std::string& file) {
    const auto require = [&](bool good, const std::string& problem) {
        if (!good) throw Error(file + ": " + problem);
    };
    std::string version, format, rest;
    stream >> version >> format;
    require(version == kVersionLine, "is no polynomial texture map of version 1.2");
    require(format == kFormatLine,
            fmt::format("its pixels are {}; only {} can be read", format.substr(0, 40), kFormatLine));
    Header header;
    stream >> header.width >> header.height;
    for (Quantiser& q : header.quantisers) stream >> q.scale;
    for (Quantiser& q : header.quantisers) stream >> q.bias;
    require(bool(stream), "the header is damaged: it must give width, height, six scales, six biases");
    require(
        std::min(header.width, header.height) > 0 && std::max(header.width, header.height) <= kLargestSide,
        fmt::format("{} x {} pixels; allowed: 1 to {} on each side", header.width, header.height,
                    kLargestSide));
    std::getline(stream, rest);
    return header;
}

}  // namespace

Image relit(const Ptm& ptm, float u, float v) {
    Image image(ptm.width, ptm.height);
    const auto terms = ptm_terms(u, v);
    for (std::size_t p = 0; p < image.pixels.size(); ++p) {
        float luminance = 0;
        for (std::size_t i = 0; i < kPtmTerms; ++i) luminance += ptm.luminance[p][i] * terms[i];
        for (int c = 0; c < 3; ++c)
            image.pixels[p][c] = std::clamp(ptm.colours[p][c] * luminance, 0.0f, 1.0f);
    }
    return image;
}

std::array<float, kPtmTerms> ptm_steps(const Ptm& ptm) {
    std::array<float, kPtmTerms> steps{};
    const Quantisers all = quantisers(ptm);
    for (std::size_t i = 0; i < kPtmTerms; ++i)
        steps[i] = std::ranges::all_of(ptm.luminance, [i](const auto& a) { return a[i] == 0; })
                       ? 0
                       : all[i].scale / kFull;
    return steps;
}

void write_ptm(const std::filesystem::path& path, const Ptm& ptm) {
    const Quantisers all = quantisers(ptm);
    std::string bytes = header_text(ptm, all);
    bytes.reserve(bytes.size() + (kPtmTerms + kChannels) * ptm.luminance.size());
    for_each_pixel(ptm, [&](std::size_t p) {
        for (std::size_t i = 0; i < kPtmTerms; ++i) bytes += all[i].encode(ptm.luminance[p][i]);
    });
    for_each_pixel(ptm, [&](std::size_t p) {
        for (int c = 0; c < kChannels; ++c)
            bytes += char(uint8_t(std::lround(kFull * std::clamp(ptm.colours[p][c], 0.0f, 1.0f))));
    });
    write_text_atomically(path, bytes);
}

Ptm read_ptm(const std::filesystem::path& path) {
    const std::string bytes = read_text(path);
    std::istringstream stream(bytes);
    const Header header = read_header(stream, path.string());
    Ptm ptm{header.width, header.height, {}, {}};
    const std::size_t count = std::size_t(ptm.width) * std::size_t(ptm.height);
    const std::size_t start = stream.eof() ? bytes.size() : std::size_t(stream.tellg());
    const std::size_t needed = (kPtmTerms + kChannels) * count, found = bytes.size() - start;
    if (found != needed)
        throw Error(fmt::format("{}: holds {} bytes of pixels; {} x {} of them take {}", path.string(), found,
                                ptm.width, ptm.height, needed));
    ptm.luminance.resize(count);
    ptm.colours.resize(count);
    const char* next = bytes.data() + start;
    for_each_pixel(ptm, [&](std::size_t p) {
        for (std::size_t i = 0; i < kPtmTerms; ++i)
            ptm.luminance[p][i] = header.quantisers[i].decode(*next++);
    });
    for_each_pixel(ptm, [&](std::size_t p) {
        for (int c = 0; c < kChannels; ++c) ptm.colours[p][c] = float(uint8_t(*next++)) / kFull;
    });
    return ptm;
}

}  // namespace pim
