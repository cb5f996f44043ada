// SPDX-License-Identifier: GPL-3.0-or-later
// What the tests of the vector units have in common.
#pragma once

#include "measured.h"
#include "synthetic_maps.h"
#include "viewer/relight/aligned.h"
#include "viewer/relight/kernels.h"

namespace pim {

inline constexpr double kRound = 0x1p-24;  // the largest relative error of one rounding

using Floats = AlignedVector<float>;

class KernelsOf : public testing::TestWithParam<VectorUnit> {
  protected:
    void SetUp() override {
        if (!is_supported(GetParam())) GTEST_SKIP() << "this processor has no " << name(GetParam());
    }
    const Kernels& own() const { return kernels(GetParam()); }
    const Kernels& plain() const { return kernels(VectorUnit::plain); }
    Dice dice_{1};
};

// One run per vector unit, under its name.
#define PIM_FOR_EACH_UNIT(suite)                                                                       \
    INSTANTIATE_TEST_SUITE_P(Units, suite,                                                             \
                             testing::Values(VectorUnit::plain, VectorUnit::avx2, VectorUnit::avx512), \
                             [](const auto& unit) { return std::string(name(unit.param)); })

}  // namespace pim
