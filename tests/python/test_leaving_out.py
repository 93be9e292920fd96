# SPDX-License-Identifier: GPL-3.0-only
"""Generalisation with correspondence that is built anew without each shape."""

import numpy as np
import pytest
import sphere_propagation as sp
from scipy.spatial.transform import Rotation


@pytest.fixture(scope="module")
def eggs():
    """Of one mode, and their landmarks as they are."""
    base = sp.make_phantom(phases=1, voxel_size=4)[0]
    v, f = base.vertices - base.vertices.mean(0), base.faces
    shapes = [
        sp.Surface(v * [1 + a, 1 - a, 1], f, f"egg {k}")
        for k, a in enumerate(np.linspace(-0.2, 0.2, 5))
    ]
    return shapes, sp.parameterise_root(shapes[0])


def landmarks_of(surfaces, sphere, turns=0.0):
    """By one map for all, or each turned by as much more than the one before."""
    axis = np.array([0.3, 0.8, 0.5])
    maps = [
        Rotation.from_rotvec(turns * (k % 3) * axis).apply(sphere.positions)
        for k in range(len(surfaces))
    ]
    return sp.remesh(surfaces, maps, frequency=5)


def test_shapes_that_took_no_part_are_shown_where_correspondence_is_right(eggs):
    shapes, sphere = eggs
    seen = []

    def build(others):
        seen.append([shape.name for shape in others])
        return landmarks_of(others, sphere)

    right = sp.rebuilt_generalisation(shapes, [1, 2], build=build)
    assert seen == [[f"egg {i}" for i in range(5) if i != k] for k in range(5)]
    assert right.distances.shape == (5, 2) and right.modes == [1, 2]
    assert right.generalisation == pytest.approx(right.distances.mean(0))
    assert (right.generalisation_error >= 0).all() and "5 shapes" in repr(right)
    wrong = sp.rebuilt_generalisation(
        shapes, build=lambda others: landmarks_of(others, sphere, turns=0.4)
    )
    size = np.abs(shapes[0].vertices).max()
    assert right.generalisation[0] < 0.03 * size
    assert wrong.generalisation[0] > 1.3 * right.generalisation[0]


def test_it_is_built_by_correspond_unless_told_otherwise(eggs):
    found = sp.rebuilt_generalisation(eggs[0][:4], modes=1, pose="search")
    assert found.distances.shape == (4, 1) and (found.distances > 0).all()


def test_what_cannot_be_rebuilt_is_refused(eggs):
    shapes, sphere = eggs
    with pytest.raises(sp.InputError, match="4 to 20 surfaces, not of 3"):
        sp.rebuilt_generalisation(shapes[:3])
    with pytest.raises(sp.InputError, match="not of 25"):
        sp.rebuilt_generalisation(shapes * 5)
    for modes in (0, 4, [], [1, 9]):
        with pytest.raises(sp.InputError, match="between 1 and 3"):
            sp.rebuilt_generalisation(shapes, modes)
    with pytest.raises(sp.InputError, match="pose"):
        sp.rebuilt_generalisation(shapes, pose="Anchors")
    with pytest.raises(sp.InputError, match="build must be a function"):
        sp.rebuilt_generalisation(shapes, build=3)
    with pytest.raises(sp.InputError, match="build must return"):
        sp.rebuilt_generalisation(shapes, build=lambda others: 3)
    with pytest.raises(sp.InputError, match="landmarks of 5 of 4 surfaces"):
        sp.rebuilt_generalisation(shapes, build=lambda others: landmarks_of(shapes, sphere))
