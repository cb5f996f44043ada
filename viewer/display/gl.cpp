// SPDX-License-Identifier: GPL-3.0-or-later
#include "viewer/display/gl.h"

#include <fmt/format.h>

#include <algorithm>
#include <string>

#include "common/core/error.h"

namespace pim {
namespace {

Error unsuitable(const std::string& found) {
    return Error(fmt::format("OpenGL 4.1 is needed, but {}; {}", found, kWithoutOpenGl));
}

template <class Function>
void load(Function& function, GlResolver resolver, const char* name) {
    function = reinterpret_cast<Function>(resolver(name));
    if (!function) throw unsuitable(fmt::format("the OpenGL that was found lacks {}", name));
}

std::string text(const Gl& gl, GLenum name) {
    const GLubyte* found = gl.GetString(name);
    return found ? reinterpret_cast<const char*>(found) : "";
}

void check_version(const Gl& gl) {
    const std::string version = text(gl, GL_VERSION);
    if (version.empty()) throw unsuitable("no OpenGL context is current");
    GLint major = 0, minor = 0;  // stay 0 before OpenGL 3.0, which does not know the question
    gl.GetIntegerv(GL_MAJOR_VERSION, &major);
    gl.GetIntegerv(GL_MINOR_VERSION, &minor);
    if (10 * major + minor < 41)
        throw unsuitable(fmt::format("OpenGL {} ({}) was found", version, text(gl, GL_RENDERER)));
}

void attach(const Gl& gl, GLuint program, GLenum kind, const char* source) {
    const GLuint shader = gl.CreateShader(kind);
    gl.ShaderSource(shader, 1, &source, nullptr);
    gl.CompileShader(shader);
    gl.AttachShader(program, shader);
    gl.DeleteShader(shader);  // lives as long as the program does
}

void flip_rows(Rgba8Image& image) {
    const std::ptrdiff_t row = std::ptrdiff_t(image.width) * 4;
    for (int y = 0; y < image.height / 2; ++y)
        std::swap_ranges(image.at(0, y), image.at(0, y) + row, image.at(0, image.height - 1 - y));
}

}  // namespace

Gl load_gl(GlResolver resolver) {
    Gl gl;
    load(gl.GetString, resolver, "glGetString");
    load(gl.GetIntegerv, resolver, "glGetIntegerv");
    check_version(gl);
#define PIM_GL_LOAD(TYPE, Name) load(gl.Name, resolver, "gl" #Name);
    PIM_GL_FUNCTIONS(PIM_GL_LOAD)
#undef PIM_GL_LOAD
    return gl;
}

GLuint link_program(const Gl& gl, const char* vertex_source, const char* fragment_source) {
    const GLuint program = gl.CreateProgram();
    attach(gl, program, GL_VERTEX_SHADER, vertex_source);
    attach(gl, program, GL_FRAGMENT_SHADER, fragment_source);
    gl.LinkProgram(program);
    GLint linked = GL_FALSE;
    gl.GetProgramiv(program, GL_LINK_STATUS, &linked);
    if (linked) return program;
    char words[1024] = "";
    gl.GetProgramInfoLog(program, sizeof words, nullptr, words);
    gl.DeleteProgram(program);
    throw Error(fmt::format("OpenGL {} ({}) does not compile the display's shaders: {}; {}",
                            text(gl, GL_VERSION), text(gl, GL_RENDERER), words, kWithoutOpenGl));
}

Rgba8Image read_framebuffer(const Gl& gl, int width, int height) {
    Rgba8Image image(width, height);
    gl.PixelStorei(GL_PACK_ALIGNMENT, 4);
    gl.ReadPixels(0, 0, width, height, GL_RGBA, GL_UNSIGNED_BYTE, image.rgba.data());
    flip_rows(image);
    return image;
}

}  // namespace pim
