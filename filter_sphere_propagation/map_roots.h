// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// Which maps belong together: those that were handed down from one root. Only then is a place of
/// the sphere, and so landmark j, the same place on every layer. Maps whose root is not known, as
/// those read from files, are not judged.

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "host/filter.h"

namespace sphere_propagation {

/// The marks of a landmark layer that is made of this surface: which map it was sampled from, and
/// its root.
std::map<std::string, int> landmarkMarks(const host::Layer& surface);

/// Says in the log which layers' maps come from different roots, and which ones nothing is known of
/// beside others that are known. Says nothing where all belong together or nothing is known.
void logSeveralRoots(const host::Task& task, const std::vector<host::Layer>& surfaces);

/// Throws ParameterError, which names the layers, where landmarks were sampled from maps of
/// different roots.
void requireOneRoot(const std::vector<host::Layer>& landmarks);

/// Names in the log the landmark layers whose surface is gone while others' are there, has no map
/// any more, or has another map than the one that was sampled. sources: for each landmark layer the
/// number of its surface, see landmarkSources.
void logStaleLandmarks(const host::Task& task, const std::vector<host::Layer>& landmarks,
                       const std::vector<host::Layer>& surfaces,
                       const std::vector<std::optional<size_t>>& sources);

}  // namespace sphere_propagation
