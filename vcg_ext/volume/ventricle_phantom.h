// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// A beating left ventricle whose material points are known: meshes without correspondence, and the
/// truth to judge by.

#include <array>

#include "vcg_ext/base/matrices.h"
#include "vcg_ext/volume/grid.h"

namespace sphere_propagation {

struct PhantomParameters {
  enum class Part {
    Cavity,  ///< the blood pool, closed by a lid at the base
    Wall,    ///< the muscle, a thick cup open at the base
  };
  static constexpr int maxPhases = 10000;
  static constexpr double minVoxelSize = 0.25, maxVoxelSize = 4;  ///< mm
  static constexpr double maxTwist = 360;                         ///< degrees

  Part part = Part::Cavity;
  int phases = 25;       ///< of one cycle, 1 to maxPhases; phase 0 is end-diastole
  double voxelSize = 2;  ///< mm; the cavity has about 4000 vertices at 2 mm
  /// Degrees by which the apex turns against the base at end-systole; negative: the other way.
  double twist = 0;
  unsigned seed = 0;  ///< another one makes another ventricle
};

/// A marching-cubes mesh and what is known about it.
struct PhantomMesh {
  Points vertices;  ///< #V by 3, mm
  Triangles faces;  ///< #F by 3; closed, outward, of one part
  /// (u, theta, m) of each vertex, #V by 3: of the closest point of the ventricle's own surface at
  /// that phase, see VentriclePhantom::position; theta in [0, 2 pi). On average it lies a tenth of
  /// a voxel from the vertex, at most half a voxel; at the rim of the base, and where the wall
  /// bulges out beside the infarct, up to a voxel.
  Points materialCoordinates;
};

/// A material point has coordinates u in [0, 1] (apex to base), theta (angle round the long axis,
/// radians) and m in [0, 1] (inner to outer surface). Radial contraction (to 1 - 0.36), shortening
/// of the long axis (0.16) and wall thickening (0.45) follow one curve, smallest at 0.35 of the
/// cycle; an infarct that contracts less, bulges and a bend depend on the seed. The random numbers
/// are those of numpy.random.RandomState(seed), so that the ventricle can be computed again in
/// Python.
class VentriclePhantom {
 public:
  /// Throws ParameterError when a parameter is out of the range given with it.
  explicit VentriclePhantom(const PhantomParameters& parameters = {});

  /// Where a material point is, mm. phase: in [0, phases), need not be whole; u, theta and m as
  /// above. u in (1, 2]: the lid that closes the cavity (m is taken as 0), on the straight line
  /// from the rim (1, theta, 0) to the bent axis at the same height, u = 2.
  Vector3 position(double u, double theta, double phase, double m) const;

  /// The voxels whose centres lie in the part, 1 inside, 0 outside; slice by slice, each outline
  /// filled as a polygon. phase: 0 .. phases - 1, else ParameterError.
  ScalarGrid mask(int phase) const;

  /// Marching cubes at 0.5 of the mask smoothed by a Gaussian of 0.7 voxels, its largest part.
  /// The wall's base is a ring-shaped cut through the muscle where the mask ends; its vertices have
  /// the u and m of the muscle there (0 < m < 1).
  PhantomMesh mesh(int phase) const;

  const PhantomParameters& parameters() const { return parameters_; }

 private:
  struct Circle;
  struct Meridian;
  Circle circle(double u, double contraction) const;
  Meridian meridian(double theta) const;
  Vector3 position(const Circle& circle, const Meridian& meridian, double contraction,
                   double m) const;
  double contraction(double phase) const;
  Points sheet(int rows, int columns, double phase, double m) const;
  Points materialCoordinates(const Points& vertices, int phase, double base) const;
  double heightToU(double height, const Meridian& meridian, double contraction, double m) const;

  PhantomParameters parameters_;
  double twist_, a_, b_, length_, infarctTheta_, infarctU_, bend_;
  std::array<double, 4> bulge_{};
};

}  // namespace sphere_propagation
