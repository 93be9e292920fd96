// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/mesh/icosphere.h"

#include <array>
#include <cmath>
#include <string>

#include "vcg_ext/base/error.h"

namespace sphere_propagation {
namespace {

/// Numbers the vertices of an icosphere: rows 0 to 3 f, each of five equal sectors.
struct Rows {
  int f;

  /// Vertices of a row in one sector; 0 for the two poles.
  int perSector(int row) const {
    if (row <= f) return row;
    return row <= 2 * f ? f : 3 * f - row;
  }

  /// Vertices before a row.
  int start(int row) const {
    if (row == 0) return 0;
    if (row <= f) return 1 + 5 * row * (row - 1) / 2;
    if (row <= 2 * f) return 1 + 5 * f * (f - 1) / 2 + 5 * f * (row - f);
    const int rest = 3 * f - row;  // as many rows follow
    return 10 * f * f + 1 - 5 * rest * (rest + 1) / 2;
  }

  /// Place s of a sector; it may be the first of the next sector.
  int vertex(int row, int sector, int s) const {
    const int n = perSector(row);
    return start(row) + (n == 0 ? 0 : (sector * n + s) % (5 * n));
  }
};

/// The corners of the icosahedron. Without trigonometric functions, whose last bit differs from one
/// library to the next.
struct IcosahedronCorners {
  Vector3 north{0, 0, 1}, south{0, 0, -1};
  std::array<Vector3, 6> upper, lower;  // the sixth is the first again

  IcosahedronCorners() {
    const double root = std::sqrt(5.0), z = 1 / root, r = 2 / root;
    const double c72 = (root - 1) / 4, s72 = std::sqrt(10 + 2 * root) / 4;
    const double c36 = (root + 1) / 4, s36 = std::sqrt(10 - 2 * root) / 4;
    upper = {Vector3(r, 0, z),
             Vector3(r * c72, r * s72, z),
             Vector3(-r * c36, r * s36, z),
             Vector3(-r * c36, -r * s36, z),
             Vector3(r * c72, -r * s72, z),
             Vector3(r, 0, z)};
    for (size_t k = 0; k < 6; ++k) lower[k] = -upper[(k + 3) % 5];
  }
};

Points makeVertices(int f) {
  const Rows rows{f};
  const IcosahedronCorners corner;
  Points vertices(10 * f * f + 2, 3);
  Eigen::Index next = 0;
  const auto add = [&](int i, const Vector3& a, int j, const Vector3& b, int k, const Vector3& c) {
    vertices.row(next++) = (double(i) * a + double(j) * b + double(k) * c).normalized().transpose();
  };
  vertices.row(next++) = corner.north.transpose();
  for (int row = 1; row < 3 * f; ++row)
    for (size_t sector = 0; sector < 5; ++sector) {
      const Vector3 &u0 = corner.upper[sector], &u1 = corner.upper[sector + 1];
      const Vector3 &l0 = corner.lower[sector], &l1 = corner.lower[sector + 1];
      for (int s = 0; s < rows.perSector(row); ++s) {
        if (row <= f) {
          add(f - row, corner.north, row - s, u0, s, u1);
        } else if (row <= 2 * f) {
          const int down = row - f,
                    cross = s - (f - down);  // from cross on the triangle (u1, l0, l1)
          if (cross < 0)
            add(f - down - s, u0, s, u1, down, l0);
          else
            add(f - down, u1, down - cross, l0, cross, l1);
        } else {
          const int down = row - 2 * f;
          add(f - down - s, l0, s, l1, down, corner.south);
        }
      }
    }
  vertices.row(next++) = corner.south.transpose();
  return vertices;
}

Triangles makeFaces(int f) {
  const Rows rows{f};
  Triangles faces(20 * f * f, 3);
  Eigen::Index next = 0;
  for (int row = 0; row < 3 * f; ++row)
    for (int sector = 0; sector < 5; ++sector) {
      const int above = rows.perSector(row), below = rows.perSector(row + 1);
      const auto upper = [&](int s) { return rows.vertex(row, sector, s); };
      const auto lower = [&](int s) { return rows.vertex(row + 1, sector, s); };
      if (row < f) {  // a row grows by one a sector
        for (int s = 0; s < below; ++s) {
          faces.row(next++) << upper(s), lower(s), lower(s + 1);
          if (s < above) faces.row(next++) << upper(s), lower(s + 1), upper(s + 1);
        }
      } else {  // it keeps its number, or shrinks
        for (int s = 0; s < above; ++s) {
          faces.row(next++) << upper(s), lower(s), upper(s + 1);
          if (s < below) faces.row(next++) << upper(s + 1), lower(s), lower(s + 1);
        }
      }
    }
  return faces;
}

}  // namespace

void requireIcosphereFrequency(int frequency) {
  requireRange("frequency of an icosphere", frequency, Range::atLeast(1));
  if (frequency > maxIcosphereFrequency) {
    const double vertices = 10.0 * frequency * frequency + 2,
                 bytes = vertices * (3 * sizeof(double) + 6 * sizeof(int));
    throw ParameterError(Finding(Fault::IcosphereTooLarge)
                             .of(std::lround(vertices))
                             .amid(std::lround(bytes / 1e6))
                             .at(frequency, 1, maxIcosphereFrequency));
  }
}

Icosphere icosphere(int frequency) {
  requireIcosphereFrequency(frequency);
  return {makeVertices(frequency), makeFaces(frequency)};
}

std::optional<int> icosphereFrequency(Eigen::Index vertexCount, const Triangles& faces) {
  const double estimate = std::sqrt(static_cast<double>(faces.rows()) / 20);
  if (!(estimate >= 1 && estimate <= maxIcosphereFrequency)) return {};
  const int f = static_cast<int>(std::lround(estimate));
  if (faces.rows() != 20 * f * f || vertexCount != 10 * f * f + 2) return {};
  if (faces != makeFaces(f)) return {};
  return f;
}

}  // namespace sphere_propagation
