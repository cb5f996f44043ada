// SPDX-License-Identifier: GPL-3.0-or-later
// Sobol's sequence in eight dimensions (direction numbers: Joe and Kuo, Constructing Sobol Sequences with
// Better Two-Dimensional Projections, SIAM J. Sci. Comput. 2008), scrambled by hashing after Owen (Burley:
// Practical Hash-based Owen Scrambling, JCGT 2020): each point by itself is uniform, many together are spread
// evenly, and differently scrambled sequences are independent.
#pragma once

#include <array>
#include <cstdint>

namespace pim {

inline constexpr int kSobolDimensions = 8;
using SobolPoint = std::array<uint32_t, kSobolDimensions>;  // of 2^32

SobolPoint sobol_point(uint32_t k);
SobolPoint scrambled_sobol_point(uint32_t k, const SobolPoint& scramble);

}  // namespace pim
