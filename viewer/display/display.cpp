// SPDX-License-Identifier: GPL-3.0-or-later
#include "viewer/display/display.h"

#include <fmt/format.h>

#include <cassert>

#include "common/core/error.h"

namespace pim {
namespace {

// One triangle that covers the framebuffer.
constexpr const char* kVertexShader = R"(#version 410 core
out vec2 uv;
void main() {
    vec2 corner = vec2((gl_VertexID << 1) & 2, gl_VertexID & 2);
    uv = vec2(corner.x, 1.0 - corner.y);  // the picture's rows start at the top
    gl_Position = vec4(2.0 * corner - 1.0, 0.0, 1.0);
})";

constexpr const char* kFragmentShader = R"(#version 410 core
uniform sampler2D picture;
in vec2 uv;
out vec4 colour;
void main() { colour = texture(picture, uv); }
)";

void check_size(const Gl& gl, int width, int height) {
    assert(width >= 1 && height >= 1);
    GLint most = 0;
    gl.GetIntegerv(GL_MAX_TEXTURE_SIZE, &most);
    if (width > most || height > most)
        throw Error(fmt::format("a picture of {} x {} is too large to display: OpenGL allows {} x {} here",
                                width, height, most, most));
}

}  // namespace

Display::Display(const Gl& gl)
    : gl_(gl), panels_(gl_), program_(link_program(gl_, kVertexShader, kFragmentShader)) {
    gl_.GenVertexArrays(1, &vertex_array_);
    gl_.GenTextures(1, &picture_);
    gl_.BindTexture(GL_TEXTURE_2D, picture_);
    gl_.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
    gl_.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
    gl_.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAX_LEVEL, 0);
}

Display::~Display() {
    gl_.DeleteTextures(1, &picture_);
    gl_.DeleteVertexArrays(1, &vertex_array_);
    gl_.DeleteProgram(program_);
}

void Display::show(const uint8_t* rgba, int width, int height) {
    gl_.BindTexture(GL_TEXTURE_2D, picture_);
    gl_.PixelStorei(GL_UNPACK_ALIGNMENT, 4);
    if (width == width_ && height == height_) {
        gl_.TexSubImage2D(GL_TEXTURE_2D, 0, 0, 0, width, height, GL_RGBA, GL_UNSIGNED_BYTE, rgba);
        return;
    }
    check_size(gl_, width, height);
    gl_.TexImage2D(GL_TEXTURE_2D, 0, GL_RGBA8, width, height, 0, GL_RGBA, GL_UNSIGNED_BYTE, rgba);
    width_ = width;
    height_ = height;
}

void Display::draw_picture(bool same_size) {
    const GLint filter = same_size ? GL_NEAREST : GL_LINEAR;
    gl_.ActiveTexture(GL_TEXTURE0);
    gl_.BindTexture(GL_TEXTURE_2D, picture_);
    gl_.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, filter);
    gl_.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, filter);
    gl_.UseProgram(program_);
    gl_.BindVertexArray(vertex_array_);
    gl_.DrawArrays(GL_TRIANGLES, 0, 3);
}

void Display::draw(int framebuffer_width, int framebuffer_height, ImDrawData* panels) {
    if (framebuffer_width < 1 || framebuffer_height < 1) return;
    // The bytes are final: nothing may be encoded, dithered or blended on the way.
    for (const GLenum state : {GL_FRAMEBUFFER_SRGB, GL_DITHER, GL_BLEND, GL_SCISSOR_TEST}) gl_.Disable(state);
    gl_.Viewport(0, 0, framebuffer_width, framebuffer_height);
    gl_.ClearColor(0, 0, 0, 1);
    gl_.Clear(GL_COLOR_BUFFER_BIT);
    if (width_ > 0) draw_picture(width_ == framebuffer_width && height_ == framebuffer_height);
    if (panels) panels_.draw(framebuffer_width, framebuffer_height, *panels);
}

}  // namespace pim
