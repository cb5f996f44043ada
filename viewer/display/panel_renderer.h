// SPDX-License-Identifier: GPL-3.0-or-later
// Draws what Dear ImGui lays out. ImGui 1.86's own OpenGL backend, as Debian packages it, opens libGL itself,
// which answers nothing under OSMesa.
#pragma once

#include "viewer/display/gl.h"

struct ImDrawCmd;
struct ImDrawData;
struct ImDrawList;
struct ImFontAtlas;

namespace pim {

class PanelRenderer {
  public:
    // `gl` must outlive it. Throws Error. Tells the current ImGui context, if there is one, what it can.
    explicit PanelRenderer(const Gl& gl);
    ~PanelRenderer();
    PanelRenderer(const PanelRenderer&) = delete;
    PanelRenderer& operator=(const PanelRenderer&) = delete;

    // Over what is in the framebuffer, blended by alpha; sizes in pixels, >= 1. `data` covers the
    // framebuffer, however many pixels one of its units is. A texture identifier is the OpenGL texture's
    // name, 0 the font. Fonts are uploaded when the atlas' texture identifier is 0, as it is after a rebuild
    // of the atlas.
    void draw(int framebuffer_width, int framebuffer_height, const ImDrawData& data);

  private:
    struct Target {  // from ImGui's units to pixels
        int width, height;
        float left, top, scale_x, scale_y;
    };
    void upload_fonts(ImFontAtlas& atlas);
    void describe_vertices();
    void prepare(const ImDrawData& data);
    void draw_list(const Target& target, const ImDrawData& data, const ImDrawList& list);
    void draw_command(const Target& target, const ImDrawCmd& command);

    const Gl& gl_;
    GLuint program_ = 0, vertex_array_ = 0, vertices_ = 0, indices_ = 0, font_ = 0;
    GLint corner_ = -1, scale_ = -1;  // uniforms
};

}  // namespace pim
