# SPDX-License-Identifier: GPL-3.0-only
"""Small helpers on PyMeshLab documents: the filters' names, layers, and snapshots that can be
compared."""

import contextlib
import hashlib
import xml.etree.ElementTree as xml
from xml.sax.saxutils import quoteattr

import numpy as np
import pymeshlab
import pytest

PHANTOM = "create_ventricle_phantom"
ROOT = "compute_spherical_parameterisation_root"
LOAD = "load_anchors_to_layers"
PROPAGATE = "transfer_spherical_parameterisation_to_layers"
GROUPWISE = "compute_spherical_parameterisation_groupwise"
REMESH = "generate_icosphere_remeshing"
EVALUATE = "get_spherical_parameterisation_measures"
SPHERES = "generate_sphere_layers"
COLOR = "compute_color_from_spherical_parameterisation_per_vertex"
PREPARE = "apply_surface_preparation"
MODEL = "compute_statistical_shape_model"
MORPH = "generate_morph"
LAYOUT = "apply_layers_side_by_side"
FIT = "compute_shape_model_fit"  # needs a file, so it is none of those that run as they come
FILTERS = [
    PHANTOM,
    PREPARE,
    ROOT,
    LOAD,
    PROPAGATE,
    GROUPWISE,
    REMESH,
    EVALUATE,
    SPHERES,
    MODEL,
    COLOR,
    MORPH,
    LAYOUT,
]

MENU_OF = {
    PHANTOM: "Beating ventricle phantom",
    PREPARE: "Prepare surface",
    ROOT: "Spherical parameterise root",
    LOAD: "Load anchors",
    PROPAGATE: "Propagate parameterisation to layers",
    GROUPWISE: "Optimise parameterisations groupwise",
    REMESH: "Remesh by icosphere",
    EVALUATE: "Evaluate spherical parameterisation",
    SPHERES: "Show parameterisation as sphere layers",
    COLOR: "Colour by spherical parameterisation",
    MODEL: "Build statistical shape model",
    MORPH: "Morph between layers",
    LAYOUT: "Lay layers side by side",
}

ATTRIBUTE = "sphere_position"
FIGURES = ["flipped_faces", "area_ratio_sd", "area_log_mean", "angle_error_mean", "seconds"]


def add(ms, vertices, faces, label, **more):
    """Adds a layer, makes it the current one and returns its number. `more`: what pymeshlab.Mesh
    takes besides."""
    mesh = pymeshlab.Mesh(
        np.asarray(vertices, float).reshape(-1, 3),
        np.asarray(faces, np.int32).reshape(-1, 3),
        **more,
    )
    ms.add_mesh(mesh, label)
    return ms.current_mesh_id()


def layers(ms):
    return list(ms)


def layer(ms, label):
    found = [m for m in ms if m.label() == label]
    assert len(found) == 1, f"{len(found)} layers are called {label!r}: {labels(ms)}"
    return found[0]


def labels(ms):
    return [m.label() for m in ms]


def landmark_layers(ms):
    return [m for m in ms if m.label().endswith(" landmarks")]


def positions(mesh):
    """The map stored on a layer as attribute (n x 3)."""
    return mesh.vertex_custom_point_attribute_matrix(ATTRIBUTE)


def has_attribute(mesh, name=ATTRIBUTE):
    try:
        mesh.vertex_custom_point_attribute_matrix(name)
    except pymeshlab.PyMeshLabException:
        return False
    return True


def texture_positions(mesh):
    """The map stored on a layer as texture coordinates: u = longitude / 2 pi, v = colatitude /
    pi."""
    uv = mesh.vertex_tex_coord_matrix()
    longitude, colatitude = 2 * np.pi * uv[:, 0], np.pi * uv[:, 1]
    return np.stack(
        [
            np.sin(colatitude) * np.cos(longitude),
            np.sin(colatitude) * np.sin(longitude),
            np.cos(colatitude),
        ],
        1,
    )


# ---------------------------------------------------------------- small projects


def small_cycle(phases=4, **more):
    """A project with a coarse phantom, a few hundred vertices per layer; phase 0 is the current
    layer, number 0."""
    ms = pymeshlab.MeshSet()
    ms.apply_filter(PHANTOM, phases=phases, voxel_size=4.0, **more)
    return ms


def mapped_cycle(phases=4, **more):
    """The same, every layer with a map; the root is layer 0."""
    ms = small_cycle(phases, **more)
    ms.apply_filter(ROOT)
    if phases > 1:
        ms.apply_filter(PROPAGATE, order="Cyclic time")
    return ms


# ---------------------------------------------------------------- snapshots

# PyMeshLab cannot list custom attributes, so these are asked for by name.
POINT_ATTRIBUTES = [ATTRIBUTE, "material_coordinate", "of_the_user"]
SCALAR_ATTRIBUTES = ["number_of_the_user", "sphere_root", "sphere_map"]


def digest(array):
    array = np.ascontiguousarray(array)
    return array.dtype.str, array.shape, hashlib.sha256(array.tobytes()).hexdigest()[:16]


def content(mesh):
    """Everything a layer holds, name -> value, bit for bit."""
    held = {
        "id": mesh.id(),
        "label": mesh.label(),
        "visible": mesh.is_visible(),
        "matrix": digest(mesh.transform_matrix()),
        "vertices": digest(mesh.vertex_matrix()),
        "faces": digest(mesh.face_matrix()),
        "edges": digest(mesh.edge_matrix()),
        "vertex normals": digest(mesh.vertex_normal_matrix()),
        "face normals": digest(mesh.face_normal_matrix()),
        "selected vertices": digest(mesh.vertex_selection_array()),
        "selected faces": digest(mesh.face_selection_array()),
        "box": digest([mesh.bounding_box().min(), mesh.bounding_box().max()]),
    }
    components = {
        "vertex colours": (mesh.has_vertex_color, mesh.vertex_color_matrix),
        "face colours": (mesh.has_face_color, mesh.face_color_matrix),
        "vertex quality": (mesh.has_vertex_scalar, mesh.vertex_scalar_array),
        "face quality": (mesh.has_face_scalar, mesh.face_scalar_array),
        "texture coordinates": (mesh.has_vertex_tex_coord, mesh.vertex_tex_coord_matrix),
        "wedge texture coordinates": (mesh.has_wedge_tex_coord, mesh.wedge_tex_coord_matrix),
    }
    for name, (has, read) in components.items():
        held[name] = digest(read()) if has() else None
    attributes = [(name, mesh.vertex_custom_point_attribute_matrix) for name in POINT_ATTRIBUTES]
    attributes += [(name, mesh.vertex_custom_scalar_attribute_array) for name in SCALAR_ATTRIBUTES]
    for name, read in attributes:
        try:
            held["attribute " + name] = digest(read(name))
        except pymeshlab.PyMeshLabException:
            held["attribute " + name] = None
    return held


def snapshot(ms):
    """Everything a project holds. Two snapshots are equal when the projects are the same, bit for
    bit."""
    current = ms.current_mesh_id() if ms.mesh_number() > 0 else None
    return {"current": current, "layers": [content(m) for m in ms]}


# ---------------------------------------------------------------- failures


# PyMeshLab goes on writing into the log of a MeshSet in which a filter failed, so these are kept
failed = []


@contextlib.contextmanager
def refused(ms, *words):
    """The block must raise PyMeshLab's own exception, whose text contains `words`, and leave the
    project as it was."""
    failed.append(ms)
    before = snapshot(ms)
    with pytest.raises(pymeshlab.PyMeshLabException) as caught:
        yield caught
    assert caught.type is pymeshlab.PyMeshLabException
    assert snapshot(ms) == before
    for word in words:
        assert word in str(caught.value)


# ------------------------------------------------ filter scripts, which speak the menu's names


def written_script(ms, path):
    """The filters applied so far: list of (menu name, {parameter: XML attributes})."""
    ms.save_filter_script(str(path))
    filters = xml.parse(path).getroot().findall("filter")
    return [(f.get("name"), {p.get("name"): p.attrib for p in f}) for f in filters]


def apply_by_menu_name(ms, path, name, **texts):
    """Applies a filter as MeshLab's menu calls it, with text parameters if any. Throws where there
    is no such filter."""
    parameters = "".join(
        f'<Param type="RichString" name={quoteattr(k)} value={quoteattr(v)}/>'
        for k, v in texts.items()
    )
    path.write_text(
        "<!DOCTYPE FilterScript>\n<FilterScript><filter "
        f"name={quoteattr(name)}>{parameters}</filter></FilterScript>\n"
    )
    ms.clear_filter_script()
    ms.load_filter_script(str(path))
    ms.apply_filter_script()
    ms.clear_filter_script()
