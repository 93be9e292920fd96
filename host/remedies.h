// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// What users read of an error: what is wrong as vcg_ext states it, with the host's word for a
/// surface, and what to do about it, with the menu entries as that host spells them.

#include <array>
#include <string>

#include "vcg_ext/base/error.h"

namespace sphere_propagation::host {

/// PyMeshLab is MeshLab 2025.07 in double precision, whose filters have names in Python, too.
enum class Host { MeshLab2025, PyMeshLab, MeshLab2020 };
constexpr std::array<Host, 3> allHosts{Host::MeshLab2025, Host::PyMeshLab, Host::MeshLab2020};

/// "MeshLab 2025.07", "PyMeshLab", "MeshLab 2020.09".
const char* nameOf(Host host);

/// The host that this plugin is built for; defined in the folders of the hosts.
Host thisHost();

/// MeshLab's filters that remedies name.
struct MenuEntry {
  const char* name;        ///< in MeshLab 2025.07; remedies call it so
  const char* pythonName;  ///< in PyMeshLab
  const char* choice;      ///< of the filter's parameters; empty: as they are
  const char* name2020;    ///< in MeshLab 2020.09; null: the same
};
constexpr int menuEntryCount = 14;
extern const std::array<MenuEntry, menuEntryCount> menuEntries;

/// `Layer "heart": it is empty. Load a closed triangle mesh into this layer, or hide or delete the
/// layer.`
std::string sentence(const Error& error, Host host = thisHost());

/// The same without the name of the surface, for where it was named.
std::string complaint(const Error& error, Host host = thisHost());

/// What to do about a fault, with "…" for what varies; empty where its statement says all. It goes
/// on with the statement where it begins with a colon.
std::string remedyOf(Fault fault, Host host);

/// The sentence with "…" for what varies, as the pages show it.
std::string outline(Fault fault, Host host);

/// A text with the entries in it, which stand in angle brackets, as a host spells them: `<Close
/// Holes>` becomes `"Close Holes"`, in PyMeshLab `"Close Holes" (meshing_close_holes)`.
std::string withMenuEntries(const std::string& text, Host host);

}  // namespace sphere_propagation::host
