// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// Areas, normals, lengths and angles of triangle meshes, as every step downstream needs them.

#include <Eigen/Core>

#include "vcg_ext/base/matrices.h"

namespace sphere_propagation {

/// Area of each face, #F.
Eigen::VectorXd faceAreas(const Points& vertices, const Triangles& faces);

/// Radius of the sphere of this area: the size of a surface.
double radiusOfSphere(double area);

/// A third of the area of the faces around each vertex, #V.
Eigen::VectorXd vertexAreas(const Points& vertices, const Triangles& faces);

/// Unit normal of each face, #F by 3; zero for a face without area.
Points faceNormals(const Points& vertices, const Triangles& faces);

/// Unit normal of each vertex, #V by 3: the normals of its faces weighted by their areas; zero
/// where they cancel.
Points vertexNormals(const Points& vertices, const Triangles& faces);

/// Mean edge length, each edge counted once per face.
double meanEdgeLength(const Points& vertices, const Triangles& faces);

/// The three corner angles of each face in radians, #F by 3.
Points cornerAngles(const Points& vertices, const Triangles& faces);

/// The enclosed volume of a closed mesh.
double enclosedVolume(const Points& vertices, const Triangles& faces);

}  // namespace sphere_propagation
