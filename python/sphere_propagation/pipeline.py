"""The main job on arrays: root map, propagation, remeshing; each a run of the plugin's filter in a MeshSet of its own.

Arrays in and out, nothing is printed and no file is read or written. What a filter refuses comes as PipelineError with the
filter's own words, which name the layer.
"""
from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Callable, Dict, List, NamedTuple, Optional, Sequence, Tuple

import numpy as np

from . import plugin

METHODS = ("Robust", "As published")
ORDERS = ("Time", "Cyclic time", "Similarity tree", "Star", "Given")
PARTS = ("Cavity", "Wall")

Figures = Dict[str, np.ndarray]


class PipelineError(RuntimeError):
    """A filter could not do its work; the message is for the user."""


class Surface(NamedTuple):
    """A closed surface: name, vertices (n, 3), outward triangles (k, 3)."""

    name: str
    vertices: np.ndarray
    faces: np.ndarray


class SphereMap(NamedTuple):
    """A map to the unit sphere: unit vectors (n, 3), and the same as texture coordinates (n, 2), which files keep.

    Texture coordinates are None where rounding them to floats would have made the map invalid.
    """

    positions: np.ndarray
    texture: Optional[np.ndarray]


@dataclass
class Correspondence:
    """All layers mapped by one method: vertex j of every landmark mesh is the same place."""

    surfaces: List[Surface]
    root: int
    method: str
    order: str
    maps: List[SphereMap]
    landmarks: np.ndarray  # layers, landmarks, 3
    landmark_faces: np.ndarray  # shared by all layers
    figures: Figures  # name -> one entry per layer


def make_phantom(part: str = "Cavity", phases: int = 25, voxel_size: float = 2.0, seed: int = 0, twist: float = 0.0) -> List[Surface]:
    """The beating ventricle, one surface per phase, without correspondence; `phantom.Ventricle` knows the truth."""
    meshes = plugin.load().MeshSet()
    _apply(meshes, "create_ventricle_phantom", part=part, phases=phases, voxel_size=voxel_size, seed=seed, twist=twist)
    return [Surface(mesh.label(), mesh.vertex_matrix(), mesh.face_matrix()) for mesh in meshes]


def parameterise_root(surface: Surface, **parameters) -> Tuple[SphereMap, Dict[str, float]]:
    """An area-preserving map of one surface, and its figures."""
    meshes = _mesh_set([surface])
    figures = _apply(meshes, "compute_spherical_parameterisation_root", **parameters)
    return _map_of(meshes.mesh(0)), figures


def propagate(surfaces: Sequence[Surface], root_map: SphereMap, root: int = 0, **parameters) -> Tuple[List[SphereMap], Figures]:
    """The root's map handed on to all other surfaces. Parameters: those of the filter (method, order, ...)."""
    meshes = _mesh_set(surfaces, {root: root_map})
    figures = _apply(meshes, "transfer_spherical_parameterisation_to_layers", root_layer=root, **parameters)
    if len(figures["parent"]) != len(surfaces):
        raise PipelineError("Not every mesh was taken for a surface: one of them is an icosphere's landmark mesh, lies on "
                            "the unit sphere, or is called like a layer of a shape model.")
    return [root_map if i == root else _map_of(meshes.mesh(i)) for i in range(len(surfaces))], figures


def remesh(surfaces: Sequence[Surface], maps: Sequence[SphereMap], frequency: int = 10) -> Tuple[np.ndarray, np.ndarray, Figures]:
    """Landmarks (layers, 10 f^2 + 2, 3) of all surfaces, their one face list, and figures."""
    meshes = _mesh_set(surfaces, dict(enumerate(maps)))
    figures = _apply(meshes, "generate_icosphere_remeshing", frequency=frequency, color_landmarks=False)
    made = [meshes.mesh(i) for i in range(len(surfaces), meshes.mesh_number())]
    if len(made) != len(surfaces):
        raise PipelineError(f"{len(surfaces)} surfaces gave {len(made)} landmark meshes: names must differ.")
    return np.stack([mesh.vertex_matrix() for mesh in made]), made[0].face_matrix(), figures


def map_colors(surfaces: Sequence[Surface], maps: Sequence[SphereMap], cells: int = 8) -> List[np.ndarray]:
    """The checkerboard of each map on the vertices of its surface: (n, 3) in [0, 1]."""
    meshes = _mesh_set(surfaces, dict(enumerate(maps)))
    _apply(meshes, "compute_color_from_spherical_parameterisation_per_vertex", pattern="Checkerboard", cells=cells)
    return [mesh.vertex_color_matrix()[:, :3] for mesh in meshes]


def run(surfaces: Sequence[Surface], root: int = 0, methods: Sequence[str] = ("Robust",), order: str = "Time", frequency: int = 10,
        report: Callable[[str], None] = lambda text: None) -> Dict[str, Correspondence]:
    """The whole job, once per method with the same root map. `report` gets one line after each step."""
    surfaces = list(surfaces)
    if not 0 <= root < len(surfaces):
        raise PipelineError(f"Layer {root} cannot be the root: layers are numbered from 0 to {len(surfaces) - 1}.")
    root_map, root_figures = parameterise_root(surfaces[root])
    report(f"root map of {surfaces[root].name}: {root_figures['flipped_faces']} flipped faces, "
           f"area ratio sd {root_figures['area_ratio_sd']:.4f}")
    results = {}
    for method in methods:
        maps, figures = propagate(surfaces, root_map, root, method=method, order=order)
        figures["seconds"][root] = root_figures["seconds"]
        report(f"{method.lower()}: maps of {len(maps)} layers, {int(figures['flipped_faces'].sum())} flipped faces, "
               f"{int(figures['repaired_faces'].sum())} repaired on the way")
        landmarks, faces, distances = remesh(surfaces, maps, frequency)
        distances["remeshing_seconds"] = distances.pop("seconds")
        figures.update(distances)
        report(f"{method.lower()}: {landmarks.shape[1]} landmarks on each layer, "
               f"{figures['surface_distance_mean'].mean():.2f} mm from the surfaces on average")
        results[method] = Correspondence(surfaces, root, method, order, maps, landmarks, faces, figures)
    return results


def volume(surface: Surface) -> float:
    """Of what a closed surface surrounds."""
    a, b, c = (surface.vertices[surface.faces[:, k]] for k in range(3))
    return float(np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6)


def largest(surfaces: Sequence[Surface]) -> int:
    """Index of the surface of largest volume: end-diastole, the better root of a heart cycle."""
    return int(np.argmax([abs(volume(surface)) for surface in surfaces]))


# ---------------------------------------------------------------- PyMeshLab


def _mesh_set(surfaces: Sequence[Surface], maps: Optional[Dict[int, SphereMap]] = None):
    """One layer per surface, numbered as in the list, with the maps that are given."""
    pymeshlab = plugin.load()
    meshes = pymeshlab.MeshSet()
    for i, surface in enumerate(surfaces):
        mesh = pymeshlab.Mesh(np.asarray(surface.vertices, float), np.asarray(surface.faces, np.int32))
        if maps and i in maps:
            mesh.add_vertex_custom_point_attribute(maps[i].positions, "sphere_position")
        meshes.add_mesh(mesh, surface.name)
    if meshes.mesh_number():
        meshes.set_current_mesh(0)
    return meshes


def _map_of(mesh) -> SphereMap:
    texture = mesh.vertex_tex_coord_matrix() if mesh.has_vertex_tex_coord() else None
    return SphereMap(mesh.vertex_custom_point_attribute_matrix("sphere_position"), texture)


def _apply(meshes, name: str, **parameters):
    try:
        return meshes.apply_filter(name, **parameters)
    except Exception as error:  # pymeshlab.PyMeshLabException; its first line says only that the filter failed
        text = re.sub(r"^\s*Failed to apply filter:[^\n]*\n?(Details:)?\s*", "", str(error)).strip()
        raise PipelineError(text or str(error)) from error
