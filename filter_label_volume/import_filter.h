// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// The filter of this plugin.

#include <memory>

#include "host/filter.h"

namespace sphere_propagation {

std::unique_ptr<host::Filter> makeImportFilter();  ///< Import label volume as layers

}  // namespace sphere_propagation
