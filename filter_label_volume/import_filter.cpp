// SPDX-License-Identifier: GPL-3.0-only
// "Import label volume as layers": from the scanner's labels to one closed surface per phase.

#include "filter_label_volume/import_filter.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <limits>
#include <map>
#include <optional>
#include <set>
#include <utility>

#include "filter_label_volume/earlier_imports.h"
#include "filter_label_volume/file_series.h"
#include "filter_label_volume/messages.h"
#include "filter_label_volume/shared_remarks.h"
#include "filter_label_volume/volume_file.h"
#include "host/help.h"
#include "host/remedies.h"
#include "vcg_ext/base/error.h"
#include "vcg_ext/base/stopwatch.h"
#include "vcg_ext/base/text.h"
#include "vcg_ext/mesh/closed_surface.h"
#include "vcg_ext/volume/volume_sequence.h"

namespace sphere_propagation {
namespace {

constexpr host::Named<Coordinates> frames[]{{"RAS", Coordinates::Ras}, {"LPS", Coordinates::Lps}};

constexpr host::Named<HandleRepair> handleRepairs[]{
    {"Whichever changes less", HandleRepair::LessChange},
    {"Cut", HandleRepair::Cut},
    {"Fill", HandleRepair::Fill}};

/// Places of a phase that are named one by one.
constexpr size_t maxPlaces = 3;

// Shares of the label's volume that deserve a look: what its surface lacks, since the label is
// thin; what lies between the two anyway; what went with smaller parts.
constexpr double maxLoss = 0.1;
constexpr double maxDifference = 0.05;
constexpr double maxDropped = 0.01;
constexpr double shortest = 1, longest = 2000;  // mm; organs are between

/// Slices that lie so far off the line of those beside them are named, mm: where several phases say
/// so, and where one does, which bends may mislead.
constexpr double minUneven = 3, minUnevenOfOne = 4;

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

std::string workingVoxels(long voxels) {
  return counted(voxels, "working voxel", "working voxels");
}

std::string tenths(double number) {
  char buffer[32];
  std::snprintf(buffer, sizeof buffer, "%.1f", number + 0.0);
  return buffer;
}

/// "(12.3, -40.0, 7.5) mm".
std::string pointText(const Vector3& x) {
  return "(" + tenths(x[0]) + ", " + tenths(x[1]) + ", " + tenths(x[2]) + ") mm";
}

/// "(12.3, -40.0, 7.5) mm (18 voxels), ... and 2 smaller places".
std::string placesText(const std::vector<HandlePlace>& places) {
  std::string text;
  const size_t named = std::min(places.size(), maxPlaces);
  for (size_t i = 0; i < named; ++i)
    text += (i > 0 ? ", " : "") + pointText(places[i].centre) +
            (places.size() > 1 ? " (" + std::to_string(places[i].voxels) + ")" : "");
  if (places.size() > named)
    text += " and " +
            counted(static_cast<long>(places.size() - named), "smaller place", "smaller places");
  return text;
}

/// What was done to a phase's labels, for the log.
std::string describe(const VolumeSurface& s) {
  std::string line = millilitres(s.labelVolume) + " of voxels, surface of " +
                     millilitres(s.volume) + ", " +
                     counted(s.vertices.rows(), "vertex", "vertices");
  const auto share = [&](long voxels) {
    return workingVoxels(voxels) + ", " +
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
    return help_.describe(host::Menu::MeshCreation | host::Menu::Layer, host::Arity::None);
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
        help_.parameter("handle_repair", host::choiceOf(handleRepairs, defaults.handleRepair)),
        help_.parameter("align_slices", defaults.interpolation.alignSlices),
        help_.parameter("file_series", false),
        help_.parameter("skip_incomplete_phases", false),
        help_.parameter("longest_gap", defaults.interpolation.longestGap).asAdvanced()};
  }

  host::Outputs run(host::Task& task) const override {
    VolumeSurfaceParameters parameters;
    parameters.interpolation.labels = parseLabels(task.values.text("labels"));
    parameters.interpolation.voxelSize = task.values.real("voxel_size");
    parameters.interpolation.longestGap = task.values.integer("longest_gap");
    parameters.interpolation.alignSlices = task.values.flag("align_slices");
    parameters.smoothing = task.values.real("smoothing");
    parameters.fillHoles = task.values.flag("fill_holes");
    parameters.keepLargestComponent = task.values.flag("keep_largest_component");
    parameters.cutHandles = task.values.flag("cut_handles");
    parameters.handleRepair = task.values.choice("handle_repair", handleRepairs);
    const std::string fileName = task.values.file("file_name");
    if (fileName.empty()) throw host::Refusal(volume_messages::noFileName);
    const Coordinates coordinates = task.values.choice("coordinates", frames);
    const bool skip = task.values.flag("skip_incomplete_phases");
    const bool isSeries = task.values.flag("file_series");
    std::vector<std::string> files, stems;
    if (isSeries)
      for (const std::string& file : files = fileSeries(fileName)) stems.push_back(stemOf(file));
    else
      for (const NamedFile& file : namedFiles(fileName)) {
        files.push_back(file.path);
        stems.push_back(file.name);
      }
    if (files.empty()) throw host::Refusal(volume_messages::noFileName);
    const auto fileCount = static_cast<int>(files.size());
    if (isSeries) task.say(volume_messages::filesInSeries, fileCount, files.front(), files.back());

    std::string labelText = " label";
    for (const std::int32_t label : parameters.interpolation.labels)
      labelText += (labelText.back() == 'l' ? " " : "+") + std::to_string(label);

    VolumeSequence sequence(parameters);
    std::vector<Entry> entries;
    EarlierImports earlier(task.layers, files, labelText);
    if (!earlier.suffix().empty())
      task.say(volume_messages::otherFileOfThisName,
               stemOf(files.front()) + earlier.suffix() + labelText);
    long skipped = 0;
    int phasesBefore = 0;
    SharedRemarks ofReading;
    for (int f = 0; f < fileCount; ++f) {
      const VolumeFile file(files[static_cast<size_t>(f)], coordinates);
      const std::string stem = stems[static_cast<size_t>(f)] + earlier.suffix();
      if (isSeries && fileCount > 1 && file.phases() > 1)
        throw host::Refusal(volume_messages::phasesInSeries, files[static_cast<size_t>(f)],
                            file.phases());
      const int phases = fileCount * file.phases();
      for (int p = 0; p < file.phases(); ++p) {
        const Stopwatch stopwatch;
        const int phase = phasesBefore + p;
        // A series' files tell their phases by their names.
        const std::string name =
            stem + labelText + (file.phases() > 1 ? " phase " + numbered(p, file.phases()) : "");
        const Progress progress =
            part(task.progress, handlesFrom * (f * file.phases() + p) / phases,
                 handlesFrom * (f * file.phases() + p + 1.0) / phases);
        try {
          sequence.add(file.phase(p), progress);
          entries.push_back(
              {name, static_cast<size_t>(f), p, file.phases(), phase, stopwatch.seconds()});
        } catch (const AbsentLabelError& error) {
          if (!skip || phases == 1)
            refuseAbsent(error, files, coordinates, parameters, static_cast<size_t>(f), p,
                         !entries.empty());
          ofReading.add(name, volume_messages::phaseSkipped, host::sentence(error));
          ++skipped;
        } catch (const VolumeError& error) {
          throw VolumeError(place(files[static_cast<size_t>(f)], p, file.phases()) +
                            host::sentence(error));
        }
      }
      phasesBefore += file.phases();
      std::vector<std::string> layersOfFile;
      for (const Entry& entry : entries)
        if (entry.file == static_cast<size_t>(f)) layersOfFile.push_back(entry.name);
      for (const host::Remark& of : file.remarks()) ofReading.add(stem, of, layersOfFile);
    }
    ofReading.tell(task);
    if (entries.empty())
      throw host::Refusal(volume_messages::allSkipped, fileName, task.values.text("labels"));
    const Trial trial(files, coordinates, parameters, entries);
    std::vector<Figures> figures;
    bool handlesAlone = false;
    std::vector<VolumeSurface> slices;  // what is to be said of them, without the surfaces
    SharedRemarks remarks;
    std::map<int, std::vector<size_t>> apart, sequences;  // by slice, by number: the entries
    std::vector<Thin> thin;
    for (size_t i = 0; i < entries.size(); ++i) {
      const Entry& entry = entries[i];
      const Stopwatch stopwatch;
      VolumeSurface surface = [&] {
        try {
          return sequence.surface(i, part(task.progress, handlesFrom, 1));
        } catch (const VolumeError& error) {
          throw VolumeError(place(files[entry.file], entry.phaseInFile, entry.phasesOfFile) +
                            host::sentence(error));
        }
      }();
      task.log(entry.name + ": " + sphere_propagation::describe(surface));
      warn(remarks, entry.name, surface);
      for (const int slice : surface.apartSlices) apart[slice].push_back(i);
      sequences[surface.sliceSequence].push_back(i);
      if (isThin(surface)) thin.push_back({i, totalLoss(surface), surface.voxelSize});
      slices.push_back(slicesOf(surface));
      handlesAlone |= warnOfHandles(remarks, entry.name, surface) && surface.handlesAlone;
      figures.emplace_back(surface, entry.phase, entry.seconds + surface.seconds);
      addLayer(task, earlier, entry.file, entry.name, parameters, std::move(surface));
    }
    bool triedToAlign = false;
    SliceShifts shifts;
    for (size_t i = 0; i < entries.size(); ++i)
      warnOfSlices(remarks, shifts, entries[i].name, slices[i],
                   parameters.interpolation.alignSlices,
                   sequences[slices[i].sliceSequence].size() > 1 ? minUneven : minUnevenOfOne, [&] {
                     if (std::exchange(triedToAlign, true)) return 0L;
                     return trial.keptByAligning(i, slices[i]);
                   });
    shifts.tell(remarks);
    warnOfThinLabels(remarks, thin, entries, trial);
    remarks.tell(task);
    if (parameters.interpolation.alignSlices)
      warnOfUnlikePhases(task, apart, sequences, entries, isSeries);
    if (handlesAlone) task.say(volume_messages::handlesElsewhere);
    if (skipped > 0) task.say(volume_messages::phasesSkipped, skipped);
    if (earlier.replacedUnknown() > 0)
      task.say(volume_messages::unknownReplaced, earlier.replacedUnknown());
    removeLeftOver(task, earlier);
    task.changes.makeFirstNewLayerCurrent();
    task.say(volume_messages::surfacesImported, figures.size(),
             skipped > 0 ? host::said(volume_messages::incompleteLeftOut, skipped) : std::string());
    return outputsOf(figures);
  }

 private:
  static constexpr double handlesFrom = 0.5;  // where in the progress they are removed

  /// A phase that was read.
  struct Entry {
    std::string name;
    size_t file = 0;
    int phaseInFile = 0, phasesOfFile = 0;
    int phase = 0;
    double seconds = 0;
  };

  /// Skipping phases is advised only where some have the label. before: whether some before had it.
  [[noreturn]] static void refuseAbsent(const AbsentLabelError& error,
                                        const std::vector<std::string>& files,
                                        Coordinates coordinates,
                                        const VolumeSurfaceParameters& parameters, size_t file,
                                        int phase, bool before) {
    const auto has = [&](const VolumeFile& volume, int p) {
      const std::vector<std::int32_t>& wanted = parameters.interpolation.labels;
      const LabelGrid grid = volume.phase(p);
      return std::any_of(grid.values.begin(), grid.values.end(), [&](std::int32_t label) {
        return std::find(wanted.begin(), wanted.end(), label) != wanted.end();
      });
    };
    bool some = before;
    int phases = 1;
    for (size_t f = file; f < files.size() && !some; ++f) {
      const VolumeFile volume(files[f], coordinates);
      if (f == file) phases = volume.phases();
      for (int p = f == file ? phase + 1 : 0; p < volume.phases() && !some; ++p)
        some = has(volume, p);
    }
    if (before) phases = VolumeFile(files[file], coordinates).phases();
    const std::string what = host::sentence(error);
    if (some)
      throw AbsentLabelError(
          host::said(volume_messages::canBeSkipped, place(files[file], phase, phases) + what));
    throw AbsentLabelError(place(files[file], 0, 1) + what);
  }

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
                 isThin(s) ? 1.0 : 0.0,
                 time} {}
    std::array<double, 11> values;
  };

  static double droppedShare(const VolumeSurface& surface) {
    return static_cast<double>(surface.dropped.voxels) / static_cast<double>(surface.workingVoxels);
  }

  /// What the user should know about a phase's surface, but for what warnOfThinLabels says; usually
  /// nothing.
  static void warn(SharedRemarks& remarks, const std::string& name, const VolumeSurface& surface) {
    const double loss = lostShare(surface);
    const double total = totalLoss(surface);
    if (!isThin(surface) && std::min(std::abs(loss), std::abs(total)) > maxDifference &&
        surface.interpolatedSlices == 0)
      remarks.add(name, volume_messages::volumesDiffer, 100 * std::abs(total),
                  total > 0 ? "less" : "more");
    if (droppedShare(surface) > maxDropped)
      remarks.add(name, volume_messages::partsDropped, 100 * droppedShare(surface));
    if (surface.interpolatedSlices > 0)
      remarks.add(name, volume_messages::slicesInterpolated, surface.interpolatedSlices);
    const double length =
        (surface.vertices.colwise().maxCoeff() - surface.vertices.colwise().minCoeff()).maxCoeff();
    if (length < shortest || length > longest)
      remarks.add(name, volume_messages::oddExtent, length, surface.voxelSize);
    for (const BorderContact& border : surface.borders)
      remarks.add(name, volume_messages::cutByBorder,
                  std::string(1, "ijk"[border.axis]) + " = " + std::to_string(border.index),
                  std::lround(100 * border.share));
  }

  /// How much of what was kept of the label its surface does not enclose.
  static double lostShare(const VolumeSurface& surface) {
    const double kept = 1 - droppedShare(surface);
    return 1 - surface.volume / (surface.labelVolume * kept);
  }

  /// How much of the label its surface does not enclose, what was dropped included.
  static double totalLoss(const VolumeSurface& surface) {
    return 1 - surface.volume / surface.labelVolume;
  }

  /// Whether its surface lacks much since the label is thin. Between slices that do not meet there
  /// is little to interpolate: where slices are lost or out of line, or parts were dropped, which
  /// is named, only what smoothing takes of the working voxels counts.
  static bool isThin(const VolumeSurface& surface) {
    if (!(lostShare(surface) > maxLoss)) return false;
    const bool torn =
        !surface.lostSlices.empty() || droppedShare(surface) > maxDropped ||
        std::any_of(surface.unevenSlices.begin(), surface.unevenSlices.end(),
                    [](const UnevenSlice& slice) { return slice.shift >= minUneven; });
    const double kept = static_cast<double>(surface.workingVoxels - surface.dropped.voxels) *
                        std::pow(surface.voxelSize, 3);
    return !torn || surface.volume < (1 - maxLoss) * kept;
  }

  /// What other parameters would make of a phase: advice is tried before it is given.
  class Trial {
   public:
    Trial(const std::vector<std::string>& files, Coordinates coordinates,
          const VolumeSurfaceParameters& parameters, const std::vector<Entry>& entries)
        : files_(files), coordinates_(coordinates), parameters_(parameters), entries_(entries) {}

    const VolumeSurfaceParameters& parameters() const { return parameters_; }

    /// How many of a phase's lost slices align_slices would keep.
    long keptByAligning(size_t entry, const VolumeSurface& surface) const {
      VolumeSurfaceParameters parameters = parameters_;
      parameters.interpolation.alignSlices = true;
      const std::vector<int> left = workingVolume(cutOut(labels(entry), parameters.interpolation),
                                                  surface.unevenSlices, parameters)
                                        .surface.lostSlices;
      const std::vector<int>& lost = surface.lostSlices;
      return std::count_if(lost.begin(), lost.end(), [&](int slice) {
        return std::find(left.begin(), left.end(), slice) == left.end();
      });
    }

    /// The loss of a phase with other parameters; nothing where these are none.
    std::optional<double> loss(size_t entry, const VolumeSurfaceParameters& parameters) const {
      try {
        return totalLoss(volumeSurface(labels(entry), parameters));
      } catch (const Error&) {  // too many working voxels
        return std::nullopt;
      }
    }

   private:
    LabelGrid labels(size_t entry) const {
      return VolumeFile(files_[entries_[entry].file], coordinates_)
          .phase(entries_[entry].phaseInFile);
    }

    const std::vector<std::string>& files_;
    Coordinates coordinates_;
    const VolumeSurfaceParameters& parameters_;
    const std::vector<Entry>& entries_;
  };

  /// A phase whose surface lacks much of its label.
  struct Thin {
    size_t entry = 0;
    double loss = 0;
    double voxelSize = 0;
  };

  /// Names them; and with the worst which smaller smoothing or voxel_size brings most of it back.
  static void warnOfThinLabels(SharedRemarks& remarks, const std::vector<Thin>& thin,
                               const std::vector<Entry>& entries, const Trial& trial) {
    const auto worst = std::max_element(
        thin.begin(), thin.end(), [](const Thin& a, const Thin& b) { return a.loss < b.loss; });
    for (auto phase = thin.begin(); phase != thin.end(); ++phase)
      if (phase == worst)
        remarks.add(entries[phase->entry].name, adviceOn(*phase, trial));
      else
        remarks.add(entries[phase->entry].name, volume_messages::thinLabel,
                    std::lround(100 * phase->loss));
  }

  static host::Remark adviceOn(const Thin& thin, const Trial& trial) {
    std::string bestWay, tried;
    double best = thin.loss;
    const double smoothing = trial.parameters().smoothing;
    for (const auto& [share, finer] : {std::pair(0.5, false), std::pair(0.0, false),
                                       std::pair(1.0, true), std::pair(0.0, true)}) {
      if (smoothing == 0 && share < 1 && !(share == 0 && finer)) continue;  // as it is
      VolumeSurfaceParameters parameters = trial.parameters();
      parameters.smoothing = share * smoothing;
      if (finer) parameters.interpolation.voxelSize = thin.voxelSize / 2;
      const std::string way =
          (share < 1 ? "smoothing " + shortNumber(parameters.smoothing) : std::string()) +
          (share < 1 && finer ? " and " : "") +
          (finer ? "voxel_size " + shortNumber(thin.voxelSize / 2) : std::string());
      const std::optional<double> found = trial.loss(thin.entry, parameters);
      if (!found) continue;
      tried += (tried.empty() ? "" : "; ") + way + ": " +
               std::to_string(std::lround(100 * *found)) + " %";
      if (*found < best) {
        best = *found;
        bestWay = way;
      }
      if (best < maxLoss) break;
    }
    const long now = std::lround(100 * thin.loss);
    return best < maxLoss || best < thin.loss / 2
               ? host::remarkOn("", volume_messages::thinRemedy, now, bestWay,
                                std::lround(100 * best))
               : host::remarkOn("", volume_messages::thinForItsVoxels, now, tried);
  }

  static bool contains(const std::vector<int>& slices, int slice) {
    return std::find(slices.begin(), slices.end(), slice) != slices.end();
  }

  /// "slices 3 to 5, slice 11".
  static std::string slicesText(const std::vector<int>& slices) {
    std::string text;
    for (size_t i = 0; i < slices.size();) {
      size_t end = i + 1;
      while (end < slices.size() && slices[end] == slices[end - 1] + 1) ++end;
      text +=
          (text.empty() ? "" : ", ") + (end - i > 1 ? "slices " + std::to_string(slices[i]) +
                                                          " to " + std::to_string(slices[end - 1])
                                                    : "slice " + std::to_string(slices[i]));
      i = end;
    }
    return text;
  }

  /// What is said of slices of phases, by the message and the slices.
  class SliceShifts {
   public:
    void add(const std::string& phase, const host::Message& message,
             const std::vector<UnevenSlice>& slices) {
      if (slices.empty()) return;
      auto group = std::find_if(groups_.begin(), groups_.end(), [&](const Group& other) {
        return other.message == &message &&
               std::equal(slices.begin(), slices.end(), other.least.begin(), other.least.end(),
                          [](const auto& a, const auto& b) { return a.slice == b.slice; });
      });
      if (group == groups_.end()) group = groups_.insert(group, {&message, slices, slices, {}});
      for (size_t i = 0; i < slices.size(); ++i) {
        group->least[i].shift = std::min(group->least[i].shift, slices[i].shift);
        group->most[i].shift = std::max(group->most[i].shift, slices[i].shift);
      }
      group->phases.push_back(phase);
    }

    /// "slice 11 by 10.6 to 11.2 mm".
    void tell(SharedRemarks& remarks) const {
      for (const Group& group : groups_) {
        std::string text;
        for (size_t i = 0; i < group.least.size(); ++i) {
          const std::string least = tenths(group.least[i].shift),
                            most = tenths(group.most[i].shift);
          text += (i == 0 ? "slice " : ", slice ") + std::to_string(group.least[i].slice) + " by " +
                  (least == most ? least : least + " to " + most) + " mm";
        }
        for (const std::string& phase : group.phases) remarks.add(phase, *group.message, text);
      }
    }

   private:
    struct Group {
      const host::Message* message;
      std::vector<UnevenSlice> least, most;
      std::vector<std::string> phases;
    };
    std::vector<Group> groups_;
  };

  static VolumeSurface slicesOf(const VolumeSurface& surface) {
    VolumeSurface slices;
    slices.lostSlices = surface.lostSlices;
    slices.unevenSlices = surface.unevenSlices;
    slices.farEnds = surface.farEnds;
    slices.sliceSequence = surface.sliceSequence;
    return slices;
  }

  /// keptByAligning: how many of the lost slices would be.
  static void warnOfSlices(SharedRemarks& remarks, SliceShifts& shifts, const std::string& name,
                           const VolumeSurface& surface, bool aligned, double least,
                           const std::function<long()>& keptByAligning) {
    if (!surface.lostSlices.empty()) {
      const long kept = aligned ? 0 : keptByAligning();
      const std::string lost = slicesText(surface.lostSlices);
      if (kept > 0)
        remarks.add(name, volume_messages::slicesLostByShift, lost, kept);
      else
        remarks.add(name, volume_messages::slicesLost, lost);
    }
    std::vector<UnevenSlice> uneven = surface.unevenSlices;
    if (!aligned)
      uneven.erase(std::remove_if(uneven.begin(), uneven.end(),
                                  [&](const UnevenSlice& slice) {
                                    return slice.shift < least ||
                                           contains(surface.lostSlices, slice.slice);
                                  }),
                   uneven.end());
    shifts.add(name, aligned ? volume_messages::slicesAligned : volume_messages::slicesUneven,
               uneven);
    std::vector<UnevenSlice> ends;
    for (const UnevenSlice& end : surface.farEnds)
      if (!contains(surface.lostSlices, end.slice)) ends.push_back(end);
    shifts.add(name, volume_messages::farEnds, ends);
  }

  /// "slice 6 in heart label 1 phases 0, 3; slice 8 in heart label 1 phase 1", and phases that do
  /// not belong together: of one file, or of the files of a series. That other files do not, as
  /// those of many patients, is said only where some do.
  static void warnOfUnlikePhases(const host::Task& task,
                                 const std::map<int, std::vector<size_t>>& apart,
                                 const std::map<int, std::vector<size_t>>& sequences,
                                 const std::vector<Entry>& entries, bool isSeries) {
    const auto namesOfThe = [&](const std::vector<size_t>& phases) {
      std::vector<std::string> names;
      for (const size_t i : phases) names.push_back(entries[i].name);
      return names;
    };
    std::string unlike;
    std::vector<std::string> named;
    for (const auto& [slice, phases] : apart) {
      const std::vector<std::string> names = namesOfThe(phases);
      unlike += (unlike.empty() ? "slice " : "; slice ") + std::to_string(slice) + " in " +
                namesOf(names);
      for (const std::string& name : names)
        if (std::find(named.begin(), named.end(), name) == named.end()) named.push_back(name);
    }
    if (!unlike.empty()) task.sayNaming(named, volume_messages::slicesAlignedInSome, unlike);
    std::set<size_t> files;
    for (const Entry& entry : entries) files.insert(entry.file);
    const bool fileByFile =
        sequences.size() == files.size() &&
        std::all_of(sequences.begin(), sequences.end(), [&](const auto& sequence) {
          return entries[sequence.second.front()].file == entries[sequence.second.back()].file;
        });
    if (sequences.size() < 2 || (fileByFile && !isSeries)) return;
    std::string parts;
    std::vector<std::string> all;
    for (const auto& [number, phases] : sequences) {
      const std::vector<std::string> names = namesOfThe(phases);
      parts += (parts.empty() ? "" : "; ") + namesOf(names);
      all.insert(all.end(), names.begin(), names.end());
    }
    task.sayNaming(all, volume_messages::slicesAlignedByParts, parts);
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

  /// Whether there was anything to say.
  static bool warnOfHandles(SharedRemarks& remarks, const std::string& name,
                            const VolumeSurface& surface) {
    const RemovedHandles& removed = surface.handles;
    if (removed.changedVoxels == 0) return false;
    const host::Message& message = removed.by == RemovedHandles::By::Filling
                                       ? volume_messages::handlesFilled
                                       : volume_messages::handlesCut;
    const std::string what = removed.handles > 0 ? counted(removed.handles, "handle", "handles")
                                                 : std::string("a cavity");
    remarks.add(name, message, what, workingVoxels(removed.changedVoxels),
                placesText(surface.handlePlaces));
    return true;
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
