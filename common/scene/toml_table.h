// SPDX-License-Identifier: GPL-3.0-or-later
// Strict reading of TOML tables: every key must be known, have its type and lie in its range.
// For the few files that read TOML: this header brings toml++ with it.
#pragma once

#include <fmt/format.h>

#include <toml++/toml.h>
#include <cmath>
#include <set>
#include <string>

#include "common/core/error.h"
#include "common/core/vector.h"

namespace pim {

class TomlTable {
  public:
    TomlTable(const toml::table& table, std::string file, std::string name)
        : table_(table), file_(std::move(file)), name_(std::move(name)) {}

    bool has(const std::string& key) {
        known_.insert(key);
        return table_.contains(key);
    }

    [[noreturn]] void fail(const std::string& key, const std::string& problem) const {
        const toml::node* node = table_.get(key);
        const auto line = node ? node->source().begin.line : table_.source().begin.line;
        const std::string where =
            line > 0 ? fmt::format("{}:{}", file_, line) : file_;  // 0: not from the file
        throw Error(fmt::format("{}: {}: {}", where, name_.empty() ? key : name_ + "." + key, problem));
    }

    std::string text(const std::string& key, const std::string& fallback) {
        if (!has(key)) return fallback;
        const auto value = table_[key].value<std::string>();
        if (!table_[key].is_string() || !value) fail(key, "must be a text in quotes");
        return *value;
    }

    // One of `allowed`; the first is the default. Returns its place.
    std::size_t choice(const std::string& key, const std::vector<std::string>& allowed) {
        const std::string value = text(key, allowed[0]);
        for (std::size_t i = 0; i < allowed.size(); ++i)
            if (allowed[i] == value) return i;
        fail(key, fmt::format("'{}' is unknown; allowed: {}", value, fmt::join(allowed, ", ")));
    }

    bool flag(const std::string& key, bool fallback) {
        if (!has(key)) return fallback;
        if (!table_[key].is_boolean()) fail(key, "must be true or false");
        return *table_[key].value<bool>();
    }

    double number(const std::string& key, double fallback, double low, double high) {
        if (!has(key)) return fallback;
        return checked(key, table_[key], low, high);
    }

    int64_t integer(const std::string& key, int64_t fallback, int64_t low, int64_t high) {
        if (!has(key)) return fallback;
        const auto value = table_[key].value<int64_t>();
        if (!table_[key].is_integer() || *value < low || *value > high)
            fail(key, fmt::format("must be a whole number from {} to {}", low, high));
        return *value;
    }

    // `count` numbers.
    std::vector<double> numbers(const std::string& key, std::size_t count, double low, double high) {
        has(key);
        const toml::array* array = table_[key].as_array();
        if (!array || array->size() != count) fail(key, fmt::format("must be a list of {} numbers", count));
        std::vector<double> values;
        for (std::size_t i = 0; i < count; ++i)
            values.push_back(checked(key, toml::node_view(array->get(i)), low, high));
        return values;
    }

    // `count` whole numbers.
    std::vector<int> integers(const std::string& key, std::size_t count, int low, int high) {
        std::vector<int> values;
        for (const double v : numbers(key, count, low, high)) {
            if (v != std::floor(v))
                fail(key, fmt::format("must be {} whole numbers from {} to {}", count, low, high));
            values.push_back(int(v));
        }
        return values;
    }

    Vec3d vector(const std::string& key, double low = -1e300, double high = 1e300) {
        const auto v = numbers(key, 3, low, high);
        return {v[0], v[1], v[2]};
    }

    TomlTable table(const std::string& key) {
        has(key);
        const toml::table* child = table_[key].as_table();
        if (!child) fail(key, "must be a table, as in { min = [0, 0, 0], max = [1, 1, 1] }");
        return {*child, file_, name_.empty() ? key : name_ + "." + key};
    }

    bool is_array(const std::string& key) const { return table_[key].is_array(); }
    const toml::table& raw() const { return table_; }

    // After everything was read: whatever is left is unknown.
    void refuse_unknown() const {
        for (const auto& [key, _] : table_)
            if (!known_.contains(std::string(key.str())))
                fail(std::string(key.str()),
                     fmt::format("is unknown; allowed here: {}", fmt::join(known_, ", ")));
    }

  private:
    template <class View>
    double checked(const std::string& key, View view, double low, double high) const {
        const auto value = view.template value<double>();
        if (!view.is_number() || !value) fail(key, "must hold numbers");
        if (!std::isfinite(*value) || *value < low || *value > high)
            fail(key, fmt::format("{} is out of range; allowed: {} to {}", *value, low, high));
        return *value;
    }

    const toml::table& table_;
    std::string file_, name_;
    std::set<std::string> known_;
};

}  // namespace pim
