// SPDX-License-Identifier: GPL-3.0-or-later
// A polynomial texture map (files/ptm.h) from pictures under a lamp that moves in a plane: the thesis, 2.4,
// equations 4 to 6.
#pragma once

#include <optional>
#include <vector>

#include "viewer/files/ptm.h"

namespace pim {

// Where (u, v) puts a lamp: u and v in [-1, 1] run along the two longer axes of its domain, in the order x,
// y, z, from its lower to its upper side; on the third axis the lamp stays.
struct LampPlane {
    Box3 domain;
    Vec3 position;  // local
    std::array<int, 2> axes{};

    Vec3 at(const Vec2& uv) const;
};

// None for a domain that extends on fewer than two axes.
std::optional<LampPlane> lamp_plane(const Box3& domain, const Vec3& position);

// n × n Chebyshev nodes, cos((i + ½) π/n) on each axis: denser at the borders, where a polynomial fitted on
// an even grid strays.
std::vector<Vec2> chebyshev_grid(int n);

// The least squares that all pixels share, by singular value decomposition of the design A, whose rows are
// ptm_terms of the lamps: the coefficients of a pixel are A⁺ times its values.
struct PtmDesign {
    std::vector<std::array<float, kPtmTerms>> weights;  // columns of A⁺, one for each lamp
    std::array<double, kPtmTerms> singular_values{};    // falling

    explicit PtmDesign(const std::vector<Vec2>& lamps);  // at least six, not all on one conic
    double condition_number() const { return singular_values.front() / singular_values.back(); }
};

// Takes the pictures one by one; keeps sums only.
class PtmFit {
  public:
    PtmFit(const Imath::V2i& size, const PtmDesign& design);  // the design outlives it

    // The picture under the design's `lamp`: what a display shows, sRGB encoded, in 0..1. Each lamp once.
    void add(std::size_t lamp, const Image& encoded);

    // A pixel's colour is its least-squares constant chromaticity at the greatest luminance that it had; so
    // L is full there.
    Ptm lrgb() const;
    // What a biquadratic in each channel would show, 0..1: the same without constant chromaticity.
    Image per_channel(float u, float v) const;

  private:
    struct Pixel {
        std::array<Rgb, kPtmTerms> coefficients;
        Rgb tinted{0};                // Σ Y · colour, Y the luminance of the encoded colour
        float squares = 0, peak = 0;  // Σ Y², max Y
        Pixel() { coefficients.fill(Rgb(0)); }
    };
    const PtmDesign& design_;
    int width_, height_;
    std::vector<Pixel> pixels_;
};

}  // namespace pim
