// SPDX-License-Identifier: GPL-3.0-or-later
// Tables of comma-separated values, as spreadsheets write them: the first line names the columns, "quotes"
// around a value keep its commas (a quote inside is doubled), line ends LF or CRLF. Blank lines, lines that
// start with #, spaces around values and a byte order mark are passed over.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace pim {

struct CsvRow {
    int line = 0;                     // 1-based
    std::vector<std::string> values;  // one for each column
};

struct CsvTable {
    std::string file;  // for messages
    CsvRow header;     // the columns' names, no two alike
    std::vector<CsvRow> rows;

    bool has(const std::string& column) const;
};

// Throw Error with file and line: no header, a row that is longer or shorter than it, a quote left open.
CsvTable parse_csv(const std::string& text, const std::string& file);
CsvTable read_csv(const std::filesystem::path& path);

// Throws Error unless the table has all of `required` and no column beyond those and `optional`.
void check_columns(const CsvTable& table, const std::vector<std::string>& required,
                   const std::vector<std::string>& optional);

// Throws Error "file:line: column: problem".
[[noreturn]] void fail(const CsvTable& table, const CsvRow& row, const std::string& column,
                       const std::string& problem);

// A row's value; empty where the table has no such column.
std::string csv_text(const CsvTable& table, const CsvRow& row, const std::string& column);

// A finite decimal number from `low` to `high`; csv_number wants one, the other allows an empty value. Throw
// Error.
struct CsvRange {
    double low = -1e30, high = 1e30;
};
double csv_number(const CsvTable& table, const CsvRow& row, const std::string& column, CsvRange range = {});
std::optional<double> csv_optional_number(const CsvTable& table, const CsvRow& row, const std::string& column,
                                          CsvRange range = {});

}  // namespace pim
