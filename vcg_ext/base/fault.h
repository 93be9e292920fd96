// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// What can be wrong with what a user gives, as data. Each fault has one sentence, which states it
/// in the words of this library; what to do about it is for the host to say, who knows its menus
/// (host/remedies.h), or the caller, who has arrays.

#include <string>
#include <string_view>
#include <vector>

namespace sphere_propagation {

enum class Fault {
  Text,  ///< said in words only

  // mesh: a mesh is not a closed surface of genus 0
  Empty,                    ///< neither vertices nor faces
  NoFaces,                  ///< vertices only
  TooFewVertices,           ///< fewer than four
  NonFiniteCoordinate,      ///< NaN or infinite
  IndexOutOfRange,          ///< a face refers to a vertex that is not there
  DegenerateFace,           ///< a face uses one vertex twice
  NonManifoldEdge,          ///< more than two faces at an edge
  NotClosed,                ///< one face at an edge
  NotWelded,                ///< the same, and vertices lie where others lie
  InconsistentOrientation,  ///< two faces run along an edge in the same direction
  UnreferencedVertex,       ///< in no face
  NonManifoldVertex,        ///< the faces around it are more than one fan
  SeveralParts,             ///< more than one connected component
  Handles,                  ///< genus above 0
  InwardOrientation,        ///< encloses a negative volume
  ZeroArea,                 ///< no face has an area
  Flat,                     ///< all vertices lie in one plane
  CoordinateTooLarge,       ///< beyond what squares and products of lengths allow
  ExtentTooSmall,           ///< the same at the other end
  IcosphereTooLarge,        ///< a frequency that takes too much memory

  // sphere: positions are no valid map, or cannot be made one
  PositionCount,   ///< not one position per vertex
  NotOnSphere,     ///< positions are not finite or not of unit length
  FlippedFaces,    ///< faces are not positively oriented
  NotCoveredOnce,  ///< the degree is not 1
  NotRepairable,   ///< flipped faces are left
  NoRoom,          ///< a vertex finds no place that flips no face

  // root_map
  NoPlaces,    ///< vertices find no place from coarse to fine
  NoValidMap,  ///< no start leads to a valid map

  // sequence: a tree of surfaces
  NoSurface,         ///< no surface at all
  RootOutOfRange,    ///< the root is none of them
  ParentOutOfRange,  ///< a parent is none of them
  SecondRoot,        ///< two are marked as the root
  NoRoot,            ///< none is
  Circle,            ///< maps are handed round

  // propagation
  NoCorrespondence,  ///< no pair of vertices is left
  NothingFixed,      ///< no vertex has a position
  DifferentUnits,    ///< sizes differ too much

  // anchors
  AnchorFileNotRead,    ///< the system refused
  AnchorFileUnknown,    ///< a file's name tells no format that is known
  AnchorFileSyntax,     ///< it is no XML or JSON
  NoAnchors,            ///< it is, but holds no anchors
  AnchorFrame,          ///< its coordinate system is none that is known
  AnchorNotNumbers,     ///< a place that is not three numbers
  AnchorsInOnePlace,    ///< two that cannot be held apart
  AnchorsChangePlaces,  ///< two that would have to pass each other
  AnchorsNotHeld,       ///< no valid map was found that holds all

  // model
  TooFewShapes,         ///< fewer than two
  NoLandmarks,          ///< a shape of none
  LandmarkCount,        ///< shapes of different numbers of landmarks
  NonFiniteLandmark,    ///< NaN or infinite
  LandmarksInOnePlace,  ///< no size
  FewSharedAnchors,     ///< too few to align a shape by
  AnchorsOnOneLine,     ///< which leave the turn about it open
  NoFileEnding,         ///< a file's name tells no format
  UnknownFileFormat,    ///< or one that is not known
  FileIsFolder,         ///< a folder is called so
  NoFolder,             ///< the folder is not there
  NotWritten,           ///< the system refused, for a reason of its own
  FileTooLarge,         ///< for its format

  // volume
  EmptyVolume,         ///< no voxels
  LabelCount,          ///< not one label per voxel
  PlaceNotFinite,      ///< the matrix is not finite
  MatrixNotAffine,     ///< its last row
  MatrixFlattens,      ///< it maps the voxels into a plane
  OnlyBackground,      ///< all voxels are 0
  AbsentLabel,         ///< a label occurs nowhere
  TooThin,             ///< no working voxel lies inside
  WorkingVoxelsSmall,  ///< too many of them
  WorkingVoxelsLarge,  ///< larger than the label

  // numbers outside their ranges
  NotBetween,  ///< outside [low, high]
  TooSmall,    ///< below low
  NotAbove,    ///< low or below
};
constexpr int faultCount = static_cast<int>(Fault::NotAbove) + 1;

/// One fault that was found. Which of the fields it uses, its sentence says.
struct Finding {
  explicit Finding(Fault f, std::string ofWhat = {}) : fault(f), name(std::move(ofWhat)) {}

  Fault fault;
  std::string name;          ///< of the surface, shape, file or parameter that has it
  std::string other;         ///< name of a second one: the surface that the map comes from
  std::string detail;        ///< words
  long count = 0;            ///< how many elements are concerned
  long first = -1;           ///< index of the first of them; -1 where none can be named
  long others = 0;           ///< a second number: of how many, out of how many
  double value = 0;          ///< what was found where it is no count
  double low = 0, high = 0;  ///< what it must lie between

  // The same, to be written in one expression.
  Finding& of(long howMany, long firstIndex = -1) {
    count = howMany;
    first = firstIndex;
    return *this;
  }
  Finding& amid(long number) {
    others = number;
    return *this;
  }
  Finding& against(std::string second) {
    other = std::move(second);
    return *this;
  }
  Finding& saying(std::string words) {
    detail = std::move(words);
    return *this;
  }
  Finding& at(double found, double least = 0, double most = 0) {
    value = found;
    low = least;
    high = most;
    return *this;
  }
};

/// "NotClosed": as in the enumeration.
std::string_view nameOf(Fault fault);

/// What is stated, with gaps (sentence.h) that are called as the fields of Finding; {Noun}, {noun}
/// and {nouns} stand for what a surface is called. Without the full stop.
std::string_view sentenceOf(Fault fault);

/// A text about a finding, its gaps filled. noun: what the reader calls a surface.
std::string fill(std::string_view text, const Finding& finding, std::string_view noun);

/// The sentence of a finding, without the full stop: `Surface "systole 7": it is empty`.
inline std::string statement(const Finding& finding, std::string_view noun = "surface") {
  return fill(sentenceOf(finding.fault), finding, noun);
}

}  // namespace sphere_propagation
