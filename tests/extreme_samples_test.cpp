// SPDX-License-Identifier: GPL-3.0-or-later
// Lamp positions that hardly determine a cubic, and fits against exact arithmetic.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <boost/multiprecision/cpp_int.hpp>
#include <cmath>
#include <functional>

#include "bake/fit.h"
#include "common/core/random.h"
#include "common/core/sampling.h"
#include "stability_table.h"

namespace pim {
namespace {

std::vector<Vec3> spread(int count, const Vec3& low, const Vec3& high) {
    std::vector<Vec3> positions;
    for (int k = 0; k < count; ++k) {
        Vec3 p;
        for (int axis = 0; axis < 3; ++axis)
            p[axis] = low[axis] + (high[axis] - low[axis]) * float(golden_sequence(uint64_t(k), axis, 3));
        positions.push_back(p);
    }
    return positions;
}

std::vector<Vec3> lattice(int nx, int ny, int nz) {
    std::vector<Vec3> positions;
    const auto place = [](int i, int n) { return n > 1 ? 2.0f * float(i) / float(n - 1) - 1 : 0.0f; };
    for (int x = 0; x < nx; ++x)
        for (int y = 0; y < ny; ++y)
            for (int z = 0; z < nz; ++z) positions.emplace_back(place(x, nx), place(y, ny), place(z, nz));
    return positions;
}

double value_at(const Polynomials& p, const Vec3d& u) {
    const auto powers = monomials(Vec3(u));  // in float, as it is seen
    float sum = 0;
    for (std::size_t t = 0; t < p.terms.size(); ++t)
        sum += p.coefficients[t * 3] * powers[std::size_t(p.terms[t])];
    return double(sum);
}

BoxFit fit_values(const MapBox& box, const std::vector<Vec3>& positions, const std::vector<float>& values,
                  int degree = 3) {
    return fit_box(box, positions, {degree}, 1,
                   [&](std::size_t m) {
                       return DensityVolume::PerComponent{{Rgb(values[m])}, {0}};
                   },
                   {});
}

// ---- lamp positions

struct SampleCase {
    const char* name;
    Box3 domain;
    std::vector<Vec3> positions;
    int rank;
    bool warned;       // `bake` warns: terms are not determined, or badly
    double in_domain;  // largest error allowed where no sample was near; light of 1 ± 0.5
};

const Box3 kCube(Vec3(-1), Vec3(1));

std::vector<SampleCase> sample_cases() {
    const auto repeated = [](std::vector<Vec3> p) {
        const auto once = p;
        for (int i = 0; i < 3; ++i) p.insert(p.end(), once.begin(), once.end());
        return p;
    };
    auto coplanar = spread(60, Vec3(-1), Vec3(1)), collinear = coplanar;
    for (Vec3& p : coplanar) p.z = 0.25f;
    for (Vec3& p : collinear) p.y = p.z = p.x;
    const auto sized = [](const Vec3& half) { return Box3(-half, half); };
    const auto in = [&](const Box3& domain) { return spread(60, domain.min, domain.max); };
    const Box3 tiny = sized(Vec3(5e-4f)), huge = sized(Vec3(5e5f)),
               long_one = sized(Vec3(1e3f, 1e-3f, 1e-3f));
    return {
        {"spread, 60", kCube, spread(60, Vec3(-1), Vec3(1)), 20, false, 1e-5},
        {"grid 13 x 7 x 2", kCube, lattice(13, 7, 2), 16, true, 1e-5},
        {"grid 8 x 4 x 3", kCube, lattice(8, 4, 3), 19, true, 1e-5},
        {"grid 2 x 2 x 2", kCube, lattice(2, 2, 2), 8, true, 1e-5},
        {"coplanar", kCube, coplanar, 10, true, 0.3},
        {"collinear, along a diagonal", kCube, collinear, 4, true, 1.0},
        {"a single one", kCube, {Vec3(0.1f, 0.2f, 0.3f)}, 1, true, 1.0},
        {"two", kCube, {Vec3(-0.5f), Vec3(0.5f)}, 2, true, 1.0},
        {"19, nearly on a cubic", kCube, spread(19, Vec3(-1), Vec3(1)), 18, true, 1e-4},
        {"15, each four times", kCube, repeated(spread(15, Vec3(-1), Vec3(1))), 15, true, 1e-4},
        {"60 in a corner of a tenth", kCube, spread(60, Vec3(-1), Vec3(-0.8f)), 20, true, 0.1},
        {"60 in a corner of a thousandth", kCube, spread(60, Vec3(-1), Vec3(-0.998f)), 4, true, 1.0},
        {"domain 1 mm wide", tiny, in(tiny), 20, false, 1e-5},
        {"domain 1,000 km wide", huge, in(huge), 20, false, 1e-5},
        {"one axis 1,000,000 times longer", long_one, in(long_one), 20, false, 1e-5},
    };
}

class SampleCases : public testing::TestWithParam<std::size_t> {};

// Light that follows the lamp linearly: whatever terms are left can follow it as far as samples tell.
TEST_P(SampleCases, AreFittedAsFarAsTheyTell) {
    const SampleCase c = sample_cases()[GetParam()];
    const MapBox box = split_domain(c.domain, Index3(1))[0];
    const auto truth = [&](const Vec3d& at) {
        const Vec3d u = box.normalised(at);
        return 1 + 0.2 * u.x - 0.2 * u.y + 0.1 * u.z;
    };
    std::vector<float> values;
    for (const Vec3& p : c.positions) values.push_back(float(truth(Vec3d(p))));
    const BoxFit fit = fit_values(box, c.positions, values);
    const FitStatistics& s = fit.statistics;
    const int terms = int(terms_of(3, box.moves()).size());
    EXPECT_EQ(s.rank, c.rank);
    EXPECT_EQ(int(s.dropped.size()), terms - s.rank);
    EXPECT_EQ(s.rank < terms || s.condition_number > kBadCondition, c.warned);
    double at_samples = 0, in_domain = 0;
    for (const Vec3& p : c.positions)
        at_samples = std::max(
            at_samples, std::abs(value_at(fit.polynomials, box.normalised(Vec3d(p))) - truth(Vec3d(p))));
    for (const Vec3& u : lattice(9, 9, 9)) {
        const Vec3d at = box.centre + box.half * Vec3d(u);
        const double value = value_at(fit.polynomials, Vec3d(u));
        ASSERT_TRUE(std::isfinite(value));
        in_domain = std::max(in_domain, std::abs(value - truth(at)));
    }
    // Values are floats of relative rounding 2^-24; a design spreads them by its condition number at most.
    EXPECT_LT(at_samples, 1e-6 * (1 + 1e-2 * s.condition_number));
    EXPECT_LT(in_domain, c.in_domain);
    const double raw = raw_condition_number(box, c.positions, 3, Vec3d(1e6, 0, 0));
    add_to_table("samples",
                 {c.name, fmt::format("{} of {}", s.rank, terms), fmt::format("{:.2g}", s.condition_number),
                  raw < 9e18 ? fmt::format("{:.2g}", raw) : "> 9e18", fmt::format("{:.1g}", at_samples),
                  fmt::format("{:.1g}", in_domain), c.warned ? "warned" : "right"});
}

INSTANTIATE_TEST_SUITE_P(All, SampleCases, testing::Range(std::size_t{0}, sample_cases().size()));

// ---- against exact arithmetic

using Exact = boost::multiprecision::cpp_rational;

// The least-squares solution over monomials of u, by elimination without any rounding.
std::vector<Exact> exact_solution(const std::vector<Vec3d>& places, const std::vector<float>& values) {
    std::vector<std::array<Exact, kTermCount>> rows;
    for (const Vec3d& u : places) {
        auto& row = rows.emplace_back();
        const std::array<Exact, 3> x{Exact(u.x), Exact(u.y), Exact(u.z)};
        for (std::size_t t = 0; t < kTermCount; ++t) {
            row[t] = 1;
            for (std::size_t axis = 0; axis < 3; ++axis)
                for (int n = 0; n < kExponents[t][axis]; ++n) row[t] *= x[axis];
        }
    }
    std::vector<std::array<Exact, kTermCount + 1>> normal(kTermCount);
    for (std::size_t i = 0; i < kTermCount; ++i)
        for (std::size_t m = 0; m < rows.size(); ++m) {
            for (std::size_t j = 0; j < kTermCount; ++j) normal[i][j] += rows[m][i] * rows[m][j];
            normal[i][kTermCount] += rows[m][i] * Exact(values[m]);
        }
    for (std::size_t k = 0; k < kTermCount; ++k)  // positive definite: pivots are positive
        for (std::size_t i = 0; i < kTermCount; ++i) {
            if (i == k) continue;
            const Exact factor = normal[i][k] / normal[k][k];
            for (std::size_t j = k; j <= kTermCount; ++j) normal[i][j] -= factor * normal[k][j];
        }
    std::vector<Exact> solution;
    for (std::size_t k = 0; k < kTermCount; ++k) solution.push_back(normal[k][kTermCount] / normal[k][k]);
    return solution;
}

struct ExactCase {
    const char* name;
    Vec3 low, high;
};

class AgainstExact : public testing::TestWithParam<ExactCase> {};

TEST_P(AgainstExact, FloatCoefficientsAndFloatValues) {
    const ExactCase& c = GetParam();
    const MapBox box = split_domain(kCube, Index3(1))[0];
    const auto positions = spread(40, c.low, c.high);
    RandomStream random(9, RandomPurpose::evaluation, 0, 0);
    std::vector<float> values;
    for (std::size_t m = 0; m < positions.size(); ++m) values.push_back(0.5f + random.next());
    const BoxFit fit = fit_values(box, positions, values);
    ASSERT_EQ(fit.statistics.rank, kTermCount);
    std::vector<Vec3d> places;
    for (const Vec3& p : positions) places.push_back(box.normalised(Vec3d(p)));
    const auto exact = exact_solution(places, values);
    double largest = 0, coefficients = 0, value = 0, level = 0, sum = 0;
    for (std::size_t t = 0; t < kTermCount; ++t) {
        largest = std::max(largest, std::abs(double(exact[t])));
        sum += std::abs(double(exact[t]));
        coefficients =
            std::max(coefficients, std::abs(double(Exact(fit.polynomials.coefficients[t * 3]) - exact[t])));
    }
    for (const Vec3& u : lattice(5, 5, 5)) {  // corners among them
        const auto powers = monomials(Vec3d(u));
        double right = 0;
        for (std::size_t t = 0; t < kTermCount; ++t) right += double(exact[t]) * powers[t];
        level = std::max(level, std::abs(right));
        value = std::max(value, std::abs(value_at(fit.polynomials, Vec3d(u)) - right));
    }
    // Rounding to floats, and double arithmetic with volumes spread by the condition number, monomials of
    // Chebyshev products by at most 4 sqrt(20).
    const double kappa = fit.statistics.condition_number;
    EXPECT_LT(coefficients, (0x1p-24 + 20 * 4 * std::sqrt(20) * kappa * 0x1p-52) * largest);
    EXPECT_LT(value, (20 * 0x1p-24 + 20 * 4 * std::sqrt(20) * kappa * 0x1p-52) * sum);
    add_to_table("exact",
                 {c.name, fmt::format("{:.2g}", kappa), fmt::format("{:.1e}", coefficients / largest),
                  fmt::format("{:.1e}", value / level)});
}

INSTANTIATE_TEST_SUITE_P(All, AgainstExact,
                         testing::Values(ExactCase{"spread over the domain", Vec3(-1), Vec3(1)},
                                         ExactCase{"half of it on every axis", Vec3(0), Vec3(1)},
                                         ExactCase{"a fifth", Vec3(0.6f), Vec3(1)},
                                         ExactCase{"a slab of a tenth", Vec3(-1, -1, 0.8f), Vec3(1)},
                                         ExactCase{"a rod of a tenth", Vec3(-1, 0.8f, 0.8f), Vec3(1)},
                                         ExactCase{"a tenth", Vec3(0.8f), Vec3(1)}));

}  // namespace
}  // namespace pim
