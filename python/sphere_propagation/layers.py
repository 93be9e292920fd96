# SPDX-License-Identifier: GPL-3.0-only
"""Arrays to PyMeshLab's layers and back: the one place that touches a MeshSet."""

from __future__ import annotations

import re
from typing import Any, Callable, Dict, List, Mapping, Optional, Sequence

import numpy as np

from . import attention, plugin
from .errors import FilterError, InputError
from .parameters import FLAGS, in_full
from .sphere_map import SphereMap
from .surface import Surface, distinct_names
from .turns import turn

ATTRIBUTE = "sphere_position"
LID = "lid"
_kept = []


def anchor_attribute(name: str) -> str:
    """Where a layer carries the anchor of this name, as host/layers.h says."""
    return "anchor_" + re.sub(
        rb"[^A-Za-z0-9_-]", lambda found: b"%%%02X" % found[0][0], name.encode()
    ).decode("ascii")


def mesh_set(
    surfaces: Sequence[Surface] = (),
    maps: Optional[Mapping[int, SphereMap]] = None,
    anchors: Optional[Sequence[Mapping[str, np.ndarray]]] = None,
):
    """One layer per surface, numbered as in the list, with the maps and anchors that are given; the
    first is the current one."""
    pymeshlab = plugin.register()
    meshes = pymeshlab.MeshSet()
    for i, (surface, name) in enumerate(zip(surfaces, distinct_names(surfaces))):
        if not len(surface.vertices):  # PyMeshLab's own words name no surface
            raise InputError(f"{name} has no vertices.")
        sphere = maps.get(i) if maps else None
        if sphere is not None and len(sphere.positions) != len(surface.vertices):
            raise InputError(
                f"{surface.name} has {len(surface.vertices)} vertices, its map "
                f"{len(sphere.positions)} positions."
            )
        texture = (
            {}
            if sphere is None or sphere.texture is None
            else {"v_tex_coords_matrix": sphere.texture}
        )
        mesh = pymeshlab.Mesh(surface.vertices, surface.faces, **texture)
        if sphere is not None:
            mesh.add_vertex_custom_point_attribute(sphere.positions, ATTRIBUTE)
        if surface.lid is not None:
            mesh.add_vertex_custom_scalar_attribute(surface.lid.astype(float), LID)
        for anchor, place in (anchors[i] if anchors else {}).items():
            places = np.tile(place, (len(surface.vertices), 1))
            mesh.add_vertex_custom_point_attribute(places, anchor_attribute(anchor))
        meshes.add_mesh(mesh, name)
    if meshes.mesh_number():
        meshes.set_current_mesh(0)
    return meshes


def surface_of(mesh, name: Optional[str] = None) -> Surface:
    name = mesh.label() if name is None else name
    return Surface(mesh.vertex_matrix(), mesh.face_matrix(), name, lid=lid_of(mesh))


def lid_of(mesh) -> Optional[np.ndarray]:
    """Per vertex the number of its lid, 0 on none; None where the mesh has no lids."""
    lid = _if_there(mesh.vertex_custom_scalar_attribute_array, LID)
    return None if lid is None else lid.astype(int)


def _if_there(read: Callable[[str], np.ndarray], attribute: str) -> Optional[np.ndarray]:
    try:
        return read(attribute)
    except Exception as error:  # PyMeshLab's; nothing else says whether it is there
        if not type(error).__module__.startswith("pymeshlab"):
            raise
        return None


def map_of(mesh, figures: Optional[Dict[str, float]] = None) -> SphereMap:
    texture = mesh.vertex_tex_coord_matrix() if mesh.has_vertex_tex_coord() else None
    return SphereMap(mesh.vertex_custom_point_attribute_matrix(ATTRIBUTE), texture, figures or {})


def without_map(meshes) -> List[str]:
    """The names of the layers that have no map."""
    return [
        mesh.label()
        for mesh in meshes
        if _if_there(mesh.vertex_custom_point_attribute_matrix, ATTRIBUTE) is None
    ]


def keep(meshes) -> None:
    """PyMeshLab goes on writing into the log of a MeshSet in which something failed, also when it
    is gone: keep the last one."""
    _kept[:] = [meshes]


def apply(meshes, name: str, **parameters) -> Dict[str, Any]:
    """Runs a filter, when those of other threads are done; what it refuses comes as a FilterError
    with the filter's own words, what it warns of as a SpherePropagationWarning."""
    parameters = {key: in_full(key, value) for key, value in parameters.items()}
    for key, value in parameters.items():
        if isinstance(value, (bool, np.bool_)) and key not in FLAGS:
            raise InputError(f"{key} must not be {value!r}: it is no matter of on or off.")
    try:
        with turn(name):
            returned = meshes.apply_filter(name, **parameters) or {}
    except RuntimeError as error:
        # pybind11 could not convert a value: it names neither the parameter nor the type.
        keep(meshes)
        given = ", ".join(f"{key}={value!r}" for key, value in parameters.items())
        raise FilterError(name, f"A parameter of {name} has the wrong type: {given}") from error
    except Exception as error:  # PyMeshLab's; the first line says only that the filter failed
        keep(meshes)
        if not type(error).__module__.startswith("pymeshlab"):
            raise
        text = re.sub(r"^\s*Failed to apply filter:[^\n]*\n?(Details:)?\s*", "", str(error)).strip()
        unknown = re.match(r"Enum '(.*)' not found\. Possible values are (.*?);?\s*$", text)
        if unknown:  # which names no parameter
            value, choices = unknown.groups()
            which = next((key for key in parameters if str(parameters[key]) == value), "a choice")
            choices = choices.replace("; ", ", ")
            text = f"{which} must be one of {choices}, not {value!r}."
        raise FilterError(name, text or str(error)) from error
    attention.pass_on(returned)
    return returned


def row(figures: Mapping[str, np.ndarray], i: int, names: Sequence[str]) -> Dict[str, float]:
    """The figures of one layer."""
    return {name: float(figures[name][i]) for name in names if name in figures}
