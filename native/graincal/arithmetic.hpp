// Elementary functions, under one name for g++ and NVRTC: the physics headers include nothing but each other.
#pragma once

namespace graincal {

using Index = int;

#if defined(__CUDACC_RTC__)
inline double square_root(double x) { return ::sqrt(x); }
inline double nearest_integer(double x) { return ::rint(x); }
inline double logarithm(double x) { return ::log(x); }
#else
inline double square_root(double x) { return __builtin_sqrt(x); }
inline double nearest_integer(double x) { return __builtin_rint(x); }
inline double logarithm(double x) { return __builtin_log(x); }
#endif

template <class T> constexpr T minimum(T a, T b) { return b < a ? b : a; }
template <class T> constexpr T maximum(T a, T b) { return a < b ? b : a; }
template <class T> constexpr T absolute(T a) { return a < T(0) ? -a : a; }
template <class T> constexpr T sign(T a) { return T(T(0) < a) - T(a < T(0)); }
template <class T> constexpr T clamp(T a, T largest) { return a > largest ? largest : (a < -largest ? -largest : a); }
template <class T> constexpr bool is_finite(T a) { return a - a == T(0); }
template <class T> constexpr T infinity() { return T(1e300) * T(1e300); }
template <class T> constexpr void exchange(T& a, T& b) {
    T held = a;
    a = b;
    b = held;
}

}  // namespace graincal
