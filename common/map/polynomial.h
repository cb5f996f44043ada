// SPDX-License-Identifier: GPL-3.0-or-later
// Cubics of the lamp's position u = (x, y, z) in [-1,1]³, in the order of equation (7) of the thesis:
// x²y, y²z, z²x, xy², yz², zx², xyz, x³, y³, z³, x², y², z², xy, yz, zx, x, y, z, 1.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "common/core/vector.h"

namespace pim {

inline constexpr int kTermCount = 20;
inline constexpr int kConstantTerm = 19;

// Powers of x, y, z in each term.
extern const std::array<std::array<int, 3>, kTermCount> kExponents;

inline int degree(int term) { return kExponents[term][0] + kExponents[term][1] + kExponents[term][2]; }

// All twenty monomials at u.
template <class T>
std::array<T, kTermCount> monomials(const Imath::Vec3<T>& u) {
    const T x = u.x, y = u.y, z = u.z;
    return {x * x * y, y * y * z, z * z * x, x * y * y, y * z * z, z * x * x, x * y * z,
            x * x * x, y * y * y, z * z * z, x * x,     y * y,     z * z,     x * y,
            y * z,     z * x,     x,         y,         z,         T(1)};
}

// The terms of at most `highest_degree` in the axes along which the lamp moves, in equation (7)'s order.
std::vector<int> terms_of(int highest_degree, const std::array<bool, 3>& moves);

// Products of Chebyshev polynomials T_i(x) T_j(y) T_k(z), one for each term's exponents (i, j, k): the basis
// in which the fit is well conditioned.
std::array<double, kTermCount> chebyshev_products(const Vec3d& u);

// The twenty monomial coefficients of the product that belongs to `term`.
std::array<double, kTermCount> chebyshev_in_monomials(int term);

}  // namespace pim
