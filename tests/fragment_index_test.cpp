// SPDX-License-Identifier: GPL-3.0-or-later
#include "bake/fragment_index.h"

#include <gtest/gtest.h>

namespace pim {
namespace {

TEST(FragmentIndex, FindsEachKeyAndNoOther) {
    std::vector<FragmentKey> keys;
    for (uint64_t cell = 0; cell < 40; ++cell)
        for (uint32_t triangle = 0; triangle < 30; ++triangle)
            for (const uint8_t place : {0, 1, 127}) keys.push_back({cell << 20, triangle, place});
    const FragmentIndex index(keys);
    EXPECT_TRUE(index.keys() == keys);
    for (std::size_t i = 0; i < keys.size(); ++i) {
        ASSERT_EQ(index.find(keys[i]), i);
        FragmentKey other = keys[i];
        other.place ^= 64;
        ASSERT_FALSE(index.contains(other));
        other = keys[i];
        ++other.cell;
        ASSERT_FALSE(index.contains(other));
    }
}

TEST(FragmentIndex, AnEmptyOneFindsNothing) {
    EXPECT_FALSE(FragmentIndex().contains({1, 2, 3}));
    EXPECT_FALSE(FragmentIndex(std::vector<FragmentKey>{}).contains({1, 2, 3}));
}

}  // namespace
}  // namespace pim
