// SPDX-License-Identifier: GPL-3.0-or-later
#include "viewer/benchmark.h"

#include <cmath>
#include <iostream>
#include <nlohmann/json.hpp>
#include <thread>

#include "common/core/memory.h"
#include "common/core/parallel.h"
#include "common/core/stopwatch.h"
#include "common/map/baked_scene.h"
#include "viewer/display/display.h"
#include "viewer/display/offscreen.h"
#include "viewer/interaction/navigation.h"
#include "viewer/relight/relighter.h"

namespace pim {
namespace {

constexpr int kFrames = 120;

class Benchmark {
  public:
    explicit Benchmark(const Arguments& a)
        : start_(),
          map_(a.map),
          scene_(scene_of(map_.outline(), a.map, a.geometry)),
          caster_(scene_.geometry, InstructionSet::best),
          unit_(parse_vector_unit(a)),
          relighter_(map_, scene_, caster_, unit_),
          state_(parse_state(a, scene_, map_.outline())),
          size_(parse_size(a, state_.camera)),
          rgba_(std::size_t(size_.x) * std::size_t(size_.y)) {
        frame();
        first_picture_ = start_.seconds();
    }

    nlohmann::json run() {
        nlohmann::json result{{"width", size_.x},
                              {"height", size_.y},
                              {"lamps", scene_.lights.size()},
                              {"threads", thread_count()},
                              {"vector_unit", name(unit_)},
                              {"seconds_to_first_picture", first_picture_},
                              {"first_lap", motion([&](int i) { move_lamps(i); })}};
        // Boxes are read while a lamp is under way for the first time; then they are there.
        while (!relighter_.store().is_settled()) std::this_thread::sleep_for(std::chrono::milliseconds(10));
        result["lamp_moving"] = motion([&](int i) { move_lamps(i); });
        const FrameStatistics& s = relighter_.statistics();
        result["points"] = s.points;
        result["patches_per_point"] = s.patches_per_point;
        result["patches_in_view"] = s.evaluated_patches;
        result["cut_values"] = s.cut_values;
        result["view_cache_bytes"] = s.cache_bytes;
        result["coefficient_bytes"] = relighter_.store().bytes();
        result["boxes_in_memory"] = relighter_.store().boxes();
        const Camera camera = state_.camera;
        result["camera_moving"] = motion([&](int i) {
            state_.camera = camera;
            orbit(state_.camera, 0.1f * std::sin(0.3f * float(i)), 0.02f * std::cos(0.2f * float(i)));
        });
        result["peak_rss_bytes"] = peak_memory();
        result["display_ms"] = display_milliseconds();  // last: a driver's memory is not the engine's
        return result;
    }

  private:
    void frame() {
        relighter_.update(state_, size_);
        relighter_.encode(1, state_.tone_curve, rgba_.data());
    }

    // Back and forth along the diagonal of each domain, across all borders of its boxes.
    void move_lamps(int i) {
        const float t = 0.5f - 0.5f * std::cos(6.2831853f * float(i) / 60);
        for (std::size_t l = 0; l < state_.lamps.size(); ++l) {
            const Box3& domain = scene_.lights[l].domain;
            state_.lamps[l].position = domain.min + (domain.max - domain.min) * t;
        }
    }

    // The picture through OpenGL into another framebuffer, by the driver that needs no display.
    double display_milliseconds() {
        Offscreen offscreen(size_.x, size_.y);
        Display display(offscreen.gl());
        std::vector<double> seconds;
        for (int i = 0; i < 20; ++i) {
            const Stopwatch watch;
            display.show(reinterpret_cast<const uint8_t*>(rgba_.data()), size_.x, size_.y);
            display.draw(size_.x, size_.y, nullptr);
            offscreen.gl().Finish();
            seconds.push_back(watch.seconds());
        }
        return quantile(seconds, 0.5);
    }

    template <class Move>
    nlohmann::json motion(Move move) {
        std::vector<double> all, shadow, evaluate, shade, view;
        std::size_t boxes = 0;
        for (int i = 0; i < kFrames; ++i) {
            move(i);
            const Stopwatch watch;
            frame();
            all.push_back(watch.seconds());
            const FrameStatistics& s = relighter_.statistics();
            view.push_back(s.view_seconds), shadow.push_back(s.shadow_seconds);
            evaluate.push_back(s.evaluate_seconds), shade.push_back(s.shade_seconds);
            boxes = std::max(boxes, s.active_boxes);
        }
        return {{"frames", kFrames},
                {"median_ms", quantile(all, 0.5)},
                {"p95_ms", quantile(all, 0.95)},
                {"longest_ms", quantile(all, 1)},
                {"frames_per_second", 1000 / quantile(all, 0.5)},
                {"most_active_boxes", boxes},
                {"parts_ms",
                 {{"view", quantile(view, 0.5)},
                  {"shadow_rays", quantile(shadow, 0.5)},
                  {"evaluate", quantile(evaluate, 0.5)},
                  {"shade", quantile(shade, 0.5)}}}};
    }

    static double quantile(std::vector<double> seconds, double q) {
        std::ranges::sort(seconds);
        return 1000 * seconds[std::size_t(std::ceil(q * double(seconds.size() - 1)))];
    }

    Stopwatch start_;
    MapFile map_;
    Scene scene_;
    RayCaster caster_;
    VectorUnit unit_;
    Relighter relighter_;
    ViewState state_;
    Imath::V2i size_;
    std::vector<uint32_t> rgba_;
    double first_picture_ = 0;
};

}  // namespace

void print_benchmark(const Arguments& arguments) { std::cout << Benchmark(arguments).run().dump(2) << "\n"; }

}  // namespace pim
