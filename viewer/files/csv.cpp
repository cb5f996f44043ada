// SPDX-License-Identifier: GPL-3.0-or-later
#include "viewer/files/csv.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <string_view>

#include "common/core/error.h"
#include "common/core/file.h"

namespace pim {
namespace {

std::string_view trimmed(std::string_view text) {
    const std::size_t first = text.find_first_not_of(" \t");
    if (first == std::string_view::npos) return {};
    return text.substr(first, text.find_last_not_of(" \t") - first + 1);
}

[[noreturn]] void fail_line(const std::string& file, int line, const std::string& problem) {
    throw Error(fmt::format("{}:{}: {}", file, line, problem));
}

// Takes the quoted value that `rest` starts with; `rest` then starts with a comma or is empty.
std::string take_quoted(std::string_view& rest, const std::string& file, int line) {
    std::string value;
    for (std::size_t i = 1; i < rest.size(); ++i) {
        if (rest[i] != '"') {
            value += rest[i];
        } else if (i + 1 < rest.size() && rest[i + 1] == '"') {
            value += rest[i++];
        } else {
            rest = trimmed(rest.substr(i + 1));
            if (!rest.empty() && rest[0] != ',')
                fail_line(file, line, "a comma must follow the quote that closes a value");
            return value;
        }
    }
    fail_line(file, line, "a quote is left open; a value must end on its own line");
}

std::vector<std::string> split(std::string_view rest, const std::string& file, int line) {
    std::vector<std::string> values;
    while (true) {
        rest = trimmed(rest);
        if (rest.starts_with('"')) {
            values.push_back(take_quoted(rest, file, line));
        } else {
            const std::string_view value = rest.substr(0, rest.find(','));
            values.emplace_back(trimmed(value));
            rest.remove_prefix(value.size());
        }
        if (rest.empty()) return values;
        rest.remove_prefix(1);
    }
}

void check_header(const CsvRow& header, const std::string& file) {
    for (auto column = header.values.begin(); column != header.values.end(); ++column) {
        if (column->empty()) fail_line(file, header.line, "a column has no name");
        if (std::find(header.values.begin(), column, *column) != column)
            fail_line(file, header.line, fmt::format("two columns are named {}", *column));
    }
}

}  // namespace

bool CsvTable::has(const std::string& column) const {
    return std::ranges::find(header.values, column) != header.values.end();
}

CsvTable parse_csv(const std::string& text, const std::string& file) {
    constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";
    std::string_view rest = text;
    if (rest.starts_with(kByteOrderMark)) rest.remove_prefix(kByteOrderMark.size());
    CsvTable table{file, {}, {}};
    for (int number = 1; !rest.empty(); ++number) {
        std::string_view line = rest.substr(0, rest.find('\n'));
        rest.remove_prefix(std::min(line.size() + 1, rest.size()));
        if (line.ends_with('\r')) line.remove_suffix(1);
        line = trimmed(line);
        if (line.empty() || line[0] == '#') continue;
        CsvRow row{number, split(line, file, number)};
        if (table.header.line == 0) {
            check_header(row, file);
            table.header = std::move(row);
            continue;
        }
        if (row.values.size() != table.header.values.size())
            fail_line(file, number,
                      fmt::format("has {} values; the header names {} columns: {}", row.values.size(),
                                  table.header.values.size(), fmt::join(table.header.values, ",")));
        table.rows.push_back(std::move(row));
    }
    if (table.header.line == 0) fail_line(file, 1, "is empty; the first line must name the columns");
    return table;
}

CsvTable read_csv(const std::filesystem::path& path) { return parse_csv(read_text(path), path.string()); }

void check_columns(const CsvTable& table, const std::vector<std::string>& required,
                   const std::vector<std::string>& optional) {
    for (const std::string& column : required)
        if (!table.has(column))
            fail(table, table.header, column,
                 fmt::format("the column is missing; needed: {}", fmt::join(required, ",")));
    std::vector<std::string> allowed = required;
    allowed.insert(allowed.end(), optional.begin(), optional.end());
    for (const std::string& column : table.header.values)
        if (std::ranges::find(allowed, column) == allowed.end())
            fail(table, table.header, column,
                 fmt::format("is unknown; allowed columns: {}", fmt::join(allowed, ",")));
}

void fail(const CsvTable& table, const CsvRow& row, const std::string& column, const std::string& problem) {
    fail_line(table.file, row.line, fmt::format("{}: {}", column, problem));
}

std::string csv_text(const CsvTable& table, const CsvRow& row, const std::string& column) {
    const auto& columns = table.header.values;
    const auto found = std::ranges::find(columns, column);
    return found == columns.end() ? std::string() : row.values[std::size_t(found - columns.begin())];
}

double csv_number(const CsvTable& table, const CsvRow& row, const std::string& column, CsvRange range) {
    const auto value = csv_optional_number(table, row, column, range);
    if (!value) fail(table, row, column, "is empty; it must be a number");
    return *value;
}

std::optional<double> csv_optional_number(const CsvTable& table, const CsvRow& row, const std::string& column,
                                          CsvRange range) {
    const std::string text = csv_text(table, row, column);
    if (text.empty()) return std::nullopt;
    double value = 0;
    const char* const end = text.data() + text.size();
    const auto [rest, problem] = std::from_chars(text.data(), end, value);
    if (problem != std::errc() || rest != end || !std::isfinite(value))
        fail(table, row, column, fmt::format("'{}' is no number", text));
    if (value < range.low || value > range.high)
        fail(table, row, column,
             fmt::format("{} is out of range; allowed: {} to {}", text, range.low, range.high));
    return value;
}

}  // namespace pim
