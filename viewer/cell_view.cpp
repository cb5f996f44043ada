// SPDX-License-Identifier: GPL-3.0-or-later
#include "viewer/cell_view.h"

#include <cmath>

namespace pim {
namespace {

// A colour of its own for each cell and facing, so that neighbours differ.
Rgb colour_of(int patch) {
    const auto word = philox4x32({uint32_t(patch), 0, 0, 0}, {0, 0});
    return Rgb(float(word[0] >> 24), float(word[1] >> 24), float(word[2] >> 24)) / 255.0f * 0.6f + Rgb(0.2f);
}

int main_facing(const CellGrid& grid, const Vec3& normal) {
    const auto weights = facing_weights(grid, normal).weight;
    return int(std::ranges::max_element(weights) - weights.begin());
}

Rgb shade(const Moment& m, const SurfaceCells& cells, const Ray& ray) {
    const auto hit = m.caster.intersect(ray);
    if (!hit) return Rgb(0);
    const SurfacePoint s = surface_at(m.scene, *hit);
    const auto fine = cells.fine_cell(s.triangle, s.side, s.position);
    const int patch = fine ? m.map.index.find(cell_of_fine(*fine), main_facing(m.map.grid, s.shading_normal)) : -1;
    return patch < 0 ? Rgb(0.02f) : colour_of(patch);
}

// Centres that no surface hides by more than a cell.
void draw_centres(const Moment& m, const Camera& camera, Image& image) {
    const CameraRays rays(camera, {image.width, image.height});
    const Vec3 corner = rays.through(0, 0).direction, right = rays.through(float(image.width), 0).direction,
               down = rays.through(0, float(image.height)).direction;
    const Vec3 forward = (camera.target - camera.eye).normalized();
    const Vec3 a = corner / corner.dot(forward), u = right / right.dot(forward) - a, v = down / down.dot(forward) - a;
    for (const Patch& patch : m.map.patches) {
        const Vec3 path = Vec3(m.map.grid.centre(patch.cell)) - camera.eye;
        const float depth = path.dot(forward), distance = path.length();
        if (!(depth > 0)) continue;
        const Vec3 on_plane = path / depth - a;
        const int x = int(on_plane.dot(u) / u.length2() * float(image.width));
        const int y = int(on_plane.dot(v) / v.length2() * float(image.height));
        if (x < 1 || y < 1 || x >= image.width - 1 || y >= image.height - 1) continue;
        if (m.caster.occluded({camera.eye, path / distance, distance - float(m.map.grid.cell_size)})) continue;
        image.at(x, y) = image.at(x + 1, y) = image.at(x, y + 1) = image.at(x + 1, y + 1) = Rgb(1, 0.9f, 0.1f);
    }
}

}  // namespace

Image render_cells(const Moment& moment, const Camera& camera, const FrameOptions& options) {
    const SurfaceCells cells(moment.map.grid, moment.scene.geometry);
    Image image = render_frame(camera, options, [&](const Ray& ray, RandomStream&) { return shade(moment, cells, ray); });
    draw_centres(moment, camera, image);
    return image;
}

}  // namespace pim
