// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/map/polynomial.h"

#include <gtest/gtest.h>

#include <cmath>
#include <set>
#include <string>

#include "common/core/random.h"

namespace pim {
namespace {

constexpr double kRounding = 1e-14;  // some dozen double roundings of numbers near 1

Vec3d random_point(RandomStream& random) {
    const double x = random.next(), y = random.next(), z = random.next();
    return Vec3d(x, y, z) * 2.0 - Vec3d(1);
}

// Equation (7) of the thesis, as it is printed.
const char* const kPrinted[kTermCount] = {"xxy", "yyz", "zzx", "xyy", "yzz", "zxx", "xyz",
                                          "xxx", "yyy", "zzz", "xx",  "yy",  "zz",  "xy",
                                          "yz",  "zx",  "x",   "y",   "z",   ""};

TEST(Monomials, OrderOfEquation7) {
    RandomStream random(1, RandomPurpose::evaluation, 0, 0);
    const Vec3d u = random_point(random);
    const auto values = monomials(u);
    for (int term = 0; term < kTermCount; ++term) {
        double expected = 1;
        std::array<int, 3> powers{};
        for (const char letter : std::string(kPrinted[term]))
            expected *= u[letter - 'x'], ++powers[std::size_t(letter - 'x')];
        EXPECT_NEAR(values[term], expected, kRounding) << kPrinted[term];
        EXPECT_EQ(kExponents[term], powers) << kPrinted[term];
        EXPECT_EQ(degree(term), int(std::string(kPrinted[term]).size()));
    }
    EXPECT_EQ(degree(kConstantTerm), 0);
}

TEST(TermsOf, Counts) {
    const std::array<bool, 3> all{true, true, true}, plane{true, false, true}, line{false, true, false},
        none{};
    EXPECT_EQ(terms_of(3, all).size(), 20u);
    EXPECT_EQ(terms_of(2, all).size(), 10u);
    EXPECT_EQ(terms_of(1, all).size(), 4u);
    EXPECT_EQ(terms_of(0, all).size(), 1u);
    EXPECT_EQ(terms_of(3, plane).size(), 10u);
    EXPECT_EQ(terms_of(3, line).size(), 4u);
    EXPECT_EQ(terms_of(3, none), std::vector<int>{kConstantTerm});
}

TEST(TermsOf, HoldsNoStillAxis) {
    for (const int term : terms_of(3, {true, false, true})) EXPECT_EQ(kExponents[term][1], 0);
    const auto terms = terms_of(2, {true, true, true});
    EXPECT_TRUE(std::ranges::is_sorted(terms));
    for (const int term : terms) EXPECT_LE(degree(term), 2);
}

TEST(ChebyshevProducts, AreCosinesOfMultipleAngles) {  // T_n(cos a) = cos(n a)
    RandomStream random(2, RandomPurpose::evaluation, 0, 0);
    for (int i = 0; i < 100; ++i) {
        const Vec3d u = random_point(random);
        const auto values = chebyshev_products(u);
        for (int term = 0; term < kTermCount; ++term) {
            double expected = 1;
            for (int axis = 0; axis < 3; ++axis)
                expected *= std::cos(kExponents[term][axis] * std::acos(u[axis]));
            EXPECT_NEAR(values[term], expected, kRounding);
        }
    }
}

TEST(ChebyshevInMonomials, IsTheSamePolynomial) {
    RandomStream random(3, RandomPurpose::evaluation, 0, 0);
    for (int i = 0; i < 100; ++i) {
        const Vec3d u = random_point(random);
        const auto products = chebyshev_products(u), powers = monomials(u);
        for (int term = 0; term < kTermCount; ++term) {
            const auto coefficients = chebyshev_in_monomials(term);
            double value = 0;
            for (int k = 0; k < kTermCount; ++k) value += coefficients[k] * powers[k];
            EXPECT_NEAR(value, products[term], kRounding);
        }
    }
}

}  // namespace
}  // namespace pim
