// SPDX-License-Identifier: GPL-3.0-or-later
#include "viewer/display/display.h"

#include <gtest/gtest.h>
#include <imgui.h>

#include <algorithm>
#include <array>
#include <memory>
#include <string>

#include "common/core/error.h"
#include "temporary_folder.h"
#include "viewer/display/imgui_context.h"
#include "viewer/display/offscreen.h"

// OSMesa 22.3 never frees its record of a framebuffer.
extern "C" const char* __lsan_default_suppressions() {  // NOLINT(bugprone-reserved-identifier)
    return "leak:libOSMesa\n";
}

namespace pim {
namespace {

using Texel = std::array<int, 4>;

Texel texel(const Rgba8Image& image, int x, int y) {
    const uint8_t* t = image.at(x, y);
    return {t[0], t[1], t[2], t[3]};
}

// No two rows or columns alike, every value of a byte, alpha among them.
Rgba8Image test_picture(int width, int height) {
    Rgba8Image image(width, height);
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            uint8_t* t = image.at(x, y);
            t[0] = uint8_t(x * 7 + y);
            t[1] = uint8_t(y * 5 + x * x);
            t[2] = uint8_t(x * y + 11);
            t[3] = uint8_t(255 - x - 3 * y);
        }
    return image;
}

Rgba8Image plain_picture(int width, int height, const Texel& colour) {
    Rgba8Image image(width, height);
    for (std::size_t i = 0; i < image.rgba.size(); ++i) image.rgba[i] = uint8_t(colour[i % 4]);
    return image;
}

// What comes back when a picture is shown on a framebuffer of that size, without panels.
Rgba8Image shown(const Rgba8Image& picture, int width, int height) {
    const Offscreen offscreen(width, height);
    Display display(offscreen.gl());
    display.show(picture);
    display.draw(width, height, nullptr);
    EXPECT_EQ(offscreen.gl().GetError(), GLenum(GL_NO_ERROR));
    return offscreen.read();
}

TEST(Display, PictureOfItsSizeComesBackByteForByte) {
    for (const auto& [width, height] : {std::pair{37, 23}, {1, 1}, {1921, 1081}, {3, 4096}}) {
        const Rgba8Image picture = test_picture(width, height);
        const Rgba8Image back = shown(picture, width, height);
        EXPECT_EQ(back.width, width);
        EXPECT_EQ(back.height, height);
        EXPECT_TRUE(back.rgba == picture.rgba) << width << " x " << height;
    }
}

TEST(Display, ReadsWhatTheContextHolds) {
    const Offscreen offscreen(37, 23);
    Display display(offscreen.gl());
    display.show(test_picture(37, 23));
    display.draw(37, 23, nullptr);
    EXPECT_TRUE(display.read(37, 23).rgba == test_picture(37, 23).rgba);
}

TEST(Display, SmallPictureFillsTheFramebuffer) {
    Rgba8Image picture(2, 2);
    const std::array<Texel, 4> corners{
        Texel{255, 0, 0, 255}, {0, 255, 0, 255}, {0, 0, 255, 255}, {255, 255, 255, 255}};
    for (int i = 0; i < 4; ++i) std::ranges::copy(corners[std::size_t(i)], picture.at(i % 2, i / 2));
    const Rgba8Image back = shown(picture, 64, 48);
    EXPECT_EQ(texel(back, 0, 0), corners[0]);
    EXPECT_EQ(texel(back, 63, 0), corners[1]);
    EXPECT_EQ(texel(back, 0, 47), corners[2]);
    EXPECT_EQ(texel(back, 63, 47), corners[3]);
    // The filter is linear between texel centres; a quarter and three quarters of the width are such.
    const double right = (32.5 - 16) / 32;
    const Texel middle = texel(back, 32, 0);
    EXPECT_NEAR(middle[0], 255 * (1 - right), 1.5);
    EXPECT_NEAR(middle[1], 255 * right, 1.5);
    EXPECT_EQ(middle[2], 0);
}

TEST(Display, PlainPictureStaysPlainWhenScaled) {
    const Texel colour{12, 130, 201, 255};
    for (const auto& [width, height] : {std::pair{5, 3}, {333, 222}}) {
        const Rgba8Image back = shown(plain_picture(width, height, colour), 100, 60);
        EXPECT_TRUE(back.rgba == plain_picture(100, 60, colour).rgba);
    }
}

TEST(Display, BlackBeforeTheFirstPicture) {
    const Offscreen offscreen(8, 8);
    Display display(offscreen.gl());
    display.draw(8, 8, nullptr);
    EXPECT_TRUE(offscreen.read().rgba == plain_picture(8, 8, {0, 0, 0, 255}).rgba);
}

TEST(Display, PictureAndFramebufferChangeTheirSize) {
    Offscreen offscreen(40, 30);
    Display display(offscreen.gl());
    for (const auto& [width, height] : {std::pair{40, 30}, {40, 30}, {64, 20}, {7, 90}, {40, 30}}) {
        offscreen.resize(width, height);
        Rgba8Image picture = test_picture(width, height);
        display.show(picture);
        picture.at(0, 0)[0] ^= 0xff;
        display.show(picture);  // same size: only its texels are replaced
        display.draw(width, height, nullptr);
        EXPECT_TRUE(offscreen.read().rgba == picture.rgba) << width << " x " << height;
    }
    display.draw(0, 0, nullptr);  // a minimised window
    EXPECT_EQ(offscreen.gl().GetError(), GLenum(GL_NO_ERROR));
}

TEST(Display, RefusesPicturesLargerThanTextures) {
    const Offscreen offscreen(4, 4);
    Display display(offscreen.gl());
    GLint most = 0;
    offscreen.gl().GetIntegerv(GL_MAX_TEXTURE_SIZE, &most);
    const Rgba8Image picture(most + 1, 1);
    EXPECT_NE(message_of<Error>([&] { display.show(picture); }).find("too large"), std::string::npos);
    display.show(test_picture(4, 4));  // still works
    display.draw(4, 4, nullptr);
    EXPECT_TRUE(offscreen.read().rgba == test_picture(4, 4).rgba);
}

TEST(Display, ContextsOneAfterTheOther) {
    const Rgba8Image picture = test_picture(20, 10);
    for (int i = 0; i < 3; ++i) EXPECT_TRUE(shown(picture, 20, 10).rgba == picture.rgba);
}

TEST(Display, ContextsBesideEachOther) {
    auto first = std::make_unique<Offscreen>(20, 10);
    const Offscreen second(10, 20);
    first.reset();  // the current one stays the second
    Display display(second.gl());
    display.show(test_picture(10, 20));
    display.draw(10, 20, nullptr);
    EXPECT_TRUE(second.read().rgba == test_picture(10, 20).rgba);
}

// Panels over a plain picture, drawn by `layout(draw_list)` on ImGui's background.
class Panels : public testing::Test {
  protected:
    static constexpr int kWidth = 80, kHeight = 60;
    static constexpr Texel kPicture{100, 50, 200, 255};

    template <class Layout>
    Rgba8Image drawn(Layout layout) {
        context_.begin_frame_headless(kWidth, kHeight, 1 / 60.0f);
        layout(*ImGui::GetBackgroundDrawList());
        ImGui::Render();
        display_.show(plain_picture(5, 5, kPicture));
        display_.draw(offscreen_width_, offscreen_height_, ImGui::GetDrawData());
        EXPECT_EQ(offscreen_.gl().GetError(), GLenum(GL_NO_ERROR));
        return offscreen_.read();
    }

    void resize(int width, int height) {
        offscreen_width_ = width;
        offscreen_height_ = height;
        offscreen_.resize(width, height);
    }

    Offscreen offscreen_{kWidth, kHeight};
    ImguiContext context_;
    Display display_{offscreen_.gl()};
    int offscreen_width_ = kWidth, offscreen_height_ = kHeight;
};

// `inside` exactly in [x0,x1) x [y0,y1), the picture elsewhere; blending may round by one.
void expect_rectangle(const Rgba8Image& image, const std::array<int, 4>& box, const Texel& inside,
                      const Texel& outside) {
    for (int y = 0; y < image.height; ++y)
        for (int x = 0; x < image.width; ++x) {
            const bool in = x >= box[0] && x < box[2] && y >= box[1] && y < box[3];
            const Texel found = texel(image, x, y), expected = in ? inside : outside;
            for (std::size_t c = 0; c < 4; ++c)
                ASSERT_NEAR(found[c], expected[c], in ? 1 : 0) << "at " << x << ", " << y << " channel " << c;
        }
}

TEST_F(Panels, RectangleLandsOnItsPixels) {
    const Rgba8Image back = drawn([](ImDrawList& list) {
        list.AddRectFilled({10, 5}, {30, 17}, IM_COL32(255, 128, 0, 255));
    });
    expect_rectangle(back, {10, 5, 30, 17}, {255, 128, 0, 255}, kPicture);
}

TEST_F(Panels, AlphaBlendsOverThePicture) {
    const Rgba8Image back = drawn([](ImDrawList& list) {
        list.AddRectFilled({0, 40}, {80, 60}, IM_COL32(255, 255, 0, 102));
    });
    // 0.4 c + 0.6 picture; what lies over an opaque picture leaves it opaque
    expect_rectangle(back, {0, 40, 80, 60}, {162, 132, 120, 255}, kPicture);
}

TEST_F(Panels, ClipRectangleIsRespected) {
    const Rgba8Image back = drawn([](ImDrawList& list) {
        list.PushClipRect({20, 10}, {25, 50});
        list.AddRectFilled({0, 0}, {80, 60}, IM_COL32(1, 2, 3, 255));
        list.PopClipRect();
    });
    expect_rectangle(back, {20, 10, 25, 50}, {1, 2, 3, 255}, kPicture);
}

TEST_F(Panels, ClipRectangleBeyondTheFramebuffer) {
    const Rgba8Image back = drawn([](ImDrawList& list) {
        list.PushClipRect({-30, -20}, {12, 9});
        list.AddRectFilled({-40, -40}, {80, 60}, IM_COL32(1, 2, 3, 255));
        list.PopClipRect();
    });
    expect_rectangle(back, {0, 0, 12, 9}, {1, 2, 3, 255}, kPicture);
}

TEST_F(Panels, FramebufferOfSeveralPixelsAUnit) {
    resize(2 * kWidth, 2 * kHeight);
    const Rgba8Image back = drawn([](ImDrawList& list) {
        list.PushClipRect({15, 0}, {80, 60});
        list.AddRectFilled({10, 5}, {30, 17}, IM_COL32(255, 128, 0, 255));
        list.PopClipRect();
    });
    expect_rectangle(back, {30, 10, 60, 34}, {255, 128, 0, 255}, kPicture);
}

TEST_F(Panels, MoreVerticesThanSixteenBitsCount) {
    const Rgba8Image back = drawn([](ImDrawList& list) {
        for (int i = 0; i < 20000; ++i) list.AddRectFilled({0, 0}, {10, 10}, IM_COL32(0, 0, 0, 255));
        list.AddRectFilled({0, 0}, {10, 10}, IM_COL32(0, 250, 7, 255));
    });
    EXPECT_GT(ImGui::GetDrawData()->TotalVtxCount, 65536);
    expect_rectangle(back, {0, 0, 10, 10}, {0, 250, 7, 255}, kPicture);
}

TEST_F(Panels, CallbacksAreCalledInOrder) {
    static int calls = 0;
    calls = 0;
    const Rgba8Image back = drawn([](ImDrawList& list) {
        list.AddCallback([](const ImDrawList*, const ImDrawCmd*) { ++calls; }, nullptr);
        list.AddCallback(ImDrawCallback_ResetRenderState, nullptr);
        list.AddRectFilled({10, 5}, {30, 17}, IM_COL32(255, 128, 0, 255));
    });
    EXPECT_EQ(calls, 1);
    expect_rectangle(back, {10, 5, 30, 17}, {255, 128, 0, 255}, kPicture);
}

int texels_unlike(const Rgba8Image& image, const Texel& colour) {
    int count = 0;
    for (int y = 0; y < image.height; ++y)
        for (int x = 0; x < image.width; ++x) count += texel(image, x, y) != colour;
    return count;
}

TEST_F(Panels, TextIsDrawnAndGrowsWithTheScale) {
    const auto text = [](ImDrawList& list) { list.AddText({0, 0}, IM_COL32(255, 255, 255, 255), "HHH"); };
    const int plain = texels_unlike(drawn(text), kPicture);
    EXPECT_GT(plain, 30);  // strokes
    EXPECT_LT(plain, 3 * 9 * 16);
    context_.set_scale(2);  // rebuilds the font
    const int doubled = texels_unlike(drawn(text), kPicture);
    EXPECT_GT(doubled, 2.5 * plain);  // strokes twice as long and wide, smooth edges only as long
    EXPECT_LT(doubled, 4.5 * plain);
    context_.set_scale(1);
    EXPECT_EQ(texels_unlike(drawn(text), kPicture), plain);
}

TEST_F(Panels, WindowIsDrawnWithoutAFileOfItsPlace) {
    const auto window = [](ImDrawList&) {
        ImGui::SetNextWindowPos({10, 10});
        ImGui::SetNextWindowSize({40, 30});
        ImGui::Begin("panel", nullptr, ImGuiWindowFlags_NoTitleBar);
        ImGui::End();
    };
    drawn(window);  // ImGui hides a window's first frame
    const Rgba8Image back = drawn(window);
    EXPECT_EQ(texel(back, 5, 5), kPicture);
    EXPECT_EQ(texel(back, 60, 50), kPicture);
    const Texel inside = texel(back, 30, 25);
    EXPECT_LT(inside[2], 80);  // dark
    EXPECT_GT(inside[2], 20);  // and the picture shines through
    EXPECT_EQ(inside[3], 255);
    EXPECT_EQ(ImGui::GetIO().IniFilename, nullptr);
}

TEST_F(Panels, AnotherDisplayTakesOver) {
    const auto text = [](ImDrawList& list) { list.AddText({0, 0}, IM_COL32(255, 255, 255, 255), "HHH"); };
    const Rgba8Image expected = drawn(text);
    const Offscreen other(kWidth, kHeight);
    Display display(other.gl());
    context_.begin_frame_headless(kWidth, kHeight, 1 / 60.0f);
    text(*ImGui::GetBackgroundDrawList());
    ImGui::Render();
    display.show(plain_picture(5, 5, kPicture));
    display.draw(kWidth, kHeight, ImGui::GetDrawData());
    EXPECT_TRUE(other.read().rgba == expected.rgba);
}

TEST(Offscreen, RefusesImpossibleSizes) {
    const std::string message = message_of<Error>([] { const Offscreen offscreen(100000, 1); });
    EXPECT_NE(message.find("100000 x 1"), std::string::npos) << message;
}

TEST(Gl, MissingFunctionsAreNamed) {
    const std::string message =
        message_of<Error>([] { load_gl([](const char*) -> void* { return nullptr; }); });
    for (const char* word : {"OpenGL 4.1", "glGetString", "--output"})
        EXPECT_NE(message.find(word), std::string::npos) << message;
}

const GLubyte* APIENTRY old_string(GLenum name) {
    return reinterpret_cast<const GLubyte*>(name == GL_VERSION ? "3.1 Mesa 9" : "an old card");
}

TEST(Gl, TooOldIsToldWithVersionAndRenderer) {
    const std::string message = message_of<Error>([] {
        load_gl([](const char* name) -> void* {
            if (name == std::string("glGetString")) return reinterpret_cast<void*>(&old_string);
            const PFNGLGETINTEGERVPROC number = [](GLenum key, GLint* value) {
                *value = key == GL_MAJOR_VERSION ? 3 : 1;
            };
            return reinterpret_cast<void*>(number);
        });
    });
    for (const char* word : {"OpenGL 4.1", "3.1 Mesa 9", "an old card", "--output"})
        EXPECT_NE(message.find(word), std::string::npos) << message;
}

TEST(Gl, NoContextIsTold) {
    const std::string message = message_of<Error>([] {
        load_gl([](const char*) -> void* {
            const PFNGLGETSTRINGPROC nothing = [](GLenum) -> const GLubyte* { return nullptr; };
            return reinterpret_cast<void*>(nothing);
        });
    });
    EXPECT_NE(message.find("no OpenGL context"), std::string::npos) << message;
}

TEST(Gl, WrongShadersAreToldInTheCompilersWords) {
    const Offscreen offscreen(4, 4);
    const char* vertex = "#version 410 core\nvoid main() { gl_Position = vec4(0.0); }";
    const std::string message = message_of<Error>(
        [&] { link_program(offscreen.gl(), vertex, "#version 410 core\nvoid main() { ; "); });
    EXPECT_NE(message.find("shaders"), std::string::npos) << message;
}

}  // namespace
}  // namespace pim
