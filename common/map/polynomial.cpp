// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/map/polynomial.h"

namespace pim {

const std::array<std::array<int, 3>, kTermCount> kExponents = {
    {{2, 1, 0}, {0, 2, 1}, {1, 0, 2}, {1, 2, 0}, {0, 1, 2}, {2, 0, 1}, {1, 1, 1},
     {3, 0, 0}, {0, 3, 0}, {0, 0, 3}, {2, 0, 0}, {0, 2, 0}, {0, 0, 2}, {1, 1, 0},
     {0, 1, 1}, {1, 0, 1}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0, 0, 0}}};

namespace {

// T_n as coefficients of 1, x, x², x³.
constexpr double kChebyshev[4][4] = {{1, 0, 0, 0}, {0, 1, 0, 0}, {-1, 0, 2, 0}, {0, -3, 0, 4}};

int term_with(int i, int j, int k) {
    for (int term = 0; term < kTermCount; ++term)
        if (kExponents[term] == std::array<int, 3>{i, j, k}) return term;
    return -1;
}

}  // namespace

std::vector<int> terms_of(int highest_degree, const std::array<bool, 3>& moves) {
    std::vector<int> terms;
    for (int term = 0; term < kTermCount; ++term) {
        bool wanted = degree(term) <= highest_degree;
        for (int axis = 0; axis < 3; ++axis) wanted = wanted && (moves[axis] || kExponents[term][axis] == 0);
        if (wanted) terms.push_back(term);
    }
    return terms;
}

std::array<double, kTermCount> chebyshev_products(const Vec3d& u) {
    std::array<double, kTermCount> values;
    for (int term = 0; term < kTermCount; ++term) {
        values[term] = 1;
        for (int axis = 0; axis < 3; ++axis) {
            const double* c = kChebyshev[kExponents[term][axis]];
            values[term] *= c[0] + u[axis] * (c[1] + u[axis] * (c[2] + u[axis] * c[3]));
        }
    }
    return values;
}

std::array<double, kTermCount> chebyshev_in_monomials(int term) {
    std::array<double, kTermCount> coefficients{};
    const auto& e = kExponents[term];
    for (int i = 0; i <= e[0]; ++i)
        for (int j = 0; j <= e[1]; ++j)
            for (int k = 0; k <= e[2]; ++k)
                coefficients[term_with(i, j, k)] +=
                    kChebyshev[e[0]][i] * kChebyshev[e[1]][j] * kChebyshev[e[2]][k];
    return coefficients;
}

}  // namespace pim
