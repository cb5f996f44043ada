// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/render/photon_tree.h"

#include <fmt/format.h>

#include "common/core/error.h"
#include "common/core/parallel.h"

namespace pim {
namespace {

// In a left-balanced tree, of `leaves` > 1: all levels full but the lowest, which is filled from the left.
std::size_t leaves_on_the_left(std::size_t leaves) {
    const std::size_t level = std::bit_floor(leaves), lowest = 2 * (leaves - level);
    return level / 2 + std::min(lowest, level) / 2;
}

}  // namespace

PhotonTree::PhotonTree(const std::vector<Vec3>& positions) : size_(positions.size()) {
    if (size_ >= std::size_t{1} << 31)
        throw Error(fmt::format("{} photons are too many to keep: fewer than 2^31", size_));
    std::vector<Entry> entries(size_);
    for (std::size_t i = 0; i < size_; ++i) entries[i] = {positions[i], uint32_t(i)};
    const std::size_t leaves = std::max<std::size_t>(1, (size_ + kLeaf - 1) / kLeaf);
    nodes_.resize(leaves - 1);
    leaves_.resize(leaves);
    numbers_.assign(leaves * kLeaf, kNone);
    build(entries, 0, leaves, {0, size_});
}

void PhotonTree::fill_leaf(const std::vector<Entry>& entries, std::size_t leaf, Range range) {
    for (auto& axis : leaves_[leaf].coordinates)
        std::ranges::fill(axis, std::numeric_limits<float>::infinity());
    for (std::size_t i = 0; i < range.end - range.begin; ++i) {
        const Entry& entry = entries[range.begin + i];
        for (int axis = 0; axis < 3; ++axis) leaves_[leaf].coordinates[axis][i] = entry.position[axis];
        numbers_[leaf * kLeaf + i] = entry.number;
    }
}

void PhotonTree::build(std::vector<Entry>& entries, std::size_t node, std::size_t leaves, Range range) {
    if (node >= nodes_.size()) return fill_leaf(entries, node - nodes_.size(), range);
    const auto [begin, end] = range;
    Box3 box;
    for (std::size_t i = begin; i < end; ++i) box.extendBy(entries[i].position);
    const auto axis = int(box.majorAxis());
    const std::size_t left = leaves_on_the_left(leaves), middle = begin + left * kLeaf;
    const auto at = [&](std::size_t i) { return entries.begin() + std::ptrdiff_t(i); };
    std::nth_element(at(begin), at(middle), at(end),
                     [axis](const Entry& a, const Entry& b) { return a.position[axis] < b.position[axis]; });
    nodes_[node] = {entries[middle].position[axis], uint32_t(axis)};
    const auto half = [&](std::size_t second) {
        build(entries, 2 * node + 1 + second, second ? leaves - left : left,
              second ? Range{middle, range.end} : Range{range.begin, middle});
    };
    constexpr std::size_t kWorthAThread = 1 << 13;
    if (end - begin >= kWorthAThread) return parallel_for(2, half);
    half(0), half(1);
}

std::vector<std::size_t> PhotonTree::within(const Vec3d& centre, double radius) const {
    std::vector<std::size_t> found;
    if (!(radius >= 0)) return found;
    descend(centre, std::nextafter(radius * radius, std::numeric_limits<double>::infinity()),
            [&](uint32_t slot, double, double&) { found.push_back(numbers_[slot]); });
    std::ranges::sort(found);
    return found;
}

}  // namespace pim
