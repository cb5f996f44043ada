// SPDX-License-Identifier: GPL-3.0-or-later
// The numbered pictures of a film, and a record beside them of which are done, so that a rendering that was
// stopped goes on.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace pim {

// frame_%04d.png and 7 give frame_0007.png. Throws UsageError unless the file's name holds exactly one %d or
// %0Nd (N from 1 to 9) and no other %.
std::filesystem::path frame_name(const std::filesystem::path& pattern, int number);

// frame_%04d.png.record, beside the frames. Throws UsageError as frame_name.
std::filesystem::path frame_record(const std::filesystem::path& pattern);

// Those of the frames 0 ... count-1 that are still to be rendered: a frame is done if the record names it and
// its file exists. `key`: all that decides the pictures, as text. The first call writes the record.
// Throws Error where frames of another key, or pictures that no record knows, stand under those names;
// `overwrite` starts anew instead, and removes the frames that the old record names.
std::vector<int> missing_frames(const std::filesystem::path& pattern, int count, const std::string& key,
                                bool overwrite = false);

// To be called when the frame's file is complete. Throws Error.
void record_frame(const std::filesystem::path& pattern, int number);

}  // namespace pim
