// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/core/parallel.h"

#include <tbb/global_control.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <atomic>
#include <exception>
#include <mutex>

#include "common/core/float_traps.h"
#include "common/core/interrupt.h"

namespace pim {

using Control = tbb::global_control;

ThreadLimit::ThreadLimit(int threads)
    : control_(threads > 0 ? new Control(Control::max_allowed_parallelism, std::size_t(threads)) : nullptr) {}

ThreadLimit::~ThreadLimit() { delete static_cast<Control*>(control_); }

int thread_count() {
    return int(std::min(Control::active_value(Control::max_allowed_parallelism),
                        std::size_t(tbb::this_task_arena::max_concurrency())));
}

void parallel_for(std::size_t count, const std::function<void(std::size_t)>& body) {
    // An exception that leaves a body would cancel all loops inside the other bodies too, without a word,
    // those of libraries included, and what they were writing would be garbage. So it is carried out by hand.
    std::atomic<bool> failed = false;
    std::exception_ptr first;
    std::mutex mutex;
    tbb::parallel_for(std::size_t{0}, count, [&](std::size_t i) {
        if (failed) return;
        try {
            throw_if_interrupted();
            const FloatTraps ours(FloatTraps::on);
            body(i);
        } catch (...) {
            const std::lock_guard lock(mutex);
            if (!first) first = std::current_exception();
            failed = true;
        }
    });
    if (first) std::rethrow_exception(first);
}

}  // namespace pim
