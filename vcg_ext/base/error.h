// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// What vcg_ext throws on purpose. The text is written for the user: it names the layer, what is
/// wrong (how many, and the index of the first) and what to do about it.

#include <stdexcept>
#include <string>

namespace sphere_propagation {

/// Base of all errors below; catch this one to catch them all.
class Error : public std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// A parameter is outside the range that its header documents.
class ParameterError : public Error {
  using Error::Error;
};

/// A mesh is no closed surface of genus 0.
class SurfaceError : public Error {
 public:
  enum class Defect {
    Empty,                    ///< no faces
    TooFewVertices,           ///< fewer than four
    NonFiniteCoordinate,      ///< NaN or infinite
    IndexOutOfRange,          ///< a face refers to a vertex that is not there
    DegenerateFace,           ///< a face uses one vertex twice
    NonManifoldEdge,          ///< more than two faces at an edge
    NotClosed,                ///< one face at an edge
    InconsistentOrientation,  ///< two faces run along an edge in the same direction
    UnreferencedVertex,       ///< in no face
    NonManifoldVertex,        ///< the faces around it are more than one fan
    SeveralParts,             ///< more than one connected component
    Handles,                  ///< genus above 0
    InwardOrientation,        ///< encloses a negative volume
    ZeroArea,                 ///< no face has an area
    Flat,                     ///< all vertices lie in one plane
    CoordinateRange,  ///< so large or so small that squares and products of lengths leave the range
                      ///< of numbers
  };
  SurfaceError(Defect what, long howMany, long firstIndex, const std::string& text)
      : Error(text), defect(what), count(howMany), first(firstIndex) {}
  Defect defect;
  long count;  ///< how many elements are concerned
  long first;  ///< index of the first of them (vertex or face, as the text says); -1 where none can
               ///< be named
};

/// Positions on the sphere are no valid map, or no valid map could be reached.
class MapError : public Error {
 public:
  MapError(long howMany, long firstIndex, const std::string& text)
      : Error(text), count(howMany), first(firstIndex) {}
  long count;  ///< how many faces (or vertices, as the text says) are concerned
  long first;  ///< index of the first of them; -1 where none can be named
};

/// A label volume cannot be read, or holds no surface.
class VolumeError : public Error {
  using Error::Error;
};

/// A label that was asked for occurs nowhere in a label volume.
class AbsentLabelError : public VolumeError {
  using VolumeError::VolumeError;
};

/// A file cannot be written; nothing was changed in what was there before.
class ExportError : public Error {
  using Error::Error;
};

/// A map cannot be handed from one surface to another: they correspond nowhere.
class PropagationError : public Error {
  using Error::Error;
};

}  // namespace sphere_propagation
