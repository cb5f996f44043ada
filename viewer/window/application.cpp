// SPDX-License-Identifier: GPL-3.0-or-later
#include "viewer/window/application.h"

#include <fmt/format.h>
#include <imgui.h>

#include <atomic>
#include <cmath>
#include <future>

#include "common/core/error.h"
#include "common/core/file.h"
#include "common/core/image.h"
#include "common/core/interrupt.h"
#include "common/core/log.h"
#include "common/core/stopwatch.h"
#include "viewer/display/display.h"
#include "viewer/display/imgui_context.h"
#include "viewer/display/offscreen.h"
#include "viewer/display/window.h"
#include "viewer/window/panels.h"

namespace pim {
namespace {

constexpr double kIdle = 0.25;       // s between looks at the world while nothing happens
constexpr int kBusyFrames = 3;       // ImGui needs some frames to settle after an input
constexpr double kTitleEvery = 0.5;  // s

// A session that is being opened in the background.
class Opening {
  public:
    Opening(const Arguments& arguments, Window& window)
        : result_(std::async(std::launch::async, [this, arguments, &window] {
              return std::make_unique<Session>(arguments, [this, &window](float progress, const char* what) {
                  progress_ = progress;
                  what_ = what;
                  window.wake();
              });
          })) {}
    bool is_done() const { return result_.wait_for(std::chrono::seconds(0)) == std::future_status::ready; }
    std::unique_ptr<Session> take() { return result_.get(); }  // throws what opening threw
    float progress() const { return progress_; }
    const char* what() const { return what_; }

  private:
    std::atomic<float> progress_ = 0;
    std::atomic<const char*> what_ = "";
    std::future<std::unique_ptr<Session>> result_;
};

Imath::V2i first_size(const Arguments& arguments) {
    return arguments.size.empty() ? Imath::V2i(1280, 800) : parse_size(arguments, {});
}

Image decoded(const Rgba8Image& shot) {
    Image image(shot.width, shot.height);
    for (int y = 0; y < shot.height; ++y)
        for (int x = 0; x < shot.width; ++x)
            for (int c = 0; c < 3; ++c) image.at(x, y)[c] = srgb_decode(float(shot.at(x, y)[c]) / 255);
    return image;
}

class Application {
  public:
    explicit Application(const Arguments& arguments)
        : arguments_(arguments),
          window_("pim", first_size(arguments).x, first_size(arguments).y),
          display_(window_.gl()),
          panels_([this](const std::string& text) { window_.set_clipboard(text); }) {
        imgui_.set_scale(window_.panel_scale());
        open(arguments.map);
    }

    void run() {
        while (!window_.should_close()) {
            throw_if_interrupted();
            step();
        }
    }

  private:
    void open(const std::filesystem::path& map) {
        if (opening_) return;
        arguments_.map = map;
        problem_.clear();
        opening_ = std::make_unique<Opening>(arguments_, window_);
    }

    void step() {
        const bool working = session_ && !session_->is_finished() && !window_.minimised();
        if (working || busy_ > 0)
            window_.poll();
        else
            window_.wait(kIdle);
        for (const auto& file : window_.take_dropped()) drop(file);
        finish_opening();
        if (window_.minimised()) {
            window_.wait(kIdle);
            return;
        }
        draw();
    }

    // Another scene: what was asked for on the command line belonged to the old one.
    void drop(const std::filesystem::path& file) {
        const std::filesystem::path map = file;
        Arguments fresh;
        fresh.vector_unit = arguments_.vector_unit;
        arguments_ = fresh;
        open(map);
    }

    void finish_opening() {
        if (!opening_ || !opening_->is_done()) return;
        try {
            session_ = opening_->take();
            controls_ = Controls{};
        } catch (const Error& e) {
            if (session_)
                session_->message = e.what();
            else if (!shown_ever_)
                throw;
            problem_ = e.what();
        }
        opening_.reset();
    }

    void draw() {
        const Imath::V2i size = window_.framebuffer_size();
        const double now = clock_.seconds();
        window_.begin_frame();
        const ImGuiIO& io = ImGui::GetIO();
        const Imath::V2i place(int(io.DisplaySize.x), int(io.DisplaySize.y));
        const bool input = io.MouseDelta.x != 0 || io.MouseDelta.y != 0 || io.MouseWheel != 0 ||
                           io.MouseDown[0] || io.MouseDown[1] || io.MouseDown[2] ||
                           io.InputQueueCharacters.Size > 0;
        busy_ = input || opening_ ? kBusyFrames : std::max(0, busy_ - 1);
        if (session_) {
            const Requests requests = controls_.update(*session_, place, io.DeltaTime);
            if (requests.reopen) open(session_->path());
            if (requests.full_screen) window_.toggle_full_screen();
            if (requests.close) window_.request_close();
            if (session_->advance(size, now)) {
                display_.show(session_->picture());
                ++frames_;
            }
            panels_.draw(*session_, controls_, place, now);
            shown_ever_ = true;
        }
        if (opening_ || (!session_ && !problem_.empty()))
            draw_loading(
                opening_ ? fmt::format("{}: {}", arguments_.map.filename().string(), opening_->what()) : "",
                opening_ ? opening_->progress() : 0, problem_);
        ImGui::Render();
        display_.draw(size.x, size.y, ImGui::GetDrawData());
        window_.swap();
        update_title(size, now);
    }

    void update_title(const Imath::V2i& size, double now) {
        if (!session_ || now - title_time_ < kTitleEvery) return;
        const double rate = double(frames_) / (now - title_time_);
        window_.set_title(fmt::format("{} - {} x {} - {:.0f} frames/s - pim",
                                      session_->path().stem().string(), size.x, size.y, rate));
        title_time_ = now;
        frames_ = 0;
    }

    Arguments arguments_;
    ImguiContext imgui_;
    Window window_;
    Display display_;
    Panels panels_;
    Controls controls_;
    std::unique_ptr<Session> session_;
    std::unique_ptr<Opening> opening_;
    std::string problem_;
    Stopwatch clock_;
    double title_time_ = 0;
    int frames_ = 0, busy_ = kBusyFrames;
    bool shown_ever_ = false;
};

}  // namespace

void run_window(const Arguments& arguments) { Application(arguments).run(); }

void render_panels(const Arguments& arguments) {
    if (arguments.output.extension() != ".png") throw UsageError("--ui: the picture is written as .png");
    check_output(arguments.output);
    Session session(arguments, [](float, const char*) {});
    const Imath::V2i size = first_size(arguments);
    ImguiContext imgui;
    Offscreen offscreen(size.x, size.y);
    Display display(offscreen.gl());
    Panels panels([](const std::string&) {});
    Controls controls;
    double now = 0;
    do session.advance(size, now += 1);
    while (!session.is_finished() && session.passes() < arguments.samples);
    display.show(session.picture());
    for (int settling = 0; settling < 3; ++settling) {  // ImGui lays out what it has seen once
        imgui.begin_frame_headless(size.x, size.y, 0.1f);
        panels.draw(session, controls, size, now);
        ImGui::Render();
        display.draw(size.x, size.y, ImGui::GetDrawData());
    }
    write_image(arguments.output, decoded(offscreen.read()), 1);
    log_info(fmt::format("wrote {} ({} x {})", arguments.output.string(), size.x, size.y));
}

}  // namespace pim
