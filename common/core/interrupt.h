// SPDX-License-Identifier: GPL-3.0-or-later
// Ctrl-C and SIGTERM: long loops ask between two units of work, and stop there.
#pragma once

namespace pim {

void catch_interrupts();
void throw_if_interrupted();  // throws Interrupted

}  // namespace pim
