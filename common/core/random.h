// SPDX-License-Identifier: GPL-3.0-or-later
// Counter-based random numbers: Philox4x32-10 (Salmon, Moraes, Dror, Shaw: Parallel Random Numbers: As Easy
// as 1, 2, 3, SC 2011). A stream is a pure function of (seed, purpose, index): no state is shared between
// threads.
#pragma once

#include <array>
#include <cstdint>

namespace pim {

// One block of Philox4x32-10: four 32-bit words for a counter and a key.
inline std::array<uint32_t, 4> philox4x32(std::array<uint32_t, 4> counter, std::array<uint32_t, 2> key) {
    for (int round = 0; round < 10; ++round) {
        const uint64_t a = uint64_t{0xD2511F53u} * counter[0];
        const uint64_t b = uint64_t{0xCD9E8D57u} * counter[2];
        counter = {uint32_t(b >> 32) ^ counter[1] ^ key[0], uint32_t(b),
                   uint32_t(a >> 32) ^ counter[3] ^ key[1], uint32_t(a)};
        key[0] += 0x9E3779B9u;
        key[1] += 0xBB67AE85u;
    }
    return counter;
}

// What a stream is for: streams of different purposes never share numbers.
enum class RandomPurpose : uint32_t {
    photons,
    reach,
    reach_lamp,
    render,
    reference,
    evaluation,
    light_image,
    photon_map
};

class RandomStream {
  public:
    // `stream`: for example the lamp sample or the pixel; `index`: the photon or path in it.
    // Streams up to 2^26, purposes up to 2^6.
    RandomStream(uint64_t seed, RandomPurpose purpose, uint32_t stream, uint64_t index)
        : key_{uint32_t(seed), uint32_t(seed >> 32)},
          counter_{0, uint32_t(purpose) << 26 ^ stream, uint32_t(index), uint32_t(index >> 32)} {}

    static constexpr int kBlock = 8;
    using Block = std::array<uint32_t, kBlock>;
    // The next numbers, in units of 2^-32, are these; then comes the stream's next block.
    void begin_with(const Block& numbers) {
        block_ = numbers;
        used_ = 0;
    }
    Block next_block() {
        Block block;
        for (int half = 0; half < kBlock; half += 4) {
            const auto numbers = philox4x32(counter_, key_);
            for (int i = 0; i < 4; ++i) block[std::size_t(half + i)] = numbers[std::size_t(i)];
            ++counter_[0];
        }
        return block;
    }

    // Uniform in [0, 1), 24 bits.
    float next() {
        if (used_ == kBlock) begin_with(next_block());
        return float(block_[std::size_t(used_++)] >> 8) * 0x1p-24f;
    }

  private:
    std::array<uint32_t, 2> key_;
    std::array<uint32_t, 4> counter_;
    Block block_{};
    int used_ = kBlock;
};

}  // namespace pim
