// SPDX-License-Identifier: GPL-3.0-only
// What propagation reaches and costs; see the usage below.

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <fstream>
#include <map>
#include <stdexcept>
#include <string>
#include <vector>

#include "benchmarks/ply.h"
#include "benchmarks/timing.h"
#include "vcg_ext/base/stopwatch.h"
#include "vcg_ext/mesh/icosphere.h"
#include "vcg_ext/propagation/motion/dense_kernels.h"
#include "vcg_ext/propagation/motion/motion_basis.h"
#include "vcg_ext/propagation/propagation.h"
#include "vcg_ext/remeshing/icosphere_remesher.h"
#include "vcg_ext/root_map/root_map.h"
#include "vcg_ext/sequence/similarity_tree.h"
#include "vcg_ext/sphere/certificate.h"
#include "vcg_ext/sphere/sphere_locator.h"

namespace sphere_propagation::benchmark {
namespace {

constexpr const char* usage = R"(propagation_benchmark [OPTION...] LAYER.ply LAYER.ply ...

Does the main job on the layers: maps the root, propagates, remeshes. Prints one line: what came of it, and what each
step cost. scripts/measure-propagation runs it on whole sets of data. Options:
  --method robust|published   default robust
  --order time|cyclic|similarity|star   default cyclic
  --root N          counted from 0; default 0
  --learn-from N    the fewest arcs that the prior of motion is learnt from; default 11
  --arcs-alone      do not fit all layers of a chain at once after its arcs
  --kernels         what the kernels of the motion's fit cost beside Eigen's, and no more
  --threads N       0 = all; default 0
  --repeat N        take the least of N runs, after one that is not counted
  --landmarks FILE  write the landmarks: layers x 1002 x 3 doubles
  --uncertainty FILE   write how well each landmark is known along the surface (motion_uncertainty.h): layers x 1002
                    doubles, not a number where nobody knows
  --root-map FILE   write the root with its map as px, py, pz
)";

struct Options {
  PropagationParameters parameters;
  std::string order = "cyclic", landmarks, rootMap, uncertainty;
  int root = 0, repeat = 1;
  bool kernels = false;
  std::vector<std::string> files;
};

Options optionsOf(const std::vector<std::string>& arguments) {
  Options options;
  for (size_t i = 0; i < arguments.size(); ++i) {
    const std::string& word = arguments[i];
    const auto value = [&] {
      if (i + 1 == arguments.size())
        throw std::invalid_argument(word + " needs a value.\n\n" + usage);
      return arguments[++i];
    };
    if (word == "--method") {
      options.parameters.method =
          value() == "published" ? PropagationMethod::AsPublished : PropagationMethod::Robust;
    } else if (word == "--order") {
      options.order = value();
    } else if (word == "--root") {
      options.root = std::stoi(value());
    } else if (word == "--learn-from") {
      options.parameters.motion.minArcsToLearnFrom = std::stoi(value());
    } else if (word == "--arcs-alone") {
      options.parameters.motion.smooths = false;
    } else if (word == "--kernels") {
      options.kernels = true;
    } else if (word == "--threads") {
      options.parameters.threads = std::stoi(value());
    } else if (word == "--repeat") {
      options.repeat = std::stoi(value());
    } else if (word == "--landmarks") {
      options.landmarks = value();
    } else if (word == "--uncertainty") {
      options.uncertainty = value();
      options.parameters.motion.uncertainty = true;
    } else if (word == "--root-map") {
      options.rootMap = value();
    } else if (word.rfind("--", 0) == 0) {
      throw std::invalid_argument("There is no option " + word + ".\n\n" + usage);
    } else {
      options.files.push_back(word);
    }
  }
  return options;
}

PropagationTree treeOf(const Options& options, const Sequence& sequence) {
  const int layers = sequence.size();
  if (options.order == "time") return timeOrder(layers, options.root);
  if (options.order == "star") return star(layers, options.root);
  if (options.order == "similarity") {
    ThreadPool pool(options.parameters.threads);
    return similarityTree(sequence, options.root, pool).tree;
  }
  return cyclicTimeOrder(layers, options.root);
}

/// The least of several runs of something that gives the same each time.
struct Cost {
  double cpu = 0, wall = 0;
  template <class Function>
  explicit Cost(int repeat, const Function& work) {
    for (int i = repeat > 1 ? -1 : 0; i < repeat; ++i) {
      const double start = cpuSeconds();
      const Stopwatch stopwatch;
      work();
      const double seconds = stopwatch.seconds(), used = cpuSeconds() - start;
      cpu = i <= 0 ? used : std::min(cpu, used);
      wall = i <= 0 ? seconds : std::min(wall, seconds);
    }
  }
};

/// How many times as long Eigen takes for the same, least of 25 runs each.
void compareKernels() {
  constexpr int columns = MotionBasis::columns, local = MotionBasis::localColumns, nodes = 1002;
  const auto seconds = [](const auto& work) { return Cost(25, work).wall; };
  const auto compare = [&](const char* name, const auto& ours, const auto& eigens) {
    const double here = seconds(ours), there = seconds(eigens);
    std::printf("%s: %.3f ms, Eigen's %.3f ms = %.1f\n", name, 1e3 * here, 1e3 * there,
                there / here);
  };
  std::srand(1);
  const RowsF rows = RowsF::Random(nodes, columns);
  Eigen::MatrixXf sum;
  compare(
      "sumOfOuterProducts, rankUpdate", [&] { sum = sumOfOuterProducts(rows); },
      [&] {
        sum.setZero(columns, columns);
        sum.selfadjointView<Eigen::Lower>().rankUpdate(rows.transpose());
      });
  const Eigen::MatrixXd square = rows.cast<double>().transpose() * rows.cast<double>();
  Eigen::MatrixXd inverse;
  compare(
      "inverseOf, llt", [&] { inverse = inverseOf(square); },
      [&] { inverse = square.llt().solve(Eigen::MatrixXd::Identity(columns, columns)); });
  const Points points = Points::Random(3 * nodes, 3).rowwise().normalized(),
               centres = points.topRows(nodes / 2), vectors = Points::Random(nodes / 2, 3);
  Points sums;
  compare(
      "kernelSums, exp", [&] { sums = kernelSums(points, centres, vectors, 5); },
      [&] {
        sums = ((points * centres.transpose()).array() * 5.0 - 5.0).exp().matrix() * vectors;
      });
  const RowsF single = RowsF::Random(3 * nodes, local);
  const Eigen::Matrix<double, Eigen::Dynamic, local, Eigen::RowMajor> basis = single.cast<double>();
  const Eigen::VectorXd c = Eigen::VectorXd::Random(local), f = Eigen::VectorXd::Random(3 * nodes);
  const Eigen::VectorXf cSingle = c.cast<float>(), fSingle = f.cast<float>();
  Eigen::VectorXd moved, pull;
  Eigen::VectorXf movedSingle, pullSingle;
  compare(
      "B c in single precision, in double", [&] { movedSingle = single * cSingle; },
      [&] { moved = basis * c; });
  compare(
      "B^T f in single precision, in double", [&] { pullSingle = single.transpose() * fSingle; },
      [&] { pull = basis.transpose() * f; });
}

void run(const Options& options) {
  std::vector<ClosedSurface> surfaces;
  double vertices = 0;
  for (const std::string& file : options.files) {
    const PlyMesh mesh = readPly(file);
    surfaces.emplace_back(mesh.vertices, mesh.faces, file);
    vertices += surfaces.back().vertexCount();
  }
  if (options.root < 0 || options.root >= static_cast<int>(surfaces.size()))
    throw std::invalid_argument("There is no layer " + std::to_string(options.root) +
                                " to be the root.");
  const ClosedSurface& root = surfaces[static_cast<size_t>(options.root)];
  RootMapParameters rootParameters;
  rootParameters.threads = options.parameters.threads;
  std::vector<RootMapResult> rootMap;
  const Cost ofRoot(options.repeat, [&] { rootMap = {makeRootMap(root, rootParameters)}; });
  Propagation made;
  PropagationParameters parameters = options.parameters;
  if (options.order == "cyclic")
    parameters.closing = closingArc(static_cast<int>(surfaces.size()), options.root);
  const Cost ofPropagation(options.repeat, [&] {
    const Sequence sequence(surfaces);
    made = propagate(sequence, rootMap.front().map, treeOf(options, sequence), parameters);
  });
  std::vector<Remeshed> remeshed;
  const auto layers = static_cast<int>(surfaces.size());
  ThreadPool pool(options.parameters.threads);
  const Cost ofRemeshing(options.repeat, [&] {
    const IcosphereRemesher remesher(10);
    remeshed = pool.makeEach(layers, [&](int i) {
      const auto k = static_cast<size_t>(i);
      return remesher.remesh(made.layers[k].map());
    });
  });
  const IcosphereRemesher remesher(10);
  const Cost ofDistances(options.repeat, [&] {
    pool.forEach(layers, [&](int i) {
      const auto k = static_cast<size_t>(i);
      remesher.distance(remeshed[k], made.layers[k].map());
    });
  });

  long flips = 0, stoodIn = 0, repaired = 0;
  double residual = 0;
  for (size_t i = 0; i < surfaces.size(); ++i) {
    flips += certify(surfaces[i].faces(), made.layers[i].map().positions()).flippedFaces;
    stoodIn += made.layers[i].route != Route::Method;
    repaired += made.layers[i].transferred.repairedFaces;
    residual += made.layers[i].transferred.residual.mean / static_cast<double>(surfaces.size() - 1);
  }
  std::printf(
      "layers=%zu root_vertices=%d mean_vertices=%.0f flips=%ld stood_in=%ld repaired=%ld "
      "residual=%.4f u=%.5f",
      surfaces.size(), root.vertexCount(), vertices / static_cast<double>(surfaces.size()), flips,
      stoodIn, repaired, residual, unitSeconds(root.vertices(), root.faces()));
  const std::map<std::string, Cost> costs = {{"distances", ofDistances},
                                             {"propagation", ofPropagation},
                                             {"remeshing", ofRemeshing},
                                             {"root", ofRoot}};
  for (const auto& [name, cost] : costs)
    std::printf(" %s_cpu=%.4f %s_wall=%.4f", name.c_str(), cost.cpu, name.c_str(), cost.wall);
  std::printf("\n");

  if (!options.rootMap.empty())
    writePly(options.rootMap, {root.vertices(), root.faces(), rootMap.front().map.positions()});
  if (!options.uncertainty.empty()) {
    std::ofstream file(options.uncertainty, std::ios::binary);
    for (const PropagatedLayer& layer : made.layers) {
      const SphereLocator under(layer.map());
      const Points directions = icosphere(10).vertices;
      for (Eigen::Index i = 0; i < directions.rows(); ++i) {
        double known = std::nan("");
        if (layer.uncertainty.size() > 0) {
          const SurfacePoint point = under.locate(directions.row(i).transpose());
          known = 0;
          for (int k = 0; k < 3; ++k)
            known += point.weights[k] * layer.uncertainty[layer.map().faces()(point.face, k)];
        }
        file.write(reinterpret_cast<const char*>(&known), sizeof known);
      }
    }
  }
  if (options.landmarks.empty()) return;
  std::ofstream file(options.landmarks, std::ios::binary);
  for (const Remeshed& layer : remeshed)
    file.write(reinterpret_cast<const char*>(layer.landmarks.data()),
               static_cast<std::streamsize>(sizeof(double)) *
                   static_cast<std::streamsize>(layer.landmarks.size()));
}

}  // namespace
}  // namespace sphere_propagation::benchmark

int main(int count, char** arguments) {
  using namespace sphere_propagation::benchmark;
  try {
    const Options options = optionsOf({arguments + 1, arguments + count});
    if (options.kernels) {
      compareKernels();
      return 0;
    }
    if (options.files.empty()) {
      std::printf("%s", usage);
      return 2;
    }
    run(options);
  } catch (const std::exception& error) {
    std::printf("%s\n", error.what());
    return 1;
  }
  return 0;
}
