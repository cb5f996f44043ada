// SPDX-License-Identifier: GPL-3.0-or-later
#include "viewer/tone/tone_curve.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "common/core/error.h"
#include "common/core/image.h"
#include "temporary_folder.h"

namespace pim {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();

TEST(ToneCurve, NoneCutsAtWhite) {
    EXPECT_EQ(apply(ToneCurve::none, 0.3f), 0.3f);
    EXPECT_EQ(apply(ToneCurve::none, 1), 1);
    EXPECT_EQ(apply(ToneCurve::none, 1.01f), 1);
}

TEST(ToneCurve, ReinhardHalvesOneAndNeverReachesWhite) {
    EXPECT_FLOAT_EQ(apply(ToneCurve::reinhard, 1), 0.5f);
    EXPECT_FLOAT_EQ(apply(ToneCurve::reinhard, 3), 0.75f);
    EXPECT_NEAR(apply(ToneCurve::reinhard, 1e-4f), 1e-4, 2e-8);  // x − x² + …
    EXPECT_LT(apply(ToneCurve::reinhard, 1000), 1);
}

TEST(ToneCurve, AcesAtPlacesWorkedOutByHand) {
    EXPECT_NEAR(apply(ToneCurve::aces, 1), 2.54 / 3.16, 1e-6);
    EXPECT_NEAR(apply(ToneCurve::aces, 2), 10.1 / 11.04, 1e-6);
    EXPECT_NEAR(apply(ToneCurve::aces, 1e-4f), 1e-4 * 0.03 / 0.14, 2e-7);  // its slope at black
    // equal to 1 where 0.08 x² − 0.56 x − 0.14 = 0: x = 7.242…
    const float white = (0.56f + std::sqrt(0.56f * 0.56f + 4 * 0.08f * 0.14f)) / 0.16f;
    EXPECT_LT(apply(ToneCurve::aces, white - 0.05f), 1);
    EXPECT_EQ(apply(ToneCurve::aces, white + 0.05f), 1);
}

TEST(ToneCurve, RiseFromBlackToWhite) {
    for (const ToneCurve curve : kToneCurves) {
        float last = apply(curve, 0);
        EXPECT_EQ(last, 0);
        for (float x = 1e-6f; x < 1e38f; x *= 1.3f) {
            const float y = apply(curve, x);
            EXPECT_GE(y, last) << description(curve) << " at " << x;
            EXPECT_LE(y, 1);
            last = y;
        }
        EXPECT_EQ(last, 1) << description(curve);
    }
}

TEST(ToneCurve, TakesWhatIsNoLight) {
    for (const ToneCurve curve : kToneCurves) {
        EXPECT_EQ(apply(curve, std::nanf("")), 0);
        EXPECT_EQ(apply(curve, -1), 0);
        EXPECT_EQ(apply(curve, -kInfinity), 0);
        EXPECT_EQ(apply(curve, kInfinity), 1);
        EXPECT_EQ(to_8bit(curve, std::nanf("")), 0);
        EXPECT_EQ(to_8bit(curve, kInfinity), 255);
        EXPECT_EQ(to_8bit(curve, std::numeric_limits<float>::max()), 255);
    }
}

TEST(ToneCurve, WithoutACurveTheBytesAreThoseOfAWrittenPicture) {
    const TemporaryFolder folder;
    Image image(400, 1);
    for (int i = 0; i < 400; ++i) image.at(i, 0) = Rgb(-0.1f + 0.0031f * float(i));
    write_image(folder / "ramp.png", image, 1);
    const Image read = read_image(folder / "ramp.png");
    for (int i = 0; i < 400; ++i)
        EXPECT_EQ(std::lround(255 * srgb_encode(read.at(i, 0).x)),
                  to_8bit(ToneCurve::none, image.at(i, 0).x));
}

TEST(ToneCurve, GreyOfTheStandard) {  // half of full code is 0.2140 linear in IEC 61966-2-1
    EXPECT_NEAR(to_8bit(ToneCurve::none, 0.21404f), 127.5, 0.5);
    EXPECT_EQ(to_8bit(ToneCurve::reinhard, 0.21404f / (1 - 0.21404f)),
              to_8bit(ToneCurve::none, 0.21404f));  // x/(1−x) undoes Reinhard
}

TEST(ToneCurve, FormulasInALine) {
    for (const ToneCurve curve : kToneCurves) {
        EXPECT_NE(description(curve).find('x'), std::string_view::npos);
        EXPECT_EQ(description(curve).find('\n'), std::string_view::npos);
    }
}

}  // namespace
}  // namespace pim
