// SPDX-License-Identifier: GPL-3.0-or-later
#include "viewer/relight/relighter.h"

#include <atomic>
#include <cmath>
#include <numeric>
#include <utility>

#include "common/core/error.h"
#include "common/core/parallel.h"
#include "common/core/stopwatch.h"
#include "common/map/irradiance.h"
#include "common/render/direct_light.h"

namespace pim {
namespace {

constexpr int kShadowRows = 2;  // rectangular lamps take so many squared shadow rays per point and pass
constexpr std::size_t kBlocksAtOnce = 16;

bool same_view(const Camera& a, const Camera& b) {
    return a.eye == b.eye && a.target == b.target && a.up == b.up && a.vertical_fov == b.vertical_fov;
}

// A well-spread sequence in [0,1)⁴ (Roberts 2018: powers of the root of x⁵ = x + 1), the middle first: two
// coordinates for the place in the pixel, two for that on a lamp, so that all pairs of places occur.
Vec2 spread(int pass, double step_x, double step_y) {
    const double x = 0.5 + pass * step_x, y = 0.5 + pass * step_y;
    return {float(x - std::floor(x)), float(y - std::floor(y))};
}
Vec2 offset_of_pass(int pass) { return spread(pass, 0.8566748838545029, 0.7338918566271260); }
Vec2 lamp_place_of_pass(int pass) { return spread(pass, 0.6287067210378087, 0.5385972572236101); }

// Hash of a pixel, uniform in [0,1)²: neighbouring pixels look at other places of a lamp.
Vec2 pixel_noise(uint32_t x, uint32_t y) {
    uint32_t h = x * 0x8da6b343u ^ y * 0xd8163841u;
    h ^= h >> 15, h *= 0x2c1b3c6du, h ^= h >> 12, h *= 0x297a2d39u, h ^= h >> 15;
    return {float(h & 0xffff) / 65536.0f, float(h >> 16) / 65536.0f};
}

// [channel][lane]. A fit's own values are not negative; what is left are roundings, and maps made otherwise.
std::size_t cut_negative(float* block) {
    std::size_t cut = 0;
    for (int i = 0; i < 3 * kLanes; ++i) {
        cut += block[i] < 0;
        block[i] = std::max(block[i], 0.0f);
    }
    return cut;
}

float fraction(float x) { return x - std::floor(x); }

}  // namespace

Relighter::Relighter(const MapFile& map, const Scene& scene, const RayCaster& caster, VectorUnit unit)
    : map_(map),
      scene_(scene),
      caster_(caster),
      kernels_(pim::kernels(unit)),
      builder_(scene, caster, map.outline(), kernels_) {
    store_ = std::make_unique<CoefficientStore>(map_, components_);
}

void Relighter::choose_components() {
    std::vector<Component> wanted;
    if (indirect_part(*state_)) wanted.push_back(Component::indirect);
    if (direct_part(*state_) == DirectLight::baked) wanted.push_back(Component::direct);
    for (const Component c : wanted)
        if (!map_.outline().has(c)) throw UsageError(std::string("the map lacks the ") + name(c) + " part");
    if (wanted == components_) return;
    components_ = wanted;
    store_ = std::make_unique<CoefficientStore>(map_, components_);
}

void Relighter::update(const ViewState& state, const Imath::V2i& size) {
    const bool camera_moved = !state_ || size != size_ || !same_view(state.camera, state_->camera);
    const std::vector<LightState> before = lights_;
    state_ = state;
    size_ = size;
    lights_ = shining(scene_, state);
    plan_view(camera_moved);
    traced_.resize(lights_.size());
    for (std::size_t l = 0; l < lights_.size(); ++l)
        if (before.empty() || before[l].position != lights_[l].position) traced_[l] = false;
    choose_components();
    boxes_ = store_->active(lights_);
    const Stopwatch watch;
    statistics_.active_boxes = boxes_.size();
    evaluated_all_ = false;
    blocks_.resize(map_.outline().patches.size(), state.view == View::trust);
    if (view_is_due_)  // what a new view needs is not known yet
        evaluate_all();
    else
        evaluate(blocks_.needed);
    statistics_.evaluate_seconds = watch.seconds();
}

void Relighter::evaluate(const std::vector<uint32_t>& blocks) {
    std::atomic<std::size_t> cut = 0;
    parallel_for((blocks.size() + kBlocksAtOnce - 1) / kBlocksAtOnce, [&](std::size_t chunk) {
        const std::size_t end = std::min(blocks.size(), (chunk + 1) * kBlocksAtOnce);
        std::size_t own = 0;
        for (std::size_t i = chunk * kBlocksAtOnce; i < end; ++i) own += evaluate_block(blocks[i]);
        cut += own;
    });
    statistics_.cut_values = cut;
}

void Relighter::evaluate_all() {
    if (std::exchange(evaluated_all_, true)) return;
    std::vector<uint32_t> blocks(blocks_.count);
    std::iota(blocks.begin(), blocks.end(), 0u);
    evaluate(blocks);
}

void Relighter::Blocks::resize(std::size_t patches, bool with_residual) {
    count = (patches + kLanes - 1) / kLanes;
    irradiance.resize(count * 3 * kLanes);
    residual.resize(with_residual ? count * 3 * kLanes : 0);
}

void Relighter::plan_view(bool camera_moved) {
    ViewOptions wanted;
    wanted.radiance = shows_radiance(state_->view);
    wanted.surfaces = direct_part(*state_) == DirectLight::traced;
    wanted.segments = state_->show_lamps && wanted.radiance &&
                      std::ranges::any_of(scene_.lights, [](const Light& l) { return l.rectangle(); });
    if (!camera_moved && wanted == options_) return;
    options_ = wanted;
    view_is_due_ = true;
    traced_.assign(scene_.lights.size(), false);
    auto fresh = make_tiles(size_);
    if (fresh.size() != tiles_.size()) tiles_ = std::move(fresh);
    for (std::size_t t = 0; t < fresh.size(); ++t) {  // keeps their memory
        tiles_[t].x = fresh[t].x, tiles_[t].y = fresh[t].y;
        tiles_[t].width = fresh[t].width, tiles_[t].height = fresh[t].height;
    }
    terms_.resize(tiles_.size());
}

// Brings each tile up to date and hands it on while it is in the processor's cache.
template <class Sink>
void Relighter::for_each_tile(Sink sink) {
    const CameraRays rays(state_->camera, size_);
    std::vector<uint8_t> due(lights_.size());
    for (std::size_t l = 0; l < lights_.size(); ++l)
        due[l] = !traced_[l] && !is_black(lights_[l].power) && direct_part(*state_) == DirectLight::traced;
    for (std::size_t l = 0; l < lights_.size(); ++l) traced_[l] = traced_[l] || due[l];
    std::atomic<int64_t> view{0}, shadow{0}, shade{0};  // ns, all threads
    const auto timed = [](std::atomic<int64_t>& sum, const auto& work) {
        const Stopwatch watch;
        work();
        sum += int64_t(1e9 * watch.seconds());
    };
    parallel_for(tiles_.size(), [&](std::size_t t) {
        if (view_is_due_) timed(view, [&] { builder_.build(rays, offset_of_pass(0), options_, tiles_[t]); });
        timed(shadow, [&] {
            terms_[t].resize(lights_.size());
            for (std::size_t l = 0; l < due.size(); ++l)
                if (due[l]) trace_lamp(tiles_[t], l, 0, terms_[t][l]);
        });
        timed(shade, [&] { sink(tiles_[t], terms_of(t)); });
    });
    const auto seconds = [](const std::atomic<int64_t>& sum) { return 1e-9 * double(sum) / thread_count(); };
    statistics_.view_seconds = seconds(view);
    statistics_.shadow_seconds = seconds(shadow);
    statistics_.shade_seconds = seconds(shade);
    if (std::exchange(view_is_due_, false)) count_points();
}

// Which patches the picture needs.
void Relighter::count_points() {
    std::vector<uint8_t> needed(blocks_.count);
    std::size_t points = 0, reads = 0, bytes = 0;
    for (const ViewTile& tile : tiles_) {
        for (const uint32_t p : tile.patches) needed[p / kLanes] = true;
        for (const PointGroup& g : tile.groups) {
            points += std::size_t(g.blocks) * kLanes;
            reads += std::size_t(g.blocks) * kLanes * g.patches;
        }
        bytes += tile.bytes();
    }
    blocks_.needed.clear();
    for (uint32_t b = 0; b < blocks_.count; ++b)
        if (needed[b]) blocks_.needed.push_back(b);
    statistics_.points = points;
    statistics_.patches_per_point = points > 0 ? double(reads) / double(points) : 0;
    statistics_.evaluated_patches = blocks_.needed.size() * kLanes;
    statistics_.cache_bytes = bytes;
}

std::size_t Relighter::evaluate_block(std::size_t block) {
    float* sum = &blocks_.irradiance[block * 3 * kLanes];
    std::size_t cut = 0;
    std::fill_n(sum, 3 * kLanes, 0.0f);
    for (const ActiveBox& active : boxes_) {
        const PackedBox& box = *active.box;
        kernels_.evaluate(&box.coefficients[block * box.block_length()], int(box.terms.size()), box.channels,
                          active.monomials.data(), &active.power.x, sum);
    }
    if (map_.outline().mend_signs) cut = cut_negative(sum);
    if (state_->view != View::trust) return cut;
    float* residual = &blocks_.residual[block * 3 * kLanes];
    std::fill_n(residual, 3 * kLanes, 0.0f);
    for (const ActiveBox& active : boxes_)
        for (int lane = 0; lane < kLanes; ++lane) {
            const std::size_t patch = block * kLanes + std::size_t(lane);
            if (patch < active.box->residuals.size())
                for (int c = 0; c < 3; ++c)
                    residual[c * kLanes + lane] += active.box->residuals[patch] * active.power[c];
        }
    return cut;
}

// terms[block][lane]: irradiance at each point of the tile for 1 W.
void Relighter::trace_lamp(const ViewTile& tile, std::size_t lamp, int pass,
                           AlignedVector<float>& terms) const {
    const RectangleShape* shape = scene_.lights[lamp].rectangle();
    const int rows = shape ? kShadowRows : 1;
    const float scale = shape ? 1 / (kPi * float(rows * rows)) : 1 / (4 * kPi);
    const Vec3& centre = lights_[lamp].position;
    const Vec2 turn = lamp_place_of_pass(pass);
    terms.assign(tile.block_count() * kLanes, 0);
    alignas(64) float targets[3 * kLanes], term[kLanes];
    RayPacket packet;
    const ShadowRays rays{{packet.origin[0], packet.origin[1], packet.origin[2]},
                          {packet.direction[0], packet.direction[1], packet.direction[2]},
                          term};
    for (std::size_t block = 0; block < tile.block_count(); ++block)
        for (int sample = 0; sample < rows * rows; ++sample) {
            for (int lane = 0; lane < kLanes; ++lane) {
                Vec3 target = centre;
                if (shape) {
                    const uint16_t pixel = tile.pixels[block * kLanes + std::size_t(lane)];
                    const Vec2 noise = pixel_noise(uint32_t(tile.x + pixel % kTileSize),
                                                   uint32_t(tile.y + pixel / kTileSize));
                    const float u = (float(sample % rows) + fraction(noise.x + turn.x)) / float(rows),
                                v = (float(sample / rows) + fraction(noise.y + turn.y)) / float(rows);
                    target += shape->axes[0] * ((u - 0.5f) * shape->size.x) +
                              shape->axes[1] * ((v - 0.5f) * shape->size.y);
                }
                for (int axis = 0; axis < 3; ++axis) targets[axis * kLanes + lane] = target[axis];
            }
            kernels_.aim(&tile.surfaces[block * kSurfaceRows * kLanes], targets,
                         shape ? &shape->normal.x : nullptr, caster_.surface_offset(), rays);
            bool any = false;
            for (int lane = 0; lane < kLanes; ++lane) {
                const bool active =
                    term[lane] > 0 && tile.pixels[block * kLanes + std::size_t(lane)] != kNoPixel;
                packet.length[lane] = active ? 1.0f : -1.0f;
                if (!active) term[lane] = 0;
                any = any || active;
            }
            if (!any) continue;
            caster_.occluded(packet);
            for (int lane = 0; lane < kLanes; ++lane)
                if (packet.length[lane] >= 0) terms[block * kLanes + std::size_t(lane)] += term[lane] * scale;
        }
}

// Calls sink(colours [channel][lane], pixels [lane]) for each block of the tile's points.
template <class Sink>
void Relighter::shade(const ViewTile& tile, const LampTerms& terms, Sink sink) const {
    alignas(64) float sum[3 * kLanes], residual[3 * kLanes];
    float values[3 * kMostEntries], residuals[3 * kMostEntries];
    const bool trust = state_->view == View::trust;
    const auto fetch = [&](const AlignedVector<float>& from, const PointGroup& group, float* to) {
        for (uint32_t e = 0; e < group.patches; ++e) {
            const uint32_t patch = tile.patches[group.first_patch + e];
            const float* at = &from[std::size_t(patch / kLanes) * 3 * kLanes + patch % kLanes];
            for (int c = 0; c < 3; ++c) to[3 * e + c] = at[c * kLanes];
        }
    };
    for (const PointGroup& group : tile.groups) {
        fetch(blocks_.irradiance, group, values);
        if (trust) fetch(blocks_.residual, group, residuals);
        for (uint32_t b = 0; b < group.blocks; ++b) {
            const std::size_t block = group.first_block + b;
            const Weight* weights =
                tile.weights.data() + group.first_weight + std::size_t(b) * group.patches * kLanes;
            kernels_.gather(weights, values, int(group.patches), sum);
            for (std::size_t l = 0; l < terms.size(); ++l) {
                if (!traced_[l] || is_black(lights_[l].power)) continue;
                const float* term = &terms[l][block * kLanes];
                for (int c = 0; c < 3; ++c)
                    for (int lane = 0; lane < kLanes; ++lane)
                        sum[c * kLanes + lane] += term[lane] * lights_[l].power[c];
            }
            if (trust) {
                kernels_.gather(weights, residuals, int(group.patches), residual);
                for (int i = 0; i < 3 * kLanes; ++i) sum[i] = sum[i] > 0 ? residual[i] / sum[i] : 0;
            }
            if (group.first_factor == PointGroup::kOneFactor) {
                for (int i = 0; i < 3 * kLanes; ++i) sum[i] *= group.factor[i / kLanes];
            } else {
                const float* factor = &tile.factors[group.first_factor + std::size_t(b) * 3 * kLanes];
                for (int i = 0; i < 3 * kLanes; ++i) sum[i] *= factor[i];
            }
            sink(sum, &tile.pixels[block * kLanes]);
        }
    }
}

void Relighter::add_tile(const ViewTile& tile, const LampTerms& terms, const Corner<Rgb>& corner) const {
    shade(tile, terms, [&](const float* colours, const uint16_t* pixels) {
        for (int lane = 0; lane < kLanes; ++lane)
            if (pixels[lane] != kNoPixel)
                corner.at(pixels[lane]) +=
                    Rgb(colours[lane], colours[kLanes + lane], colours[2 * kLanes + lane]);
    });
    add_lamps(tile, corner);
}

// A lamp seen straight hides what is behind it, mirrors too; seen in a mirror it is added to that, which it
// outshines.
void Relighter::add_lamps(const ViewTile& tile, const Corner<Rgb>& corner) const {
    uint16_t hidden = kNoPixel;  // a pixel's segments follow its primary one
    for (const Segment& s : tile.segments) {
        if (s.pixel == hidden) continue;
        float nearest = s.until;
        std::optional<Rgb> radiance;
        for (std::size_t l = 0; l < lights_.size(); ++l) {
            const RectangleShape* shape = scene_.lights[l].rectangle();
            if (!shape) continue;
            const auto distance = intersect(*shape, lights_[l].position, s.ray.origin, s.ray.direction);
            if (!distance || *distance >= nearest) continue;
            nearest = *distance;
            radiance = emitted_radiance(*shape, lights_[l].power);
        }
        if (!radiance) continue;
        Rgb& pixel = corner.at(s.pixel);
        pixel = s.primary ? *radiance : pixel + *radiance * s.throughput;
        if (s.primary) hidden = s.pixel;
    }
}

void Relighter::encode(float exposure, ToneCurve curve, uint32_t* rgba) {
    for_each_tile([&](const ViewTile& tile, const LampTerms& terms) {
        const Corner<uint32_t> corner{rgba + std::size_t(tile.y) * size_.x + tile.x, size_.x};
        if (tile.one_point_per_pixel)
            encode_points(tile, terms, exposure, curve, corner);
        else
            encode_sums(tile, terms, exposure, curve, corner);
    });
}

// Each point is a pixel: no sum in between.
void Relighter::encode_points(const ViewTile& tile, const LampTerms& terms, float exposure, ToneCurve curve,
                              const Corner<uint32_t>& corner) const {
    alignas(64) uint32_t encoded[kLanes];
    for (int y = 0; y < tile.height; ++y) std::fill_n(&corner.at(y * kTileSize), tile.width, 0xff000000u);
    shade(tile, terms, [&](const float* colours, const uint16_t* pixels) {
        kernels_.encode(colours, exposure, int(curve), encoded);
        for (int lane = 0; lane < kLanes; ++lane)
            if (pixels[lane] != kNoPixel) corner.at(pixels[lane]) = encoded[lane];
    });
}

void Relighter::encode_sums(const ViewTile& tile, const LampTerms& terms, float exposure, ToneCurve curve,
                            const Corner<uint32_t>& corner) const {
    std::vector<Rgb> sums(kTileSize * kTileSize, Rgb(0));
    add_tile(tile, terms, {sums.data(), kTileSize});
    alignas(64) float colours[3 * kLanes];
    alignas(64) uint32_t encoded[kLanes];
    for (int first = 0; first < tile.height * kTileSize; first += kLanes) {
        for (int lane = 0; lane < kLanes; ++lane)
            for (int c = 0; c < 3; ++c) colours[c * kLanes + lane] = sums[std::size_t(first + lane)][c];
        kernels_.encode(colours, exposure, int(curve), encoded);
        for (int lane = 0; lane < kLanes && first % kTileSize + lane < tile.width; ++lane)
            corner.at(first + lane) = encoded[lane];
    }
}

const Relighter::LampTerms& Relighter::terms_of(std::size_t tile) const {
    static const LampTerms none;
    return direct_part(*state_) == DirectLight::traced ? terms_[tile] : none;
}

Image Relighter::linear() {
    Image image(size_.x, size_.y);
    for_each_tile([&](const ViewTile& tile, const LampTerms& terms) {
        add_tile(tile, terms, {&image.at(tile.x, tile.y), size_.x});
    });
    return image;
}

void Relighter::add_pass(int pass, std::size_t first_tile, std::size_t end_tile, Image& sum) {
    const CameraRays rays(state_->camera, size_);
    // Other places in the pixels may look up other patches.
    evaluate_all();
    parallel_for(end_tile - first_tile, [&](std::size_t i) {
        const std::size_t t = first_tile + i;
        thread_local ViewTile tile;
        thread_local std::vector<Rgb> own;
        tile.x = tiles_[t].x, tile.y = tiles_[t].y, tile.width = tiles_[t].width,
        tile.height = tiles_[t].height;
        builder_.build(rays, offset_of_pass(pass), options_, tile);
        LampTerms terms(terms_of(t).size());
        for (std::size_t l = 0; l < terms.size(); ++l)
            if (traced_[l] && !is_black(lights_[l].power)) trace_lamp(tile, l, pass, terms[l]);
        own.assign(kTileSize * kTileSize, Rgb(0));
        add_tile(tile, terms, {own.data(), kTileSize});
        for (int y = 0; y < tile.height; ++y)
            for (int x = 0; x < tile.width; ++x)
                sum.at(tile.x + x, tile.y + y) += own[std::size_t(y) * kTileSize + x];
    });
}

void Relighter::encode(const Image& linear, float exposure, ToneCurve curve, uint32_t* rgba) const {
    const auto width = std::size_t(linear.width);
    parallel_for(std::size_t(linear.height), [&](std::size_t y) {
        alignas(64) float colours[3 * kLanes];
        alignas(64) uint32_t encoded[kLanes];
        for (std::size_t x = 0; x < width; x += kLanes) {
            const std::size_t count = std::min<std::size_t>(kLanes, width - x);
            for (std::size_t lane = 0; lane < kLanes; ++lane)
                for (std::size_t c = 0; c < 3; ++c)
                    colours[c * kLanes + lane] =
                        lane < count ? linear.pixels[y * width + x + lane][int(c)] : 0;
            kernels_.encode(colours, exposure, int(curve), encoded);
            std::copy_n(encoded, count, rgba + y * width + x);
        }
    });
}

Rgb Relighter::irradiance(const SurfacePoint& surface) {
    std::vector<PatchShare> shares;
    look_up(map_.outline(), surface.position, surface.shading_normal, shares);
    Rgb sum(0);
    for (const PatchShare& share : shares) {
        evaluate_block(share.patch / kLanes);  // it may lie outside the picture
        const float* at =
            &blocks_.irradiance[std::size_t(share.patch / kLanes) * 3 * kLanes + share.patch % kLanes];
        sum += Rgb(at[0], at[kLanes], at[2 * kLanes]) * share.weight;
    }
    if (direct_part(*state_) != DirectLight::traced) return sum;
    RandomStream random(1, RandomPurpose::render, 0, 0);
    for (std::size_t l = 0; l < lights_.size(); ++l)
        sum +=
            direct_irradiance(caster_, scene_.lights[l], lights_[l], surface, Moment::kShadowSamples, random);
    return sum;
}

}  // namespace pim
