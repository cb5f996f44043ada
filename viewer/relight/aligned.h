// SPDX-License-Identifier: GPL-3.0-or-later
// Arrays that vector units load whole lines of.
#pragma once

#include <cstddef>
#include <new>
#include <utility>
#include <vector>

namespace pim {

template <class T>
struct LineAllocator {
    using value_type = T;
    LineAllocator() = default;
    template <class U>
    LineAllocator(const LineAllocator<U>&) {}
    T* allocate(std::size_t n) {
        return static_cast<T*>(::operator new(n * sizeof(T), std::align_val_t(64)));
    }
    // resize() leaves new elements as they are: whoever asks for them fills them.
    template <class U>
    void construct(U* p) {
        ::new (static_cast<void*>(p)) U;
    }
    template <class U, class... A>
    void construct(U* p, A&&... arguments) {
        ::new (static_cast<void*>(p)) U(std::forward<A>(arguments)...);
    }
    void deallocate(T* p, std::size_t) { ::operator delete(p, std::align_val_t(64)); }
    bool operator==(const LineAllocator&) const { return true; }
};

template <class T>
using AlignedVector = std::vector<T, LineAllocator<T>>;

// To another size, what it held is lost: takes little more memory than that, where resize() may double it.
template <class T>
void reshape(AlignedVector<T>& v, std::size_t size) {
    if (size > v.capacity()) {
        v = {};
        v.reserve(size + size / 8);
    }
    v.resize(size);
}

}  // namespace pim
