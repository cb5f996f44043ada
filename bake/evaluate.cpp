// SPDX-License-Identifier: GPL-3.0-or-later
#include "bake/evaluate.h"

#include <fmt/format.h>

#include <cmath>

#include "bake/bake.h"
#include "bake/reference.h"
#include "bake/statistics.h"
#include "common/core/error.h"
#include "common/core/file.h"
#include "common/core/progress.h"
#include "common/core/stopwatch.h"
#include "common/map/baked_scene.h"
#include "common/render/frame.h"
#include "common/render/map_radiance.h"
#include "common/render/whitted_radiance.h"

namespace pim {
namespace {

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

// Half width of the 95 % confidence interval of the mean.
double half_width(const std::vector<double>& v) {
    if (v.size() < 2) return 0;
    const double n = double(v.size()),
                 t = 1.96 + 2.4 / (n - 1) + 7 / ((n - 1) * (n - 1));  // Student's t, nearly
    return t * standard_error(v);
}

class Evaluation {
  public:
    Evaluation(const BakedScene& baked, const RayCaster& caster, const Reference& reference,
               const Contest& contest)
        : baked_(baked), caster_(caster), reference_(reference), contest_(contest) {}

    nlohmann::json run() {
        Progress progress("comparing with path tracing", uint64_t(reference_.positions()));
        for (int i = 0; i < reference_.positions(); ++i) {
            positions_.push_back(evaluate_position(i));
            progress.advance();
        }
        return summary();
    }

    // Of the lamps' move and a picture with one sample per pixel, the median of three.
    double frame_seconds() const {
        const Camera& camera = baked_.scene.cameras[0];
        std::vector<double> seconds;
        for (int i = 0; i < 3; ++i) {
            const Stopwatch watch;
            const auto render = renderer(i % reference_.positions(), true, Moment::kShadowSamples);
            render_frame(camera, {.size = camera.size, .samples = 1}, render);
            seconds.push_back(watch.seconds());
        }
        std::ranges::sort(seconds);
        return seconds[1];
    }

  private:
    Moment moment(const std::vector<LightState>& lamps, bool with_direct, int shadow_samples) const {
        Moment m = evaluated_moment(baked_.scene, caster_, baked_.map, lamps);
        if (!with_direct) m.direct = DirectLight::none;
        m.shadow_samples = shadow_samples;
        evaluate_patches(m);
        return m;
    }

    Reference::Renderer renderer(int position, bool with_direct, int shadow_samples) const {
        const auto& lamps = reference_.lamps(position);
        if (contest_.contestant == Contestant::map) {
            const auto m = std::make_shared<Moment>(moment(lamps, with_direct, shadow_samples));
            return [m](const Ray& ray, RandomStream& random) { return map_radiance(*m, ray, random); };
        }
        const PathScene lit{baked_.scene, caster_, lamps};
        if (contest_.contestant == Contestant::whitted) {
            const int shadows = with_direct ? shadow_samples : 0;
            return [lit, shadows](const Ray& ray, RandomStream& random) {
                return whitted_radiance(lit, ray, shadows, random);
            };
        }
        PhotonMapOptions options = contest_.photon_map;
        options.direct = with_direct ? DirectLight::traced : DirectLight::none;
        options.shadow_samples = shadow_samples;
        options.seed += uint64_t(position);
        const auto scene = std::make_shared<PhotonScene>(
            build_photon_maps(lit, shoot_photons(lit, options.photons_per_lamp, options.seed), options));
        return [scene](const Ray& ray, RandomStream& random) { return photon_radiance(*scene, ray, random); };
    }

    Position evaluate_position(int i) const {
        const auto whole = renderer(i, true, kEvaluationShadowSamples),
                   part = renderer(i, false, kEvaluationShadowSamples);
        Position result;
        const double cameras = reference_.cameras();
        for (int c = 0; c < reference_.cameras(); ++c) {
            ErrorSums all, indirect;
            const auto& pixels = reference_.pixels(i, c);
            const auto seen = reference_.seen(i, c, whole), seen_part = reference_.seen(i, c, part);
            for (std::size_t p = 0; p < pixels.size(); ++p) {
                if (!pixels[p].surface) continue;
                all.add(seen[p], pixels[p].all);
                indirect.add(seen_part[p], pixels[p].indirect);
            }
            result.relrmse += all.relative_error() / cameras;
            result.indirect += indirect.relative_error() / cameras;
            result.noise += all.relative_noise() / cameras;
        }
        return result;
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

    const BakedScene& baked_;
    const RayCaster& caster_;
    const Reference& reference_;
    const Contest& contest_;
    std::vector<Position> positions_;
};

nlohmann::json bake_seconds_of(const std::filesystem::path& map_file) {
    const auto run_file = WorkFolder::beside(map_file) / "run.json";
    if (!std::filesystem::exists(run_file)) return nullptr;
    const auto run = nlohmann::json::parse(read_text(run_file), nullptr, false);
    return run.is_object() && run.contains("bake_seconds") ? run["bake_seconds"] : nullptr;
}

}  // namespace

Evaluator::Evaluator(EvaluateOptions options) : options_(std::move(options)) {}
Evaluator::~Evaluator() = default;

nlohmann::json Evaluator::evaluate(const std::filesystem::path& map_file, const Contest& contest) {
    const BakedScene baked = read_baked_scene(map_file, options_.geometry);
    const RayCaster caster(baked.scene.geometry, InstructionSet::best);
    if (const std::string key = Reference::key(baked.scene, options_); key != reference_key_) {
        reference_ = std::make_unique<Reference>(baked.scene, caster, solids_of(baked.scene), options_);
        reference_key_ = key;
    }
    Evaluation evaluation(baked, caster, *reference_, contest);
    nlohmann::json result = evaluation.run();
    result["frame_seconds"] = evaluation.frame_seconds();
    result["bake_seconds"] = bake_seconds_of(map_file);
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
