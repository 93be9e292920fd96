// SPDX-License-Identifier: GPL-3.0-only
#include "tests/core/limb_meshes.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

#include "vcg_ext/mesh/closed_surface.h"
#include "vcg_ext/mesh/icosphere.h"

namespace sphere_propagation::test {
namespace {

/// Collects vertices and faces.
struct Builder {
  std::vector<Vector3> vertices;
  std::vector<std::array<int, 3>> faces;

  int add(const Vector3& p) {
    vertices.push_back(p);
    return static_cast<int>(vertices.size()) - 1;
  }
  Mesh mesh() const {
    Mesh mesh;
    mesh.vertices.resize(static_cast<Eigen::Index>(vertices.size()), 3);
    mesh.faces.resize(static_cast<Eigen::Index>(faces.size()), 3);
    for (size_t v = 0; v < vertices.size(); ++v)
      mesh.vertices.row(static_cast<Eigen::Index>(v)) = vertices[v].transpose();
    for (size_t f = 0; f < faces.size(); ++f)
      mesh.faces.row(static_cast<Eigen::Index>(f)) << faces[f][0], faces[f][1], faces[f][2];
    return mesh;
  }
};

/// Grows a tube of so many segments out of the triangle, and `depth` times three more out of its
/// end.
void grow(Builder& builder, std::array<int, 3> base, const Vector3& direction, double width,
          int segments, int depth) {
  for (int segment = 0; segment < segments; ++segment) {
    std::array<int, 3> end{};
    for (int k = 0; k < 3; ++k)
      end[k] = builder.add(builder.vertices[base[k]] + 2 * width * direction);
    for (int k = 0; k < 3; ++k) {
      const int l = (k + 1) % 3;
      builder.faces.push_back({base[k], base[l], end[l]});
      builder.faces.push_back({base[k], end[l], end[k]});
    }
    base = end;
  }
  if (depth == 0) {
    builder.faces.push_back(base);
    return;
  }
  const Vector3 centre =
      (builder.vertices[base[0]] + builder.vertices[base[1]] + builder.vertices[base[2]]) / 3;
  const int tip = builder.add(centre + width * direction);
  for (int k = 0; k < 3; ++k) {
    const std::array<int, 3> side{base[k], base[(k + 1) % 3], tip};
    const Vector3 outward = (builder.vertices[side[1]] - builder.vertices[side[0]])
                                .cross(builder.vertices[side[2]] - builder.vertices[side[0]])
                                .normalized();
    grow(builder, side, outward, 0.7 * width, segments, depth - 1);
  }
}

}  // namespace

Mesh subdivided(Mesh mesh, int times) {
  for (; times > 0; --times) {
    const ClosedSurface surface(mesh.vertices, mesh.faces);
    const int n = surface.vertexCount(), halfEdges = 3 * surface.faceCount();
    Points vertices(n + halfEdges / 2, 3);
    for (int v = 0; v < n; ++v) {
      const IndexRange ring = surface.ring(v);
      const double c = 0.375 + 0.25 * std::cos(2 * pi / ring.size()),
                   beta = (0.625 - c * c) / ring.size();
      Vector3 sum = Vector3::Zero();
      for (int w : ring) sum += surface.vertex(w);
      vertices.row(v) = ((1 - beta * ring.size()) * surface.vertex(v) + beta * sum).transpose();
    }
    std::vector<int> middle(static_cast<size_t>(halfEdges));
    int count = n;
    for (int h = 0; h < halfEdges; ++h) {
      const int twin = surface.twin(h);
      if (twin < h) {
        middle[h] = middle[twin];
        continue;
      }
      const Vector3 along = surface.vertex(surface.origin(h)) + surface.vertex(surface.target(h)),
                    across = surface.vertex(surface.origin(ClosedSurface::previous(h))) +
                             surface.vertex(surface.origin(ClosedSurface::previous(twin)));
      middle[h] = count;
      vertices.row(count++) = (0.375 * along + 0.125 * across).transpose();
    }
    Triangles faces(4 * surface.faceCount(), 3);
    for (int f = 0; f < surface.faceCount(); ++f) {
      const int* m = middle.data() + static_cast<size_t>(3) * f;
      for (int k = 0; k < 3; ++k)
        faces.row(4 * f + k) << surface.faces()(f, k), m[k], m[(k + 2) % 3];
      faces.row(4 * f + 3) << m[0], m[1], m[2];
    }
    mesh = {std::move(vertices), std::move(faces)};
  }
  return mesh;
}

Mesh blob(int frequency, double noise, unsigned seed) {
  Icosphere sphere = icosphere(frequency);
  Random random(seed);
  constexpr int waves = 24;
  std::array<Vector3, waves> direction;
  std::array<double, waves> phase{}, size{};
  for (int i = 0; i < waves; ++i) {
    const double frequencyOfWave = 1 + 5 * random.uniform();
    direction[i] = frequencyOfWave * random.direction();
    phase[i] = random.uniform(0, 2 * pi);
    size[i] = 0.25 / frequencyOfWave;
  }
  const double edge = 1.1 / frequency;  // about
  for (Eigen::Index v = 0; v < sphere.vertices.rows(); ++v) {
    const Vector3 p = sphere.vertices.row(v).transpose();
    double radius = 0;
    for (int i = 0; i < waves; ++i) radius += size[i] * std::sin(direction[i].dot(p) + phase[i]);
    sphere.vertices.row(v) *= std::exp(radius) + noise * edge * random.normal();
  }
  return {std::move(sphere.vertices), std::move(sphere.faces)};
}

Mesh limbs(int segments, int subdivisions) { return subdivided(tetrapod(segments), subdivisions); }

Mesh tree(int depth, int segments, int subdivisions) {
  Builder builder;
  const std::array<int, 3> base{builder.add(Vector3(1, 0, 0)),
                                builder.add(Vector3(-0.5, std::sqrt(0.75), 0)),
                                builder.add(Vector3(-0.5, -std::sqrt(0.75), 0))};
  builder.faces.push_back({base[0], base[2], base[1]});
  grow(builder, base, Vector3(0, 0, 1), 1, segments, depth);
  return subdivided(builder.mesh(), subdivisions);
}

Mesh disc(int rings) {
  // A hexagonal grid on both sides, met at the rim.
  Builder builder;
  std::vector<std::vector<std::array<int, 2>>> vertex(static_cast<size_t>(rings) + 1);
  for (int ring = 0; ring <= rings; ++ring)
    for (int i = 0; i < std::max(6 * ring, 1); ++i) {
      const double radius = static_cast<double>(ring) / rings,
                   angle = ring > 0 ? 2 * pi * i / (6 * ring) : 0;
      const double height = 0.01 * std::sqrt(std::max(0.0, 1 - std::pow(radius, 8)));
      const Vector3 p(radius * std::cos(angle), radius * std::sin(angle), height);
      const int above = builder.add(p),
                below = ring == rings ? above : builder.add({p[0], p[1], -p[2]});
      vertex[ring].push_back({above, below});
    }
  for (int side = 0; side < 2; ++side) {
    const auto add = [&](int a, int b, int c) {
      if (side == 1) std::swap(b, c);
      builder.faces.push_back({a, b, c});
    };
    for (int ring = 0; ring < rings; ++ring)
      for (int sector = 0; sector < 6; ++sector)
        for (int i = 0; i <= ring; ++i) {
          const auto inner = [&](int j) {
            return vertex[ring][(sector * ring + j) % std::max(6 * ring, 1)][side];
          };
          const auto outer = [&](int j) {
            return vertex[ring + 1][(sector * (ring + 1) + j) % (6 * ring + 6)][side];
          };
          add(inner(i), outer(i), outer(i + 1));
          if (i < ring) add(inner(i), outer(i + 1), inner(i + 1));
        }
  }
  return builder.mesh();
}

Mesh coil(double turns, int around, int along) {
  Builder builder;
  const auto centre = [&](double t) {
    const double angle = 2 * pi * turns * t;
    return Vector3(std::cos(angle), std::sin(angle), 0.6 * turns * t);
  };
  for (int ring = 0; ring < along; ++ring) {
    const double t = (ring + 0.5) / along;
    const Vector3 tangent = (centre(t + 1e-4) - centre(t - 1e-4)).normalized();
    const Vector3 side = tangent.cross(Vector3::UnitZ()).normalized(), up = side.cross(tangent);
    for (int i = 0; i < around; ++i) {
      const double angle = 2 * pi * i / around;
      builder.add(centre(t) + 0.2 * (std::cos(angle) * side + std::sin(angle) * up));
    }
  }
  for (int ring = 0; ring + 1 < along; ++ring)
    for (int i = 0; i < around; ++i) {
      const int a = ring * around + i, b = ring * around + (i + 1) % around;
      builder.faces.push_back({a, a + around, b});
      builder.faces.push_back({b, a + around, b + around});
    }
  const int first = builder.add(centre(0)), last = builder.add(centre(1));
  for (int i = 0; i < around; ++i) {
    builder.faces.push_back({first, i, (i + 1) % around});
    builder.faces.push_back(
        {last, (along - 1) * around + (i + 1) % around, (along - 1) * around + i});
  }
  return builder.mesh();
}

}  // namespace sphere_propagation::test
