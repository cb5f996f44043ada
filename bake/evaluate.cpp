// SPDX-License-Identifier: GPL-3.0-or-later
#include "bake/evaluate.h"

#include <cmath>
#include <numeric>

#include "bake/bake.h"
#include "common/core/error.h"
#include "common/core/file.h"
#include "common/core/log.h"
#include "common/core/parallel.h"
#include "common/core/progress.h"
#include "common/core/stopwatch.h"
#include "common/map/baked_scene.h"
#include "common/render/frame.h"
#include "common/render/light_image.h"
#include "common/render/map_radiance.h"
#include "common/render/path_radiance.h"

namespace pim {
namespace {

constexpr uint64_t kSeed = 0x5eed;
constexpr int kShadowSamples = 256;  // per rectangular lamp: the map's error, not that of soft shadows

struct PixelAnswer {
    Rgb map{0}, map_indirect{0};
    std::array<Rgb, 2> reference{Rgb(0), Rgb(0)}, reference_indirect{Rgb(0), Rgb(0)};  // the two halves
    bool surface = false;
    Vec2 place{0};  // in the image, 0 to 1
};

// Sums over the pixels of one camera and lamp position.
struct ErrorSums {
    double error = 0, norm = 0, noise = 0;

    void add(const Rgb& i, const std::array<Rgb, 2>& r) {
        error += double((i - r[0]).dot(i - r[1]));
        norm += double(r[0].dot(r[1]));
        noise += double((r[0] - r[1]).dot(r[0] - r[1]));
    }
    double relative_error() const { return norm > 0 ? std::sqrt(std::max(0.0, error) / norm) : 0; }
    double relative_noise() const { return norm > 0 ? 0.5 * std::sqrt(noise / norm) : 0; }
};

struct Position {
    double relrmse = 0, indirect = 0, noise = 0;
};

double mean(const std::vector<double>& v) {
    return std::accumulate(v.begin(), v.end(), 0.0) / double(v.size());
}

// Half width of the 95 % confidence interval of the mean.
double half_width(const std::vector<double>& v) {
    if (v.size() < 2) return 0;
    const double m = mean(v);
    double squares = 0;
    for (const double x : v) squares += (x - m) * (x - m);
    const double n = double(v.size()),
                 t = 1.96 + 2.4 / (n - 1) + 7 / ((n - 1) * (n - 1));  // Student's t, nearly
    return t * std::sqrt(squares / (n * (n - 1)));
}

class Evaluation {
  public:
    Evaluation(const std::filesystem::path& map_file, const EvaluateOptions& options)
        : options_(options),
          baked_(read_baked_scene(map_file, options.geometry)),
          caster_(baked_.scene.geometry, InstructionSet::best),
          solids_(solids_of(baked_.scene)) {}

    nlohmann::json run() {
        Progress progress("comparing with path tracing", uint64_t(options_.lights));
        for (int i = 0; i < options_.lights; ++i) {
            positions_.push_back(evaluate_position(i));
            progress.advance();
        }
        return summary();
    }

    double frame_seconds() {
        const Camera& camera = baked_.scene.cameras[0];
        std::vector<double> seconds;
        for (int i = 0; i < 3; ++i) {
            const Stopwatch watch;
            const Moment m = moment(place_lamps(i), true, Moment::kShadowSamples);
            render_frame(camera, {.size = camera.size, .samples = 1},
                         [&](const Ray& ray, RandomStream& random) { return map_radiance(m, ray, random); });
            seconds.push_back(watch.seconds());
        }
        std::ranges::sort(seconds);
        return seconds[1];
    }

  private:
    std::vector<LightState> place_lamps(int i) const {
        std::vector<LightState> states;
        for (std::size_t l = 0; l < baked_.scene.lights.size(); ++l) {
            const Light& light = baked_.scene.lights[l];
            RandomStream random(kSeed, RandomPurpose::evaluation, uint32_t(l), uint64_t(i));
            Vec3 position = light.position;
            for (int attempt = 0; attempt < 64; ++attempt) {
                for (int axis = 0; axis < 3; ++axis)
                    position[axis] =
                        light.domain.min[axis] + (light.domain.max - light.domain.min)[axis] * random.next();
                if (solids_.containing(position).empty()) break;
            }
            states.push_back({position, light.power});
        }
        return states;
    }

    Moment moment(const std::vector<LightState>& lamps, bool with_direct,
                  int shadow_samples = kShadowSamples) const {
        const bool baked_direct = baked_.map.has(Component::direct);
        Moment m{
            .scene = baked_.scene, .caster = caster_, .map = baked_.map, .lights = lamps, .patch_values = {}};
        m.direct = !with_direct ? DirectLight::none : baked_direct ? DirectLight::baked : DirectLight::traced;
        m.indirect = baked_.map.has(Component::indirect);
        m.shadow_samples = shadow_samples;
        evaluate_patches(m);
        return m;
    }

    Position evaluate_position(int i) {
        const auto lamps = place_lamps(i);
        const Moment whole = moment(lamps, true), indirect = moment(lamps, false);
        const PathScene paths{baked_.scene, caster_, lamps};
        Position result;
        const auto& cameras = baked_.scene.cameras;
        for (std::size_t c = 0; c < cameras.size(); ++c) {
            ErrorSums all, indirect_only;
            const int view = i * int(cameras.size()) + int(c);
            auto pixels = answers(cameras[c], view, whole, indirect, paths);
            if (point_lamps_meet_specular(baked_.scene)) add_light_images(cameras[c], view, paths, pixels);
            for (const PixelAnswer& p : pixels) {
                if (!p.surface) continue;
                all.add(p.map, p.reference);
                indirect_only.add(p.map_indirect, p.reference_indirect);
            }
            result.relrmse += all.relative_error() / double(cameras.size());
            result.indirect += indirect_only.relative_error() / double(cameras.size());
            result.noise += all.relative_noise() / double(cameras.size());
        }
        return result;
    }

    // Stratified pixels of one camera; map and reference look along the same camera rays.
    std::vector<PixelAnswer> answers(const Camera& camera, int view, const Moment& whole,
                                     const Moment& indirect, const PathScene& paths) const {
        const double wanted = std::max(16.0, double(options_.pixels) / double(baked_.scene.cameras.size()));
        const double aspect = double(camera.size.x) / double(camera.size.y);
        const int columns = std::max(1, int(std::lround(std::sqrt(wanted * aspect))));
        const int rows = std::max(1, int(std::lround(wanted / columns)));
        const CameraRays rays(camera, {columns, rows});
        std::vector<PixelAnswer> pixels(std::size_t(columns) * rows);
        parallel_for(pixels.size(), [&](std::size_t p) {
            RandomStream random(kSeed, RandomPurpose::evaluation, uint32_t(view + 64), p);
            const float x = float(int(p) % columns) + random.next(),
                        y = float(int(p) / columns) + random.next();
            const Ray ray = rays.through(x, y);
            PixelAnswer& pixel = pixels[p];
            pixel.place = {std::min(x / float(columns), 0.99999f), std::min(y / float(rows), 0.99999f)};
            pixel.map = map_radiance(whole, ray, random);
            pixel.map_indirect = map_radiance(indirect, ray, random);
            const int half = std::max(1, options_.paths / 2);
            for (int k = 0; k < 2 * half; ++k) {
                RandomStream path_random(kSeed, RandomPurpose::reference, uint32_t(view),
                                         p << 20 | uint64_t(k));
                const Seen seen = path_radiance(paths, ray, path_random);
                pixel.surface = seen.surface;
                pixel.reference[k & 1] += seen.total / float(half);
                pixel.reference_indirect[k & 1] += seen.indirect / float(half);
            }
        });
        return pixels;
    }

    // Light that only photons from the lamps find, from two independent images of the camera's own size.
    void add_light_images(const Camera& camera, int view, const PathScene& paths,
                          std::vector<PixelAnswer>& pixels) const {
        for (int half = 0; half < 2; ++half) {
            const uint64_t photons = uint64_t(options_.paths) * 4096;
            const Image image =
                light_image(paths, camera, camera.size, photons, kSeed, uint32_t(2 * view + half));
            for (PixelAnswer& p : pixels) {
                const Rgb& added =
                    image.at(int(p.place.x * float(image.width)), int(p.place.y * float(image.height)));
                p.reference[half] += added;
                p.reference_indirect[half] += added;
            }
        }
    }

    nlohmann::json summary() const {
        std::vector<double> all, indirect, noise;
        for (const Position& p : positions_)
            all.push_back(p.relrmse), indirect.push_back(p.indirect), noise.push_back(p.noise);
        std::vector<double> sorted = all;
        std::ranges::sort(sorted);
        const double p95 = sorted[std::size_t(std::ceil(0.95 * double(sorted.size()))) - 1];
        nlohmann::json notes = nlohmann::json::array();
        if (point_lamps_meet_specular(baked_.scene))
            notes.push_back(
                "point lamps shine on mirrors or glass: that part of their light is added to the reference "
                "by "
                "photons from the lamps; where it is seen in mirrors or through glass it is missing");
        return {{"relrmse", mean(all)},
                {"relrmse_indirect", mean(indirect)},
                {"relrmse_p95", p95},
                {"relrmse_per_position", all},
                {"reference_noise", mean(noise)},
                {"confidence", {{"relrmse", half_width(all)}, {"relrmse_indirect", half_width(indirect)}}},
                {"notes", notes}};
    }

    EvaluateOptions options_;
    BakedScene baked_;
    RayCaster caster_;
    Solids solids_;
    std::vector<Position> positions_;
};

}  // namespace

nlohmann::json evaluate_map(const std::filesystem::path& map_file, const EvaluateOptions& options) {
    Evaluation evaluation(map_file, options);
    nlohmann::json result = evaluation.run();
    result["frame_seconds"] = evaluation.frame_seconds();
    const auto run_file = WorkFolder::beside(map_file) / "run.json";
    result["bake_seconds"] = nullptr;
    if (std::filesystem::exists(run_file)) {
        const auto run = nlohmann::json::parse(read_text(run_file), nullptr, false);
        if (run.is_object() && run.contains("bake_seconds")) result["bake_seconds"] = run["bake_seconds"];
    }
    return result;
}

std::string evaluation_text(const nlohmann::json& e) {
    std::string text = fmt::format(
        "relative error {:.4f} ± {:.4f} (indirect part {:.4f} ± {:.4f}), 95 % of positions below {:.4f}\n"
        "reference's own noise {:.4f}; frame {:.4f} s\n",
        e["relrmse"].get<double>(), e["confidence"]["relrmse"].get<double>(),
        e["relrmse_indirect"].get<double>(), e["confidence"]["relrmse_indirect"].get<double>(),
        e["relrmse_p95"].get<double>(), e["reference_noise"].get<double>(), e["frame_seconds"].get<double>());
    if (e["bake_seconds"].is_number())
        text += fmt::format("baked in {:.1f} s\n", e["bake_seconds"].get<double>());
    for (const auto& note : e["notes"]) text += "note: " + note.get<std::string>() + "\n";
    return text;
}

}  // namespace pim
