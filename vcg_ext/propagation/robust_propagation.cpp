#include "vcg_ext/propagation/robust_propagation.h"

#include <utility>

#include "vcg_ext/propagation/map_transfer.h"
#include "vcg_ext/propagation/rigid_alignment.h"

namespace sphere_propagation {
namespace {

constexpr int icpIterations = 30;

/// The reference's vertices where it lies on the target: centroids together, then closest points, rigidly.
Points alignedVertices(const ClosedSurface& reference, const ClosedSurface& target) {
  Points points = reference.vertices();
  points.rowwise() += (target.vertices().colwise().mean() - points.colwise().mean()).eval();
  return alignRigidly(points, VertexLocator(target.vertices()), icpIterations).motion.applyTo(points);
}

}  // namespace

RobustPropagation propagateRobustly(const ClosedSurface& reference, const SphereMap& referenceMap,
                                    const ClosedSurface& target) {
  TransferredMap read = transferMap(reference, referenceMap, alignedVertices(reference, target), target);
  return {std::move(read.map), read.repairedFaces, read.residual.mean, read.residual.p95};
}

}  // namespace sphere_propagation
