// SPDX-License-Identifier: GPL-3.0-or-later
// An open scene in the window: what a person has set, and the picture of it, which follows every change at
// once and sharpens while all rests. No OpenGL, no panels.
#pragma once

#include <memory>

#include "viewer/arguments.h"
#include "viewer/display/rgba_image.h"
#include "viewer/files/animation.h"
#include "viewer/relight/relighter.h"
#include "viewer/tone/false_colour.h"

namespace pim {

// What is under the mouse.
struct Reading {
    std::string object;
    Vec3d position;  // world, m
    Rgb irradiance;  // W/m²
    Rgb shown;       // the picture's linear value
};

class Session {
  public:
    static constexpr int kPasses = 64;  // a resting picture is the mean of so many

    // Reads the map and its scene. `stage` is called with what is going on, for a progress bar. Throws Error
    // and UsageError.
    Session(const Arguments& arguments, const std::function<void(float, const char*)>& stage);

    ViewState state;           // panels and mouse change it; `advance` follows
    std::size_t selected = 0;  // lamp with the handles
    std::string message;       // the latest, for the person

    // Brings the picture up to date, in slices of some hundredths of a second; `now` in seconds. True: there
    // is a new picture. Throws Error.
    bool advance(const Imath::V2i& size, double now);
    const Rgba8Image& picture() const { return picture_; }
    bool is_finished() const;  // nothing more to sharpen
    int passes() const { return passes_; }

    const Scene& scene() const { return scene_; }
    const IlluminationMap& map() const { return map_.outline(); }
    const std::filesystem::path& path() const { return arguments_.map; }
    const Relighter& relighter() const { return relighter_; }
    const Animation* animation() const { return arguments_.paths.empty() ? nullptr : &animation_; }
    // Of the legend, where the view has one.
    const std::optional<Scale>& scale() const { return scale_; }
    float exposure() const { return exposure_; }  // factor in use
    double frame_seconds() const { return frame_seconds_; }
    const std::vector<float>& frame_times() const { return frame_times_; }  // ms, latest last

    void measure_again();    // exposure and legend fit the picture anew
    void reset_camera();     // to where it was when the map was opened
    void play(double time);  // state to where the animation is
    void move_lamp(
        const Vec3& position);  // of the selected lamp, kept inside its domain; says where it stops
    std::optional<Reading> read(const Vec2& place);  // of the picture, 0..1 from its upper left corner

    // What is kept. Throw Error.
    void save_picture(const std::filesystem::path& path);  // .exr and .png
    void save_setup(const std::filesystem::path& path) const;
    void load_setup(const std::filesystem::path& path);
    std::string command_line(const std::filesystem::path& output) const;

  private:
    void render(const Imath::V2i& size);
    void render_state(const Imath::V2i& size);
    void show(const Image& linear);
    void sharpen();
    void watch_file(double now);
    Image linear();

    Arguments arguments_;
    MapFile map_;
    Scene scene_;
    RayCaster caster_;
    Relighter relighter_;
    Animation animation_;
    ViewState shown_, start_;
    Imath::V2i size_{0}, shown_size_{0};
    Rgba8Image picture_;
    Image sum_, mean_;  // of passes; mean_ of the whole ones
    int passes_ = 0;
    std::size_t next_tile_ = 0;
    bool measured_ = false;
    double last_change_ = 0, full_seconds_ = 0, frame_seconds_ = 0, last_look_ = 0;
    std::vector<float> frame_times_;
    float exposure_ = 1;
    std::optional<Scale> scale_;
    bool reported_ = false;
};

}  // namespace pim
