// SPDX-License-Identifier: GPL-3.0-or-later
// Points in a k-d tree (Bentley: Multidimensional Binary Search Trees Used for Associative Searching, 1975),
// to ask which photons lie near a place (Jensen 2001, chapter 6). Split across the longest side into halves
// as equal as a left-balanced tree allows, whose nodes need no pointers. The points lie in leaves of eight,
// axis by axis, so that their distances are taken several at a time.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include "common/core/vector.h"

namespace pim {

class PhotonTree {
  public:
    explicit PhotonTree(const std::vector<Vec3>& positions = {});  // throws Error from 2^31 on
    std::size_t size() const { return size_; }

    // Points are kept at slots, neighbours side by side; what belongs to them is best kept in the same way.
    // numbers()[slot] is the point's number in `positions`, kNone where the slot is empty.
    static constexpr uint32_t kNone = std::numeric_limits<uint32_t>::max();
    const std::vector<uint32_t>& numbers() const { return numbers_; }

    Vec3 position(uint32_t slot) const {
        const auto& [x, y, z] = leaves_[slot / kLeaf].coordinates;
        return {x[slot % kLeaf], y[slot % kLeaf], z[slot % kLeaf]};
    }

    struct Found {
        float squared_distance;
        uint32_t slot;
        bool operator<(const Found& other) const { return squared_distance < other.squared_distance; }
    };
    // Of the points that accept(slot) lets pass and that lie at most `radius` from `centre`, the `count`
    // nearest, or all where there are fewer; in no order. `found` is emptied first.
    template <class Accept>
    void nearest(const Vec3& centre, float radius, std::size_t count, const Accept& accept,
                 std::vector<Found>& found) const;

    // Numbers of the points at most `radius` from `centre`, in ascending order.
    std::vector<std::size_t> within(const Vec3d& centre, double radius) const;

  private:
    static constexpr std::size_t kLeaf = 8;  // points in a leaf; the last may hold fewer

    struct Node {
        float split;  // points of the first half are at most here, of the second at least
        uint32_t axis;
    };
    struct alignas(32) Leaf {
        float coordinates[3][kLeaf];  // infinite where the slot is empty
    };
    struct Entry {
        Vec3 position;
        uint32_t number;
    };
    struct Range {
        std::size_t begin, end;
    };
    void build(std::vector<Entry>& entries, std::size_t node, std::size_t leaves, Range range);
    void fill_leaf(const std::vector<Entry>& entries, std::size_t leaf, Range range);

    template <class Real>
    static std::array<Real, kLeaf> squared_distances(const Leaf& leaf, const Imath::Vec3<Real>& centre) {
        std::array<Real, kLeaf> squared;
        for (std::size_t i = 0; i < kLeaf; ++i) {
            const Real x = Real(leaf.coordinates[0][i]) - centre.x,
                       y = Real(leaf.coordinates[1][i]) - centre.y,
                       z = Real(leaf.coordinates[2][i]) - centre.z;
            squared[i] = x * x + y * y + z * z;
        }
        return squared;
    }

    // Of a heap whose farthest stands first.
    static void replace_farthest(std::vector<Found>& heap, const Found& by) {
        std::size_t place = 0;
        for (std::size_t child = 1; child < heap.size(); child = 2 * place + 1) {
            if (child + 1 < heap.size()) child += heap[child] < heap[child + 1];
            if (!(by < heap[child])) break;
            heap[place] = heap[child];
            place = child;
        }
        heap[place] = by;
    }

    // Calls visit(slot, squared distance, bound) for points whose squared distance from `centre` is below
    // `bound`, which it may lower; regions near by come first.
    template <class Real, class Visit>
    void descend(const Imath::Vec3<Real>& centre, Real bound, const Visit& visit) const;

    std::size_t size_ = 0;
    std::vector<Node> nodes_;  // children of i at 2i + 1 and 2i + 2; those beyond the last node are leaves
    std::vector<Leaf> leaves_;
    std::vector<uint32_t> numbers_;  // [slot]
};

template <class Real, class Visit>
void PhotonTree::descend(const Imath::Vec3<Real>& centre, Real bound, const Visit& visit) const {
    struct Region {
        std::size_t node;
        // From `centre` to the region, 0 on axes on which the region holds it. Its square is summed as those
        // of points are, and rounding is monotone: no point is lost by it.
        Imath::Vec3<Real> offset;
    };
    std::array<Region, 32> waiting;
    waiting[0] = {0, Imath::Vec3<Real>(0)};
    for (std::size_t count = 1; count > 0;) {
        auto [node, offset] = waiting[--count];
        if (!(offset.x * offset.x + offset.y * offset.y + offset.z * offset.z < bound)) continue;
        while (node < nodes_.size()) {
            const auto [split, axis] = nodes_[node];
            const Real distance = Real(split) - centre[int(axis)];
            const std::size_t near_half = distance > 0 ? 0 : 1;
            Imath::Vec3<Real> beyond = offset;
            beyond[int(axis)] = distance;
            waiting[count++] = {2 * node + 2 - near_half, beyond};
            node = 2 * node + 1 + near_half;
        }
        const std::size_t leaf = node - nodes_.size();
        const auto squared = squared_distances(leaves_[leaf], centre);
        uint32_t inside = 0;
        for (std::size_t i = 0; i < kLeaf; ++i) inside |= uint32_t(squared[i] < bound) << i;
        for (; inside != 0; inside &= inside - 1) {
            const auto i = std::size_t(std::countr_zero(inside));
            if (squared[i] < bound) visit(uint32_t(leaf * kLeaf + i), squared[i], bound);
        }
    }
}

template <class Accept>
void PhotonTree::nearest(const Vec3& centre, float radius, std::size_t count, const Accept& accept,
                         std::vector<Found>& found) const {
    found.clear();
    if (count == 0 || !(radius >= 0)) return;
    const auto visit = [&](uint32_t slot, float squared, float& bound) {
        if (!accept(slot)) return;
        if (found.size() == count) {
            replace_farthest(found, {squared, slot});
        } else {
            found.push_back({squared, slot});
            if (found.size() < count) return;
            std::make_heap(found.begin(), found.end());
        }
        bound = found.front().squared_distance;
    };
    descend(centre, std::nextafter(radius * radius, std::numeric_limits<float>::infinity()), visit);
}

}  // namespace pim
