// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/map/map_file.h"

#include <gtest/gtest.h>

#include <set>

#include "common/core/error.h"
#include "common/core/random.h"
#include "temporary_folder.h"

namespace pim {
namespace {

Polynomials random_polynomials(const IlluminationMap& map, const std::vector<int>& terms, uint64_t stream) {
    RandomStream random(1, RandomPurpose::evaluation, 0, stream);
    Polynomials p{terms, {}, {}};
    for (std::size_t patch = 0; patch < map.patches.size(); ++patch) {
        p.residuals.push_back(random.next());
        for (std::size_t t = 0; t < terms.size(); ++t) {
            const float red = random.next() - 0.5f;
            for (int c = 0; c < 3; ++c)
                p.coefficients.push_back(map.grey || c == 0 ? red : random.next() - 0.5f);
        }
    }
    return p;
}

// Two lamps, one moving in two boxes, one still; patches in both layers.
IlluminationMap test_map(bool grey) {
    IlluminationMap map;
    map.grid = {Vec3d(-1, 0.5, 0), 0.1, Index3(20, 10, 5), true};
    map.grey = grey;
    for (const Index3& cell : {Index3(0), Index3(3, 2, 1), Index3(3, 2, 4), Index3(19, 9, 4)})
        for (const int slot : {0, 3, 5 + kFacingCount})
            map.patches.push_back(
                {cell, slot, 0.01f * float(slot + 1), Vec3(0.01f, -0.02f, float(slot) * 1e-3f)});
    map.index = PatchIndex(map.grid, map.patches);
    map.components = {Component::direct, Component::indirect};
    map.description = "[scene]\ngeometry = \"x.glb\"\n";
    map.geometry_path = "../x.glb";
    map.geometry_hash = "0123456789abcdef";
    map.left_out = {"nothing of note", "two lines"};
    uint64_t stream = 0;
    for (const auto& [name, domain, boxes] :
         {std::tuple("roaming", Box3(Vec3(0), Vec3(1, 2, 3)), Index3(2, 1, 1)),
          std::tuple("still", Box3(Vec3(0.5f)), Index3(1))}) {
        MapLight light;
        light.name = name;
        light.domain = domain;
        light.boxes = split_domain(domain, boxes);
        const auto terms = terms_of(3, light.boxes[0].moves());
        for (std::size_t b = 0; b < light.boxes.size(); ++b) {
            light.fits.push_back({40, int(terms.size()), 1.5 + double(b), 1e6, {3, 7}, 5});
            auto& polynomials = light.polynomials.emplace_back();
            for (const Component c : map.components)
                polynomials[int(c)] = random_polynomials(map, terms, ++stream);
        }
        map.lights.push_back(light);
    }
    return map;
}

void expect_same_polynomials(const Polynomials& a, const Polynomials& b) {
    EXPECT_EQ(a.terms, b.terms);
    EXPECT_EQ(a.coefficients, b.coefficients);
    EXPECT_EQ(a.residuals, b.residuals);
}

void expect_same_map(const IlluminationMap& a, const IlluminationMap& b) {
    EXPECT_EQ(a.grid.origin, b.grid.origin);
    EXPECT_EQ(a.grid.cell_size, b.grid.cell_size);
    EXPECT_EQ(a.grid.size, b.grid.size);
    EXPECT_EQ(a.grid.facings, b.grid.facings);
    EXPECT_EQ(a.grey, b.grey);
    EXPECT_EQ(a.components, b.components);
    EXPECT_EQ(a.description, b.description);
    EXPECT_EQ(a.geometry_path, b.geometry_path);
    EXPECT_EQ(a.geometry_hash, b.geometry_hash);
    EXPECT_EQ(a.left_out, b.left_out);
    ASSERT_EQ(a.patches.size(), b.patches.size());
    for (std::size_t p = 0; p < a.patches.size(); ++p) {
        EXPECT_EQ(a.patches[p].cell, b.patches[p].cell);
        EXPECT_EQ(a.patches[p].slot, b.patches[p].slot);
        EXPECT_EQ(a.patches[p].area, b.patches[p].area);
        EXPECT_EQ(a.patches[p].centre, b.patches[p].centre);
        EXPECT_EQ(b.index.find(a.patches[p].cell, a.patches[p].slot), int(p));
    }
    ASSERT_EQ(a.lights.size(), b.lights.size());
    for (std::size_t l = 0; l < a.lights.size(); ++l) {
        EXPECT_EQ(a.lights[l].name, b.lights[l].name);
        EXPECT_EQ(a.lights[l].domain.min, b.lights[l].domain.min);
        EXPECT_EQ(a.lights[l].domain.max, b.lights[l].domain.max);
        ASSERT_EQ(a.lights[l].boxes.size(), b.lights[l].boxes.size());
        for (std::size_t i = 0; i < a.lights[l].boxes.size(); ++i) {
            EXPECT_EQ(a.lights[l].boxes[i].centre, b.lights[l].boxes[i].centre);
            EXPECT_EQ(a.lights[l].boxes[i].half, b.lights[l].boxes[i].half);
            EXPECT_EQ(a.lights[l].boxes[i].overlap_high, b.lights[l].boxes[i].overlap_high);
            EXPECT_EQ(a.lights[l].fits[i].samples, b.lights[l].fits[i].samples);
            EXPECT_EQ(a.lights[l].fits[i].condition_number, b.lights[l].fits[i].condition_number);
            for (const Component c : a.components)
                expect_same_polynomials(*a.lights[l].polynomials[i][int(c)],
                                        *b.lights[l].polynomials[i][int(c)]);
        }
    }
}

TEST(MapFile, RoundTrip) {
    const TemporaryFolder folder;
    for (const bool grey : {false, true}) {
        const IlluminationMap map = test_map(grey);
        write_map(folder / "a.vdb", map);
        expect_same_map(map, read_map(folder / "a.vdb"));
    }
}

TEST(MapFile, GridsAreNamedAsInTheContract) {
    const TemporaryFolder folder;
    write_map(folder / "a.vdb", test_map(false));
    const VdbReader file(folder / "a.vdb");
    for (const char* name : {"area/px", "area/ny", "roaming/b0/direct/px/a00", "roaming/b1/indirect/ny/a19",
                             "still/b0/indirect/px/a19", "roaming/b0/direct/px/residual"})
        EXPECT_TRUE(file.has(name)) << name;
    EXPECT_FALSE(file.has("still/b0/indirect/px/a00"));  // a still lamp has one term
}

// Grids of zeros need not be written, but for a19.
TEST(MapFile, ZeroGridsAreLeftOutAndComeBack) {
    const TemporaryFolder folder;
    IlluminationMap map = test_map(false);
    Polynomials& p = *map.lights[0].polynomials[0][0];
    for (std::size_t i = 0; i < p.coefficients.size(); ++i)
        if (const int term = p.terms[i / 3 % p.terms.size()]; term == 4 || term == kConstantTerm)
            p.coefficients[i] = 0;
    write_map(folder / "a.vdb", map);
    const VdbReader file(folder / "a.vdb");
    EXPECT_FALSE(file.has("roaming/b0/direct/px/a04"));
    EXPECT_TRUE(file.has("roaming/b0/direct/px/a19"));
    expect_same_map(map, read_map(folder / "a.vdb"));
}

TEST(MapFile, SameMapSameBytes) {
    const TemporaryFolder folder;
    IlluminationMap map = test_map(false);
    map.origin = Vec3d(1, 2, 3);
    write_map(folder / "a.vdb", map);
    write_map(folder / "b.vdb", map);
    EXPECT_EQ(bytes_of(folder / "a.vdb"), bytes_of(folder / "b.vdb"));
}

// The same file again, grid by grid, with other metadata and without one grid.
void rewrite(const std::filesystem::path& from, const std::filesystem::path& to, const VdbMetadata& metadata,
             const std::string& without) {
    const VdbReader file(from);
    auto names = file.grid_names();
    std::erase(names, without);
    VdbWriter writer(to, metadata, {}, int(names.size()));
    for (const std::string& name : names) {
        const auto cells = file.active_cells(name);
        writer.add(name, cells, file.values(name, cells, 3), 3);
    }
    writer.finish();
}

TEST(MapFile, MissingGridIsRefusedByName) {
    const TemporaryFolder folder;
    write_map(folder / "a.vdb", test_map(false));
    const VdbMetadata metadata = VdbReader(folder / "a.vdb").metadata();
    for (const std::string grid : {"area/ny", "roaming/b1/indirect/ny/a07", "still/b0/direct/px/residual"}) {
        rewrite(folder / "a.vdb", folder / "cut.vdb", metadata, grid);
        const std::string message = message_of<Error>([&] { read_map(folder / "cut.vdb"); });
        EXPECT_NE(message.find(grid), std::string::npos) << grid << ": " << message;
        EXPECT_NE(message.find("cut.vdb"), std::string::npos) << message;
    }
}

TEST(MapFile, WhatPatchesSeeComesBack) {
    const TemporaryFolder folder;
    IlluminationMap map = test_map(false);
    ASSERT_GE(map.patches.size(), 2u);
    map.sight = PatchSight(map.patches.size(), {{0, 0, 0xffff}, {0, 9, 0}, {1, 63, 0x0102}});
    write_map(folder / "a.vdb", map);
    const auto given = map.sight.entries(), read = read_map(folder / "a.vdb").sight.entries();
    ASSERT_EQ(read.size(), given.size());
    for (std::size_t i = 0; i < given.size(); ++i) {
        EXPECT_EQ(read[i].patch, given[i].patch);
        EXPECT_EQ(read[i].part, given[i].part);
        EXPECT_EQ(read[i].unseen, given[i].unseen);
    }
}

TEST(MapFile, OtherVersionsAreRefused) {
    const TemporaryFolder folder;
    write_map(folder / "a.vdb", test_map(false));
    VdbMetadata metadata = VdbReader(folder / "a.vdb").metadata();
    metadata["format_version"] = int64_t{kFormatVersion + 1};
    rewrite(folder / "a.vdb", folder / "new.vdb", metadata, "");
    EXPECT_NE(message_of<Error>([&] { read_map(folder / "new.vdb"); }).find("version"), std::string::npos);
    metadata["format_version"] = std::string("one");  // of another type
    rewrite(folder / "a.vdb", folder / "odd.vdb", metadata, "");
    EXPECT_THROW(read_map(folder / "odd.vdb"), Error);
    metadata.erase("format_version");
    rewrite(folder / "a.vdb", folder / "none.vdb", metadata, "");
    EXPECT_THROW(read_map(folder / "none.vdb"), Error);
}

TEST(MapFile, EveryMissingKeyIsAnError) {
    const TemporaryFolder folder;
    IlluminationMap map = test_map(false);
    map.lights.erase(map.lights.begin());  // fewer grids: faster
    write_map(folder / "a.vdb", map);
    const VdbMetadata metadata = VdbReader(folder / "a.vdb").metadata();
    const std::set<std::string> for_people = {"program_version", "origin",
                                              "grid_corner"};  // nobody needs them
    for (const auto& [key, _] : metadata) {
        if (for_people.contains(key)) continue;
        VdbMetadata less = metadata;
        less.erase(key);
        rewrite(folder / "a.vdb", folder / "less.vdb", less, "");
        EXPECT_THROW(read_map(folder / "less.vdb"), Error) << key;
    }
}

TEST(MapFile, TruncatedFilesAreErrors) {
    const TemporaryFolder folder;
    write_map(folder / "a.vdb", test_map(false));
    const std::string bytes = bytes_of(folder / "a.vdb");
    for (std::size_t length = 0; length < bytes.size(); length += 1 + bytes.size() / 40) {
        folder.write("cut.vdb", bytes.substr(0, length));
        EXPECT_THROW(read_map(folder / "cut.vdb"), Error) << length << " of " << bytes.size();
    }
}

TEST(MapFile, TransformIsTheCellGridInMetres) {
    const CellGrid grid{Vec3d(-1, 0.5, 0), 0.1, Index3(20, 10, 5), true};
    const VdbTransform transform = transform_of(grid, Vec3d(100, 0, 0));
    EXPECT_NEAR((transform.first_centre - Vec3d(99.05, 0.55, 0.05)).length(), 0, 1e-12);
    EXPECT_EQ(transform.voxel_size, 0.1);
}

}  // namespace
}  // namespace pim
