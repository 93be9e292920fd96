// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/anchors/exact_map.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "vcg_ext/anchors/coarse_map.h"
#include "vcg_ext/area/area_minimiser.h"
#include "vcg_ext/base/error.h"
#include "vcg_ext/sphere/certificate.h"
#include "vcg_ext/sphere/repair/untangling.h"

namespace sphere_propagation {
namespace {

constexpr double widthPerWay = 2, leastWidth = 0.12, mostWidth = 0.6, stepPerWidth = 0.15;
/// Of the energy that is lowered, shapes weigh so much beside areas. With 1 angles are worse and
/// areas hardly better.
constexpr double shapeWeight = 3;
/// Relaxation ends with the step that leaves this share of the energy or more; its systems are
/// solved no better than that takes.
struct Effort {
  int steps;  ///< at most
  double enough;
  int conjugateGradientIterations;
};
constexpr Effort onTheWay{4, 0.98, 40}, atEnd{20, 0.997, 40};
constexpr double conjugateGradientTolerance = 0.1;
/// Far ways are gone with a share of the vertices, not too few. Every time that so many times as
/// many are back, what they carry is relaxed; in the end little but what is near is left.
constexpr double coarseShare = 0.1, stageRatio = 2.5;
constexpr int fewestVertices = 800;
constexpr Effort ofFew{40, 0.999, 40}, ofStage{20, 0.995, 20}, ofAll{4, 0.97, 12};
constexpr double onePlace = 1e-9;   // radians
constexpr double leastApart = 0.2;  // of what two are apart at the ends of their ways
constexpr int placesOnTheWay = 50;
/// Within so many radians, what is interpolated from the corners of faces is aimed at: that
/// converges quickly where faces are large, but on long ways it tears at corners that are far.
constexpr double nearEnds = 1e-3;
/// Ways longer than this (radians) are relaxed for, in the end and so often on the way.
constexpr double farAway = 0.15, betweenRelaxations = 0.3;

/// A step that cannot be untangled is halved, down to this share of the usual.
constexpr double leastShare = 0.05;

/// How points are brought to their targets: mostly the first finds a map, sometimes only another.
struct Manner {
  bool faceAsItIs;  ///< the corners of a point's face go with it
  bool spreads;     ///< what is squeezed and stretched on long ways, on the way
  bool waits;       ///< where a step cannot be untangled: spreads, and takes half of it
  int mostSteps;
  int ringsWithHeld;  ///< of patches that are untangled
};
constexpr Manner manners[]{
    {true, true, true, 150, 12}, {true, true, false, 240, 12}, {false, false, false, 60, 4}};

/// The tangent at p that leads to q along the great circle, as long as the way.
Vector3 wayFrom(const Vector3& p, const Vector3& q) {
  const Vector3 along = q - p.dot(q) * p;
  const double length = along.norm();
  if (length == 0) return Vector3::Zero();
  return std::atan2(length, p.dot(q)) / length * along;
}

/// x turned by |w| about w.
Vector3 turned(const Vector3& x, const Vector3& w) {
  const double angle = w.norm();
  if (angle == 0) return x;
  return (Eigen::AngleAxisd(angle, w / angle) * x).normalized();
}

Vector3 normalTo(const Vector3& p) {
  return p.cross(std::fabs(p[2]) < 0.9 ? Vector3(0, 0, 1) : Vector3(1, 0, 0)).normalized();
}

/// A point of the surface on the sphere, with what it is interpolated from.
struct PlaceInFace {
  Vector3 place;
  std::array<Vector3, 3> corners;  ///< of its face
  Vector3 weights;
  double length = 1;  ///< of the interpolated corners
};

/// A field of rotations that moves the given places by given velocities, to first order where the
/// corners of their faces move with it.
class RotationField {
 public:
  /// velocities: tangent at the places.
  RotationField(const std::vector<PlaceInFace>& places, const std::vector<Vector3>& velocities,
                double width)
      : scale_(0.5 / (width * width)) {
    const auto count = static_cast<Eigen::Index>(places.size());
    Eigen::MatrixXd matrix = Eigen::MatrixXd::Zero(2 * count, 2 * count);
    Eigen::VectorXd wanted(2 * count);
    std::vector<Eigen::Matrix<double, 3, 2>> tangents;
    for (const PlaceInFace& p : places) {
      places_.push_back(p.place);
      const Vector3 e = normalTo(p.place);
      tangents.emplace_back();
      tangents.back() << e, p.place.cross(e);
    }
    for (Eigen::Index k = 0; k < count; ++k) {
      const auto& ofK = tangents[static_cast<size_t>(k)];
      const PlaceInFace& p = places[static_cast<size_t>(k)];
      // e . (w x x) = w . (x x e)
      for (Eigen::Index corner = 0; corner < 3; ++corner) {
        const Vector3& x = p.corners[static_cast<size_t>(corner)];
        Eigen::Matrix<double, 3, 2> turned;
        turned << x.cross(ofK.col(0)), x.cross(ofK.col(1));
        turned *= p.weights[corner] / p.length;
        for (Eigen::Index j = 0; j < count; ++j)
          matrix.block<2, 2>(2 * k, 2 * j) += kernel(x, static_cast<size_t>(j)) *
                                              turned.transpose() * tangents[static_cast<size_t>(j)];
      }
      wanted.segment<2>(2 * k) = ofK.transpose() * velocities[static_cast<size_t>(k)];
    }
    const Eigen::VectorXd solution = matrix.partialPivLu().solve(wanted);
    for (Eigen::Index k = 0; k < count; ++k)
      turns_.emplace_back(tangents[static_cast<size_t>(k)] * solution.segment<2>(2 * k));
  }

  Vector3 at(const Vector3& x) const {
    Vector3 turn = Vector3::Zero();
    for (size_t k = 0; k < places_.size(); ++k) turn += kernel(x, k) * turns_[k];
    return turn;
  }

 private:
  double kernel(const Vector3& x, size_t k) const {
    return std::exp(-scale_ * (x - places_[k]).squaredNorm());
  }

  std::vector<Vector3> places_, turns_;
  double scale_;
};

/// Throws where two points lie in one place, or would have to pass each other.
void requireApart(const std::vector<Vector3>& from, const std::vector<Vector3>& to,
                  const std::string& surface, const std::vector<std::string>& names) {
  for (size_t i = 0; i < from.size(); ++i)
    for (size_t j = i + 1; j < from.size(); ++j) {
      const double ends = std::min((from[i] - from[j]).norm(), (to[i] - to[j]).norm());
      const auto refuse = [&](Fault fault) {
        throw AnchorError(Finding(fault, surface).against(names[i]).saying(names[j]));
      };
      if (ends < onePlace) refuse(Fault::AnchorsInOnePlace);
      const Vector3 turnI = from[i].cross(wayFrom(from[i], to[i])),
                    turnJ = from[j].cross(wayFrom(from[j], to[j]));
      double least = ends;
      for (int step = 0; step <= placesOnTheWay; ++step) {
        const double share = static_cast<double>(step) / placesOnTheWay;
        least = std::min(least,
                         (turned(from[i], share * turnI) - turned(from[j], share * turnJ)).norm());
      }
      if (least < leastApart * ends) refuse(Fault::AnchorsChangePlaces);
    }
}

Vector3 placeAt(const Triangles& faces, const Points& positions, const SurfacePoint& point) {
  return point.interpolate(faces, positions).normalized();
}

PlaceInFace placeWithCorners(const MappedSurface& map, const SurfacePoint& point) {
  PlaceInFace place;
  place.weights = point.weights;
  for (int k = 0; k < 3; ++k)
    place.corners[static_cast<size_t>(k)] = map.position(map.faces()(point.face, k));
  place.place = point.interpolate(map.faces(), map.positions());
  place.length = place.place.norm();
  place.place /= place.length;
  return place;
}

/// Its face as small as a point.
PlaceInFace placeAsVertex(const Vector3& place) {
  return {place, {place, place, place}, Vector3::UnitX(), 1};
}

/// Corners of points' faces go with them, as rigid as they are, but for those of several.
constexpr int nobody = -1, several = -2;

/// Which point each vertex goes with.
std::vector<int> ownersOf(const ClosedSurface& surface, const std::vector<SurfacePoint>& points) {
  std::vector<int> owners(static_cast<size_t>(surface.vertexCount()), nobody);
  for (size_t k = 0; k < points.size(); ++k)
    for (int corner = 0; corner < 3; ++corner) {
      int& its = owners[static_cast<size_t>(surface.faces()(points[k].face, corner))];
      its = its == nobody ? static_cast<int>(k) : several;
    }
  return owners;
}

std::vector<char> heldBy(const std::vector<int>& owners) {
  std::vector<char> held;
  held.reserve(owners.size());
  for (const int its : owners) held.push_back(its != nobody);
  return held;
}

/// What the flow has squeezed and stretched spreads over the sphere while what is held stays.
class Relaxation {
 public:
  /// given: the map as it was, on these vertices; freely: 0 keeps its shapes of faces, 1 asks for
  /// the surface's.
  Relaxation(FaceRings rings, const Points& vertices, const Points& given, std::vector<char> held,
             double freely)
      : minimiser_(withTargets(std::move(rings), vertices, given, static_cast<float>(freely))) {
    minimiser_.hold(std::move(held));
  }
  Relaxation(const MappedSurface& given, std::vector<char> held, double freely)
      : Relaxation(FaceRings::of(given.surface()), given.surface().vertices(), given.positions(),
                   std::move(held), freely) {}

  void lower(Points& positions, const Effort& effort) {
    AreaStepParameters parameters;
    parameters.weights = {1, shapeWeight};
    parameters.conjugateGradientIterations = effort.conjugateGradientIterations;
    parameters.conjugateGradientTolerance = conjugateGradientTolerance;
    for (int i = 0; i < effort.steps; ++i)
      if (minimiser_.step(parameters, positions) > effort.enough) break;
  }

  MappedSurface of(const MappedSurface& map, const Effort& effort) {
    Points positions = map.positions();
    lower(positions, effort);
    const std::optional<MappedSurface> relaxed = MappedSurface::ifValid(map.surface(), positions);
    return relaxed ? *relaxed : map;
  }

 private:
  static AreaMinimiser withTargets(FaceRings rings, const Points& vertices, const Points& given,
                                   float freely) {
    std::vector<FaceTarget> targets = faceTargets(given, rings.faces);
    const std::vector<FaceTarget> surface = faceTargets(vertices, rings.faces);
    for (size_t f = 0; f < targets.size(); ++f)
      for (size_t k = 0; k < 3; ++k)
        targets[f].stiffness[k] += freely * (surface[f].stiffness[k] - targets[f].stiffness[k]);
    return AreaMinimiser(std::move(rings), std::move(targets));
  }

  AreaMinimiser minimiser_;
};

/// How much the surface counts beside the given map where shapes of faces are asked for.
double freedomAfter(double longestWay) { return std::min(1.0, 2 * longestWay); }

/// Throws AnchorError where the manner leads nowhere. end: of the last relaxation.
ExactMap broughtTo(const MappedSurface& map, const std::vector<SurfacePoint>& points,
                   const std::vector<Vector3>& targets, const std::vector<std::string>& names,
                   const Manner& manner, const Effort& end) {
  ExactMap result{map};
  const ClosedSurface& surface = map.surface();
  std::vector<Vector3> places(points.size()), left(points.size());
  size_t worst = 0;
  const auto look = [&] {
    double most = -1;
    for (size_t k = 0; k < points.size(); ++k) {
      places[k] = placeOf(result.map, points[k]);
      left[k] = wayFrom(places[k], targets[k]);
      if (left[k].norm() > most) most = left[worst = k].norm();
    }
    return most;
  };
  double most = result.longestWay = look();
  const double width = std::clamp(widthPerWay * most, leastWidth, mostWidth);
  const std::vector<int> owners = ownersOf(surface, points);
  const std::vector<char> held = heldBy(owners);
  const auto movedBy = [&](double share) {
    std::vector<Vector3> velocities = left;
    for (Vector3& velocity : velocities) velocity *= share;
    std::vector<PlaceInFace> withCorners;
    withCorners.reserve(points.size());
    for (size_t k = 0; k < points.size(); ++k)
      withCorners.push_back(most < nearEnds ? placeWithCorners(result.map, points[k])
                                            : placeAsVertex(places[k]));
    const RotationField field(withCorners, velocities, width);
    std::vector<Vector3> turns;  // of the points' faces
    for (size_t k = 0; k < points.size(); ++k)
      turns.push_back(most < nearEnds ? Vector3(places[k].cross(velocities[k]))
                                      : field.at(places[k]));
    Points moved = result.map.positions();
    for (Eigen::Index v = 0; v < moved.rows(); ++v) {
      const Vector3 x = moved.row(v).transpose();
      const int k = manner.faceAsItIs ? owners[static_cast<size_t>(v)] : nobody;
      moved.row(v) = turned(x, k >= 0 ? turns[static_cast<size_t>(k)] : field.at(x)).transpose();
    }
    return moved;
  };
  std::optional<Relaxation> relaxation;
  if (result.longestWay > farAway) relaxation.emplace(map, held, freedomAfter(result.longestWay));
  double sinceRelaxed = 0, shorter = 1;
  for (;; most = look(), ++result.steps) {
    if (most < exactDistance) {
      if (!relaxation) break;
      result.map = relaxation->of(result.map, end);
      relaxation.reset();  // what follows are the last bits
      continue;
    }
    if (result.steps == manner.mostSteps)
      throw AnchorError(
          Finding(Fault::AnchorsNotHeld, surface.name()).against(names[worst]).at(most));
    const double share = std::min(1.0, shorter * stepPerWidth * width / most);
    sinceRelaxed += share * most;
    Points moved = movedBy(share);
    if (std::optional<MappedSurface> valid = MappedSurface::ifValid(surface, moved)) {
      result.map = std::move(*valid);
    } else {
      try {
        Untangled mended = untangle(surface, moved, manner.ringsWithHeld, {}, held);
        result.untangledFaces += mended.repairedFaces;
        result.map = std::move(mended.map);
      } catch (const MapError&) {
        if (relaxation && manner.waits && shorter > leastShare) {
          result.map = relaxation->of(result.map, onTheWay);
          shorter /= 2;
          sinceRelaxed = 0;
          continue;
        }
        // What moves the points, too; the next steps bring them back.
        Untangled mended = mend(surface, std::move(moved));
        result.untangledFaces += mended.repairedFaces;
        result.map = std::move(mended.map);
        sinceRelaxed = betweenRelaxations;
      }
    }
    if (relaxation && manner.spreads && sinceRelaxed >= betweenRelaxations) {
      result.map = relaxation->of(result.map, onTheWay);
      sinceRelaxed = 0;
    }
    shorter = std::min(1.0, 2 * shorter);
  }
  return result;
}

/// The same with a share of the vertices, which then take the others along; nothing where the mesh
/// has few, and where this finds no map.
std::optional<ExactMap> broughtByFew(const MappedSurface& map,
                                     const std::vector<SurfacePoint>& points,
                                     const std::vector<Vector3>& targets,
                                     const std::vector<std::string>& names) {
  const int vertices = std::max(static_cast<int>(coarseShare * map.vertexCount()), fewestVertices);
  if (2 * vertices > map.vertexCount()) return std::nullopt;
  const std::vector<char> held = heldBy(ownersOf(map.surface(), points));
  try {
    CoarseMap coarse(map, held, vertices);
    std::vector<SurfacePoint> onCoarse;
    onCoarse.reserve(points.size());
    for (const SurfacePoint& point : points) onCoarse.push_back(coarse.onCoarse(point));
    ExactMap result = broughtTo(coarse.map(), onCoarse, targets, names, manners[0], ofFew);
    const double freely = freedomAfter(result.longestWay);
    result.map = coarse.refined(result.map.positions(), stageRatio, [&](CoarseMap::Stage& stage) {
      Relaxation(std::move(stage.rings), stage.vertices, stage.before, std::move(stage.kept),
                 freely)
          .lower(stage.positions, ofStage);
    });
    result.map = Relaxation(map, held, freely).of(result.map, ofAll);
    for (size_t k = 0; k < points.size(); ++k)
      if (!(wayFrom(placeOf(result.map, points[k]), targets[k]).norm() < exactDistance))
        return std::nullopt;
    return result;
  } catch (const Error&) {  // too few for where the points go
    return std::nullopt;
  }
}

}  // namespace

Vector3 placeOf(const MappedSurface& map, const SurfacePoint& point) {
  return placeAt(map.faces(), map.positions(), point);
}

ExactMap holdExactly(const MappedSurface& map, const std::vector<SurfacePoint>& points,
                     const std::vector<Vector3>& targets, const std::vector<std::string>& names) {
  if (points.empty()) return {map};
  std::vector<Vector3> places;
  places.reserve(points.size());
  for (const SurfacePoint& point : points) places.push_back(placeOf(map, point));
  requireApart(places, targets, map.surface().name(), names);
  double longest = 0;
  for (size_t k = 0; k < points.size(); ++k)
    longest = std::max(longest, wayFrom(places[k], targets[k]).norm());
  if (longest > farAway)
    if (std::optional<ExactMap> brought = broughtByFew(map, points, targets, names))
      return std::move(*brought);
  std::optional<AnchorError> first;  // says more than those of the others
  for (const Manner& manner : manners) {
    try {
      return broughtTo(map, points, targets, names, manner, atEnd);
    } catch (const AnchorError& error) {
      if (!first) first = error;
    }
  }
  throw *first;
}

}  // namespace sphere_propagation
