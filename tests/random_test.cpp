// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/core/random.h"

#include <set>

#include "statistics.h"

namespace pim {
namespace {

using Block = std::array<uint32_t, 4>;

// The known answers of the authors' library (Random123, kat_vectors, philox4x32 with 10 rounds).
TEST(Philox, KnownAnswers) {
    EXPECT_EQ(philox4x32({0, 0, 0, 0}, {0, 0}), (Block{0x6627e8d5, 0xe169c58d, 0xbc57ac4c, 0x9b00dbd8}));
    constexpr uint32_t kAll = 0xffffffff;
    EXPECT_EQ(philox4x32({kAll, kAll, kAll, kAll}, {kAll, kAll}),
              (Block{0x408f276d, 0x41c83b0e, 0xa20bc7c6, 0x6d5451fd}));
    EXPECT_EQ(philox4x32({0x243f6a88, 0x85a308d3, 0x13198a2e, 0x03707344}, {0xa4093822, 0x299f31d0}),
              (Block{0xd16cfe09, 0x94fdcceb, 0x5001e420, 0x24126ea1}));
}

TEST(RandomStream, IsUniform) {
    RandomStream random(7, RandomPurpose::photons, 3, 0);
    std::vector<long> bins(256);
    for (int i = 0; i < 1 << 20; ++i) {
        const float u = random.next();
        ASSERT_GE(u, 0);
        ASSERT_LT(u, 1);
        ++bins[std::size_t(u * 256)];
    }
    EXPECT_LT(chi_squared(bins), chi_squared_bound(255));
}

// First numbers of neighbouring streams, as pixels and photons use them, are independent pairs.
TEST(RandomStream, NeighbouringStreamsAreIndependent) {
    std::vector<long> bins(16 * 16);
    for (uint64_t index = 0; index < 1 << 18; ++index) {
        RandomStream one(1, RandomPurpose::photons, 5, index), next(1, RandomPurpose::photons, 5, index + 1);
        ++bins[std::size_t(one.next() * 16) * 16 + std::size_t(next.next() * 16)];
    }
    EXPECT_LT(chi_squared(bins), chi_squared_bound(255));
}

TEST(RandomStream, EveryArgumentChangesTheNumbers) {
    // Six streams of four 24-bit numbers each: two equal ones by chance happen once in 2^90.
    const auto numbers = [](uint64_t seed, RandomPurpose purpose, uint32_t stream, uint64_t index) {
        RandomStream random(seed, purpose, stream, index);
        return std::array<float, 4>{random.next(), random.next(), random.next(), random.next()};
    };
    std::set<std::array<float, 4>> all;
    all.insert(numbers(1, RandomPurpose::photons, 1, 1));
    all.insert(numbers(2, RandomPurpose::photons, 1, 1));
    all.insert(numbers(uint64_t{1} << 32, RandomPurpose::photons, 1, 1));
    all.insert(numbers(1, RandomPurpose::photons, 2, 1));
    all.insert(numbers(1, RandomPurpose::photons, 1, 2));
    all.insert(numbers(1, RandomPurpose::photons, 1, uint64_t{1} << 32));
    EXPECT_EQ(all.size(), 6u);
    EXPECT_EQ(numbers(1, RandomPurpose::photons, 1, 1), numbers(1, RandomPurpose::photons, 1, 1));
}

TEST(RandomStream, PurposesNeverShareNumbers) {
    std::set<std::array<float, 4>> all;
    int streams = 0;
    for (uint32_t purpose = 0; purpose <= uint32_t(RandomPurpose::light_image); ++purpose)
        for (const uint32_t stream : {0u, 1u, (1u << 26) - 1}) {
            RandomStream random(1, RandomPurpose(purpose), stream, 9);
            all.insert({random.next(), random.next(), random.next(), random.next()});
            ++streams;
        }
    EXPECT_EQ(int(all.size()), streams);
}

TEST(RandomStream, GoesOnAfterTheNumbersThatItBeginsWith) {
    RandomStream plain(1, RandomPurpose::render, 2, 3), led = plain;
    led.begin_with({0, 1u << 31, 1u << 30, 0, 0, 0, 0, 3u << 30});
    for (const float expected : {0.0f, 0.5f, 0.25f, 0.0f, 0.0f, 0.0f, 0.0f, 0.75f})
        EXPECT_EQ(led.next(), expected);
    for (int i = 0; i < 20; ++i) EXPECT_EQ(led.next(), plain.next());
}

}  // namespace
}  // namespace pim
