// SPDX-License-Identifier: GPL-3.0-or-later
// The functions of OpenGL 4.1 that the display uses, asked of whoever owns the context: nothing links libGL,
// and the same code draws into a window (GLFW) and into memory (OSMesa).
#pragma once

#include <GL/glcorearb.h>

#include "viewer/display/rgba_image.h"

namespace pim {

// Types as in glcorearb.h: PFNGL<first>PROC is the type of gl<second>.
#define PIM_GL_FUNCTIONS(USE)                             \
    USE(GETSTRING, GetString)                             \
    USE(GETINTEGERV, GetIntegerv)                         \
    USE(GETERROR, GetError)                               \
    USE(ENABLE, Enable)                                   \
    USE(DISABLE, Disable)                                 \
    USE(VIEWPORT, Viewport)                               \
    USE(SCISSOR, Scissor)                                 \
    USE(CLEARCOLOR, ClearColor)                           \
    USE(CLEAR, Clear)                                     \
    USE(BLENDEQUATION, BlendEquation)                     \
    USE(BLENDFUNCSEPARATE, BlendFuncSeparate)             \
    USE(PIXELSTOREI, PixelStorei)                         \
    USE(READPIXELS, ReadPixels)                           \
    USE(FINISH, Finish)                                   \
    USE(GENTEXTURES, GenTextures)                         \
    USE(DELETETEXTURES, DeleteTextures)                   \
    USE(ACTIVETEXTURE, ActiveTexture)                     \
    USE(BINDTEXTURE, BindTexture)                         \
    USE(TEXPARAMETERI, TexParameteri)                     \
    USE(TEXIMAGE2D, TexImage2D)                           \
    USE(TEXSUBIMAGE2D, TexSubImage2D)                     \
    USE(GENBUFFERS, GenBuffers)                           \
    USE(DELETEBUFFERS, DeleteBuffers)                     \
    USE(BINDBUFFER, BindBuffer)                           \
    USE(BUFFERDATA, BufferData)                           \
    USE(GENVERTEXARRAYS, GenVertexArrays)                 \
    USE(DELETEVERTEXARRAYS, DeleteVertexArrays)           \
    USE(BINDVERTEXARRAY, BindVertexArray)                 \
    USE(ENABLEVERTEXATTRIBARRAY, EnableVertexAttribArray) \
    USE(VERTEXATTRIBPOINTER, VertexAttribPointer)         \
    USE(DRAWARRAYS, DrawArrays)                           \
    USE(DRAWELEMENTSBASEVERTEX, DrawElementsBaseVertex)   \
    USE(CREATESHADER, CreateShader)                       \
    USE(DELETESHADER, DeleteShader)                       \
    USE(SHADERSOURCE, ShaderSource)                       \
    USE(COMPILESHADER, CompileShader)                     \
    USE(CREATEPROGRAM, CreateProgram)                     \
    USE(DELETEPROGRAM, DeleteProgram)                     \
    USE(ATTACHSHADER, AttachShader)                       \
    USE(LINKPROGRAM, LinkProgram)                         \
    USE(GETPROGRAMIV, GetProgramiv)                       \
    USE(GETPROGRAMINFOLOG, GetProgramInfoLog)             \
    USE(USEPROGRAM, UseProgram)                           \
    USE(GETUNIFORMLOCATION, GetUniformLocation)           \
    USE(UNIFORM2F, Uniform2f)

// Each member is the OpenGL function of that name, valid while the context lives.
struct Gl {
#define PIM_GL_MEMBER(TYPE, Name) PFNGL##TYPE##PROC Name = nullptr;
    PIM_GL_FUNCTIONS(PIM_GL_MEMBER)
#undef PIM_GL_MEMBER
};

// The address of the OpenGL function of that name, or nullptr.
using GlResolver = void* (*)(const char* name);

// What to do instead, as the end of an error's sentence.
inline constexpr const char* kWithoutOpenGl = "`viewer FILE.vdb --output FRAME.png` works without OpenGL";

// Of the current context. Throws Error, naming what was found, below OpenGL 4.1 or where a function is
// missing.
Gl load_gl(GlResolver resolver);

// A linked program of two shaders in GLSL 4.10. Throws Error with the compiler's words.
GLuint link_program(const Gl& gl, const char* vertex_source, const char* fragment_source);

// The framebuffer's lower left `width` x `height` pixels (all of it where that is its size): of a window what
// has been drawn since the last swap.
Rgba8Image read_framebuffer(const Gl& gl, int width, int height);

}  // namespace pim
