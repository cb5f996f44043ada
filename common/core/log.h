// SPDX-License-Identifier: GPL-3.0-or-later
// Messages for the user, on stderr; results go to stdout.
#pragma once

#include <fmt/format.h>

#include <string>

namespace pim {

// level: "debug", "info", "warning", "error" or "off". Throws UsageError.
void set_log_level(const std::string& level);
void log_debug(const std::string& message);
void log_info(const std::string& message);
void log_warning(const std::string& message);
void log_error(const std::string& message);
bool log_info_enabled();

}  // namespace pim
