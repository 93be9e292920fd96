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
from typing import Iterable, Sequence

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
    "FewSharedAnchors": (
        "Pick more of them",
        "Give more of them, leave the shape out, or choose another alignment.",
    ),
    "AnchorsOnOneLine": (
        "Pick more of them",
        "Give more of them, leave the shape out, or choose another alignment.",
    ),
    "LandmarksInOnePlace": (
        "Hide the layer, or remesh",
        "Leave the shape out, or make its landmarks again.",
    ),
}


#: The same of what filters say besides (messages.def), by its name there.
MESSAGES_FOR_ARRAYS = {
    "noMappedLayer": (
        "No visible surface layer has a map",
        "No surface has a valid map to the sphere: a map has one unit vector per vertex, and no "
        "face of it is flipped, as parameterise_root and propagate make them.",
    ),
    "rootMapNotValid": (
        "Make it the current layer and run",
        "parameterise_root(surface) makes one.",
    ),
    "noSurfaceToMeasure": (
        ": load it, hide the landmarks, or",
        ": surfaces are those that the landmarks lie on, in the order of the shapes.",
    ),
    "landmarksOffSurface": (
        ", which was moved or replaced since: run",
        ": surfaces are those that the landmarks lie on, in the order of the shapes.",
    ),
    "onlySurface": ("Load or show the other layers", "Give two surfaces or more."),
    "tooManyLandmarks": (
        "Choose a lower frequency or hide layers",
        "Choose a lower frequency or fewer surfaces.",
    ),
    "rootOnUnitSphere": (
        "so the other filters take it for one that",
        "so propagate and remesh take it for a map's sphere. Where it is a surface, scale it.",
    ),
    "mirrorImage": ("Run the filter again with mirror_layers", "mirror_layers=True reflects it."),
    "reflected": (
        "Its surface is changed; save it",
        "Its surface goes on reflected; what was given stays as it is.",
    ),
    "layersWithoutLids": (
        "Prepare them in the same way, or tell",
        "Prepare them in the same way; where they were closed elsewhere, nothing tells what is "
        "made up there.",
    ),
    "shellsNotJoined": (
        "Load it again and prepare it with",
        "Prepare it with join_shells=True, which puts a ring between the two; else each side is a "
        "surface of its own, of which the larger is kept.",
    ),
    "largePartDropped": (
        "load the mesh again, split it into its parts and prepare each by itself;",
        "prepare each by itself; where the two are the sides of one wall, both closed, they have "
        "to be joined before.",
    ),
    "partNotJoined": (
        "Keep both by",
        "Keep both by keep_largest_component=False, or prepare each by itself.",
    ),
    "largeSheetsDropped": (
        "make each body a layer of its own before",
        "make each body a surface of its own before, or keep all sheets by remove_fins=False.",
    ),
    "notClosedYet": (
        "Run the filter again with the steps",
        "Prepare it with the steps that were left out.",
    ),
    "oneSided": (", and run the filter again", ", and prepare it again."),
    "notMended": (
        "No step of this filter mends that",
        "No step of the preparation mends that; mend the mesh where it was made.",
    ),
    "handlesLeft": (
        "Run the filter again with remove_handles",
        "Prepare it with remove_handles=True, which makes the surface anew.",
    ),
}


def for_arrays(message: str) -> str:
    """What the plugin says, with advice for one who has arrays."""
    for opening, advice in (*FOR_ARRAYS.values(), *MESSAGES_FOR_ARRAYS.values()):
        statement, found, _ = message.rpartition(opening)
        if found:
            message = statement + advice
            break
    return re.sub(r'^Layer (?=")', "Surface ", message)


class SpherePropagationError(Exception):
    """Base of all errors below."""


class SpherePropagationWarning(UserWarning):
    """A result that deserves a look, in the filter's own words.

    layers: the names of the surfaces that it is about, a tuple; empty where it is about the result
    as a whole. layer: the name where it is one, else empty. message: what the filters' catalogue
    calls it, as "anotherPose"; empty where it is none of theirs. kind: "Warning", or "Note" for
    advice (see warnings_of). subject: how the text calls them where it begins with that, as
    "heart phases 0 to 4"; said: the text after it.
    """

    def __init__(
        self,
        text: str,
        layer: str = "",
        message: str = "",
        kind: str = "Warning",
        layers: Iterable[str] = (),
        subject: str = "",
    ):
        super().__init__(text)
        self.layers = tuple(layers) or ((layer,) if layer else ())
        self.layer = self.layers[0] if len(self.layers) == 1 else ""
        self.message, self.kind = message, kind
        begin = subject or self.layer
        self.subject = begin if begin and text.startswith(f"{begin}: ") else ""
        self.said = text[len(self.subject) + 2 :] if self.subject else text

    @classmethod
    def of(
        cls,
        subject: str,
        said: str,
        layers: Iterable[str],
        message: str = "",
        kind: str = "Warning",
    ) -> SpherePropagationWarning:
        """From the parts of its text."""
        text = f"{subject}: {said}" if subject else said
        return cls(text, "", message, kind, layers, subject)

    def __reduce__(self):
        rest = (self.message, self.kind, self.layers, self.subject)
        return type(self), (str(self), self.layer, *rest)


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


def some(names: Sequence[str], most: int) -> str:
    """Names in a message: the first of them, and how many more there are."""
    more = len(names) - most
    return ", ".join(names[:most]) + (f" and {more} more" if more > 0 else "")
