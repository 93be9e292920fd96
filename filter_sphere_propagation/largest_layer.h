// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// Which layer encloses most: of a heart cycle that is end-diastole, the better root in the paper.
/// Hints for dialogs and for the log.

#include <string>
#include <vector>

#include "host/layers.h"

namespace sphere_propagation {

/// The visible surfaces by volume.
class LargestLayer {
 public:
  /// Quick, and nothing is wrong with any layer: what encloses nothing is never the largest. Up to
  /// a quarter of the layers, where they are more than twice as large as all others and three times
  /// as large as the median, are of another unit or shape, and passed over.
  explicit LargestLayer(const std::vector<host::Layer>& surfaces);

  /// Whether a layer is clearly smaller than the largest one, and the choice of the root therefore
  /// worth a thought. False for a layer that is not among the surfaces, or where there is one only.
  bool beats(int layerId) const;

  /// For a parameter's help: which layer it is. Empty where there is one surface only.
  std::string help() const;
  /// For a label and the log: "layer 3 "endo_03.ply" is the largest (volume 2.1e+05, this
  /// one 1.1e+05)"; empty where it does not beat the layer.
  std::string note(int layerId) const;

 private:
  double volumeOf(int layerId) const;

  struct Entry {
    int id;
    std::string label;
    double volume;
  };
  std::vector<Entry> entries_;
  size_t largest_ = 0;
};

}  // namespace sphere_propagation
