// SPDX-License-Identifier: GPL-3.0-or-later
// Density volumes to polynomials: one least-squares design for all patches of a box, volumes streamed.
#pragma once

#include <functional>

#include "bake/density.h"
#include "bake/patch_filter.h"
#include "bake/robust_pass.h"
#include "common/map/illumination_map.h"

namespace pim {

struct BoxFit {
    Polynomials polynomials;
    FitStatistics statistics;
};

struct FitSettings {
    int degree = 3;
    bool shrinkage = true;      // and filter, where neighbourhoods are given
    bool non_negative = false;  // see non_negative.h
    Robust robust = Robust::off;
    RobustLoss loss = RobustLoss::tukey;
};

// What patches share in a fit with these settings.
Neighbourhoods neighbourhoods(const Scene& scene, const Cells& cells);
// Among some of the patches only (sorted), numbered as they stand there.
Neighbourhoods neighbourhoods(const Scene& scene, const Cells& cells, const std::vector<uint32_t>& patches);

// Fits a polynomial of at most the degree in the box's normalised coordinates to the samples at `positions`
// (local, all inside the box). Terms that the samples do not determine are 0.
//
// With neighbourhoods, coefficients orthonormal over the samples are shrunk, and before that filtered where
// the neighbourhoods are made for it (see patch_filter.h). Their noise is known from the photons then,
// otherwise from the patch's own residual. Memory grows with the patches, not with the samples.
//
// With a robust fit, patches with outliers are fitted again first (see robust_pass.h).
BoxFit fit_box(const MapBox& box, const std::vector<Vec3>& positions, const FitSettings& settings,
               std::size_t patch_count, const VolumeReader& read_volume, const Neighbourhoods& shared);

// A worse condition number of a design is warned of: noise of the samples grows with it.
inline constexpr double kBadCondition = 1e3;

// Of the design that monomials of world coordinates would make of the same positions (local, `origin` away
// from the world's): the thesis' way. At most what extended precision can tell, 10^19.
double raw_condition_number(const MapBox& box, const std::vector<Vec3>& positions, int degree,
                            const Vec3d& origin);

// Variance of the fit at lamp positions `at` for variance 1 of each sample, without shrinkage: the sum of
// squares of what each sample counts for there.
std::vector<double> leverages(const MapBox& box, const std::vector<Vec3>& positions, int degree,
                              const std::vector<Vec3d>& at);

// Of one lamp position.
using DensityReader = std::function<DensityVolume::PerComponent(const LightSample&, Component)>;

// A fit for each box and component of a lamp; `samples` are the positions of that lamp.
MapLight fit_light(const Light& light, const BakeSettings& settings, const std::vector<LightSample>& samples,
                   std::size_t patch_count, const Neighbourhoods& shared, const DensityReader& density);

}  // namespace pim
