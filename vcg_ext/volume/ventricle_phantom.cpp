// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/volume/ventricle_phantom.h"

#include <algorithm>
#include <cmath>
#include <sstream>
#include <vector>

#include "vcg_ext/base/error.h"
#include "vcg_ext/base/random.h"
#include "vcg_ext/mesh/surface_locator.h"
#include "vcg_ext/volume/gaussian_smoothing.h"
#include "vcg_ext/volume/marching_cubes.h"

namespace sphere_propagation {
namespace {

constexpr double wallThickness = 9, thickening = 0.45, radialContraction = 0.36, shortening = 0.16;
constexpr int maskRows = 400;  // of a sheet, from apex to base; twice as many round the axis

/// numpy.random.RandomState, which hands out the second of two normal numbers first.
class RandomState {
 public:
  explicit RandomState(unsigned seed) : bits_(seed) {}

  double rand() { return uniformNumber(bits_); }

  double randn() {
    isFirstLeft_ = !isFirstLeft_;
    if (!isFirstLeft_) return pair_[0];
    pair_ = normalNumbers(bits_);
    return pair_[1];
  }

 private:
  std::mt19937 bits_;
  std::array<double, 2> pair_{};
  bool isFirstLeft_ = false;
};

void checkParameters(const PhantomParameters& p) {
  requireRange("number of the phantom's phases", p.phases,
               Range::between(1, PhantomParameters::maxPhases));
  requireRange("phantom's voxel size in mm", p.voxelSize,
               Range::between(PhantomParameters::minVoxelSize, PhantomParameters::maxVoxelSize));
  requireRange("phantom's twist in degrees", p.twist,
               Range::between(-PhantomParameters::maxTwist, PhantomParameters::maxTwist));
}

/// Sets the samples of slice k whose centres the closed polygon surrounds (even-odd rule).
void fillPolygon(const std::vector<Vector2>& polygon, int k, ScalarGrid& grid) {
  std::vector<double> crossings;
  for (int j = 0; j < grid.size[1]; ++j) {
    const double y = grid.origin[1] + grid.spacing[1] * j;
    crossings.clear();
    for (size_t i = 0; i < polygon.size(); ++i) {
      const Vector2 &p = polygon[i], &q = polygon[(i + 1) % polygon.size()];
      if ((p[1] >= y) != (q[1] >= y))
        crossings.push_back(p[0] + (y - p[1]) / (q[1] - p[1]) * (q[0] - p[0]));
    }
    std::sort(crossings.begin(), crossings.end());
    size_t passed = 0;
    for (int i = 0; i < grid.size[0]; ++i) {
      const double x = grid.origin[0] + grid.spacing[0] * i;
      while (passed < crossings.size() && crossings[passed] <= x) ++passed;
      if (passed % 2 == 1) grid(i, j, k) = 1;
    }
  }
}

/// Where the slices of a sheet lie: the mean height of each of its rows, apex first.
Eigen::VectorXd rowHeights(const Points& sheet, int rows) {
  const Eigen::Index columns = sheet.rows() / rows;
  Eigen::VectorXd heights(rows);
  for (int r = 0; r < rows; ++r) heights[r] = sheet.col(2).segment(r * columns, columns).mean();
  return heights;
}

/// Fills each slice between the sheet's apex and base with the sheet's outline there.
void fillSheet(const Points& sheet, const Eigen::VectorXd& heights, ScalarGrid& grid) {
  const Eigen::Index columns = sheet.rows() / heights.size();
  std::vector<Vector2> ring(static_cast<size_t>(columns));
  for (int k = 0; k < grid.size[2]; ++k) {
    const double z = grid.origin[2] + grid.spacing[2] * k;
    if (z < heights.minCoeff() || z > heights.maxCoeff()) continue;
    const Eigen::Index above =
        std::lower_bound(heights.data(), heights.data() + heights.size(), z) - heights.data();
    const Eigen::Index i = std::clamp<Eigen::Index>(above, 1, heights.size() - 1);
    const double f = (z - heights[i - 1]) / (heights[i] - heights[i - 1] + 1e-12);
    for (Eigen::Index c = 0; c < columns; ++c)
      ring[static_cast<size_t>(c)] =
          ((1 - f) * sheet.row((i - 1) * columns + c) + f * sheet.row(i * columns + c))
              .head<2>()
              .transpose();
    fillPolygon(ring, k, grid);
  }
}

}  // namespace

VentriclePhantom::VentriclePhantom(const PhantomParameters& parameters) : parameters_(parameters) {
  checkParameters(parameters);
  RandomState random(parameters.seed);  // the order of the draws matters
  a_ = 25;
  b_ = 25 * (1 + 0.1 * random.randn());
  length_ = 80 * (1 + 0.05 * random.randn());
  twist_ = parameters.twist * pi / 180;
  infarctTheta_ = random.rand() * 2 * pi;
  infarctU_ = 0.35 + 0.3 * random.rand();
  for (double& bulge : bulge_) bulge = random.randn() * 0.05;
  bend_ = random.randn() * 6;
}

double VentriclePhantom::contraction(double phase) const {
  const double x = phase / parameters_.phases;
  const double root = x < 0.35 ? std::sin(pi * x / 0.7) : std::cos(pi * (x - 0.35) / 1.3);
  return root * root;
}

/// What depends on u alone, so that sheets of many points need few sines.
struct VentriclePhantom::Circle {
  double u, lid, sinPhi, cosPhi, sinTurn, cosTurn, infarct;
};

/// What depends on theta alone.
struct VentriclePhantom::Meridian {
  double sin, cos, sin3, cos2, infarct;
};

VentriclePhantom::Circle VentriclePhantom::circle(double u, double contraction) const {
  const double onSheet = std::min(u, 1.0), phi = onSheet * pi * 0.5 * 1.25,
               turn = twist_ * contraction * (1 - onSheet);
  const double distance = onSheet - infarctU_;
  return {onSheet,
          u - onSheet,
          std::sin(phi),
          std::cos(phi),
          std::sin(turn),
          std::cos(turn),
          std::exp(-distance * distance / (2 * 0.18 * 0.18))};
}

VentriclePhantom::Meridian VentriclePhantom::meridian(double theta) const {
  const double away = std::remainder(theta - infarctTheta_, 2 * pi);
  return {std::sin(theta), std::cos(theta), std::sin(3 * theta), std::cos(2 * theta),
          std::exp(-away * away / (2 * 0.5 * 0.5))};
}

Vector3 VentriclePhantom::position(const Circle& circle, const Meridian& meridian,
                                   double contraction, double m) const {
  const double local = contraction * (1 - 0.9 * circle.infarct * meridian.infarct);
  const double radial = 1 - radialContraction * local, axial = 1 - shortening * contraction;
  const double shape = 1 + bulge_[0] * meridian.cos2 +
                       (bulge_[1] * meridian.sin3 + bulge_[2] * meridian.cos) * circle.u;
  const double outward = circle.lid > 0 ? 0 : wallThickness * (1 + thickening * local) * m;
  const double cosTurned = meridian.cos * circle.cosTurn - meridian.sin * circle.sinTurn;
  const double sinTurned = meridian.sin * circle.cosTurn + meridian.cos * circle.sinTurn;
  const double x = (1 - circle.lid) * (a_ * radial * shape + outward) * circle.sinPhi * cosTurned;
  const double y = (1 - circle.lid) * (b_ * radial * shape + outward) * circle.sinPhi * sinTurned;
  const double z = -(length_ * 0.55 * axial + outward * 0.9) * circle.cosPhi;
  return {x + bend_ * std::sin(pi * (z + length_ * 0.6) / (length_ * 1.2)), y, z};
}

Vector3 VentriclePhantom::position(double u, double theta, double phase, double m) const {
  const double c = contraction(phase);
  return position(circle(u, c), meridian(theta), c, m);
}

/// rows by columns points, apex row first, u from 0 to 1.
Points VentriclePhantom::sheet(int rows, int columns, double phase, double m) const {
  const double c = contraction(phase);
  std::vector<Meridian> meridians;
  meridians.reserve(static_cast<size_t>(columns));
  for (int j = 0; j < columns; ++j) meridians.push_back(meridian(2 * pi * j / columns));
  Points points(static_cast<Eigen::Index>(rows) * columns, 3);
  for (int i = 0; i < rows; ++i) {
    const Circle here = circle(static_cast<double>(i) / (rows - 1), c);
    for (int j = 0; j < columns; ++j)
      points.row(i * columns + j) =
          position(here, meridians[static_cast<size_t>(j)], c, m).transpose();
  }
  return points;
}

ScalarGrid VentriclePhantom::mask(int phase) const {
  if (phase < 0 || phase >= parameters_.phases)
    throw ArgumentError("Phantom: there is no phase " + std::to_string(phase) +
                        ", they are numbered from 0 to " + std::to_string(parameters_.phases - 1) +
                        ".");
  const double h = parameters_.voxelSize;
  const Points inner = sheet(maskRows, 2 * maskRows, phase, 0),
               outer = sheet(maskRows, 2 * maskRows, phase, 1);
  const Eigen::VectorXd innerHeights = rowHeights(inner, maskRows),
                        outerHeights = rowHeights(outer, maskRows);
  const Vector3 low = outer.colwise().minCoeff().transpose().array() - 4 * h;
  const Vector3 high = outer.colwise().maxCoeff().transpose().array() + 4 * h;
  const Eigen::Vector3i size = ((high - low) / h).array().ceil().cast<int>() + 1;
  ScalarGrid cavity(size, low, Vector3::Constant(h));
  fillSheet(inner, innerHeights, cavity);
  if (parameters_.part == PhantomParameters::Part::Cavity) return cavity;
  ScalarGrid tissue(size, low, Vector3::Constant(h));
  fillSheet(outer, outerHeights, tissue);
  const double base = std::min(innerHeights[maskRows - 1], outerHeights[maskRows - 1]);
  const int top = static_cast<int>((base - low[2]) / h);
  for (int k = 0; k < size[2]; ++k)
    for (int j = 0; j < size[1]; ++j)
      for (int i = 0; i < size[0]; ++i)
        if (cavity(i, j, k) > 0 || k >= top) tissue(i, j, k) = 0;
  return tissue;
}

PhantomMesh VentriclePhantom::mesh(int phase) const {
  ScalarGrid grid = mask(phase);
  int top = grid.size[2] - 1;  // the last slice with a voxel
  const auto slice = static_cast<std::ptrdiff_t>(grid.index(0, 0, 1));
  const auto empty = [&](int k) {
    const auto begin = grid.values.begin() + k * slice;
    return std::all_of(begin, begin + slice, [](float x) { return x == 0; });
  };
  while (top > 0 && empty(top)) --top;
  const double base = grid.origin[2] + (top + 0.5) * grid.spacing[2];
  smoothGaussian(grid, 0.7);
  IsoSurface surface = largestPart(marchingCubes(grid, 0.5));
  PhantomMesh mesh;
  mesh.materialCoordinates = materialCoordinates(surface.vertices, phase, base);
  mesh.vertices = std::move(surface.vertices);
  mesh.faces = std::move(surface.faces);
  return mesh;
}

/// The u at which the material line (theta, m) has this height; 1 if it lies below it. Height grows
/// with u.
double VentriclePhantom::heightToU(double height, const Meridian& meridian, double contraction,
                                   double m) const {
  const auto heightAt = [&](double u) {
    return position(circle(u, contraction), meridian, contraction, m)[2];
  };
  double low = 0.5, high = 1;
  if (heightAt(high) <= height) return high;
  for (int i = 0; i < 25; ++i) {
    const double middle = (low + high) / 2;
    (heightAt(middle) < height ? low : high) = middle;
  }
  return (low + high) / 2;
}

/// Closest points on a fine mesh of the ventricle's surface at that phase, the coordinates
/// interpolated. Between its samples (less than 2 mm) the surface is about 0.02 mm from flat. base:
/// the height where the mask ends, mm.
Points VentriclePhantom::materialCoordinates(const Points& vertices, int phase, double base) const {
  constexpr int columns = 150, rows = 75, lidRows = 20;
  const bool wall = parameters_.part == PhantomParameters::Part::Wall;
  const double contracted = contraction(phase);
  // One strip from the inner apex to the base and, for the wall, over the cut and down to the outer
  // apex; for the cavity over the lid to its centre. The seam column is there twice, with theta = 0
  // and 2 pi.
  const int strip = wall ? 2 * rows + lidRows - 1 : rows + lidRows;
  Points coordinates(static_cast<Eigen::Index>(strip) * (columns + 1), 3);
  for (int c = 0; c <= columns; ++c) {
    const double theta = 2 * pi * c / columns;
    const Meridian here = meridian(theta);
    const double innerTop = wall ? heightToU(base, here, contracted, 0) : 1;
    const double outerTop = wall ? heightToU(base, here, contracted, 1) : 1;
    for (int r = 0; r < strip; ++r) {
      double u = 0, m = 0;
      if (r < rows) {
        u = innerTop * r / (rows - 1);
      } else if (!wall) {
        u = 1 + static_cast<double>(r - rows + 1) / lidRows;
      } else if (r < rows + lidRows) {
        m = static_cast<double>(r - rows + 1) / lidRows;
        u = heightToU(base, here, contracted, m);
      } else {
        m = 1;
        u = outerTop * (strip - 1 - r) / (rows - 1);
      }
      coordinates.row(r * (columns + 1) + c) << u, theta, m;
    }
  }
  Points points(coordinates.rows(), 3);
  for (Eigen::Index i = 0; i < points.rows(); ++i)
    points.row(i) =
        position(coordinates(i, 0), coordinates(i, 1), phase, coordinates(i, 2)).transpose();
  Triangles faces(static_cast<Eigen::Index>(strip - 1) * columns * 2, 3);
  Eigen::Index f = 0;
  for (int r = 0; r + 1 < strip; ++r)
    for (int c = 0; c < columns; ++c) {
      const int i = r * (columns + 1) + c, j = i + columns + 1;
      faces.row(f++) << i, i + 1, j;
      faces.row(f++) << i + 1, j + 1, j;
    }
  const SurfaceLocator locator(points, faces);
  Points result(vertices.rows(), 3);
  for (Eigen::Index v = 0; v < vertices.rows(); ++v) {
    Vector3 found = locator.closest(vertices.row(v).transpose()).interpolate(faces, coordinates);
    found[0] = std::clamp(found[0], 0.0, wall ? 1.0 : 2.0);  // rounding
    found[2] = std::clamp(found[2], 0.0, 1.0);
    if (found[1] >= 2 * pi) found[1] -= 2 * pi;
    result.row(v) = found.transpose();
  }
  return result;
}

}  // namespace sphere_propagation
