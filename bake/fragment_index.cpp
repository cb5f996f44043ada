// SPDX-License-Identifier: GPL-3.0-or-later
#include "bake/fragment_index.h"

#include <bit>

namespace pim {

FragmentIndex::FragmentIndex(std::vector<FragmentKey> keys) : keys_(std::move(keys)) {
    if (keys_.empty()) return;
    slots_.assign(std::bit_ceil(2 * keys_.size()), kFree);
    const std::size_t mask = slots_.size() - 1;
    for (std::size_t i = 0; i < keys_.size(); ++i) {
        std::size_t slot = hash(keys_[i]) & mask;
        while (slots_[slot] != kFree) slot = (slot + 1) & mask;
        slots_[slot] = uint32_t(i);
    }
}

}  // namespace pim
