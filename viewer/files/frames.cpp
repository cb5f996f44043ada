// SPDX-License-Identifier: GPL-3.0-or-later
#include "viewer/files/frames.h"

#include <fmt/format.h>

#include <charconv>
#include <fstream>
#include <set>
#include <sstream>

#include "common/core/error.h"
#include "common/core/file.h"

namespace pim {
namespace {

namespace fs = std::filesystem;

// The record: a title with the key's hash, then a line for each frame.
const std::string kTitle = "pim frames of ", kDone = "done ";

struct PatternParts {
    std::string before, after;
    int digits = 1;
};

PatternParts parts_of(const fs::path& pattern) {
    const std::string name = pattern.filename().string();
    const std::size_t percent = name.find('%');
    const auto refuse = [&]() -> UsageError {
        return UsageError(
            fmt::format("'{}' must hold one number as %d or %04d in its file's name, as in frame_%04d.png, "
                        "and no other %",
                        pattern.string()));
    };
    if (percent == std::string::npos || name.find('%', percent + 1) != std::string::npos) throw refuse();
    PatternParts parts{name.substr(0, percent), name.substr(percent + 1)};
    if (parts.after.size() >= 3 && parts.after[0] == '0' && parts.after[1] >= '1' && parts.after[1] <= '9') {
        parts.digits = parts.after[1] - '0';
        parts.after.erase(0, 2);
    }
    if (!parts.after.starts_with('d')) throw refuse();
    parts.after.erase(0, 1);
    return parts;
}

struct Record {
    std::string title;
    std::set<int> frames;
};

// A line that a crash cut off does not count, and spoils the next one at most: that frame is rendered again.
Record read_record(const fs::path& path) {
    std::istringstream stream(read_text(path));
    Record record;
    std::getline(stream, record.title);
    if (stream.eof() || !record.title.starts_with(kTitle))
        throw Error(
            fmt::format("{}: is no record of frames; remove it or use another --output", path.string()));
    for (std::string line; std::getline(stream, line) && !stream.eof();) {
        if (!line.starts_with(kDone)) continue;
        int number = -1;
        const char* const end = line.data() + line.size();
        const auto [rest, problem] = std::from_chars(line.data() + kDone.size(), end, number);
        if (problem == std::errc() && rest == end) record.frames.insert(number);
    }
    return record;
}

std::string title_of(const std::string& key) {
    ContentHash hash;
    hash.feed(key);
    return kTitle + hash.hex();
}

void start_record(const fs::path& pattern, const std::string& title, const Record& old) {
    for (const int number : old.frames) {
        std::error_code ignored;
        fs::remove(frame_name(pattern, number), ignored);
    }
    write_text_atomically(frame_record(pattern), title + "\n");
}

void refuse_strangers(const fs::path& pattern, int count) {
    for (int number = 0; number < count; ++number)
        if (const fs::path frame = frame_name(pattern, number); fs::exists(frame))
            throw Error(
                fmt::format("{}: exists, and nothing tells how it was made; remove it, use another "
                            "--output, or give --overwrite",
                            frame.string()));
}

}  // namespace

fs::path frame_name(const fs::path& pattern, int number) {
    const PatternParts parts = parts_of(pattern);
    return pattern.parent_path() /
           fmt::format("{}{:0{}d}{}", parts.before, number, parts.digits, parts.after);
}

fs::path frame_record(const fs::path& pattern) {
    parts_of(pattern);  // throws
    return pattern.parent_path() / (pattern.filename().string() + ".record");
}

std::vector<int> missing_frames(const fs::path& pattern, int count, const std::string& key, bool overwrite) {
    const fs::path path = frame_record(pattern);
    const std::string title = title_of(key);
    Record record;
    if (fs::exists(path)) record = read_record(path);
    if (record.title.empty() && !overwrite) refuse_strangers(pattern, count);
    if (!record.title.empty() && record.title != title && !overwrite)
        throw Error(
            fmt::format("{}: the frames there are of another scene, path or setting; remove them and "
                        "this record, use another --output, or give --overwrite",
                        path.string()));
    if (record.title != title || overwrite) {
        start_record(pattern, title, record);
        record.frames.clear();
    }
    std::vector<int> missing;
    for (int number = 0; number < count; ++number)
        if (!record.frames.contains(number) || !fs::exists(frame_name(pattern, number)))
            missing.push_back(number);
    return missing;
}

void record_frame(const fs::path& pattern, int number) {
    const fs::path path = frame_record(pattern);
    std::ofstream stream(path, std::ios::binary | std::ios::app);
    if (!(stream << fmt::format("{}{}\n", kDone, number)).flush())
        throw Error(fmt::format("{}: cannot be written", path.string()));
}

}  // namespace pim
