// One block of memory holds all arrays of a simulation: the same layout is taken on a host and on a device. And how it is asked for ahead of its use.
#pragma once

#include "vec3.hpp"

namespace graincal {

// Asks for memory that is needed soon, into the second cache: the first has no room for it yet. Devices go on with other threads instead. Always
// inline: g++ takes a function that does nothing else for one without effect, and leaves its calls out.
#if defined(__CUDACC_RTC__)
inline void fetch_ahead(const void*) {}
#else
[[gnu::always_inline]] inline void fetch_ahead(const void* at) { __builtin_prefetch(at, 0, 2); }
#endif
template <class Real> [[gnu::always_inline]] inline void fetch_ahead(const Vec3Array<Real>& vectors, Index i) {
    fetch_ahead(vectors.x + i), fetch_ahead(vectors.y + i), fetch_ahead(vectors.z + i);
}

class Arena {
  public:
    using Size = unsigned long long;

    // Without a block to carve, `used` tells how large one is needed.
    explicit Arena(char* block = nullptr) : block_(block) {}

    template <class T> T* take(Index count) {
        constexpr Size alignment = 64;
        used_ = (used_ + alignment - 1) / alignment * alignment;
        T* start = block_ ? reinterpret_cast<T*>(block_ + used_) : nullptr;
        used_ += sizeof(T) * Size(count);
        return start;
    }
    template <class Real> Vec3Array<Real> take_vectors(Index count) {
        Real* x = take<Real>(count);
        Real* y = take<Real>(count);
        Real* z = take<Real>(count);
        return {x, y, z};
    }
    Size used() const { return used_; }

  private:
    char* block_;
    Size used_ = 0;
};

}  // namespace graincal
