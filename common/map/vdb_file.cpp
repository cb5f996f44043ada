// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/map/vdb_file.h"

#include <fmt/format.h>
#include <openvdb/io/File.h>
#include <openvdb/io/GridDescriptor.h>
#include <openvdb/openvdb.h>
#include <sys/mman.h>

#include <algorithm>
#include <fstream>
#include <mutex>
#include <sstream>

#include "common/core/error.h"
#include "common/core/file.h"
#include "common/core/float_traps.h"

namespace pim {
namespace {

using openvdb::FloatGrid;
using openvdb::Vec3SGrid;

// OpenVDB refuses voxels of less than 3e-15 m³; such grids are placed in micrometres.
constexpr double kSmallestVoxel = 2e-5, kMicrometre = 1e-6;
constexpr std::size_t kIdentifierStart = 21, kIdentifierLength = 36;

void initialise() {
    static const bool once = [] {
        openvdb::initialize();
        return true;
    }();
    (void)once;
}

openvdb::Coord to_coord(const Index3& c) { return {c.x, c.y, c.z}; }

openvdb::MetaMap to_openvdb(const VdbMetadata& metadata) {
    openvdb::MetaMap map;
    for (const auto& [key, value] : metadata) {
        if (const auto* text = std::get_if<std::string>(&value))
            map.insertMeta(key, openvdb::StringMetadata(*text));
        if (const auto* number = std::get_if<double>(&value))
            map.insertMeta(key, openvdb::DoubleMetadata(*number));
        if (const auto* count = std::get_if<int64_t>(&value))
            map.insertMeta(key, openvdb::Int64Metadata(*count));
        if (const auto* v = std::get_if<Vec3d>(&value))
            map.insertMeta(key, openvdb::Vec3DMetadata(openvdb::Vec3d(v->x, v->y, v->z)));
    }
    return map;
}

VdbMetadata from_openvdb(const openvdb::MetaMap& map) {
    VdbMetadata metadata;
    for (auto it = map.beginMeta(); it != map.endMeta(); ++it) {
        const openvdb::Metadata& value = *it->second;
        if (value.typeName() == "string") metadata[it->first] = map.metaValue<std::string>(it->first);
        if (value.typeName() == "double") metadata[it->first] = map.metaValue<double>(it->first);
        if (value.typeName() == "int64") metadata[it->first] = map.metaValue<int64_t>(it->first);
        if (value.typeName() == "vec3d") {
            const auto v = map.metaValue<openvdb::Vec3d>(it->first);
            metadata[it->first] = Vec3d(v.x(), v.y(), v.z());
        }
    }
    return metadata;
}

// A grid of some cells, whose values may be filled in again and again, and how a file describes its tree.
struct CellTree {
    std::vector<Index3> cells;
    int channels;
    openvdb::GridBase::Ptr grid;
    std::vector<float*> places;  // of the cells' values
    std::string topology;

    void fill(const std::vector<float>& values) {
        for (std::size_t i = 0; i < places.size(); ++i)
            std::copy_n(&values[i * std::size_t(channels)], channels, places[i]);
    }
};

// OpenVDB's own writer wants all grids of a file alive at once, and describes the tree of each; its parts,
// called in the same order, do not.
class GridStream : public openvdb::io::Archive {
  public:
    GridStream(std::ostream& stream, const openvdb::MetaMap& metadata, int32_t grid_count) : stream_(stream) {
        setCompression(openvdb::io::COMPRESS_ACTIVE_MASK |
                       (hasBloscCompression() ? openvdb::io::COMPRESS_BLOSC : openvdb::io::COMPRESS_ZIP));
        writeHeader(stream_, /*seekable=*/true);
        metadata.writeMeta(stream_);
        stream_.write(reinterpret_cast<const char*>(&grid_count), sizeof grid_count);
    }

    void describe(CellTree& tree) const {
        std::ostringstream text;
        setGridCompression(text, *tree.grid);
        text.str({});
        tree.grid->writeTopology(text);
        tree.topology = text.str();
    }

    void write_grid(const CellTree& tree) {
        std::ostringstream head, body;
        openvdb::io::GridDescriptor descriptor(tree.grid->getName(), tree.grid->type(), false);
        descriptor.writeHeader(head);
        const int64_t start = int64_t(stream_.tellp()) + int64_t(head.tellp()) + 3 * int64_t(sizeof(int64_t));
        descriptor.setGridPos(start);
        setGridCompression(body, *tree.grid);
        tree.grid->writeMeta(body);
        tree.grid->writeTransform(body);
        body << tree.topology;
        descriptor.setBlockPos(start + int64_t(body.tellp()));
        tree.grid->writeBuffers(body);
        descriptor.setEndPos(start + int64_t(body.tellp()));
        descriptor.writeStreamPos(head);
        stream_ << head.view() << body.view();
    }
    openvdb::io::Archive::Ptr copy() const override { return std::make_shared<GridStream>(*this); }

  private:
    std::ostream& stream_;
};

template <class Grid>
void build(CellTree& tree) {
    const auto grid = Grid::create();
    auto accessor = grid->getAccessor();
    for (const Index3& cell : tree.cells) accessor.setValueOn(to_coord(cell), typename Grid::ValueType(0.0f));
    for (const Index3& cell : tree.cells) {
        auto* leaf = accessor.probeLeaf(to_coord(cell));
        auto* value = leaf->buffer().data() + leaf->coordToOffset(to_coord(cell));
        tree.places.push_back(reinterpret_cast<float*>(value));
    }
    tree.grid = grid;
}

constexpr char kTrailer[] = "pim-end\n";
constexpr std::size_t kTrailerText = sizeof kTrailer - 1, kTrailerLength = kTrailerText + 8;

std::string trailer_of(uint64_t length) {
    std::string trailer(kTrailer);
    for (int byte = 0; byte < 8; ++byte) trailer += char(length >> 8 * byte & 0xff);
    return trailer;
}

void append_trailer(std::ofstream& file) {
    const std::string trailer = trailer_of(uint64_t(file.tellp()) + kTrailerLength);
    file.write(trailer.data(), std::streamsize(trailer.size()));
}

void check_trailer(const std::filesystem::path& path) {
    std::ifstream file(path, std::ios::binary);
    const uint64_t length = std::filesystem::file_size(path);
    std::string end(kTrailerLength, '\0');
    if (length >= kTrailerLength) {
        file.seekg(std::streamoff(length - kTrailerLength));
        file.read(end.data(), std::streamsize(kTrailerLength));
    }
    if (end != trailer_of(length))
        throw Error(
            fmt::format("{}: was not made by `bake`, or has been cut short; bake it again", path.string()));
}

// Overwrites OpenVDB's random identifier by a hash of all other bytes, in the same 8-4-4-4-12 form.
void identify_by_content(const std::filesystem::path& path) {
    std::fstream file(path, std::ios::binary | std::ios::in | std::ios::out);
    ContentHash hash;
    std::vector<char> block(1 << 20);
    for (bool first = true; file; first = false) {
        file.read(block.data(), std::streamsize(block.size()));
        const auto got = std::size_t(file.gcount());
        if (first && got >= kIdentifierStart + kIdentifierLength)
            std::fill_n(block.begin() + kIdentifierStart, kIdentifierLength, '0');
        hash.feed(block.data(), got);
    }
    file.clear();
    const std::string h = hash.hex();
    const std::string identifier = h.substr(0, 8) + "-" + h.substr(8, 4) + "-" + h.substr(12, 4) + "-" +
                                   h.substr(16, 4) + "-" + h.substr(20, 12);
    file.seekp(kIdentifierStart);
    file.write(identifier.data(), std::streamsize(identifier.size()));
    if (!file.flush()) throw Error(fmt::format("{}: cannot be written; is the disk full?", path.string()));
}

}  // namespace

struct VdbTrees::Implementation {
    std::mutex mutex;
    std::vector<std::unique_ptr<CellTree>> free;

    // None: all of these cells are in use, or none was ever written.
    std::unique_ptr<CellTree> take(const std::vector<Index3>& cells, int channels) {
        const std::lock_guard lock(mutex);
        const auto found = std::ranges::find_if(
            free, [&](const auto& tree) { return tree->channels == channels && tree->cells == cells; });
        if (found == free.end()) return nullptr;
        auto tree = std::move(*found);
        free.erase(found);
        return tree;
    }
    void give_back(std::unique_ptr<CellTree> tree) {
        const std::lock_guard lock(mutex);
        free.push_back(std::move(tree));
    }
};

VdbTrees::VdbTrees() : implementation_(std::make_unique<Implementation>()) {}

VdbTrees::~VdbTrees() = default;

struct VdbWriter::Implementation {
    std::filesystem::path path;
    std::ofstream file;
    openvdb::math::Transform::Ptr transform;
    std::unique_ptr<GridStream> stream;
    int missing;
    std::shared_ptr<VdbTrees> trees;

    std::unique_ptr<CellTree> tree_of(const std::vector<Index3>& cells, int channels) const {
        if (auto known = trees->implementation_->take(cells, channels)) return known;
        auto tree = std::make_unique<CellTree>(CellTree{cells, channels, {}, {}, {}});
        channels == 1 ? build<FloatGrid>(*tree) : build<Vec3SGrid>(*tree);
        stream->describe(*tree);
        return tree;
    }
};

VdbWriter::VdbWriter(const std::filesystem::path& path, const VdbMetadata& metadata,
                     const VdbTransform& transform, int grid_count, std::shared_ptr<VdbTrees> trees)
    : implementation_(std::make_unique<Implementation>()) {
    const FloatTraps library(FloatTraps::off);
    initialise();
    Implementation& i = *implementation_;
    i.path = path;
    i.missing = grid_count;
    i.trees = std::move(trees);
    i.file.open(path, std::ios::binary);
    if (!i.file) throw Error(fmt::format("{}: cannot be written", path.string()));
    const double unit = transform.voxel_size < kSmallestVoxel ? kMicrometre : 1;
    const Vec3d first = transform.first_centre / unit;
    i.transform = openvdb::math::Transform::createLinearTransform(transform.voxel_size / unit);
    i.transform->postTranslate({first.x, first.y, first.z});
    i.stream = std::make_unique<GridStream>(i.file, to_openvdb(metadata), grid_count);
}

VdbWriter::~VdbWriter() = default;

void VdbWriter::add(const std::string& name, const std::vector<Index3>& cells, const std::vector<float>& v,
                    int channels) {
    const FloatTraps library(FloatTraps::off);
    Implementation& i = *implementation_;
    auto tree = i.tree_of(cells, channels);
    tree->fill(v);
    tree->grid->setName(name);
    tree->grid->setTransform(i.transform->copy());
    i.stream->write_grid(*tree);
    i.trees->implementation_->give_back(std::move(tree));
    --i.missing;
}

void VdbWriter::finish() {
    const FloatTraps library(FloatTraps::off);
    Implementation& i = *implementation_;
    if (i.missing != 0) throw std::logic_error("VdbWriter: fewer or more grids than announced");
    append_trailer(i.file);
    i.file.close();
    if (!i.file) throw Error(fmt::format("{}: cannot be written; is the disk full?", i.path.string()));
    identify_by_content(i.path);
}

struct VdbReader::Implementation {
    std::filesystem::path path;
    std::unique_ptr<openvdb::io::File> file;
    VdbMetadata metadata;

    openvdb::GridBase::Ptr read(const std::string& name) const {
        try {
            if (file->hasGrid(name)) return file->readGrid(name);
        } catch (const std::exception& e) {
            throw Error(fmt::format("{}: the grid {} cannot be read: {}", path.string(), name, e.what()));
        }
        throw Error(fmt::format("{}: the grid {} is missing; bake it again", path.string(), name));
    }
};

VdbReader::VdbReader(const std::filesystem::path& path, Access access)
    : implementation_(std::make_unique<Implementation>()) {
    const FloatTraps library(FloatTraps::off);
    initialise();
    implementation_->path = path;
    check_input(path);
    check_trailer(path);
    try {
        implementation_->file = std::make_unique<openvdb::io::File>(path.string());
        implementation_->file->setCopyMaxBytes(0);  // map the file, however small: never copy it
        implementation_->file->open(/*delayLoad=*/access == Access::mapped);
        implementation_->metadata = from_openvdb(*implementation_->file->getMetadata());
    } catch (const std::exception& e) {
        throw Error(fmt::format("{}: is damaged: {}; bake it again", path.string(), e.what()));
    }
}

VdbReader::~VdbReader() = default;

const VdbMetadata& VdbReader::metadata() const { return implementation_->metadata; }

std::vector<std::string> VdbReader::grid_names() const {
    std::vector<std::string> names;
    for (auto it = implementation_->file->beginName(); it != implementation_->file->endName(); ++it)
        names.push_back(it.gridName());
    return names;
}

bool VdbReader::has(const std::string& name) const { return implementation_->file->hasGrid(name); }

int VdbReader::channels(const std::string& name) const {
    return implementation_->read(name)->isType<FloatGrid>() ? 1 : 3;
}

std::vector<Index3> VdbReader::active_cells(const std::string& name) const {
    const FloatTraps library(FloatTraps::off);
    std::vector<Index3> cells;
    const auto collect = [&](const auto& grid) {
        for (auto it = grid.cbeginValueOn(); it; ++it)
            cells.push_back({it.getCoord().x(), it.getCoord().y(), it.getCoord().z()});
    };
    const auto grid = implementation_->read(name);
    if (grid->isType<FloatGrid>())
        collect(static_cast<const FloatGrid&>(*grid));
    else
        collect(static_cast<const Vec3SGrid&>(*grid));
    return cells;
}

std::vector<float> VdbReader::values(const std::string& name, const std::vector<Index3>& cells,
                                     int channels) const {
    const FloatTraps library(FloatTraps::off);
    std::vector<float> values;
    values.reserve(cells.size() * channels);
    const auto grid = implementation_->read(name);
    if (grid->isType<FloatGrid>()) {
        const auto accessor = static_cast<const FloatGrid&>(*grid).getConstAccessor();
        for (const Index3& c : cells) values.insert(values.end(), channels, accessor.getValue(to_coord(c)));
    } else {
        const auto accessor = static_cast<const Vec3SGrid&>(*grid).getConstAccessor();
        for (const Index3& c : cells) {
            const openvdb::Vec3s v = accessor.getValue(to_coord(c));
            for (int i = 0; i < channels; ++i) values.push_back(v[i]);
        }
    }
    return values;
}

void VdbReader::release_pages() const {
    // OpenVDB keeps its mapping to itself: the kernel knows where it is.
    std::error_code problem;
    const std::string file = std::filesystem::canonical(implementation_->path, problem).string();
    std::ifstream maps("/proc/self/maps");
    for (std::string line; !problem && std::getline(maps, line);) {
        if (!line.ends_with(" " + file)) continue;
        std::istringstream range(line);
        uintptr_t begin = 0, end = 0;
        char dash = 0;
        if (range >> std::hex >> begin >> dash >> end)
            ::madvise(reinterpret_cast<void*>(begin), end - begin, MADV_DONTNEED);  // NOLINT: an address
    }
}

namespace {
template <class T>
T get(const VdbMetadata& metadata, const std::string& key, const std::filesystem::path& path) {
    const auto found = metadata.find(key);
    if (found == metadata.end() || !std::holds_alternative<T>(found->second))
        throw Error(fmt::format("{}: lacks '{}' in its metadata; is it a map that this program baked?",
                                path.string(), key));
    return std::get<T>(found->second);
}
}  // namespace

std::string VdbReader::text(const std::string& key) const {
    return get<std::string>(metadata(), key, implementation_->path);
}
double VdbReader::number(const std::string& key) const {
    return get<double>(metadata(), key, implementation_->path);
}
int64_t VdbReader::integer(const std::string& key) const {
    return get<int64_t>(metadata(), key, implementation_->path);
}
Vec3d VdbReader::vector(const std::string& key) const {
    return get<Vec3d>(metadata(), key, implementation_->path);
}

}  // namespace pim
