// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/render/photon_tree.h"

#include <gtest/gtest.h>

#include "common/core/parallel.h"
#include "common/core/random.h"

namespace pim {
namespace {

std::vector<Vec3> points(std::size_t count, bool on_a_lattice = false) {
    RandomStream random(1, RandomPurpose::evaluation, 0, 0);
    std::vector<Vec3> positions;
    for (std::size_t i = 0; i < count; ++i) {
        Vec3 p;
        for (int axis = 0; axis < 3; ++axis) p[axis] = random.next();
        if (on_a_lattice)  // many points and many coordinates alike
            for (int axis = 0; axis < 3; ++axis) p[axis] = std::floor(p[axis] * 4) / 4;
        positions.push_back(p);
    }
    return positions;
}

float squared(const Vec3& a, const Vec3& b) { return (a - b).length2(); }

// The squared distances of the nearest, ascending: points at equal distance may stand in for one another.
template <class Accept>
std::vector<float> expected_nearest(const std::vector<Vec3>& positions, const Vec3& centre, float radius,
                                    std::size_t count, Accept accept) {
    std::vector<float> all;
    for (std::size_t i = 0; i < positions.size(); ++i)
        if (accept(i) && squared(positions[i], centre) <= radius * radius)
            all.push_back(squared(positions[i], centre));
    std::ranges::sort(all);
    all.resize(std::min(all.size(), count));
    return all;
}

template <class Accept>
void expect_nearest(const std::vector<Vec3>& positions, const PhotonTree& tree, const Vec3& centre,
                    float radius, std::size_t count, Accept accept) {
    std::vector<PhotonTree::Found> found;
    tree.nearest(
        centre, radius, count, [&](uint32_t slot) { return accept(tree.numbers()[slot]); }, found);
    std::vector<float> distances;
    std::vector<uint32_t> slots;
    for (const auto& [distance, slot] : found) {
        const uint32_t number = tree.numbers()[slot];
        ASSERT_LT(number, positions.size());
        EXPECT_TRUE(accept(number));
        EXPECT_EQ(tree.position(slot), positions[number]);
        EXPECT_EQ(distance, squared(positions[number], centre));
        distances.push_back(distance);
        slots.push_back(slot);
    }
    std::ranges::sort(distances);
    EXPECT_EQ(distances, expected_nearest(positions, centre, radius, count, accept));
    std::ranges::sort(slots);
    EXPECT_EQ(std::ranges::adjacent_find(slots), slots.end()) << "the same point twice";
}

TEST(PhotonTree, NearestAgreesWithBruteForce) {
    for (const bool on_a_lattice : {false, true})
        for (const std::size_t size : {0, 1, 2, 7, 8, 9, 15, 16, 17, 23, 24, 25, 33, 100, 1000, 2000}) {
            const auto positions = points(size, on_a_lattice);
            const PhotonTree tree(positions);
            EXPECT_EQ(tree.size(), size);
            for (const std::size_t count : {0, 1, 2, 10, 50, 3000})
                for (const float radius : {0.0f, 0.25f, 10.0f, std::numeric_limits<float>::infinity()})
                    for (const Vec3& centre : {Vec3(0.5f), Vec3(0.25f, 0.6f, 0.1f), Vec3(-3, 2, 0.5f)}) {
                        const auto any = [](std::size_t) { return true; };
                        const auto third = [](std::size_t i) { return i % 3 == 0; };
                        expect_nearest(positions, tree, centre, radius, count, any);
                        expect_nearest(positions, tree, centre, radius, count, third);
                    }
        }
}

TEST(PhotonTree, AllPointsInOnePlace) {
    const std::vector<Vec3> positions(100, Vec3(1, 2, 3));
    const PhotonTree tree(positions);
    for (const std::size_t count : {1, 50, 100, 200})
        expect_nearest(positions, tree, {1, 2, 3}, 0, count, [](std::size_t) { return true; });
    EXPECT_EQ(tree.within(Vec3d(1, 2, 3), 0).size(), 100u);
    EXPECT_TRUE(tree.within(Vec3d(1, 2, 3.001), 0.0005).empty());
}

TEST(PhotonTree, EveryPointHasOneSlot) {
    for (const std::size_t size : {0, 1, 8, 9, 100, 12345}) {
        const PhotonTree tree(points(size));
        std::vector<int> seen(size, 0);
        for (const uint32_t number : tree.numbers())
            if (number != PhotonTree::kNone) ++seen.at(number);
        EXPECT_EQ(std::ranges::count(seen, 1), std::ptrdiff_t(size));
    }
}

TEST(PhotonTree, WithinAgreesWithBruteForce) {
    const auto positions = points(2000);
    const PhotonTree tree(positions);
    for (int i = 0; i < 50; ++i) {
        const Vec3d centre(positions[std::size_t(i)] + Vec3(0.01f));
        const double radius = 0.05 + 0.005 * i;
        std::vector<std::size_t> expected;
        for (std::size_t k = 0; k < positions.size(); ++k)
            if ((Vec3d(positions[k]) - centre).length2() <= radius * radius) expected.push_back(k);
        EXPECT_EQ(tree.within(centre, radius), expected);
    }
    EXPECT_TRUE(PhotonTree().within(Vec3d(0), 1).empty());
    EXPECT_TRUE(tree.within(Vec3d(0), -1).empty());
}

TEST(PhotonTree, SameTreeAtAnyThreadCount) {
    const auto positions = points(100000);
    const PhotonTree all(positions);
    for (const int threads : {1, 2, 4}) {
        const ThreadLimit limit(threads);
        EXPECT_EQ(PhotonTree(positions).numbers(), all.numbers());
    }
}

}  // namespace
}  // namespace pim
