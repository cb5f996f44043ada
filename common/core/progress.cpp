// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/core/progress.h"

#include <unistd.h>

#include <cstdio>

#include "common/core/log.h"

namespace pim {
namespace {

std::string duration_text(double seconds) {
    const auto s = int64_t(seconds + 0.5);
    if (s >= 3600) return fmt::format("{}h{:02}m", s / 3600, s / 60 % 60);
    return s >= 60 ? fmt::format("{}m{:02}s", s / 60, s % 60) : fmt::format("{}s", s);
}

}  // namespace

Progress::Progress(std::string what, uint64_t total)
    : what_(std::move(what)),
      total_(total),
      start_(std::chrono::steady_clock::now()),
      next_show_(0.5),
      terminal_(isatty(STDERR_FILENO) != 0) {}

Progress::~Progress() {
    if (terminal_ && shown_) std::fputs("\r\033[K", stderr);
}

void Progress::advance(uint64_t steps) {
    const uint64_t done = done_ += steps;
    const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - start_;
    if (!log_info_enabled() || elapsed.count() < next_show_) return;
    const std::lock_guard lock(mutex_);
    if (elapsed.count() < next_show_) return;
    next_show_ = elapsed.count() + (terminal_ ? 0.2 : 5.0);
    show(done);
}

void Progress::show(uint64_t done) {
    const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - start_;
    const double share = total_ ? double(done) / double(total_) : 1.0;
    const double left = share > 0 ? elapsed.count() * (1 - share) / share : 0;
    const std::string text = fmt::format("{}: {} of {} ({:.0f} %), {} left", what_, done, total_, 100 * share,
                                         duration_text(left));
    if (terminal_) {
        const int filled = int(30 * share);
        fmt::print(stderr, "\r\033[K[{}{}] {}", std::string(filled, '#'), std::string(30 - filled, '.'),
                   text);
        std::fflush(stderr);
    } else {
        log_info(text);
    }
    shown_ = true;
}

}  // namespace pim
