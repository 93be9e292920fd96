// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/base/fault.h"

#include <array>
#include <cctype>
#include <locale>
#include <sstream>

#include "vcg_ext/base/sentence.h"

namespace sphere_propagation {
namespace {

struct Entry {
  Fault fault;
  std::string_view name, sentence;
};

#define FAULT(name, sentence) \
  Entry { Fault::name, #name, sentence }
#define SURFACE "{Noun} \"{name}\": "
#define UNMAPPABLE SURFACE "its positions on the sphere cannot be made a valid map"
#define CAME_FROM "[. They come from {noun} \"{other}\", which may be too different from it]"
#define INVALID SURFACE "its map to the sphere is not valid: "
#define NO_ANCHORS_FROM "Anchors cannot be read from \"{name}\""
#define NOT_EXACT SURFACE "its map cannot hold the anchors exactly"
#define NOT_WRITTEN "The model cannot be written to \"{name}\": "

constexpr std::array<Entry, faultCount> entries{
    FAULT(Text, "{detail}"),

    FAULT(Empty, SURFACE "it is empty"),
    FAULT(NoFaces, SURFACE "it has vertices but no faces"),
    FAULT(TooFewVertices, SURFACE "it has {count|vertex|vertices}"),
    FAULT(NonFiniteCoordinate, SURFACE
          "{count|vertex has|vertices have} coordinates that are not finite numbers, the first is "
          "vertex {first}"),
    FAULT(IndexOutOfRange, SURFACE
          "{count|face refers|faces refer} to vertices that do not exist, the first is face "
          "{first}"),
    FAULT(DegenerateFace,
          SURFACE "{count|face uses|faces use} one vertex twice, the first is face {first}"),
    FAULT(NonManifoldEdge,
          SURFACE "{count|edge has|edges have} more than two faces, the first at face {first}"),
    FAULT(NotClosed, SURFACE
          "it is not closed: {count|edge has|edges have} a face on one side only, the first at "
          "face {first}; they surround {others|opening|openings}, the largest of {value} edges"),
    FAULT(NotWelded, SURFACE
          "it is not closed: {count|edge has|edges have} a face on one side only, the first at "
          "face {first}. {others|vertex lies|vertices lie} exactly where another one lies"),
    FAULT(InconsistentOrientation, SURFACE
          "its faces are not oriented alike: {count|edge lies|edges lie} between faces of opposite "
          "orientation, the first at face {first}"),
    FAULT(UnreferencedVertex,
          SURFACE "{count|vertex belongs|vertices belong} to no face, the first is vertex {first}"),
    FAULT(NonManifoldVertex, SURFACE
          "at {count|vertex|vertices} sheets touch that share no edge there, the first is vertex "
          "{first}"),
    FAULT(SeveralParts, SURFACE
          "it has {count} separate parts, vertex {first} is the first outside the part of vertex "
          "0"),
    FAULT(Handles, SURFACE "it has {count|handle|handles} (genus {count}), and a sphere has none"),
    FAULT(InwardOrientation, SURFACE "its faces are oriented inwards"),
    FAULT(ZeroArea, SURFACE "all its faces have zero area"),
    FAULT(Flat, SURFACE "it is flat: all its vertices lie in one plane"),
    FAULT(CoordinateTooLarge,
          SURFACE "its coordinates reach {value}, and beyond {high} nothing can be computed"),
    FAULT(ExtentTooSmall, SURFACE "it is {value} large, and below {low} nothing can be computed"),
    FAULT(IcosphereTooLarge,
          "An icosphere of frequency {value} has {count} landmarks and takes {others} MB for each "
          "surface; the largest frequency is {high}"),

    FAULT(PositionCount, SURFACE "{count} sphere positions for {others} vertices"),
    FAULT(NotOnSphere,
          INVALID "{count|vertex does|vertices do} not lie on the unit sphere, the first is vertex "
                  "{first}"),
    FAULT(FlippedFaces,
          INVALID "{count|face is|faces are} flipped on the sphere, the first is face {first}"),
    FAULT(NotCoveredOnce, INVALID "it covers the sphere {count} times instead of once"),
    FAULT(NotRepairable, UNMAPPABLE
          " by local repair: {others} faces were flipped, {count} still are, the first is face "
          "{first}" CAME_FROM),
    FAULT(NoRoom, UNMAPPABLE ": there is no room for vertex {first}" CAME_FROM),

    FAULT(NoPlaces, SURFACE
          "{count|vertex finds|vertices find} no place on the sphere, the first at face {first}"),
    FAULT(NoValidMap,
          "{Noun} \"{name}\" gets no valid map to the sphere: {detail}. The surface may have very "
          "thin or folded parts near face {first}"),

    FAULT(NoSurface, "There is no {noun} to propagate a parameterisation to"),
    FAULT(RootOutOfRange, "The root is {noun} {first}, but the {nouns} are numbered 0 to {high}"),
    FAULT(ParentOutOfRange,
          "{Noun} {first} (counted from 0) is to get its map from {noun} {others}, which does not "
          "exist"),
    FAULT(SecondRoot,
          "{Noun} {first} (counted from 0) is marked as the root (-1), but so is {noun} {others}"),
    FAULT(NoRoot, "No {noun} is marked as the root"),
    FAULT(Circle,
          "{Noun} {first} (counted from 0) would get its map from itself, by way of {detail}: no "
          "map reaches these {nouns}"),

    FAULT(NoCorrespondence,
          "{Noun} \"{name}\" corresponds nowhere to {noun} \"{other}\", from which it is to get "
          "its parameterisation: all {count} vertices that are nearest to each other lie in "
          "triangles of opposite orientation"),
    FAULT(NothingFixed, SURFACE "no vertex has a position on the sphere to begin with"),
    FAULT(DifferentUnits,
          "{Noun} \"{name}\" is {value} times {detail} than {noun} \"{other}\", and one of the "
          "two would get its map from the other"),

    FAULT(AnchorFileNotRead, NO_ANCHORS_FROM ": {detail}"),
    FAULT(AnchorFileUnknown, NO_ANCHORS_FROM ", as its ending tells no format that is known"),
    FAULT(AnchorFileSyntax, NO_ANCHORS_FROM ", line {first}: {detail}"),
    FAULT(NoAnchors, NO_ANCHORS_FROM ": it holds none, or in no format that is known"),
    FAULT(AnchorFrame,
          NO_ANCHORS_FROM ": its coordinate system is \"{other}\", neither LPS nor RAS"),
    FAULT(AnchorNotNumbers,
          NO_ANCHORS_FROM ", {detail}: the place of \"{other}\" is not three numbers"),
    FAULT(AnchorsInOnePlace, NOT_EXACT ": \"{other}\" and \"{detail}\" lie in one place"),
    FAULT(AnchorsChangePlaces,
          NOT_EXACT ": on the sphere, \"{other}\" and \"{detail}\" would have to change places"),
    FAULT(AnchorsNotHeld, NOT_EXACT ": \"{other}\" stays {value} radians off"),

    FAULT(TooFewShapes, "A shape model needs at least two shapes; there is only \"{name}\""),
    FAULT(NoLandmarks, "Shape \"{name}\" has no landmarks"),
    FAULT(LandmarkCount,
          "Shapes \"{name}\" and \"{other}\" do not correspond: they have {count} and {others} "
          "landmarks"),
    FAULT(NonFiniteLandmark,
          "Shape \"{name}\": {count|landmark has|landmarks have} coordinates that are not finite; "
          "the first is landmark {first}"),
    FAULT(LandmarksInOnePlace, "Shape \"{name}\": all its {count} landmarks lie in one place"),
    FAULT(FewSharedAnchors,
          "Shape \"{name}\" cannot be aligned by anchors: it shares {count} with the others, and "
          "three are the fewest"),
    FAULT(AnchorsOnOneLine,
          "Shape \"{name}\" cannot be aligned by anchors: the {count} that it shares with the "
          "others lie on one line"),
    FAULT(NoFileEnding, NOT_WRITTEN "its name has no ending; choose one of {detail}"),
    FAULT(UnknownFileFormat,
          NOT_WRITTEN "\"{other}\" is no format that is known; choose one of {detail}"),
    FAULT(FileIsFolder, NOT_WRITTEN "it is a folder"),
    FAULT(NoFolder, NOT_WRITTEN "there is no folder \"{other}\""),
    FAULT(NotWritten, NOT_WRITTEN "{detail}"),
    FAULT(FileTooLarge, "The model is too large for a {detail} file (4 GB)"),

    FAULT(EmptyVolume, "The label volume has no voxels: its size is {detail}"),
    FAULT(LabelCount, "The label volume has {count} labels for {others} voxels"),
    FAULT(PlaceNotFinite,
          "The label volume's position in space is not finite: its affine matrix holds NaN or "
          "infinite numbers"),
    FAULT(MatrixNotAffine, "The label volume's matrix is not affine: its last row is {detail}"),
    FAULT(MatrixFlattens,
          "The label volume's affine matrix maps the voxels into a plane: the spacings are "
          "{detail} mm and a voxel's volume is {value} mm^3"),
    FAULT(OnlyBackground, "No voxel has {detail}; all voxels are 0"),
    FAULT(AbsentLabel, "No voxel has {detail}. The labels that occur are {other}"),
    FAULT(TooThin, "The label is so thin that no working voxel of {value} mm lies inside"),
    FAULT(WorkingVoxelsSmall,
          "Working voxels of {value} mm are too small here: there would be {detail}, the most are "
          "{high}"),
    FAULT(WorkingVoxelsLarge,
          "Working voxels are too large for this label, which lies in a box of {detail} mm"),

    FAULT(NotBetween, "The {name} must lie between {low} and {high}; it is {value}"),
    FAULT(TooSmall, "The {name} must be {low} or more; it is {value}"),
    FAULT(NotAbove, "The {name} must be above {low}; it is {value}"),
};

constexpr bool inOrder() {
  for (int i = 0; i < faultCount; ++i)
    if (static_cast<int>(entries[static_cast<size_t>(i)].fault) != i) return false;
  return true;
}
static_assert(inOrder(), "one entry per fault, in the order of the enumeration");

/// The number, with as many digits as it takes to see that it is outside its range.
std::string outside(const Finding& finding) {
  const std::string text = numeral(finding.value);
  std::istringstream stream(text);
  stream.imbue(std::locale::classic());
  double said = 0;
  stream >> said;
  const bool seen = said != finding.low && said != finding.high;
  return seen || said == finding.value ? text : numeral(finding.value, 9);
}

}  // namespace

std::string_view nameOf(Fault fault) { return entries[static_cast<size_t>(fault)].name; }

std::string_view sentenceOf(Fault fault) { return entries[static_cast<size_t>(fault)].sentence; }

std::string fill(std::string_view text, const Finding& finding, std::string_view noun) {
  return fill(text, [&](std::string_view gap) -> std::string {
    if (gap == "name") return finding.name;
    if (gap == "other") return finding.other;
    if (gap == "detail") return finding.detail;
    if (gap == "count") return std::to_string(finding.count);
    if (gap == "first") return std::to_string(finding.first);
    if (gap == "others") return std::to_string(finding.others);
    if (gap == "value") return outside(finding);
    if (gap == "low") return numeral(finding.low);
    if (gap == "high") return numeral(finding.high);
    std::string word(noun);
    if (gap == "Noun")
      word[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(word[0])));
    if (gap == "nouns") word += 's';
    return word;
  });
}

}  // namespace sphere_propagation
