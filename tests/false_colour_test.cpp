// SPDX-License-Identifier: GPL-3.0-or-later
#include "viewer/tone/false_colour.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace pim {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();

double lightness(const Rgb& colour) { return 116 * std::cbrt(luminance(colour)) - 16; }  // L* above 8

TEST(FalseColour, LuminanceRisesStrictly) {
    float last = 0;
    for (int i = 0; i <= 1000; ++i) {
        const float y = luminance(colour_at(float(i) / 1000));
        EXPECT_GT(y, last) << i;
        last = y;
    }
}

TEST(FalseColour, LightnessRisesEvenly) {
    const double first = lightness(colour_at(0)), last = lightness(colour_at(1));
    EXPECT_GT(last - first, 70);
    for (int i = 0; i <= 100; ++i)
        EXPECT_NEAR(lightness(colour_at(float(i) / 100)), first + (last - first) * i / 100, 0.1);
}

TEST(FalseColour, EveryColourCanBeShown) {
    for (int i = 0; i <= 1000; ++i) {
        const Rgb c = colour_at(float(i) / 1000);
        for (int k = 0; k < 3; ++k) {
            EXPECT_GE(c[k], 0) << i;
            EXPECT_LE(c[k], 1) << i;
        }
    }
}

TEST(FalseColour, FromBlueOverGreenToYellow) {
    const Rgb low = colour_at(0), middle = colour_at(0.6f), high = colour_at(1);
    EXPECT_GT(low.z, 3 * std::max(low.x, low.y));
    EXPECT_GT(middle.y, 2 * std::max(middle.x, middle.z));
    EXPECT_GT(std::min(high.x, high.y), 10 * high.z);
}

TEST(FalseColour, NothingIsBlackAndTheRestIsCut) {
    const Scale scale{1, 10, false, "W/m²"};
    EXPECT_EQ(colour(scale, 0), Rgb(0));
    EXPECT_EQ(colour(scale, -2), Rgb(0));
    EXPECT_EQ(colour(scale, std::nanf("")), Rgb(0));
    EXPECT_EQ(colour(scale, 0.5f), colour_at(0));
    EXPECT_EQ(colour(scale, 1), colour_at(0));
    EXPECT_EQ(colour(scale, 10), colour_at(1));
    EXPECT_EQ(colour(scale, kInfinity), colour_at(1));
    EXPECT_EQ(colour(scale, 5.5f), colour_at(0.5f));
}

TEST(FalseColour, PicturesAreColouredByLuminance) {
    Image values(2, 1);
    values.at(0, 0) = Rgb(0, 1, 0);
    const Image coloured = false_colours(values, {0, 2, false, ""});
    EXPECT_EQ(coloured.at(0, 0), colour_at(0.3576f));  // 0.7152 of 2
    EXPECT_EQ(coloured.at(1, 0), Rgb(0));
}

TEST(Scale, LogarithmicPlacesAreEqualRatios) {
    const Scale scale{0.01f, 100, true, ""};
    EXPECT_NEAR(place(scale, 0.1f), 0.25, 1e-6);
    EXPECT_NEAR(place(scale, 1), 0.5, 1e-6);
    EXPECT_NEAR(place(scale, 10), 0.75, 1e-6);
    EXPECT_EQ(place(scale, 0), 0);
    EXPECT_EQ(place(scale, 1e9f), 1);
}

bool is_1_2_5(double value) {
    const double digit = value / std::pow(10, std::floor(std::log10(value) + 1e-6));
    return std::abs(digit - 1) < 1e-4 || std::abs(digit - 2) < 1e-4 || std::abs(digit - 5) < 1e-4;
}

void check_ticks(const Scale& scale) {
    SCOPED_TRACE(testing::Message() << scale.low << " to " << scale.high
                                    << (scale.logarithmic ? " log" : ""));
    const std::vector<Tick> found = ticks(scale);
    EXPECT_GE(found.size(), 3u);
    EXPECT_LE(found.size(), 11u);
    for (std::size_t i = 0; i < found.size(); ++i) {
        EXPECT_GE(found[i].value, scale.low);
        EXPECT_LE(found[i].value, scale.high);
        EXPECT_GE(found[i].place, 0);
        EXPECT_LE(found[i].place, 1);
        EXPECT_NEAR(std::stod(found[i].label), found[i].value,
                    1e-6 * (scale.logarithmic ? found[i].value : std::abs(scale.low) + scale.high));
        if (i > 0) {
            EXPECT_GT(found[i].place, found[i - 1].place);
            EXPECT_NE(found[i].label, found[i - 1].label);
        }
    }
}

TEST(Ticks, AreOrderedAndInsideTheScale) {
    for (const float low : {0.0f, 0.03f, 7.0f, 990.0f})
        for (const float extent : {0.01f, 0.37f, 1.0f, 12.0f, 999.0f, 4e5f})
            for (const bool logarithmic : {false, true})
                if (low > 0 || !logarithmic) check_ticks({low, low + extent, logarithmic, ""});
    check_ticks({-3, 4, false, ""});
    check_ticks({1e-12f, 1e12f, true, ""});
    check_ticks({3e-9f, 1e3f, true, ""});
    check_ticks({1e-30f, 3e38f, true, ""});
}

TEST(Ticks, LinearOnesAreARoundStepApart) {
    for (const float high : {0.07f, 1.0f, 3.3f, 48.0f, 51.0f, 12345.0f}) {
        const std::vector<Tick> found = ticks({0, high, false, ""});
        EXPECT_EQ(found.front().value, 0);
        const double step = found[1].value;
        EXPECT_TRUE(is_1_2_5(step)) << step;
        for (std::size_t i = 1; i < found.size(); ++i)
            EXPECT_NEAR(found[i].value, step * double(i), 1e-6 * high);
    }
}

TEST(Ticks, LogarithmicOnesAreRoundThemselves) {
    for (const Tick& tick : ticks({0.034f, 21, true, ""})) EXPECT_TRUE(is_1_2_5(tick.value)) << tick.value;
    const std::vector<Tick> wide = ticks({0.001f, 1000, true, ""});
    ASSERT_EQ(wide.size(), 7u);
    EXPECT_EQ(wide[0].label, "0.001");
    EXPECT_EQ(wide[6].label, "1000");
    EXPECT_NEAR(wide[3].place, 0.5, 1e-6);
}

TEST(Ticks, NoneOfScalesThatAreNone) {
    EXPECT_TRUE(ticks({1, 1, false, ""}).empty());
    EXPECT_TRUE(ticks({2, 1, false, ""}).empty());
    EXPECT_TRUE(ticks({0, 1, true, ""}).empty());
    EXPECT_TRUE(ticks({0, kInfinity, false, ""}).empty());
    EXPECT_TRUE(ticks({std::nanf(""), 1, false, ""}).empty());
    EXPECT_EQ(place({1, 1, false, ""}, 1), 0.5f);
}

TEST(Lux, OfWhiteAndOfColours) {
    EXPECT_NEAR(lux(Rgb(1)), 683, 1e-3);
    EXPECT_NEAR(lux(Rgb(2, 0, 0)), 2 * 683 * 0.2126, 1e-3);
    EXPECT_NEAR(lux(Rgb(1, 0, 0)) + lux(Rgb(0, 1, 0)) + lux(Rgb(0, 0, 1)), 683, 1e-3);
}

TEST(Lux, BothSidesOfTheLegendAgree) {
    const Scale watts{0, 3, false, "W/m²"}, luxes = in_lux(watts);
    EXPECT_EQ(luxes.unit, "lx");
    for (const Tick& tick : ticks(luxes)) EXPECT_NEAR(tick.place, place(watts, tick.value / 683), 1e-6);
    EXPECT_EQ(label(watts, 2), "2.00 W/m² (1366 lx)");
    EXPECT_EQ(label(watts, 0.012345f), "0.0123 W/m² (8.43 lx)");
    EXPECT_EQ(label({0, 1, false, ""}, 0.25f), "0.250");
    EXPECT_EQ(label({0, 1, false, ""}, 0), "0");
    EXPECT_EQ(label({0, 1, false, ""}, 2.5e-7f), "2.5e-07");
}

TEST(AutomaticScale, IsNotMovedByStrays) {
    Image values(100, 100);
    for (int i = 0; i < 10000; ++i) values.pixels[std::size_t(i)] = Rgb(1 + 9 * float(i) / 9999);
    const Scale clean = automatic_scale(values, true, "W/m²");
    EXPECT_NEAR(clean.high, 9.91, 0.02);
    for (int i = 0; i < 20; ++i) {
        values.pixels[std::size_t(500 * i)] = Rgb(i % 2 ? 1e6f : 1e-6f);
        values.pixels[std::size_t(500 * i + 1)] = Rgb(i % 2 ? kInfinity : std::nanf(""));
    }
    const Scale strays = automatic_scale(values, true, "W/m²");
    EXPECT_NEAR(strays.high, clean.high, 0.02);
    EXPECT_NEAR(strays.low, clean.low, 0.02);
    EXPECT_EQ(automatic_scale(values, false, "").low, 0);
}

TEST(AutomaticScale, BlackOrEvenPicturesGetOneToo) {
    for (const bool logarithmic : {false, true}) {
        EXPECT_FALSE(ticks(automatic_scale(Image(), logarithmic, "")).empty());
        EXPECT_FALSE(ticks(automatic_scale(Image(3, 3), logarithmic, "")).empty());
        Image even(3, 3);
        even.pixels.assign(9, Rgb(4));
        const Scale scale = automatic_scale(even, logarithmic, "");
        EXPECT_FALSE(ticks(scale).empty());
        EXPECT_EQ(place(scale, 4), 1);
    }
}

}  // namespace
}  // namespace pim
