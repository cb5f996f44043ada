// SPDX-License-Identifier: GPL-3.0-or-later
// A baked map on disk: docs/format.md says what stands where.
#pragma once

#include <filesystem>
#include <functional>

#include "common/map/illumination_map.h"
#include "common/map/vdb_file.h"

namespace pim {

inline constexpr int kFormatVersion = 4;

// Atomic; same map, same bytes. Throws Error.
void write_map(const std::filesystem::path& path, const IlluminationMap& map);

// Patches of each slot: their numbers and cells, in the order of the patches.
struct SlotCells {
    std::vector<uint32_t> patches;
    std::vector<Index3> cells;
};
std::array<SlotCells, kSlotCount> cells_by_slot(const std::vector<Patch>& patches);

// A map that stays on disk, mapped into memory; polynomials are read box by box.
class MapFile {
  public:
    // Throws Error: no map, another format version, grids missing.
    explicit MapFile(const std::filesystem::path& path);
    // All but the polynomials, which are empty.
    const IlluminationMap& outline() const { return outline_; }
    const std::vector<int>& terms(std::size_t light, std::size_t box) const { return terms_[light][box]; }
    // Calls visit for each grid of one box's polynomials: the place of its term among terms(), the patches
    // that it holds and their values, `channels` each. Terms that are all zero are left out. Throws Error:
    // damaged, or overwritten in place since it was opened.
    using TermVisitor = std::function<void(std::size_t term, const std::vector<uint32_t>& patches,
                                           const std::vector<float>& values)>;
    void read_terms(std::size_t light, std::size_t box, Component component, int channels,
                    const TermVisitor& visit) const;
    std::vector<float> residuals(std::size_t light, std::size_t box, Component component) const;  // [patch]
    std::vector<uint8_t> status(std::size_t light, std::size_t box, Component component) const;   // [patch]
    Polynomials polynomials(std::size_t light, std::size_t box, Component component) const;
    void release_pages() const { file_.release_pages(); }  // see VdbReader
    // Is another file there now? One that was renamed to its place does no harm: this one stays readable.
    enum class Change { none, replaced, overwritten };
    Change change() const;

  private:
    struct Stamp {
        uint64_t inode = 0, bytes = 0;
        int64_t seconds = 0, nanoseconds = 0;
        bool operator==(const Stamp&) const = default;
    };
    // Keeps the file that was opened, whatever becomes of its name.
    struct Descriptor {
        int number;
        explicit Descriptor(const std::filesystem::path& path);
        ~Descriptor();
        Descriptor(const Descriptor&) = delete;
        Descriptor& operator=(const Descriptor&) = delete;
    };
    Stamp stamp_of_opened() const;
    void check_unchanged() const;
    enum class Missing { fails, is_zero };
    std::vector<float> patch_values(std::size_t light, std::size_t box, Component component, const char* grid,
                                    Missing missing) const;
    template <class Visit>
    void for_each_slot(std::size_t light, std::size_t box, Component component, Visit visit) const;

    std::filesystem::path path_;
    Descriptor opened_;
    Stamp stamp_;
    VdbReader file_;
    IlluminationMap outline_;
    std::array<SlotCells, kSlotCount> slots_;
    std::vector<std::vector<std::vector<int>>> terms_;  // [light][box]
};

// The whole map. Throws Error as MapFile does.
IlluminationMap read_map(const std::filesystem::path& path);

// Patches of a grid as they stand in maps and in work folders: grids area/<facing> and centre/<facing>.
using PatchGridVisitor = std::function<void(const std::string& name, const std::vector<Index3>& cells,
                                            const std::vector<float>& values, int channels)>;
void write_patches(const std::vector<Patch>& patches, const CellGrid& grid, const PatchGridVisitor& write);
std::vector<Patch> read_patches(const VdbReader& file, const CellGrid& grid);  // sorted by patch_before

// What parts of patches see, likewise: grids unseen/<facing>, a voxel for each fine cell.
void write_sight(const PatchSight& sight, const std::vector<Patch>& patches, const CellGrid& grid,
                 const PatchGridVisitor& write);
// `index`: of the grid's patches, `count` in all.
PatchSight read_sight(const VdbReader& file, const CellGrid& grid, const PatchIndex& index,
                      std::size_t count);

// World-space transform of a cell grid's centres.
VdbTransform transform_of(const CellGrid& grid, const Vec3d& origin);

}  // namespace pim
