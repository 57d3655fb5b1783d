// Elementary functions, under one name for g++ and NVRTC: the physics headers include nothing but each other.
#pragma once

namespace graincal {

using Index = int;

// Positions, the cell and all that is found from them: kept in float64 whatever the precision of forces, since an overlap is a small difference of
// large lengths. At E = 1e11 Pa and 0.5 MPa it is 1e-5 of a radius, and a float32 distance rounds at 1e-7 of one.
using Coordinate = double;

#if defined(__CUDACC_RTC__)
inline double square_root(double x) { return ::sqrt(x); }
inline float square_root(float x) { return ::sqrtf(x); }
inline double nearest_integer(double x) { return ::rint(x); }
inline double logarithm(double x) { return ::log(x); }
#else
inline double square_root(double x) { return __builtin_sqrt(x); }
inline float square_root(float x) { return __builtin_sqrtf(x); }
inline double nearest_integer(double x) { return __builtin_rint(x); }
inline double logarithm(double x) { return __builtin_log(x); }
#endif

template <class T> constexpr T minimum(T a, T b) { return b < a ? b : a; }
template <class T> constexpr T maximum(T a, T b) { return a < b ? b : a; }
template <class T> constexpr T absolute(T a) { return a < T(0) ? -a : a; }
template <class T> constexpr T sign(T a) { return T(T(0) < a) - T(a < T(0)); }
template <class T> constexpr T clamp(T a, T largest) { return a > largest ? largest : (a < -largest ? -largest : a); }
template <class T> constexpr bool is_finite(T a) { return a - a == T(0); }
template <class T> constexpr T infinity() {
    T large = T(1e38);
    for (int doubling = 0; doubling < 4; ++doubling) large *= large;
    return large;
}
template <class T> constexpr void exchange(T& a, T& b) {
    T held = a;
    a = b;
    b = held;
}

}  // namespace graincal
