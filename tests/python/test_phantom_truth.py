# SPDX-License-Identifier: GPL-3.0-only
"""The truth about the phantom in numpy: that of the plugin, and its own inverse."""

import numpy as np
import pymeshlab
import pytest
from sphere_propagation import filters, read_label_volume
from sphere_propagation.nifti import write_nifti
from sphere_propagation.phantom import TRUSTED, Ventricle


@pytest.mark.parametrize("part", filters.PARTS)
def test_the_truth_is_the_plugins(part):
    meshes = pymeshlab.MeshSet()
    meshes.apply_filter("create_ventricle_phantom", part=part, phases=5, seed=3, twist=12)
    truth = Ventricle(part, phases=5, seed=3, twist=12)
    for phase, mesh in enumerate(meshes):
        u, theta, m = mesh.vertex_custom_point_attribute_matrix("material_coordinate").T
        tissue = u < 0.93  # above are the lid and the cut
        away = np.linalg.norm(truth.position(u, theta, m, phase) - mesh.vertex_matrix(), axis=1)[
            tissue
        ]
        assert away.mean() < 0.3 and away.max() < 2.1  # a tenth of a voxel and one voxel of 2 mm


@pytest.mark.parametrize("part", filters.PARTS)
def test_material_points_are_found_again(part):
    truth = Ventricle(part, seed=1)
    u, theta = np.linspace(0.02, 0.9, 200), np.linspace(0, 40, 200)
    for m in truth.sheets:
        found = truth.material_points(truth.position(u, theta, m, 4), 4)
        assert found.distance.max() < 1e-6
        assert (
            np.abs(
                truth.position(found.u, found.theta, found.m, 9) - truth.position(u, theta, m, 9)
            ).max()
            < 1e-4
        )


def test_errors_are_zero_for_the_truth_itself():
    truth = Ventricle("Wall", phases=5)
    points = [
        truth.position(np.linspace(0.1, 0.9, 50), np.linspace(0, 6, 50), 1.0, phase)
        for phase in range(5)
    ]
    assert truth.errors(np.array(points), root=2).max() < 1e-4
    points[3] = points[3] + [0, 0, 0.5]
    assert truth.errors(np.array(points), root=2)[3] == pytest.approx(0.5, abs=1e-4)
    assert TRUSTED > 0.5


# ---------------------------------------------------------------- its scan


@pytest.mark.parametrize("seed", [0, 1])
def test_labels_are_what_the_surfaces_enclose(seed):
    truth = Ventricle(phases=4, seed=seed)
    labels, affine = truth.scan((1.0, 1.0, 1.0))
    assert (
        labels.shape[3] == 4
        and set(np.unique(labels)) == {0, 1, 2}
        and not labels[:, :, -1].any()
        and not labels[:, :, 0].any()
    )
    for phase, surface in enumerate(filters.make_phantom(phases=4, voxel_size=1.0, seed=seed)):
        indices = np.argwhere(labels[..., phase] == 1)
        assert len(indices) == pytest.approx(surface.volume, rel=0.03)
        assert (indices @ affine[:3, :3].T + affine[:3, 3]).mean(0) == pytest.approx(
            _center(surface), abs=0.5
        )
    wall = [(labels[..., phase] == 2).sum() for phase in range(4)]
    assert min(wall) > 30000


def _center(surface):
    a, b, c = (surface.vertices[surface.faces[:, k]] for k in range(3))
    volumes = np.einsum("ij,ij->i", a, np.cross(b, c))
    return ((a + b + c) / 4 * volumes[:, None]).sum(0) / volumes.sum()


@pytest.mark.parametrize("seed", range(4))
def test_slices_lie_where_few_come_and_go(seed):
    labels, affine = Ventricle(phases=10, seed=seed).scan()
    assert np.linalg.norm(affine[:3, :3], axis=0) == pytest.approx([1.4, 1.4, 10])
    slices = (labels == 1).any((0, 1))
    assert slices.sum(0).min() >= 4 and np.ptp(slices.sum(0)) <= 1


def test_a_scan_is_read_where_it_was_written(tmp_path):
    """By ITK: voxels, place and spacing, compressed or not."""
    truth = Ventricle(phases=2)
    labels, affine = truth.scan((1.5, 1.5, 1.5))
    for name in ("scan.nii.gz", "scan.nii"):
        write_nifti(tmp_path / name, labels, affine, 0.04)
        found = read_label_volume(tmp_path / name)
        assert found.figures["label_volume"] == pytest.approx(
            [(labels[..., k] == 1).sum() * 1.5**3 for k in range(2)]
        )
        for phase, surface in enumerate(found.surfaces):
            below = surface.vertices[surface.vertices[:, 2] < 5]  # the lid is no tissue
            assert truth.material_points(below, phase).distance.mean() < 0.5
    write_nifti(tmp_path / "one.nii", labels[..., 0], affine)
    assert len(read_label_volume(tmp_path / "one.nii").surfaces) == 1
