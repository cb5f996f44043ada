// SPDX-License-Identifier: GPL-3.0-or-later
#include "viewer/ptm_fit.h"

#include <Eigen/Dense>
#include <cmath>

#include "common/core/parallel.h"

namespace pim {
namespace {

// Encoded luminance below which a pixel counts as black: in no channel would it come to half a byte.
constexpr float kBlack = 1e-4f;

}  // namespace

Vec3 LampPlane::at(const Vec2& uv) const {
    Vec3 place = position;
    for (int i = 0; i < 2; ++i) {
        const int axis = axes[std::size_t(i)];
        place[axis] = std::clamp(0.5f * (domain.min[axis] * (1 - uv[i]) + domain.max[axis] * (1 + uv[i])),
                                 domain.min[axis], domain.max[axis]);
    }
    return place;
}

std::optional<LampPlane> lamp_plane(const Box3& domain, const Vec3& position) {
    const Vec3 size = domain.max - domain.min;
    const int shortest = size.z <= std::min(size.x, size.y) ? 2 : size.y <= size.x ? 1 : 0;
    LampPlane plane{domain, position, {shortest == 0 ? 1 : 0, shortest == 2 ? 1 : 2}};
    if (!(size[plane.axes[0]] > 0 && size[plane.axes[1]] > 0)) return std::nullopt;
    return plane;
}

std::vector<Vec2> chebyshev_grid(int n) {
    const auto node = [n](int i) { return float(-std::cos((i + 0.5) * double(kPi) / n)); };
    std::vector<Vec2> grid;
    for (int j = 0; j < n; ++j)
        for (int i = 0; i < n; ++i) grid.emplace_back(node(i), node(j));
    return grid;
}

PtmDesign::PtmDesign(const std::vector<Vec2>& lamps) : weights(lamps.size()) {
    const auto rows = Eigen::Index(lamps.size());
    Eigen::MatrixXd design(rows, kPtmTerms);
    for (Eigen::Index k = 0; k < rows; ++k) {
        const auto terms = ptm_terms(lamps[std::size_t(k)].x, lamps[std::size_t(k)].y);
        for (int i = 0; i < kPtmTerms; ++i) design(k, i) = terms[std::size_t(i)];
    }
    const Eigen::JacobiSVD<Eigen::MatrixXd> svd(design, Eigen::ComputeThinU | Eigen::ComputeThinV);
    const Eigen::MatrixXd inverse = svd.solve(Eigen::MatrixXd::Identity(rows, rows));
    for (int i = 0; i < kPtmTerms; ++i) {
        singular_values[std::size_t(i)] = svd.singularValues()(i);
        for (Eigen::Index k = 0; k < rows; ++k)
            weights[std::size_t(k)][std::size_t(i)] = float(inverse(i, k));
    }
}

PtmFit::PtmFit(const Imath::V2i& size, const PtmDesign& design)
    : design_(design), width_(size.x), height_(size.y), pixels_(std::size_t(size.x) * std::size_t(size.y)) {}

void PtmFit::add(std::size_t lamp, const Image& encoded) {
    const auto& weights = design_.weights[lamp];
    parallel_for(std::size_t(height_), [&](std::size_t row) {
        for (std::size_t p = row * std::size_t(width_); p < (row + 1) * std::size_t(width_); ++p) {
            Pixel& pixel = pixels_[p];
            const Rgb& colour = encoded.pixels[p];
            for (std::size_t i = 0; i < kPtmTerms; ++i) pixel.coefficients[i] += colour * weights[i];
            const float y = luminance(colour);
            pixel.tinted += colour * y;
            pixel.squares += y * y;
            pixel.peak = std::max(pixel.peak, y);
        }
    });
}

Ptm PtmFit::lrgb() const {
    Ptm ptm{width_, height_, {}, {}};
    ptm.luminance.resize(pixels_.size());
    ptm.colours.assign(pixels_.size(), Rgb(0));
    for (std::size_t p = 0; p < pixels_.size(); ++p) {
        const Pixel& pixel = pixels_[p];
        if (pixel.peak < kBlack) continue;
        const Rgb chromaticity = pixel.tinted / pixel.squares;  // of luminance 1; minimises Σ |colour - Y c|²
        const float peak = std::min(pixel.peak, 1 / max_channel(chromaticity));
        ptm.colours[p] = chromaticity * peak;
        for (std::size_t i = 0; i < kPtmTerms; ++i)
            ptm.luminance[p][i] = luminance(pixel.coefficients[i]) / peak;
    }
    return ptm;
}

Image PtmFit::per_channel(float u, float v) const {
    Image image(width_, height_);
    const auto terms = ptm_terms(u, v);
    for (std::size_t p = 0; p < pixels_.size(); ++p) {
        for (std::size_t i = 0; i < kPtmTerms; ++i) image.pixels[p] += pixels_[p].coefficients[i] * terms[i];
        for (int c = 0; c < 3; ++c) image.pixels[p][c] = std::clamp(image.pixels[p][c], 0.0f, 1.0f);
    }
    return image;
}

}  // namespace pim
