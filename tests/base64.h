// SPDX-License-Identifier: GPL-3.0-or-later
// Numbers as base64 text, for geometry inside a glTF file.
#pragma once

#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

namespace pim {

// A multiple of three floats: no padding.
inline std::string base64(const std::vector<float>& numbers) {
    static const char kDigits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string bytes(numbers.size() * 4, '\0'), text;
    std::memcpy(bytes.data(), numbers.data(), bytes.size());
    for (std::size_t i = 0; i < bytes.size(); i += 3) {
        const unsigned word =
            unsigned(uint8_t(bytes[i])) << 16 | unsigned(uint8_t(bytes[i + 1])) << 8 | uint8_t(bytes[i + 2]);
        for (int shift = 18; shift >= 0; shift -= 6) text += kDigits[word >> shift & 63];
    }
    return text;
}

}  // namespace pim
