// SPDX-License-Identifier: GPL-3.0-or-later
#include "viewer/relight/kernels.h"

namespace pim {
namespace plain {
extern const Kernels kKernels;
}
namespace avx2 {
extern const Kernels kKernels;
}
namespace avx512 {
extern const Kernels kKernels;
}

const char* name(VectorUnit unit) {
    return unit == VectorUnit::avx512 ? "avx512" : unit == VectorUnit::avx2 ? "avx2" : "plain";
}

bool is_supported(VectorUnit unit) {
    switch (unit) {
        case VectorUnit::avx512:
            return __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") &&
                   __builtin_cpu_supports("avx512bw") && __builtin_cpu_supports("avx512vl");
        case VectorUnit::avx2:
            return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma");
        case VectorUnit::plain:
            return true;
    }
    return false;
}

VectorUnit best_vector_unit() {
    for (const VectorUnit unit : {VectorUnit::avx512, VectorUnit::avx2})
        if (is_supported(unit)) return unit;
    return VectorUnit::plain;
}

std::optional<VectorUnit> find_vector_unit(const std::string& wanted) {
    for (const VectorUnit unit : {VectorUnit::plain, VectorUnit::avx2, VectorUnit::avx512})
        if (wanted == name(unit)) return unit;
    return std::nullopt;
}

const Kernels& kernels(VectorUnit unit) {
    if (unit == VectorUnit::avx512) return avx512::kKernels;
    return unit == VectorUnit::avx2 ? avx2::kKernels : plain::kKernels;
}

}  // namespace pim
