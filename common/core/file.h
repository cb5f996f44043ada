// SPDX-License-Identifier: GPL-3.0-or-later
// Files that are there whole or not at all, and fingerprints of content.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <string_view>

namespace pim {

// Calls write(temporary path beside `path`), syncs the file, renames it to `path`. On an exception the
// temporary file is removed and `path` is untouched. The temporary name keeps the extension. Throws Error.
void write_atomically(const std::filesystem::path& path,
                      const std::function<void(const std::filesystem::path&)>& write);
void write_text_atomically(const std::filesystem::path& path, const std::string& text);

std::string read_text(const std::filesystem::path& path);  // throws Error

void check_input(const std::filesystem::path& path);  // throws Error: no file there

// Before long work: can `path` become a file? Throws Error: its folder is missing, or it is a folder itself.
void check_output(const std::filesystem::path& path);

// Held by one process at a time, while it lives; others wait. Creates the file. Throws Error.
class FileLock {
  public:
    explicit FileLock(const std::filesystem::path& path);
    ~FileLock();
    FileLock(const FileLock&) = delete;
    FileLock& operator=(const FileLock&) = delete;

  private:
    int descriptor_;
};

// 128-bit content hash; feed() chains.
class ContentHash {
  public:
    void feed(const void* data, std::size_t bytes);
    void feed(std::string_view text) { feed(text.data(), text.size()); }
    std::string hex() const;  // 32 hexadecimal digits

  private:
    uint64_t low_ = 0x70696d, high_ = 0x6d6970;
};

}  // namespace pim
