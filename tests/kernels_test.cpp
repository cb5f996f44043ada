// SPDX-License-Identifier: GPL-3.0-or-later
// Each vector unit against double precision, and against the plain one: sums, shadow rays, colours.
// kernels_look_up_test.cpp does so for surfaces and the weights of their patches.
#include "viewer/relight/kernels.h"

#include <array>
#include <cmath>
#include <limits>

#include "kernels_of.h"
#include "viewer/tone/tone_curve.h"

namespace pim {
namespace {

Floats random_floats(std::size_t count, Dice& dice, float low = -1, float high = 1) {
    Floats values(count);
    for (float& v : values) v = dice.between(low, high);
    return values;
}

PIM_FOR_EACH_UNIT(KernelsOf);

TEST(VectorUnits, GoByTheirNames) {
    for (const VectorUnit unit : {VectorUnit::plain, VectorUnit::avx2, VectorUnit::avx512})
        EXPECT_EQ(find_vector_unit(name(unit)), unit);
    EXPECT_FALSE(find_vector_unit("sse"));
    EXPECT_TRUE(is_supported(VectorUnit::plain));
    EXPECT_TRUE(is_supported(best_vector_unit()));
}

// --- evaluate ---

struct Evaluation {
    int terms, channels;
    Floats coefficients, start;
    std::vector<float> monomials;
    std::array<float, 3> power;

    Evaluation(int t, int c, Dice& dice)
        : terms(t),
          channels(c),
          coefficients(random_floats(std::size_t(t * c * kLanes), dice)),
          start(random_floats(3 * kLanes, dice)) {
        for (int i = 0; i < terms; ++i) monomials.push_back(dice.between(-1, 1));
        for (float& p : power) p = dice.between(0, 100);
    }
    Floats sum_of(const Kernels& k) const {
        Floats sum = start;
        k.evaluate(coefficients.data(), terms, channels, monomials.data(), power.data(), sum.data());
        return sum;
    }
    // The sum at [channel][lane], the sum of its terms' magnitudes, and the largest of them.
    struct Expected {
        double value, magnitude, largest;
    };
    Expected expected(int channel, int lane) const {
        const double first = start[std::size_t(channel * kLanes + lane)];
        Expected e{first, std::abs(first), std::abs(first)};
        for (int t = 0; t < terms; ++t) {
            const int own = channels == 1 ? 0 : channel;
            const double term = double(power[std::size_t(channel)]) * double(monomials[std::size_t(t)]) *
                                double(coefficients[std::size_t((t * channels + own) * kLanes + lane)]);
            e.value += term;
            e.magnitude += std::abs(term);
            e.largest = std::max(e.largest, std::abs(term));
        }
        return e;
    }
};

// A term passes through its product, at most `terms` additions, the power and the last addition.
TEST_P(KernelsOf, EvaluateSumsAllTerms) {
    Largest error("error_by_largest_term"), apart("from_plain_by_largest_term");
    for (const int channels : {1, 3})
        for (int terms = 1; terms <= kTermCount; ++terms)
            for (int repeat = 0; repeat < 20; ++repeat) {
                const Evaluation e(terms, channels, dice_);
                const Floats sum = e.sum_of(own()), reference = e.sum_of(plain());
                for (int i = 0; i < 3 * kLanes; ++i) {
                    const auto at = std::size_t(i);
                    const auto x = e.expected(i / kLanes, i % kLanes);
                    ASSERT_NEAR(sum[at], x.value, (terms + 3) * kRound * x.magnitude)
                        << terms << " terms, " << channels << " channels";
                    ASSERT_NEAR(sum[at], reference[at], 1e-5 * x.largest);
                    error.add((double(sum[at]) - x.value) / x.largest);
                    apart.add((double(sum[at]) - double(reference[at])) / x.largest);
                }
            }
}

TEST_P(KernelsOf, EvaluateOneTermIsExact) {
    Floats sum(3 * kLanes, 2.0f), coefficients(3 * kLanes);
    for (int i = 0; i < 3 * kLanes; ++i) coefficients[std::size_t(i)] = float(i);
    const float one = 1, power[3] = {1, 2, 4};
    own().evaluate(coefficients.data(), 1, 3, &one, power, sum.data());
    for (int i = 0; i < 3 * kLanes; ++i)
        EXPECT_EQ(sum[std::size_t(i)], 2 + power[i / kLanes] * float(i)) << i;
}

// --- pack and gather ---

std::vector<Weight, LineAllocator<Weight>> random_weights(std::size_t count, Dice& dice) {
    std::vector<Weight, LineAllocator<Weight>> weights;
    for (std::size_t i = 0; i < count; ++i) weights.push_back(Weight(dice.between(0, kWeightSteps)));
    return weights;
}

// Every sum from the first weight on is right to half a step, and so is each weight to a whole one; float
// rounding of numbers up to 65535 is far below.
TEST_P(KernelsOf, PackedWeightsKeepTheirSums) {
    for (int entries = 1; entries <= kMostEntries; ++entries) {
        Floats weights = random_floats(std::size_t(entries * kLanes), dice_, 0);
        for (int lane = 0; lane < kLanes; ++lane) {
            double sum = 0;
            for (int e = 0; e < entries; ++e) {
                if (e % 3 == 2) weights[std::size_t(e * kLanes + lane)] = 0;
                sum += double(weights[std::size_t(e * kLanes + lane)]);
            }
            for (int e = 0; e < entries; ++e) weights[std::size_t(e * kLanes + lane)] /= float(sum);
        }
        std::vector<Weight, LineAllocator<Weight>> packed(weights.size());
        own().pack(weights.data(), entries, packed.data());
        for (int lane = 0; lane < kLanes; ++lane) {
            double left = 0;
            for (int e = 0; e < entries; ++e) {
                const auto at = std::size_t(e * kLanes + lane);
                left += double(weights[at]) * double(kWeightSteps) - double(packed[at]);
                ASSERT_LE(std::abs(left), 0.5 + 0.01 * entries) << e << " of " << entries;
                ASSERT_TRUE(weights[at] > 0 || packed[at] == 0);
            }
        }
    }
    Floats one(kLanes, 1.0f);
    std::vector<Weight, LineAllocator<Weight>> packed(kLanes);
    own().pack(one.data(), 1, packed.data());
    for (const Weight w : packed) EXPECT_EQ(w, Weight(kWeightSteps));
}

TEST_P(KernelsOf, GatherSumsAllEntries) {
    Largest error("error_by_largest_term"), apart("from_plain_by_largest_term");
    for (int entries = 0; entries <= 48; ++entries)
        for (int repeat = 0; repeat < 10; ++repeat) {
            const auto weights = random_weights(std::size_t(entries * kLanes), dice_);
            std::vector<float> values;
            for (int i = 0; i < 3 * entries; ++i) values.push_back(dice_.between(-0.2f, 1));
            Floats sum(3 * kLanes, 9.0f), reference(3 * kLanes);
            own().gather(weights.data(), values.data(), entries, sum.data());
            plain().gather(weights.data(), values.data(), entries, reference.data());
            for (int c = 0; c < 3; ++c)
                for (int lane = 0; lane < kLanes; ++lane) {
                    double expected = 0, magnitude = 0, largest = 0;
                    for (int e = 0; e < entries; ++e) {
                        const double term = double(weights[std::size_t(e * kLanes + lane)]) /
                                            double(kWeightSteps) * double(values[std::size_t(3 * e + c)]);
                        expected += term, magnitude += std::abs(term);
                        largest = std::max(largest, std::abs(term));
                    }
                    const auto at = std::size_t(c * kLanes + lane);
                    ASSERT_NEAR(sum[at], expected, (entries + 3) * kRound * magnitude);
                    ASSERT_NEAR(sum[at], reference[at], 1e-5 * largest);
                    if (largest > 0) error.add((double(sum[at]) - expected) / largest);
                    if (largest > 0) apart.add((double(sum[at]) - double(reference[at])) / largest);
                }
        }
}

// --- aim ---

struct Aimed {
    Floats surfaces = Floats(kSurfaceRows * kLanes), targets = Floats(3 * kLanes);
    Floats origin = Floats(3 * kLanes), direction = Floats(3 * kLanes), term = Floats(kLanes);

    void set(int lane, const Vec3& position, const Vec3& normal, const Vec3& geometric, const Vec3& target) {
        for (int axis = 0; axis < 3; ++axis) {
            surfaces[std::size_t(axis * kLanes + lane)] = position[axis];
            surfaces[std::size_t((3 + axis) * kLanes + lane)] = normal[axis];
            surfaces[std::size_t((6 + axis) * kLanes + lane)] = geometric[axis];
            targets[std::size_t(axis * kLanes + lane)] = target[axis];
        }
    }
    Vec3d surface(int row, int lane) const {
        Vec3d v;
        for (int axis = 0; axis < 3; ++axis) v[axis] = surfaces[std::size_t((row + axis) * kLanes + lane)];
        return v;
    }
    static Vec3d at(const Floats& rows, int lane) {
        return {rows[std::size_t(lane)], rows[std::size_t(kLanes + lane)],
                rows[std::size_t(2 * kLanes + lane)]};
    }
    void aim(const Kernels& k, const Vec3* lamp, float offset) {
        const ShadowRays rays{{&origin[0], &origin[kLanes], &origin[2 * kLanes]},
                              {&direction[0], &direction[kLanes], &direction[2 * kLanes]},
                              term.data()};
        k.aim(surfaces.data(), targets.data(), lamp ? &lamp->x : nullptr, offset, rays);
    }
};

// Cosines of unit vectors are sums of three products that cancel: off by 6 roundings of 1. The rest of
// cos cos' / d² brings some dozen roundings of itself, which is at most 1 / d².
TEST_P(KernelsOf, AimIsTheGeometryTerm) {
    constexpr float kOffset = 0x1p-18f;
    constexpr double kTerm = 32 * kRound;
    const Vec3 lamp_normal = Vec3(0.3f, -1, 0.2f).normalized();
    Largest error("error_by_inverse_square"), apart("from_plain_by_inverse_square");
    int lit = 0, behind = 0;
    for (const Vec3* lamp : {static_cast<const Vec3*>(nullptr), &lamp_normal})
        for (int repeat = 0; repeat < 400; ++repeat) {
            Aimed aimed;
            for (int lane = 0; lane < kLanes; ++lane) {
                const Vec3 geometric = dice_.direction();
                const Vec3 normal = (geometric + dice_.direction() * dice_.between(0, 0.9f)).normalized();
                aimed.set(lane, dice_.inside({Vec3(-3), Vec3(3)}), normal, geometric,
                          dice_.inside({Vec3(-3), Vec3(3)}));
            }
            Aimed other = aimed;
            aimed.aim(own(), lamp, kOffset);
            other.aim(plain(), lamp, kOffset);
            for (int lane = 0; lane < kLanes; ++lane) {
                const Vec3d p = aimed.surface(0, lane), target = Aimed::at(aimed.targets, lane);
                const Vec3d way = target - p, to = way.normalized();
                const double d2 = way.length2(), cosine = to.dot(aimed.surface(3, lane)),
                             geometric = to.dot(aimed.surface(6, lane));
                const double lamp_cosine = lamp ? std::max(0.0, -to.dot(Vec3d(*lamp))) : 1;
                const float term = aimed.term[std::size_t(lane)];
                if (std::abs(geometric) > 16 * kRound) {  // else either side is right
                    const double expected = geometric > 0 ? std::max(0.0, cosine) * lamp_cosine / d2 : 0;
                    ASSERT_NEAR(term, expected, kTerm / d2);
                    ASSERT_NEAR(term, other.term[std::size_t(lane)], 1e-5 / d2);
                    error.add((double(term) - expected) * d2);
                    apart.add((double(term) - double(other.term[std::size_t(lane)])) * d2);
                    if (geometric < 0 || cosine < -kTerm || (lamp && to.dot(Vec3d(*lamp)) > kTerm)) {
                        ASSERT_EQ(term, 0);
                        ++behind;
                    }
                    lit += expected > 0;
                }
                const Vec3d origin = Aimed::at(aimed.origin, lane);
                const Vec3d off = p + aimed.surface(6, lane) * double(kOffset);
                const Vec3d end = origin + Aimed::at(aimed.direction, lane);
                ASSERT_NEAR((origin - off).length(), 0, 4 * 3 * kRound * 3) << "start";
                ASSERT_NEAR((end - target).length(), 0, 4 * 6 * kRound * 2) << "end";
            }
        }
    EXPECT_GT(lit, 2000);
    EXPECT_GT(behind, 2000);
}

TEST_P(KernelsOf, AimFromTheLampItselfIsNoRay) {
    Aimed aimed;
    for (int lane = 0; lane < kLanes; ++lane) aimed.set(lane, Vec3(1, 2, 3), {0, 1, 0}, {0, 1, 0}, {1, 2, 3});
    const Vec3 down(0, -1, 0);
    for (const Vec3* lamp : {static_cast<const Vec3*>(nullptr), &down}) {
        aimed.aim(own(), lamp, 1e-6f);
        for (const float term : aimed.term) EXPECT_EQ(term, 0);
    }
}

// --- encode ---

std::vector<uint32_t> encoded(const Kernels& k, const std::vector<float>& values, float exposure,
                              ToneCurve curve) {
    std::vector<uint32_t> result;
    Floats linear(3 * kLanes);
    alignas(64) uint32_t rgba[kLanes];
    for (std::size_t first = 0; first < values.size(); first += kLanes) {
        for (std::size_t lane = 0; lane < kLanes; ++lane)
            for (std::size_t c = 0; c < 3; ++c)
                linear[c * kLanes + lane] = values[std::min(first + lane, values.size() - 1)];
        k.encode(linear.data(), exposure, int(curve), rgba);
        result.insert(result.end(), rgba, rgba + kLanes);
    }
    result.resize(values.size());
    return result;
}

int byte(uint32_t rgba, int channel) { return int(rgba >> (8 * channel) & 0xff); }

TEST_P(KernelsOf, EncodeIsExposureCurveAndSrgb) {
    std::vector<float> ramp;
    for (int i = 0; i <= 1 << 17; ++i) ramp.push_back(float(i) * 1.25f / (1 << 17));  // dense
    for (int i = 0; i <= 1 << 15; ++i) ramp.push_back(std::pow(10.0f, -9 + 18 * float(i) / (1 << 15)));
    Largest largest_off("share_off_by_one");
    for (const ToneCurve curve : {ToneCurve::none, ToneCurve::reinhard, ToneCurve::aces})
        for (const float exposure : {1.0f, 0.37f, 23.0f}) {
            const auto own_bytes = encoded(own(), ramp, exposure, curve),
                       plain_bytes = encoded(plain(), ramp, exposure, curve);
            std::size_t off = 0, from_plain = 0;
            for (std::size_t i = 0; i < ramp.size(); ++i) {
                const long expected = std::lround(255 * srgb_encode(apply(curve, ramp[i] * exposure)));
                const int found = byte(own_bytes[i], 0);
                ASSERT_LE(std::abs(found - expected), 1) << ramp[i] << ", curve " << int(curve);
                ASSERT_EQ(own_bytes[i], 0xff000000u + 0x10101u * uint32_t(found));
                ASSERT_LE(std::abs(found - byte(plain_bytes[i], 0)), 1);
                off += found != expected;
                from_plain += own_bytes[i] != plain_bytes[i];
            }
            EXPECT_LT(double(off), 1e-3 * double(ramp.size())) << "curve " << int(curve);
            EXPECT_LT(double(from_plain), 1e-3 * double(ramp.size()));
            largest_off.add(double(off) / double(ramp.size()));
        }
}

// The formula of IEC 61966-2-1 in double, where a byte turns to the next: within the 1e-5 of the polynomial,
// a rounding of the curve's argument and those of 255 e + 0.5.
TEST_P(KernelsOf, EncodeTurnsWhereSrgbDoes) {
    const auto decode = [](double e) {
        return e <= 0.04045 ? e / 12.92 : std::pow((e + 0.055) / 1.055, 2.4);
    };
    constexpr double kOff = 1e-5 + 16 * kRound;
    for (int k = 1; k <= 255; ++k) {
        const double turn = (k - 0.5) / 255;
        const auto bytes =
            encoded(own(), {float(decode(turn - kOff)), float(decode(turn + kOff))}, 1, ToneCurve::none);
        EXPECT_EQ(byte(bytes[0], 0), k - 1) << k;
        EXPECT_EQ(byte(bytes[1], 0), k) << k;
    }
}

TEST_P(KernelsOf, EncodeOfNoNumbers) {
    constexpr float kInfinity = std::numeric_limits<float>::infinity();
    constexpr float kLargest = std::numeric_limits<float>::max();
    const std::vector<float> black = {NAN, -NAN, -kInfinity, -1, -0.0f, 0, 1e-42f, -kLargest},
                             white = {kInfinity, kLargest, 1e30f};
    for (const ToneCurve curve : {ToneCurve::none, ToneCurve::reinhard, ToneCurve::aces})
        for (const float exposure : {1.0f, 100.0f}) {
            for (const uint32_t rgba : encoded(own(), black, exposure, curve)) EXPECT_EQ(rgba, 0xff000000u);
            for (const uint32_t rgba : encoded(own(), white, exposure, curve)) EXPECT_EQ(rgba, 0xffffffffu);
        }
    for (const uint32_t rgba : encoded(own(), white, 0, ToneCurve::none))  // inf · 0 is no number
        EXPECT_EQ(rgba, 0xff000000u);
}

TEST_P(KernelsOf, EncodeKeepsChannelsAndLanesApart) {
    Floats linear(3 * kLanes);
    for (int i = 0; i < 3 * kLanes; ++i) linear[std::size_t(i)] = srgb_decode(float(5 * i) / 255);
    alignas(64) uint32_t rgba[kLanes];
    own().encode(linear.data(), 1, int(ToneCurve::none), rgba);
    for (int lane = 0; lane < kLanes; ++lane)
        for (int c = 0; c < 3; ++c) EXPECT_EQ(byte(rgba[lane], c), 5 * (c * kLanes + lane));
}

}  // namespace
}  // namespace pim
