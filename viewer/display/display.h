// SPDX-License-Identifier: GPL-3.0-or-later
// The only thing that OpenGL does here: a finished picture on the framebuffer, panels over it.
#pragma once

#include <cstdint>

#include "viewer/display/gl.h"
#include "viewer/display/panel_renderer.h"

struct ImDrawData;

namespace pim {

// Belongs to the context that is current when it is made, and must go before it.
class Display {
  public:
    // Throws Error. The ImGui context, if panels are to be drawn, exists already.
    explicit Display(const Gl& gl);
    ~Display();
    Display(const Display&) = delete;
    Display& operator=(const Display&) = delete;

    // The picture of all draws to come: rows from the top, 4 bytes a pixel, width and height >= 1.
    // Throws Error where it is larger than the context's textures may be.
    void show(const uint8_t* rgba, int width, int height);
    void show(const Rgba8Image& image) { show(image.rgba.data(), image.width, image.height); }

    // The picture stretched over the whole framebuffer, byte for byte where the sizes agree, black before the
    // first picture; then the panels (`ImGui::GetDrawData()`), or none (nullptr). Nothing where a size is 0.
    void draw(int framebuffer_width, int framebuffer_height, ImDrawData* panels);

    // What has been drawn, before the window swaps.
    Rgba8Image read(int framebuffer_width, int framebuffer_height) const {
        return read_framebuffer(gl_, framebuffer_width, framebuffer_height);
    }

  private:
    void draw_picture(bool same_size);

    Gl gl_;
    PanelRenderer panels_;
    GLuint program_ = 0, vertex_array_ = 0, picture_ = 0;
    int width_ = 0, height_ = 0;  // of the picture
};

}  // namespace pim
