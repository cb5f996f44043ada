// SPDX-License-Identifier: GPL-3.0-or-later
#include "viewer/files/names.h"

#include <fmt/format.h>

#include <algorithm>

#include "common/core/error.h"

namespace pim {
namespace {

template <class Value>
Value parse_name(const std::string& text, const std::string& option, const std::vector<std::string>& names) {
    const auto found = std::ranges::find(names, text);
    if (found == names.end())
        throw UsageError(
            fmt::format("{}: '{}' is unknown; allowed: {}", option, text, fmt::join(names, ", ")));
    return Value(found - names.begin());
}

}  // namespace

const std::vector<std::string>& view_names() {
    static const std::vector<std::string> names{"radiance", "irradiance", "direct", "indirect", "density",
                                                "cells",    "normals",    "albedo", "trust"};
    return names;
}

const std::vector<std::string>& direct_light_names() {
    static const std::vector<std::string> names{"none", "traced", "baked"};
    return names;
}

const std::vector<std::string>& tone_curve_names() {
    static const std::vector<std::string> names{"none", "reinhard", "aces"};
    return names;
}

const std::string& name(View view) { return view_names().at(std::size_t(view)); }
const std::string& name(DirectLight direct) { return direct_light_names().at(std::size_t(direct)); }
const std::string& name(ToneCurve curve) { return tone_curve_names().at(std::size_t(curve)); }

View parse_view(const std::string& text, const std::string& option) {
    return parse_name<View>(text, option, view_names());
}

DirectLight parse_direct_light(const std::string& text, const std::string& option) {
    return parse_name<DirectLight>(text, option, direct_light_names());
}

ToneCurve parse_tone_curve(const std::string& text, const std::string& option) {
    return parse_name<ToneCurve>(text, option, tone_curve_names());
}

}  // namespace pim
