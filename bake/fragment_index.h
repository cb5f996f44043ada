// SPDX-License-Identifier: GPL-3.0-or-later
// Fragments by their key, for every landing of a photon: a hash table with linear probing (Knuth: The Art of
// Computer Programming, volume 3, section 6.4).
#pragma once

#include <optional>

#include "bake/fragments.h"

namespace pim {

class FragmentIndex {
  public:
    FragmentIndex() = default;
    explicit FragmentIndex(std::vector<FragmentKey> keys);  // each of them once, fewer than 2^32

    const std::vector<FragmentKey>& keys() const { return keys_; }
    bool contains(const FragmentKey& key) const { return find(key).has_value(); }
    std::optional<std::size_t> find(const FragmentKey& key) const {  // its place in keys()
        if (slots_.empty()) return std::nullopt;
        const std::size_t mask = slots_.size() - 1;
        for (std::size_t slot = hash(key) & mask; slots_[slot] != kFree; slot = (slot + 1) & mask)
            if (keys_[slots_[slot]] == key) return slots_[slot];
        return std::nullopt;
    }

  private:
    static constexpr uint32_t kFree = ~uint32_t{0};
    static std::size_t hash(const FragmentKey& key) {
        uint64_t x = key.cell * 0x9e3779b97f4a7c15u ^ (uint64_t(key.triangle) << 8 | key.place);
        x = (x ^ x >> 32) * 0xd6e8feb86659fd93u;
        return x ^ x >> 32;
    }

    std::vector<FragmentKey> keys_;
    std::vector<uint32_t> slots_;  // numbers of keys; a power of two
};

}  // namespace pim
