#pragma once
/// The global step of the area-preserving map: Gauss-Newton over all vertices at once, never leaving validity.

#include <vector>

#include "vcg_ext/map/area_energy.h"
#include "vcg_ext/mesh/closed_surface.h"

namespace sphere_propagation {

struct AreaStepParameters {
  AreaEnergyWeights weights;
  /// Weight of the Dirichlet energy of the displacement, relative to the Hessian's own scale: damps what the Hessian
  /// does not see (rotations of the sphere, flows that keep areas).
  double damping = 0.01;
  int conjugateGradientIterations = 60;      ///< at most, per step
  double conjugateGradientTolerance = 0.05;  ///< relative, in the norm of the preconditioner
};

/// Minimises the area energy of one surface from a given valid map. Keeps the sparsity pattern and the buffers, so that
/// many steps cost no allocation.
class AreaMinimiser {
 public:
  /// surface must outlive the minimiser; targets: #F.
  AreaMinimiser(const ClosedSurface& surface, std::vector<FaceTarget> targets);

  /// Energy of the positions (#V by 3 unit vectors); infinity when a face is not admissible.
  double energy(const AreaEnergyWeights& weights, const Points& positions) const;

  /// One step: solves the regularised Gauss-Newton system by conjugate gradients with a block-Jacobi preconditioner,
  /// tries lengths 1, 1/2, 1/4 ... of the step, each shortened locally where a face would degenerate, and takes the one
  /// that lowers the energy most. (The first that lowers it at all is a poor choice: far from the solution a long step
  /// is held up by the faces that it would flip.) Valid positions stay valid: no solid angle falls below 2e-14 or rises
  /// above 6, no edge grows beyond arccos(-0.9); what is beyond already gets no worse.
  /// Returns the ratio of the energy after the step to that before; 1 when no step lowers it (positions unchanged).
  double step(const AreaStepParameters& parameters, Points& positions);

 private:
  void assemble(const AreaStepParameters& parameters, const Points& positions);
  void solve(const AreaStepParameters& parameters);
  double multiplySearch();
  double take(double length, const AreaStepParameters& parameters, const Points& positions);

  const ClosedSurface& surface_;
  std::vector<FaceTarget> targets_;
  std::vector<int> rowStart_, column_, slot_;  // block rows of the Hessian; slot_[h]: where half-edge h's block lies
  std::vector<std::array<Vector3, 2>> frame_;
  std::vector<TangentBlock> diagonal_, offDiagonal_, preconditioner_;
  std::vector<Tangent> gradient_, step_, residual_, search_, image_, scaled_;
  std::vector<double> solidAngle_, share_;
  Points trial_, best_;
};

}  // namespace sphere_propagation
