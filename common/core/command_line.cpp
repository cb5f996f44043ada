// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/core/command_line.h"

#include <array>
#include <charconv>
#include <cmath>
#include <new>
#include <optional>

#include "common/core/error.h"
#include "common/core/interrupt.h"
#include "common/core/log.h"
#include "common/core/parallel.h"

namespace pim {

int run_program(const CommonOptions& options, const std::function<void()>& work) {
    try {
        set_log_level(options.quiet ? "error" : options.log_level);
        catch_interrupts();
        const ThreadLimit limit(options.threads);
        work();
        return kExitDone;
    } catch (const Interrupted& e) {
        log_error(e.what());
        return kExitInterrupted;
    } catch (const UsageError& e) {
        log_error(e.what());
        return kExitUsage;
    } catch (const std::bad_alloc&) {
        log_error("there is not enough memory; use larger cells, fewer boxes or set [grid] bounds");
        return kExitFailed;
    } catch (const std::exception& e) {
        log_error(e.what());
        return kExitFailed;
    }
}

std::array<double, 3> parse_triple(const std::string& text, const std::string& option) {
    std::array<double, 3> values{};
    const char *at = text.data(), *end = text.data() + text.size();
    for (int i = 0; i < 3; ++i) {
        const auto [rest, problem] = std::from_chars(at, end, values[i]);
        const bool last = i == 2;
        if (problem != std::errc() || !std::isfinite(values[i]) ||
            (last ? rest != end : rest == end || *rest != ','))
            throw UsageError(fmt::format("{}: '{}' is not three numbers x,y,z", option, text));
        at = rest + 1;
    }
    return values;
}

}  // namespace pim
