// SPDX-License-Identifier: GPL-3.0-or-later
#include "viewer/window/session.h"

#include <fmt/format.h>

#include <cmath>

#include "common/core/error.h"
#include "common/core/stopwatch.h"
#include "common/map/baked_scene.h"
#include "viewer/files/command_text.h"
#include "viewer/files/lighting_setup.h"
#include "viewer/picture.h"

namespace pim {
namespace {

constexpr double kFluent = 1.0 / 30;  // s: a moving camera may cost so much before sharpness drops
constexpr double kRest = 0.06;        // s without change until the picture is sharp again
constexpr double kSlice = 0.015;      // s of sharpening at once
constexpr std::size_t kTilesAtOnce = 16;
constexpr double kLookAtFile = 1;  // s between looks at the map's file
constexpr std::size_t kFrameTimes = 120;

void to_grey(Image& image) {
    for (Rgb& pixel : image.pixels) pixel = Rgb(luminance(pixel));
}

}  // namespace

Session::Session(const Arguments& arguments, const std::function<void(float, const char*)>& stage)
    : arguments_(arguments),
      map_((stage(0, "opening the map"), arguments.map)),
      scene_((stage(0.2f, "reading the scene"), scene_of(map_.outline(), arguments.map, arguments.geometry))),
      caster_((stage(0.5f, "sorting the surfaces"), scene_.geometry), InstructionSet::best),
      relighter_(map_, scene_, caster_, parse_vector_unit(arguments)) {
    stage(0.8f, "first light");
    state = start_ = parse_state(arguments, scene_, map_.outline());
    if (!arguments.paths.empty()) animation_ = read_animation(arguments.paths, scene_);
}

bool Session::is_finished() const {
    return shown_size_ == size_ && state == shown_ && (is_unlit(state.view) || passes_ >= kPasses);
}

bool Session::advance(const Imath::V2i& size, double now) {
    if (size.x < 1 || size.y < 1) return false;  // minimised
    watch_file(now);
    const bool camera_moved = !(state.camera == shown_.camera) && size == size_;
    const bool changed = size != size_ || !(state == shown_);
    size_ = size;
    if (changed) {
        last_change_ = now;
        if (state.view != shown_.view || state.automatic_exposure != shown_.automatic_exposure)
            measured_ = false;
        const double ratio = camera_moved ? std::sqrt(full_seconds_ / kFluent) : 1;
        const int divisor = std::clamp(int(std::ceil(ratio - 0.25)), 1, 4);
        render({(size.x + divisor - 1) / divisor, (size.y + divisor - 1) / divisor});
        return true;
    }
    if (shown_size_ != size_) {
        if (now - last_change_ < kRest) return false;
        render(size_);
        return true;
    }
    if (is_finished() || now - last_change_ < kRest) return false;
    sharpen();
    return next_tile_ == 0;
}

Image Session::linear() {
    Image image = is_unlit(state.view)
                      ? render_unlit(state.view, scene_, map(), caster_, state.camera, shown_size_, 1)
                      : relighter_.linear();
    if (state.view == View::density) to_grey(image);
    return image;
}

// What cannot be shown leaves the last good state, and says why.
void Session::render(const Imath::V2i& size) {
    try {
        render_state(size);
    } catch (const Error& e) {
        if (picture_.width == 0 || state == shown_) throw;
        message = e.what();
        state = shown_;
        render_state(size);
    }
}

void Session::render_state(const Imath::V2i& size) {
    const Stopwatch watch;
    const bool moved = size != shown_size_ || !(state.camera == shown_.camera);
    if (!is_unlit(state.view)) relighter_.update(state, size);
    shown_ = state;
    shown_size_ = size;
    passes_ = 1;
    next_tile_ = 0;
    if (shows_radiance(state.view)) scale_.reset();
    if (picture_.width != size.x || picture_.height != size.y) picture_ = Rgba8Image(size.x, size.y);
    if (shows_radiance(state.view) && (measured_ || !state.automatic_exposure)) {
        exposure_ = state.automatic_exposure ? exposure_ : std::exp2(state.exposure);
        relighter_.encode(exposure_, state.tone_curve, reinterpret_cast<uint32_t*>(picture_.rgba.data()));
    } else {
        show(linear());
    }
    frame_seconds_ = watch.seconds();
    if (moved && size == size_) full_seconds_ = frame_seconds_;
    frame_times_.push_back(float(1000 * frame_seconds_));
    if (frame_times_.size() > kFrameTimes) frame_times_.erase(frame_times_.begin());
}

// A linear picture as it is displayed; measures it first where that is due.
void Session::show(const Image& linear) {
    auto* rgba = reinterpret_cast<uint32_t*>(picture_.rgba.data());
    if (!measured_) {
        scale_ = fitting_scale(state.view, linear);
        if (state.automatic_exposure) exposure_ = is_unlit(state.view) ? 1 : automatic_exposure(linear);
        measured_ = true;
    }
    if (!state.automatic_exposure) exposure_ = std::exp2(state.exposure);
    if (scale_)
        relighter_.encode(false_colours(linear, *scale_), 1, ToneCurve::none, rgba);
    else if (is_unlit(state.view))
        relighter_.encode(linear, 1, ToneCurve::none, rgba);
    else
        relighter_.encode(linear, exposure_, state.tone_curve, rgba);
}

// One slice of another pass over the resting picture.
void Session::sharpen() {
    const Stopwatch watch;
    if (passes_ == 1 && next_tile_ == 0) sum_ = relighter_.linear();
    const std::size_t tiles = relighter_.tile_count();
    while (next_tile_ < tiles && watch.seconds() < kSlice) {
        const std::size_t end = std::min(tiles, next_tile_ + kTilesAtOnce);
        relighter_.add_pass(passes_, next_tile_, end, sum_);
        next_tile_ = end;
    }
    if (next_tile_ < tiles) return;
    next_tile_ = 0;
    ++passes_;
    mean_ = sum_;
    for (Rgb& pixel : mean_.pixels) pixel /= float(passes_);
    if (state.view == View::density) to_grey(mean_);
    show(mean_);
}

void Session::watch_file(double now) {
    if (const std::string problem = relighter_.take_problem(); !problem.empty()) message = problem;
    if (now - last_look_ < kLookAtFile || reported_) return;
    last_look_ = now;
    const auto change = map_.change();
    if (change == MapFile::Change::none) return;
    reported_ = true;
    message = change == MapFile::Change::replaced
                  ? "The map was baked anew: this one stays open, F5 opens the new one."
                  : "The map's file was overwritten: what is in memory stays, F5 opens what is there now.";
}

void Session::measure_again() {
    measured_ = false;
    shown_size_ = Imath::V2i(0);  // render anew
}

void Session::reset_camera() { state.camera = start_.camera; }

void Session::play(double time) { state = animation_.at(time, state); }

void Session::move_lamp(const Vec3& position) {
    const Box3& domain = scene_.lights[selected].domain;
    const Vec3 inside(clamped(domain, position));
    state.lamps[selected].position = inside;
    message.clear();
    for (int axis = 0; axis < 3; ++axis)
        if (position[axis] != inside[axis] && domain.max[axis] > domain.min[axis])
            message += fmt::format("{}{} stops at {:.2f} m: the map was baked up to there",
                                   message.empty() ? "" : "; ", "xyz"[axis],
                                   double(inside[axis]) + scene_.geometry.origin[axis]);
}

std::optional<Reading> Session::read(const Vec2& place) {
    if (shown_size_.x < 1 || is_unlit(state.view)) return std::nullopt;
    const CameraRays rays(state.camera, size_);
    const Ray ray = rays.through(place.x * float(size_.x), place.y * float(size_.y));
    const auto hit = caster_.intersect(ray);
    if (!hit) return std::nullopt;
    const SurfacePoint surface = surface_at(scene_, *hit);
    Reading reading;
    reading.object = scene_.geometry.objects[scene_.geometry.triangles[hit->triangle].object];
    reading.position = scene_.geometry.to_world(surface.position);
    reading.irradiance = relighter_.irradiance(surface);
    reading.shown = surface.diffuse * reading.irradiance / kPi;
    return reading;
}

void Session::save_picture(const std::filesystem::path& path) {
    const Image image = passes_ > 1 ? mean_ : linear();
    for (const char* extension : {".exr", ".png"})
        write_picture(std::filesystem::path(path).replace_extension(extension), image, shown_, {exposure_, scale_});
}

void Session::save_setup(const std::filesystem::path& path) const { pim::save_setup(path, scene_, state); }

void Session::load_setup(const std::filesystem::path& path) { state = pim::load_setup(path, scene_, map()); }

std::string Session::command_line(const std::filesystem::path& output) const {
    ViewState fixed = state;
    if (fixed.automatic_exposure) {
        fixed.automatic_exposure = false;
        fixed.exposure = std::log2(exposure_);
    }
    return headless_command(scene_, map(), fixed, size_, {arguments_.map, output, arguments_.geometry});
}

}  // namespace pim
