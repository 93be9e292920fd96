// SPDX-License-Identifier: GPL-3.0-only
#include "tests/core/test_meshes.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <utility>
#include <vector>

namespace sphere_propagation::test {
namespace {

void reverse(Mesh& mesh, int face) { std::swap(mesh.faces(face, 1), mesh.faces(face, 2)); }

void append(Mesh& mesh, const Vector3& vertex) {
  mesh.vertices.conservativeResize(mesh.vertices.rows() + 1, 3);
  mesh.vertices.bottomRows(1) = vertex.transpose();
}

void append(Mesh& mesh, int a, int b, int c) {
  mesh.faces.conservativeResize(mesh.faces.rows() + 1, 3);
  mesh.faces.bottomRows(1) << a, b, c;
}

}  // namespace

double Random::normal() {
  const double radius = std::sqrt(-2 * std::log(1 - uniform()));
  return radius * std::cos(2 * pi * uniform());
}

Vector3 Random::direction() {
  const double z = uniform(-1, 1), longitude = 2 * pi * uniform(), across = std::sqrt(1 - z * z);
  return Vector3(across * std::cos(longitude), across * std::sin(longitude), z).normalized();
}

Eigen::Matrix3d randomRotation(unsigned seed) {
  Random random(seed);
  Eigen::Quaterniond q(random.normal(), random.normal(), random.normal(), random.normal());
  return q.normalized().toRotationMatrix();
}

Mesh tetrahedron() {
  Mesh mesh;
  mesh.vertices.resize(4, 3);
  mesh.vertices << 1, 1, 1, 1, -1, -1, -1, 1, -1, -1, -1, 1;
  mesh.vertices /= std::sqrt(3.0);
  mesh.faces.resize(4, 3);
  mesh.faces << 0, 1, 2, 0, 2, 3, 0, 3, 1, 1, 3, 2;
  return mesh;
}

Mesh octahedron() {
  Mesh mesh;
  mesh.vertices.resize(6, 3);
  mesh.vertices << 1, 0, 0, -1, 0, 0, 0, 1, 0, 0, -1, 0, 0, 0, 1, 0, 0, -1;
  mesh.faces.resize(8, 3);
  mesh.faces << 0, 2, 4, 2, 1, 4, 1, 3, 4, 3, 0, 4, 2, 0, 5, 1, 2, 5, 3, 1, 5, 0, 3, 5;
  return mesh;
}

Mesh icosahedron() {
  const double g = (1 + std::sqrt(5.0)) / 2;
  Mesh mesh;
  mesh.vertices.resize(12, 3);
  mesh.vertices << -1, g, 0, 1, g, 0, -1, -g, 0, 1, -g, 0, 0, -1, g, 0, 1, g, 0, -1, -g, 0, 1, -g,
      g, 0, -1, g, 0, 1, -g, 0, -1, -g, 0, 1;
  mesh.vertices.rowwise().normalize();
  mesh.faces.resize(20, 3);
  mesh.faces << 0, 11, 5, 0, 5, 1, 0, 1, 7, 0, 7, 10, 0, 10, 11, 1, 5, 9, 5, 11, 4, 11, 10, 2, 10,
      7, 6, 7, 1, 8, 3, 9, 4, 3, 4, 2, 3, 2, 6, 3, 6, 8, 3, 8, 9, 4, 9, 5, 2, 4, 11, 6, 2, 10, 8, 6,
      7, 9, 8, 1;
  return mesh;
}

Mesh icosphereMesh(int frequency) {
  const Mesh base = icosahedron();
  std::map<std::vector<std::pair<int, int>>, int>
      known;  // (corner, weight) pairs of non-zero weight -> vertex
  std::vector<Vector3> vertices;
  std::vector<Eigen::RowVector3i> faces;
  for (int f = 0; f < 20; ++f) {
    const auto vertex = [&](int i, int j) {  // i steps from corner 0 to 1, j from corner 0 to 2
      const int weight[3] = {frequency - i - j, i, j};
      std::vector<std::pair<int, int>> key;
      Vector3 p = Vector3::Zero();
      for (int k = 0; k < 3; ++k) {
        if (weight[k] > 0) key.emplace_back(base.faces(f, k), weight[k]);
        p += weight[k] * base.vertices.row(base.faces(f, k)).transpose();
      }
      std::sort(key.begin(), key.end());
      const auto [at, fresh] = known.emplace(key, static_cast<int>(vertices.size()));
      if (fresh) vertices.push_back(p.normalized());
      return at->second;
    };
    for (int i = 0; i < frequency; ++i)
      for (int j = 0; i + j < frequency; ++j) {
        faces.emplace_back(vertex(i, j), vertex(i + 1, j), vertex(i, j + 1));
        if (i + j + 1 < frequency)
          faces.emplace_back(vertex(i + 1, j), vertex(i + 1, j + 1), vertex(i, j + 1));
      }
  }
  Mesh mesh;
  mesh.vertices.resize(static_cast<Eigen::Index>(vertices.size()), 3);
  for (size_t v = 0; v < vertices.size(); ++v)
    mesh.vertices.row(static_cast<Eigen::Index>(v)) = vertices[v].transpose();
  mesh.faces.resize(static_cast<Eigen::Index>(faces.size()), 3);
  for (size_t f = 0; f < faces.size(); ++f) mesh.faces.row(static_cast<Eigen::Index>(f)) = faces[f];
  return mesh;
}

Mesh ellipsoid(double a, double b, double c, int frequency) {
  Mesh mesh = icosphereMesh(frequency);
  mesh.vertices.array().rowwise() *= Eigen::Array<double, 1, 3>(a, b, c);
  return mesh;
}

Mesh noisyEllipsoid(unsigned seed) {
  Mesh mesh = ellipsoid(30, 20, 15, 8);
  Random random(seed);
  for (Eigen::Index v = 0; v < mesh.vertices.rows(); ++v)
    mesh.vertices.row(v) *= 1 + 0.03 * random.normal();
  return transformed(std::move(mesh), randomRotation(seed + 1000), 1, Vector3::Zero());
}

Mesh bipyramid(int sides) {
  Mesh mesh;
  mesh.vertices.resize(sides + 2, 3);
  mesh.faces.resize(2 * sides, 3);
  mesh.vertices.row(0) << 0, 0, 1;
  mesh.vertices.row(1) << 0, 0, -1;
  for (int i = 0; i < sides; ++i) {
    const double angle = 2 * pi * i / sides;
    mesh.vertices.row(2 + i) << std::cos(angle), std::sin(angle), 0;
    mesh.faces.row(2 * i) << 0, 2 + i, 2 + (i + 1) % sides;
    mesh.faces.row(2 * i + 1) << 1, 2 + (i + 1) % sides, 2 + i;
  }
  return mesh;
}

Mesh rings(double least) {
  constexpr int sides = 8;
  int count = 0;
  for (double colatitude = least; colatitude < 1.5; colatitude *= 2) ++count;
  const int south = 1 + sides * count;
  Mesh mesh;
  mesh.vertices.resize(south + 1, 3);
  mesh.vertices.row(0) << 0, 0, 1;
  mesh.vertices.row(south) << 0, 0, -1;
  for (int ring = 0; ring < count; ++ring)
    for (int i = 0; i < sides; ++i) {
      const double colatitude = std::ldexp(least, ring),
                   longitude = (i + 0.5 * ring) * 2 * pi / sides;
      const double across = std::sin(colatitude);
      mesh.vertices.row(1 + sides * ring + i) << across * std::cos(longitude),
          across * std::sin(longitude), std::cos(colatitude);
      const int next = (i + 1) % sides, below = 1 + sides * ring, above = below - sides;
      if (ring == 0) {
        append(mesh, 0, 1 + i, 1 + next);
      } else {
        append(mesh, above + i, below + i, above + next);
        append(mesh, above + next, below + i, below + next);
      }
    }
  for (int i = 0; i < sides; ++i)
    append(mesh, south, south - sides + (i + 1) % sides, south - sides + i);
  return mesh;
}

Mesh cup(double thickness, int around, int along) {
  constexpr double depth = 1.2;
  constexpr int rim = 2;  // rings between the outer and the inner edge
  std::vector<Vector2>
      profile;  // radius and height, from the outer apex over the rim to the inner one
  const double inner = 1 - thickness;
  for (int i = 1; i <= along; ++i) {
    const double angle = pi / 2 * i / along;
    profile.emplace_back(std::sin(angle), -depth * std::cos(angle));
  }
  for (int i = 1; i <= rim; ++i) profile.emplace_back(1 - thickness * i / (rim + 1), 0);
  for (int i = along; i >= 1; --i) {
    const double angle = pi / 2 * i / along;
    profile.emplace_back(inner * std::sin(angle), -inner * depth * std::cos(angle));
  }
  const int count = static_cast<int>(profile.size());
  Mesh mesh;
  mesh.vertices.resize(2 + count * around, 3);
  mesh.vertices.row(0) << 0, 0, -depth;
  mesh.vertices.row(1) << 0, 0, -depth * inner;
  const auto vertex = [&](int ring, int i) { return 2 + ring * around + i % around; };
  for (int ring = 0; ring < count; ++ring)
    for (int i = 0; i < around; ++i) {
      const double angle =
          2 * pi * (i + 0.5 * (ring % 2)) / around;  // every other ring turned by half a side
      mesh.vertices.row(vertex(ring, i)) << profile[ring][0] * std::cos(angle),
          profile[ring][0] * std::sin(angle), profile[ring][1];
    }
  for (int i = 0; i < around; ++i) {
    append(mesh, 0, vertex(0, i + 1), vertex(0, i));
    append(mesh, 1, vertex(count - 1, i), vertex(count - 1, i + 1));
    for (int ring = 0; ring + 1 < count; ++ring) {
      const int a = vertex(ring, i), b = vertex(ring, i + 1), c = vertex(ring + 1, i),
                d = vertex(ring + 1, i + 1);
      if (ring % 2 == 0) {
        append(mesh, a, b, c);
        append(mesh, b, d, c);
      } else {
        append(mesh, a, b, d);
        append(mesh, a, d, c);
      }
    }
  }
  return mesh;
}

Mesh box(int n) {
  Mesh mesh;
  std::map<std::vector<int>, int> known;  // grid point -> vertex
  for (int axis = 0; axis < 3; ++axis)
    for (int side = 0; side < 2; ++side)
      for (int i = 0; i < n; ++i)
        for (int j = 0; j < n; ++j) {
          const auto vertex = [&](int a, int b) {
            std::vector<int> p(3);
            p[axis] = side * n, p[(axis + 1) % 3] = a, p[(axis + 2) % 3] = b;
            const auto [at, fresh] = known.emplace(p, static_cast<int>(known.size()));
            if (fresh) append(mesh, Vector3(p[0], p[1], p[2]) / n);
            return at->second;
          };
          const int a = vertex(i, j), b = vertex(i + 1, j), c = vertex(i + 1, j + 1),
                    d = vertex(i, j + 1);
          append(mesh, a, side == 1 ? b : c, side == 1 ? c : b);
          append(mesh, a, side == 1 ? c : d, side == 1 ? d : c);
        }
  return mesh;
}

Mesh tetrapod(int segments) {
  Mesh mesh = tetrahedron();
  for (int f = 0; f < 4; ++f) {
    Eigen::RowVector3i base = mesh.faces.row(f);
    const Eigen::RowVector3d outward =
        (mesh.vertices.row(base[0]) + mesh.vertices.row(base[1]) + mesh.vertices.row(base[2])) / 3;
    for (int segment = 0; segment < segments; ++segment) {
      const int first = static_cast<int>(mesh.vertices.rows());
      for (int k = 0; k < 3; ++k)
        append(mesh, (mesh.vertices.row(base[k]) + 4 * outward).transpose());
      for (int k = 0; k < 3; ++k) {
        const int l = (k + 1) % 3;
        append(mesh, base[k], base[l], first + l);
        append(mesh, base[k], first + l, first + k);
      }
      base << first, first + 1, first + 2;
    }
    mesh.faces.row(f) = base;
  }
  return mesh;
}

Mesh withZeroAreaFace() {
  Mesh mesh = octahedron();
  append(mesh,
         {0.5, 0.5, 0});  // the middle of the edge (0, 2), made part of face 0 = (0, 2, 4) alone
  mesh.faces.row(0) << 0, 2, 6;  // no area
  append(mesh, 2, 4, 6);
  append(mesh, 4, 0, 6);
  return mesh;
}

Mesh openCone() {
  Mesh mesh = bipyramid(8);
  Triangles upper(8, 3);
  for (int i = 0; i < 8; ++i) upper.row(i) << 0, 1 + i, 1 + (i + 1) % 8;
  Points vertices(9, 3);
  vertices << mesh.vertices.row(0), mesh.vertices.bottomRows(8);
  return {vertices, upper};
}

Mesh nonManifoldEdge() {
  Mesh mesh;
  mesh.vertices.resize(6, 3);
  mesh.vertices << 0, 0, 0, 0, 0, 1, 1, 0, 0, 1, 1, 0, -1, 0, 0, -1, -1, 0;
  mesh.faces.resize(8, 3);
  mesh.faces << 0, 2, 1, 0, 3, 2, 0, 1, 3, 1, 2, 3, 0, 4, 1, 0, 5, 4, 0, 1, 5, 1, 4, 5;
  return mesh;
}

Mesh nonManifoldVertex() {
  Mesh mesh;
  mesh.vertices.resize(7, 3);
  mesh.vertices << 0, 0, 0, 1, 0, 1, 0, 1, 1, -1, -1, 1, 1, 0, -1, 0, 1, -1, -1, -1, -1;
  mesh.faces.resize(8, 3);
  mesh.faces << 0, 2, 1, 0, 3, 2, 0, 1, 3, 1, 2, 3, 0, 4, 5, 0, 5, 6, 0, 6, 4, 4, 6, 5;
  return mesh;
}

Mesh torus() {
  constexpr int around = 16, across = 8;
  Mesh mesh;
  mesh.vertices.resize(around * across, 3);
  mesh.faces.resize(2 * around * across, 3);
  for (int i = 0; i < around; ++i)
    for (int j = 0; j < across; ++j) {
      const double a = 2 * pi * i / around, b = 2 * pi * j / across, r = 3 + std::cos(b);
      const int i1 = (i + 1) % around, j1 = (j + 1) % across, v = i * across + j;
      mesh.vertices.row(v) << r * std::cos(a), r * std::sin(a), std::sin(b);
      mesh.faces.row(2 * v) << v, i1 * across + j, i1 * across + j1;
      mesh.faces.row(2 * v + 1) << v, i1 * across + j1, i * across + j1;
    }
  return mesh;
}

Mesh twoSpheres() {
  const Mesh one = octahedron();
  Mesh mesh;
  mesh.vertices.resize(12, 3);
  mesh.vertices << one.vertices, (one.vertices.rowwise() + Eigen::RowVector3d(5, 0, 0));
  mesh.faces.resize(16, 3);
  mesh.faces << one.faces, (one.faces.array() + 6).matrix();
  return mesh;
}

Mesh flippedFace() {
  Mesh mesh = icosahedron();
  reverse(mesh, 7);
  return mesh;
}

Mesh inwardSphere() {
  Mesh mesh = icosahedron();
  for (int f = 0; f < 20; ++f) reverse(mesh, f);
  return mesh;
}

Mesh withUnreferencedVertex() {
  Mesh mesh = icosahedron();
  append(mesh, Vector3(2, 0, 0));
  return mesh;
}

Mesh withNaN() {
  Mesh mesh = icosahedron();
  mesh.vertices(5, 1) = std::numeric_limits<double>::quiet_NaN();
  return mesh;
}

Mesh withDegenerateFace() {
  Mesh mesh = icosahedron();
  append(mesh, 0, 0, 1);
  return mesh;
}

Mesh duplicatedVertices() {
  const Mesh whole = icosahedron();
  Mesh soup;
  soup.vertices.resize(60, 3);
  soup.faces.resize(20, 3);
  for (int f = 0; f < 20; ++f)
    for (int k = 0; k < 3; ++k) {
      soup.vertices.row(3 * f + k) = whole.vertices.row(whole.faces(f, k));
      soup.faces(f, k) = 3 * f + k;
    }
  return soup;
}

Mesh mirrored(Mesh mesh) {
  mesh.vertices.col(0) *= -1;
  mesh.faces.col(1).swap(mesh.faces.col(2));
  return mesh;
}

Mesh stretched(Mesh mesh, double x, double y, double z) {
  mesh.vertices.array().rowwise() *= Eigen::Array<double, 1, 3>(x, y, z);
  return mesh;
}

Mesh transformed(Mesh mesh, const Eigen::Matrix3d& rotation, double scale,
                 const Vector3& translation) {
  mesh.vertices =
      ((scale * (mesh.vertices * rotation.transpose())).rowwise() + translation.transpose()).eval();
  return mesh;
}

ClosedSurface surfaceOf(const Mesh& mesh, const std::string& name) {
  return {mesh.vertices, mesh.faces, name};
}

double largestDistance(const Points& a, const Points& b) {
  return (a - b).rowwise().norm().maxCoeff();
}

}  // namespace sphere_propagation::test
