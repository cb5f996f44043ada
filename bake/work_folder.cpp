// SPDX-License-Identifier: GPL-3.0-or-later
#include "bake/work_folder.h"

#include <fmt/format.h>

#include <cstring>
#include <nlohmann/json.hpp>

#include "common/core/error.h"
#include "common/core/file.h"
#include "common/core/log.h"
#include "common/map/map_file.h"

namespace pim {
namespace fs = std::filesystem;
namespace {

// Counts up when the same settings give other volumes than before, so that old ones are not mixed in.
constexpr int kTracerVersion = 9;

std::string text(const Vec3& v) { return fmt::format("{:.9g} {:.9g} {:.9g}", v.x, v.y, v.z); }

std::string light_text(const Light& light) {
    const RectangleShape* r = light.rectangle();
    return fmt::format(
        "light {} {} domain {} to {}\n", light.name,
        r ? fmt::format("rectangle {:.9g} {:.9g} {}", r->size.x, r->size.y, text(r->normal)) : "point",
        text(light.domain.min), text(light.domain.max));
}

std::string pack(const std::vector<FragmentKey>& keys) {
    std::string bytes;
    for (const FragmentKey& k : keys) {
        char record[13];
        std::memcpy(record, &k.cell, 8);
        std::memcpy(record + 8, &k.triangle, 4);
        record[12] = char(k.place);
        bytes.append(record, sizeof record);
    }
    return bytes;
}

std::vector<FragmentKey> unpack(const std::string& bytes) {
    std::vector<FragmentKey> keys(bytes.size() / 13);
    for (std::size_t i = 0; i < keys.size(); ++i) {
        std::memcpy(&keys[i].cell, &bytes[13 * i], 8);
        std::memcpy(&keys[i].triangle, &bytes[13 * i + 8], 4);
        keys[i].place = uint8_t(bytes[13 * i + 12]);
    }
    return keys;
}

std::string pack(const LookUpMeans& means) {
    std::string bytes;
    const auto append = [&](const auto& value) {
        bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
    };
    for (std::size_t p = 0; p < means.patches(); ++p) {
        append(uint32_t(means.of(p).size()));
        for (const auto& share : means.of(p)) append(share.patch), append(share.weight);
    }
    return bytes;
}

// Empty if they are not those of so many patches.
std::optional<LookUpMeans> unpack_means(const std::string& bytes, std::size_t patches) {
    std::vector<LookUpMeans::Row> rows;
    std::size_t at = 0;
    const auto take = [&](auto& value) {
        if (at + sizeof value > bytes.size()) return false;
        std::memcpy(&value, &bytes[at], sizeof value);
        at += sizeof value;
        return true;
    };
    while (at < bytes.size()) {
        uint32_t count = 0;
        if (!take(count)) return std::nullopt;
        LookUpMeans::Row& row = rows.emplace_back();
        for (uint32_t i = 0; i < count; ++i) {
            auto& share = row.emplace_back();
            if (!take(share.patch) || !take(share.weight) || share.patch >= patches) return std::nullopt;
        }
    }
    if (!rows.empty() && rows.size() != patches) return std::nullopt;
    return rows.empty() ? LookUpMeans() : LookUpMeans(rows);
}

void check_settings(const VdbReader& file, const std::string& settings, const fs::path& path) {
    if (file.text("settings") != settings) throw other_settings(path);
}

int used_slots(const std::vector<Patch>& patches) {
    const auto facings = cells_by_slot(patches);
    return int(std::ranges::count_if(facings, [](const SlotCells& f) { return !f.cells.empty(); }));
}

// A damaged file is as good as none: it is made again.
std::unique_ptr<VdbReader> open_unless_damaged(const fs::path& path) {
    try {
        return std::make_unique<VdbReader>(path, VdbReader::Access::whole_grids);
    } catch (const Error& e) {
        log_warning(fmt::format("{}; it is made again", e.what()));
        return nullptr;
    }
}

std::string stem_of(Component component, const CellGrid& grid, int facing) {
    return fmt::format("{}/{}", name(component), slot_name(grid, facing));
}

}  // namespace

Error other_settings(const fs::path& path) {
    return Error(
        fmt::format("{}: was made with other settings or another scene; bake with --overwrite, or to another "
                    "file with -o",
                    path.string()));
}

std::string trace_settings(const Scene& s, const RayCaster& caster, const Solids& solids) {
    const auto* count = std::get_if<CellCount>(&s.grid.resolution);
    std::string out = fmt::format("tracer {}\ngeometry {}\n", kTracerVersion, s.geometry_hash);
    out += count ? fmt::format("cells {}\n", count->longest)
                 : fmt::format("cell_size {:.17g}\n", std::get<CellSize>(s.grid.resolution).metres);
    if (s.grid.bounds)
        out += fmt::format("bounds {} to {}\n", text(s.grid.bounds->min), text(s.grid.bounds->max));
    if (s.grid.reach_photons != GridSettings{}.reach_photons)
        out += fmt::format("reach_photons {}\n", s.grid.reach_photons);
    out += fmt::format("facings {} estimator {} radius {:.17g} reachable {}\n", s.grid.facings,
                       int(s.grid.estimator), s.grid.radius.value_or(0), s.grid.reachable_area_only);
    out += fmt::format("photons {} store {} seed {} rays {}\n", s.bake.photons, int(s.bake.store),
                       s.bake.seed, caster.instruction_set());
    for (const Component c : s.bake.components) out += fmt::format("component {}\n", name(c));
    for (const Light& light : s.lights) out += light_text(light);
    for (const std::string& solid : solids.names()) out += fmt::format("solid {}\n", solid);
    return out;
}

WorkFolder::WorkFolder(const Workplace& place, std::string settings, const Scene& scene)
    : path_(place.folder),
      volumes_(place.volumes),
      settings_(std::move(settings)),
      origin_(scene.geometry.origin),
      channels_(is_grey(scene) ? 1 : 3) {
    create(path_);
    volumes_->begin(settings_);
}

void WorkFolder::create(const fs::path& path) {
    std::error_code problem;
    fs::create_directories(path, problem);
    if (problem)
        throw Error(
            fmt::format("{}: the work folder cannot be created: {}", path.string(), problem.message()));
}

fs::path WorkFolder::beside(const fs::path& map_file) { return map_file.string() + ".work"; }

std::optional<Cells> WorkFolder::read_cells() const {
    const fs::path path = path_ / "cells.vdb";
    if (!fs::exists(path)) return std::nullopt;
    const auto reader = open_unless_damaged(path);
    if (!reader) return std::nullopt;
    const VdbReader& file = *reader;
    check_settings(file, settings_, path);
    Cells cells;
    cells.grid = {file.vector("grid_local_corner"), file.number("grid_cell_size"),
                  Index3(file.vector("grid_size")), file.number("grid_facings") != 0};
    cells.patches = read_patches(file, cells.grid);
    cells.index = PatchIndex(cells.grid, cells.patches);
    cells.split.resize(cells.patches.size());
    cells.sight = read_sight(file, cells.grid, cells.index, cells.patches.size());
    const auto slots = cells_by_slot(cells.patches);
    for (int f = 0; f < kSlotCount; ++f) {
        if (slots[f].cells.empty()) continue;
        const auto offset = file.values("split/" + slot_name(cells.grid, f), slots[f].cells, 1);
        const auto normal = file.values("split_normal/" + slot_name(cells.grid, f), slots[f].cells, 3);
        for (std::size_t i = 0; i < offset.size(); ++i)
            cells.split[slots[f].patches[i]] = {{normal[3 * i], normal[3 * i + 1], normal[3 * i + 2]},
                                                offset[i]};
    }
    const auto means = unpack_means(file.text("look_up_means"), cells.patches.size());
    if (!means)
        throw Error(fmt::format("{}: look_up_means is damaged; bake with --overwrite", path.string()));
    cells.means = *means;
    cells.left_out = FragmentIndex(unpack(file.text("left_out_fragments")));
    cells.surface_area = file.number("surface_area");
    cells.counted_area = file.number("counted_area");
    cells.moved_area = file.number("moved_area");
    cells.deciding_photons = uint64_t(file.number("deciding_photons"));
    return cells;
}

void WorkFolder::write_cells(const Cells& cells) const {
    VdbMetadata m;
    m["settings"] = settings_;
    m["grid_local_corner"] = cells.grid.origin;
    m["grid_cell_size"] = cells.grid.cell_size;
    m["grid_size"] = Vec3d(cells.grid.size);
    m["grid_facings"] = double(cells.grid.facings);
    m["look_up_means"] = pack(cells.means);
    m["left_out_fragments"] = pack(cells.left_out.keys());
    m["surface_area"] = cells.surface_area;
    m["counted_area"] = cells.counted_area;
    m["moved_area"] = cells.moved_area;
    m["deciding_photons"] = double(cells.deciding_photons);
    write_atomically(path_ / "cells.vdb", [&](const fs::path& temporary) {
        int sight_grids = 0;
        write_sight(cells.sight, cells.patches, cells.grid,
                    [&](const auto&, const auto&, const auto&, int) { ++sight_grids; });
        VdbWriter writer(temporary, m, transform_of(cells.grid, origin_),
                         4 * used_slots(cells.patches) + sight_grids);
        write_patches(cells.patches, cells.grid,
                      [&](const auto& grid, const auto& active, const auto& values, int channels) {
                          writer.add(grid, active, values, channels);
                      });
        write_sight(cells.sight, cells.patches, cells.grid,
                    [&](const auto& grid, const auto& voxels, const auto& values, int channels) {
                        writer.add(grid, voxels, values, channels);
                    });
        const auto slots = cells_by_slot(cells.patches);
        for (int f = 0; f < kSlotCount; ++f) {
            if (slots[f].cells.empty()) continue;
            std::vector<float> offset, normal;
            for (const uint32_t p : slots[f].patches) {
                offset.push_back(cells.split[p].offset);
                const Vec3& n = cells.split[p].normal;
                normal.insert(normal.end(), &n.x, &n.x + 3);
            }
            writer.add("split/" + slot_name(cells.grid, f), slots[f].cells, offset, 1);
            writer.add("split_normal/" + slot_name(cells.grid, f), slots[f].cells, normal, 3);
        }
        writer.finish();
    });
}

fs::path WorkFolder::file_of(const Scene& scene, const LightSample& sample) const {
    return path_ / fmt::format("{}.{:06}.vdb", scene.lights[sample.light].name, sample.number);
}

bool WorkFolder::has(const Scene& scene, const LightSample& sample) const {
    const fs::path path = file_of(scene, sample);
    if (!fs::exists(path)) return false;
    if (const auto held = volumes_->find(path.filename()); held.account)
        return held.position == sample.position;
    const auto file = open_unless_damaged(path);
    if (!file) return false;
    check_settings(*file, settings_, path);
    return Vec3(file->vector("local_position")) == sample.position;
}

void WorkFolder::write(const Scene& scene, const Cells& cells, const LightSample& sample,
                       const DensityVolume& volume) const {
    const EnergyAccount& a = volume.account;
    VdbMetadata m;
    m["settings"] = settings_;
    m["geometry_hash"] = scene.geometry_hash;
    m["light"] = scene.lights[sample.light].name;
    m["sample"] = int64_t{sample.number};
    m["position"] = scene.geometry.to_world(sample.position);
    m["local_position"] = Vec3d(sample.position);
    m["seed"] = int64_t(scene.bake.seed);
    m["photons_emitted"] = double(a.emitted), m["photons_absorbed"] = double(a.absorbed);
    m["photons_escaped"] = double(a.escaped), m["photons_cut_off"] = double(a.cut_off);
    m["flux_absorbed"] = a.absorbed_flux, m["flux_escaped"] = a.escaped_flux,
    m["flux_cut_off"] = a.cut_off_flux;
    m["flux_normals"] = a.normals_flux, m["flux_squared"] = a.squared_flux;
    const auto facings = cells_by_slot(cells.patches);
    write_atomically(file_of(scene, sample), [&](const fs::path& temporary) {
        VdbWriter writer(temporary, m, transform_of(cells.grid, origin_),
                         2 * used_slots(cells.patches) * int(scene.bake.components.size()), trees_);
        for (const Component c : scene.bake.components)
            for (int f = 0; f < kSlotCount; ++f) {
                if (facings[f].cells.empty()) continue;
                std::vector<float> density, variance;
                for (const uint32_t p : facings[f].patches) {
                    const Rgb& d = volume.components[int(c)].density[p];
                    density.insert(density.end(), &d.x, &d.x + channels_);
                    variance.push_back(volume.components[int(c)].variance[p]);
                }
                writer.add(stem_of(c, cells.grid, f) + "/density", facings[f].cells, density, channels_);
                writer.add(stem_of(c, cells.grid, f) + "/variance", facings[f].cells, variance, 1);
            }
        writer.finish();
    });
    VolumeCache::Volume held{sample.position, a, {}};
    for (const Component c : scene.bake.components) {
        auto component = volume.components[std::size_t(c)];
        if (channels_ == 1)
            for (Rgb& d : component.density) d = Rgb(d.x);
        held.components[std::size_t(c)] = std::make_shared<DensityVolume::PerComponent>(std::move(component));
    }
    volumes_->keep(file_of(scene, sample).filename(), std::move(held));
}

DensityVolume::PerComponent WorkFolder::read(const Scene& scene, const Cells& cells,
                                             const LightSample& sample, Component component) const {
    const fs::path file = file_of(scene, sample);
    auto held = volumes_->find(file.filename());
    auto& own = held.components[std::size_t(component)];
    if (own) return *own;
    own = std::make_shared<DensityVolume::PerComponent>(read_file(file, cells, component));
    held.position = sample.position;
    volumes_->keep(file.filename(), held);
    return *own;
}

DensityVolume::PerComponent WorkFolder::read_file(const fs::path& path, const Cells& cells,
                                                  Component component) const {
    const VdbReader file(path, VdbReader::Access::whole_grids);
    check_settings(file, settings_, path);
    DensityVolume::PerComponent volume{std::vector<Rgb>(cells.patches.size()),
                                       std::vector<float>(cells.patches.size())};
    const auto slots = cells_by_slot(cells.patches);
    for (int f = 0; f < kSlotCount; ++f) {
        if (slots[f].cells.empty()) continue;
        const std::string stem = stem_of(component, cells.grid, f);
        const auto density = file.values(stem + "/density", slots[f].cells, 3);
        const auto variance = file.values(stem + "/variance", slots[f].cells, 1);
        for (std::size_t i = 0; i < slots[f].patches.size(); ++i) {
            volume.density[slots[f].patches[i]] = {density[3 * i], density[3 * i + 1], density[3 * i + 2]};
            volume.variance[slots[f].patches[i]] = variance[i];
        }
    }
    return volume;
}

EnergyAccount WorkFolder::read_account(const Scene& scene, const LightSample& sample) const {
    const fs::path path = file_of(scene, sample);
    if (const auto held = volumes_->find(path.filename()); held.account) return *held.account;
    const VdbReader file(path);
    EnergyAccount a;
    a.emitted = uint64_t(file.number("photons_emitted")),
    a.absorbed = uint64_t(file.number("photons_absorbed"));
    a.escaped = uint64_t(file.number("photons_escaped")),
    a.cut_off = uint64_t(file.number("photons_cut_off"));
    a.absorbed_flux = file.vector("flux_absorbed"), a.escaped_flux = file.vector("flux_escaped");
    a.cut_off_flux = file.vector("flux_cut_off"), a.normals_flux = file.vector("flux_normals");
    a.squared_flux = file.vector("flux_squared");
    return a;
}

void WorkFolder::update_run(const std::function<void(nlohmann::json&)>& change) const {
    const fs::path path = path_ / "run.json";
    const FileLock lock(path_ / "run.lock");
    nlohmann::json run =
        fs::exists(path) ? nlohmann::json::parse(read_text(path), nullptr, false) : nlohmann::json::object();
    if (!run.is_object()) run = nlohmann::json::object();
    change(run);
    write_text_atomically(path, run.dump(2) + "\n");
}

void WorkFolder::remove() const {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
}

}  // namespace pim
