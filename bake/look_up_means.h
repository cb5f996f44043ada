// SPDX-License-Identifier: GPL-3.0-or-later
// What the look-up shows of a patch as a whole. Photons tell how much light lands on each patch; between
// patches the look-up interpolates, and between facings, and so blurs: the mean of what it shows over a patch
// is a mean over the patch's neighbours too.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/core/vector.h"

namespace pim {

struct Cells;
struct Fragment;
struct Scene;

class LookUpMeans {
  public:
    struct Share {
        uint32_t patch;
        float weight;
    };
    using Row = std::vector<Share>;  // of one patch

    LookUpMeans() = default;                             // of no patches
    explicit LookUpMeans(const std::vector<Row>& rows);  // weights of a row add to 1

    bool empty() const { return first_.empty(); }
    std::size_t patches() const { return empty() ? 0 : first_.size() - 1; }
    std::span<const Share> of(std::size_t patch) const {
        return {&shares_[first_[patch]], first_[patch + 1] - first_[patch]};
    }
    // The same among some of the patches only (sorted), numbered as they stand there.
    LookUpMeans part(const std::vector<uint32_t>& patches) const;

  private:
    std::vector<std::size_t> first_;  // [patch] into shares_, and the end
    std::vector<Share> shares_;
};

// Over the fragments (sorted by cell) of each patch.
LookUpMeans find_look_up_means(const Scene& scene, const Cells& cells,
                               const std::vector<Fragment>& fragments);

// Values v whose look-up has, patch by patch, nearly the means `values`: v + (v - mean of v), once. As they
// are without means.
std::vector<Rgb> sharpened(const std::vector<Rgb>& values, const LookUpMeans& means);

}  // namespace pim
