// SPDX-License-Identifier: GPL-3.0-only
#include "filter_label_volume/filter_label_volume.h"

#include "filter_label_volume/import_filter.h"
#include "filter_label_volume/messages.h"

namespace {

std::vector<std::unique_ptr<sphere_propagation::host::Filter>> makeFilters() {
  std::vector<std::unique_ptr<sphere_propagation::host::Filter>> filters;
  filters.push_back(sphere_propagation::makeImportFilter());
  return filters;
}

}  // namespace

FilterLabelVolume::FilterLabelVolume()
    : Plugin("FilterLabelVolume", makeFilters(),
             {sphere_propagation::volume_messages::all.begin(),
              sphere_propagation::volume_messages::all.end()}) {}

MESHLAB_PLUGIN_NAME_EXPORTER(FilterLabelVolume)

#include "moc_filter_label_volume.cpp"  // Qt's part of the class
