// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/scene/texture.h"

#include <gtest/gtest.h>

#include <cmath>

namespace pim {
namespace {

Image picture() {  // top row 1 2 3 4, bottom row 5 6 7 8
    Image image(4, 2);
    for (int i = 0; i < 8; ++i) image.pixels[std::size_t(i)] = Rgb(float(i + 1));
    return image;
}

constexpr float kRounding = 1e-5f;

TEST(SampleTexture, TexelCentresFromTheLowerLeft) {
    const Image image = picture();
    EXPECT_NEAR(sample_texture(image, {0.125f, 0.25f}).x, 5, kRounding);
    EXPECT_NEAR(sample_texture(image, {0.875f, 0.25f}).x, 8, kRounding);
    EXPECT_NEAR(sample_texture(image, {0.125f, 0.75f}).x, 1, kRounding);
}

TEST(SampleTexture, BilinearBetweenCentres) {
    EXPECT_NEAR(sample_texture(picture(), {0.25f, 0.25f}).x, 5.5, kRounding);
    EXPECT_NEAR(sample_texture(picture(), {0.25f, 0.5f}).x, 3.5, kRounding);
}

TEST(SampleTexture, RepeatsInBothDirections) {
    const Image image = picture();
    EXPECT_NEAR(sample_texture(image, {0, 0.25f}).x, 6.5, kRounding);  // between the last and the first
    for (const Vec2& uv : {Vec2(0.3f, 0.6f), Vec2(0.9f, 0.1f)})
        for (const float shift : {1.0f, -3.0f})
            EXPECT_NEAR(sample_texture(image, uv + Vec2(shift, 2 * shift)).x, sample_texture(image, uv).x,
                        1e-4);
}

TEST(SampleTexture, NoNumbersAreBlack) {
    EXPECT_EQ(sample_texture(picture(), {std::nanf(""), 0}), Rgb(0));
    EXPECT_EQ(sample_texture(picture(), {INFINITY, 0}), Rgb(0));
}

}  // namespace
}  // namespace pim
