// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// Meshes for tests: good ones, and bad ones each with one named defect.

#include <Eigen/Core>
#include <random>
#include <string>

#include "vcg_ext/base/matrices.h"
#include "vcg_ext/mesh/closed_surface.h"

namespace sphere_propagation::test {

inline constexpr double pi = 3.14159265358979323846;

struct Mesh {
  Points vertices;
  Triangles faces;
};

/// Random numbers that are the same with every standard library.
class Random {
 public:
  explicit Random(unsigned seed) : bits_(seed) {}
  /// In [0, 1).
  double uniform() { return static_cast<double>(bits_() >> 11) * 0x1p-53; }
  double uniform(double low, double high) { return low + (high - low) * uniform(); }
  /// Standard normal.
  double normal();
  /// Uniform on the unit sphere.
  Vector3 direction();
  /// Uniform in 0 .. count - 1.
  int index(int count) { return static_cast<int>(uniform() * count); }

 private:
  std::mt19937_64 bits_;
};

/// Uniformly distributed rotation.
Eigen::Matrix3d randomRotation(unsigned seed);

// Closed, outward oriented, genus 0; the first four are inscribed in the unit sphere.
Mesh tetrahedron();
Mesh octahedron();
Mesh icosahedron();
/// The icosahedron with every edge split into `frequency`: 10 f^2 + 2 vertices. Slow and simple,
/// numbered as they come.
Mesh icosphereMesh(int frequency);
/// An icosphere scaled to these semi-axes.
Mesh ellipsoid(double a, double b, double c, int frequency = 8);
/// An ellipsoid (30, 20, 15), 642 vertices, with independent radial noise of 3 % and turned at
/// random.
Mesh noisyEllipsoid(unsigned seed);
/// Two apexes (vertices 0 and 1, at +z and -z) over an equator of `sides` vertices.
Mesh bipyramid(int sides);
/// On the unit sphere, with faces of very different sizes: rings of eight vertices round the north
/// pole, each twice as far from it as the one before, from `least` radian to about 1, and the south
/// pole. Vertex 0 is the north pole.
Mesh rings(double least);
/// A thick cup, the shape of the ventricle's wall: a half ellipsoid of radius 1 and depth 1.2 with
/// a wall of this thickness, rings of `around` vertices, `along` rings from an apex to the rim.
Mesh cup(double thickness, int around, int along);
/// The unit cube, each side an n x n grid of squares cut in two.
Mesh box(int n);
/// A tetrahedron with a triangular tube of so many segments on each face: four limbs.
Mesh tetrapod(int segments);
/// An octahedron with an additional vertex at the middle of an edge, inside a face that so loses a
/// zero-area part.
Mesh withZeroAreaFace();

// Not closed, not manifold, not a sphere, not oriented, or not even a mesh.
Mesh openCone();                ///< 8 sides, no base: 8 open edges
Mesh nonManifoldEdge();         ///< two tetrahedra that share the edge (0, 1)
Mesh nonManifoldVertex();       ///< two tetrahedra that share vertex 0
Mesh torus();                   ///< 16 x 8, genus 1
Mesh twoSpheres();              ///< two octahedra, the second begins at vertex 6
Mesh flippedFace();             ///< icosahedron, face 7 reversed
Mesh inwardSphere();            ///< icosahedron, all faces reversed
Mesh withUnreferencedVertex();  ///< icosahedron and vertex 12
Mesh withNaN();                 ///< icosahedron, vertex 5
Mesh withDegenerateFace();      ///< icosahedron and face 20 = (0, 0, 1)
Mesh duplicatedVertices();  ///< icosahedron as a soup of 20 faces with three vertices of their own
                            ///< each

/// The mirror image, oriented outwards.
Mesh mirrored(Mesh mesh);
/// The same mesh stretched along the axes.
Mesh stretched(Mesh mesh, double x, double y, double z);
/// The same mesh in another place: rotation, then scale, then translation.
Mesh transformed(Mesh mesh, const Eigen::Matrix3d& rotation, double scale,
                 const Vector3& translation);

ClosedSurface surfaceOf(const Mesh& mesh, const std::string& name = "surface");

/// Between points of the same row.
double largestDistance(const Points& a, const Points& b);

}  // namespace sphere_propagation::test
