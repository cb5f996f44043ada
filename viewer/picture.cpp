// SPDX-License-Identifier: GPL-3.0-or-later
#include "viewer/picture.h"

#include <fmt/format.h>

#include "common/core/error.h"
#include "common/core/log.h"
#include "common/map/irradiance.h"
#include "common/map/map_file.h"
#include "common/render/frame.h"
#include "common/render/light_image.h"
#include "common/render/path_radiance.h"
#include "viewer/cell_view.h"

namespace pim {
namespace {

Image render_paths(const BakedScene& baked, const RayCaster& caster, const PictureOptions& o,
                   const FrameOptions& frame) {
    const PathScene scene{baked.scene, caster, o.lights, o.show_lamps};
    Image image = render_frame(o.camera, frame, [&](const Ray& ray, RandomStream& random) {
        const Seen seen = path_radiance(scene, ray, random);
        Rgb shown(0);
        if (o.direct != DirectLight::none) shown += seen.total - seen.indirect;
        if (o.indirect) shown += seen.indirect;
        return shown;
    });
    if (!o.indirect || !point_lamps_meet_specular(baked.scene)) return image;
    log_warning(
        "light of point lamps by way of mirrors or glass is added by photons from the lamps; seen in mirrors "
        "or "
        "through glass it is missing");
    const uint64_t photons = uint64_t(image.width) * uint64_t(image.height) * uint64_t(o.samples);
    const Image added = light_image(scene, o.camera, o.size, photons, frame.seed, 0);
    for (std::size_t i = 0; i < image.pixels.size(); ++i) image.pixels[i] += added.pixels[i];
    return image;
}

Moment moment_of(const BakedScene& baked, const RayCaster& caster, const PictureOptions& o) {
    Moment moment{.scene = baked.scene,
                  .caster = caster,
                  .map = baked.map,
                  .lights = o.lights,
                  .direct = o.direct,
                  .indirect = o.indirect,
                  .show_lamps = o.show_lamps,
                  .patch_values = {}};
    if (o.view == View::density && moment.direct == DirectLight::traced) moment.direct = DirectLight::none;
    if (o.volume)
        moment.patch_values = read_volume(baked.map, *o.volume);
    else
        evaluate_patches(moment);
    return moment;
}

}  // namespace

std::vector<Rgb> read_volume(const IlluminationMap& map, const std::filesystem::path& file) {
    const VdbReader reader(file);
    const auto alien = [&] {
        return Error(
            fmt::format("{}: is no density volume of this map: another grid or scene", file.string()));
    };
    if (!reader.metadata().contains("geometry_hash") || reader.text("geometry_hash") != map.geometry_hash)
        throw alien();
    std::vector<Rgb> values(map.patches.size(), Rgb(0));
    const auto facings = cells_by_slot(map.patches);
    bool any = false;
    for (const Component c : {Component::direct, Component::indirect})
        for (int f = 0; f < kSlotCount; ++f) {
            const std::string grid = fmt::format("{}/{}/density", name(c), slot_name(map.grid, f));
            if (facings[f].cells.empty() || !reader.has(grid)) continue;
            any = true;
            auto active = reader.active_cells(grid);
            std::sort(active.begin(), active.end(), cell_before);
            if (active != facings[f].cells) throw alien();
            const auto own = reader.values(grid, facings[f].cells, 3);
            for (std::size_t i = 0; i < facings[f].patches.size(); ++i)
                values[facings[f].patches[i]] += Rgb(own[3 * i], own[3 * i + 1], own[3 * i + 2]);
        }
    if (!any) throw alien();
    return values;
}

Image render_picture(const BakedScene& baked, const RayCaster& caster, const PictureOptions& o) {
    FrameOptions frame{.size = o.size, .samples = o.samples};
    if (o.integrator == Integrator::path) {
        frame.progress = "tracing paths";
        return render_paths(baked, caster, o, frame);
    }
    const Moment moment = moment_of(baked, caster, o);
    if (o.view == View::cells) return render_cells(moment, o.camera, frame);
    if (o.view == View::radiance)
        return render_frame(o.camera, frame, [&](const Ray& ray, RandomStream& random) {
            return map_radiance(moment, ray, random);
        });
    return render_frame(o.camera, frame, [&](const Ray& ray, RandomStream& random) {
        const auto hit = caster.intersect(ray);
        if (!hit) return Rgb(0);
        const SurfacePoint surface = surface_at(baked.scene, *hit);
        if (o.view == View::irradiance) return surface_irradiance(moment, surface, random);
        return Rgb(luminance(
            irradiance_at(baked.map, moment.patch_values, surface.position, surface.shading_normal)));
    });
}

}  // namespace pim
