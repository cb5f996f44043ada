// SPDX-License-Identifier: GPL-3.0-or-later
#include "viewer/display/offscreen.h"
// osmesa.h brings the older gl.h, which must find the types of glcorearb.h made.
#include <GL/osmesa.h>
#include <dlfcn.h>
#include <fmt/format.h>

#include <utility>

#include "common/core/error.h"

namespace pim {
namespace {

// OSMesa is loaded by the first who needs it: its compiler alone takes 60 MB, which a window does without.
struct Library {
    template <class Function>
    void find(Function& function, const char* name) const {
        function = reinterpret_cast<Function>(dlsym(handle, name));
        if (!function) throw Error(fmt::format("the installed OSMesa has no {}; {}", name, kWithoutOpenGl));
    }
    Library() {
        if (!handle)
            throw Error(fmt::format("OSMesa (package libosmesa6) is not installed: {}; {}", dlerror(),
                                    kWithoutOpenGl));
        find(create, "OSMesaCreateContextAttribs");
        find(destroy, "OSMesaDestroyContext");
        find(make_current, "OSMesaMakeCurrent");
        find(current, "OSMesaGetCurrentContext");
        find(get_integer, "OSMesaGetIntegerv");
        find(pixel_store, "OSMesaPixelStore");
        find(address, "OSMesaGetProcAddress");
    }

    void* handle = dlopen("libOSMesa.so.8", RTLD_LAZY | RTLD_LOCAL);
    decltype(&OSMesaCreateContextAttribs) create;
    decltype(&OSMesaDestroyContext) destroy;
    decltype(&OSMesaMakeCurrent) make_current;
    decltype(&OSMesaGetCurrentContext) current;
    decltype(&OSMesaGetIntegerv) get_integer;
    decltype(&OSMesaPixelStore) pixel_store;
    decltype(&OSMesaGetProcAddress) address;
};

const Library& osmesa() {
    static const Library library;
    return library;
}

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
    osmesa_context* context = osmesa().create(attributes, nullptr);
    if (!context)
        throw Error(fmt::format("the installed OSMesa (package libosmesa6) offers no OpenGL 4.1 core; {}",
                                kWithoutOpenGl));
    return context;
}

// Of the current context; OSMesa itself takes any size and then draws nothing.
bool within_limits(int width, int height) {
    int widest = 0, highest = 0;
    osmesa().get_integer(OSMESA_MAX_WIDTH, &widest);
    osmesa().get_integer(OSMESA_MAX_HEIGHT, &highest);
    return width <= widest && height <= highest;
}

}  // namespace

void Offscreen::Destroy::operator()(osmesa_context* context) const {
    if (osmesa().current() == context) osmesa().make_current(nullptr, nullptr, GL_UNSIGNED_BYTE, 0, 0);
    osmesa().destroy(context);
}

Offscreen::Offscreen(int width, int height) : context_(create_context()) {
    resize(width, height);
    gl_ = load_gl([](const char* name) { return reinterpret_cast<void*>(osmesa().address(name)); });
}

void Offscreen::resize(int width, int height) {
    Rgba8Image buffer(width, height);
    if (!osmesa().make_current(context_.get(), buffer.rgba.data(), GL_UNSIGNED_BYTE, width, height) ||
        !within_limits(width, height))
        throw Error(fmt::format("OSMesa makes no framebuffer of {} x {}; {}", width, height, kWithoutOpenGl));
    osmesa().pixel_store(OSMESA_Y_UP, 0);
    buffer_ = std::move(buffer);  // the bytes stay where they are
}

Rgba8Image Offscreen::read() const {
    gl_.Finish();  // only now does OSMesa write into the buffer
    return buffer_;
}

}  // namespace pim
