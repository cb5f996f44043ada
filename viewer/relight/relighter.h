// SPDX-License-Identifier: GPL-3.0-or-later
// Frames of a baked scene while lamps and camera move: keeps all that the last change left valid. No OpenGL.
#pragma once

#include "common/core/image.h"
#include "viewer/relight/coefficient_store.h"
#include "viewer/relight/view_cache.h"
#include "viewer/view_state.h"

namespace pim {

struct FrameStatistics {
    double evaluate_seconds = 0;  // polynomials of the patches in view
    // Of all threads, over their number:
    double view_seconds = 0;    // camera rays and look-up weights; nearly 0 where the camera rested
    double shadow_seconds = 0;  // rays to lamps
    double shade_seconds = 0;
    std::size_t points = 0;        // surface points that make the picture
    double patches_per_point = 0;  // read for each of them
    std::size_t evaluated_patches = 0;
    std::size_t active_boxes = 0;
    std::size_t cache_bytes = 0;
    std::size_t cut_values = 0;  // of patches and channels: below zero, shown as 0
};

class Relighter {
  public:
    // Arguments outlive it.
    Relighter(const MapFile& map, const Scene& scene, const RayCaster& caster, VectorUnit unit);

    // Takes up the state: polynomials now, rays where the camera has moved and shadow rays where lamps have
    // with the next picture. Views cells, normals and albedo show nothing of it. Throws UsageError: a lamp
    // outside its domain, a part that the map lacks; Error: the map cannot be read.
    void update(const ViewState& state, const Imath::V2i& size);

    // 8-bit picture of a radiance view: R, G, B, 255 in rising bytes; size.x · size.y of them, from the top.
    void encode(float exposure, ToneCurve curve, uint32_t* rgba);
    // Linear: radiance, W/(m² sr), or irradiance, W/m², or for `trust` residual over irradiance.
    Image linear();
    // Adds the linear picture of another sampling pass (rays elsewhere in the pixels and on rectangular
    // lamps) to `sum`; pass 1, 2, ...: with pass 0, which linear() gives, their mean converges. In the window
    // a pass is made of several slices of tiles.
    std::size_t tile_count() const { return tiles_.size(); }
    void add_pass(int pass, std::size_t first_tile, std::size_t end_tile, Image& sum);
    void add_pass(int pass, Image& sum) { add_pass(pass, 0, tile_count(), sum); }
    // 8-bit picture of any linear one.
    void encode(const Image& linear, float exposure, ToneCurve curve, uint32_t* rgba) const;
    // Irradiance at a surface under the lamps of the last update, W/m².
    Rgb irradiance(const SurfacePoint& surface);

    const FrameStatistics& statistics() const { return statistics_; }
    const CoefficientStore& store() const { return *store_; }
    std::string take_problem() { return store_->take_problem(); }

  private:
    struct Blocks {
        std::size_t count = 0;
        void resize(std::size_t patches, bool with_residual);
        std::vector<uint32_t> needed;               // blocks of kLanes patches
        AlignedVector<float> irradiance, residual;  // [block][channel][lane]
    };
    // A tile's place in a picture.
    template <class Pixel>
    struct Corner {
        Pixel* pixels;
        int stride;
        Pixel& at(int pixel) const {
            return pixels[std::size_t(pixel / kTileSize) * std::size_t(stride) + pixel % kTileSize];
        }
    };
    using LampTerms = std::vector<AlignedVector<float>>;  // [lamp][block of the tile][lane]

    void choose_components();
    void plan_view(bool camera_moved);
    template <class Sink>
    void for_each_tile(Sink sink);
    void evaluate(const std::vector<uint32_t>& blocks);
    void evaluate_all();
    std::size_t evaluate_block(std::size_t block);  // how many values it cut at 0
    void trace_lamp(const ViewTile& tile, std::size_t lamp, int pass, AlignedVector<float>& terms) const;
    template <class Sink>
    void shade(const ViewTile& tile, const LampTerms& terms, Sink sink) const;
    void add_tile(const ViewTile& tile, const LampTerms& terms, const Corner<Rgb>& corner) const;
    void add_lamps(const ViewTile& tile, const Corner<Rgb>& corner) const;
    void encode_points(const ViewTile& tile, const LampTerms& terms, float exposure, ToneCurve curve,
                       const Corner<uint32_t>& corner) const;
    void encode_sums(const ViewTile& tile, const LampTerms& terms, float exposure, ToneCurve curve,
                     const Corner<uint32_t>& corner) const;
    const LampTerms& terms_of(std::size_t tile) const;
    void count_points();

    const MapFile& map_;
    const Scene& scene_;
    const RayCaster& caster_;
    const Kernels& kernels_;
    ViewBuilder builder_;
    std::unique_ptr<CoefficientStore> store_;
    std::vector<Component> components_;
    std::optional<ViewState> state_;
    std::vector<LightState> lights_;
    Imath::V2i size_{0};
    ViewOptions options_;
    std::vector<ViewTile> tiles_;
    std::vector<LampTerms> terms_;  // per tile
    std::vector<uint8_t> traced_;   // lamps whose terms are valid
    Blocks blocks_;
    std::vector<ActiveBox> boxes_;
    bool evaluated_all_ = false, view_is_due_ = true;
    FrameStatistics statistics_;
};

}  // namespace pim
