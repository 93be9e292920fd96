// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// The global step of the area-preserving map: Gauss-Newton over all vertices at once, never
/// leaving validity.

#include <utility>
#include <vector>

#include "vcg_ext/area/area_energy.h"
#include "vcg_ext/base/thread_pool.h"
#include "vcg_ext/mesh/hierarchy/face_rings.h"
#include "vcg_ext/sphere/admissible.h"

namespace sphere_propagation {

struct AreaStepParameters {
  AreaEnergyWeights weights;
  /// Weight of the Dirichlet energy of the displacement, relative to the Hessian's own scale: damps
  /// what the Hessian does not see (rotations of the sphere, flows that keep areas).
  double damping = 0.01;
  int conjugateGradientIterations = 60;      ///< at most, per step
  double conjugateGradientTolerance = 0.05;  ///< relative, in the norm of the preconditioner
};

/// Minimises the area energy of one mesh from a given valid map. Keeps the sparsity pattern and the
/// buffers, so that many steps cost no allocation: about 500 bytes a vertex.
class AreaMinimiser {
 public:
  /// targets: #F. pool: who does the work, the calling thread alone where there is none; it must
  /// outlive the minimiser.
  AreaMinimiser(FaceRings rings, std::vector<FaceTarget> targets, ThreadPool* pool = nullptr);
  AreaMinimiser(const ClosedSurface& surface, std::vector<FaceTarget> targets,
                ThreadPool* pool = nullptr)
      : AreaMinimiser(FaceRings::of(surface), std::move(targets), pool) {}

  /// Vertices that no step moves. held: #V, 1 for each of them; empty: none.
  void hold(std::vector<char> held) { stays_ = std::move(held); }

  /// Energy of the positions (#V by 3 unit vectors); infinity when a face is not admissible.
  double energy(const AreaEnergyWeights& weights, const Points& positions) const;

  /// One step: solves the regularised Gauss-Newton system by conjugate gradients with a
  /// block-Jacobi preconditioner, tries lengths 1, 1/2, 1/4 ... of the step, each shortened locally
  /// where a face would degenerate, and takes the one that lowers the energy most. (The first that
  /// lowers it at all is a poor choice: far from the solution a long step is held up by the faces
  /// that it would flip.) Where the whole step brings what the quadratic model promises, no other
  /// is tried. Valid positions stay admissible; what is beyond the limits already gets no worse.
  /// Returns the ratio of the energy after the step to that before; 1 when no step lowers it
  /// (positions unchanged).
  double step(const AreaStepParameters& parameters, Points& positions);

  const FaceRings& rings() const { return rings_; }

 private:
  using Tangent2 = Eigen::Vector2f;
  using Block = Eigen::Matrix2f;
  using Frame = Eigen::Matrix<float, 6, 1>;  // both tangents
  /// What the rows of the Hessian need of a face. Single precision: the system is solved to a few
  /// per cent.
  struct FaceTerms {
    std::array<Tangent2, 3> logArea, quotient;
    float slope = 0, curvature = 0, shapeWeight = 0;
    std::array<float, 3> tie = {};  ///< with the damping's
  };

  double expandFaces(const AreaStepParameters& parameters, const Points& positions);
  void assemble(const Points& positions);
  Block coupling(int c, bool forward) const;
  double multiply(const std::vector<Tangent2>& x);
  double solve(const AreaStepParameters& parameters);
  double take(double length, const AreaStepParameters& parameters, const Points& positions,
              bool& shortened);
  void move(int v, const Points& positions);
  bool isAdmissible(int f, const Points& positions, double& s, std::array<Vector3, 3>& p) const;

  FaceRings rings_;
  std::vector<FaceTarget> targets_;
  ThreadPool ownPool_;
  ThreadPool* pool_;
  std::vector<int> column_;  // 3 #F: the vertex to which each off-diagonal block belongs, in the
                             // order of rings_.corner
  std::vector<FaceTerms> terms_;
  std::vector<Frame> frame_;
  std::vector<Block> diagonal_, offDiagonal_, preconditioner_;
  std::vector<Tangent2> gradient_, step_, residual_, search_, image_;
  std::vector<char> stays_;
  std::vector<double> solidAngle_;
  std::vector<float> share_;
  std::vector<std::vector<int>> held_;  // faces that hold up a step, by range of faces
  Points trial_, best_;
};

}  // namespace sphere_propagation
