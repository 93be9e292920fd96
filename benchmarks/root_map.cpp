// SPDX-License-Identifier: GPL-3.0-only
// root_map_benchmark [OPTION...] MESH...
//
// Maps each mesh to the sphere and prints one line: what came of it, and what it cost. MESH is a
// PLY file or made here:
//   blob:FREQUENCY[:NOISE[:SEED]]   limbs:SEGMENTS:SUBDIVISIONS   tree:DEPTH:SEGMENTS:SUBDIVISIONS
//   disc:RINGS   coil:TURNS:AROUND:ALONG
// Options, each for the meshes after it:
//   --threads N       0 = all; default 1
//   --area-weight W   --initial-map 0|1|2 (Automatic, Brechbuehler, Harmonic)
//   --repeat N        take the least of N runs, after one that is not counted
//   --unit 0|1        also time the unit u (default 1)
//   --save FILE       write the mesh, with its map as px, py, pz
//   --measure         the file already has a map: measure that one
//   --progress        print how far it says it is, and the CPU seconds until then
//   --make FILE       write the mesh without a map and do no more
//   --level N FILE    write the level of the hierarchy with N vertices, with a map of its own, and
//   do no more

#include <sys/resource.h>

#include <cstdio>
#include <exception>
#include <sstream>
#include <string>
#include <vector>

#include "benchmarks/ply.h"
#include "benchmarks/timing.h"
#include "tests/core/limb_meshes.h"
#include "vcg_ext/base/stopwatch.h"
#include "vcg_ext/mesh/hierarchy/collapsible_mesh.h"
#include "vcg_ext/mesh/hierarchy/simplification.h"
#include "vcg_ext/mesh/hierarchy/spatial_order.h"
#include "vcg_ext/root_map/root_map.h"
#include "vcg_ext/sphere/map_measures.h"

namespace sphere_propagation::benchmark {
namespace {

PlyMesh meshOf(const std::string& name) {
  std::istringstream words(name);
  std::string kind, word;
  std::getline(words, kind, ':');
  std::vector<double> x;
  if (kind != name || kind == "disc")
    while (std::getline(words, word, ':')) x.push_back(std::stod(word));
  const auto at = [&](size_t i, double otherwise) { return i < x.size() ? x[i] : otherwise; };
  const auto whole = [&](size_t i, double otherwise) { return static_cast<int>(at(i, otherwise)); };
  test::Mesh mesh;
  if (x.empty()) return readPly(name);
  if (kind == "blob")
    mesh = test::blob(whole(0, 10), at(1, 0.3), static_cast<unsigned>(whole(2, 1)));
  if (kind == "limbs") mesh = test::limbs(whole(0, 10), whole(1, 2));
  if (kind == "tree") mesh = test::tree(whole(0, 2), whole(1, 4), whole(2, 2));
  if (kind == "disc") mesh = test::disc(whole(0, 30));
  if (kind == "coil") mesh = test::coil(at(0, 3), whole(1, 24), whole(2, 200));
  return {mesh.vertices, mesh.faces, {}};
}

struct Options {
  RootMapParameters parameters;
  int repeat = 1;
  bool unit = true, measure = false, progress = false;
  std::string save, make, level;
  int levelVertices = 0;
};

/// What the hierarchy keeps of a mesh, mapped.
PlyMesh levelOf(const PlyMesh& mesh, const std::string& name, const Options& options) {
  const ClosedSurface surface(mesh.vertices, mesh.faces, name);
  const std::vector<int> order = spatialOrder(surface.vertices());
  CollapsibleMesh level(surface, order);
  ThreadPool pool;
  simplify(level, pool);
  while (level.vertexCount() < std::min(options.levelVertices, level.allVertices())) level.undo();
  PlyMesh result;
  std::vector<int> vertices, faceOf;
  result.faces = level.rings(vertices, faceOf).faces;
  result.vertices.resize(static_cast<Eigen::Index>(vertices.size()), 3);
  for (size_t i = 0; i < vertices.size(); ++i)
    result.vertices.row(static_cast<Eigen::Index>(i)) = surface.vertices().row(order[vertices[i]]);
  result.map = makeRootMap(ClosedSurface(result.vertices, result.faces, name), options.parameters)
                   .map.positions();
  return result;
}

void run(const std::string& name, const Options& options) {
  PlyMesh mesh = meshOf(name);
  if (!options.make.empty()) return writePly(options.make, mesh);
  if (!options.level.empty()) return writePly(options.level, levelOf(mesh, name, options));
  const double checking = cpuSeconds();
  const ClosedSurface surface(mesh.vertices, mesh.faces, name);
  const double checked = cpuSeconds() - checking;
  double cpu = 0, wall = 0;
  std::string how;
  if (!options.measure)
    for (int i = options.repeat > 1 ? -1 : 0; i < options.repeat; ++i) {
      const double start = cpuSeconds();
      const Stopwatch stopwatch;
      const RootMapResult result = makeRootMap(surface, options.parameters, [&](double fraction) {
        if (options.progress)
          std::printf("  %5.1f %% after %.3f s\n", 100 * fraction, cpuSeconds() - start);
      });
      const double seconds = stopwatch.seconds(), used = cpuSeconds() - start;
      if (i <= 0 || used < cpu) cpu = used;
      if (i <= 0 || seconds < wall) wall = seconds;
      mesh.map = result.map.positions();
      how = nameOf(result.used) + ", " + std::to_string(result.levels) + " levels, " +
            std::to_string(result.steps) + " steps";
    }
  const double measuring = cpuSeconds();
  const MapMeasures measures = measureMap(surface, mesh.map);
  const double measured = cpuSeconds() - measuring;
  std::printf("%s: vertices=%d flips=%ld degree=%.6f sd=%.5f log=%.5f angle=%.3f", name.c_str(),
              surface.vertexCount(), measures.certificate.flippedFaces, measures.certificate.degree,
              measures.areaRatioSd, measures.areaLogMean, measures.angleErrorMean);
  if (!options.measure) {
    rusage usage{};
    getrusage(RUSAGE_SELF, &usage);
    std::printf(" cpu=%.4f wall=%.4f checks=%.3f measures=%.3f MB=%ld", cpu, wall, checked,
                measured, usage.ru_maxrss / 1024);
    if (options.unit) {
      const double unit = unitSeconds(surface.vertices(), surface.faces());
      std::printf(" u=%.5f ratio=%.2f", unit, cpu / unit);
    }
    std::printf(" (%s)", how.c_str());
  }
  std::printf("\n");
  std::fflush(stdout);
  if (!options.save.empty()) writePly(options.save, mesh);
}

int main(const std::vector<std::string>& arguments) {
  Options options;
  options.parameters.threads = 1;
  int failed = 0;
  for (size_t i = 0; i < arguments.size(); ++i) {
    const std::string& word = arguments[i];
    const auto value = [&] { return arguments.at(++i); };
    if (word == "--area-weight") {
      options.parameters.areaWeight = std::stod(value());
    } else if (word == "--initial-map") {
      options.parameters.initialMap = static_cast<InitialMap>(std::stoi(value()));
    } else if (word == "--threads") {
      options.parameters.threads = std::stoi(value());
    } else if (word == "--repeat") {
      options.repeat = std::stoi(value());
    } else if (word == "--unit") {
      options.unit = std::stoi(value()) != 0;
    } else if (word == "--save") {
      options.save = value();
    } else if (word == "--make") {
      options.make = value();
    } else if (word == "--level") {
      options.levelVertices = std::stoi(value());
      options.level = value();
    } else if (word == "--progress") {
      options.progress = true;
    } else if (word == "--measure") {
      options.measure = true;
    } else {
      try {
        run(word, options);
      } catch (const std::exception& error) {
        std::printf("%s: %s\n", word.c_str(), error.what());
        failed = 1;
      }
    }
  }
  return failed;
}

}  // namespace
}  // namespace sphere_propagation::benchmark

int main(int count, char** arguments) {
  return sphere_propagation::benchmark::main({arguments + 1, arguments + count});
}
