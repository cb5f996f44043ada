// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/core/parallel.h"

#include <tbb/global_control.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

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
    tbb::parallel_for(std::size_t{0}, count, [&](std::size_t i) {
        throw_if_interrupted();
        body(i);
    });
}

}  // namespace pim
