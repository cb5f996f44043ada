// SPDX-License-Identifier: GPL-3.0-or-later
#include "viewer/display/panel_renderer.h"

#include <imgui.h>

#include <cmath>

namespace pim {
namespace {

constexpr const char* kVertexShader = R"(#version 410 core
layout(location = 0) in vec2 position;
layout(location = 1) in vec2 texture_position;
layout(location = 2) in vec4 vertex_colour;
uniform vec2 corner, scale;  // upper left corner and 2 / size of what is shown, ImGui's units
out vec2 uv;
out vec4 tint;
void main() {
    uv = texture_position;
    tint = vertex_colour;
    vec2 place = (position - corner) * scale - 1.0;
    gl_Position = vec4(place.x, -place.y, 0.0, 1.0);
})";

constexpr const char* kFragmentShader = R"(#version 410 core
uniform sampler2D atlas;
in vec2 uv;
in vec4 tint;
out vec4 colour;
void main() { colour = tint * texture(atlas, uv); }
)";

constexpr GLenum kIndexType = sizeof(ImDrawIdx) == 2 ? GL_UNSIGNED_SHORT : GL_UNSIGNED_INT;

ImTextureID identifier(GLuint texture) {
    return reinterpret_cast<ImTextureID>(std::uintptr_t(texture));  // NOLINT(performance-no-int-to-ptr)
}
GLuint texture_of(ImTextureID identifier) { return GLuint(reinterpret_cast<std::uintptr_t>(identifier)); }

const void* offset(std::size_t bytes) {
    return reinterpret_cast<const void*>(bytes);  // NOLINT(performance-no-int-to-ptr)
}

}  // namespace

PanelRenderer::PanelRenderer(const Gl& gl)
    : gl_(gl), program_(link_program(gl, kVertexShader, kFragmentShader)) {
    corner_ = gl_.GetUniformLocation(program_, "corner");
    scale_ = gl_.GetUniformLocation(program_, "scale");
    gl_.GenBuffers(1, &vertices_);
    gl_.GenBuffers(1, &indices_);
    gl_.GenTextures(1, &font_);
    gl_.GenVertexArrays(1, &vertex_array_);
    describe_vertices();
    if (ImGui::GetCurrentContext()) {
        ImGui::GetIO().BackendFlags |= ImGuiBackendFlags_RendererHasVtxOffset;
        ImGui::GetIO().Fonts->SetTexID(nullptr);
    }
}

PanelRenderer::~PanelRenderer() {
    if (ImGui::GetCurrentContext() && texture_of(ImGui::GetIO().Fonts->TexID) == font_)
        ImGui::GetIO().Fonts->SetTexID(nullptr);
    gl_.DeleteVertexArrays(1, &vertex_array_);
    gl_.DeleteTextures(1, &font_);
    gl_.DeleteBuffers(1, &indices_);
    gl_.DeleteBuffers(1, &vertices_);
    gl_.DeleteProgram(program_);
}

void PanelRenderer::describe_vertices() {
    gl_.BindVertexArray(vertex_array_);
    gl_.BindBuffer(GL_ARRAY_BUFFER, vertices_);
    gl_.BindBuffer(GL_ELEMENT_ARRAY_BUFFER, indices_);
    for (const GLuint attribute : {0u, 1u, 2u}) gl_.EnableVertexAttribArray(attribute);
    const GLsizei stride = sizeof(ImDrawVert);
    gl_.VertexAttribPointer(0, 2, GL_FLOAT, GL_FALSE, stride, offset(offsetof(ImDrawVert, pos)));
    gl_.VertexAttribPointer(1, 2, GL_FLOAT, GL_FALSE, stride, offset(offsetof(ImDrawVert, uv)));
    gl_.VertexAttribPointer(2, 4, GL_UNSIGNED_BYTE, GL_TRUE, stride, offset(offsetof(ImDrawVert, col)));
}

void PanelRenderer::upload_fonts(ImFontAtlas& atlas) {
    unsigned char* pixels = nullptr;
    int width = 0, height = 0;
    atlas.GetTexDataAsRGBA32(&pixels, &width, &height);
    gl_.BindTexture(GL_TEXTURE_2D, font_);
    gl_.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
    gl_.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
    gl_.PixelStorei(GL_UNPACK_ALIGNMENT, 4);
    gl_.TexImage2D(GL_TEXTURE_2D, 0, GL_RGBA8, width, height, 0, GL_RGBA, GL_UNSIGNED_BYTE, pixels);
    atlas.SetTexID(identifier(font_));
}

void PanelRenderer::prepare(const ImDrawData& data) {
    gl_.Enable(GL_BLEND);
    gl_.Enable(GL_SCISSOR_TEST);
    gl_.BlendEquation(GL_FUNC_ADD);
    // Alpha: what lies over an opaque picture leaves it opaque.
    gl_.BlendFuncSeparate(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA, GL_ONE, GL_ONE_MINUS_SRC_ALPHA);
    gl_.UseProgram(program_);
    gl_.Uniform2f(corner_, data.DisplayPos.x, data.DisplayPos.y);
    gl_.Uniform2f(scale_, 2 / data.DisplaySize.x, 2 / data.DisplaySize.y);
    gl_.ActiveTexture(GL_TEXTURE0);
    gl_.BindVertexArray(vertex_array_);
    gl_.BindBuffer(GL_ARRAY_BUFFER, vertices_);
}

void PanelRenderer::draw_command(const Target& target, const ImDrawCmd& command) {
    const int left = int(std::lround((command.ClipRect.x - target.left) * target.scale_x)),
              top = int(std::lround((command.ClipRect.y - target.top) * target.scale_y)),
              right = int(std::lround((command.ClipRect.z - target.left) * target.scale_x)),
              bottom = int(std::lround((command.ClipRect.w - target.top) * target.scale_y));
    if (right <= left || bottom <= top) return;
    gl_.Scissor(left, target.height - bottom, right - left, bottom - top);
    const GLuint texture = texture_of(command.GetTexID());
    gl_.BindTexture(GL_TEXTURE_2D, texture ? texture : font_);
    gl_.DrawElementsBaseVertex(GL_TRIANGLES, GLsizei(command.ElemCount), kIndexType,
                               offset(command.IdxOffset * sizeof(ImDrawIdx)), GLint(command.VtxOffset));
}

void PanelRenderer::draw_list(const Target& target, const ImDrawData& data, const ImDrawList& list) {
    gl_.BufferData(GL_ARRAY_BUFFER, list.VtxBuffer.size_in_bytes(), list.VtxBuffer.Data, GL_STREAM_DRAW);
    gl_.BufferData(GL_ELEMENT_ARRAY_BUFFER, list.IdxBuffer.size_in_bytes(), list.IdxBuffer.Data,
                   GL_STREAM_DRAW);
    for (const ImDrawCmd& command : list.CmdBuffer) {
        if (command.UserCallback == ImDrawCallback_ResetRenderState)
            prepare(data);
        else if (command.UserCallback)
            command.UserCallback(&list, &command);
        else
            draw_command(target, command);
    }
}

void PanelRenderer::draw(int framebuffer_width, int framebuffer_height, const ImDrawData& data) {
    if (data.DisplaySize.x <= 0 || data.DisplaySize.y <= 0) return;
    ImFontAtlas& atlas = *ImGui::GetIO().Fonts;
    if (!atlas.TexID) upload_fonts(atlas);
    // Not data.FramebufferScale: the window may have been resized since the frame began.
    const Target target{framebuffer_width,
                        framebuffer_height,
                        data.DisplayPos.x,
                        data.DisplayPos.y,
                        float(framebuffer_width) / data.DisplaySize.x,
                        float(framebuffer_height) / data.DisplaySize.y};
    prepare(data);
    for (int i = 0; i < data.CmdListsCount; ++i) draw_list(target, data, *data.CmdLists[i]);
}

}  // namespace pim
