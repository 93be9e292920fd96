// SPDX-License-Identifier: GPL-3.0-only
#include "filter_sphere_propagation/map_roots.h"

#include <algorithm>
#include <utility>

#include "filter_sphere_propagation/messages.h"
#include "filter_sphere_propagation/reporting.h"

namespace sphere_propagation {
namespace {

using Labels = std::vector<std::string>;

std::string listed(const Labels& labels) { return namesIn(labels, 3); }

struct Roots {
  std::vector<std::pair<int, Labels>> known;  // by root, in the order of their first layers
  Labels unknown;
};

Roots rootsOf(const std::vector<host::Layer>& layers) {
  Roots roots;
  for (const host::Layer& layer : layers) {
    const std::optional<int> root = layer.mark(host::rootMark);
    if (!root) {
      roots.unknown.push_back(layer.label());
      continue;
    }
    auto group = std::find_if(roots.known.begin(), roots.known.end(),
                              [&](const auto& g) { return g.first == *root; });
    if (group == roots.known.end()) group = roots.known.insert(group, {*root, {}});
    group->second.push_back(layer.label());
  }
  return roots;
}

/// ("a", "b" from one; "c" from another; and 2 more roots)
std::string inBrackets(const Roots& roots) {
  constexpr size_t maxNamed = 4;
  std::string text;
  for (size_t i = 0; i < std::min(roots.known.size(), maxNamed); ++i)
    text += (i > 0 ? "; " : "") + listed(roots.known[i].second) +
            (i > 0 ? " from another" : " from one");
  if (roots.known.size() > maxNamed)
    text += "; and " +
            counted(static_cast<long>(roots.known.size() - maxNamed), "more root", "more roots");
  return "(" + text + ")";
}

}  // namespace

std::map<std::string, int> landmarkMarks(const host::Layer& surface) {
  std::map<std::string, int> marks;
  if (const auto root = surface.mark(host::rootMark)) marks[host::rootMark] = *root;
  if (const auto map = surface.mapFingerprint()) marks[host::sampledMapMark] = *map;
  return marks;
}

void logSeveralRoots(const host::Task& task, const std::vector<host::Layer>& surfaces) {
  const Roots roots = rootsOf(surfaces);
  if (roots.known.size() > 1) task.say(messages::mapsOfSeveralRoots, inBrackets(roots));
  if (!roots.known.empty() && !roots.unknown.empty())
    task.sayNaming(roots.unknown, messages::rootNotKnown, listed(roots.unknown));
}

void requireOneRoot(const std::vector<host::Layer>& landmarks) {
  const Roots roots = rootsOf(landmarks);
  if (roots.known.size() > 1)
    throw host::Refusal(messages::landmarksOfSeveralRoots, inBrackets(roots));
}

void logStaleLandmarks(const host::Task& task, const std::vector<host::Layer>& landmarks,
                       const std::vector<host::Layer>& surfaces,
                       const std::vector<std::optional<size_t>>& sources) {
  Labels gone, mapless, remapped;
  for (size_t i = 0; i < landmarks.size(); ++i) {
    if (!sources[i]) {
      gone.push_back(landmarks[i].label());
      continue;
    }
    const host::Layer& surface = surfaces[*sources[i]];
    const std::optional<int> sampled = landmarks[i].mark(host::sampledMapMark);
    if (!surface.storesPositions())
      mapless.push_back(landmarks[i].label());
    else if (sampled && surface.mark(host::rootMark) && sampled != surface.mapFingerprint())
      remapped.push_back(landmarks[i].label());
  }
  if (!gone.empty() && gone.size() < landmarks.size())
    task.sayNaming(gone, messages::surfacesGone, listed(gone));
  if (!mapless.empty()) task.sayNaming(mapless, messages::surfacesWithoutMap, listed(mapless));
  if (!remapped.empty()) task.sayNaming(remapped, messages::mapsChanged, listed(remapped));
}

}  // namespace sphere_propagation
