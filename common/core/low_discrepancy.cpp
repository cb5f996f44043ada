// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/core/low_discrepancy.h"

namespace pim {
namespace {

using Directions = std::array<uint32_t, 32>;

struct Primitive {  // polynomial and first direction numbers
    int degree;
    uint32_t coefficients;
    std::array<uint32_t, 5> first;
};

constexpr std::array<Primitive, kSobolDimensions - 1> kPrimitives{{{1, 0, {1}},
                                                                   {2, 1, {1, 3}},
                                                                   {3, 1, {1, 3, 1}},
                                                                   {3, 2, {1, 1, 1}},
                                                                   {4, 1, {1, 1, 3, 3}},
                                                                   {4, 4, {1, 3, 5, 13}},
                                                                   {5, 2, {1, 1, 5, 5, 17}}}};

constexpr Directions directions_of(const Primitive& p) {
    Directions v{};
    for (int i = 0; i < 32; ++i) {
        if (i < p.degree) {
            v[i] = p.first[i] << (31 - i);
            continue;
        }
        v[i] = v[i - p.degree] ^ (v[i - p.degree] >> p.degree);
        for (int k = 1; k < p.degree; ++k)
            if (p.coefficients >> (p.degree - 1 - k) & 1) v[i] ^= v[i - k];
    }
    return v;
}

constexpr std::array<Directions, kSobolDimensions> all_directions() {
    std::array<Directions, kSobolDimensions> all{};
    for (int i = 0; i < 32; ++i) all[0][i] = 1u << (31 - i);
    for (std::size_t d = 1; d < all.size(); ++d) all[d] = directions_of(kPrimitives[d - 1]);
    return all;
}

constexpr auto kDirections = all_directions();

constexpr uint32_t reversed(uint32_t x) {
    x = x >> 16 | x << 16;
    x = (x & 0xff00ff00u) >> 8 | (x & 0x00ff00ffu) << 8;
    x = (x & 0xf0f0f0f0u) >> 4 | (x & 0x0f0f0f0fu) << 4;
    x = (x & 0xccccccccu) >> 2 | (x & 0x33333333u) << 2;
    return (x & 0xaaaaaaaau) >> 1 | (x & 0x55555555u) << 1;
}

// Each bit is flipped by a hash of those above it.
constexpr uint32_t scrambled(uint32_t x, uint32_t seed) {
    x = reversed(x);
    x ^= x * 0x3d20adeau;
    x += seed;
    x *= seed >> 16 | 1;
    x ^= x * 0x05526c56u;
    x ^= x * 0x53a22864u;
    return reversed(x);
}

}  // namespace

SobolPoint sobol_point(uint32_t k) {
    SobolPoint point{};
    for (int bit = 0; k >> bit != 0 && bit < 32; ++bit)
        if (k >> bit & 1)
            for (std::size_t d = 0; d < point.size(); ++d) point[d] ^= kDirections[d][std::size_t(bit)];
    return point;
}

SobolPoint scrambled_sobol_point(uint32_t k, const SobolPoint& scramble) {
    SobolPoint point = sobol_point(k);
    for (std::size_t d = 0; d < point.size(); ++d) point[d] = scrambled(point[d], scramble[d]);
    return point;
}

}  // namespace pim
