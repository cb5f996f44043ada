// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/core/interrupt.h"

#include <csignal>

#include "common/core/error.h"

namespace pim {
namespace {

volatile std::sig_atomic_t interrupted = 0;

void note_signal(int signal) {
    interrupted = 1;
    std::signal(signal, SIG_DFL);  // a second one ends the program at once
}

}  // namespace

void catch_interrupts() {
    std::signal(SIGINT, note_signal);
    std::signal(SIGTERM, note_signal);
}

void throw_if_interrupted() {
    if (interrupted) throw Interrupted();
}

}  // namespace pim
