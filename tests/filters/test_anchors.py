# SPDX-License-Identifier: GPL-3.0-only
"""The user's own landmarks: read from files of other programs, carried by layers, heeded by
propagation."""

import json

import numpy as np
import pymeshlab
import pytest
from documents import (
    LOAD,
    MODEL,
    PROPAGATE,
    REMESH,
    ROOT,
    add,
    has_attribute,
    labels,
    layer,
    positions,
    refused,
)
from documents import small_cycle as cycle
from environment import PROJECT
from surfaces import egg

NAMES = ("apex", "base", "left side")


def remarks(returned):
    if "warnings" not in returned:
        return []
    return json.loads(bytes(map(int, returned["warnings"])).decode())


def anchor(mesh, name="apex"):
    values = mesh.vertex_custom_point_attribute_matrix("anchor_" + name.replace(" ", "%20"))
    assert len(np.unique(values, axis=0)) == 1
    return values[0]


def places(mesh, shift=0):
    """Vertices that are far apart, in each layer's own numbering."""
    v = mesh.vertex_matrix() + shift
    return dict(zip(NAMES, (v[v[:, 2].argmin()], v[v[:, 2].argmax()], v[v[:, 0].argmax()])))


def pick_points(path, points):
    tags = "\n".join(
        f' <point x="{p[0]!r}" y="{p[1]!r}" z="{p[2]!r}" active="1" name="{name}"/>'
        for name, p in ((name, list(map(float, p))) for name, p in points.items())
    )
    path.write_text(f"<!DOCTYPE PickedPoints>\n<PickedPoints>\n{tags}\n</PickedPoints>\n")


def table(path, points):
    rows = [f"{name},{','.join(repr(float(x)) for x in p)}" for name, p in points.items()]
    path.write_text("\n".join(["name,x,y,z", *rows]))


def saved(folder, count=3):
    """A project of meshes that lie in files."""
    ms, loaded = cycle(count), pymeshlab.MeshSet()
    for i in range(count):
        ms.set_current_mesh(i)
        ms.save_current_mesh(str(folder / f"phase_{i}.ply"))
    for i in range(count):
        loaded.load_new_mesh(str(folder / f"phase_{i}.ply"))
    loaded.set_current_mesh(0)
    return loaded


def test_a_file_goes_to_the_current_layer_in_the_frame_that_is_asked_for(tmp_path):
    for coordinates, shift in (("World", 0), ("Mesh", 10)):
        ms = cycle(2)
        mesh = ms.mesh(1)
        ms.set_current_mesh(1)
        ms.apply_filter("compute_matrix_from_translation", axisx=10.0, freeze=False)
        pick_points(tmp_path / "a.pp", places(mesh))
        returned = ms.apply_filter(LOAD, file_name=str(tmp_path / "a.pp"), coordinates=coordinates)
        assert returned["anchors"].tolist() == [3]
        assert np.allclose(anchor(mesh), places(mesh)["apex"] - [10 - shift, 0, 0], atol=1e-9)
        assert not has_attribute(ms.mesh(0), "anchor_apex")


def test_a_folder_and_files_beside_the_meshes(tmp_path):
    ms = saved(tmp_path)
    (tmp_path / "anchors").mkdir()
    for i, mesh in enumerate(ms):
        table(tmp_path / f"anchors/phase_{i}.csv", places(mesh))
    returned = ms.apply_filter(LOAD, file_name=str(tmp_path / "anchors"), show_anchors=True)
    assert returned["anchors"].tolist() == [3, 3, 3] and "warnings" not in returned
    assert np.allclose(anchor(ms.mesh(2), "left side"), places(ms.mesh(2))["left side"])
    shown = layer(ms, "phase_1 anchors")
    assert shown.vertex_number() == 3 * 92
    centres = shown.vertex_matrix().reshape(3, 92, 3).mean(1)
    assert np.allclose(centres, list(places(ms.mesh(1)).values()), atol=1e-3)
    # Markers are no surfaces: nothing is made of them.
    ms.set_current_mesh(0)
    ms.apply_filter(ROOT)
    assert len(ms.apply_filter(PROPAGATE)["parent"]) == 3

    beside = saved(tmp_path)
    pick_points(tmp_path / "phase_1_picked_points.pp", {"apex": places(ms.mesh(1))["apex"]})
    table(tmp_path / "phase_1.csv", places(ms.mesh(1)))
    assert beside.apply_filter(LOAD)["anchors"].tolist() == [0, 1, 0]
    assert labels(beside) == labels(ms)[:3]


def test_what_is_wrong_with_anchors_is_named(tmp_path):
    ms = cycle(2)
    points = places(ms.mesh(0))
    table(tmp_path / "far.csv", {**points, "far": points["base"] + 300})
    said = remarks(ms.apply_filter(LOAD, file_name=str(tmp_path / "far.csv")))
    assert [(r["message"], r["layer"]) for r in said] == [("anchorFarOff", "phantom cavity 00")]
    assert '"far"' in said[0]["text"]
    far = {name: point + 300 for name, point in points.items()}
    table(tmp_path / "far.csv", {**points, **{f"far {name}": p for name, p in far.items()}})
    said = remarks(ms.apply_filter(LOAD, file_name=str(tmp_path / "far.csv")))
    assert [(r["message"], r["layer"]) for r in said] == [("anchorsFarOff", "phantom cavity 00")]
    assert said[0]["text"].startswith('3 of its anchors ("far apex", "far base", "far left side")')
    (tmp_path / "twice.csv").write_text("a,1,2,3\na,3,4,5\n")
    said = remarks(ms.apply_filter(LOAD, file_name=str(tmp_path / "twice.csv")))
    assert [r["message"] for r in said] == ["anchorsTwice"]
    (tmp_path / "unplaced.csv").write_text("name,x,y,z\napex,nan,nan,nan\nbase,,,\n")
    said = remarks(ms.apply_filter(LOAD, file_name=str(tmp_path / "unplaced.csv")))
    assert [r["message"] for r in said] == ["noAnchorHasPlace"]
    assert 'names "apex", "base" and has a place for none' in said[0]["text"]
    (tmp_path / "two").mkdir()
    for ending in ("csv", "txt"):
        table(tmp_path / f"two/phantom cavity 00.{ending}", points)
    said = remarks(ms.apply_filter(LOAD, file_name=str(tmp_path / "two")))
    assert [(r["message"], r["layer"]) for r in said] == [
        ("severalAnchorFiles", "phantom cavity 00")
    ]
    assert said[0]["text"].endswith("00.csv; take the others away.")
    for name, text, words in (
        ("bad.csv", "a,1,2,three", 'line 1: the place of "a" is not three numbers'),
        ("bad.json", "{", "line"),
        ("bad.pp", "<a/>", "holds none"),
        ("bad.ply", "ply", "its ending tells no format"),
        ("no_row.csv", "# made for later\nname,x,y,z\n", "holds none"),
        ("no_point.pp", "<!DOCTYPE P>\n<PickedPoints></PickedPoints>", "holds none"),
        ("no_point.fcsv", "# Markups fiducial file version = 4.11\n", "holds none"),
        ("no_point.mrk.json", '{"markups": [{"controlPoints": []}]}', "holds none"),
    ):
        (tmp_path / name).write_text(text)
        with pytest.raises(pymeshlab.PyMeshLabException, match=words):
            ms.apply_filter(LOAD, file_name=str(tmp_path / name))
    (tmp_path / "empty").mkdir()
    with pytest.raises(pymeshlab.PyMeshLabException, match="holds no anchors of the layers"):
        ms.apply_filter(LOAD, file_name=str(tmp_path / "empty"))


def test_places_in_lps_are_turned_round_unless_the_surface_is_there(tmp_path):
    ms = pymeshlab.MeshSet()
    add(ms, *egg(centre=(50, 20, 0)), "egg")
    mesh = ms.mesh(0)
    for sign in ((-1, -1, 1), (1, 1, 1)):
        points = [
            {"label": name, "position": list(map(float, p * sign))}
            for name, p in places(mesh).items()
        ]
        text = json.dumps({"markups": [{"coordinateSystem": "LPS", "controlPoints": points}]})
        (tmp_path / "a.mrk.json").write_text(text)
        said = remarks(ms.apply_filter(LOAD, file_name=str(tmp_path / "a.mrk.json")))
        as_written = [("Note", "anchorsInLps", ["egg"])] if sign[0] == 1 else []
        assert [(r["kind"], r["message"], r["layers"]) for r in said] == as_written
        assert np.allclose(anchor(mesh), places(mesh)["apex"])


def turning(count=3, anchors=True):
    """Eggs of revolution that turn about their axis, which no surface shows."""
    ms = pymeshlab.MeshSet()
    vertices, faces = egg(20, 24, radii=(20, 20, 35))
    vertices = np.asarray(vertices, float)
    for i in range(count):
        a = 0.12 * i
        rotation = np.array([[np.cos(a), -np.sin(a), 0], [np.sin(a), np.cos(a), 0], [0, 0, 1]])
        v = vertices @ rotation.T
        mesh = pymeshlab.Mesh(v, np.asarray(faces, np.int32))
        if anchors:
            for k in (5, 100, 230, 400):
                place = np.tile(v[k], (len(v), 1))
                mesh.add_vertex_custom_point_attribute(place, f"anchor_p{k}")
        ms.add_mesh(mesh, f"egg {i}")
    ms.set_current_mesh(0)
    ms.apply_filter(ROOT)
    return ms


def test_propagation_heeds_anchors_and_says_what_became_of_them():
    without, off, soft, exact = (turning(anchors=i > 0) for i in range(4))
    plain = without.apply_filter(PROPAGATE)
    assert "anchor_distance" not in plain
    off.apply_filter(PROPAGATE, anchors="Off")
    for i in range(3):
        assert np.array_equal(positions(off.mesh(i)), positions(without.mesh(i)))
    returned = soft.apply_filter(PROPAGATE)
    names = bytes(map(int, returned["anchor_names"])).decode().split("\n")
    assert names == ["p100", "p230", "p400", "p5"]
    distance = returned["anchor_distance"].reshape(3, 4)
    assert np.allclose(distance[0], 0, atol=1e-9)
    assert np.isnan(returned["anchor_distance_before"].reshape(3, 4)[0]).all()
    assert returned["anchor_z"].shape == (12,) and (returned["prior_widening"] >= 1).all()
    held = exact.apply_filter(PROPAGATE, anchors="Exact")
    assert held["anchor_distance"].max() < 1e-9 and (held["flipped_faces"] == 0).all()
    root = positions(exact.mesh(0))
    for i in (1, 2):
        for k in (5, 100, 230, 400):
            assert np.linalg.norm(positions(exact.mesh(i))[k] - root[k]) < 1e-12
    error = [np.linalg.norm(positions(ms.mesh(2)) - root, axis=1).mean() for ms in (without, soft)]
    assert error[1] < error[0]


def test_anchors_become_landmarks_on_every_layer(tmp_path):
    ms = turning()
    former = positions(ms.mesh(0))
    returned = ms.apply_filter(PROPAGATE, anchors="Exact", anchor_snap=True)
    assert (returned["flipped_faces"] == 0).all()
    assert not np.array_equal(positions(ms.mesh(0)), former)
    landmarks = returned["anchor_landmark"].astype(int)
    assert len(set(landmarks)) == 4
    remeshed = ms.apply_filter(REMESH)
    assert "warnings" not in remeshed  # maps of one root
    for i in range(3):
        points = ms.mesh(3 + i).vertex_matrix()[landmarks]
        vertices = ms.mesh(i).vertex_matrix()
        assert np.allclose(points, vertices[[100, 230, 400, 5]], atol=1e-9)
    ms.apply_filter(MODEL, export_file=str(tmp_path / "model.npz"))
    with np.load(tmp_path / "model.npz") as model:  # whose landmarks have the anchors' names
        assert model["anchor_landmarks"].tolist() == landmarks.tolist()
        assert len(set(model["anchor_names"].tolist())) == 4
    assert np.array_equal(
        turning().apply_filter(PROPAGATE, anchors="Exact", anchor_snap=True)["anchor_landmark"],
        returned["anchor_landmark"],
    )
    assert "anchor_landmark" not in turning(anchors=False).apply_filter(PROPAGATE, anchor_snap=True)


def test_propagation_looks_beside_the_meshes_and_into_a_folder(tmp_path):
    ms = saved(tmp_path)
    table(tmp_path / "phase_0.csv", places(ms.mesh(0)))
    table(tmp_path / "phase_2.csv", places(ms.mesh(2)))
    (tmp_path / "phase_1.csv").write_text("time,volume\n0.1,72\n")  # of somebody else
    ms.apply_filter(ROOT)
    returned = ms.apply_filter(PROPAGATE)
    missing = np.isnan(returned["anchor_distance"]).reshape(3, 3)
    assert missing.tolist() == [[False] * 3, [True] * 3, [False] * 3]
    assert [r["message"] for r in remarks(returned)] == ["anchorsNotRead"]
    (tmp_path / "given").mkdir()
    for i in (0, 1):
        table(tmp_path / f"given/phase_{i}.csv", {"one": places(ms.mesh(i))["apex"]})
    returned = ms.apply_filter(PROPAGATE, anchor_files=str(tmp_path / "given"))
    assert bytes(map(int, returned["anchor_names"])) == b"one"
    (said,) = (r for r in remarks(returned) if r["message"] == "anchorsNotOnRoot")
    root, other = (ms.mesh(i).label() for i in (0, 2))
    assert said["layers"] == [root, other] and said["subject"] == root
    assert said["text"].startswith(f'the anchors "apex", "base", "left side" of "{other}" are not')


def test_of_two_files_beside_a_mesh_the_first_counts_and_contradictions_are_named(tmp_path):
    ms = saved(tmp_path)
    for i in range(3):
        points = places(ms.mesh(i))
        pick_points(tmp_path / f"phase_{i}_picked_points.pp", points)
        if i == 1:
            points["apex"] = points["apex"] + 1
        points["new"] = points["base"]
        control = [
            {"label": name, "position": list(map(float, p)), "positionStatus": "defined"}
            for name, p in points.items()
        ]
        markups = {"type": "Fiducial", "coordinateSystem": "RAS", "controlPoints": control}
        (tmp_path / f"phase_{i}.mrk.json").write_text(json.dumps({"markups": [markups]}))
    ms.apply_filter(ROOT)
    returned = ms.apply_filter(PROPAGATE)
    assert bytes(map(int, returned["anchor_names"])).decode().split("\n")[0] == "apex"
    assert b"new" not in bytes(map(int, returned["anchor_names"]))
    picked = places(ms.mesh(1))["apex"]
    assert np.abs(returned["anchor_places"].reshape(3, 3, 3)[1, 0] - picked).max() < 1e-4
    (said,) = (r for r in remarks(returned) if r["message"] == "anchorFilesContradict")
    assert said["layers"] == [ms.mesh(1).label()]
    first, second = (said["text"].index(end) for end in ("_picked_points.pp", ".mrk.json"))
    assert '"apex"' in said["text"] and '"base"' not in said["text"] and first < second


def test_names_that_are_exchanged_are_refused_or_named():
    ms = turning(2)
    first, second = (
        ms.mesh(1).vertex_custom_point_attribute_matrix(f"anchor_p{k}") for k in (5, 100)
    )
    swapped = pymeshlab.MeshSet()
    for i in range(2):
        mesh = pymeshlab.Mesh(ms.mesh(i).vertex_matrix(), ms.mesh(i).face_matrix())
        for k in (5, 100, 230, 400):
            values = ms.mesh(i).vertex_custom_point_attribute_matrix(f"anchor_p{k}")
            if i == 1 and k in (5, 100):
                values = second if k == 5 else first
            mesh.add_vertex_custom_point_attribute(values, f"anchor_p{k}")
        swapped.add_mesh(mesh, f"egg {i}")
    swapped.set_current_mesh(0)
    swapped.apply_filter(ROOT)
    with pytest.raises(pymeshlab.PyMeshLabException, match='"p100" and "p5".*change places'):
        swapped.apply_filter(PROPAGATE, anchors="Exact")
    assert not has_attribute(swapped.mesh(1))
    for method in ("Robust", "As published"):
        said = [r["text"] for r in remarks(swapped.apply_filter(PROPAGATE, method=method))]
        assert any(
            '"p100" and "p5" fit much better with their names exchanged' in text for text in said
        )


@pytest.mark.parametrize("method", ["Robust", "As published"])
def test_names_that_are_right_stay_unnamed(method):
    returned = turning(4).apply_filter(PROPAGATE, method=method)
    assert len(bytes(map(int, returned["anchor_names"])).split(b"\n")) == 4
    assert not any("exchanged" in remark["text"] for remark in remarks(returned))


def test_names_that_are_exchanged_in_turn_are_named():
    there = turning(2)
    its_place = {"p5": "p100", "p100": "p230", "p230": "p5", "p400": "p400"}
    ms = pymeshlab.MeshSet()
    for i, mesh in enumerate(there):
        copy = pymeshlab.Mesh(mesh.vertex_matrix(), mesh.face_matrix())
        for name, other in its_place.items():
            values = mesh.vertex_custom_point_attribute_matrix(f"anchor_{other if i else name}")
            copy.add_vertex_custom_point_attribute(values, f"anchor_{name}")
        ms.add_mesh(copy, f"egg {i}")
    ms.set_current_mesh(0)
    ms.apply_filter(ROOT)
    for method in ("As published", "Robust"):
        said = [r["text"] for r in remarks(ms.apply_filter(PROPAGATE, method=method))]
        assert any(
            text.startswith('its anchors "p100", "p230", "p5" fit much better')
            and "in turn" in text
            for text in said
        )
    assert not any("standard deviations" in text and "p5" in text for text in said)


def test_anchors_follow_their_layer_through_a_preparation(tmp_path):
    ms = pymeshlab.MeshSet()
    vertices, faces = egg()
    add(ms, vertices, np.asarray(faces)[1:], "open")
    mesh = ms.mesh(0)
    place = np.tile(np.asarray(vertices, float)[7], (mesh.vertex_number(), 1))
    mesh.add_vertex_custom_point_attribute(place, "anchor_a")
    ms.apply_filter("apply_surface_preparation")
    assert np.allclose(anchor(ms.mesh(0), "a"), np.asarray(vertices)[7])


POSITIONS = "name,longitude,latitude\napex,0,-90\nbase,0,90\nleft side,90,10\nnowhere,0,0\n"


def place_on_sphere(mesh, point):
    """Of a vertex."""
    at = np.linalg.norm(mesh.vertex_matrix() - point, axis=1).argmin()
    return positions(mesh)[at]


def test_the_roots_anchors_lie_where_they_are_asked_to(tmp_path):
    ms = cycle(1)
    points = places(ms.mesh(0))
    (tmp_path / "phantom cavity 00.csv").write_text(
        "".join(f"{name},{x:.17g},{y:.17g},{z:.17g}\n" for name, (x, y, z) in points.items())
    )
    (tmp_path / "positions.csv").write_text(POSITIONS)
    with refused(ms, "none of the anchors"):
        ms.apply_filter(ROOT, anchor_positions=str(tmp_path / "positions.csv"))
    ms = cycle(1)
    free = ms.apply_filter(ROOT)["area_ratio_sd"]
    ms.apply_filter(LOAD, file_name=str(tmp_path))
    returned = ms.apply_filter(ROOT, anchor_positions=str(tmp_path / "positions.csv"))
    wanted = [[0, 0, -1], [0, 0, 1], [0, np.cos(np.radians(10)), np.sin(np.radians(10))]]
    for point, place in zip(points.values(), wanted):
        np.testing.assert_allclose(place_on_sphere(ms.mesh(0), point), place, atol=1e-11)
    assert returned["flipped_faces"] == 0 and len(returned["anchor_moved"]) == 3
    assert returned["area_ratio_sd"] < free + 0.5
    assert any("nowhere" in str(remark) for remark in remarks(returned))


def test_places_that_cannot_be_are_refused(tmp_path):
    ms = cycle(1)
    points = places(ms.mesh(0))
    (tmp_path / "a.csv").write_text(
        "".join(f"{name},{x:.17g},{y:.17g},{z:.17g}\n" for name, (x, y, z) in points.items())
    )
    ms.apply_filter(LOAD, file_name=str(tmp_path / "a.csv"))
    for text, words in (
        ("name,x,y,z\napex,0,0,1\nbase,0,0,2\n", "lie in one place"),
        ("name,lon,lat\napex,0,100\n", "latitude"),
        ("name,x,y,z\napex,0,0,0\n", "direction"),
        ("name,x,y,z\napex,one,0,0\n", "three numbers"),
    ):
        (tmp_path / "positions.csv").write_text(text)
        with refused(ms, words):
            ms.apply_filter(ROOT, anchor_positions=str(tmp_path / "positions.csv"))


@pytest.mark.parametrize("way", ["at random", "as a twist"])
def test_anchors_that_are_moved_far_hold_and_the_maps_stay_valid(tmp_path, monkeypatch, way):
    """benchmarks/exact_anchors.py on a small sequence."""
    monkeypatch.syspath_prepend(str(PROJECT / "benchmarks"))
    import exact_anchors

    ms, files = cycle(2), []
    for i in range(2):
        files.append(tmp_path / f"{i}.ply")
        ms.set_current_mesh(i)
        ms.save_current_mesh(str(files[-1]))
    flips, worst, growth, _ = exact_anchors.hold(files, "Time", way, 0.1, 0)
    assert flips == 0 and worst < 1e-11 and growth < 8


TURN = np.array([[0.36, 0.48, -0.8], [-0.8, 0.6, 0.0], [0.48, 0.64, 0.6]])
SHIFT = np.array([70.0, -20.0, 40.0])


def carry(mesh, points):
    for name, place in points.items():
        mesh.add_vertex_custom_point_attribute(
            np.tile(place, (mesh.vertex_number(), 1)), f"anchor_{name}"
        )


def extremes(mesh):
    v = mesh.vertex_matrix()
    return dict(zip("abc", (v[v[:, k].argmin()] for k in (0, 1, 2))))


def moved(place):
    return TURN @ place + SHIFT


def moved_cycle(which, anchors=lambda i, points: points):
    """Phases of which one lies elsewhere, with anchors on all of them. anchors: of a phase, given
    its extremes."""
    ms, made = cycle(4), pymeshlab.MeshSet()
    for i, mesh in enumerate(ms):
        v, points = mesh.vertex_matrix(), anchors(i, extremes(mesh))
        if i == which:
            v, points = v @ TURN.T + SHIFT, {name: moved(p) for name, p in points.items()}
        add(made, v, mesh.face_matrix(), f"phase {i}")
        carry(made.mesh(i), points)
    made.set_current_mesh(0)
    made.apply_filter(ROOT)
    return made


@pytest.mark.parametrize("method", ["Robust", "As published"])
def test_anchors_lay_a_layer_that_lies_elsewhere(method):
    ms = moved_cycle(2)
    there = ms.mesh(2).vertex_matrix()
    returned = ms.apply_filter(PROPAGATE, method=method, anchor_pose=True)
    assert [r["message"] for r in remarks(returned)] == [] and returned["flipped_faces"].sum() == 0
    assert (ms.mesh(2).vertex_matrix() == there).all()  # laid for the fit alone
    places_of = returned["anchor_places"].reshape(4, 3, 3)
    assert np.allclose(places_of[2], [anchor(ms.mesh(2), k) for k in "abc"], atol=1e-9)
    still = moved_cycle(None)
    still.apply_filter(PROPAGATE, method=method, anchor_pose=True)
    assert np.allclose(positions(ms.mesh(2)), positions(still.mesh(2)), atol=1e-6)


def test_a_pose_by_anchors_takes_three():
    def two(i, points):
        return points if i == 0 else {k: points[k] for k in "ab"}

    ms = moved_cycle(2, two)
    with refused(ms, "takes 3 anchors of the root"):
        ms.apply_filter(PROPAGATE, anchor_pose=True)
    with refused(ms, "takes 3 anchors of the root"):
        ms.apply_filter(PROPAGATE, anchors="Off", anchor_pose=True)
    ms = moved_cycle(2, lambda i, points: points if i < 2 else two(i, points))
    said = remarks(ms.apply_filter(PROPAGATE, anchor_pose=True))
    assert sorted({r["message"] for r in said}) == ["anotherPose", "posesNotByAnchors"]


def with_landmarks(ms):
    ms.apply_filter(PROPAGATE)
    ms.apply_filter(REMESH, frequency=4)
    return ms, np.stack([ms.mesh(4 + i).vertex_matrix() for i in range(4)])


def test_a_model_is_aligned_by_anchors_alone():
    # On the surfaces that the landmarks were made of: of identical anchors the third shape's motion
    # is undone, whatever the landmarks say.
    start = cycle(1)
    first = extremes(start.mesh(0))
    ms, points = with_landmarks(moved_cycle(2, lambda i, own: first))
    returned = ms.apply_filter(MODEL, alignment="Anchors", mode_layers=0)
    points[2] = (points[2] - SHIFT) @ TURN
    assert np.allclose(returned["mean"].reshape(-1, 3), points.mean(0), atol=1e-9)
    # A landmark layer's own come first: with size, of a shape twice as large.
    for i in range(4):
        own = {k: moved(p) if i == 2 else (1 + (i == 1)) * p for k, p in first.items()}
        carry(ms.mesh(4 + i), own)
    returned = ms.apply_filter(MODEL, alignment="Scaled anchors", mode_layers=0)
    points[1] /= 2
    mean, found = points.mean(0), returned["mean"].reshape(-1, 3)
    mean, found = mean - mean.mean(0), found - found.mean(0)
    assert np.allclose(found / np.linalg.norm(found), mean / np.linalg.norm(mean), atol=1e-9)


def test_a_shape_that_anchors_cannot_align_is_named():
    ms, _ = with_landmarks(
        moved_cycle(2, lambda i, own: {k: own[k] for k in "ab"} if i == 3 else own)
    )
    with refused(ms, 'Shape "phase 3 landmarks" cannot be aligned by anchors: it shares 2'):
        ms.apply_filter(MODEL, alignment="Anchors")

    def on_a_line(i, own):
        line = {k: own["a"] + n * np.array([1.0, 2.0, 3.0]) for n, k in enumerate("abc")}
        return line if i == 3 else own

    ms, _ = with_landmarks(moved_cycle(2, on_a_line))
    with refused(ms, "the 3 that it shares with the others lie on one line"):
        ms.apply_filter(MODEL, alignment="Anchors")
