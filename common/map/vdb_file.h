// SPDX-License-Identifier: GPL-3.0-or-later
// OpenVDB files, grid after grid: the one place that knows OpenVDB. Grids are written one at a time: memory
// holds a tree for each set of cells, and not all grids.
#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <variant>
#include <vector>

#include "common/core/vector.h"

namespace pim {

using VdbMetadata = std::map<std::string, std::variant<std::string, double, int64_t, Vec3d>>;

// Where voxels stand: the centre of voxel (0,0,0) in world space and the distance of centres, m. Grids of
// voxels smaller than 20 µm say it in micrometres.
struct VdbTransform {
    Vec3d first_centre{0};
    double voxel_size = 1;
};

// Trees of grids that were written, filled anew for other grids of the same cells: to build and to describe a
// tree takes longer than its values do. Writers in several threads may share them.
class VdbTrees {
  public:
    VdbTrees();
    ~VdbTrees();

  private:
    friend class VdbWriter;
    struct Implementation;
    std::unique_ptr<Implementation> implementation_;
};

class VdbWriter {
  public:
    // Throws Error. `grid_count` grids must follow. Same content, same bytes: the file's identifier is a
    // hash.
    VdbWriter(const std::filesystem::path& path, const VdbMetadata& metadata, const VdbTransform& transform,
              int grid_count, std::shared_ptr<VdbTrees> trees = std::make_shared<VdbTrees>());
    ~VdbWriter();
    // One value per cell, `channels` 1 (float) or 3 (Vec3s) numbers each, laid out cell by cell; those cells
    // are active, no others.
    void add(const std::string& name, const std::vector<Index3>& cells, const std::vector<float>& values,
             int channels);
    void finish();  // throws Error, for example when the disk is full

  private:
    struct Implementation;
    std::unique_ptr<Implementation> implementation_;
};

// Files end with a trailer, which OpenVDB does not read: "pim-end\n" and the file's length as 8 bytes, least
// first. A file that was cut short, or that another program wrote, lacks it.
class VdbReader {
  public:
    // How values come in: from the file mapped into memory, as they are asked for; or a grid at once, which
    // is faster where all of them are needed.
    enum class Access { mapped, whole_grids };
    explicit VdbReader(const std::filesystem::path& path,
                       Access access = Access::mapped);  // throws Error: missing, not ours, cut short
    ~VdbReader();
    const VdbMetadata& metadata() const;
    std::vector<std::string> grid_names() const;
    bool has(const std::string& name) const;
    int channels(const std::string& name) const;                      // 1 or 3; throws Error
    std::vector<Index3> active_cells(const std::string& name) const;  // throws Error: no such grid
    // Values at the cells, one after the other, as 3 channels where `channels` is 3 (a float grid repeats its
    // value). Throws Error: no such grid, or it cannot be read.
    std::vector<float> values(const std::string& name, const std::vector<Index3>& cells, int channels) const;

    // Gives the pages of the mapped file that have been read back to the system; reading goes on as before.
    void release_pages() const;

    // Typed metadata; throws Error naming the file and the key.
    std::string text(const std::string& key) const;
    double number(const std::string& key) const;
    int64_t integer(const std::string& key) const;
    Vec3d vector(const std::string& key) const;

  private:
    struct Implementation;
    std::unique_ptr<Implementation> implementation_;
};

}  // namespace pim
