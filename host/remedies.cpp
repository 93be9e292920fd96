// SPDX-License-Identifier: GPL-3.0-only
#include "host/remedies.h"

#include <algorithm>
#include <string_view>

#include "vcg_ext/base/sentence.h"

namespace sphere_propagation::host {

// As FilterPlugin::filterName and pythonFilterName say; tests compare them with the hosts' own.
const std::array<MenuEntry, menuEntryCount> menuEntries{{
    {"Close Holes", "meshing_close_holes", "", nullptr},
    {"Conditional Vertex Selection", "compute_selection_by_condition_per_vertex", "", nullptr},
    {"Delete Selected Vertices", "meshing_remove_selected_vertices", "", nullptr},
    {"Invert Faces Orientation", "meshing_invert_face_orientation", "", nullptr},
    {"Matrix: Reset Current Matrix", "set_matrix_identity", "", nullptr},
    {"Re-Orient all faces coherently", "meshing_re_orient_faces_coherently", "",
     "Re-Orient all faces coherentely"},
    {"Remeshing: Isotropic Explicit Remeshing", "meshing_isotropic_explicit_remeshing", "",
     nullptr},
    {"Remove Duplicate Vertices", "meshing_remove_duplicate_vertices", "", nullptr},
    {"Remove Isolated pieces (wrt Face Num.)", "meshing_remove_connected_component_by_face_number",
     "", nullptr},
    {"Remove Unreferenced Vertices", "meshing_remove_unreferenced_vertices", "", nullptr},
    {"Remove Zero Area Faces", "meshing_remove_null_faces", "", nullptr},
    {"Repair non Manifold Vertices by splitting", "meshing_repair_non_manifold_vertices", "",
     nullptr},
    {"Surface Reconstruction: Screened Poisson", "generate_surface_reconstruction_screened_poisson",
     "", nullptr},
    {"Transform: Scale, Normalize", "compute_matrix_from_scaling_or_normalization", "", nullptr},
}};

namespace {

std::string_view remedyWithEntries(Fault fault) {
  switch (fault) {
    case Fault::Empty:
    case Fault::NoFaces:
      return "Load a closed triangle mesh into this layer, or hide or delete the layer.";
    case Fault::TooFewVertices:
      return "A closed surface has at least four.";
    case Fault::NonFiniteCoordinate:
      return "Drop them and close what opens with \"Prepare surface\"; or select them with "
             "<Conditional Vertex Selection>, condition \"x-x+y-y+z-z != 0\", then <Delete "
             "Selected "
             "Vertices> and <Close Holes>.";
    case Fault::IndexOutOfRange:
      return "The file is damaged: export it again.";
    case Fault::DegenerateFace:
      return "Drop them with \"Prepare surface\", or with <Remove Zero Area Faces>, then <Close "
             "Holes> if there are any.";
    case Fault::NonManifoldEdge:
      return "Remove the fins with \"Prepare surface\".";
    case Fault::NotClosed:
      return "Close it with \"Prepare surface\", whose lids are marked; or with <Close Holes>, "
             "whose "
             "largest size to be closed must be {low} or more; it is 30 unless it is set.";
    case Fault::NotWelded:
      return ": unify them with \"Prepare surface\", which also closes what is still open; or with "
             "<Remove Duplicate Vertices>, then <Close Holes>.";
    case Fault::InconsistentOrientation:
      return "Orient them with \"Prepare surface\", or with <Re-Orient all faces coherently>; "
             "should "
             "they point inwards then, <Invert Faces Orientation>.";
    case Fault::UnreferencedVertex:
      return "Leave them out with \"Prepare surface\", or with <Remove Unreferenced Vertices>.";
    case Fault::NonManifoldVertex:
      return "Take them apart with \"Prepare surface\"; or with <Repair non Manifold Vertices by "
             "splitting>, then keep the largest part with <Remove Isolated pieces (wrt Face "
             "Num.)>.";
    case Fault::SeveralParts:
      return "Keep the largest with \"Prepare surface\", or the one that is meant with <Remove "
             "Isolated pieces (wrt Face Num.)>.";
    case Fault::Handles:
      return "Remove them before meshing (fill the tunnels in the label image), or with \"Prepare "
             "surface\" and its option \"Remove handles\", or <Surface Reconstruction: Screened "
             "Poisson> at a lower depth, which make the surface anew.";
    case Fault::InwardOrientation:
      return "Turn them round with \"Prepare surface\", or with <Invert Faces Orientation>.";
    case Fault::ZeroArea:
      return "There is no surface to map: load the mesh again.";
    case Fault::Flat:
      return "If its matrix flattens it, undo that (<Matrix: Reset Current Matrix>); else load "
             "the mesh again.";
    case Fault::CoordinateTooLarge:
    case Fault::ExtentTooSmall:
      return "Bring all layers to a unit such as mm (<Transform: Scale, Normalize>).";
    case Fault::NotRepairable:
    case Fault::NoRoom:
      return ": choose another order of propagation or another root.";
    case Fault::NoValidMap:
      return ": remesh it with <Remeshing: Isotropic Explicit Remeshing> and run this filter "
             "again.";
    case Fault::NoSurface:
      return ": show at least one.";
    case Fault::RootOutOfRange:
      return ": choose one of them.";
    case Fault::ParentOutOfRange:
      return ": give the number of a layer, or -1 for the root.";
    case Fault::SecondRoot:
      return ": give all layers but one the number of the layer their map comes from.";
    case Fault::NoRoot:
      return ": give one of them the number -1.";
    case Fault::Circle:
      return "Give one of them a layer that leads back to the root.";
    case Fault::NoCorrespondence:
      return "Choose another order of propagation or another root, or the method \"Robust\".";
    case Fault::DifferentUnits:
      return "Bring all layers to one unit (<Transform: Scale, Normalize>).";
    case Fault::AnchorFileUnknown:
      return "Give a file of Pick Points (.pp), of 3D Slicer (.mrk.json, .fcsv) or of scalismo "
             "(.json), or a table of name, x, y, z (.csv, .txt).";
    case Fault::AnchorFileSyntax:
      return "Write it again.";
    case Fault::AnchorFrame:
      return "Export it again in one of them.";
    case Fault::AnchorNotNumbers:
      return "Mend it there, or leave the place empty where it is not known.";
    case Fault::AnchorsInOnePlace:
      return "Leave one of them out.";
    case Fault::AnchorsChangePlaces:
      return "Are their names exchanged?";
    case Fault::AnchorsNotHeld:
      return "Leave out those that lie closest together.";
    case Fault::FewSharedAnchors:
    case Fault::AnchorsOnOneLine:
      return "Pick more of them on its surface (\"Load anchors\"), hide the layer, or choose "
             "another "
             "alignment.";
    case Fault::LandmarkCount:
      return "Remesh all surfaces with one frequency, or hide the layers that do not belong to the "
             "model.";
    case Fault::NonFiniteLandmark:
      return "Remesh its surface again, or hide the layer.";
    case Fault::LandmarksInOnePlace:
      return "Hide the layer, or remesh its surface again.";
    case Fault::FileIsFolder:
      return "Name a file.";
    case Fault::NoFolder:
      return "Make it first.";
    case Fault::FileTooLarge:
      return "Keep fewer modes.";
    case Fault::TooThin:
      return ": choose a smaller voxel_size.";
    case Fault::WorkingVoxelsSmall:
      return "Choose a larger voxel_size.";
    case Fault::WorkingVoxelsLarge:
      return "Choose a smaller voxel_size.";
    default:  // the statement says all
      return "";
  }
}

/// The statement and what to do about it, which may go on with its last clause.
std::string joined(const std::string& statement, const std::string& remedy) {
  if (remedy.empty()) return statement + ".";
  return statement + (remedy.front() == ':' ? "" : ". ") + remedy;
}

/// What pages show for a gap.
std::string dots(std::string_view gap) {
  return gap == "Noun" ? "Layer" : gap == "noun" ? "layer" : gap == "nouns" ? "layers" : "…";
}

}  // namespace

const char* nameOf(Host host) {
  switch (host) {
    case Host::MeshLab2020:
      return "MeshLab 2020.09";
    case Host::PyMeshLab:
      return "PyMeshLab";
    default:
      return "MeshLab 2025.07";
  }
}

std::string withMenuEntries(const std::string& text, Host host) {
  const size_t open = text.find('<'), close = text.find('>', open);
  if (open == std::string::npos || close == std::string::npos) return text;
  const std::string_view name = std::string_view(text).substr(open + 1, close - open - 1);
  const auto entry = std::find_if(menuEntries.begin(), menuEntries.end(),
                                  [&](const MenuEntry& e) { return name == e.name; });
  std::string shown = "\"" + std::string(name) + "\"", choice;
  if (entry != menuEntries.end()) {
    if (host == Host::MeshLab2020 && entry->name2020 != nullptr)
      shown = "\"" + std::string(entry->name2020) + "\"";
    else
      choice = entry->choice;
    if (host == Host::PyMeshLab) choice = entry->pythonName + (choice.empty() ? "" : ", " + choice);
  }
  const bool inBrackets = open > 0 && text[open - 1] == '(';
  if (!choice.empty()) shown += inBrackets ? ", " + choice : " (" + choice + ")";
  return text.substr(0, open) + shown + withMenuEntries(text.substr(close + 1), host);
}

std::string remedyOf(Fault fault, Host host) {
  return fill(withMenuEntries(std::string(remedyWithEntries(fault)), host), dots);
}

std::string sentence(const Error& error, Host host) {
  const Finding& finding = error.finding();
  const std::string text = statement(finding, "layer");
  if (finding.fault == Fault::Text) return text;  // with its full stop
  const std::string remedy = withMenuEntries(std::string(remedyWithEntries(finding.fault)), host);
  return joined(text, fill(remedy, finding, "layer"));
}

std::string complaint(const Error& error, Host host) {
  const std::string text = sentence(error, host);
  const std::string name = "Layer \"" + error.finding().name + "\": ";
  return text.compare(0, name.size(), name) == 0 ? text.substr(name.size()) : text;
}

std::string outline(Fault fault, Host host) {
  return joined(fill(sentenceOf(fault), dots), remedyOf(fault, host));
}

}  // namespace sphere_propagation::host
