# SPDX-License-Identifier: GPL-3.0-only
"""Projects with a layer that is no surface: every filter leaves it out and says so, or is refused
in its name; what the others get is the same as without it."""

import functools

import numpy as np
import pymeshlab
import pytest
from documents import (
    FILTERS,
    PHANTOM,
    PREPARE,
    PROPAGATE,
    REMESH,
    ROOT,
    add,
    layers,
    mapped_cycle,
    refused,
)
from PIL import Image


def empty(ms, tmp_path):
    add(ms, 3 * np.eye(3), [[0, 1, 2]], "odd")
    ms.set_selection_all()
    ms.meshing_remove_selected_vertices()


def points(ms, tmp_path):
    add(ms, np.random.default_rng(0).normal(size=(50, 3)), np.zeros((0, 3)), "odd")


def edges(ms, tmp_path):
    lines = np.array([[0, 1], [1, 2]], np.int32)
    ms.add_mesh(pymeshlab.Mesh(vertex_matrix=3 * np.eye(3), edge_matrix=lines), "odd")


def hidden(ms, tmp_path):
    add(ms, 3 * np.eye(3), [[0, 1, 2]], "odd")
    ms.set_current_mesh_visibility(False)


def raster(ms, tmp_path):
    Image.new("RGB", (4, 3)).save(tmp_path / "raster.png")
    ms.load_new_raster(str(tmp_path / "raster.png"))


def shapes(ms):
    return [
        (m.label(), m.vertex_matrix(), m.face_matrix()) for m in layers(ms) if m.label() != "odd"
    ]


def project():
    ms = mapped_cycle(2)
    ms.apply_filter(REMESH, frequency=2)
    return ms


@functools.lru_cache(maxsize=None)
def shapes_without_it(name):
    ms = project()
    ms.set_current_mesh(0)
    ms.apply_filter(name)
    return shapes(ms)


@pytest.mark.parametrize("name", [name for name in FILTERS if name != PHANTOM])
@pytest.mark.parametrize("odd", [empty, points, edges, hidden, raster])
def test_a_layer_that_is_no_surface(name, odd, tmp_path):
    ms = project()
    odd(ms, tmp_path)
    ms.set_current_mesh(0)
    if name == PROPAGATE and odd in (empty, points, edges):
        with refused(ms, '"odd"'):
            ms.apply_filter(name)
        return
    ms.apply_filter(name)
    made = shapes(ms)
    expected = shapes_without_it(name)
    assert [label for label, _, _ in expected] == [label for label, _, _ in made]
    for (_, v, f), (_, w, g) in zip(expected, made):
        assert np.array_equal(v, w) and np.array_equal(f, g)


@pytest.mark.parametrize("name", [PREPARE, ROOT])
@pytest.mark.parametrize("odd", [empty, points, edges])
def test_it_cannot_be_the_layer_that_is_worked_on(name, odd, tmp_path):
    ms = mapped_cycle(1)
    odd(ms, tmp_path)
    with refused(ms, '"odd"'):
        ms.apply_filter(name)
