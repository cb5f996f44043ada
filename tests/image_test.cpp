// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/core/image.h"

#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <thread>

#include "common/core/error.h"
#include "temporary_folder.h"

namespace pim {
namespace {

Image test_image() {
    Image image(5, 3);
    for (int i = 0; i < 15; ++i) image.pixels[std::size_t(i)] = Rgb(float(i) / 15, 0.5f, 3.25e-3f * float(i));
    return image;
}

TEST(Srgb, ValuesOfTheStandard) {
    EXPECT_EQ(srgb_encode(0), 0);
    EXPECT_NEAR(srgb_encode(1), 1, 1e-6);
    EXPECT_NEAR(srgb_encode(0.214041f), 0.5, 1e-5);  // mid grey of IEC 61966-2-1
    EXPECT_NEAR(srgb_encode(0.002f), 0.002 * 12.92, 1e-7);
    EXPECT_EQ(srgb_encode(-1), 0);
    EXPECT_NEAR(srgb_encode(7), 1, 1e-6);
    EXPECT_EQ(srgb_encode(std::nanf("")), 0);
}

TEST(Srgb, DecodingUndoesEncoding) {
    for (int i = 0; i <= 1000; ++i) {
        const float x = float(i) / 1000;
        EXPECT_NEAR(srgb_decode(srgb_encode(x)), x, 2e-6);  // roundings of two powers
    }
}

TEST(WriteImage, ExrKeepsEveryBit) {
    const TemporaryFolder folder;
    Image image = test_image();
    image.at(2, 1) = {1e30f, 1e-30f, -2.5f};
    write_image(folder / "a.exr", image, 8);  // exposure does not touch it
    const Image back = read_image(folder / "a.exr");
    ASSERT_EQ(back.width, 5);
    ASSERT_EQ(back.height, 3);
    EXPECT_EQ(back.pixels, image.pixels);
}

TEST(WriteImage, PngRoundsToOneOf256) {
    const TemporaryFolder folder;
    const Image image = test_image();
    write_image(folder / "a.png", image, 0.5f);
    const Image back = read_image(folder / "a.png");
    for (std::size_t i = 0; i < image.pixels.size(); ++i)
        for (int c = 0; c < 3; ++c)
            EXPECT_NEAR(srgb_encode(back.pixels[i][c]), srgb_encode(0.5f * image.pixels[i][c]),
                        0.5 / 255 + 1e-5);
}

TEST(WriteImage, SameImageSameBytes) {
    const TemporaryFolder folder;
    for (const char* name : {"a.exr", "a.png"}) {
        write_image(folder / name, test_image(), 1);
        const std::string first = bytes_of(folder / name);
        std::this_thread::sleep_for(std::chrono::milliseconds(1100));  // a time stamp would differ now
        write_image(folder / name, test_image(), 1);
        EXPECT_EQ(bytes_of(folder / name), first) << name;
    }
}

TEST(WriteImage, RefusesOtherFormatsAndFolders) {
    const TemporaryFolder folder;
    EXPECT_THROW(write_image(folder / "a.jpg", test_image(), 1), UsageError);
    EXPECT_THROW(write_image(folder / "none/a.png", test_image(), 1), Error);
}

TEST(ReadImage, FromMemoryIsTheSame) {
    const TemporaryFolder folder;
    write_image(folder / "a.png", test_image(), 1);
    const std::string bytes = bytes_of(folder / "a.png");
    EXPECT_EQ(read_image(bytes.data(), bytes.size(), "memory").pixels, read_image(folder / "a.png").pixels);
}

TEST(ReadImage, NamesWhatItCannotRead) {
    const TemporaryFolder folder;
    folder.write("broken.png", "no picture");
    EXPECT_NE(message_of<Error>([&] { read_image(folder / "broken.png"); }).find("broken.png"),
              std::string::npos);
    EXPECT_NE(message_of<Error>([&] { read_image("no picture", 10, "memory"); }).find("memory"),
              std::string::npos);
    EXPECT_THROW(read_image(folder / "missing.png"), Error);
}

TEST(ReadImage, ATruncatedPictureIsAnError) {
    const TemporaryFolder folder;
    Image image(64, 64);
    for (int i = 0; i < 4096; ++i) image.pixels[std::size_t(i)] = Rgb(float(i * 37 % 101) / 101);
    write_image(folder / "a.png", image, 1);
    const std::string bytes = bytes_of(folder / "a.png");
    folder.write("cut.png", bytes.substr(0, bytes.size() / 2));
    EXPECT_THROW(read_image(folder / "cut.png"), Error);
}

TEST(AutomaticExposure, BringsTheBrightPixelsBelowWhite) {
    Image image(100, 1);
    for (int i = 0; i < 100; ++i) image.at(i, 0) = Rgb(float(i + 1));
    EXPECT_NEAR(automatic_exposure(image) * 98, 0.9, 0.9 / 98);  // the percentile's own grain: one pixel
    EXPECT_EQ(automatic_exposure(Image(4, 4)), 1);
    image.at(99, 0) = Rgb(1e30f);  // an outlier changes nothing
    EXPECT_NEAR(automatic_exposure(image) * 98, 0.9, 0.9 / 98);
}

}  // namespace
}  // namespace pim
