// SPDX-License-Identifier: GPL-3.0-or-later
// Fits of what has been traced so far, for the patches that the held-out pixels look up: how large is the
// error with these settings, how much of it is noise, and what would other boxes or another degree make of
// the same photons?
#pragma once

#include "bake/fit.h"
#include "bake/held_out.h"
#include "bake/tracing.h"

namespace pim {

// Squares are of ||I-R||/||R||, means over the held-out views.
struct TrialFigures {
    double square = 0;          // all of it
    std::vector<double> noise;  // per lamp, the part that more photons or positions take away
    HeldOut::Error error;       // as `bake evaluate` would say it
    double below_zero = 0;      // share of the polynomials' values that signs would be mended of

    double noise_sum() const;
    TrialFigures with_noise(double share) const;  // as they would be with so much of the squared noise
    double floor() const { return square - noise_sum(); }  // grid and polynomial
};

class TrialFits {
  public:
    using AtPositions = std::vector<HeldOut::Values>;  // [held-out position], not clamped
    struct BoxTrial {
        std::size_t light;
        Index3 boxes;
        TrialFigures figures;
        AtPositions whole;  // of the light
    };

    // The arguments must outlive the fits; `held_out` knows the cells.
    TrialFits(const Tracing& tracing, const HeldOut& held_out);

    // Reads what has been traced for these positions of a lamp; known ones are not read again.
    void add(int light, const std::vector<LightSample>& samples);

    // Fits all lamps. Noise by the delete-a-group jackknife (Kott 2001): from the scatter of fits that each
    // leave out one of a few groups of positions.
    TrialFigures measure(const std::vector<Light>& lights, int degree);
    // With one lamp's boxes, or the degree, changed since measure(): the error is measured, its noise follows
    // from the leverage of the changed design, as far as the error leaves room for it: part of what scatters
    // is what the polynomial misses, which boxes mend. None where a box holds too few positions.
    std::optional<BoxTrial> with_boxes(std::size_t light, const Index3& boxes) const;
    std::optional<TrialFigures> with_degree(int degree) const;
    // Makes such a change: what follows is compared with it.
    void change_boxes(BoxTrial trial);

  private:
    struct Lamp {
        std::vector<LightSample> samples;
        std::vector<DensityVolume> volumes;  // [sample], of held_out.patches()
        AtPositions whole;
        std::vector<double> leverage;  // [held-out position]
    };

    AtPositions fitted(std::size_t light, const Light& as, int degree,
                       const std::vector<LightSample>& samples) const;
    std::vector<double> leverage(std::size_t light, const Light& as, int degree) const;
    bool enough(std::size_t light, const Light& as, int degree) const;
    AtPositions total(std::size_t replaced, const AtPositions& by) const;
    AtPositions sum_of(const std::vector<const AtPositions*>& parts) const;
    double noise(std::size_t light) const;
    double below_zero() const;
    std::vector<int> groups_of(std::size_t light) const;  // of the samples
    void add_figures(const AtPositions& total, TrialFigures& figures) const;

    const Tracing& tracing_;
    const HeldOut& held_out_;
    Neighbourhoods shared_;
    std::vector<Lamp> lamps_;
    std::vector<Light> lights_;  // as measured
    int degree_ = 3;
    TrialFigures measured_;
};

}  // namespace pim
