// SPDX-License-Identifier: GPL-3.0-or-later
#include "viewer/files/number_text.h"

#include <fmt/format.h>

#include <charconv>

namespace pim {
namespace {

// The first of ever longer texts of `value` that reads back as what the caller takes for the same; the
// seventeenth tells any two doubles apart.
template <class ReadsBack>
std::string shortest_text(double value, ReadsBack reads_back) {
    constexpr int kEnough = 17;
    double rounded = value;
    for (int digits = 1; digits <= kEnough; ++digits) {
        const std::string text = fmt::format("{:.{}g}", value, digits);
        std::from_chars(text.data(), text.data() + text.size(), rounded);
        if (reads_back(rounded)) break;
    }
    return fmt::format("{}", rounded);  // 100 where the loop had 1e+02
}

}  // namespace

std::string number_text(float value) {
    return shortest_text(value, [&](double read) { return float(read) == value; });
}

std::string number_text(double value) {
    return shortest_text(value, [&](double read) { return read == value; });
}

NumberTexts number_texts(const Vec3& v) { return {number_text(v.x), number_text(v.y), number_text(v.z)}; }
NumberTexts number_texts(const Vec3d& v) { return {number_text(v.x), number_text(v.y), number_text(v.z)}; }

std::string commas(const NumberTexts& texts) { return fmt::format("{}", fmt::join(texts, ",")); }

NumberTexts world_texts(const Geometry& geometry, const Vec3& position) {
    const Vec3d world = geometry.to_world(position);
    NumberTexts texts;
    for (int axis = 0; axis < 3; ++axis)
        texts[axis] = shortest_text(
            world[axis], [&](double read) { return float(read - geometry.origin[axis]) == position[axis]; });
    return texts;
}

}  // namespace pim
