// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/map/vdb_file.h"

#include <gtest/gtest.h>
#include <sys/resource.h>

#include <algorithm>
#include <tuple>

#include "common/core/error.h"
#include "common/core/parallel.h"
#include "temporary_folder.h"

namespace pim {
namespace {

const std::vector<Index3> kCells = {{0, 0, 0}, {1, 2, 3}, {7, 8, 9}, {100, 3, 4000}};
const std::vector<float> kFloats = {1, -2, 0, 1e-20f};
const std::vector<float> kVectors = {1, 2, 3, 4, 5, 6, 0, 0, 0, -1, -2, -3};

VdbMetadata test_metadata() {
    return {{"text", std::string("two\nlines")},
            {"number", 1.0 / 3},
            {"count", int64_t{1} << 40},
            {"vector", Vec3d(1, 2, 3)}};
}

void write_test_file(const std::filesystem::path& path,
                     std::shared_ptr<VdbTrees> trees = std::make_shared<VdbTrees>()) {
    VdbWriter writer(path, test_metadata(), {{1, 2, 3}, 0.25}, 2, std::move(trees));
    writer.add("area/px", kCells, kFloats, 1);
    writer.add("lamp/b0/a19", kCells, kVectors, 3);
    writer.finish();
}

void expect_same_cells(std::vector<Index3> a, std::vector<Index3> b) {
    const auto before = [](const Index3& p, const Index3& q) {
        return std::tie(p.x, p.y, p.z) < std::tie(q.x, q.y, q.z);
    };
    std::sort(a.begin(), a.end(), before), std::sort(b.begin(), b.end(), before);
    EXPECT_EQ(a, b);
}

TEST(VdbFile, RoundTrip) {
    const TemporaryFolder folder;
    write_test_file(folder / "a.vdb");
    const VdbReader file(folder / "a.vdb");
    EXPECT_EQ(file.text("text"), "two\nlines");
    EXPECT_EQ(file.number("number"), 1.0 / 3);
    EXPECT_EQ(std::get<int64_t>(file.metadata().at("count")), int64_t{1} << 40);
    EXPECT_EQ(file.vector("vector"), Vec3d(1, 2, 3));
    EXPECT_TRUE(file.has("area/px"));
    EXPECT_FALSE(file.has("area/py"));
    EXPECT_EQ(file.grid_names().size(), 2u);
    expect_same_cells(file.active_cells("area/px"), kCells);  // zero values are active too
    EXPECT_EQ(file.values("area/px", kCells, 1), kFloats);
    EXPECT_EQ(file.values("lamp/b0/a19", kCells, 3), kVectors);
    const auto repeated = file.values("area/px", {kCells[1]}, 3);
    EXPECT_EQ(repeated, (std::vector<float>{-2, -2, -2}));
}

TEST(VdbFile, ManyCells) {
    const TemporaryFolder folder;
    std::vector<Index3> cells;
    std::vector<float> values;
    for (int x = 0; x < 40; ++x)
        for (int y = 0; y < 40; ++y)
            for (int z = 0; z < 40; ++z) {
                cells.push_back({x, y, z});
                values.push_back(float(x * 1600 + y * 40 + z));
            }
    VdbWriter writer(folder / "a.vdb", {}, {}, 1);
    writer.add("full", cells, values, 1);
    writer.finish();
    const VdbReader file(folder / "a.vdb");
    expect_same_cells(file.active_cells("full"), cells);
    EXPECT_EQ(file.values("full", cells, 1), values);
}

TEST(VdbFile, SameContentSameBytes) {
    const TemporaryFolder folder;
    write_test_file(folder / "a.vdb");
    write_test_file(folder / "b.vdb");
    EXPECT_EQ(bytes_of(folder / "a.vdb"), bytes_of(folder / "b.vdb"));
    VdbWriter writer(folder / "c.vdb", test_metadata(), {{1, 2, 3}, 0.25}, 2);
    writer.add("area/px", kCells, {1, -2, 0, 2e-20f}, 1);
    writer.add("lamp/b0/a19", kCells, kVectors, 3);
    writer.finish();
    EXPECT_NE(bytes_of(folder / "a.vdb").substr(21, 36),
              bytes_of(folder / "c.vdb").substr(21, 36));  // the identifier
}

// Of the same cells with other values, of a part of them, and several at once.
TEST(VdbFile, TreesThatAreFilledAnewHoldOnlyWhatIsNew) {
    const TemporaryFolder folder;
    const auto trees = std::make_shared<VdbTrees>();
    {
        VdbWriter writer(folder / "other.vdb", {}, {{9, 9, 9}, 2}, 3, trees);
        writer.add("other", kCells, {7, 7, 7, 7}, 1);
        writer.add("others", kCells, std::vector<float>(12, 8), 3);
        writer.add("fewer", {kCells[1]}, {6}, 1);
        writer.finish();
    }
    const auto name = [&](std::size_t i) { return folder / (std::to_string(i) + ".vdb"); };
    parallel_for(20, [&](std::size_t i) { write_test_file(name(i), trees); });
    write_test_file(folder / "alone.vdb");
    for (std::size_t i = 0; i < 20; ++i) EXPECT_EQ(bytes_of(name(i)), bytes_of(folder / "alone.vdb"));
    EXPECT_EQ(VdbReader(folder / "other.vdb").active_cells("fewer"), std::vector<Index3>{kCells[1]});
}

TEST(VdbFile, MissingGridsAndKeysAreNamed) {
    const TemporaryFolder folder;
    write_test_file(folder / "a.vdb");
    const VdbReader file(folder / "a.vdb");
    const auto names = [](const std::string& message, const std::string& what) {
        return message.find("a.vdb") != std::string::npos && message.find(what) != std::string::npos;
    };
    EXPECT_TRUE(names(message_of<Error>([&] { file.text("nothing"); }), "nothing"));
    EXPECT_TRUE(names(message_of<Error>([&] { file.number("text"); }), "text"));
    EXPECT_TRUE(names(message_of<Error>([&] { file.values("area/py", kCells, 1); }), "area/py"));
    EXPECT_TRUE(names(message_of<Error>([&] { file.active_cells("area/py"); }), "area/py"));
}

TEST(VdbFile, RefusesWhatIsNoVdb) {
    const TemporaryFolder folder;
    folder.write("text.vdb", "this is no OpenVDB file, but long enough to look like one for a while");
    folder.write("empty.vdb", "");
    EXPECT_THROW(VdbReader(folder / "text.vdb"), Error);
    EXPECT_THROW(VdbReader(folder / "empty.vdb"), Error);
    EXPECT_THROW(VdbReader(folder / "missing.vdb"), Error);
    EXPECT_THROW(VdbReader(folder.path()), Error);
    EXPECT_THROW(VdbWriter(folder / "none/a.vdb", {}, {}, 0), Error);
}

// Memory that this process may take; a broken length in a cut file must not make it ask for all there is.
// The address sanitizer needs more than any limit, and watches allocations itself.
class MemoryLimit {
  public:
    explicit MemoryLimit(rlim_t bytes) {
        ::getrlimit(RLIMIT_AS, &before_);
#ifdef __SANITIZE_ADDRESS__
        bytes = before_.rlim_cur;
#endif
        const rlimit limit{bytes, before_.rlim_max};
        ::setrlimit(RLIMIT_AS, &limit);
    }
    ~MemoryLimit() { ::setrlimit(RLIMIT_AS, &before_); }

  private:
    rlimit before_{};
};

// What reading all of the file ends with: an Error's message, or that of another exception after a "!".
std::string outcome_of_reading(const std::filesystem::path& path) {
    try {
        const VdbReader file(path);
        for (const char* grid : {"area/px", "lamp/b0/a19"}) file.values(grid, file.active_cells(grid), 3);
    } catch (const Error& e) {
        return e.what();
    } catch (const std::exception& e) {
        return std::string("!") + e.what();
    }
    return "!read";
}

// Cut anywhere, a file must be refused with an Error when it is opened or read, never crash or run out of
// memory.
TEST(VdbFile, TruncatedFilesAreErrors) {
    const TemporaryFolder folder;
    write_test_file(folder / "a.vdb");
    const std::string bytes = bytes_of(folder / "a.vdb");
    const MemoryLimit limit(rlim_t{2} << 30);
    for (std::size_t length = 0; length < bytes.size();
         length += length < 1000 ? 37 : 1 + bytes.size() / 60) {
        folder.write("cut.vdb", bytes.substr(0, length));
        const std::string outcome = outcome_of_reading(folder / "cut.vdb");
        EXPECT_EQ(outcome.find("!"), std::string::npos)
            << length << " of " << bytes.size() << ": " << outcome;
        EXPECT_EQ(outcome.find("bad_alloc"), std::string::npos)
            << length << " of " << bytes.size() << ": " << outcome;
    }
}

}  // namespace
}  // namespace pim
