// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/propagation/motion/motion_uncertainty.h"

#include <cmath>
#include <utility>

#include "vcg_ext/base/dense_cholesky.h"
#include "vcg_ext/mesh/surface_geometry.h"
#include "vcg_ext/propagation/motion/dense_kernels.h"

namespace sphere_propagation {
namespace {

constexpr double shareOfCovariance = 0.75, shareOfMotion = 0.2;

/// The unknowns in an order in which those that are bound follow each other.
std::vector<int> alongChain(const Eigen::MatrixXd& inTime) {
  const auto count = static_cast<int>(inTime.rows());
  const auto bound = [&](int k, int l) { return k != l && inTime(k, l) != 0; };
  std::vector<char> seen(static_cast<size_t>(count), 0);
  std::vector<int> order;
  const auto follow = [&](int k) {
    while (k >= 0) {
      order.push_back(k);
      seen[static_cast<size_t>(k)] = 1;
      int next = -1;
      for (int l = 0; l < count && next < 0; ++l)
        if (bound(k, l) && seen[static_cast<size_t>(l)] == 0) next = l;
      k = next;
    }
  };
  for (int k = 0; k < count; ++k) {
    int neighbours = 0;
    for (int l = 0; l < count; ++l) neighbours += bound(k, l) ? 1 : 0;
    if (neighbours < 2 && seen[static_cast<size_t>(k)] == 0) follow(k);
  }
  return order;
}

/// P of the surface at the end of an arc, P at its beginning given; `before` of size 0: nothing.
Eigen::MatrixXd covarianceBehind(const Eigen::MatrixXd& before, const Eigen::MatrixXd& inverse,
                                 const Eigen::MatrixXd& information) {
  if (before.size() == 0) return inverse;
  Eigen::MatrixXd kept = -inverse * information;
  kept.diagonal().array() += 1;
  const Eigen::MatrixXd brought = kept * before;
  Eigen::MatrixXd covariance = brought * kept.transpose();
  covariance += inverse;
  return covariance;
}

Eigen::MatrixXd inverseOfFactor(const DenseCholesky& factor) {
  return factor.solve(
      Eigen::MatrixXd(Eigen::MatrixXd::Identity(MotionBasis::columns, MotionBasis::columns)));
}

}  // namespace

// Elimination from both ends: what is left of a block by those before it, and by those behind it.
std::vector<Eigen::MatrixXd> covariancesOf(const BoundChain& chain, ThreadPool& pool) {
  const std::vector<int> order = alongChain(chain.inTime);
  const auto count = static_cast<int>(order.size());
  const auto at = [&](int p) { return static_cast<size_t>(order[static_cast<size_t>(p)]); };
  const auto bond = [&](int p) {  // between p and p + 1
    return p < 0 || p + 1 >= count
               ? 0.0
               : -chain.inTime(order[static_cast<size_t>(p)], order[static_cast<size_t>(p) + 1]);
  };
  const auto own = [&](int p) {
    Eigen::MatrixXd block = chain.blocks[at(p)];
    block.diagonal().array() +=
        chain.inTime(order[static_cast<size_t>(p)], order[static_cast<size_t>(p)]);
    return block;
  };
  const auto places = static_cast<size_t>(count);
  std::vector<Eigen::MatrixXd> fromFirst(places), fromLast(places);  // inverses
  pool.forEach(2, [&](int end) {
    for (int i = 0; i < count; ++i) {
      const int p = end == 0 ? i : count - 1 - i, before = end == 0 ? p - 1 : p + 1;
      const double binds = end == 0 ? bond(before) : bond(p);
      std::vector<Eigen::MatrixXd>& inverses = end == 0 ? fromFirst : fromLast;
      Eigen::MatrixXd left = own(p);
      if (binds != 0) left -= binds * binds * inverses[static_cast<size_t>(before)];
      inverses[static_cast<size_t>(p)] = inverseOf(left);
    }
  });
  // What the shared unknowns do: the chain's answer to each.
  std::vector<Eigen::MatrixXd> answer(places);
  Eigen::MatrixXd shared = chain.shared;
  for (int p = 0; p < count; ++p) {
    Eigen::MatrixXd right = chain.coupling[at(p)];
    if (bond(p - 1) != 0) right += bond(p - 1) * answer[static_cast<size_t>(p) - 1];
    answer[static_cast<size_t>(p)] = fromFirst[static_cast<size_t>(p)] * right;
  }
  for (int p = count - 1; p >= 0; --p) {
    const auto i = static_cast<size_t>(p);
    if (bond(p) != 0) {
      const Eigen::MatrixXd back = fromFirst[i] * answer[i + 1];
      answer[i] += bond(p) * back;
    }
    shared -= chain.coupling[at(p)].transpose() * answer[i];
  }
  const DenseCholesky ofShared(std::move(shared));
  std::vector<Eigen::MatrixXd> covariances(chain.blocks.size());
  pool.forEach(count, [&](int p) {
    const auto i = static_cast<size_t>(p);
    Eigen::MatrixXd precision = own(p);
    if (bond(p - 1) != 0) precision -= bond(p - 1) * bond(p - 1) * fromFirst[i - 1];
    if (bond(p) != 0) precision -= bond(p) * bond(p) * fromLast[i + 1];
    Eigen::MatrixXd covariance = inverseOf(precision);
    const Eigen::MatrixXd spread = ofShared.solveLower(Eigen::MatrixXd(answer[i].transpose()));
    covariance.noalias() += spread.transpose() * spread;
    covariances[at(p)] = std::move(covariance);
  });
  return covariances;
}

std::vector<Eigen::MatrixXd> covariancesAlongTree(const PropagationTree& tree, const MotionFit& fit,
                                                  ThreadPool& pool) {
  std::vector<Eigen::MatrixXd> covariances(fit.coefficients.size());
  for (const std::vector<int>& level : tree.levels())
    pool.forEach(static_cast<int>(level.size()), [&](int k) {
      const auto t = static_cast<size_t>(level[static_cast<size_t>(k)]);
      if (static_cast<int>(t) == tree.root() || fit.lost[t] != 0) return;
      auto s = static_cast<size_t>(tree.parent[t]);
      while (fit.lost[s] != 0) s = static_cast<size_t>(tree.parent[s]);
      covariances[t] = covarianceBehind(covariances[s], inverseOfFactor(fit.factors[t]),
                                        fit.equations[t].matrix);
    });
  return covariances;
}

std::vector<Eigen::MatrixXd> covariancesOfBothWays(const ClosedCycle& cycle, const MotionFit& fit,
                                                   const std::vector<char>& averaged,
                                                   std::vector<Eigen::MatrixXd> alongTree) {
  std::vector<Eigen::MatrixXd> result = alongTree;
  const auto surfaces = static_cast<int>(cycle.layers.size());
  const auto layerAt = [&](int step) {
    return static_cast<size_t>(cycle.layers[static_cast<size_t>(step % surfaces)]);
  };
  for (const bool forward : {true, false}) {
    int step = forward ? cycle.forward : cycle.forward + 1;
    const int by = forward ? 1 : -1;
    Eigen::MatrixXd here = alongTree[layerAt(step)];
    for (step += by; step > 0 && step < surfaces; step += by) {
      const size_t t = layerAt(step);
      if (fit.lost[t] != 0) continue;
      const Eigen::MatrixXd inverse = inverseOfFactor(fit.factors[t]);
      const Eigen::MatrixXd& information = fit.equations[t].matrix;
      here = covarianceBehind(here, inverse, information);
      if (averaged[t] == 0) continue;
      const double ahead = forwardShare(step, surfaces), other = forward ? ahead : 1 - ahead;
      const Eigen::MatrixXd kept = inverse * information;
      Eigen::MatrixXd common = kept * inverse;
      common *= 2 * other * (1 - other);
      common += other * other * here;
      common += (1 - other) * (1 - other) * alongTree[t];
      result[t] = std::move(common);
    }
  }
  return result;
}

Eigen::VectorXd deviationsAlongSurface(const MotionModel& model, const Eigen::VectorXd& c,
                                       const Eigen::MatrixXd& covariance) {
  const Points normals = vertexNormals(model.movedNodes(c), model.faces());
  const Eigen::Index count = normals.rows();
  const Eigen::VectorXd ones = Eigen::VectorXd::Ones(count);
  Points first(count, 3), second(count, 3);
  for (Eigen::Index i = 0; i < count; ++i) {
    const Vector3 normal = normals.row(i).transpose();
    Eigen::Index least = 0;
    normal.cwiseAbs().minCoeff(&least);
    const Vector3 along = normal.cross(Vector3::Unit(least)).normalized();
    first.row(i) = along.transpose();
    second.row(i) = normal.cross(along).transpose();
  }
  const Eigen::MatrixXf rough = covariance.cast<float>();
  Eigen::VectorXd variances = Eigen::VectorXd::Zero(count);
  for (const Points* directions : {&first, &second}) {
    const RowsF rows = model.basis().roughRows(*directions, ones);
    const RowsF spread = rows * rough;
    variances += rows.cwiseProduct(spread).rowwise().sum().cast<double>();
  }
  return (0.25 * model.meanVertexArea() * variances).cwiseMax(0.0).cwiseSqrt();
}

Eigen::VectorXd uncertaintyOfNodes(const MotionModel& model, const Eigen::VectorXd& c,
                                   const Eigen::MatrixXd& covariance) {
  const Points moved = model.movedNodes(c) - model.nodes();
  const double way = shareOfMotion * shareOfMotion * moved.rowwise().squaredNorm().mean();
  const Eigen::VectorXd known = shareOfCovariance * deviationsAlongSurface(model, c, covariance);
  return (known.array().square() + way).sqrt();
}

Eigen::VectorXd interpolatedAt(const MotionModel& model, const MappedSurface& map,
                               const Eigen::VectorXd& ofNodes) {
  std::vector<Vector3> directions;
  directions.reserve(static_cast<size_t>(map.vertexCount()));
  for (int v = 0; v < map.vertexCount(); ++v) directions.push_back(map.position(v));
  const std::vector<SurfacePoint> sites = model.sitesOf(directions);
  Eigen::VectorXd values(map.vertexCount());
  for (int v = 0; v < map.vertexCount(); ++v) {
    const SurfacePoint& site = sites[static_cast<size_t>(v)];
    values[v] = 0;
    for (int k = 0; k < 3; ++k) values[v] += site.weights[k] * ofNodes[model.faces()(site.face, k)];
  }
  return values;
}

}  // namespace sphere_propagation
