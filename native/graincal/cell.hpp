// The periodic cell: its edge vectors are the columns of H, and it deforms with the velocity gradient L.
#pragma once

#include "vec3.hpp"

namespace graincal {

struct Cell {
    Mat3<Coordinate> edges = Mat3<Coordinate>::identity();          // H
    Mat3<Coordinate> initial_edges = Mat3<Coordinate>::identity();  // where strain is zero
    Mat3<Coordinate> velocity_gradient = Mat3<Coordinate>{};        // L of the latest motion

    Coordinate volume() const { return determinant(edges); }

    // The shortest of the periodic images of a difference of fractional coordinates.
    static Vec3<Coordinate> nearest_image(Vec3<Coordinate> ds) {
        return {ds.x - nearest_integer(ds.x), ds.y - nearest_integer(ds.y), ds.z - nearest_integer(ds.z)};
    }
    Vec3<Coordinate> branch(const Vec3<Coordinate>& s1, const Vec3<Coordinate>& s2) const { return edges * nearest_image(s2 - s1); }

    // Logarithmic strain per axis, compression positive.
    Coordinate strain(Index axis) const { return logarithm(initial_edges(axis, axis) / edges(axis, axis)); }

    // The distance between opposite faces.
    Vec3<Coordinate> widths() const {
        const Mat3<Coordinate> reciprocal = inverse(edges);
        return {Coordinate(1) / norm(reciprocal.row[0]), Coordinate(1) / norm(reciprocal.row[1]), Coordinate(1) / norm(reciprocal.row[2])};
    }
    void advance(Coordinate dt) { edges += dt * (velocity_gradient * edges); }
};

}  // namespace graincal
