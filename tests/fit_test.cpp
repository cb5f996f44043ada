// SPDX-License-Identifier: GPL-3.0-or-later
// Item 13 of the list of answers known in advance: a density that is a cubic comes back exactly.
#include "bake/fit.h"

#include "bake/light_samples.h"
#include "common/core/parallel.h"
#include "statistics.h"
#include "test_scenes.h"

namespace pim {
namespace {

// Well-spread positions in a lamp's domain.
std::vector<Vec3> spread(const Box3& domain, int count, const SampleCount& samples) {
    Light lamp = point_lamp(domain.center());
    lamp.domain = domain;
    lamp.samples = samples;
    std::vector<std::string> inside;
    std::vector<Vec3> positions;
    for (const LightSample& s : light_samples(lamp, 0, Solids({}, {}), inside))
        positions.push_back(s.position);
    EXPECT_EQ(int(positions.size()), count);
    return positions;
}

// Coefficients between -1 and 1, [patch][term][channel] over all twenty terms.
std::vector<double> random_cubics(std::size_t patches, const std::vector<int>& terms) {
    RandomStream random(1, RandomPurpose::evaluation, 0, 0);
    std::vector<double> a(patches * kTermCount * 3, 0.0);
    for (std::size_t p = 0; p < patches; ++p)
        for (const int t : terms)
            for (std::size_t c = 0; c < 3; ++c)
                a[(p * kTermCount + std::size_t(t)) * 3 + c] = 2 * random.next() - 1;
    return a;
}

DensityVolume::PerComponent volume_of(const std::vector<float>& channels, float variance = 0) {
    DensityVolume::PerComponent volume;
    for (std::size_t i = 0; i < channels.size(); i += 3)
        volume.density.emplace_back(channels[i], channels[i + 1], channels[i + 2]);
    volume.variance.assign(volume.density.size(), variance);
    return volume;
}

VolumeReader volumes_of(const std::vector<double>& a, const MapBox& box, const std::vector<Vec3>& positions) {
    return [&a, &box, &positions](std::size_t sample) {
        const auto m = monomials(box.normalised(Vec3d(positions[sample])));
        std::vector<float> values(a.size() / kTermCount);
        for (std::size_t i = 0; i < values.size(); ++i) {
            double sum = 0;
            for (std::size_t t = 0; t < kTermCount; ++t)
                sum += a[(i / 3 * kTermCount + t) * 3 + i % 3] * m[t];
            values[i] = float(sum);
        }
        return volume_of(values);
    };
}

void expect_cubics_back(const Box3& domain, int count, const SampleCount& samples,
                        const std::vector<int>& terms) {
    constexpr std::size_t kPatches = 5;
    const MapBox box = split_domain(domain, Index3(1))[0];
    const auto positions = spread(domain, count, samples);
    const auto a = random_cubics(kPatches, terms);
    const BoxFit fit = fit_box(box, positions, {3}, kPatches, volumes_of(a, box, positions), {});
    ASSERT_EQ(fit.statistics.rank, int(terms.size()));
    ASSERT_EQ(fit.polynomials.terms, terms);
    // Densities are rounded to float: each up to 20 · 2^-25. What a coefficient makes of that: at most times
    // the condition number times 4 sqrt(terms) for the change from Chebyshev products; then it is rounded to
    // float itself.
    const double rounding = 20 * 0x1p-25 * fit.statistics.condition_number * 4 * std::sqrt(20) + 0x1p-24;
    for (std::size_t p = 0; p < kPatches; ++p) {
        for (std::size_t t = 0; t < terms.size(); ++t)
            for (std::size_t c = 0; c < 3; ++c)
                EXPECT_NEAR(fit.polynomials.coefficients[(p * terms.size() + t) * 3 + c],
                            a[(p * kTermCount + std::size_t(terms[t])) * 3 + c], rounding);
        EXPECT_LT(fit.polynomials.residuals[p], rounding);
    }
}

constexpr std::array<bool, 3> kAll{true, true, true};

// The hat matrix is a projection: its diagonal adds to the rank. With one term each sample counts 1/n.
TEST(Fit, LeveragesAddToTheRank) {
    const Box3 domain(Vec3(-1, 2, 3), Vec3(1, 3, 7));
    const MapBox box = split_domain(domain, Index3(1))[0];
    const auto positions = spread(domain, 90, 90);
    const std::vector<Vec3d> at(positions.begin(), positions.end());
    for (const int degree : {0, 1, 2, 3}) {
        const auto leverage = leverages(box, positions, degree, at);
        double sum = 0;
        for (const double l : leverage) sum += l;
        EXPECT_NEAR(sum, double(terms_of(degree, {true, true, true}).size()), 1e-9);
    }
    EXPECT_NEAR(leverages(box, positions, 0, {Vec3d(box.centre)})[0], 1.0 / 90, 1e-12);
}

TEST(FitBox, CubicComesBackFromSpreadPositions) {
    expect_cubics_back(Box3(Vec3(-1, -2, -3), Vec3(1, 2, 3)), 40, 40, terms_of(3, kAll));
}

TEST(FitBox, CubicComesBackFromAGrid) {
    expect_cubics_back(Box3(Vec3(-1, -2, -3), Vec3(1, 2, 3)), 64, Index3(4), terms_of(3, kAll));
}

TEST(FitBox, CubicComesBackFarFromTheOriginAndAtAnyScale) {
    expect_cubics_back(Box3(Vec3(1000, -2000, 500), Vec3(1001, -1999, 502)), 60, 60, terms_of(3, kAll));
    expect_cubics_back(Box3(Vec3(-1e-6f), Vec3(1e-6f)), 60, 60, terms_of(3, kAll));
    expect_cubics_back(Box3(Vec3(-1e6f), Vec3(1e6f)), 60, 60, terms_of(3, kAll));
    expect_cubics_back(Box3(Vec3(0, -1e-3f, -1e3f), Vec3(1, 1e-3f, 1e3f)), 60, 60, terms_of(3, kAll));
}

TEST(FitBox, CubicOfAPlaneALineAndAPoint) {
    expect_cubics_back(Box3(Vec3(0, 5, 0), Vec3(2, 5, 3)), 30, 30, terms_of(3, {true, false, true}));
    expect_cubics_back(Box3(Vec3(1, 5, 0), Vec3(1, 6, 0)), 9, 9, terms_of(3, {false, true, false}));
    expect_cubics_back(Box3(Vec3(1, 5, 0)), 1, 1, {kConstantTerm});
}

TEST(FitBox, TooFewPositionsStillFitWhatTheyHold) {
    const Box3 domain(Vec3(-1), Vec3(1));
    const MapBox box = split_domain(domain, Index3(1))[0];
    for (const Index3& grid : {Index3(13, 7, 2), Index3(8, 4, 3), Index3(2)}) {
        const auto positions = spread(domain, grid.x * grid.y * grid.z, grid);
        const auto a = random_cubics(2, terms_of(1, kAll));  // linear: every such grid determines it
        const BoxFit fit = fit_box(box, positions, {3}, 2, volumes_of(a, box, positions), {});
        EXPECT_EQ(fit.statistics.rank, grid.x == 13 ? 16 : grid.x == 8 ? 19 : 8);
        for (std::size_t p = 0; p < 2; ++p) {
            EXPECT_LT(fit.polynomials.residuals[p], 1e-5);  // roundings, as above
            for (std::size_t t = 0; t < kTermCount; ++t)
                EXPECT_NEAR(fit.polynomials.coefficients[(p * kTermCount + t) * 3],
                            a[(p * kTermCount + t) * 3], 1e-5);
        }
    }
}

TEST(FitBox, RepeatedAndSinglePositions) {
    const Box3 domain(Vec3(-1), Vec3(1));
    const MapBox box = split_domain(domain, Index3(1))[0];
    const std::vector<Vec3> same(5, Vec3(0.5f));
    const auto seven = [](std::size_t) { return volume_of({7, 7, 7}); };
    const BoxFit fit = fit_box(box, same, {3}, 1, seven, {});
    EXPECT_EQ(fit.statistics.rank, 1);
    EXPECT_EQ(fit.statistics.samples, 5);
    EXPECT_NEAR(fit.polynomials.coefficients[3 * kConstantTerm], 7, 1e-6);
    EXPECT_NEAR(fit.polynomials.residuals[0], 0, 1e-6);
}

// --- noise ---

std::vector<float> gaussian(std::size_t count, uint64_t stream) {
    RandomStream random(1, RandomPurpose::evaluation, 0, stream);
    std::vector<float> values(count);
    for (float& v : values) {
        const float u = 1 - random.next();
        v = std::sqrt(-2 * std::log(u)) * std::cos(2 * kPi * random.next());
    }
    return values;
}

// Pure unit noise on a constant: a fit of k terms to M samples leaves 1 - k/M of its variance.
TEST(FitBox, ResidualOfNoise) {
    constexpr std::size_t kPatches = 200;
    constexpr int kSamples = 100;
    const Box3 domain(Vec3(-1), Vec3(1));
    const MapBox box = split_domain(domain, Index3(1))[0];
    const auto noise = [](std::size_t sample) { return volume_of(gaussian(3 * kPatches, sample)); };
    const BoxFit fit = fit_box(box, spread(domain, kSamples, kSamples), {3}, kPatches, noise, {});
    Mean squares;
    for (const float r : fit.polynomials.residuals) squares.add(double(r) * r);
    expect_mean(squares, 1 - 20.0 / kSamples);
}

// A lamp on a line or in a plane: 4 or 10 terms are stored, a fifth or half of 20, and take up 4/M or 10/M of
// the noise.
TEST(FitBox, LineAndPlaneKeepTheirTermsOnly) {
    constexpr std::size_t kPatches = 200;
    constexpr int kSamples = 100;
    const auto noise = [](std::size_t sample) { return volume_of(gaussian(3 * kPatches, sample)); };
    for (const auto& [highest, terms] : {std::pair{Vec3(1, 0, 0), 4}, std::pair{Vec3(1, 0, 1), 10}}) {
        const Box3 domain(Vec3(0), highest);
        const MapBox box = split_domain(domain, Index3(1))[0];
        const BoxFit fit = fit_box(box, spread(domain, kSamples, kSamples), {3}, kPatches, noise, {});
        EXPECT_EQ(fit.statistics.rank, terms);
        EXPECT_EQ(fit.polynomials.coefficients.size(), kPatches * std::size_t(terms) * 3);
        Mean squares;
        for (const float r : fit.polynomials.residuals) squares.add(double(r) * r);
        expect_mean(squares, 1 - double(terms) / kSamples);
    }
}

// A cube of cells; those at its corners have 8 patches around them, themselves among these.
Neighbourhoods one_neighbourhood(int side) {
    Cells cells;
    cells.grid.size = Index3(side);
    for (int x = 0; x < side; ++x)
        for (int y = 0; y < side; ++y)
            for (int z = 0; z < side; ++z) cells.patches.push_back({{x, y, z}, 0, 1, Vec3(0)});
    cells.index = PatchIndex(cells.grid, cells.patches);
    return {cells, false};
}

// Sum of squares of what the fit leaves besides the constant.
double movement(const Polynomials& p) {
    double sum = 0;
    for (std::size_t i = 0; i < p.coefficients.size(); ++i)
        if (p.terms[i / 3 % p.terms.size()] != kConstantTerm)
            sum += double(p.coefficients[i]) * p.coefficients[i];
    return sum;
}

// Noise alone: tau² is estimated from n = 8 patches at least × 3 channels × at least 3 terms, so it stays
// below sigma² · 5 sqrt(2/n), and the factor below 0.46 in amplitude for degree 1, less for the others.
TEST(FitBox, PureNoiseIsShrunk) {
    constexpr std::size_t kPatches = 27;
    const Box3 domain(Vec3(-1), Vec3(1));
    const MapBox box = split_domain(domain, Index3(1))[0];
    const auto positions = spread(domain, 100, 100);
    const auto noise = [](std::size_t sample) { return volume_of(gaussian(3 * kPatches, sample)); };
    const double plain = movement(fit_box(box, positions, {3}, kPatches, noise, {}).polynomials);
    const double shrunk =
        movement(fit_box(box, positions, {3}, kPatches, noise, one_neighbourhood(3)).polynomials);
    EXPECT_LT(shrunk, 0.46 * 0.46 * plain);
}

// A clear signal is kept: shrinkage by less than noise² / (M · signal²) per orthonormal term.
TEST(FitBox, SignalIsKept) {
    constexpr std::size_t kPatches = 27;
    const Box3 domain(Vec3(-1), Vec3(1));
    const MapBox box = split_domain(domain, Index3(1))[0];
    const auto positions = spread(domain, 100, 100);
    const auto a = random_cubics(kPatches, terms_of(3, kAll));
    const VolumeReader exact = volumes_of(a, box, positions);
    const VolumeReader noisy = [&](std::size_t sample) {
        auto values = exact(sample);
        const auto noise = gaussian(3 * values.density.size(), sample);
        for (std::size_t i = 0; i < noise.size(); ++i) values.density[i / 3][int(i % 3)] += 1e-2f * noise[i];
        return values;
    };
    const BoxFit plain = fit_box(box, positions, {3}, kPatches, noisy, {});
    const BoxFit shrunk = fit_box(box, positions, {3}, kPatches, noisy, one_neighbourhood(3));
    // Per orthonormal term the signal's power is at least M/100 of the coefficients' 1/3: the factor differs
    // from 1 by less than 1e-4 · 300 / M = 3e-4.
    for (std::size_t i = 0; i < plain.polynomials.coefficients.size(); ++i)
        EXPECT_NEAR(shrunk.polynomials.coefficients[i], plain.polynomials.coefficients[i],
                    3e-4 * 20);  // twenty products make one monomial's coefficient
}

TEST(FitBox, SameBytesAtAnyThreadCount) {
    constexpr std::size_t kPatches = 3000;  // several blocks of rows
    const Box3 domain(Vec3(-1), Vec3(1));
    const MapBox box = split_domain(domain, Index3(1))[0];
    const auto positions = spread(domain, 70, 70);
    const auto noise = [](std::size_t sample) { return volume_of(gaussian(3 * kPatches, sample)); };
    const auto fit_with = [&](int threads) {
        const ThreadLimit limit(threads);
        return fit_box(box, positions, {3}, kPatches, noise, Neighbourhoods()).polynomials.coefficients;
    };
    EXPECT_EQ(fit_with(1), fit_with(4));
}

}  // namespace
}  // namespace pim
