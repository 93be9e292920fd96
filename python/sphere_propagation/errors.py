# SPDX-License-Identifier: GPL-3.0-only
"""What this package raises on purpose; the messages are written for the user.

SpherePropagationError          catch this one to catch them all
  PluginError (ImportError)     PyMeshLab or the plugin is missing, or they do not fit together
  InputError (ValueError)       an argument that no filter needs to see: an array of the wrong
                                shape, a root that is not there
  FileError (OSError)           a file that cannot be read as a mesh or a map
  FilterError (RuntimeError)    a filter refused; the message is the filter's own, with advice for
                                arrays

SpherePropagationWarning        a result that deserves a look
"""

from __future__ import annotations

import re

#: What to do about a fault (vcg_ext/base/fault.h) where surfaces are arrays, in place of what the
#: plugin advises, which is for layers and menus: how its advice begins, and ours. All that comes
#: from the plugin is a text, so its advice is known by its first words; a test compares them.
FOR_ARRAYS = {
    "Empty": (
        "Load a closed triangle mesh",
        "Give it vertices (n, 3) and faces (k, 3), or leave it out.",
    ),
    "NoFaces": (
        "Load a closed triangle mesh",
        "Give it vertices (n, 3) and faces (k, 3), or leave it out.",
    ),
    "NonFiniteCoordinate": (
        "Drop them and close",
        "sp.prepare(surface) drops them and closes what opens; "
        "~np.isfinite(vertices).all(axis=1) tells which: whatever wrote them went wrong.",
    ),
    "IndexOutOfRange": (
        "The file is damaged",
        "((faces < 0) | (faces >= len(vertices))).any(axis=1) tells which.",
    ),
    "DegenerateFace": (
        "Drop them with",
        "Leave them out: faces[(faces != np.roll(faces, 1, axis=1)).all(axis=1)].",
    ),
    "NonManifoldEdge": (
        "Remove the fins with",
        "sp.prepare(surface) removes the fins.",
    ),
    "NotClosed": (
        "Close it with",
        "sp.prepare(surface) closes it by lids that are marked; so does, without marks, "
        "meshing_close_holes of a pymeshlab.MeshSet, with a maxholesize above that number of "
        "edges; it is 30 unless it is given.",
    ),
    "NotWelded": (
        ": unify them with",
        ": unify them by sp.prepare(surface), which also closes what is still open, or by "
        "vertices, index = np.unique(vertices, axis=0, return_inverse=True); faces = "
        "index.reshape(-1)[faces].",
    ),
    "InconsistentOrientation": (
        "Orient them with",
        "All must run counterclockwise as seen from outside: sp.prepare(surface) turns them so.",
    ),
    "UnreferencedVertex": (
        "Leave them out with",
        "Leave them out: used, index = np.unique(faces, return_inverse=True); vertices[used] and "
        "index.reshape(-1, 3) are what is left.",
    ),
    "NonManifoldVertex": (
        "Take them apart with",
        "sp.prepare(surface) takes them apart, and keeps the largest part.",
    ),
    "SeveralParts": (
        "Keep the largest with",
        "sp.prepare(surface) keeps the largest. Where another one is meant, keep its faces: "
        "scipy.sparse.csgraph.connected_components tells the parts.",
    ),
    "Handles": (
        "Remove them before meshing",
        "Remove them before meshing, by filling the tunnels in the label image, as "
        "read_label_volume does; or by sp.prepare(surface, remove_handles=True), which makes the "
        "surface anew.",
    ),
    "InwardOrientation": ("Turn them round", "Turn them round: faces[:, ::-1]."),
    "ZeroArea": (
        "There is no surface to map",
        "There is no surface to map: all vertices lie in one place, or on one line.",
    ),
    "Flat": ("If its matrix flattens it", "Is a column of the vertices constant?"),
    "CoordinateTooLarge": (
        "Bring all layers to a unit",
        "Multiply all vertices, so that their unit is one such as mm.",
    ),
    "ExtentTooSmall": (
        "Bring all layers to a unit",
        "Multiply all vertices, so that their unit is one such as mm.",
    ),
    "NoValidMap": (
        ": remesh it with",
        ": make its triangles more even, as meshing_isotropic_explicit_remeshing of a "
        "pymeshlab.MeshSet does.",
    ),
    "NoSurface": (": show at least one", ": give at least one."),
    "DifferentUnits": (
        "Bring all layers to one unit",
        "Multiply the vertices of one of them, so that both are in one unit.",
    ),
    "LandmarkCount": (
        "Remesh all surfaces with one frequency",
        "Remesh all surfaces with one frequency.",
    ),
    "NonFiniteLandmark": (
        "Remesh its surface again",
        "Leave the shape out, points[np.isfinite(points).all(axis=(1, 2))], or make its landmarks "
        "again.",
    ),
    "LandmarksInOnePlace": (
        "Hide the layer, or remesh",
        "Leave the shape out, or make its landmarks again.",
    ),
}


def for_arrays(message: str) -> str:
    """What the plugin says of a fault, with advice for one who has arrays."""
    for opening, advice in FOR_ARRAYS.values():
        statement, found, _ = message.rpartition(opening)
        if found:
            message = statement + advice
            break
    return re.sub(r'^Layer (?=")', "Surface ", message)


class SpherePropagationError(Exception):
    """Base of all errors below."""


class SpherePropagationWarning(UserWarning):
    """A result that deserves a look, in the filter's own words.

    layer: the surface that it is about, whose name the text begins with; empty where it is about
    the result as a whole. message: what the filters' catalogue calls it, as "anotherPose"; empty
    where it is none of theirs. kind: "Warning", or "Note" for advice (see warnings_of).
    """

    def __init__(self, text: str, layer: str = "", message: str = "", kind: str = "Warning"):
        super().__init__(text)
        self.layer, self.message, self.kind = layer, message, kind

    def __reduce__(self):
        return type(self), (str(self), self.layer, self.message, self.kind)


class PluginError(SpherePropagationError, ImportError):
    """PyMeshLab or the plugin is missing, or they do not fit together."""


class InputError(SpherePropagationError, ValueError):
    """An argument cannot be what is meant: an array of the wrong shape, a root that is missing."""


class FileError(SpherePropagationError, OSError):
    """A file cannot be read as a mesh or a map."""


class FilterError(SpherePropagationError, RuntimeError):
    """A filter refused its input or its parameters, in its own words, with advice for arrays.

    filter: its name in PyMeshLab; __cause__: what it said there.
    """

    def __init__(self, filter: str, message: str):
        super().__init__(for_arrays(message))
        self.filter = filter
