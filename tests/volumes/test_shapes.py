# SPDX-License-Identifier: GPL-3.0-only
"""Labels that no segmentation should have, and some have: every one comes out as a sphere, where it
lies."""

import numpy as np
import pytest
import volume_files as files
from test_import import imported, require_sphere, written


def points(n=40):
    """Of a grid of n^3 voxels, from -1 to 1."""
    return np.stack(np.meshgrid(*[np.linspace(-1, 1, n)] * 3, indexing="ij"), -1)


def tube(curve, radius, n=48):
    """The voxels within a radius of a curve of points."""
    x = points(n)
    return np.min([((x - p) ** 2).sum(-1) for p in curve], 0) < radius**2


def trefoil():
    t = np.linspace(0, 2 * np.pi, 160)
    return 0.26 * np.stack(
        [np.sin(t) + 2 * np.sin(2 * t), np.cos(t) - 2 * np.cos(2 * t), -np.sin(3 * t)], -1
    )


def ball(radius=0.7, n=40):
    return (points(n) ** 2).sum(-1) < radius**2


def tunnels():
    """A ball with three tunnels two voxels wide that cross in its middle."""
    labels = ball()
    labels[19:21, 19:21, :] = labels[19:21, :, 19:21] = labels[:, 19:21, 19:21] = False
    return labels


def handles_and_a_cavity():
    x = points()
    r = np.hypot(x[..., 0], x[..., 1])
    labels = ball(0.6)
    for height in (-0.45, 0, 0.45):  # rings round the ball that touch it on one side
        labels |= np.hypot(np.hypot(x[..., 0] - 0.3, x[..., 1]) - 0.5, x[..., 2] - height) < 0.1
    labels[(x[..., 2] ** 2 + r**2) < 0.05] = False
    return labels


def diagonals():
    """Two cubes that meet in an edge, and a third in a corner."""
    labels = np.zeros((30, 30, 30), bool)
    labels[5:12, 5:12, 5:12] = labels[12:19, 12:19, 5:12] = labels[19:26, 19:26, 12:19] = True
    return labels


def frame():
    """The edges of a cube: genus 5."""
    i = np.indices((24, 24, 24))
    near = (i < 6) | (i > 17)
    return (near.sum(0) >= 2) & (i > 1).all(0) & (i < 22).all(0)


SHAPES = {
    "torus": lambda: tube(
        0.6 * np.stack([np.cos(t := np.linspace(0, 6.3, 90)), np.sin(t), 0 * t], -1), 0.22
    ),
    "trefoil": lambda: tube(trefoil(), 0.13),
    "two linked rings": lambda: (
        tube(
            0.5 * np.stack([np.cos(t := np.linspace(0, 6.3, 90)) - 0.5, np.sin(t), 0 * t], -1), 0.14
        )
        | tube(0.5 * np.stack([np.cos(t) + 0.5, 0 * t, np.sin(t)], -1), 0.14)
    ),
    "tunnels": tunnels,
    "handles and a cavity": handles_and_a_cavity,
    "a shell": lambda: ball(0.8) & ~ball(0.6),
    "diagonals": diagonals,
    "frame": frame,
    "one voxel": lambda: np.pad(np.ones((1, 1, 1), bool), 3),
    "one slice": lambda: np.pad(np.ones((9, 7, 1), bool), [(2, 2), (2, 2), (3, 3)]),
    "a grid of one slice": lambda: np.pad(np.ones((9, 7), bool), 2)[..., None],
    "a needle": lambda: np.pad(np.ones((1, 1, 14), bool), 2),
    "all voxels": lambda: np.ones((8, 9, 7), bool),
    "at the border": lambda: ball()[12:, :, :],
    "a chessboard": lambda: np.indices((9, 9, 9)).sum(0) % 2 == 0,
    "noise": lambda: np.random.default_rng(3).random((18, 17, 16)) < 0.5,
}
GRIDS = {
    "cubes": np.eye(4),
    "thick slices, oblique, mirrored": np.array(
        [[0.0, 1.1, 3, 12], [1.2, 0, 0.4, -40], [0.1, -0.5, 5, 80], [0, 0, 0, 1]]
    ),
}


@pytest.mark.parametrize("grid", GRIDS)
@pytest.mark.parametrize("name", SHAPES)
def test_every_label_comes_out_as_a_sphere(tmp_path, name, grid):
    labels, matrix = SHAPES[name]().astype("u1"), GRIDS[grid]
    ms, returned = imported(written(tmp_path, "shape.nii", files.nifti(labels, matrix)))
    require_sphere(ms.mesh(0))
    corners = np.array(
        [
            matrix[:3, :3] @ (np.array(labels.shape) * c - 0.5) + matrix[:3, 3]
            for c in np.ndindex(2, 2, 2)
        ]
    )
    found = ms.mesh(0).vertex_matrix()
    assert (found > corners.min(0) - 1).all() and (found < corners.max(0) + 1).all()
    assert returned["label_volume"][0] == pytest.approx(
        labels.sum() * abs(np.linalg.det(matrix)), rel=1e-5
    )


@pytest.mark.parametrize(
    "name, handles",
    [
        ("torus", 1),
        ("trefoil", 1),
        ("two linked rings", 1),
        ("tunnels", 5),
        ("frame", 5),
        ("a shell", 0),
        ("diagonals", 0),
        ("at the border", 0),
    ],
)
def test_handles_are_counted(tmp_path, name, handles):
    """Of the largest part; three tunnels that meet are as many as their six mouths but one."""
    _, returned = imported(written(tmp_path, "shape.nii", files.nifti(SHAPES[name]().astype("u1"))))
    assert returned["handles"][0] == handles
