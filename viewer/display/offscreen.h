// SPDX-License-Identifier: GPL-3.0-or-later
// A framebuffer in memory: what a window would show, without display or GPU.
#pragma once

#include <memory>

#include "viewer/display/gl.h"

struct osmesa_context;

namespace pim {

class Offscreen {
  public:
    // Sizes in pixels, >= 1. Its context is the current one until another is made. Throws Error where OSMesa
    // offers no OpenGL 4.1 or no framebuffer of that size.
    Offscreen(int width, int height);

    void resize(int width, int height);  // what was drawn is lost; throws Error
    const Gl& gl() const { return gl_; }
    Rgba8Image read() const;  // all that has been drawn

  private:
    struct Destroy {
        void operator()(osmesa_context* context) const;
    };
    Rgba8Image buffer_;  // the context draws into it, rows from the top
    std::unique_ptr<osmesa_context, Destroy> context_;
    Gl gl_;
};

}  // namespace pim
