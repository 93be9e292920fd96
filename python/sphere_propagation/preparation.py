# SPDX-License-Identifier: GPL-3.0-only
"""Meshes as they come, made closed surfaces: the filter "Prepare surface" on arrays."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Dict, Iterator, List, Mapping, Union

import numpy as np

from . import layers
from .parameters import NAMED
from .surface import Surface, SurfaceLike, as_surface

PREPARE = "apply_surface_preparation"
LIDS = NAMED["lid"]
# What is counted, by its names, and in words: of one, of several.
STEPS = {
    "weld": ("vertex welded or dropped", "vertices welded or dropped"),
    "remove_duplicate_faces": ("duplicate or flat face mended", "duplicate or flat faces mended"),
    "remove_fins": ("place with fins cleared", "places with fins cleared"),
    "join_shells": ("wall joined by a ring", "walls joined by a ring"),
    "keep_largest_component": ("smaller part dropped", "smaller parts dropped"),
    "close_openings": ("opening closed", "openings closed"),
    "lid": ("vertex of lids added", "vertices of lids added"),
    "orient": ("face turned", "faces turned"),
    "remove_handles": ("handle removed", "handles removed"),
}


def steps_in_words(figures: Mapping[str, Union[float, np.ndarray]]) -> List[str]:
    """What was done: "1 opening closed", "122 vertices of lids added"."""
    return [
        f"{figures[name]:g} {words[figures[name] != 1]}"
        for name, words in STEPS.items()
        if figures.get(name)
    ]


@dataclass(frozen=True, eq=False)
class PreparedSurface:
    """A surface after its preparation: `surface, figures = prepare(...)`, or by name.

    surface.lid goes on to the landmarks, which a shape model leaves out there.
    lid: (n,), per vertex the number (from 1) of the opening whose lid it belongs to, 0 on the
    surface that was there: vertices[lid == 0] leaves lids out. lid_faces: (k,), True for the faces
    of lids, of which small ones have no vertex of their own.
    figures: how much each step did, by its name: weld, remove_duplicate_faces, remove_fins,
    join_shells, keep_largest_component, close_openings, lid (vertices of lids), orient,
    remove_handles; closed (1 where it is a closed surface of genus 0 now), vertices,
    vertices_before, seconds; one entry per opening: opening_edges, opening_perimeter.
    """

    surface: Surface
    figures: Dict[str, Union[float, np.ndarray]]
    lid: np.ndarray
    lid_faces: np.ndarray

    def __repr__(self) -> str:
        done = [f"{name} {self.figures[name]:g}" for name in STEPS if self.figures.get(name)]
        return f"PreparedSurface({self.surface!r}, {', '.join(done) or 'as it was'})"

    def __iter__(self) -> Iterator:
        return iter((self.surface, self.figures))


def prepare(
    surface: SurfaceLike,
    *,
    weld: bool = True,
    remove_duplicate_faces: bool = True,
    remove_fins: bool = True,
    join_shells: bool = False,
    keep_largest_component: bool = True,
    close_openings: bool = True,
    lid: str = "Curved",
    orient: bool = True,
    remove_handles: bool = False,
) -> PreparedSurface:
    """A closed surface from a mesh with the defects of files. Each step is on or off; what is
    closed and clean comes back as it is.

    weld: unify vertices on open edges that lie in one place, drop those that no face uses.
    remove_duplicate_faces: and those without area. remove_fins: leave no edge with more than two
    faces and no vertex at which sheets touch. join_shells: put a ring between the inner sides and
    the outer side of a wall, at the longest of its openings. keep_largest_component: by area.
    close_openings: by lids, of which `lid` says whether the surface goes on over the rim ("Curved")
    or not ("Flat"). orient: all faces outwards. remove_handles: by way of a volume, with a new
    mesh.

    Warns (SpherePropagationWarning) where it is not a closed surface yet, and where a large part or
    large sheets were dropped. Raises FilterError where there is nothing to prepare.
    """
    given = as_surface(surface)
    meshes = layers.mesh_set([given])
    figures = layers.apply(
        meshes,
        PREPARE,
        all_visible=False,
        weld=weld,
        remove_duplicate_faces=remove_duplicate_faces,
        remove_fins=remove_fins,
        join_shells=join_shells,
        keep_largest_component=keep_largest_component,
        close_openings=close_openings,
        lid=lid,
        orient=orient,
        remove_handles=remove_handles,
    )
    del figures["opening_layer"]
    of_openings = ("opening_edges", "opening_perimeter")
    figures = {
        name: np.asarray(values) if name in of_openings else float(values[0])
        for name, values in figures.items()
    }
    mesh = meshes.mesh(0)
    made = layers.surface_of(mesh, given.name)
    if len(made.vertices) == len(given.vertices) and np.array_equal(made.faces, given.faces):
        none = np.zeros(len(given.vertices), int), np.zeros(len(given.faces), bool)
        if given.lid is not None:
            none = given.lid, none[1]
        return PreparedSurface(given, figures, *none)
    lid = layers.lid_of(mesh)
    return PreparedSurface(
        Surface(made.vertices, made.faces, given.name, given.space, lid),
        figures,
        np.zeros(len(made.vertices), int) if lid is None else lid,
        mesh.face_selection_array(),
    )
