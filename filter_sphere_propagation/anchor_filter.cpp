// SPDX-License-Identifier: GPL-3.0-only
// "Load anchors": the user's own landmarks, from files of other programs onto layers.

#include <cmath>
#include <utility>
#include <vector>

#include "filter_sphere_propagation/anchor_sources.h"
#include "filter_sphere_propagation/filters.h"
#include "filter_sphere_propagation/messages.h"
#include "filter_sphere_propagation/reporting.h"
#include "host/help.h"
#include "vcg_ext/mesh/icosphere.h"

namespace sphere_propagation {
namespace {

constexpr host::Named<AnchorFrame> anchorFrames[]{{"World", AnchorFrame::World},
                                                  {"Mesh", AnchorFrame::Mesh}};

constexpr int markerFrequency = 3;
constexpr double markerPerDiagonal = 0.012;  // radius of a marker

/// A colour that belongs to the name, the same on all layers and in all projects.
Eigen::Matrix<unsigned char, 1, 3> colorOf(const std::string& name) {
  unsigned hash = 2166136261U;  // FNV-1a
  for (const char c : name) hash = (hash ^ static_cast<unsigned char>(c)) * 16777619U;
  const double hue = 6.0 * ((hash >> 8) % 4096) / 4096;
  Eigen::Matrix<unsigned char, 1, 3> color;
  for (int k = 0; k < 3; ++k) {
    const double away = std::fabs(std::remainder(hue - 2 * k, 6));
    color[k] = static_cast<unsigned char>(255 * std::min(1.0, std::max(0.0, 2 - away)));
  }
  return color;
}

/// A small sphere at each anchor.
host::NewLayer markersOf(const host::Layer& layer, const AnchorSet& anchors) {
  const Points vertices = layer.content().vertices;
  const Vector3 low = vertices.colwise().minCoeff(), high = vertices.colwise().maxCoeff();
  const double radius = markerPerDiagonal * (high - low).norm();
  const Icosphere sphere = icosphere(markerFrequency);
  const Eigen::Index points = sphere.vertices.rows(), faces = sphere.faces.rows(),
                     count = static_cast<Eigen::Index>(anchors.size());
  host::NewLayer markers;
  markers.label = layer.derivedLabel("anchors");
  markers.kind = host::LayerKind::Anchors;
  if (layer.isShownAside()) markers.aside = layer.shownBox().center() - 0.5 * (low + high);
  markers.vertices.resize(points * count, 3);
  markers.faces.resize(faces * count, 3);
  markers.colors = Colors(points * count, 3);
  Eigen::Index i = 0;
  for (const auto& [name, place] : anchors) {
    markers.vertices.middleRows(i * points, points) =
        (radius * sphere.vertices).rowwise() + place.transpose();
    markers.faces.middleRows(i * faces, faces) =
        sphere.faces.array() + static_cast<int>(i * points);
    markers.colors->middleRows(i * points, points).rowwise() = colorOf(name);
    ++i;
  }
  return markers;
}

class AnchorFilter : public host::Filter {
 public:
  host::FilterDescription describe() const override {
    return help_.describe(host::Menu::Layer, host::Arity::VisibleLayers);
  }

  std::vector<host::Parameter> parameters(const host::Layers&) const override {
    return {
        help_.parameter("file_name",
                        host::Parameter::File{
                            "Anchors (*.pp *.mrk.json *.json *.fcsv *.csv *.tsv *.txt *.pts *.xyz "
                            "*.particles);;All files (*)"}),
        help_.parameter("coordinates", host::choiceOf(anchorFrames, AnchorFrame::World)),
        help_.parameter("show_anchors", false)};
  }

  host::Outputs run(host::Task& task) const override {
    const std::string given = task.values.file("file_name");
    const AnchorFrame frame = task.values.choice("coordinates", anchorFrames);
    const bool fromFolder = !given.empty() && isFolder(given);
    const std::vector<host::Layer> layers = given.empty() || fromFolder
                                                ? task.layers.visibleSurfaces()
                                                : std::vector<host::Layer>{task.layers.current()};
    Eigen::VectorXd counts = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(layers.size()));
    std::vector<std::string> without;
    bool any = false, inFolder = false;
    AnchorSources sources(task, frame);
    for (size_t i = 0; i < layers.size(); ++i) {
      const host::Layer& layer = layers[i];
      const std::string file = fromFolder ? sources.fileIn(given, layer) : given;
      inFolder = inFolder || !file.empty();
      AnchorSet anchors;
      if (!file.empty())
        anchors = sources.from(file, layer);
      else if (!fromFolder)
        anchors = sources.beside(layer);
      if (anchors.empty()) {
        without.push_back(layer.label());
        continue;
      }
      any = true;
      warnOfFarAnchors(task, layer, anchors);
      counts[static_cast<Eigen::Index>(i)] = static_cast<double>(anchors.size());
      task.changes.setAnchors(layer, anchors);
      if (task.values.flag("show_anchors")) task.changes.addLayer(markersOf(layer, anchors));
    }
    sources.sayWhichAsWritten();
    if (fromFolder && !inFolder) throw host::Refusal(messages::noAnchorsInFolder, given);
    if (!any && given.empty()) task.say(messages::noAnchorsBeside, layers.size());
    if ((any || !given.empty()) && !without.empty())
      task.say(messages::layersWithoutAnchors, namesIn(without));
    if (any) task.say(messages::anchorsLoaded, layers.size() - without.size());
    return {{"anchors", counts}};
  }

 private:
  const host::Help help_{"load_anchors_to_layers"};
};

}  // namespace

std::unique_ptr<host::Filter> makeAnchorFilter() { return std::make_unique<AnchorFilter>(); }

}  // namespace sphere_propagation
