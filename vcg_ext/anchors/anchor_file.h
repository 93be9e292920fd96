// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// Anchors in files of other programs.
///
/// | ending | of | |
/// | --- | --- | --- |
/// | .pp | MeshLab's Pick Points | points that are not active are undefined |
/// | .mrk.json, .json | 3D Slicer | all lists of the file; LPS unless it says RAS |
/// | .json | scalismo | a list of id and coordinates |
/// | .fcsv | 3D Slicer | RAS unless it says LPS (1) |
/// | .csv, .tsv, .txt, .pts, .xyz, .particles | tables | name, x, y, z, or x, y, z alone |
///
/// In tables commas, semicolons, tabs and blanks separate; lines that begin with # are comments; a
/// first line of words names the columns (name, label, landmark or id; x; y; z), else the last
/// three numbers of a line are the place and what stands before is the name. Lines of a place alone
/// are called 1, 2, ... by their order. A place that is empty or nan is undefined.

#include <string>
#include <vector>

#include "vcg_ext/anchors/anchor_set.h"

namespace sphere_propagation {

/// Reads a file. Places that the file has in LPS are returned in RAS. Throws AnchorError, which
/// says what is wrong and where; also of a file that holds no point, not even one without a
/// place.
AnchorList readAnchors(const std::string& file);

/// Places on the sphere, by name: a table with columns name, longitude and latitude (degrees; lon
/// and lat will do), or any file of anchors, whose places are taken as directions. Unit vectors.
/// Throws AnchorError, and RangeError where a latitude is beyond 90 degrees or a direction zero.
AnchorList readSpherePlaces(const std::string& file);

/// The files beside a mesh that hold its anchors, best first: NAME_picked_points.pp, NAME.mrk.json,
/// NAME.csv, NAME.fcsv, NAME.pp. mesh: its file, which need not be there. (NAME.json and NAME.txt
/// may be anything.)
std::vector<std::string> anchorFilesBeside(const std::string& mesh);

/// The files of a folder that hold the anchors of what is called so, best first: one is right.
/// name: with or without a file's ending. As beside a mesh, and besides NAME.json, .tsv, .txt,
/// .pts, .xyz and .particles: a folder that is given holds anchors.
std::vector<std::string> anchorFilesIn(const std::string& folder, const std::string& name);

}  // namespace sphere_propagation
