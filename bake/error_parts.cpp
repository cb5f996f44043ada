// SPDX-License-Identifier: GPL-3.0-or-later
#include "bake/error_parts.h"

#include <fmt/format.h>

#include <cmath>

#include "bake/bake.h"
#include "bake/fit.h"
#include "bake/reference.h"
#include "bake/visible_light.h"
#include "common/core/error.h"
#include "common/core/file.h"
#include "common/core/image.h"
#include "common/core/parallel.h"
#include "common/core/progress.h"
#include "common/core/stopwatch.h"
#include "common/map/baked_scene.h"
#include "common/map/irradiance.h"
#include "common/render/camera_rays.h"
#include "common/render/map_radiance.h"
#include "common/render/seen_radiance.h"

namespace pim {
namespace fs = std::filesystem;
namespace {

constexpr int kParts = 4;
constexpr std::array<const char*, kParts> kNames{"noise", "polynomial", "leak", "grid"};
constexpr int kUnseen = 1 << 19;  // numbers of lamp positions that no bake uses
constexpr std::size_t kWorst = 8;

using Colours = std::vector<Rgb>;
using Matrix = std::array<std::array<double, kParts>, kParts>;

// One pixel in all experiments: [experiment] of half a or b; the first is the map itself in both.
struct Steps {
    std::array<Rgb, kParts + 1> seen;
    Rgb step(int part) const { return seen[std::size_t(part)] - seen[std::size_t(part) + 1]; }
};

struct WorstPixel {
    double square = 0;  // error over the view's mean square
    int position = 0, camera = 0;
    Vec2 place{0};
    std::array<Steps, 2> halves;
};

class ErrorParts {
  public:
    ErrorParts(const fs::path& map_file, const ErrorPartsOptions& options)
        : options_(options),
          baked_(read_baked_scene(map_file, options.evaluate.geometry)),
          caster_(baked_.scene.geometry, InstructionSet::pinned),
          solids_(solids_of(baked_.scene)),
          cells_(find_cells(baked_.scene, caster_,
                            [&](const Vec3& p) { return solids_.containing(p).empty(); })),
          surface_(cells_.grid, baked_.scene.geometry),
          reference_(baked_.scene, caster_, solids_, options.evaluate) {
        if (!same_patches())
            throw Error(fmt::format("{}: its cells are not those that this version finds; bake it again",
                                    map_file.string()));
    }

    nlohmann::json run() {
        const Stopwatch watch;
        const std::array<IlluminationMap, 2> others{rebaked(1), rebaked(2)};
        std::optional<VisibleLight> visible;
        if (baked_.scene.grid.estimator == Estimator::area) visible.emplace(baked_.scene, cells_, surface_);
        Progress progress("taking the error apart", uint64_t(reference_.positions()));
        for (int i = 0; i < reference_.positions(); ++i) {
            take_apart(i, others, visible ? &*visible : nullptr);
            progress.advance();
        }
        return summary(watch.seconds());
    }

  private:
    bool same_patches() const {
        const auto& baked = baked_.map.patches;
        return baked.size() == cells_.patches.size() &&
               std::ranges::equal(baked, cells_.patches, [](const Patch& a, const Patch& b) {
                   return a.cell == b.cell && a.slot == b.slot && a.area == b.area;
               });
    }

    // As baked, but for the random numbers.
    Scene other_scene(int half) const {
        Scene scene = baked_.scene;
        scene.bake.seed += uint64_t(half) * 0x9e3779b97f4a7c15u;
        return scene;
    }

    IlluminationMap rebaked(int half) const {
        const Scene scene = other_scene(half);
        std::vector<std::string> warnings;
        const auto samples = all_light_samples(scene, solids_, warnings);
        std::vector<DensityVolume> volumes(samples.size());
        Progress progress(fmt::format("baking again, {} of 2", half), samples.size());
        parallel_for(samples.size(), [&](std::size_t i) {
            volumes[i] = trace_density(scene, caster_, cells_, surface_, samples[i]);
            progress.advance();
        });
        IlluminationMap map = baked_.map;
        map.lights.clear();
        const Neighbourhoods shared = neighbourhoods(scene, cells_);
        for (std::size_t l = 0; l < scene.lights.size(); ++l) {
            std::vector<LightSample> own;
            std::vector<const DensityVolume*> own_volumes;
            for (std::size_t i = 0; i < samples.size(); ++i)
                if (samples[i].light == int(l)) own.push_back(samples[i]), own_volumes.push_back(&volumes[i]);
            const auto density = [&](const LightSample& sample, Component c) {
                const auto found = std::ranges::find(own, sample.number, &LightSample::number);
                return own_volumes[std::size_t(found - own.begin())]->components[int(c)];
            };
            map.lights.push_back(
                fit_light(scene.lights[l], scene.bake, own, cells_.patches.size(), shared, density));
        }
        return map;
    }

    Moment moment(const IlluminationMap& map, int position) const {
        return evaluated_moment(baked_.scene, caster_, map, reference_.lamps(position));
    }

    std::vector<Landed> land(int position, int half) const {
        Scene scene = other_scene(half);
        scene.bake.photons *= uint64_t(options_.photons);
        std::vector<Landed> all;
        for (std::size_t l = 0; l < scene.lights.size(); ++l) {
            const LightState& state = reference_.lamps(position)[l];
            const auto landed = landed_light(scene, caster_, cells_, surface_,
                                             {int(l), kUnseen + position, state.position}, state.power);
            all.insert(all.end(), landed.begin(), landed.end());
        }
        return all;
    }

    // Irradiance of the patches from a density volume of this very position, where photons belong to no
    // patch.
    Colours own_volume(int position, int half) const {
        Scene scene = other_scene(half);
        scene.bake.photons *= uint64_t(options_.photons);
        Colours values(cells_.patches.size(), Rgb(0));
        for (std::size_t l = 0; l < scene.lights.size(); ++l) {
            const LightState& state = reference_.lamps(position)[l];
            const auto volume =
                trace_density(scene, caster_, cells_, surface_, {int(l), kUnseen + position, state.position});
            for (const auto& component : volume.components)
                for (std::size_t p = 0; p < component.density.size(); ++p)
                    values[p] += component.density[p] * state.power;
        }
        return values;
    }

    void take_apart(int i, const std::array<IlluminationMap, 2>& others, VisibleLight* visible) {
        Moment own = moment(baked_.map, i);
        evaluate_patches(own);
        std::array<std::vector<std::array<Colours, kParts + 1>>, 2> seen;  // [half][camera][experiment]
        for (std::size_t half = 0; half < 2; ++half) {
            Moment other = moment(others[half], i), exact = moment(baked_.map, i);
            evaluate_patches(other);
            if (visible) {
                visible->set(land(i, int(half) + 1));
                exact.patch_values = visible->patch_values();
            } else {
                exact.patch_values = own_volume(i, int(half) + 1);
            }
            const Colours averages = exact.patch_values;
            exact.patch_values = baked_.scene.bake.shrinkage ? sharpened(averages, cells_.means) : averages;
            for (int c = 0; c < reference_.cameras(); ++c) {
                auto& pictures = seen[half].emplace_back();
                const auto by = [&](const Moment& m) {
                    return reference_.seen(i, c, [&](const Ray& ray, RandomStream& random) {
                        return map_radiance(m, ray, random);
                    });
                };
                pictures[0] = by(own), pictures[1] = by(other), pictures[2] = by(exact);
                pictures[3] = visible ? by_visible(exact, averages, *visible, i, c) : pictures[2];
                for (const ReferencePixel& p : reference_.pixels(i, c)) pictures[4].push_back(p.all[half]);
            }
        }
        for (int c = 0; c < reference_.cameras(); ++c) {
            add(i, c, seen[0][std::size_t(c)], seen[1][std::size_t(c)]);
            if (i == 0 && options_.pictures)
                write_pictures(c, seen[0][std::size_t(c)], seen[1][std::size_t(c)]);
        }
    }

    // `averages`: the patches' values before they were sharpened, which visible light stands for.
    Colours by_visible(const Moment& exact, const Colours& averages, const VisibleLight& visible, int i,
                       int c) const {
        return reference_.seen(i, c, [&](const Ray& ray, RandomStream& random) {
            return seen_radiance(exact, ray, [&](const SurfacePoint& s) {
                const Rgb as_it_is = irradiance_at(exact.map, averages, s.position, s.shading_normal);
                const Rgb all = surface_irradiance(exact, s, random);
                return all - as_it_is + visible.irradiance(exact.map, caster_, s);
            });
        });
    }

    void add(int position, int camera, const std::array<Colours, kParts + 1>& a,
             const std::array<Colours, kParts + 1>& b) {
        const auto& pixels = reference_.pixels(position, camera);
        Matrix sums{};
        double norm = 0, count = 0;
        for (const ReferencePixel& p : pixels)
            if (p.surface) norm += double(p.all[0].dot(p.all[1])), ++count;
        if (!(norm > 0)) return;
        for (std::size_t p = 0; p < pixels.size(); ++p) {
            if (!pixels[p].surface) continue;
            WorstPixel pixel{0, position, camera, pixels[p].place, {}};
            for (std::size_t e = 0; e <= kParts; ++e)
                pixel.halves[0].seen[e] = a[e][p], pixel.halves[1].seen[e] = b[e][p];
            for (int j = 0; j < kParts; ++j)
                for (int k = 0; k < kParts; ++k)
                    sums[j][k] += double(pixel.halves[0].step(j).dot(pixel.halves[1].step(k))) / norm;
            const Rgb e = a[0][p] - (a[kParts][p] + b[kParts][p]) / 2;
            pixel.square = double(e.dot(e)) * count / norm;
            keep_worst(pixel);
        }
        views_.push_back(sums);
    }

    void keep_worst(const WorstPixel& pixel) {
        if (worst_.size() == kWorst && pixel.square <= worst_.back().square) return;
        const auto place =
            std::ranges::find_if(worst_, [&](const auto& w) { return w.square < pixel.square; });
        worst_.insert(place, pixel);
        if (worst_.size() > kWorst) worst_.pop_back();
    }

    void write_pictures(int camera, const std::array<Colours, kParts + 1>& a,
                        const std::array<Colours, kParts + 1>& b) const {
        const std::string name = baked_.scene.cameras[std::size_t(camera)].name;
        const auto size = reference_.size(camera);
        const auto write = [&](const std::string& what, const std::function<Rgb(std::size_t)>& colour) {
            Image image(size.x, size.y);
            for (std::size_t p = 0; p < image.pixels.size(); ++p) image.pixels[p] = colour(p);
            write_image(*options_.pictures / fmt::format("{}_{}.exr", name, what), image, 1);
        };
        const auto mean = [&](std::size_t e, std::size_t p) { return (a[e][p] + b[e][p]) / 2; };
        write("map", [&](std::size_t p) { return a[0][p]; });
        write("reference", [&](std::size_t p) { return mean(kParts, p); });
        for (std::size_t part = 0; part < kParts; ++part)
            write(kNames[part], [&](std::size_t p) { return mean(part, p) - mean(part + 1, p); });
    }

    nlohmann::json to_json(const WorstPixel& w) const {
        const Scene& scene = baked_.scene;
        const Camera& camera = scene.cameras[std::size_t(w.camera)];
        const auto rgb = [](const Rgb& v) { return nlohmann::json{v.x, v.y, v.z}; };
        nlohmann::json steps = nlohmann::json::object();
        for (int j = 0; j < kParts; ++j)
            steps[kNames[std::size_t(j)]] = rgb((w.halves[0].step(j) + w.halves[1].step(j)) / 2);
        nlohmann::json json{{"position", w.position},
                            {"camera", camera.name},
                            {"place", {w.place.x, w.place.y}},
                            {"error_over_rms", std::sqrt(w.square)},
                            {"map", rgb(w.halves[0].seen[0])},
                            {"reference", rgb((w.halves[0].seen[kParts] + w.halves[1].seen[kParts]) / 2)},
                            {"steps", steps}};
        const CameraRays rays(camera, camera.size);
        const auto hit = caster_.intersect(
            rays.through(w.place.x * float(camera.size.x), w.place.y * float(camera.size.y)));
        if (!hit) return json;
        const SurfacePoint s = surface_at(scene, *hit);
        float nearest = std::numeric_limits<float>::infinity();
        for (const LightState& lamp : reference_.lamps(w.position))
            nearest = std::min(nearest, (lamp.position - s.position).length());
        json["lamp_distance"] = nearest;
        json["material"] = s.material->name;
        json["object"] = scene.geometry.objects[scene.geometry.triangles[s.triangle].object];
        return json;
    }

    nlohmann::json summary(double seconds) const {
        const auto n = double(views_.size());
        nlohmann::json squares = nlohmann::json::array(), confidence = nlohmann::json::array(), relrms,
                       worst = nlohmann::json::array();
        double whole = 0;
        for (std::size_t j = 0; j < kParts; ++j) {
            squares.push_back(nlohmann::json::array());
            for (std::size_t k = 0; k < kParts; ++k) {
                double sum = 0;
                for (const Matrix& view : views_) sum += (view[j][k] + view[k][j]) / (2 * n);
                squares[j].push_back(sum);
                whole += sum;
            }
            const double own = squares[j][j];
            double scatter = 0;
            for (const Matrix& view : views_) scatter += (view[j][j] - own) * (view[j][j] - own);
            confidence.push_back(n > 1 ? 1.96 * std::sqrt(scatter / (n * (n - 1))) : 0.0);
            relrms[kNames[j]] = std::sqrt(std::max(0.0, own));
        }
        for (const WorstPixel& w : worst_) worst.push_back(to_json(w));
        return {{"parts", kNames},
                {"relative_squares", squares},
                {"confidence", confidence},
                {"relative_square", whole},
                {"relrms", relrms},
                {"worst", worst},
                {"positions", reference_.positions()},
                {"seconds", seconds}};
    }

    ErrorPartsOptions options_;
    BakedScene baked_;
    RayCaster caster_;
    Solids solids_;
    Cells cells_;
    SurfaceCells surface_;
    Reference reference_;
    std::vector<Matrix> views_;
    std::vector<WorstPixel> worst_;
};

}  // namespace

nlohmann::json error_parts(const fs::path& map_file, const ErrorPartsOptions& options) {
    if (options.pictures) fs::create_directories(*options.pictures);
    return ErrorParts(map_file, options).run();
}

std::string error_parts_text(const nlohmann::json& parts) {
    std::string text = "squared error, in parts of the whole (± 95 %):\n";
    const double whole = parts["relative_square"].get<double>();
    const auto& squares = parts["relative_squares"];
    const auto percent = [&](double square) { return whole > 0 ? 100 * square / whole : 0.0; };
    for (std::size_t j = 0; j < kParts; ++j)
        text += fmt::format(
            "  {:<24} {:8.2f} % ± {:.2f}   alone {:.4f}\n", kNames[j], percent(squares[j][j].get<double>()),
            percent(parts["confidence"][j].get<double>()), parts["relrms"][kNames[j]].get<double>());
    for (std::size_t j = 0; j < kParts; ++j)
        for (std::size_t k = j + 1; k < kParts; ++k)
            text += fmt::format("  {:<24} {:8.2f} %\n", fmt::format("2 · {} · {}", kNames[j], kNames[k]),
                                percent(2 * squares[j][k].get<double>()));
    text += fmt::format("  {:<24}   100.00 %            {:.4f}\n", "whole", std::sqrt(std::max(0.0, whole)));
    text += "worst pixels:\n";
    for (const auto& w : parts["worst"]) {
        std::string most;
        double largest = -1;
        for (const auto& [name, step] : w["steps"].items()) {
            double square = 0;
            for (const auto& v : step) square += v.get<double>() * v.get<double>();
            if (square > largest) largest = square, most = name;
        }
        text += fmt::format(
            "  {} at ({:.3f}, {:.3f}), position {}: {:.1f} times the picture's rms, mostly {}",
            w["camera"].get<std::string>(), w["place"][0].get<double>(), w["place"][1].get<double>(),
            w["position"].get<int>(), w["error_over_rms"].get<double>(), most);
        if (w.contains("object"))
            text += fmt::format("; '{}' ({}), {:.2f} m from the lamp", w["object"].get<std::string>(),
                                w["material"].get<std::string>(), w["lamp_distance"].get<double>());
        text += "\n";
    }
    return text;
}

}  // namespace pim
