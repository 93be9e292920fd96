"""The truth about the phantom in numpy: that of the plugin, and its own inverse."""
import numpy as np
import pymeshlab
import pytest

from sphere_propagation import filters
from sphere_propagation.phantom import TRUSTED, Ventricle


@pytest.mark.parametrize("part", filters.PARTS)
def test_the_truth_is_the_plugins(part):
    meshes = pymeshlab.MeshSet()
    meshes.apply_filter("create_ventricle_phantom", part=part, phases=5, seed=3, twist=12)
    truth = Ventricle(part, phases=5, seed=3, twist=12)
    for phase, mesh in enumerate(meshes):
        u, theta, m = mesh.vertex_custom_point_attribute_matrix("material_coordinate").T
        tissue = u < 0.93  # above are the lid and the cut
        away = np.linalg.norm(truth.position(u, theta, m, phase) - mesh.vertex_matrix(), axis=1)[tissue]
        assert away.mean() < 0.3 and away.max() < 2.1  # a tenth of a voxel and one voxel of 2 mm


@pytest.mark.parametrize("part", filters.PARTS)
def test_material_points_are_found_again(part):
    truth = Ventricle(part, seed=1)
    u, theta = np.linspace(0.02, 0.9, 200), np.linspace(0, 40, 200)
    for m in truth.sheets:
        found = truth.material_points(truth.position(u, theta, m, 4), 4)
        assert found.distance.max() < 1e-6
        assert np.abs(truth.position(found.u, found.theta, found.m, 9) - truth.position(u, theta, m, 9)).max() < 1e-4


def test_errors_are_zero_for_the_truth_itself():
    truth = Ventricle("Wall", phases=5)
    points = [truth.position(np.linspace(0.1, 0.9, 50), np.linspace(0, 6, 50), 1.0, phase) for phase in range(5)]
    assert truth.errors(np.array(points), root=2).max() < 1e-4
    points[3] = points[3] + [0, 0, 0.5]
    assert truth.errors(np.array(points), root=2)[3] == pytest.approx(0.5, abs=1e-4)
    assert TRUSTED > 0.5
