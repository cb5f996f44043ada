// SPDX-License-Identifier: GPL-3.0-or-later
#include "viewer/relight/kernels.h"

namespace pim::avx2 {
#include "viewer/relight/kernels.inl"
}  // namespace pim::avx2
