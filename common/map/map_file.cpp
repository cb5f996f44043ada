// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/map/map_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <pim_version.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <set>

#include "common/core/error.h"
#include "common/core/file.h"

namespace pim {
namespace {

std::string term_grid(const std::string& stem, int term) { return fmt::format("{}/a{:02}", stem, term); }

std::string stem_of(const std::string& light, std::size_t box, Component component,
                    const std::string& facing) {
    return fmt::format("{}/b{}/{}/{}", light, box, name(component), facing);
}

struct GridToWrite {
    std::string name;
    std::vector<float> values;
    int channels;
};

// Values of one term at the patches of one facing.
GridToWrite term_values(const IlluminationMap& map, const std::string& grid_name, const Polynomials& p,
                        std::size_t term_place, const SlotCells& facing) {
    GridToWrite grid{grid_name, {}, map.grey ? 1 : 3};
    for (const uint32_t patch : facing.patches)
        for (int c = 0; c < grid.channels; ++c)
            grid.values.push_back(p.coefficients[(patch * p.terms.size() + term_place) * 3 + c]);
    return grid;
}

bool all_zero(const std::vector<float>& values) {
    return std::ranges::all_of(values, [](float v) { return v == 0; });
}

// Calls visit for every grid that is written of a map, in order.
void for_each_grid(const IlluminationMap& map, const PatchGridVisitor& visit) {
    write_patches(map.patches, map.grid, visit);
    write_sight(map.sight, map.patches, map.grid, visit);
    const auto facings = cells_by_slot(map.patches);
    for (int f = 0; f < kSlotCount; ++f) {
        if (facings[f].cells.empty()) continue;
        const std::string facing = slot_name(map.grid, f);
        for (const MapLight& light : map.lights)
            for (std::size_t b = 0; b < light.boxes.size(); ++b)
                for (const Component component : map.components) {
                    const Polynomials& p = *light.polynomials[b][int(component)];
                    const std::string stem = stem_of(light.name, b, component, facing);
                    for (std::size_t t = 0; t < p.terms.size(); ++t) {
                        const GridToWrite grid =
                            term_values(map, term_grid(stem, p.terms[t]), p, t, facings[f]);
                        if (p.terms[t] == kConstantTerm || !all_zero(grid.values))
                            visit(grid.name, facings[f].cells, grid.values, grid.channels);
                    }
                    GridToWrite residual{stem + "/residual", {}, 1}, status{stem + "/status", {}, 1};
                    for (const uint32_t patch : facings[f].patches) {
                        residual.values.push_back(p.residuals[patch]);
                        status.values.push_back(p.status.empty() ? 0 : float(p.status[patch]));
                    }
                    visit(residual.name, facings[f].cells, residual.values, residual.channels);
                    if (!all_zero(status.values))
                        visit(status.name, facings[f].cells, status.values, status.channels);
                }
    }
}

std::string join(const std::vector<std::string>& lines) {
    std::string text;
    for (const std::string& line : lines) text += line + "\n";
    return text;
}

std::vector<std::string> split(const std::string& text) {
    std::vector<std::string> lines;
    for (std::size_t start = 0; start < text.size();) {
        const std::size_t end = text.find('\n', start);
        lines.push_back(text.substr(start, end - start));
        start = end == std::string::npos ? text.size() : end + 1;
    }
    return lines;
}

std::string names_of(const std::vector<int>& terms) {
    std::string names;
    for (const int term : terms) names += fmt::format("a{:02}\n", term);
    return names;
}

std::vector<int> terms_named(const std::string& names) {
    std::vector<int> terms;
    for (const std::string& name : split(names)) terms.push_back(std::stoi(name.substr(1)));
    return terms;
}

VdbMetadata metadata_of(const IlluminationMap& map, const std::vector<std::string>& grids) {
    VdbMetadata m;
    m["format_version"] = int64_t{kFormatVersion};
    m["program_version"] = std::string(kVersion);
    m["scene"] = map.description;
    m["geometry"] = map.geometry_path;
    m["geometry_hash"] = map.geometry_hash;
    m["origin"] = map.origin;
    m["grid_corner"] = map.grid.origin + map.origin;
    m["grid_local_corner"] = map.grid.origin;
    m["grid_cell_size"] = map.grid.cell_size;
    m["grid_size"] = Vec3d(map.grid.size);
    m["grid_facings"] = int64_t{map.grid.facings};
    m["grey"] = int64_t{map.grey};
    m["mend_signs"] = int64_t{map.mend_signs};
    std::vector<std::string> components, lights;
    for (const Component c : map.components) components.push_back(name(c));
    for (const MapLight& light : map.lights) {
        lights.push_back(light.name);
        const std::string key = "light/" + light.name + "/";
        m[key + "type"] = light.type;
        m[key + "power"] = Vec3d(light.power);
        m[key + "domain_min"] = Vec3d(light.domain.min);
        m[key + "domain_max"] = Vec3d(light.domain.max);
        m[key + "boxes"] = double(light.boxes.size());
        for (std::size_t b = 0; b < light.boxes.size(); ++b) {
            const std::string box_key = fmt::format("{}b{}/", key, b);
            m[box_key + "centre"] = light.boxes[b].centre;
            m[box_key + "half"] = light.boxes[b].half;
            m[box_key + "overlap_low"] = light.boxes[b].overlap_low;
            m[box_key + "overlap_high"] = light.boxes[b].overlap_high;
            m[box_key + "samples"] = double(light.fits[b].samples);
            m[box_key + "rank"] = double(light.fits[b].rank);
            m[box_key + "condition_number"] = light.fits[b].condition_number;
            m[box_key + "raw_condition_number"] = light.fits[b].raw_condition_number;
            m[box_key + "robust_iterations"] = double(light.fits[b].iterations);
            m[box_key + "dropped"] = names_of(light.fits[b].dropped);
            m[box_key + "terms"] = names_of(light.polynomials[b][int(map.components[0])]->terms);
        }
    }
    m["components"] = join(components);
    m["lights"] = join(lights);
    m["grids"] = join(grids);
    m["left_out"] = join(map.left_out);
    return m;
}

MapBox read_box(const VdbReader& file, const std::string& key) {
    return {file.vector(key + "centre"), file.vector(key + "half"), file.vector(key + "overlap_low"),
            file.vector(key + "overlap_high")};
}

MapLight read_light(const VdbReader& file, const std::string& light_name) {
    const std::string key = "light/" + light_name + "/";
    MapLight light;
    light.name = light_name;
    light.type = file.text(key + "type");
    light.power = Rgb(file.vector(key + "power"));
    light.domain = Box3(Vec3(file.vector(key + "domain_min")), Vec3(file.vector(key + "domain_max")));
    for (std::size_t b = 0; b < std::size_t(file.number(key + "boxes")); ++b) {
        const std::string box_key = fmt::format("{}b{}/", key, b);
        light.boxes.push_back(read_box(file, box_key));
        light.fits.push_back(
            {int(file.number(box_key + "samples")), int(file.number(box_key + "rank")),
             file.number(box_key + "condition_number"), file.number(box_key + "raw_condition_number"),
             terms_named(file.text(box_key + "dropped")), int(file.number(box_key + "robust_iterations"))});
        light.polynomials.emplace_back();
    }
    return light;
}

std::vector<int> listed_terms(const VdbReader& file, const std::string& light, std::size_t box) {
    return terms_named(file.text(fmt::format("light/{}/b{}/terms", light, box)));
}

void check_complete(const VdbReader& file, const std::filesystem::path& path) {
    if (!file.metadata().contains("format_version"))
        throw Error(fmt::format("{}: is no map; give the file that `bake run` wrote", path.string()));
    if (file.integer("format_version") != kFormatVersion)
        throw Error(fmt::format("{}: has format version {}, this program reads {}; bake it again",
                                path.string(), file.integer("format_version"), kFormatVersion));
    for (const std::string& grid : split(file.text("grids")))
        if (!file.has(grid))
            throw Error(fmt::format("{}: the grid {} is missing; bake it again", path.string(), grid));
}

}  // namespace

std::array<SlotCells, kSlotCount> cells_by_slot(const std::vector<Patch>& patches) {
    std::array<SlotCells, kSlotCount> facings;
    for (uint32_t p = 0; p < patches.size(); ++p) {
        facings[patches[p].slot].patches.push_back(p);
        facings[patches[p].slot].cells.push_back(patches[p].cell);
    }
    return facings;
}

std::vector<Patch> read_patches(const VdbReader& file, const CellGrid& grid) {
    std::vector<Patch> patches;
    for (int f = 0; f < (grid.facings ? kSlotCount : 1); ++f) {
        const std::string area = "area/" + slot_name(grid, f);
        if (!file.has(area)) continue;
        const auto cells = file.active_cells(area);
        const auto areas = file.values(area, cells, 1);
        const auto centres = file.values("centre/" + slot_name(grid, f), cells, 3);
        for (std::size_t i = 0; i < cells.size(); ++i)
            patches.push_back(
                {cells[i], f, areas[i], {centres[3 * i], centres[3 * i + 1], centres[3 * i + 2]}});
    }
    std::ranges::sort(patches, patch_before);
    return patches;
}

void write_patches(const std::vector<Patch>& patches, const CellGrid& grid, const PatchGridVisitor& write) {
    const auto facings = cells_by_slot(patches);
    for (int f = 0; f < kSlotCount; ++f) {
        if (facings[f].cells.empty()) continue;
        std::vector<float> areas, centres;
        for (const uint32_t p : facings[f].patches) {
            areas.push_back(patches[p].area);
            centres.insert(centres.end(), {patches[p].centre.x, patches[p].centre.y, patches[p].centre.z});
        }
        write("area/" + slot_name(grid, f), facings[f].cells, areas, 1);
        write("centre/" + slot_name(grid, f), facings[f].cells, centres, 3);
    }
}

void write_sight(const PatchSight& sight, const std::vector<Patch>& patches, const CellGrid& grid,
                 const PatchGridVisitor& write) {
    std::array<std::vector<Index3>, kSlotCount> voxels;
    std::array<std::vector<float>, kSlotCount> values;
    for (const PatchSight::Entry& e : sight.entries()) {
        const Patch& patch = patches[e.patch];
        const Index3 fine(e.part & 3, e.part >> 2 & 3, e.part >> 4);
        voxels[std::size_t(patch.slot)].push_back(patch.cell * kFinePerCell + fine);
        values[std::size_t(patch.slot)].push_back(float(e.unseen));
    }
    for (int s = 0; s < kSlotCount; ++s)
        if (!voxels[std::size_t(s)].empty())
            write("unseen/" + slot_name(grid, s), voxels[std::size_t(s)], values[std::size_t(s)], 1);
}

PatchSight read_sight(const VdbReader& file, const CellGrid& grid, const PatchIndex& index,
                      std::size_t count) {
    std::vector<PatchSight::Entry> entries;
    for (int s = 0; grid.facings && s < kSlotCount; ++s) {
        const std::string name = "unseen/" + slot_name(grid, s);
        if (!file.has(name)) continue;
        const auto voxels = file.active_cells(name);
        const auto values = file.values(name, voxels, 1);
        for (std::size_t i = 0; i < voxels.size(); ++i) {
            const Index3 cell = cell_of_fine(voxels[i]), fine = voxels[i] - cell * kFinePerCell;
            const int patch = index.find(cell, s);
            if (patch >= 0)
                entries.push_back({uint32_t(patch), fine.x + 4 * fine.y + 16 * fine.z, Unseen(values[i])});
        }
    }
    return {count, std::move(entries)};
}

VdbTransform transform_of(const CellGrid& grid, const Vec3d& origin) {
    return {origin + grid.centre({0, 0, 0}), grid.cell_size};
}

void write_map(const std::filesystem::path& path, const IlluminationMap& map) {
    std::vector<std::string> grids;
    for_each_grid(map,
                  [&](const std::string& grid, const auto&, const auto&, int) { grids.push_back(grid); });
    write_atomically(path, [&](const std::filesystem::path& temporary) {
        VdbWriter writer(temporary, metadata_of(map, grids), transform_of(map.grid, map.origin),
                         int(grids.size()));
        for_each_grid(map, [&](const auto& grid, const auto& cells, const auto& values, int channels) {
            writer.add(grid, cells, values, channels);
        });
        writer.finish();
    });
}

MapFile::Descriptor::Descriptor(const std::filesystem::path& path)
    : number(::open(path.c_str(), O_RDONLY | O_CLOEXEC)) {}

MapFile::Descriptor::~Descriptor() {
    if (number >= 0) ::close(number);
}

MapFile::Stamp MapFile::stamp_of_opened() const {
    struct stat s {};
    if (::fstat(opened_.number, &s) != 0) return {};
    return {s.st_ino, uint64_t(s.st_size), s.st_mtim.tv_sec, s.st_mtim.tv_nsec};
}

MapFile::MapFile(const std::filesystem::path& path)
    : path_(path), opened_(path), stamp_(stamp_of_opened()), file_(path) {
    check_complete(file_, path);
    IlluminationMap& map = outline_;
    map.origin = file_.vector("origin");
    map.grid.origin = file_.vector("grid_local_corner");
    map.grid.cell_size = file_.number("grid_cell_size");
    map.grid.size = Index3(file_.vector("grid_size"));
    map.grid.facings = file_.integer("grid_facings") != 0;
    map.grey = file_.integer("grey") != 0;
    map.mend_signs = file_.integer("mend_signs") != 0;
    map.description = file_.text("scene");
    map.geometry_path = file_.text("geometry");
    map.geometry_hash = file_.text("geometry_hash");
    map.left_out = split(file_.text("left_out"));
    for (const std::string& component : split(file_.text("components")))
        map.components.push_back(component == name(Component::direct) ? Component::direct
                                                                      : Component::indirect);
    map.patches = read_patches(file_, map.grid);
    map.index = PatchIndex(map.grid, map.patches);
    map.sight = read_sight(file_, map.grid, map.index, map.patches.size());
    slots_ = cells_by_slot(map.patches);
    for (const std::string& light : split(file_.text("lights"))) {
        map.lights.push_back(read_light(file_, light));
        auto& terms = terms_.emplace_back();
        for (std::size_t b = 0; b < map.lights.back().boxes.size(); ++b)
            terms.push_back(listed_terms(file_, light, b));
    }
    release_pages();
}

void MapFile::check_unchanged() const {
    if (change() == Change::overwritten)
        throw Error(fmt::format("{}: was overwritten while it was open; open it again", path_.string()));
}

// Calls visit(slot, stem of its grids) for the slots that have patches.
template <class Visit>
void MapFile::for_each_slot(std::size_t light, std::size_t box, Component component, Visit visit) const {
    check_unchanged();
    for (int s = 0; s < kSlotCount; ++s)
        if (!slots_[s].cells.empty())
            visit(slots_[s],
                  stem_of(outline_.lights[light].name, box, component, slot_name(outline_.grid, s)));
}

void MapFile::read_terms(std::size_t light, std::size_t box, Component component, int channels,
                         const TermVisitor& visit) const {
    for_each_slot(light, box, component, [&](const SlotCells& slot, const std::string& stem) {
        for (std::size_t t = 0; t < terms(light, box).size(); ++t) {
            const std::string grid = term_grid(stem, terms(light, box)[t]);
            if (file_.has(grid)) visit(t, slot.patches, file_.values(grid, slot.cells, channels));
        }
    });
}

std::vector<float> MapFile::patch_values(std::size_t light, std::size_t box, Component component,
                                         const char* grid, Missing missing) const {
    std::vector<float> all(outline_.patches.size());
    for_each_slot(light, box, component, [&](const SlotCells& slot, const std::string& stem) {
        const std::string grid_name = fmt::format("{}/{}", stem, grid);
        if (missing == Missing::is_zero && !file_.has(grid_name)) return;
        const auto values = file_.values(grid_name, slot.cells, 1);
        for (std::size_t i = 0; i < values.size(); ++i) all[slot.patches[i]] = values[i];
    });
    return all;
}

std::vector<float> MapFile::residuals(std::size_t light, std::size_t box, Component component) const {
    return patch_values(light, box, component, "residual", Missing::fails);
}

std::vector<uint8_t> MapFile::status(std::size_t light, std::size_t box, Component component) const {
    const auto values = patch_values(light, box, component, "status", Missing::is_zero);
    return {values.begin(), values.end()};
}

Polynomials MapFile::polynomials(std::size_t light, std::size_t box, Component component) const {
    const std::size_t count = terms(light, box).size();
    Polynomials p{terms(light, box), {}, residuals(light, box, component), status(light, box, component)};
    p.coefficients.resize(outline_.patches.size() * count * 3);
    read_terms(light, box, component, 3,
               [&](std::size_t t, const std::vector<uint32_t>& patches, const std::vector<float>& values) {
                   for (std::size_t i = 0; i < patches.size(); ++i)
                       std::copy_n(&values[3 * i], 3, &p.coefficients[(patches[i] * count + t) * 3]);
               });
    return p;
}

MapFile::Change MapFile::change() const {
    if (stamp_of_opened() != stamp_) return Change::overwritten;
    struct stat named {};
    const bool same = ::stat(path_.c_str(), &named) == 0 && named.st_ino == stamp_.inode;
    return same ? Change::none : Change::replaced;
}

IlluminationMap read_map(const std::filesystem::path& path) {
    const MapFile file(path);
    IlluminationMap map = file.outline();
    for (std::size_t l = 0; l < map.lights.size(); ++l)
        for (std::size_t b = 0; b < map.lights[l].boxes.size(); ++b)
            for (const Component c : map.components)
                map.lights[l].polynomials[b][int(c)] = file.polynomials(l, b, c);
    return map;
}

}  // namespace pim
