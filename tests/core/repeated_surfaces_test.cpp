// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/sequence/repeated_surfaces.h"

#include <gtest/gtest.h>

#include "tests/core/test_meshes.h"
#include "vcg_ext/sequence/mirroring.h"

namespace sphere_propagation {
namespace {

ClosedSurface ellipsoid(double c) { return test::surfaceOf(test::ellipsoid(3, 2, c, 5)); }

ClosedSurface changed(const ClosedSurface& surface, const Points& vertices) {
  return {vertices, surface.faces(), surface.name()};
}

TEST(RepeatedSurfaces, AreFoundInSpiteOfOrderAndDigits) {
  const ClosedSurface surface = ellipsoid(1);
  const Points& vertices = surface.vertices();
  const Points rounded = (1e5 * vertices.array()).round().matrix() / 1e5;
  const auto last = static_cast<int>(vertices.rows()) - 1;
  const Triangles turned = (last - surface.faces().array()).matrix();
  const ClosedSurface reordered(vertices.colwise().reverse(), turned, "reordered");
  EXPECT_EQ(repeatedSurfaces(
                Sequence({ellipsoid(1.1), surface, surface, changed(surface, rounded), reordered})),
            (std::vector<int>{-1, -1, 1, 1, 1}));
}

TEST(RepeatedSurfaces, AreNotThoseThatMovedOrDiffer) {
  const ClosedSurface surface = ellipsoid(1);
  const Points& vertices = surface.vertices();
  Points bulged = vertices;
  bulged.row(17) *= 1.001;
  const std::vector<int> none(6, -1);
  EXPECT_EQ(
      repeatedSurfaces(Sequence(
          {surface, changed(surface, vertices.rowwise() + Eigen::RowVector3d(0.1, 0, 0)),
           changed(surface, 1.001 * vertices), changed(surface, bulged),
           mirrorImage(changed(surface, bulged)), test::surfaceOf(test::ellipsoid(3, 2, 1, 6))})),
      none);
}

}  // namespace
}  // namespace sphere_propagation
