// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// From a triangle mesh with the defects of files to a closed surface.

#include <optional>
#include <string>
#include <vector>

#include "vcg_ext/base/error.h"
#include "vcg_ext/base/progress.h"
#include "vcg_ext/preparation/openings.h"
#include "vcg_ext/preparation/orientation.h"
#include "vcg_ext/preparation/sheets.h"

namespace sphere_propagation {

struct PreparationParameters {
  bool weld = true;  ///< vertices on open edges that lie in one place, see weldOpenEdges; vertices
                     ///< without faces are dropped
  bool removeDuplicateFaces = true;  ///< and faces without area
  bool removeFins = true;            ///< see separateSheets
  bool joinShells = false;           ///< the two sides of a wall, see openings.h
  bool keepLargestComponent = true;  ///< by area
  bool closeOpenings = true;         ///< see closeOpenings
  LidShape lid = LidShape::Curved;
  bool orient = true;          ///< faces alike, and outwards
  bool removeHandles = false;  ///< where there are any, see withoutHandles: the whole surface is
                               ///< then a new one
};

/// A surface after its preparation, and what was done.
struct PreparedMesh {
  Points vertices;           ///< #V by 3
  Triangles faces;           ///< #F by 3
  std::vector<int> source;   ///< #V: the vertex of the input, in whose place it is; -1: a new one
  std::vector<int> lid;      ///< #V: number (from 1) of the opening whose lid it belongs to, or 0
  std::vector<int> faceLid;  ///< #F: the same; faces of lids may have all corners on the rim

  bool changed = false;       ///< false: it was closed and clean, and is as it was
  int nonFiniteVertices = 0;  ///< dropped with their faces, whatever was asked for
  int weldedVertices = 0;     ///< merged into others
  int unusedVertices = 0;     ///< that no face used
  int duplicateFaces = 0;     ///< dropped, those that use one vertex twice with them
  int flatFaces = 0;          ///< without area, mended
  SeparatedSheets sheets;
  DroppedSurfaces dropped;
  int turnedFaces = 0;
  std::vector<Opening> openings;  ///< the first of them between shells, where there were some
  int rings = 0;                  ///< how many of them
  int joinedShells = 0;           ///< inner sides of a wall that were joined to the outer one
  bool shells = false;            ///< it held the sides of a wall, which were not joined
  int handles = 0;                ///< removed
  double voxelSize = 0;           ///< of the volume in which they were
  bool oneSided = false;          ///< as a Moebius strip: no step closes or orients it
  std::optional<Finding> left;    ///< why it is no ClosedSurface yet; nothing where it is one
};

/// The steps in the order of the parameters, each as far as it is asked for. The order of vertices
/// and faces stays; new ones come last. A mesh that is a ClosedSurface without flat faces is
/// returned as it is.
///
/// vertices: #V by 3; faces: #F by 3; name: what findings call the surface. Throws SurfaceError
/// where nothing can be prepared: no faces, or faces that refer to vertices that are not there.
PreparedMesh preparedMesh(const Points& vertices, const Triangles& faces,
                          const PreparationParameters& parameters = {},
                          const std::string& name = "surface", const Progress& progress = {});

}  // namespace sphere_propagation
