// One block of memory holds all arrays of a simulation: the same layout is taken on a host and on a device.
#pragma once

#include "vec3.hpp"

namespace graincal {

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
