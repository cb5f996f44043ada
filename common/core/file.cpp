// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/core/file.h"

#include <OpenImageIO/hash.h>
#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <fstream>
#include <iterator>
#include <random>

#include "common/core/error.h"

namespace pim {
namespace fs = std::filesystem;
namespace {

void sync(const fs::path& path, int flags) {
    const int descriptor = ::open(path.c_str(), flags);
    if (descriptor < 0)
        throw Error(fmt::format("{}: cannot be opened: {}", path.string(), std::strerror(errno)));
    const int failed = ::fsync(descriptor);
    ::close(descriptor);
    if (failed)
        throw Error(fmt::format("{}: cannot be written to disk: {}", path.string(), std::strerror(errno)));
}

fs::path folder_of(const fs::path& file) {
    return file.has_parent_path() ? file.parent_path() : fs::path(".");
}

}  // namespace

void check_input(const fs::path& path) {
    if (fs::is_directory(path)) throw Error(fmt::format("{}: is a folder, not a file", path.string()));
    if (!fs::is_regular_file(path)) throw Error(fmt::format("{}: there is no such file", path.string()));
}

void check_output(const fs::path& path) {
    const fs::path folder = folder_of(path);
    if (!fs::is_directory(folder))
        throw Error(
            fmt::format("{}: the folder {} does not exist; create it first", path.string(), folder.string()));
    if (fs::is_directory(path))
        throw Error(fmt::format("{}: is a folder; name a file to write", path.string()));
}

FileLock::FileLock(const fs::path& path)
    : descriptor_(::open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666)) {
    if (descriptor_ < 0 || ::flock(descriptor_, LOCK_EX) != 0) {
        const int problem = errno;
        if (descriptor_ >= 0) ::close(descriptor_);
        throw Error(fmt::format("{}: cannot be locked: {}", path.string(), std::strerror(problem)));
    }
}

FileLock::~FileLock() { ::close(descriptor_); }

void write_atomically(const fs::path& path, const std::function<void(const fs::path&)>& write) {
    check_output(path);
    const fs::path folder = folder_of(path);
    const fs::path temporary =
        folder / fmt::format("{}.{:08x}{:08x}.tmp{}", path.stem().string(), std::random_device()(),
                             std::random_device()(), path.extension().string());
    try {
        write(temporary);
        sync(temporary, O_RDONLY);
        fs::rename(temporary, path);
        sync(folder, O_RDONLY | O_DIRECTORY);
    } catch (const fs::filesystem_error& e) {
        std::error_code ignored;
        fs::remove(temporary, ignored);
        throw Error(fmt::format("{}: cannot be written: {}", path.string(), e.code().message()));
    } catch (...) {
        std::error_code ignored;
        fs::remove(temporary, ignored);
        throw;
    }
}

void write_text_atomically(const fs::path& path, const std::string& text) {
    write_atomically(path, [&](const fs::path& temporary) {
        std::ofstream stream(temporary, std::ios::binary);
        if (!(stream << text).flush()) throw Error(fmt::format("{}: cannot be written", path.string()));
    });
}

std::string read_text(const fs::path& path) {
    std::ifstream stream(path, std::ios::binary);
    if (fs::is_directory(path) || !stream)
        throw Error(fmt::format("{}: cannot be read; is the path right?", path.string()));
    std::string text{std::istreambuf_iterator<char>(stream), {}};
    if (stream.bad()) throw Error(fmt::format("{}: cannot be read to its end", path.string()));
    return text;
}

void ContentHash::feed(const void* data, std::size_t bytes) {
    low_ = OIIO::xxhash::xxhash(data, bytes, low_);
    high_ = OIIO::xxhash::xxhash(data, bytes, high_ ^ 0x9E3779B97F4A7C15ull);
}

std::string ContentHash::hex() const { return fmt::format("{:016x}{:016x}", high_, low_); }

}  // namespace pim
