# SPDX-License-Identifier: GPL-3.0-only
"""mirror_layers of the propagation: layers that are mirror images of the others are reflected
before they get their map."""

import json

import filter_log
import numpy as np
import pymeshlab
import pytest
from documents import (
    EVALUATE,
    PROPAGATE,
    REMESH,
    ROOT,
    add,
    content,
    landmark_layers,
    layer,
    positions,
    refused,
    snapshot,
)
from environment import DATA, files_of, require
from surfaces import egg


def lopsided(phase, turn=0):
    """A shape without any plane of symmetry, which shrinks a little from phase to phase."""
    v, f = egg(14, 20, radii=(40, 30, 22))
    d = v / np.linalg.norm(v, axis=1, keepdims=True)
    bump = (
        1
        + 0.5 * np.exp(-4 * ((d - [0.6, 0.64, 0.48]) ** 2).sum(1))
        + 0.4 * np.exp(-6 * ((d - [-0.48, 0.6, 0.64]) ** 2).sum(1))
    )
    return v * bump[:, None] * (1 - 0.02 * phase) + [5, 6, 7], f


def centroid(v, f):
    corners = v[f]
    areas = np.linalg.norm(
        np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1
    )
    return (corners.mean(1) * areas[:, None]).sum(0) / areas.sum()


def mirrored(v, f, plane=None):
    """Across x = plane; through the centroid where none is given."""
    plane = centroid(v, f)[0] if plane is None else plane
    return np.stack([2 * plane - v[:, 0], v[:, 1], v[:, 2]], 1), f[:, [0, 2, 1]]


def project(shapes, **more):
    ms = pymeshlab.MeshSet()
    for i, (v, f) in enumerate(shapes):
        add(ms, v, f, f"shape {i}", **more)
    ms.set_current_mesh(0)
    ms.apply_filter(ROOT)
    return ms


def hearts():
    ms = pymeshlab.MeshSet()
    for path in files_of("heart_truth/mc")[::4]:
        ms.load_new_mesh(str(path))
    return [(m.vertex_matrix(), m.face_matrix()) for m in ms]


def landmarks(ms):
    ms.apply_filter(REMESH)
    return [m.vertex_matrix() for m in landmark_layers(ms)]


def volume(v, f):
    a, b, c = (v[f[:, k]] - v.mean(0) for k in range(3))
    return np.einsum("ij,ij->", a, np.cross(b, c)) / 6


def test_a_mirrored_heart_among_others_is_as_if_it_never_was():
    shapes = hearts()
    plain = project(shapes)
    assert not plain.apply_filter(PROPAGATE, order="Cyclic time", mirror_layers=True)[
        "mirrored"
    ].any()
    expected = landmarks(plain)
    ms = project([mirrored(*s) if i in (2, 5) else s for i, s in enumerate(shapes)])
    figures = ms.apply_filter(PROPAGATE, order="Cyclic time", mirror_layers=True)
    assert np.flatnonzero(figures["mirrored"]).tolist() == [2, 5]
    assert np.abs(ms.mesh(2).vertex_matrix() - shapes[2][0]).max() < 1e-10
    assert volume(ms.mesh(2).vertex_matrix(), ms.mesh(2).face_matrix()) > 0
    normals = ms.mesh(2).vertex_normal_matrix(), plain.mesh(2).vertex_normal_matrix()
    assert np.abs(normals[0] - normals[1]).max() < 1e-6
    evaluated = ms.apply_filter(EVALUATE)
    assert (
        evaluated["valid"].all()
        and np.abs(evaluated["degree"] - 1).max() < 1e-9
        and not evaluated["flipped_faces"].any()
    )
    for found, wanted in zip(landmarks(ms), expected):
        assert np.linalg.norm(found - wanted, axis=1).mean() < 0.05


def test_a_heart_that_was_turned_is_no_mirror_image():
    """Nearly round about its long axis, it is hard to turn back."""
    shapes = hearts()[:6]
    v, f = shapes[2]
    for axis in np.eye(3):
        for degrees in (60, 120, 180):
            a = np.radians(degrees)
            cross = np.cross(np.eye(3), axis)
            turn = np.eye(3) + np.sin(a) * cross + (1 - np.cos(a)) * cross @ cross
            turned = (v - v.mean(0)) @ turn.T + v.mean(0)
            ms = project([*shapes[:2], (turned, f), *shapes[3:]])
            figures = ms.apply_filter(PROPAGATE, order="Cyclic time", mirror_layers=True)
            assert not figures["mirrored"].any(), (axis, degrees)


def test_a_mirrored_heart_elsewhere_is_mirrored_and_its_pose_found():
    """The landmarks are the mirror images of those of the original, but for the pose, which is
    aligned instead of known."""
    shapes = hearts()
    plain = project(shapes)
    plain.apply_filter(PROPAGATE, order="Cyclic time")
    expected = landmarks(plain)[2]
    ms = project([mirrored(*s, plane=0) if i == 2 else s for i, s in enumerate(shapes)])
    assert np.flatnonzero(
        ms.apply_filter(PROPAGATE, order="Cyclic time", mirror_layers=True)["mirrored"]
    ).tolist() == [2]
    difference = landmarks(ms)[2] - expected
    # They differ by a shift, and little else: landmarks lie 3 mm apart.
    assert np.ptp(difference[:, 0]) < 4
    assert np.linalg.norm(difference - difference.mean(0), axis=1).mean() < 1.5


@pytest.mark.parametrize("method", ["Robust", "As published"])
@pytest.mark.parametrize("order", ["Time", "Cyclic time", "Similarity tree", "Star"])
def test_every_order_and_method(method, order):
    ms = project([mirrored(*lopsided(t)) if t in (1, 3) else lopsided(t) for t in range(5)])
    figures = ms.apply_filter(PROPAGATE, order=order, method=method, mirror_layers=True)
    assert figures["mirrored"].tolist() == [0, 1, 0, 1, 0]
    assert not figures["flipped_faces"].any()
    for t in range(5):
        assert np.abs(ms.mesh(t).vertex_matrix() - lopsided(t)[0]).max() < 1e-10


def test_without_the_option_surfaces_stay():
    shapes = [lopsided(0), mirrored(*lopsided(1)), lopsided(2)]
    ms = project(shapes)
    before = [content(m) for m in ms]
    assert not ms.apply_filter(PROPAGATE)["mirrored"].any()
    for m, was in zip(ms, before):
        now = content(m)
        assert all(
            now[name] == was[name]
            for name in ("vertices", "faces", "vertex normals", "face normals", "matrix")
        )


def test_a_second_run_finds_nothing_to_mirror():
    ms = project([lopsided(0), mirrored(*lopsided(1)), lopsided(2)])
    assert ms.apply_filter(PROPAGATE, mirror_layers=True)["mirrored"].tolist() == [0, 1, 0]
    before = snapshot(ms)
    assert not ms.apply_filter(PROPAGATE, mirror_layers=True)["mirrored"].any()
    assert snapshot(ms) == before


MATRICES = {
    "turned and moved": np.array([[0, -1, 0, 10], [1, 0, 0, -4], [0, 0, 1, 3], [0, 0, 0, 1.0]]),
    "one that mirrors": np.diag([1.0, -1, 1, 1]),
    "stretched": np.array([[2, 0.3, 0, 1], [0, 1, 0, 2], [0, 0, 3, 3], [0, 0, 0, 1.0]]),
}


@pytest.mark.parametrize("matrix", list(MATRICES.values()), ids=list(MATRICES))
def test_what_is_seen_is_mirrored_and_the_matrix_stays(matrix):
    """A layer that is seen as a mirror image, through its matrix."""
    seen, faces = mirrored(*lopsided(1))
    stored = (seen - matrix[:3, 3]) @ np.linalg.inv(matrix[:3, :3]).T
    if np.linalg.det(matrix[:3, :3]) < 0:  # faces are stored so that the stored mesh is outward
        faces = faces[:, [0, 2, 1]]
    ms = project([lopsided(0), (stored, faces), lopsided(2)])
    ms.set_current_mesh(1)
    # freeze=False keeps the matrix beside the vertices
    ms.apply_filter("set_matrix", transformmatrix=matrix, freeze=False)
    ms.set_current_mesh(0)
    assert ms.apply_filter(PROPAGATE, mirror_layers=True)["mirrored"].tolist() == [0, 1, 0]
    assert np.abs(ms.mesh(1).transform_matrix() - matrix).max() < 1e-12
    now = ms.mesh(1).vertex_matrix() @ matrix[:3, :3].T + matrix[:3, 3]
    assert np.abs(now - lopsided(1)[0]).max() < 1e-9
    assert volume(ms.mesh(1).vertex_matrix(), ms.mesh(1).face_matrix()) > 0
    assert ms.apply_filter(EVALUATE)["valid"].all()


def test_what_belongs_to_vertices_and_corners_stays_with_them():
    v, f = mirrored(*lopsided(1))
    corners = np.random.default_rng(0).random((3 * len(f), 2))
    colors = np.random.default_rng(1).random((len(v), 4))
    ms = pymeshlab.MeshSet()
    add(ms, *lopsided(0), "right")
    add(ms, v, f, "left", w_tex_coords_matrix=corners, v_color_matrix=colors)
    left = layer(ms, "left")
    left.add_vertex_custom_scalar_attribute(np.arange(len(v), dtype=float), "number")
    colors = left.vertex_color_matrix()

    def corner_texture(mesh):
        """{(face, vertex): texture coordinates}"""
        texture, faces = mesh.wedge_tex_coord_matrix().reshape(-1, 3, 2), mesh.face_matrix()
        return {
            (i, int(faces[i, k])): tuple(texture[i, k]) for i in range(len(faces)) for k in range(3)
        }

    before = corner_texture(left)
    ms.set_current_mesh(0)
    ms.apply_filter(ROOT)
    ms.apply_filter(PROPAGATE, mirror_layers=True)
    left = layer(ms, "left")
    assert corner_texture(left) == before
    assert np.array_equal(left.vertex_color_matrix(), colors)
    assert np.array_equal(left.vertex_custom_scalar_attribute_array("number"), np.arange(len(v)))
    assert len(positions(left)) == len(v)


def phantoms(part, phases, voxel_size, mirror=(), plane=0):
    """A phantom's cycle with some phases reflected across x = plane, that is, elsewhere."""
    ms = pymeshlab.MeshSet()
    ms.apply_filter("create_ventricle_phantom", phases=phases, voxel_size=voxel_size, part=part)
    shapes = [(m.vertex_matrix(), m.face_matrix()) for m in ms]
    return project([mirrored(*s, plane) if i in mirror else s for i, s in enumerate(shapes)])


def named(returned):
    """Of warnings about sides: what and of which layer."""
    if "warnings" not in returned:
        return []
    remarks = json.loads(bytes(map(int, returned["warnings"])).decode())
    return [
        (r["message"], r["layer"])
        for r in remarks
        if r["message"] in ("mirrorImage", "mirroredRoot", "sidesDiffer")
    ]


@pytest.mark.parametrize(
    "part, phases, order, mirror",
    [
        ("Wall", 8, "Time", [2]),
        ("Wall", 8, "Star", []),
        ("Wall", 12, "Similarity tree", [2]),
        ("Wall", 12, "Cyclic time", [2, 7]),
        ("Wall", 25, "Time", [2]),
        ("Cavity", 6, "Time", [2]),
        ("Cavity", 6, "Star", [2]),
        ("Cavity", 8, "Similarity tree", []),
    ],
)
def test_phantoms_that_are_nearly_their_own_mirror_images(part, phases, order, mirror):
    """Without the option exactly those are named that are reflected with it; some pairs of phases
    say nothing, and others tell."""
    ms = phantoms(part, phases, 3 if part == "Cavity" else 4, mirror)
    expected = [("mirrorImage", f"shape {i}") for i in mirror]
    assert named(ms.apply_filter(PROPAGATE, order=order)) == expected
    figures = ms.apply_filter(PROPAGATE, order=order, mirror_layers=True)
    assert np.flatnonzero(figures["mirrored"]).tolist() == mirror
    assert named(figures) == []
    assert named(ms.apply_filter(PROPAGATE, order=order)) == []


def subjects(part, seeds, mirror=()):
    """Ventricles of different subjects, each with an asymmetry of its own."""
    shapes = []
    for seed in seeds:
        ms = pymeshlab.MeshSet()
        voxel_size = 3 if part == "Cavity" else 4
        ms.apply_filter(
            "create_ventricle_phantom", phases=1, voxel_size=voxel_size, part=part, seed=seed
        )
        shapes.append((ms.mesh(0).vertex_matrix(), ms.mesh(0).face_matrix()))
    return project([mirrored(*s) if i in mirror else s for i, s in enumerate(shapes)])


@pytest.mark.parametrize("part", ["Cavity", "Wall"])
@pytest.mark.parametrize("first", [0, 16, 72])
@pytest.mark.parametrize("mirror", [[], [3]])
def test_ventricles_of_different_subjects_have_no_side(part, first, mirror):
    """Seen from any of them about half of the others look mirrored: nobody can tell."""
    ms = subjects(part, range(first, first + 8), mirror)
    assert named(ms.apply_filter(PROPAGATE, order="Star")) == []
    assert not ms.apply_filter(PROPAGATE, order="Star", mirror_layers=True)["mirrored"].any()


@pytest.mark.parametrize("mirror", [[], [3], [2, 5]])
@pytest.mark.parametrize("seed", [0, 1])
def test_of_different_subjects_with_a_side_the_mirrored_are_named(seed, mirror):
    ms = pymeshlab.MeshSet()
    ms.load_new_mesh(str(require(DATA / "classic/hippocampus.ply")))
    v, f = ms.mesh(0).vertex_matrix(), ms.mesh(0).face_matrix()
    random = np.random.default_rng(seed)
    x = (v - v.mean(0)) / np.sqrt(((v - v.mean(0)) ** 2).sum(1).mean())
    waves = [(random.normal(size=3), random.normal(size=3), 6 * random.random()) for _ in range(4)]
    shapes = []
    for i in range(8):
        warp = sum(
            random.normal() * np.sin(1.6 * x @ wave + shift)[:, None] * way
            for wave, way, shift in waves
        )
        warp *= 0.15 * np.ptp(v) / 5 / np.sqrt((warp**2).sum(1).mean())
        shapes.append(mirrored(v + warp, f) if i in mirror else (v + warp, f))
    ms = project(shapes)
    expected = [("mirrorImage", f"shape {i}") for i in mirror]
    assert named(ms.apply_filter(PROPAGATE, order="Star")) == expected


def test_a_root_that_is_the_odd_one_is_said_to_be():
    ms = project([mirrored(*lopsided(t)) if t == 0 else lopsided(t) for t in range(4)])
    figures = ms.apply_filter(PROPAGATE, method="As published")
    assert named(figures) == [("mirroredRoot", "shape 0")]


def test_where_half_are_mirrored_and_the_root_does_not_tell_nothing_is_reflected():
    ms = phantoms("Wall", 12, 4, range(1, 12, 2))
    figures = ms.apply_filter(PROPAGATE, mirror_layers=True)
    assert not figures["mirrored"].any()
    assert named(figures) == [("sidesDiffer", "")]


@pytest.mark.parametrize("mirrors", [False, True])
def test_beside_mirrored_layers_those_are_named_of_which_nobody_can_tell(mirrors):
    symmetric = egg(14, 20, radii=(40, 30, 22))
    for odd in ([2], []):
        shapes = [mirrored(*lopsided(t)) if t in odd else lopsided(t) for t in range(4)]
        figures = project([*shapes, symmetric]).apply_filter(PROPAGATE, mirror_layers=mirrors)
        remarks = json.loads(bytes(map(int, figures.get("warnings", b"[]"))).decode())
        named = [r["text"] for r in remarks if r["message"] == "sidesNotKnown"]
        assert ['of "shape 4" nobody can tell' in text for text in named] == [True] * len(odd)


@pytest.mark.parametrize("mirrors", [False, True])
def test_where_none_is_mirrored_the_log_says_of_which_nobody_can_tell(mirrors):
    said = filter_log.lines_of(
        "from surfaces import egg\n"
        "from test_mirroring import lopsided\n"
        "shapes = [lopsided(0), lopsided(1), lopsided(2), egg(14, 20, radii=(40, 30, 22))]\n"
        "for i, (v, f) in enumerate(shapes):\n"
        "    add(ms, v, f, f'shape {i}')\n"
        "ms.set_current_mesh(0)\n"
        "ms.apply_filter(ROOT)\n"
        f"ms.apply_filter(PROPAGATE, mirror_layers={mirrors})\n"
    )
    assert sum('of "shape 3" nobody can tell whether' in line for line in said) == 1


def test_a_refused_run_mirrors_nothing():
    ms = project([lopsided(0), mirrored(*lopsided(1)), lopsided(2)])
    with refused(ms, "area restoration must lie between 0 and 1"):
        ms.apply_filter(PROPAGATE, mirror_layers=True, area_restoration=2.0)


@pytest.mark.parametrize("order", ["Similarity tree", "Star"])
def test_skulls_are_their_own_mirror_images(order):
    """A mirrored finch skull fits the others as well as it did: nothing has to be mirrored."""
    ms = pymeshlab.MeshSet()
    for path in files_of("finch_skulls")[:4]:
        ms.load_new_mesh(str(path))
    shapes = [(m.vertex_matrix(), m.face_matrix()) for m in ms]
    residuals = []
    for which in ([], [2]):
        ms = project([mirrored(*s) if i in which else s for i, s in enumerate(shapes)])
        figures = ms.apply_filter(PROPAGATE, order=order, mirror_layers=True)
        assert not figures["mirrored"].any() and not figures["flipped_faces"].any()
        residuals.append(figures["residual_mean"][2])
    assert residuals[1] < 1.2 * residuals[0]
