// SPDX-License-Identifier: GPL-3.0-or-later
#include "viewer/display/offscreen.h"
// osmesa.h brings the older gl.h, which must find the types of glcorearb.h made.
#include <GL/osmesa.h>
#include <fmt/format.h>

#include <utility>

#include "common/core/error.h"

namespace pim {
namespace {

osmesa_context* create_context() {
    const int attributes[] = {OSMESA_FORMAT,
                              OSMESA_RGBA,
                              OSMESA_PROFILE,
                              OSMESA_CORE_PROFILE,
                              OSMESA_CONTEXT_MAJOR_VERSION,
                              4,
                              OSMESA_CONTEXT_MINOR_VERSION,
                              1,
                              0};
    osmesa_context* context = OSMesaCreateContextAttribs(attributes, nullptr);
    if (!context)
        throw Error(fmt::format("the installed OSMesa (package libosmesa6) offers no OpenGL 4.1 core; {}",
                                kWithoutOpenGl));
    return context;
}

// Of the current context; OSMesa itself takes any size and then draws nothing.
bool within_limits(int width, int height) {
    int widest = 0, highest = 0;
    OSMesaGetIntegerv(OSMESA_MAX_WIDTH, &widest);
    OSMesaGetIntegerv(OSMESA_MAX_HEIGHT, &highest);
    return width <= widest && height <= highest;
}

}  // namespace

void Offscreen::Destroy::operator()(osmesa_context* context) const {
    if (OSMesaGetCurrentContext() == context) OSMesaMakeCurrent(nullptr, nullptr, GL_UNSIGNED_BYTE, 0, 0);
    OSMesaDestroyContext(context);
}

Offscreen::Offscreen(int width, int height) : context_(create_context()) {
    resize(width, height);
    gl_ = load_gl([](const char* name) { return reinterpret_cast<void*>(OSMesaGetProcAddress(name)); });
}

void Offscreen::resize(int width, int height) {
    Rgba8Image buffer(width, height);
    if (!OSMesaMakeCurrent(context_.get(), buffer.rgba.data(), GL_UNSIGNED_BYTE, width, height) ||
        !within_limits(width, height))
        throw Error(fmt::format("OSMesa makes no framebuffer of {} x {}; {}", width, height, kWithoutOpenGl));
    OSMesaPixelStore(OSMESA_Y_UP, 0);
    buffer_ = std::move(buffer);  // the bytes stay where they are
}

Rgba8Image Offscreen::read() const {
    gl_.Finish();  // only now does OSMesa write into the buffer
    return buffer_;
}

}  // namespace pim
