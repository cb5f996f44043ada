// SPDX-License-Identifier: GPL-3.0-or-later
// The relighter against render_picture(), which goes ray by ray, on maps of made-up light.
#include "viewer/relight/relighter.h"

#include <set>

#include "bake/bake.h"
#include "common/core/error.h"
#include "common/core/file.h"
#include "common/core/parallel.h"
#include "common/map/irradiance.h"
#include "measured.h"
#include "statistics.h"
#include "synthetic_maps.h"
#include "test_scenes.h"
#include "viewer/files/names.h"
#include "viewer/picture.h"

namespace pim {
namespace {

const Imath::V2i kSize(80, 60);

// Rays in packets start with directions that are not unit and meet surfaces a few roundings beside those of
// single rays, and sums are taken in another order. That changes a pixel by some 1e-6 of itself, but
// - where an edge of a triangle or of a shadow passes within roundings of the pixel's middle, the pixel is
// another
//   one altogether. A picture has some ten edges of a hundred pixels, and roundings are below a thousandth of
//   a pixel: about one pixel of 80 · 60;
// - where two layers of a cell are as far from the surface within a thousandth of a cell, their shares turn
// over
//   with the distances, by up to a thousand times the roundings;
// - where the thesis' irradiance, which may be negative, vanishes, `trust` is a number on one side and 0 on
// the
//   other.
// Weights are kept in steps of 1/65535, and every sum of them from the first on is right to half a step. So,
// summed by parts, a pixel changes by at most half a step times the differences of one patch and the next: of
// up to 48 patches, 47 / 131070 = 3.6e-4 of the brightest; as rms of roundings that are spread evenly, over
// √48 patches, 0.29 / 65535 · √48 = 3.1e-5 of them, and these pictures' brightest is some three times their
// rms.
constexpr double kApart = 4e-4;       // of the brightest pixel: beyond it pixels count as others
constexpr double kShareApart = 2e-3;  // of the pixels
constexpr double kRest = 1e-4;        // relative rms of the others

struct Difference {
    double rms = 0;    // of pixels that are not apart, over the picture's rms
    double share = 0;  // of pixels apart
};
Difference difference(const Image& found, const Image& expected) {
    double brightest = 0, squares = 0, own = 0, apart = 0;
    for (const Rgb& p : expected.pixels)
        for (int c = 0; c < 3; ++c) brightest = std::max(brightest, std::abs(double(p[c])));
    for (std::size_t i = 0; i < expected.pixels.size(); ++i) {
        const Vec3d d = Vec3d(found.pixels[i]) - Vec3d(expected.pixels[i]);
        own += Vec3d(expected.pixels[i]).length2();
        if (std::max({std::abs(d.x), std::abs(d.y), std::abs(d.z)}) > kApart * brightest)
            ++apart;
        else
            squares += d.length2();
    }
    return {own > 0 ? std::sqrt(squares / own) : squares, apart / double(expected.pixels.size())};
}

ViewState state_of(const MappedScene& m, View view, DirectLight direct, bool indirect) {
    ViewState state = initial_state(m.scene(), m.baked.map);
    state.view = view, state.direct = direct, state.indirect = indirect;
    Dice dice(11);
    for (std::size_t l = 0; l < state.lamps.size(); ++l) {
        state.lamps[l].position = dice.inside(m.scene().lights[l].domain);
        state.lamps[l].gain = dice.between(0.5f, 2);
        state.lamps[l].colour = dice.inside({Vec3(0.5f), Vec3(1)});
    }
    return state;
}

Relighter relighter_of(const MappedScene& m, VectorUnit unit = best_vector_unit()) {
    return {m.map, m.scene(), m.caster, unit};
}

Image exact(const MappedScene& m, const ViewState& state, const Imath::V2i& size = kSize, int samples = 1) {
    PictureOptions options;
    options.state = state, options.size = size, options.samples = samples;
    return render_picture(m.baked, m.caster, options).image;
}

Image fast(Relighter& relighter, const ViewState& state, const Imath::V2i& size = kSize) {
    relighter.update(state, size);
    Image image = relighter.linear();
    if (state.view == View::density)  // the exact one is grey
        for (Rgb& pixel : image.pixels) pixel = Rgb(luminance(pixel));
    return image;
}

// Of a map that is soon read.
SyntheticOptions few_grids() {
    SyntheticOptions options;
    options.facings = false;
    return options;
}

class RelighterTest : public testing::Test {
  protected:
    void expect_same(const MappedScene& m, Relighter& relighter, const ViewState& state) {
        Image expected = exact(m, state), found = fast(relighter, state);
        if (state.view ==
            View::trust) {  // a ratio is as good as its denominator, and none where that vanishes
            ViewState denominator = state;
            denominator.view = View::irradiance, denominator.direct = direct_part(state);
            const Image e = exact(m, denominator), f = fast(relighter, denominator);
            float brightest = 0;
            for (const Rgb& p : e.pixels) brightest = std::max({brightest, p.x, p.y, p.z});
            for (std::size_t i = 0; i < e.pixels.size(); ++i)
                for (int c = 0; c < 3; ++c) {
                    const bool counts = e.pixels[i][c] > float(kApart) * brightest;
                    expected.pixels[i][c] *= counts ? e.pixels[i][c] : 0;
                    found.pixels[i][c] *= counts ? f.pixels[i][c] : 0;
                }
        }
        const Difference d = difference(found, expected);
        EXPECT_LT(d.rms, kRest) << what(state);
        EXPECT_LE(d.share, kShareApart) << what(state);
        rms_.add(d.rms);
        share_.add(d.share);
        const bool dark = std::ranges::all_of(expected.pixels, [](const Rgb& p) { return p == Rgb(0); });
        const bool nothing = direct_part(state) == DirectLight::none && !indirect_part(state);
        EXPECT_EQ(dark, nothing) << what(state);
    }
    void expect_all_views(const MappedScene& m, const std::vector<DirectLight>& directs) {
        Relighter relighter = relighter_of(m);
        std::set<std::tuple<View, DirectLight, bool>> done;
        for (const DirectLight direct : directs)
            for (const bool indirect : {true, false})
                for (const View view : {View::radiance, View::irradiance, View::direct, View::indirect,
                                        View::density, View::trust}) {
                    const ViewState state = state_of(m, view, direct, indirect);
                    if (done.emplace(view, direct_part(state), indirect_part(state)).second)
                        expect_same(m, relighter, state);
                }
    }
    static std::string what(const ViewState& state) {
        return name(state.view) + ", direct " + name(state.direct) + (state.indirect ? ", indirect" : "");
    }
    Largest rms_{"relative_rms"}, share_{"share_of_pixels_apart"};
};

constexpr DirectLight kNone = DirectLight::none, kTraced = DirectLight::traced, kBaked = DirectLight::baked;

TEST_F(RelighterTest, IsTheExactPictureOfPlainSurfaces) {
    expect_all_views(MappedScene(scene_of_data("cornell")), {kBaked, kTraced, kNone});
}

// Mirror, glass, a ball with smooth normals. Soft shadows are sampled otherwise: not here.
TEST_F(RelighterTest, IsTheExactPictureBehindMirrorAndGlass) {
    expect_all_views(MappedScene(scene_of_data("caustic")), {kBaked, kNone});
}

TEST_F(RelighterTest, IsTheExactPictureOfTexturesUnderSeveralLamps) {
    SyntheticOptions undivided;  // three lamps are enough to read
    undivided.boxes = Index3(1);
    const MappedScene m(scene_of_data("gallery"), undivided);
    expect_all_views(m, {kBaked, kNone});
    Relighter relighter = relighter_of(m);
    for (const View view : {View::radiance, View::irradiance, View::direct}) {
        ViewState state = state_of(m, view, kTraced, true);
        state.lamps[2].on = false;  // the rectangle
        expect_same(m, relighter, state);
        state.lamps[0].solo = true;
        expect_same(m, relighter, state);
    }
}

// The thesis' maps have no facings, and negative values stay.
TEST_F(RelighterTest, IsTheExactPictureOfTheThesis) {
    const MappedScene m = MappedScene::baked_by([](const std::filesystem::path& file) {
        set_log_level("error");
        std::string text = read_text(std::filesystem::path(PIM_DATA) / "cornell/cornell.toml");
        for (const auto& [from, to] : {std::pair<std::string, std::string>{"cells = 48", "cells = 10"},
                                       {"photons = 200000", "photons = 500"},
                                       {"samples = 300", "samples = 30"},
                                       {"cornell.glb", std::string(PIM_DATA) + "/cornell/cornell.glb"}})
            text.replace(text.find(from), from.size(), to);
        const auto description = file.parent_path() / "thesis.toml";
        std::ofstream(description) << "preset = \"thesis\"\n" << text;
        bake_run(description, {.output = file});
    });
    ASSERT_FALSE(m.baked.map.mend_signs);
    ASSERT_FALSE(m.baked.map.grid.facings);
    const auto values = patch_irradiance(m.baked.map, {Component::indirect},
                                         shining(m.scene(), state_of(m, View::radiance, kNone, true)));
    ASSERT_TRUE(std::ranges::any_of(values, [](const Rgb& e) { return e.x < 0; }));
    expect_all_views(m, {kBaked, kTraced, kNone});
}

// Surfaces beyond the grid's bounds have no light of the map.
TEST_F(RelighterTest, IsTheExactPictureOfAPartOfTheScene) {
    Scene scene = scene_of_data("cornell");
    scene.grid.bounds = Box3(Vec3(1.3f, -0.1f, 1.1f), Vec3(4.2f, 3.1f, 4));
    const MappedScene m(std::move(scene), few_grids());
    const Image picture = exact(m, state_of(m, View::irradiance, kBaked, true));
    EXPECT_GT(std::ranges::count(picture.pixels, Rgb(0)), kSize.x * kSize.y / 2);
    expect_all_views(m, {kBaked, kTraced});
}

// Those that nothing mended, as a map made otherwise may hold them.
TEST_F(RelighterTest, CountsWhatItCutsAtZero) {
    const MappedScene m(scene_of_data("cornell"), few_grids());
    const ViewState state = state_of(m, View::radiance, kNone, true);
    std::size_t cut = 0;
    patch_irradiance(m.baked.map, {Component::indirect}, shining(m.scene(), state), &cut);
    ASSERT_GT(cut, 10u);
    Relighter relighter = relighter_of(m);
    relighter.update(state, kSize);
    EXPECT_NEAR(double(relighter.statistics().cut_values), double(cut), 1);  // roundings
}

TEST_F(RelighterTest, EveryVectorUnitMakesThePicture) {
    const MappedScene m(scene_of_data("cornell"), few_grids());
    for (const VectorUnit unit : {VectorUnit::plain, VectorUnit::avx2, VectorUnit::avx512}) {
        if (!is_supported(unit)) continue;
        Relighter relighter = relighter_of(m, unit);
        for (const DirectLight direct : {kBaked, kTraced})
            expect_same(m, relighter, state_of(m, View::radiance, direct, true));
    }
}

TEST_F(RelighterTest, SingleReadingsAreThoseOfTheMap) {
    const MappedScene m(scene_of_data("cornell"));
    Relighter relighter = relighter_of(m);
    Largest off("relative_error");
    for (const DirectLight direct : {kBaked, kTraced, kNone}) {
        const ViewState state = state_of(m, View::radiance, direct, true);
        relighter.update(state, {8, 8});
        Moment moment{.scene = m.scene(),
                      .caster = m.caster,
                      .map = m.baked.map,
                      .lights = shining(m.scene(), state),
                      .direct = direct,
                      .patch_values = {}};
        evaluate_patches(moment);
        relighter.linear();
        Dice dice(5);
        for (int i = 0; i < 300; ++i) {  // all about the room, seen by the camera or not
            const auto hit = m.caster.intersect({{2.7f, 2.5f, 2.7f}, dice.direction()});
            if (!hit) continue;
            const SurfacePoint s = surface_at(m.scene(), *hit);
            RandomStream random(1, RandomPurpose::evaluation, 0, 0);
            const Rgb expected = surface_irradiance(moment, s, random), found = relighter.irradiance(s);
            // Sums of up to 48 patches and 40 terms, signs differing.
            ASSERT_NEAR((found - expected).length(), 0, 1e-5f * (expected.length() + 1));
            off.add(double((found - expected).length() / (expected.length() + 1)));
        }
    }
}

// --- what is kept is what would be made anew ---

std::vector<uint32_t> bytes(Relighter& relighter, const ViewState& state, const Imath::V2i& size) {
    relighter.update(state, size);
    std::vector<uint32_t> rgba(std::size_t(size.x) * std::size_t(size.y), 0x12345678u);
    relighter.encode(2, state.tone_curve, rgba.data());
    return rgba;
}

void expect_as_fresh(const MappedScene& m, Relighter& used, const ViewState& state, const Imath::V2i& size,
                     const std::string& what) {
    const MapFile own_map(m.file);  // a file has one reader at a time
    Relighter fresh(own_map, m.scene(), m.caster, best_vector_unit());
    if (shows_radiance(state.view)) {
        ASSERT_EQ(bytes(used, state, size), bytes(fresh, state, size)) << what;
    }
    used.update(state, size), fresh.update(state, size);
    ASSERT_EQ(used.linear().pixels, fresh.linear().pixels) << what;
    const SurfacePoint s = surface_seen(m.scene(), m.caster, state.camera.eye, state.camera.target);
    ASSERT_EQ(used.irradiance(s), fresh.irradiance(s)) << what;
    Image own(size.x, size.y), other(size.x, size.y);
    used.add_pass(1, own), fresh.add_pass(1, other);
    ASSERT_EQ(own.pixels, other.pixels) << what;
}

TEST(RelighterHistory, DoesNotShow) {
    const MappedScene m(scene_of_data("gallery"), few_grids());
    Relighter used = relighter_of(m);
    ViewState state = initial_state(m.scene(), m.baked.map);
    Imath::V2i size(40, 30);
    Dice dice(3);
    const auto lamp = [&]() -> LampControl& { return state.lamps[std::size_t(dice.below(3))]; };
    const std::vector<std::pair<const char*, std::function<void()>>> changes = {
        {"nothing", [] {}},
        {"a lamp moves",
         [&] {
             const auto l = std::size_t(dice.below(3));
             state.lamps[l].position = dice.inside(m.scene().lights[l].domain);
         }},
        {"a lamp jumps to a corner",
         [&] {
             const auto l = std::size_t(dice.below(3));
             const Box3& d = m.scene().lights[l].domain;
             state.lamps[l].position = dice.chance(0.5f) ? d.min : d.max;
         }},
        {"gain", [&] { lamp().gain = dice.chance(0.3f) ? 0 : dice.between(0, 2); }},
        {"colour",
         [&] {
             lamp().colour = dice.inside({Vec3(0), Vec3(1)});
         }},
        {"on or off", [&] { lamp().on = dice.chance(0.6f); }},
        {"solo", [&] { lamp().solo = dice.chance(0.3f); }},
        {"camera", [&] { state.camera.eye = Vec3(2.9f, 1.65f, 2.75f) + dice.direction() * 0.2f; }},
        {"target", [&] { state.camera.target.y = 1.45f + dice.between(-0.2f, 0.2f); }},
        {"field of view", [&] { state.camera.vertical_fov = dice.between(40, 80); }},
        {"up", [&] { state.camera.up.x = dice.between(-0.2f, 0.2f); }},
        {"direct light", [&] { state.direct = DirectLight(dice.below(3)); }},
        {"indirect light", [&] { state.indirect = dice.chance(0.7f); }},
        {"view", [&] { state.view = View(dice.chance(0.5f) ? 0 : dice.below(5)); }},
        {"trust", [&] { state.view = View::trust; }},
        {"lamps are shown", [&] { state.show_lamps = dice.chance(0.5f); }},
        {"tone curve", [&] { state.tone_curve = ToneCurve(dice.below(3)); }},
        {"size", [&] { size = Imath::V2i(20 + dice.below(40), 20 + dice.below(40)); }},
    };
    for (int step = 0; step < 60; ++step) {
        const auto& [what, change] = changes[std::size_t(dice.below(int(changes.size())))];
        change();
        if (dice.chance(0.2f)) used.update(state, size);  // taken up, never drawn
        if (dice.chance(0.3f)) changes[std::size_t(dice.below(int(changes.size())))].second();
        expect_as_fresh(m, used, state, size, std::to_string(step) + ": " + what);
        if (testing::Test::HasFatalFailure()) return;
    }
}

// While lamps move only patches that the picture needs are evaluated: others when they are asked for.
TEST(RelighterHistory, PatchesOutsideThePictureFollowTheLamps) {
    const MappedScene m(scene_of_data("cornell"), few_grids());
    const MapFile own_map(m.file);
    ViewState state = state_of(m, View::radiance, kBaked, true);
    const Imath::V2i size(4, 3);  // sees few of them
    Relighter used = relighter_of(m), fresh(own_map, m.scene(), m.caster, best_vector_unit());
    used.update(state, size);
    used.linear();
    state.lamps[0].position = m.scene().lights[0].domain.min;
    used.update(state, size), fresh.update(state, size);
    ASSERT_EQ(used.linear().pixels, fresh.linear().pixels);
    ASSERT_LT(used.statistics().evaluated_patches, m.baked.map.patches.size());
    Dice dice(5);
    for (int i = 0; i < 100; ++i) {
        const auto hit = m.caster.intersect({{2.7f, 2.5f, 2.7f}, dice.direction()});
        if (!hit) continue;
        const SurfacePoint s = surface_at(m.scene(), *hit);
        ASSERT_EQ(used.irradiance(s), fresh.irradiance(s));
    }
    state.lamps[0].position = m.scene().lights[0].domain.max;
    used.update(state, size);
    const MapFile third_map(m.file);
    Relighter newest(third_map, m.scene(), m.caster, best_vector_unit());
    newest.update(state, size);
    for (int pass = 0; pass < 20; ++pass) {
        Image own(size.x, size.y), other = own;
        if (pass > 0) used.add_pass(pass, own);
        if (pass > 0) newest.add_pass(pass, other);
        ASSERT_EQ(own.pixels, other.pixels) << pass;
    }
}

TEST(RelighterHistory, ThereAndBackIsTheSamePicture) {
    const MappedScene m(scene_of_data("caustic"), few_grids());
    Relighter relighter = relighter_of(m);
    const ViewState start = state_of(m, View::radiance, kTraced, true);
    const auto first = bytes(relighter, start, kSize);
    ViewState away = start;
    away.camera.eye += Vec3(0.1f, 0, 0);
    const auto other = bytes(relighter, away, kSize);
    EXPECT_NE(first, other);
    EXPECT_EQ(bytes(relighter, start, kSize), first);
    away = start;
    away.lamps[0].position = m.scene().lights[0].domain.min;
    EXPECT_NE(bytes(relighter, away, kSize), first);
    EXPECT_EQ(bytes(relighter, start, kSize), first);
    away = start;
    away.view = View::irradiance;
    relighter.update(away, {17, 9});
    relighter.linear();
    EXPECT_EQ(bytes(relighter, start, kSize), first);
}

TEST(RelighterHistory, GoesOnAfterAnError) {
    const MappedScene m(scene_of_data("cornell"), few_grids());
    Relighter relighter = relighter_of(m);
    const ViewState good = state_of(m, View::radiance, kTraced, true);
    ViewState bad = good;
    bad.lamps[0].position = Vec3(0);
    EXPECT_THROW(relighter.update(bad, kSize), UsageError);  // the first of all
    expect_as_fresh(m, relighter, good, kSize, "after a first error");
    bad.camera.eye.x += 0.1f;
    EXPECT_THROW(relighter.update(bad, kSize), UsageError);
    expect_as_fresh(m, relighter, good, kSize, "after a second error");
}

TEST(RelighterHistory, PartsThatTheMapLacksAreRefused) {
    SyntheticOptions options = few_grids();
    options.components = {Component::indirect};
    const MappedScene m(scene_of_data("cornell"), options);
    Relighter relighter = relighter_of(m);
    const std::string message =
        message_of<UsageError>([&] { relighter.update(state_of(m, View::radiance, kBaked, true), kSize); });
    EXPECT_NE(message.find("direct"), std::string::npos) << message;
    expect_as_fresh(m, relighter, state_of(m, View::radiance, kTraced, true), kSize, "after it");
}

TEST(RelighterHistory, ThreadsDoNotShow) {
    const MappedScene m(scene_of_data("gallery"), few_grids());
    const ViewState state = state_of(m, View::radiance, kTraced, true);
    std::vector<std::vector<uint32_t>> pictures;
    std::vector<std::vector<Rgb>> passes;
    for (const int threads : {1, 2, 4}) {
        const ThreadLimit limit(threads);
        Relighter relighter = relighter_of(m);
        pictures.push_back(bytes(relighter, state, {130, 70}));
        Image sum(130, 70);
        relighter.add_pass(1, sum);
        passes.push_back(sum.pixels);
    }
    EXPECT_EQ(pictures[0], pictures[1]);
    EXPECT_EQ(pictures[0], pictures[2]);
    EXPECT_EQ(passes[0], passes[1]);
    EXPECT_EQ(passes[0], passes[2]);
}

// --- pictures of all kinds ---

TEST_F(RelighterTest, AnySize) {
    const MappedScene m(scene_of_data("caustic"), few_grids());
    const ViewState state = state_of(m, View::radiance, kBaked, true);
    Relighter relighter = relighter_of(m);
    for (const Imath::V2i& size :
         {Imath::V2i(1, 1), {33, 31}, {32, 32}, {1, 40}, {65, 2}, {31, 64}, {5, 3}}) {
        const Image expected = exact(m, state, size), found = fast(relighter, state, size);
        ASSERT_EQ(found.width, size.x);
        ASSERT_EQ(found.height, size.y);
        const Difference d = difference(found, expected);
        EXPECT_LT(d.rms, kRest) << size;
        EXPECT_LE(d.share, kShareApart) << size;  // none, of pictures so small
        // Bytes: of each pixel, and none beside the picture.
        std::vector<uint32_t> rgba(found.pixels.size() + 32, 7u), again = rgba;
        relighter.encode(0.7f, ToneCurve::aces, rgba.data());
        relighter.encode(found, 0.7f, ToneCurve::aces, again.data());
        EXPECT_EQ(rgba, again) << size;
        for (std::size_t i = found.pixels.size(); i < rgba.size(); ++i) EXPECT_EQ(rgba[i], 7u);
    }
}

// Without mirrors each point is a pixel and goes straight to its bytes; lamps that show make sums of all.
TEST_F(RelighterTest, BytesAreThoseOfTheLinearPicture) {
    const MappedScene m(scene_of_data("gallery"), few_grids());
    Relighter relighter = relighter_of(m);
    for (const bool show_lamps : {false, true})
        for (const ToneCurve curve : {ToneCurve::none, ToneCurve::reinhard, ToneCurve::aces}) {
            ViewState state = state_of(m, View::radiance, kTraced, true);
            state.show_lamps = show_lamps, state.tone_curve = curve;
            const auto straight = bytes(relighter, state, kSize);
            std::vector<uint32_t> by_image(straight.size());
            relighter.encode(relighter.linear(), 2, curve, by_image.data());
            EXPECT_EQ(straight, by_image);
        }
}

TEST_F(RelighterTest, AViewOfNothingIsBlack) {
    const MappedScene m(scene_of_data("cornell"), few_grids());
    Relighter relighter = relighter_of(m);
    ViewState state = state_of(m, View::radiance, kTraced, true);
    state.camera.target = state.camera.eye * 2.0f - state.camera.target;  // the room lies behind
    for (const bool show_lamps : {false, true}) {
        state.show_lamps = show_lamps;
        for (const Rgb& pixel : fast(relighter, state).pixels) ASSERT_EQ(pixel, Rgb(0));
        for (const uint32_t rgba : bytes(relighter, state, kSize)) ASSERT_EQ(rgba, 0xff000000u);
        Image sum(kSize.x, kSize.y);
        relighter.add_pass(1, sum);
        for (const Rgb& pixel : sum.pixels) ASSERT_EQ(pixel, Rgb(0));
        EXPECT_EQ(relighter.statistics().points, 0u);
    }
}

TEST_F(RelighterTest, DarkLampsGiveBlackPictures) {
    const MappedScene m(scene_of_data("cornell"), few_grids());
    Relighter relighter = relighter_of(m);
    for (const DirectLight direct : {kBaked, kTraced}) {
        ViewState state = state_of(m, View::radiance, direct, true);
        state.lamps[0].on = false;
        for (const Rgb& pixel : fast(relighter, state).pixels) ASSERT_EQ(pixel, Rgb(0));
        EXPECT_EQ(relighter.statistics().active_boxes, 0u);
    }
}

// --- lamps that show ---

// A room of 2 m; a mirror covers the wall x = 2. Two lamps hang back to back before it, one shining at the
// eye, the other at the mirror.
struct LampsBeforeAMirror {
    MappedScene m;
    ViewState state;

    LampsBeforeAMirror() : m(scene()) {
        state = initial_state(m.scene(), m.baked.map);
        state.camera.eye = {0.1f, 1, 1}, state.camera.target = {2, 1, 1}, state.camera.vertical_fov = 60;
        state.direct = kBaked, state.show_lamps = true;
    }
    static Scene scene() {
        Scene scene = room(Rgb(0.5f), Vec3(2));
        scene.materials.push_back(mirror_material(Rgb(0.5f)));
        add_quad(scene, {1.999f, 0, 0}, {0, 0, 2}, {0, 2, 0}, 1);
        scene.lights = {rectangle_lamp({1.2f, 1, 1}, {0.5f, 0.3f}, {-1, 0, 0}, Rgb(3, 2, 1)),
                        rectangle_lamp({1.2f, 1, 1}, {1.6f, 0.3f}, {1, 0, 0}, Rgb(5, 7, 9))};
        scene.lights.push_back(rectangle_lamp({1.5f, 0.6f, 1}, {0.8f, 0.6f}, {-1, 0, 0}, Rgb(1, 2, 9)));
        scene.lights[1].name = "back", scene.lights[2].name = "behind";
        scene.cameras.emplace_back();
        return scene;
    }
};

TEST_F(RelighterTest, LampsAreSeenStraightAndInMirrors) {
    LampsBeforeAMirror lamps;
    Relighter relighter = relighter_of(lamps.m);
    const Image with = exact(lamps.m, lamps.state), found = fast(relighter, lamps.state);
    lamps.state.show_lamps = false;
    const Image without = exact(lamps.m, lamps.state), found_without = fast(relighter, lamps.state);
    EXPECT_LE(difference(found_without, without).share, kShareApart);
    const auto radiance = [&](std::size_t l) {
        const Light& light = lamps.m.scene().lights[l];
        return light.power / (kPi * light.rectangle()->area());
    };
    int straight = 0, mirrored = 0, farther = 0, apart = 0;
    for (std::size_t i = 0; i < with.pixels.size(); ++i) {
        const auto is = [&](const Rgb& a, const Rgb& b) {
            return (a - b).length() < 1e-4f * b.length() + 1e-6f;
        };
        if (is(with.pixels[i], radiance(0)) || is(with.pixels[i], radiance(2))) {  // hides all behind it
            apart += !is(found.pixels[i], with.pixels[i]);
            ++straight;
            farther += is(with.pixels[i], radiance(2));
        } else if (is(with.pixels[i], radiance(1) * 0.5f)) {  // is added to what is behind
            apart += !is(found.pixels[i], radiance(1) * 0.5f + without.pixels[i]);
            ++mirrored;
        } else {
            apart += !is(found.pixels[i], with.pixels[i]);
        }
    }
    EXPECT_GT(farther, 100);
    EXPECT_GT(straight - farther, 100);
    EXPECT_GT(mirrored, 20);
    EXPECT_LE(apart, kShareApart * double(with.pixels.size()));
}

// --- passes ---

// A floor under a rectangular lamp, a board between them: a wide penumbra.
Scene penumbra() {
    Scene scene = empty_scene(Rgb(0.5f));
    add_quad(scene, {-2, 0, -2}, {0, 0, 4}, {4, 0, 0});
    add_quad(scene, {-0.3f, 1, -1}, {0, 0, 2}, {1, 0, 0});
    scene.lights = {rectangle_lamp({0, 2, 0}, {0.8f, 0.6f}, {0.2f, -1, 0}, Rgb(10, 20, 30))};
    Camera camera;
    camera.eye = {0.1f, 0.9f, 1.9f}, camera.target = {-0.1f, 0, 0.2f}, camera.vertical_fov = 70;
    scene.cameras.push_back(camera);
    return scene;
}

constexpr int kPasses = 64;

TEST(RelighterPasses, MeanConvergesToTheSoftShadow) {
    const MappedScene m(penumbra());
    const Imath::V2i size(24, 16);
    ViewState state = initial_state(m.scene(), m.baked.map);
    state.view = View::irradiance, state.direct = kTraced, state.indirect = false;
    // Each pixel's mean over its area and the lamp's, found by 8 × 8 places with 64 shadow rays each.
    const CameraRays rays(state.camera, size);
    const LightState lamp = shining(m.scene(), state)[0];
    std::vector<Mean> expected(std::size_t(size.x) * std::size_t(size.y));
    for (std::size_t i = 0; i < expected.size(); ++i)
        for (int place = 0; place < 64; ++place) {
            RandomStream random(1, RandomPurpose::evaluation, uint32_t(i), uint64_t(place));
            const float x = float(i % std::size_t(size.x)) + (float(place % 8) + random.next()) / 8,
                        y = float(i / std::size_t(size.x)) + (float(place / 8) + random.next()) / 8;
            const auto hit = m.caster.intersect(rays.through(x, y));
            expected[i].add(!hit ? 0
                                 : double(direct_irradiance(m.caster, m.scene().lights[0], lamp,
                                                            surface_at(m.scene(), *hit), 64, random)
                                              .x));
        }
    Relighter relighter = relighter_of(m);
    relighter.update(state, size);
    std::vector<Mean> found(expected.size());
    double first_error = 0, last_error = 0, power = 0;
    for (int pass = 0; pass < kPasses; ++pass) {
        Image image = pass == 0 ? relighter.linear() : Image(size.x, size.y);
        if (pass > 0) relighter.add_pass(pass, image);
        for (std::size_t i = 0; i < found.size(); ++i) found[i].add(double(image.pixels[i].x));
        if (pass + 1 != 4 && pass + 1 != kPasses) continue;
        for (std::size_t i = 0; i < found.size(); ++i)
            (pass + 1 == 4 ? first_error : last_error) += std::pow(found[i].value() - expected[i].value(), 2);
    }
    int soft = 0;
    double by_chance = 0;
    for (std::size_t i = 0; i < found.size(); ++i) {
        by_chance += std::pow(found[i].standard_error(), 2);
        // Passes are spread better than chance, so that chance's error is ample. Pixels that all agree on
        // have none: some roundings.
        pim::expect_same(found[i], expected[i], 1e-4 * std::abs(expected[i].value()), double(found.size()));
        soft += found[i].standard_error() > 0.01 * found[i].value();
        power += expected[i].value() * expected[i].value();
    }
    EXPECT_GT(soft, 50);
    // Sixteen times the passes: a quarter of the error at most, and less than places at random would leave.
    EXPECT_LT(last_error, first_error / 16);
    EXPECT_LT(last_error, 0.5 * by_chance);
    record("error_by_that_of_chance", std::sqrt(last_error / by_chance));
    record("relative_rms_of_4", std::sqrt(first_error / power));
    record("relative_rms_of_64", std::sqrt(last_error / power));
}

TEST(RelighterPasses, SlicesAddUpToThePass) {
    const MappedScene m(penumbra());
    Relighter relighter = relighter_of(m);
    ViewState state = initial_state(m.scene(), m.baked.map);
    state.direct = kTraced;
    const Imath::V2i size(100, 70);
    relighter.update(state, size);
    Image whole = relighter.linear(), sliced = whole;
    relighter.add_pass(3, whole);
    ASSERT_EQ(relighter.tile_count(), 12u);  // 4 × 3 tiles of 32 pixels
    for (std::size_t tile = 0; tile < 12; tile += 5)
        relighter.add_pass(3, tile, std::min<std::size_t>(12, tile + 5), sliced);
    EXPECT_EQ(whole.pixels, sliced.pixels);
}

// Where nothing is soft, passes show the same surfaces at other places of the pixel. Of 64 well-spread places
// a part of the pixel beyond an edge holds its share within about 64^(-3/4) (Beck 1987).
TEST(RelighterPasses, MeanOfSharpPicturesIsThatOfExactOnes) {
    const MappedScene m(scene_of_data("cornell"), few_grids());
    Relighter relighter = relighter_of(m);
    const ViewState state = state_of(m, View::radiance, kTraced, true);
    const Imath::V2i size(32, 32);
    relighter.update(state, size);
    std::vector<Mean> found(std::size_t(size.x) * std::size_t(size.y));
    for (int pass = 0; pass < kPasses; ++pass) {
        Image image = pass == 0 ? relighter.linear() : Image(size.x, size.y);
        if (pass > 0) relighter.add_pass(pass, image);
        for (std::size_t i = 0; i < found.size(); ++i) found[i].add(double(image.pixels[i].y));
    }
    const Image many = exact(m, state, size, 1024);
    double brightest = 0, squares = 0, sum = 0;
    for (const Rgb& pixel : many.pixels) brightest = std::max(brightest, double(pixel.y));
    for (std::size_t i = 0; i < found.size(); ++i) {
        const double expected = double(many.pixels[i].y);
        expect_mean(found[i], expected, brightest * std::pow(kPasses, -0.75), double(found.size()));
        squares += std::pow(found[i].value() - expected, 2), sum += expected * expected;
    }
    record("relative_rms", std::sqrt(squares / sum));
}

}  // namespace
}  // namespace pim
