# SPDX-License-Identifier: GPL-3.0-only
"""A layer of another kind among the phases of a heart: it may come out as it will, but spoils no
other layer."""

import numpy as np
import pymeshlab
import pytest
from documents import PROPAGATE, REMESH, ROOT, add, landmark_layers
from environment import files_of

FOREIGN = 5


@pytest.fixture(scope="module")
def phases(plugin, measure):
    read = [measure.read_ply(file) for file in files_of("heart_truth/mc")[:8]]
    return [(measure.points(v), f) for v, f in read]


def organ(measure, name, like=None):
    """A surface of data/classic, as large as another one and where that is, or as it is."""
    vertex, f = measure.read_ply(next(file for file in files_of("classic") if file.stem == name))
    v = measure.points(vertex)
    if like is not None:
        v = (v - v.mean(0)) * np.linalg.norm(np.ptp(like, axis=0)) / np.linalg.norm(
            np.ptp(v, axis=0)
        ) + like.mean(0)
    return v, f


def project(shapes):
    ms = pymeshlab.MeshSet()
    for i, (v, f) in enumerate(shapes):
        add(ms, v, f, f"phase {i}")
    ms.set_current_mesh(0)
    ms.apply_filter(ROOT)
    return ms


def landmarks(ms):
    ms.apply_filter(REMESH)
    return [mesh.vertex_matrix() for mesh in landmark_layers(ms)]


@pytest.mark.parametrize("name", ["hippocampus", "maxplanck"])
def test_the_layers_behind_it_get_the_maps_that_they_get_without_it(phases, measure, name):
    sound = project(phases)
    sound.apply_filter(PROPAGATE)
    mixed = project(
        [*phases[:FOREIGN], organ(measure, name, phases[FOREIGN][0]), *phases[FOREIGN + 1 :]]
    )
    mixed.apply_filter(PROPAGATE)
    for i, (a, b) in enumerate(zip(landmarks(sound), landmarks(mixed))):
        if i != FOREIGN:
            # In mm; 25 to 48 where they were fitted from it.
            assert np.linalg.norm(a - b, axis=1).mean() < 3, i


def test_nothing_behind_it_is_reflected(phases, measure):
    ms = project([*phases[:4], organ(measure, "buddha"), *phases[5:7]])  # 80 times smaller
    assert not ms.apply_filter(PROPAGATE, mirror_layers=True)["mirrored"].any()
