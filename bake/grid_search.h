// SPDX-License-Identifier: GPL-3.0-or-later
// How large cells should be: measured at the held-out lamp positions with photons of these positions' own, so
// that neither the polynomial nor its lamp positions are in the figures.
#pragma once

#include <map>

#include "bake/held_out.h"

namespace pim {

struct GridFigures {
    double cell_size = 0;  // m
    double square = 0;     // of the error that remains with ever more photons, ||I-R||²/||R||²
    double doubt = 0;      // its standard error
    double noise = 0;      // of one photon per lamp, in the same measure; of n photons: noise / n
    std::size_t patches = 0;
};

class GridSearch {
  public:
    static constexpr uint64_t kFewestPhotons = 1 << 11, kMostPhotons = 1 << 20;
    // Squared errors of the size of `wanted` are to be told apart; `first_photons` per lamp, position and
    // half for the first size, `most_photons` for any, within the bounds above. The arguments must outlive
    // the search.
    GridSearch(Scene scene, const RayCaster& caster, const PositionFilter& allowed, HeldOut& held_out,
               double wanted, uint64_t first_photons, uint64_t most_photons);
    // Of the cells that the scene asks for.
    const GridFigures& measure_given();

    // From so many cells along the longest side, finer or coarser as the cost falls, in steps of sqrt(2)
    // or two. Costs may be infinite; they are asked for what is known, and for what is hoped of a size
    // that takes so many seconds to look into, about.
    using Cost = std::function<double(const GridFigures&, double seconds)>;
    GridFigures search(double longest_side, double first_cells, const Cost& cost);
    // The cells that were found or given, as find_cells makes them. Once.
    Cells take_cells() { return std::move(cells_); }

  private:
    const GridFigures& measure(double cell_size);
    const GridFigures& measure_as_set(double cell_size);
    const GridFigures& nearest(double cell_size) const;  // of those measured
    double least_square(double cell_size) const;
    Doubtful with_expected(const Doubtful& measured, double cell_size) const;
    // What a size is likely to be, as far as is known.
    GridFigures hoped_at(double cell_size) const;
    uint64_t photons_for(double cell_size) const;
    std::vector<HeldOut::Values> own_volumes(const Cells& cells, int half) const;

    Scene scene_;
    const RayCaster& caster_;
    const PositionFilter& allowed_;
    HeldOut& held_out_;
    double wanted_;
    uint64_t first_photons_, most_photons_;
    std::map<double, GridFigures> known_;
    double seconds_ = 0;      // that the last took to measure
    Cells measured_, cells_;  // of the size measured last, and of the best
};

}  // namespace pim
