// SPDX-License-Identifier: GPL-3.0-only
#include "filter_sphere_propagation/anchor_sources.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iterator>
#include <optional>
#include <set>
#include <utility>

#include "filter_sphere_propagation/messages.h"
#include "filter_sphere_propagation/reporting.h"
#include "host/remedies.h"
#include "vcg_ext/anchors/anchor_file.h"
#include "vcg_ext/base/error.h"
#include "vcg_ext/mesh/surface_geometry.h"
#include "vcg_ext/mesh/surface_locator.h"

namespace sphere_propagation {
namespace {

/// How far anchors lie off a layer, in its mean edge lengths; whatever else is wrong with it.
constexpr double onePlace = 1e-3;  // edges

class Distances {
 public:
  explicit Distances(const host::Layer& layer) {
    const MeshContent content = layer.content();
    if (content.faces.rows() == 0 || !content.vertices.allFinite()) return;
    surface_.emplace(content.vertices, content.faces);
    edge_ = meanEdgeLength(content.vertices, content.faces);
  }
  double operator()(const Vector3& point) const {
    return surface_ && edge_ > 0 ? surface_->closest(point).distance / edge_ : 0;
  }
  double inEdges(const Vector3& way) const { return edge_ > 0 ? way.norm() / edge_ : HUGE_VAL; }
  int farOnes(const AnchorSet& anchors) const {
    return static_cast<int>(std::count_if(anchors.begin(), anchors.end(), [&](const auto& anchor) {
      return (*this)(anchor.second) > maxAnchorEdges;
    }));
  }

 private:
  std::optional<SurfaceLocator> surface_;
  double edge_ = 0;
};

AnchorSet inFrame(const AnchorSet& anchors, const host::Layer& layer, AnchorFrame frame) {
  return frame == AnchorFrame::World ? anchors : transformed(anchors, layer.matrix());
}

AnchorSet turnedRound(const AnchorSet& anchors) {
  return transformed(anchors, Eigen::Vector4d(-1, -1, 1, 1).asDiagonal().toDenseMatrix());
}

}  // namespace

/// isAsked: whether the file was given; else what has little to do with the layer is left out.
AnchorSet AnchorSources::read(const std::string& file, const host::Layer& layer, bool isAsked) {
  const AnchorList list = readAnchors(file);
  const Distances distances(layer);
  AnchorSet anchors = inFrame(list.anchors, layer, frame_);
  int far = distances.farOnes(anchors);
  bool asWritten = false;
  if (list.fromLps && far > 0) {
    AnchorSet other = inFrame(turnedRound(list.anchors), layer, frame_);
    if (const int farOther = distances.farOnes(other); farOther < far) {
      anchors = std::move(other);
      far = farOther;
      asWritten = true;
    }
  }
  if (!isAsked && 2 * far > static_cast<int>(anchors.size())) {
    task_.sayOf(layer, messages::notItsAnchors, file, far, anchors.size());
    return {};
  }
  if (asWritten) asWritten_.push_back(layer.label());
  task_.say(messages::anchorsRead, layer.label(), anchors.size(), file);
  if (list.anchors.empty() && list.ambiguous.empty())
    task_.sayOf(layer, messages::noAnchorHasPlace, file, namesIn(list.undefined));
  else if (!list.undefined.empty())
    task_.say(messages::anchorsWithoutPlace, layer.label(), namesIn(list.undefined));
  if (!list.ambiguous.empty())
    task_.sayOf(layer, messages::anchorsTwice, namesIn(list.ambiguous), file);
  return anchors;
}

AnchorSet AnchorSources::beside(const host::Layer& layer) {
  const std::vector<std::string> files = anchorFilesBeside(layer.fileName());
  for (auto file = files.begin(); file != files.end(); ++file) {
    try {
      AnchorSet anchors = read(*file, layer, false);
      if (!anchors.empty())
        for (auto other = std::next(file); other != files.end(); ++other)
          compare(layer, *file, anchors, *other);
      return anchors;
    } catch (const AnchorError& error) {
      task_.sayOf(layer, messages::anchorsNotRead, host::sentence(error));
    }
  }
  return {};
}

/// Says where another file beside the layer's own puts the same anchors elsewhere.
void AnchorSources::compare(const host::Layer& layer, const std::string& taken,
                            const AnchorSet& anchors, const std::string& other) const {
  AnchorList list;
  try {
    list = readAnchors(other);
  } catch (const AnchorError&) {
    return;  // of somebody else
  }
  const Distances distances(layer);
  const auto elsewhere = [&](const AnchorSet& its) {
    std::vector<std::string> names;
    for (const auto& [name, place] : its)
      if (const auto same = anchors.find(name);
          same != anchors.end() && distances.inEdges(place - same->second) > onePlace)
        names.push_back(name);
    return names;
  };
  std::vector<std::string> names = elsewhere(inFrame(list.anchors, layer, frame_));
  if (list.fromLps && !names.empty())
    if (std::vector<std::string> asWritten =
            elsewhere(inFrame(turnedRound(list.anchors), layer, frame_));
        asWritten.size() < names.size())
      names = std::move(asWritten);
  if (!names.empty())
    task_.sayOf(layer, messages::anchorFilesContradict, namesIn(names), taken, other);
}

void AnchorSources::sayWhichAsWritten() const {
  if (!asWritten_.empty())
    task_.sayNaming(asWritten_, messages::anchorsInLps, namesIn(asWritten_), asWritten_.size());
}

std::string AnchorSources::fileIn(const std::string& folder, const host::Layer& layer) const {
  std::vector<std::string> files;
  if (const std::string own = layer.fileName(); !own.empty())
    files = anchorFilesIn(folder, std::filesystem::u8path(own).filename().u8string());
  if (files.empty()) files = anchorFilesIn(folder, layer.label());
  if (files.empty()) return "";
  if (files.size() > 1) task_.sayOf(layer, messages::severalAnchorFiles, namesIn(files), files[0]);
  return files[0];
}

bool isFolder(const std::string& path) {
  std::error_code ignored;
  return std::filesystem::is_directory(std::filesystem::u8path(path), ignored);
}

void warnOfFarAnchors(const host::Task& task, const host::Layer& layer, const AnchorSet& anchors) {
  const Distances distances(layer);
  std::set<std::string> together;
  for (auto one = anchors.begin(); one != anchors.end(); ++one)
    for (auto other = std::next(one); other != anchors.end(); ++other)
      if (distances.inEdges(one->second - other->second) < onePlace)
        together.insert({one->first, other->first});
  if (!together.empty())
    task.sayOf(layer, messages::anchorsInOnePlace, namesIn({together.begin(), together.end()}));
  std::vector<std::string> far;
  std::vector<double> edges;
  for (const auto& [name, point] : anchors) {
    const double off = distances(point);
    if (off <= maxAnchorEdges) continue;
    far.push_back(name);
    edges.push_back(off);
  }
  if (far.size() == 1) task.sayOf(layer, messages::anchorFarOff, far[0], edges[0]);
  if (far.size() < 2) return;
  const auto [least, most] = std::minmax_element(edges.begin(), edges.end());
  task.sayOf(layer, messages::anchorsFarOff, far.size(), namesIn(far), *least, *most);
}

}  // namespace sphere_propagation
