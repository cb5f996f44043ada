// SPDX-License-Identifier: GPL-3.0-or-later
#include "viewer/cell_view.h"

#include <cmath>

namespace pim {
namespace {

struct Sight {
    const Scene& scene;
    const IlluminationMap& map;
    const RayCaster& caster;
};

// A colour of its own for each cell and facing, so that neighbours differ.
Rgb colour_of(int patch) {
    const auto word = philox4x32({uint32_t(patch), 0, 0, 0}, {0, 0});
    return Rgb(float(word[0] >> 24), float(word[1] >> 24), float(word[2] >> 24)) / 255.0f * 0.6f + Rgb(0.2f);
}

int main_facing(const CellGrid& grid, const Vec3& normal) {
    const auto weights = facing_weights(grid, normal).weight;
    return int(std::ranges::max_element(weights) - weights.begin());
}

Rgb shade(const Sight& m, const SurfaceCells& cells, const Ray& ray) {
    const auto hit = m.caster.intersect(ray);
    if (!hit) return Rgb(0);
    const SurfacePoint s = surface_at(m.scene, *hit);
    const auto fine = cells.fine_cell(s.triangle, s.side, s.position);
    const int patch =
        fine ? m.map.index.find(cell_of_fine(*fine), main_facing(m.map.grid, s.shading_normal)) : -1;
    return patch < 0 ? Rgb(0.02f) : colour_of(patch);
}

// Centres that no surface hides by more than a cell.
void draw_centres(const Sight& m, const Camera& camera, Image& image) {
    const CameraRays rays(camera, {image.width, image.height});
    for (const Patch& patch : m.map.patches) {
        const Vec3 centre(m.map.grid.centre(patch.cell));
        const auto pixel = rays.pixel_of(centre);
        if (!pixel) continue;
        const int x = pixel->x, y = pixel->y;
        const Vec3 path = centre - camera.eye;
        const float distance = path.length();
        if (x < 1 || y < 1 || x >= image.width - 1 || y >= image.height - 1) continue;
        if (m.caster.occluded({camera.eye, path / distance, distance - float(m.map.grid.cell_size)}))
            continue;
        image.at(x, y) = image.at(x + 1, y) = image.at(x, y + 1) = image.at(x + 1, y + 1) =
            Rgb(1, 0.9f, 0.1f);
    }
}

}  // namespace

Image render_cells(const Scene& scene, const IlluminationMap& map, const RayCaster& caster,
                   const Camera& camera, const FrameOptions& options) {
    const Sight sight{scene, map, caster};
    const SurfaceCells cells(map.grid, scene.geometry);
    Image image = render_frame(camera, options,
                               [&](const Ray& ray, RandomStream&) { return shade(sight, cells, ray); });
    draw_centres(sight, camera, image);
    return image;
}

}  // namespace pim
