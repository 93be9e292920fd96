// SPDX-License-Identifier: GPL-3.0-only
// "Import label volume as layers": from the scanner's labels to one closed surface per phase.

#include "filter_label_volume/import_filter.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <limits>
#include <utility>

#include "filter_label_volume/earlier_imports.h"
#include "filter_label_volume/file_series.h"
#include "filter_label_volume/messages.h"
#include "filter_label_volume/volume_file.h"
#include "host/help.h"
#include "host/remedies.h"
#include "vcg_ext/base/error.h"
#include "vcg_ext/base/stopwatch.h"
#include "vcg_ext/base/text.h"
#include "vcg_ext/mesh/closed_surface.h"
#include "vcg_ext/volume/volume_surface.h"

namespace sphere_propagation {
namespace {

constexpr host::Named<Coordinates> frames[]{{"RAS", Coordinates::Ras}, {"LPS", Coordinates::Lps}};

// Shares of the label's volume that deserve a look: what its surface lacks, since the label is
// thin; what lies between the two anyway; what went with smaller parts.
constexpr double maxLoss = 0.1;
constexpr double maxDifference = 0.05;
constexpr double maxDropped = 0.01;

std::string millilitres(double cubicMillimetres) {
  char buffer[32];
  std::snprintf(buffer, sizeof buffer, "%.1f ml", cubicMillimetres / 1000);
  return buffer;
}

/// "1", "1,2", "1 2" or "1; 2".
std::vector<std::int32_t> parseLabels(const std::string& text) {
  std::vector<std::int32_t> labels;
  for (size_t at = 0; at < text.size();) {
    if (std::string(" \t,;").find(text[at]) != std::string::npos) {
      ++at;
      continue;
    }
    const size_t end = std::min(text.find_first_of(" \t,;", at), text.size());
    const std::string word = text.substr(at, end - at);
    const size_t digits = word[0] == '-' ? 1 : 0;
    if (word.size() == digits || word.size() > 10 + digits ||
        word.find_first_not_of("0123456789", digits) != std::string::npos ||
        std::abs(std::stoll(word)) > std::numeric_limits<std::int32_t>::max())
      throw host::Refusal(volume_messages::labelsNoNumbers, text);
    const auto label = static_cast<std::int32_t>(std::stoll(word));
    if (label == 0) throw host::Refusal(volume_messages::labelsBackground);
    if (std::find(labels.begin(), labels.end(), label) == labels.end()) labels.push_back(label);
    at = end;
  }
  if (labels.empty()) throw host::Refusal(volume_messages::labelsEmpty);
  return labels;
}

/// How many digits the numbers below `count` have, at least two.
std::string numbered(int number, int count) {
  const size_t digits = std::max<size_t>(2, std::to_string(std::max(count - 1, 0)).size());
  std::string text = std::to_string(number);
  return text.insert(0, digits - std::min(digits, text.size()), '0');
}

/// What was done to a phase's labels, for the log.
std::string describe(const VolumeSurface& s) {
  std::string line = millilitres(s.labelVolume) + " of voxels, surface of " +
                     millilitres(s.volume) + ", " +
                     counted(s.vertices.rows(), "vertex", "vertices");
  const auto share = [&](long voxels) {
    return counted(voxels, "working voxel", "working voxels") + ", " +
           shortNumber(100.0 * static_cast<double>(voxels) / static_cast<double>(s.workingVoxels)) +
           " %";
  };
  if (s.interpolatedSlices > 0)
    line += "; " + counted(s.interpolatedSlices, "empty slice", "empty slices") + " interpolated";
  if (s.dropped.parts > 0)
    line += "; " + counted(s.dropped.parts, "smaller part", "smaller parts") + " dropped (" +
            share(s.dropped.voxels) + ")";
  if (s.filledVoxels > 0) line += "; cavities filled (" + share(s.filledVoxels) + ")";
  if (s.handles.by != RemovedHandles::By::Nothing)
    line += "; " + counted(s.handles.handles, "handle", "handles") +
            (s.handles.by == RemovedHandles::By::Cutting ? " cut (" : " filled (") +
            share(s.handles.changedVoxels) + " changed)";
  return line;
}

class ImportFilter : public host::Filter {
 public:
  host::FilterDescription describe() const override {
    return help_.describe(host::Menu::MeshCreation, host::Arity::None);
  }

  std::vector<host::Parameter> parameters(const host::Layers&) const override {
    const VolumeSurfaceParameters defaults;
    return {
        help_.parameter(
            "file_name",
            host::Parameter::File{
                "Label volumes (*.nii *.nii.gz *.hdr *.hdr.gz *.img *.img.gz *.nrrd *.nhdr *.mha "
                "*.mhd);;All files (*)"}),
        help_.parameter("labels", std::string("1")),
        help_.parameter("voxel_size", defaults.interpolation.voxelSize),
        help_.parameter("smoothing", defaults.smoothing),
        help_.parameter("coordinates", host::choiceOf(frames, Coordinates::Ras)),
        help_.parameter("fill_holes", defaults.fillHoles),
        help_.parameter("keep_largest_component", defaults.keepLargestComponent),
        help_.parameter("cut_handles", defaults.cutHandles),
        help_.parameter("file_series", false),
        help_.parameter("skip_incomplete_phases", false),
        help_.parameter("longest_gap", defaults.interpolation.longestGap).asAdvanced()};
  }

  host::Outputs run(host::Task& task) const override {
    VolumeSurfaceParameters parameters;
    parameters.interpolation.labels = parseLabels(task.values.text("labels"));
    parameters.interpolation.voxelSize = task.values.real("voxel_size");
    parameters.interpolation.longestGap = task.values.integer("longest_gap");
    parameters.smoothing = task.values.real("smoothing");
    parameters.fillHoles = task.values.flag("fill_holes");
    parameters.keepLargestComponent = task.values.flag("keep_largest_component");
    parameters.cutHandles = task.values.flag("cut_handles");
    const std::string fileName = task.values.file("file_name");
    if (fileName.empty()) throw host::Refusal(volume_messages::noFileName);
    const Coordinates coordinates = task.values.choice("coordinates", frames);
    const bool skip = task.values.flag("skip_incomplete_phases");
    const std::vector<std::string> files =
        task.values.flag("file_series") ? fileSeries(fileName) : std::vector<std::string>{fileName};
    const auto fileCount = static_cast<int>(files.size());
    if (task.values.flag("file_series"))
      task.say(volume_messages::filesInSeries, fileCount, files.front(), files.back());

    std::string labelText = " label";
    for (const std::int32_t label : parameters.interpolation.labels)
      labelText += (labelText.back() == 'l' ? " " : "+") + std::to_string(label);

    std::vector<Figures> figures;
    EarlierImports earlier(task.layers, files, labelText);
    if (!earlier.suffix().empty())
      task.say(volume_messages::otherFileOfThisName,
               stemOf(files.front()) + earlier.suffix() + labelText);
    long skipped = 0;
    for (int f = 0; f < fileCount; ++f) {
      const VolumeFile file(files[static_cast<size_t>(f)], coordinates);
      const std::string stem = stemOf(files[static_cast<size_t>(f)]) + earlier.suffix();
      if (fileCount > 1 && file.phases() > 1)
        throw host::Refusal(volume_messages::phasesInSeries, files[static_cast<size_t>(f)],
                            file.phases());
      const int phases = fileCount * file.phases();
      for (int p = 0; p < file.phases(); ++p) {
        const Stopwatch stopwatch;
        const int phase = fileCount > 1 ? f : p;
        // A series' files tell their phases by their names.
        const std::string name =
            stem + labelText + (file.phases() > 1 ? " phase " + numbered(p, file.phases()) : "");
        const Progress progress =
            part(task.progress, static_cast<double>(phase) / phases, (phase + 1.0) / phases);
        try {
          VolumeSurface surface = volumeSurface(file.phase(p), parameters, progress);
          task.log(name + ": " + sphere_propagation::describe(surface));
          warn(task, name, surface);
          figures.emplace_back(surface, phase, stopwatch.seconds());
          addLayer(task, earlier, static_cast<size_t>(f), name, parameters, std::move(surface));
        } catch (const AbsentLabelError& error) {
          if (!skip || phases == 1) {
            const std::string what =
                place(files[static_cast<size_t>(f)], p, file.phases()) + host::sentence(error);
            throw AbsentLabelError(phases > 1 ? host::said(volume_messages::canBeSkipped, what)
                                              : what);
          }
          task.tell(remark(name, volume_messages::phaseSkipped, host::sentence(error)));
          ++skipped;
        } catch (const VolumeError& error) {
          throw VolumeError(place(files[static_cast<size_t>(f)], p, file.phases()) +
                            host::sentence(error));
        }
      }
      for (host::Remark of : file.remarks()) {
        of.layer = stem;
        task.tell(of);
      }
    }
    if (figures.empty())
      throw host::Refusal(volume_messages::allSkipped, fileName, task.values.text("labels"));
    if (skipped > 0) task.say(volume_messages::phasesSkipped, skipped);
    if (earlier.replacedUnknown() > 0)
      task.say(volume_messages::unknownReplaced, earlier.replacedUnknown());
    removeLeftOver(task, earlier);
    task.changes.makeFirstNewLayerCurrent();
    return outputsOf(figures);
  }

 private:
  /// What is returned about a layer.
  struct Figures {
    Figures(const VolumeSurface& s, int number, double time)
        : values{static_cast<double>(number),
                 s.labelVolume,
                 s.volume,
                 static_cast<double>(s.vertices.rows()),
                 static_cast<double>(s.interpolatedSlices),
                 static_cast<double>(s.dropped.voxels) / static_cast<double>(s.workingVoxels),
                 static_cast<double>(s.filledVoxels),
                 static_cast<double>(s.handles.handles),
                 static_cast<double>(s.handles.changedVoxels),
                 lostShare(s) > maxLoss ? 1.0 : 0.0,
                 time} {}
    std::array<double, 11> values;
  };

  static double droppedShare(const VolumeSurface& surface) {
    return static_cast<double>(surface.dropped.voxels) / static_cast<double>(surface.workingVoxels);
  }

  /// What the user should know about a phase's surface; usually nothing.
  static void warn(const host::Task& task, const std::string& name, const VolumeSurface& surface) {
    const double loss = lostShare(surface);
    if (loss > maxLoss)
      task.sayOf(name, volume_messages::thinLabel, std::lround(100 * loss));
    else if (std::abs(loss) > maxDifference && surface.interpolatedSlices == 0)
      task.sayOf(name, volume_messages::volumesDiffer, 100 * std::abs(loss));
    if (droppedShare(surface) > maxDropped)
      task.sayOf(name, volume_messages::partsDropped, 100 * droppedShare(surface));
    if (surface.interpolatedSlices > 0)
      task.sayOf(name, volume_messages::slicesInterpolated, surface.interpolatedSlices);
  }

  /// How much of what was kept of the label its surface does not enclose.
  static double lostShare(const VolumeSurface& surface) {
    const double kept = 1 - droppedShare(surface);
    return 1 - surface.volume / (surface.labelVolume * kept);
  }

  static host::Outputs outputsOf(const std::vector<Figures>& figures) {
    static const std::array<const char*, 11> keys{
        "phase",         "label_volume",  "volume",  "vertices",       "interpolated_slices",
        "dropped_share", "filled_voxels", "handles", "changed_voxels", "thin",
        "seconds"};
    host::Outputs outputs{{"layers", static_cast<int>(figures.size())}};
    for (size_t key = 0; key < keys.size(); ++key) {
      Eigen::VectorXd values(static_cast<Eigen::Index>(figures.size()));
      for (size_t i = 0; i < figures.size(); ++i)
        values[static_cast<Eigen::Index>(i)] = figures[i].values[key];
      outputs[keys[key]] = values;
    }
    return outputs;
  }

  static std::string place(const std::string& file, int phase, int phases) {
    return "\"" + file + "\"" + (phases > 1 ? ", phase " + std::to_string(phase) : "") + ": ";
  }

  static void removeLeftOver(host::Task& task, const EarlierImports& earlier) {
    const std::vector<host::Layer> layers = earlier.leftOver();
    if (layers.empty()) return;
    for (const host::Layer& layer : layers) task.changes.removeLayer(layer);
    task.say(volume_messages::leftOverRemoved, layers.size(), layers.front().label(),
             layers.back().label());
  }

  static void addLayer(host::Task& task, EarlierImports& earlier, size_t file,
                       const std::string& name, const VolumeSurfaceParameters& parameters,
                       VolumeSurface surface) {
    if (parameters.cutHandles && parameters.keepLargestComponent) {
      const ClosedSurface sphere(surface.vertices, surface.faces,
                                 name);  // what was promised is checked
    }
    host::NewLayer layer;
    layer.label = name;
    layer.vertices = std::move(surface.vertices);
    layer.faces = std::move(surface.faces);
    earlier.place(layer, file);
    task.changes.addLayer(layer);
  }

  const host::Help help_{"create_layers_from_label_volume",
                         {{"max_smoothing", shortNumber(VolumeSurfaceParameters::maxSmoothing)}}};
};

}  // namespace

std::unique_ptr<host::Filter> makeImportFilter() { return std::make_unique<ImportFilter>(); }

}  // namespace sphere_propagation
