// SPDX-License-Identifier: GPL-3.0-or-later
#include "viewer/ptm_export.h"

#include <fmt/format.h>

#include <cmath>
#include <utility>

#include "common/core/error.h"
#include "common/core/file.h"
#include "common/core/log.h"
#include "common/core/progress.h"
#include "common/core/sampling.h"
#include "common/core/stopwatch.h"

namespace pim {
namespace {

constexpr int kGrid = 8;  // lamp positions along u and v
constexpr int kHeldOut = 16;

template <class Function>
Image mapped(Image image, Function function) {
    for (Rgb& pixel : image.pixels)
        for (int c = 0; c < 3; ++c) pixel[c] = function(pixel[c]);
    return image;
}

// Between radiance and what a display shows, channel by channel.
Image encoded(const Image& linear, float exposure) {
    return mapped(linear, [exposure](float x) { return srgb_encode(exposure * x); });
}
Image decoded(const Image& shown, float exposure) {
    return mapped(shown, [exposure](float x) { return srgb_decode(x) / exposure; });
}

// One picture twice, with independent noise.
struct Twice {
    Image first, second;
};
Twice twice(const Image& exact) { return {exact, exact}; }

// ⟨a₁ − b₁, a₂ − b₂⟩
double product(const Image& a1, const Image& b1, const Image& a2, const Image& b2) {
    double sum = 0;
    for (std::size_t p = 0; p < a1.pixels.size(); ++p)
        sum += double((a1.pixels[p] - b1.pixels[p]).dot(a2.pixels[p] - b2.pixels[p]));
    return sum;
}

// ‖a − b‖ / ‖reference‖
double relative_difference(const Twice& a, const Twice& b, const Twice& reference) {
    const Image black(reference.first.width, reference.first.height);
    const double norm = product(reference.first, black, reference.second, black);
    return norm > 0 ? std::sqrt(std::max(0.0, product(a.first, b.first, a.second, b.second)) / norm) : 0;
}

// At one lamp position, relative to the reference there.
struct Errors {
    double all = 0, clipping = 0, biquadratic = 0, chromaticity = 0, quantisation = 0, map = 0;
};

double mean(const std::vector<Errors>& errors, double Errors::*part) {
    double sum = 0;
    for (const Errors& e : errors) sum += e.*part;
    return sum / double(errors.size());
}

class PtmExport {
  public:
    PtmExport(const BakedScene& baked, const RayCaster& caster, const PictureOptions& options,
              std::size_t lamp, const LampPlane& plane)
        : baked_(baked),
          caster_(caster),
          options_(options),
          lamp_(lamp),
          plane_(plane),
          lamps_(chebyshev_grid(kGrid)),
          design_(lamps_),
          fit_(options.size, design_),
          exposure_(options.state.automatic_exposure ? fitting_exposure()
                                                     : std::exp2(options.state.exposure)) {}

    nlohmann::json run(const std::filesystem::path& path) {
        take_pictures();
        const Stopwatch watch;
        const Ptm ptm = fit_.lrgb();
        write_ptm(path, ptm);
        fit_seconds_ += watch.seconds();
        log_info(fmt::format("wrote {}", path.string()));
        nlohmann::json report = description(ptm);
        report["bytes"] = std::filesystem::file_size(path);
        report.update(errors(ptm, read_ptm(path)));
        return report;
    }

  private:
    bool noisy() const { return options_.integrator == Integrator::path; }

    // Noise is new for each `number`; pictures of the map have the same samples in each pixel at all of them.
    Image picture(const ViewState& state, uint64_t number) const {
        PictureOptions o = options_;
        o.state = state;
        if (noisy()) o.seed += number;
        return render_picture(baked_, caster_, o).image;
    }

    // Cut to white is what no polynomial brings back; so the exposure is that of the brightest which each
    // pixel gets with the lamp in the corners and the middle of the square.
    float fitting_exposure() {
        Image brightest(options_.size.x, options_.size.y);
        for (const Vec2& uv : {Vec2(0, 0), Vec2(-1, -1), Vec2(1, -1), Vec2(-1, 1), Vec2(1, 1)}) {
            const Image seen = picture(state_at(uv), ++taken_);
            for (std::size_t p = 0; p < seen.pixels.size(); ++p)
                for (int c = 0; c < 3; ++c)
                    brightest.pixels[p][c] = std::max(brightest.pixels[p][c], seen.pixels[p][c]);
        }
        return automatic_exposure(brightest);
    }

    ViewState state_at(const Vec2& uv) const {
        ViewState state = options_.state;
        state.lamps[lamp_].position = plane_.at(uv);
        return state;
    }

    void take_pictures() {
        Progress progress("taking pictures", lamps_.size());
        for (std::size_t k = 0; k < lamps_.size(); ++k) {
            Stopwatch watch;
            const Image linear = picture(state_at(lamps_[k]), ++taken_);
            picture_seconds_ += watch.seconds();
            watch = Stopwatch();
            fit_.add(k, encoded(linear, exposure_));
            fit_seconds_ += watch.seconds();
            progress.advance();
        }
    }

    nlohmann::json along(int i) const {
        const int axis = plane_.axes[std::size_t(i)];
        const auto world = [&](float uv) {
            return baked_.scene.geometry.to_world(plane_.at(Vec2(uv)))[axis];
        };
        return {{"axis", std::string(1, "xyz"[axis])}, {"from", world(-1)}, {"to", world(1)}};
    }

    nlohmann::json description(const Ptm& ptm) const {
        return {{"lamp", baked_.scene.lights[lamp_].name},
                {"u", along(0)},
                {"v", along(1)},
                {"width", ptm.width},
                {"height", ptm.height},
                {"exposure", std::log2(exposure_)},
                {"lamp_positions", lamps_.size()},
                {"singular_values", design_.singular_values},
                {"condition_number", design_.condition_number()},
                {"quantisation_steps", ptm_steps(ptm)},
                {"pictures_seconds", picture_seconds_},
                {"fit_seconds", fit_seconds_}};
    }

    Twice reference(const ViewState& state) {
        Twice r = twice(picture(state, ++taken_));
        if (noisy()) r.second = picture(state, ++taken_);
        return r;
    }

    // `fitted` as it was written, `file` as it is read.
    Errors errors_at(const Vec2& uv, const Ptm& fitted, const Ptm& file) {
        const ViewState state = state_at(uv);
        const Twice seen = reference(state);
        const auto linear = [&](const Image& shown) { return twice(decoded(shown, exposure_)); };
        const auto cut = [&](const Image& x) { return decoded(encoded(x, exposure_), exposure_); };
        const Twice clipped{cut(seen.first), cut(seen.second)},
            polynomial = linear(fit_.per_channel(uv.x, uv.y)), tinted = linear(relit(fitted, uv.x, uv.y)),
            written = linear(relit(file, uv.x, uv.y));
        return {.all = relative_difference(written, seen, seen),
                .clipping = relative_difference(clipped, seen, seen),
                .biquadratic = relative_difference(polynomial, clipped, seen),
                .chromaticity = relative_difference(tinted, polynomial, seen),
                .quantisation = relative_difference(written, tinted, seen),
                .map = noisy() ? relative_difference(picture_of_map(state), seen, seen) : 0};
    }

    nlohmann::json errors(const Ptm& fitted, const Ptm& file) {
        std::vector<Errors> errors;
        Progress progress("comparing", kHeldOut);
        for (uint64_t k = 0; k < kHeldOut; ++k) {
            const Vec2 place(float(golden_sequence(k, 0, 2)), float(golden_sequence(k, 1, 2)));
            errors.push_back(errors_at(2.0f * place - Vec2(1), fitted, file));
            progress.advance();
        }
        nlohmann::json each = nlohmann::json::array();
        for (const Errors& e : errors) each.push_back(e.all);
        nlohmann::json report{{"held_out_positions", kHeldOut},
                              {"relrmse", mean(errors, &Errors::all)},
                              {"relrmse_per_position", each},
                              {"parts",
                               {{"clipping", mean(errors, &Errors::clipping)},
                                {"biquadratic", mean(errors, &Errors::biquadratic)},
                                {"chromaticity", mean(errors, &Errors::chromaticity)},
                                {"quantisation", mean(errors, &Errors::quantisation)}}}};
        if (noisy()) report["relrmse_map"] = mean(errors, &Errors::map);
        return report;
    }

    Twice picture_of_map(const ViewState& state) {
        PictureOptions o = options_;
        o.state = state;
        o.integrator = Integrator::polynomial;
        const auto next = [&] {
            o.seed = options_.seed + ++taken_;
            return render_picture(baked_, caster_, o).image;
        };
        Image first = next();
        return {std::move(first), next()};
    }

    const BakedScene& baked_;
    const RayCaster& caster_;
    const PictureOptions& options_;
    std::size_t lamp_;
    const LampPlane& plane_;
    std::vector<Vec2> lamps_;
    PtmDesign design_;
    PtmFit fit_;
    uint64_t taken_ = 0;  // pictures
    float exposure_;
    double picture_seconds_ = 0, fit_seconds_ = 0;
};

}  // namespace

LampPlane check_ptm(const std::filesystem::path& path, const Scene& scene, const PictureOptions& options,
                    std::size_t lamp) {
    if (path.extension() != ".ptm")
        throw UsageError(
            fmt::format("--export-ptm: {}: viewers look for .ptm; name the file so", path.string()));
    if (!shows_radiance(options.state.view))
        throw UsageError("--view: a polynomial texture map shows radiance, direct and indirect only");
    if (options.state.tone_curve != ToneCurve::none)
        throw UsageError("--tone-curve: a polynomial texture map has none");
    if (is_rival(options.integrator))
        throw UsageError("--integrator: a polynomial texture map is made by polynomial or path only");
    const auto plane = lamp_plane(scene.lights[lamp].domain, options.state.lamps[lamp].position);
    if (!plane)
        throw UsageError(fmt::format(
            "--export-ptm: the domain of {} extends on fewer than two axes; choose another with --ptm-lamp",
            scene.lights[lamp].name));
    check_output(path);
    return *plane;
}

nlohmann::json export_ptm(const std::filesystem::path& path, const BakedScene& baked, const RayCaster& caster,
                          const PictureOptions& options, std::size_t lamp, const LampPlane& plane) {
    return PtmExport(baked, caster, options, lamp, plane).run(path);
}

}  // namespace pim
