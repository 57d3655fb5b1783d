// Vectors and 3 x 3 matrices, and arrays of vectors stored as three arrays of components.
#pragma once

#include "arithmetic.hpp"

namespace graincal {

template <class Real> struct Vec3 {
    Real x{}, y{}, z{};

    constexpr Vec3& operator+=(const Vec3& b) {
        x += b.x, y += b.y, z += b.z;
        return *this;
    }
    constexpr Vec3& operator-=(const Vec3& b) {
        x -= b.x, y -= b.y, z -= b.z;
        return *this;
    }
    constexpr Vec3& operator*=(Real a) {
        x *= a, y *= a, z *= a;
        return *this;
    }
    constexpr Real& operator[](Index axis) { return axis == 0 ? x : (axis == 1 ? y : z); }
    constexpr Real operator[](Index axis) const { return axis == 0 ? x : (axis == 1 ? y : z); }
};

template <class Real> constexpr Vec3<Real> operator+(Vec3<Real> a, const Vec3<Real>& b) { return a += b; }
template <class Real> constexpr Vec3<Real> operator-(Vec3<Real> a, const Vec3<Real>& b) { return a -= b; }
template <class Real> constexpr Vec3<Real> operator*(Real a, Vec3<Real> b) { return b *= a; }
template <class Real> constexpr Vec3<Real> operator-(const Vec3<Real>& a) { return {-a.x, -a.y, -a.z}; }
template <class Real> constexpr Real dot(const Vec3<Real>& a, const Vec3<Real>& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
template <class Real> constexpr Vec3<Real> cross(const Vec3<Real>& a, const Vec3<Real>& b) {
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
template <class Real> constexpr Vec3<Real> componentwise(const Vec3<Real>& a, const Vec3<Real>& b) { return {a.x * b.x, a.y * b.y, a.z * b.z}; }
template <class To, class Real> constexpr Vec3<To> as(const Vec3<Real>& a) { return {To(a.x), To(a.y), To(a.z)}; }
template <class Real> Real norm(const Vec3<Real>& a) { return square_root(dot(a, a)); }
template <class Real> constexpr Real largest(const Vec3<Real>& a) { return maximum(a.x, maximum(a.y, a.z)); }

template <class Real> struct Mat3 {
    Vec3<Real> row[3];

    constexpr Real& operator()(Index i, Index j) { return row[i][j]; }
    constexpr Real operator()(Index i, Index j) const { return row[i][j]; }
    constexpr Mat3& operator+=(const Mat3& b) {
        for (Index i = 0; i < 3; ++i) row[i] += b.row[i];
        return *this;
    }
    static constexpr Mat3 diagonal(const Vec3<Real>& d) { return {{{d.x, 0, 0}, {0, d.y, 0}, {0, 0, d.z}}}; }
    static constexpr Mat3 identity() { return diagonal({1, 1, 1}); }
};

template <class Real> constexpr Vec3<Real> operator*(const Mat3<Real>& a, const Vec3<Real>& b) {
    return {dot(a.row[0], b), dot(a.row[1], b), dot(a.row[2], b)};
}
template <class Real> constexpr Mat3<Real> operator*(Real a, Mat3<Real> b) {
    for (auto& row : b.row) row *= a;
    return b;
}
template <class Real> constexpr Mat3<Real> operator*(const Mat3<Real>& a, const Mat3<Real>& b) {
    Mat3<Real> product;
    for (Index i = 0; i < 3; ++i) product.row[i] = a(i, 0) * b.row[0] + a(i, 1) * b.row[1] + a(i, 2) * b.row[2];
    return product;
}
template <class Real> constexpr Mat3<Real> operator+(Mat3<Real> a, const Mat3<Real>& b) { return a += b; }
template <class Real> constexpr Mat3<Real> operator-(Mat3<Real> a, const Mat3<Real>& b) {
    for (Index i = 0; i < 3; ++i) a.row[i] -= b.row[i];
    return a;
}
template <class To, class Real> constexpr Mat3<To> as(const Mat3<Real>& a) { return {{as<To>(a.row[0]), as<To>(a.row[1]), as<To>(a.row[2])}}; }
template <class Real> constexpr Mat3<Real> outer(const Vec3<Real>& a, const Vec3<Real>& b) { return {{a.x * b, a.y * b, a.z * b}}; }
template <class Real> constexpr Real trace(const Mat3<Real>& a) { return a(0, 0) + a(1, 1) + a(2, 2); }
template <class Real> constexpr Real determinant(const Mat3<Real>& a) { return dot(a.row[0], cross(a.row[1], a.row[2])); }
template <class Real> constexpr Mat3<Real> inverse(const Mat3<Real>& a) {
    const Real scale = Real(1) / determinant(a);
    const Vec3<Real> c0 = cross(a.row[1], a.row[2]), c1 = cross(a.row[2], a.row[0]), c2 = cross(a.row[0], a.row[1]);
    return scale * Mat3<Real>{{{c0.x, c1.x, c2.x}, {c0.y, c1.y, c2.y}, {c0.z, c1.z, c2.z}}};
}
template <class Real> constexpr Real double_contraction(const Mat3<Real>& a, const Mat3<Real>& b) {
    return dot(a.row[0], b.row[0]) + dot(a.row[1], b.row[1]) + dot(a.row[2], b.row[2]);
}
template <class Real> constexpr Mat3<Real> deviator(const Mat3<Real>& a) { return a - (trace(a) / Real(3)) * Mat3<Real>::identity(); }
template <class Real> Real frobenius_norm(const Mat3<Real>& a) { return square_root(double_contraction(a, a)); }

// A matrix that stretches along the axes alone.
template <class Real> struct Diagonal {
    Vec3<Real> entries;

    static constexpr Diagonal of(const Mat3<Real>& a) { return {{a(0, 0), a(1, 1), a(2, 2)}}; }
};
template <class Real> constexpr Vec3<Real> operator*(const Diagonal<Real>& a, const Vec3<Real>& b) { return componentwise(a.entries, b); }
template <class To, class Real> constexpr Diagonal<To> as(const Diagonal<Real>& a) { return {as<To>(a.entries)}; }
template <class Real> constexpr bool is_diagonal(const Mat3<Real>& a) {
    return a(0, 1) == 0 && a(0, 2) == 0 && a(1, 0) == 0 && a(1, 2) == 0 && a(2, 0) == 0 && a(2, 1) == 0;
}

// An array of vectors as three arrays of components.
template <class Real> struct Vec3Array {
    Real *x, *y, *z;

    Vec3<Real> operator[](Index i) const { return {x[i], y[i], z[i]}; }
    void set(Index i, const Vec3<Real>& v) const { x[i] = v.x, y[i] = v.y, z[i] = v.z; }
};

}  // namespace graincal
