// SPDX-License-Identifier: GPL-3.0-or-later
// What a bake that chooses for itself judges its settings by: lamp positions that stay out of the fit, and
// the radiance that paths of its own show there. Evaluations never use these positions, pixels and paths.
#pragma once

#include "bake/cells.h"
#include "bake/reference.h"
#include "bake/statistics.h"

namespace pim {

class HeldOut {
  public:
    struct Size {
        int positions = 64;  // lamp positions, spread evenly over the domains, outside solids
        int pixels = 500;    // per position
        int paths = 256;     // per pixel
    };
    HeldOut(const Scene& scene, const RayCaster& caster, const Solids& solids, const Size& size);

    int positions() const { return reference_.positions(); }
    bool sees_light(int camera) const;  // at any position
    const std::vector<LightState>& lamps(int position) const { return reference_.lamps(position); }

    // Looks up where the pixels get their light in these cells. Pixels are linear in the patches' values, so
    // that from here on no ray is needed.
    void set_cells(const Scene& scene, const RayCaster& caster, const Cells& cells);
    // The patches that the pixels look up, and those around them that share what they know with them; sorted.
    const std::vector<uint32_t>& patches() const { return patches_; }

    using Values = std::vector<Rgb>;  // W/m², one per patch of patches()
    // ||I - R||² / ||R||², mean over all views. `a` and `b` [position] are two estimates of the patches'
    // irradiance; where their noise is independent, none of it is in the result.
    double square(const std::vector<Values>& a, const std::vector<Values>& b) const;
    // With its standard error, from the scatter among the views.
    Doubtful doubtful_square(const std::vector<Values>& a, const std::vector<Values>& b) const;
    // ||I_a - I_b||² / ||R||², mean over all views; and their median, which a rare bright photon in a small
    // patch does not move.
    double difference(const std::vector<Values>& a, const std::vector<Values>& b) const;
    double usual_difference(const std::vector<Values>& a, const std::vector<Values>& b) const;
    // As `bake evaluate` says it: the mean of ||I - R|| / ||R|| over all views; and its standard error. With
    // few pixels and paths a view's root would be too small, or that of mere noise: squares are averaged
    // first, and the root of their mean lowered by how much views truly differ (as if log-normal).
    struct Error {
        double relrmse = 0, standard_error = 0;
    };
    Error error(const std::vector<Values>& values) const;

  private:
    struct Share {
        uint32_t patch;  // number in patches()
        Rgb weight;      // radiance per irradiance, 1/sr
    };
    struct Pixel {
        uint32_t first = 0, last = 0;  // shares
        Rgb direct{0};                 // W/(m² sr), traced
    };
    struct View {
        std::vector<Share> shares;
        std::vector<Pixel> pixels;
    };

    void look_up_view(const Moment& moment, int position, int camera, View& view) const;
    void number_patches(const Cells& cells);
    std::vector<Rgb> seen(std::size_t view, const Values& values) const;
    std::size_t position_of(std::size_t view) const { return view / std::size_t(reference_.cameras()); }
    const std::vector<ReferencePixel>& reference(std::size_t view) const;
    double norm(std::size_t view) const;
    // ||I - R||² / ||R||² of one view, and its variance from the scatter of its pixels.
    struct ViewError {
        double square = 0, variance = 0;
    };
    ViewError view_error(std::size_t view, const Values& values) const;
    std::vector<double> squares(const std::vector<Values>& a, const std::vector<Values>& b) const;
    std::vector<double> differences(const std::vector<Values>& a, const std::vector<Values>& b) const;

    Reference reference_;
    std::vector<View> views_;  // [position][camera]
    std::vector<uint32_t> patches_;
};

}  // namespace pim
