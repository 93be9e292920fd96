# SPDX-License-Identifier: GPL-3.0-only
"""Surfaces that are refused: the advice is for arrays, and following it helps."""

import numpy as np
import pymeshlab
import pytest
import sphere_propagation as sp


def egg():
    """A closed surface, not in order of anything."""
    surface = sp.make_phantom(phases=1, voxel_size=4.0)[0]
    return surface.vertices.copy(), surface.faces.copy()


def refusal(vertices, faces):
    with pytest.raises(sp.FilterError) as refused:
        sp.parameterise_root(sp.Surface(vertices, faces, "my heart"))
    text = str(refused.value)
    assert text.startswith('Surface "my heart": ') and "layer" not in text and "Filters" not in text
    assert 'Layer "my heart": ' in str(refused.value.__cause__)  # what PyMeshLab's users read
    return text


def advised(text, name, **values):
    """The value of an expression that stands in the text."""
    start = text.index(name)
    end = max(end for end in range(start, len(text) + 1) if _compiles(text[start:end]))
    return eval(text[start:end], {"np": np, **values})


def _compiles(code):
    try:
        compile(code, "advice", "eval")
    except SyntaxError:
        return False
    return True


def taken(vertices, faces):
    return len(sp.parameterise_root(sp.Surface(vertices, faces)).positions) == len(vertices)


def test_inward_faces():
    vertices, faces = egg()
    faces = faces[:, ::-1]
    text = refusal(vertices, faces)
    assert text == (
        'Surface "my heart": its faces are oriented inwards. Turn them round: faces[:, ::-1].'
    )
    assert taken(vertices, advised(text, "faces[", faces=faces))


def test_vertices_that_are_there_several_times():
    vertices, faces = egg()
    vertices, faces = vertices[faces.ravel()], np.arange(faces.size).reshape(-1, 3)
    text = refusal(vertices, faces)
    assert "vertices lie exactly where another one lies: unify them by" in text
    unified, index = advised(text, "np.unique(", vertices=vertices)
    assert taken(unified, advised(text, "index.reshape", index=index, faces=faces))


def test_vertices_in_no_face():
    vertices, faces = egg()
    vertices, faces = np.vstack([[[0, 0, 0]], vertices]), faces + 1
    text = refusal(vertices, faces)
    used, index = advised(text, "np.unique(", faces=faces)
    assert taken(vertices[used], advised(text, "index.reshape", index=index))


def test_faces_that_use_a_vertex_twice():
    vertices, faces = egg()
    text = refusal(vertices, np.vstack([faces, [[0, 1, 1]]]))
    faces = advised(text, "faces[(", faces=np.vstack([faces, [[0, 1, 1]]]))
    assert taken(vertices, faces)


def test_vertices_that_are_not_finite():
    vertices, faces = egg()
    vertices[[3, 8]] = np.nan
    text = refusal(vertices, faces)
    assert list(np.flatnonzero(advised(text, "~np", vertices=vertices))) == [3, 8]


def test_an_opening():
    """meshing_close_holes closes those of fewer edges than its maxholesize."""
    vertices, faces = egg()
    apex = faces[0, 0]
    rim = int((faces == apex).any(axis=1).sum())
    faces = faces[(faces != apex).all(axis=1)]
    used, index = np.unique(faces, return_inverse=True)
    vertices, faces = vertices[used], index.reshape(-1, 3)
    text = refusal(vertices, faces)
    assert f"1 opening, the largest of {rim} edges" in text
    prepared = advised(text, "sp.prepare(surface)", sp=sp, surface=(vertices, faces)).surface
    assert taken(prepared.vertices, prepared.faces)
    assert "with a maxholesize above that number of edges" in text
    meshes = pymeshlab.MeshSet()
    meshes.add_mesh(pymeshlab.Mesh(vertices, faces))
    meshes.meshing_close_holes(maxholesize=rim + 1)
    assert taken(meshes.current_mesh().vertex_matrix(), meshes.current_mesh().face_matrix())
