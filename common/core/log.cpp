// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/core/log.h"

#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>

#include "common/core/error.h"

namespace pim {
namespace {

spdlog::logger& logger() {
    static const std::shared_ptr<spdlog::logger> instance = [] {
        auto made =
            std::make_shared<spdlog::logger>("pim", std::make_shared<spdlog::sinks::stderr_color_sink_mt>());
        made->set_pattern("%^%l%$: %v");
        return made;
    }();
    return *instance;
}

}  // namespace

void set_log_level(const std::string& level) {
    for (const char* known : {"debug", "info", "warning", "error", "off"})
        if (level == known) return logger().set_level(spdlog::level::from_str(level));
    throw UsageError(fmt::format("log level '{}' is unknown: use debug, info, warning, error or off", level));
}

void log_debug(const std::string& message) { logger().debug(message); }
void log_info(const std::string& message) { logger().info(message); }
void log_warning(const std::string& message) { logger().warn(message); }
void log_error(const std::string& message) { logger().error(message); }
bool log_info_enabled() { return logger().should_log(spdlog::level::info); }

}  // namespace pim
