// SPDX-License-Identifier: GPL-3.0-or-later
#include "bake/held_out.h"

#include <algorithm>
#include <cmath>

#include "common/core/sampling.h"
#include "common/map/irradiance.h"
#include "common/render/specular_walk.h"

namespace pim {
namespace {

constexpr uint64_t kSeed = 0x48e1d;
constexpr double kMostScatter = 1;  // of squared errors among views, in their squared mean; more is doubtful

// All lamps at once; each position's lamps are shifted by numbers of their own, so that lamps do not move in
// step.
std::vector<std::vector<LightState>> spread_lamps(const Scene& scene, const Solids& solids, int count) {
    std::vector<std::vector<LightState>> lamps(static_cast<std::size_t>(count));
    for (std::size_t l = 0; l < scene.lights.size(); ++l) {
        const Light& light = scene.lights[l];
        RandomStream random(kSeed, RandomPurpose::evaluation, uint32_t(l), 0);
        const Vec3 shift(random.next(), random.next(), random.next());
        uint64_t k = 0;
        for (auto& states : lamps) {
            Vec3 position = light.position;
            for (int attempt = 0; attempt < 64; ++attempt, ++k) {
                for (int axis = 0; axis < 3; ++axis) {
                    const double t = golden_sequence(k, axis, 3) + double(shift[axis]);
                    const float low = light.domain.min[axis], size = light.domain.max[axis] - low;
                    position[axis] = low + size * float(t - std::floor(t));
                }
                if (solids.containing(position).empty()) break;
            }
            ++k;
            states.push_back({position, light.power});
        }
    }
    return lamps;
}

// Diffuse surfaces that a ray sees, with the radiance that irradiance 1 there would send along it.
struct SurfacesSeen {
    std::vector<std::pair<SurfacePoint, Rgb>>& found;

    bool segment(const Ray&, float, const Rgb&) { return false; }
    void diffuse(const SurfacePoint& surface, const Rgb& throughput) {
        found.emplace_back(surface, throughput * surface.diffuse / kPi);
    }
};

}  // namespace

HeldOut::HeldOut(const Scene& scene, const RayCaster& caster, const Solids& solids, const Size& size)
    : reference_(scene, caster, spread_lamps(scene, solids, size.positions),
                 {.lights = size.positions, .pixels = size.pixels, .paths = size.paths, .geometry = {}},
                 kSeed) {}

void HeldOut::set_cells(const Scene& scene, const RayCaster& caster, const Cells& cells) {
    const IlluminationMap map = map_without_lights(cells);
    views_.assign(std::size_t(reference_.positions()) * std::size_t(reference_.cameras()), {});
    for (int i = 0; i < reference_.positions(); ++i) {
        Moment moment{.scene = scene, .caster = caster, .map = map, .lights = lamps(i), .patch_values = {}};
        const auto& baked = scene.bake.components;
        const bool has_direct = std::ranges::find(baked, Component::direct) != baked.end();
        moment.direct = has_direct ? DirectLight::none : DirectLight::traced;
        moment.indirect = false;
        moment.shadow_samples = kEvaluationShadowSamples;
        moment.patch_values.assign(map.patches.size(), Rgb(0));
        for (int c = 0; c < reference_.cameras(); ++c)
            look_up_view(moment, i, c, views_[std::size_t(i * reference_.cameras() + c)]);
    }
    number_patches(cells);
}

void HeldOut::look_up_view(const Moment& moment, int position, int camera, View& view) const {
    const std::size_t count = reference_.pixels(position, camera).size();
    std::vector<std::vector<Share>> shares(count);
    view.pixels.resize(count);
    reference_.for_each_ray(position, camera, [&](std::size_t p, const Ray& ray, RandomStream& random) {
        view.pixels[p].direct = map_radiance(moment, ray, random);
        std::vector<std::pair<SurfacePoint, Rgb>> surfaces;
        SurfacesSeen visitor{surfaces};
        SpecularWalk<SurfacesSeen>(moment.scene, moment.caster, visitor).follow(ray, Rgb(1));
        std::vector<PatchShare> found;
        for (const auto& [surface, weight] : surfaces) {
            look_up(moment.map, surface.position, surface.shading_normal, found);
            for (const PatchShare& share : found)
                if (share.weight > 0) shares[p].push_back({share.patch, weight * share.weight});
        }
    });
    for (std::size_t p = 0; p < count; ++p) {
        view.pixels[p].first = uint32_t(view.shares.size());
        view.shares.insert(view.shares.end(), shares[p].begin(), shares[p].end());
        view.pixels[p].last = uint32_t(view.shares.size());
    }
}

void HeldOut::number_patches(const Cells& cells) {
    std::vector<bool> used(cells.patches.size(), false);
    for (const View& view : views_)
        for (const Share& share : view.shares) {
            const Patch& patch = cells.patches[share.patch];
            for (int n = 0; n < 27; ++n) {
                const Index3 step(n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1);
                if (const int near = cells.index.find(patch.cell + step, patch.slot); near >= 0)
                    used[std::size_t(near)] = true;
            }
        }
    patches_.clear();
    std::vector<uint32_t> number(used.size(), 0);
    for (uint32_t p = 0; p < used.size(); ++p)
        if (used[p]) {
            number[p] = uint32_t(patches_.size());
            patches_.push_back(p);
        }
    for (View& view : views_)
        for (Share& share : view.shares) share.patch = number[share.patch];
}

const std::vector<ReferencePixel>& HeldOut::reference(std::size_t view) const {
    const auto cameras = std::size_t(reference_.cameras());
    return reference_.pixels(int(view / cameras), int(view % cameras));
}

double HeldOut::norm(std::size_t view) const {
    double sum = 0;
    for (const ReferencePixel& p : reference(view))
        if (p.surface) sum += double(p.all[0].dot(p.all[1]));
    return sum;
}

bool HeldOut::sees_light(int camera) const {
    for (int i = 0; i < positions(); ++i)
        if (norm(std::size_t(i * reference_.cameras() + camera)) > 0) return true;
    return false;
}

std::vector<Rgb> HeldOut::seen(std::size_t view, const Values& values) const {
    std::vector<Rgb> colours;
    for (const Pixel& pixel : views_[view].pixels) {
        Rgb sum = pixel.direct;
        for (uint32_t s = pixel.first; s < pixel.last; ++s)
            sum += views_[view].shares[s].weight * values[views_[view].shares[s].patch];
        colours.push_back(sum);
    }
    return colours;
}

std::vector<double> HeldOut::squares(const std::vector<Values>& a, const std::vector<Values>& b) const {
    std::vector<double> all;
    for (std::size_t v = 0; v < views_.size(); ++v) {
        const auto& pixels = reference(v);
        const auto seen_a = seen(v, a[position_of(v)]), seen_b = seen(v, b[position_of(v)]);
        double square = 0;
        for (std::size_t p = 0; p < pixels.size(); ++p)
            if (pixels[p].surface)
                square += 0.5 * double((seen_a[p] - pixels[p].all[0]).dot(seen_b[p] - pixels[p].all[1]) +
                                       (seen_b[p] - pixels[p].all[0]).dot(seen_a[p] - pixels[p].all[1]));
        const double whole = norm(v);
        all.push_back(whole > 0 ? square / whole : 0);
    }
    return all;
}

double HeldOut::square(const std::vector<Values>& a, const std::vector<Values>& b) const {
    return mean(squares(a, b));
}

Doubtful HeldOut::doubtful_square(const std::vector<Values>& a, const std::vector<Values>& b) const {
    const auto all = squares(a, b);
    return {mean(all), standard_error(all)};
}

std::vector<double> HeldOut::differences(const std::vector<Values>& a, const std::vector<Values>& b) const {
    std::vector<double> all;
    for (std::size_t v = 0; v < views_.size(); ++v) {
        const auto seen_a = seen(v, a[position_of(v)]), seen_b = seen(v, b[position_of(v)]);
        double square = 0;
        for (std::size_t p = 0; p < seen_a.size(); ++p) square += double((seen_a[p] - seen_b[p]).length2());
        const double whole = norm(v);
        all.push_back(whole > 0 ? square / whole : 0);
    }
    return all;
}

double HeldOut::difference(const std::vector<Values>& a, const std::vector<Values>& b) const {
    return mean(differences(a, b));
}

double HeldOut::usual_difference(const std::vector<Values>& a, const std::vector<Values>& b) const {
    auto all = differences(a, b);
    std::erase(all, 0.0);  // of dark views
    if (all.empty()) return 0;
    const auto middle = all.begin() + std::ptrdiff_t(all.size() / 2);
    std::ranges::nth_element(all, middle);
    return *middle;
}

HeldOut::ViewError HeldOut::view_error(std::size_t view, const Values& values) const {
    const auto& pixels = reference(view);
    const auto colours = seen(view, values);
    double errors = 0, norms = 0, count = 0;
    const auto for_each = [&](auto visit) {
        for (std::size_t p = 0; p < pixels.size(); ++p)
            if (const auto& r = pixels[p].all; pixels[p].surface)
                visit(double((colours[p] - r[0]).dot(colours[p] - r[1])), double(r[0].dot(r[1])));
    };
    for_each([&](double error, double norm) { errors += error, norms += norm, ++count; });
    if (!(norms > 0) || count < 2) return {};
    const double ratio = errors / norms;
    double scatter = 0;
    for_each([&](double error, double norm) { scatter += std::pow(error - ratio * norm, 2); });
    return {ratio, scatter * count / (count - 1) / (norms * norms)};
}

HeldOut::Error HeldOut::error(const std::vector<Values>& values) const {
    const auto cameras = std::size_t(reference_.cameras());
    const auto n = double(positions());
    Error error;
    for (std::size_t c = 0; c < cameras; ++c) {
        double mean = 0, within = 0, squares = 0;
        for (std::size_t v = c; v < views_.size(); v += cameras) {
            const ViewError one = view_error(v, values[position_of(v)]);
            mean += one.square / n, within += one.variance / n, squares += one.square * one.square / n;
        }
        const double scatter = n > 1 ? std::max(0.0, squares - mean * mean) * n / (n - 1) : 0;
        const double doubt = std::sqrt(scatter / n);  // of the mean
        const LikelyError likely = likely_error({mean, doubt});
        if (likely.square > 0) {
            const double between =
                std::clamp((scatter - within) / (likely.square * likely.square), 0.0, kMostScatter);
            error.relrmse += likely.mean * std::pow(1 + between, -0.125) / double(cameras);
        }
        if (const double root = std::sqrt(std::max(likely.square, doubt)); root > 0)
            error.standard_error += doubt / (2 * root) / double(cameras);
    }
    return error;
}

}  // namespace pim
