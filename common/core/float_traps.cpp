// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/core/float_traps.h"

#include <cfenv>
#include <cstdlib>

namespace pim {
namespace {

constexpr int kTrapped = FE_INVALID | FE_DIVBYZERO | FE_OVERFLOW;

bool wanted() {
    static const bool is_set = std::getenv("PIM_TRAP_FLOATS") != nullptr;
    return is_set;
}

// What happened before must not be laid at the door of what follows.
void set(int traps) {
    std::feclearexcept(FE_ALL_EXCEPT);
    fedisableexcept(FE_ALL_EXCEPT);
    feenableexcept(traps);
}

}  // namespace

FloatTraps::FloatTraps(State state) {
    if (!wanted()) return;
    before_ = fegetexcept();
    set(state == on ? kTrapped : 0);
}

FloatTraps::~FloatTraps() {
    if (wanted()) set(before_);
}

}  // namespace pim
