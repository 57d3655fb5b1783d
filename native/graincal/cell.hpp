// The periodic cell: its edge vectors are the columns of H, and it deforms with the velocity gradient L.
#pragma once

#include "vec3.hpp"

namespace graincal {

template <class Real> struct Cell {
    Mat3<Real> edges = Mat3<Real>::identity();              // H
    Mat3<Real> initial_edges = Mat3<Real>::identity();      // where strain is zero
    Mat3<Real> velocity_gradient = Mat3<Real>{};            // L of the latest motion

    Real volume() const { return determinant(edges); }

    // The shortest of the periodic images of a difference of fractional coordinates.
    static Vec3<Real> nearest_image(Vec3<Real> ds) {
        return {ds.x - nearest_integer(ds.x), ds.y - nearest_integer(ds.y), ds.z - nearest_integer(ds.z)};
    }
    Vec3<Real> branch(const Vec3<Real>& s1, const Vec3<Real>& s2) const { return edges * nearest_image(s2 - s1); }

    // Logarithmic strain per axis, compression positive.
    Real strain(Index axis) const { return logarithm(initial_edges(axis, axis) / edges(axis, axis)); }

    // The distance between opposite faces.
    Vec3<Real> widths() const {
        const Mat3<Real> reciprocal = inverse(edges);
        return {Real(1) / norm(reciprocal.row[0]), Real(1) / norm(reciprocal.row[1]), Real(1) / norm(reciprocal.row[2])};
    }
    void advance(Real dt) { edges += dt * (velocity_gradient * edges); }
};

}  // namespace graincal
