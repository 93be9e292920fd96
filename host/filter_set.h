// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// The filters of a plugin, and how one is run whatever the host: no exception leaves it, the
/// document is written only when nothing can fail any more, and the user cannot start a second one
/// or close a layer meanwhile.

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "host/document.h"
#include "host/filter.h"

namespace sphere_propagation::host {

class FilterSet {
 public:
  explicit FilterSet(std::vector<std::unique_ptr<Filter>> filters);
  ~FilterSet();
  FilterSet(const FilterSet&) = delete;
  FilterSet& operator=(const FilterSet&) = delete;

  int size() const { return static_cast<int>(filters_.size()); }
  /// index: 0 to size() - 1, also below.
  const FilterDescription& description(int index) const {
    return descriptions_.at(static_cast<size_t>(index));
  }
  /// What the host shows of a filter: scripts have all of it, dialogs the first lines.
  const std::string& info(int index) const;
  RichParameterList parameters(int index, const MeshDocument& document) const;
  /// The same in no host's words.
  std::vector<Parameter> outline(int index, const MeshDocument& document) const;

  struct Result {
    std::optional<std::string>
        failure;  ///< why it did not work, for the user; the document is as it was
    Outputs outputs;
    int changed = 0;  ///< what was written to layers, as a mask of MeshLab's
  };
  /// callback: MeshLab's, may be null; called from this thread only.
  Result run(int index, const RichParameterList& values, MeshDocument& document,
             vcg::CallBackPos* callback, const std::function<void(const std::string&)>& log);

  /// What MeshLab is told beforehand that a filter may change. The numbers of vertices and faces
  /// keep the GUI from offering a preview, which would make layers at every turn of a knob, and
  /// make 2020.09 draw everything anew. Coordinates and colours are not named: 2020.09 would set
  /// those of the current layer back at every Apply to what they were when the dialog was opened.
  static int changes();

 private:
  std::vector<std::unique_ptr<Filter>> filters_;
  std::vector<FilterDescription> descriptions_;
  bool running_ = false;  // the GUI's callback runs its event loop: whoever gets in there must not
                          // start a filter
};

}  // namespace sphere_propagation::host
