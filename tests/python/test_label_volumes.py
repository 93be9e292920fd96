# SPDX-License-Identifier: GPL-3.0-only
"""Label volumes in Python and on the command line: surfaces of all phases, what deserves a look,
what is missing."""

import csv
import gzip
import re
import shutil
import warnings

import numpy as np
import pytest
import sphere_propagation as sp
import volume_files
from scipy.spatial import cKDTree
from sphere_propagation import command, files, plugin


def beat(phases=3):
    """Labels of an egg (1) in a larger one (2) that contracts, phase by phase."""

    def phase(t):
        x = np.stack(
            np.meshgrid(*[np.linspace(-1.3, 1.3, n) for n in (26, 24, 22)], indexing="ij"), -1
        )
        r = (x**2).sum(-1) * (1 + 0.25 * x[..., 0] + 0.15 * x[..., 1] - 0.2 * x[..., 2])
        return np.select([r < 0.6 - 0.1 * t, r < 1], [1, 2]).astype("u1")

    return np.stack([phase(t) for t in range(phases)], -1)


@pytest.fixture
def volume(tmp_path):
    path = tmp_path / "beat_1.5mm.nii.gz"
    path.write_bytes(gzip.compress(volume_files.nifti(beat(), np.diag([1.5, 1.5, 1.5, 1]))))
    return path


def test_surfaces_and_figures_of_all_phases(volume):
    found = sp.read_label_volume(volume)
    assert [surface.name for surface in found.surfaces] == [
        f"beat_1.5mm label 1 phase 0{t}" for t in range(3)
    ]
    voxels = [(beat()[..., t] == 1).sum() * 1.5**3 for t in range(3)]
    assert found.figures["label_volume"] == pytest.approx(voxels)
    assert [surface.volume for surface in found.surfaces] == pytest.approx(voxels, rel=0.02)
    assert [len(surface.vertices) for surface in found.surfaces] == found.figures[
        "vertices"
    ].tolist()
    assert all(len(values) == 3 for values in found.figures.values())


@pytest.mark.parametrize("labels", ["1,2", [1, 2], (2, 1), np.array([1, 2])])
def test_labels_are_united(volume, labels):
    (first, *_) = sp.read_label_volume(volume, labels=labels).surfaces
    assert first.volume == pytest.approx((beat()[..., 0] > 0).sum() * 1.5**3, rel=0.02)


def test_a_label_by_its_number(volume):
    assert (
        sp.read_label_volume(volume, labels=1, voxel_size=3).surfaces[0].name
        == "beat_1.5mm label 1 phase 00"
    )
    with pytest.raises(sp.FilterError, match="label 7"):
        sp.read_label_volume(volume, labels=7)


@pytest.mark.filterwarnings("error")
def test_what_deserves_a_look_is_warned_of(volume, tmp_path):
    """A gap of two slices, a part that is dropped, a cavity that is filled; each is said once."""
    labels = volume_files.egg((20, 18, 16))
    gap = labels.copy()
    gap[:, :, 7:9] = 0
    (tmp_path / "gap.nii").write_bytes(volume_files.nifti(gap))
    with pytest.warns(
        sp.SpherePropagationWarning,
        match="gap label 1: 2 slices without the label were interpolated",
    ):
        sp.read_label_volume(tmp_path / "gap.nii")
    with pytest.warns(
        sp.SpherePropagationWarning,
        match=r"^beat_1.5mm label 2 phases 00 to 02: the surface encloses [\d.]+ to [\d.]+ % more ",
    ) as warned:
        sp.read_label_volume(volume, labels=2)
    assert len(warned) == 1
    two = np.concatenate([labels, labels[:, :, ::-1], labels[:10]], 0)
    (tmp_path / "parts.nii").write_bytes(volume_files.nifti(two))
    with (
        pytest.warns(
            sp.SpherePropagationWarning,
            match=r"parts label 1: [\d.]+ % of the label's voxels were dropped with its smaller",
        ),
        pytest.warns(sp.SpherePropagationWarning, match="parts label 1: lost .*: slices 13 to 14"),
    ):
        sp.read_label_volume(tmp_path / "parts.nii")


@pytest.mark.filterwarnings("error")
def test_good_labels_are_read_without_a_word(volume):
    sp.read_label_volume(volume)


@pytest.mark.filterwarnings("error")
def test_a_thin_label_that_loses_much_is_warned_of(tmp_path):
    """A plate three voxels thick, smoothed by five: the phase, how much is lost, and what to do."""
    labels = np.zeros((24, 24, 12), np.uint8)
    labels[3:21, 3:21, 4:7] = 1
    (tmp_path / "plate.nii").write_bytes(volume_files.nifti(labels))
    with pytest.warns(
        sp.SpherePropagationWarning,
        match=r"plate label 1: the surface encloses \d+ % less than the label's voxels, which are "
        r"thin .*\. With smoothing 1 it would be \d %\.",
    ):
        figures = sp.read_label_volume(tmp_path / "plate.nii", smoothing=2).figures
    assert figures["volume"][0] < 0.9 * figures["label_volume"][0] and figures["thin"][0] == 1


def test_an_apex_after_another_breath_is_named_and_brought_back(tmp_path):
    """Its slice does not touch the one beside it, and so is lost as a loose part."""
    labels = np.zeros((64, 64, 14), np.uint8)
    x, y = np.indices((64, 64))
    for k in range(10):
        radius = max(2.6, 14 * np.sqrt(1 - (k / 9) ** 1.5))
        labels[:, :, 2 + k] = (x - 32 - 8 * (k == 9)) ** 2 + (y - 30) ** 2 < radius**2
    path = tmp_path / "breath.nii"
    path.write_bytes(volume_files.nifti(labels, np.diag([1.4, 1.4, 10, 1])))
    with pytest.warns(
        sp.SpherePropagationWarning,
        match=r"breath label 1: lost .*: slice 11 .* With align_slices, .* 1 of them would be kept",
    ):
        (lost,) = sp.read_label_volume(path).surfaces
    (whole,) = sp.read_label_volume(path, align_slices=True).surfaces
    assert np.ptp(lost.vertices[:, 2]) < 92 and abs(np.ptp(whole.vertices[:, 2]) - 100) < 1  # mm


def stack_with(moved, by, spacing=10.0):
    """Discs of 14 voxels in 9 slices, some of them out of place."""
    labels = np.zeros((96, 64, 13), np.uint8)
    x, y = np.indices((96, 64))
    for k in range(9):
        labels[:, :, 2 + k] = (x - 30 - by * (k in moved)) ** 2 + (y - 30) ** 2 < 14**2
    return volume_files.nifti(labels, np.diag([1.4, 1.4, spacing, 1]))


@pytest.mark.parametrize("moved, by", [((4,), 40)])
def test_slices_out_of_place_do_not_make_a_label_thin(tmp_path, moved, by):
    (tmp_path / "torn.nii").write_bytes(stack_with(moved, by))
    with pytest.warns(sp.SpherePropagationWarning) as caught:
        figures = sp.read_label_volume(tmp_path / "torn.nii").figures
    said = " ".join(str(w.message) for w in caught)
    assert figures["volume"][0] < 0.9 * figures["label_volume"][0]
    assert "thin" not in said and "finer ones" not in said and figures["thin"][0] == 0, said
    assert "% less than the label's voxels." in said and "slice" in said


def tubes(shifts, phases, slices=13):
    """Phases of a bent tube that beats, its slices moved by so many voxels along the first axis."""
    x, y = np.indices((84, 64))
    labels = np.zeros((84, 64, slices + 4, phases), np.uint8)
    for p in range(phases):
        for k in range(slices):
            middle = 36 + 0.08 * (k - 5) ** 2 + shifts[p].get(k, 0)
            radius = 14 - 1.5 * p + 0.1 * k
            labels[:, :, 2 + k, p] = (x - middle) ** 2 + (y - 30) ** 2 < radius**2
    return labels


def aligned(path, **parameters):
    """The surfaces and the texts of the warnings."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", sp.SpherePropagationWarning)
        found = sp.read_label_volume(path, align_slices=True, **parameters)
    return found.surfaces, [str(w.message) for w in caught]


def off(surfaces, straight):
    """How far surfaces lie from others of the same volumes, mean over all, mm."""
    apart = [cKDTree(b.vertices).query(a.vertices)[0].mean() for a, b in zip(surfaces, straight)]
    return np.array(apart)


THICK = np.diag([1.4, 1.4, 10, 1])


@pytest.mark.filterwarnings("ignore::sphere_propagation.SpherePropagationWarning")
def test_a_run_reports_the_slices_that_it_moves(tmp_path):
    path, results = tmp_path / "scan.nii", tmp_path / "results"
    path.write_bytes(volume_files.nifti(tubes([{6: 6}] * 3, 3), THICK))
    words = ["run", path, "-o", results, "--align-slices", "--frequency", 2, "--no-pictures"]
    assert command.main([*map(str, words)]) == 0
    with open(results / "warnings.csv", newline="") as file:
        (moved,) = [row for row in csv.DictReader(file) if row["message"] == "slicesAligned"]
    assert "slice 8 by 8.4 mm" in moved["text"]  # 6 voxels of 1.4 mm


def test_slices_are_moved_alike_in_all_phases(tmp_path):
    """In a 4D file and in a series of files."""
    moved = tubes([{6: 6}] * 3, 3)
    whole, series = tmp_path / "whole.nii", tmp_path / "part_0.nii"
    whole.write_bytes(volume_files.nifti(moved, THICK))
    for p in range(3):
        (tmp_path / f"part_{p}.nii").write_bytes(volume_files.nifti(moved[..., p].copy(), THICK))
    (tmp_path / "straight.nii").write_bytes(volume_files.nifti(tubes([{}] * 3, 3), THICK))
    straight, said = aligned(tmp_path / "straight.nii")
    assert not said
    for path, parameters in ((whole, {}), (series, {"file_series": True})):
        surfaces, said = aligned(path, **parameters)
        assert not said
        assert off(surfaces, straight).max() < 0.8
    with pytest.warns(
        sp.SpherePropagationWarning,
        match=r"^whole label 1 phases 00 to 02: not in line .*: slice 8 by [78]\.\d mm ",
    ) as warned:
        sp.read_label_volume(whole)
    assert len(warned) == 1


@pytest.mark.filterwarnings("ignore::sphere_propagation.SpherePropagationWarning")
def test_files_of_a_folder_are_decided_together(tmp_path):
    """Slices that are no other in the files by themselves, as in the phases of one; names of files
    that two folders share; and handles."""
    moved = tubes([{6: 6}] * 3, 3)
    paths = []
    for p, home in enumerate(("a", "a", "b")):
        (tmp_path / "seg" / home).mkdir(parents=True, exist_ok=True)
        paths.append(tmp_path / "seg" / home / ("late.nii" if p == 1 else "part.nii"))
        paths[-1].write_bytes(volume_files.nifti(moved[..., p].copy(), THICK))
    (tmp_path / "whole.nii").write_bytes(volume_files.nifti(moved, THICK))
    whole, _ = aligned(tmp_path / "whole.nii")
    listed, said = aligned(paths)
    assert not said
    assert [surface.name for surface in listed] == [
        "a_part label 1",
        "late label 1",
        "b_part label 1",
    ]
    for one, other in zip(listed, whole):
        assert np.array_equal(one.vertices, other.vertices)
    folder, _ = aligned(tmp_path / "seg" / "a")
    assert [surface.name for surface in folder] == ["late label 1", "part label 1"]
    results = tmp_path / "results"
    words = ["run", *paths, "-o", results, "--align-slices", "--frequency", 2, "--no-pictures"]
    assert command.main([*map(str, words)]) == 0
    with open(results / "warnings.csv", newline="") as file:
        rows = [row for row in csv.DictReader(file) if row["message"] == "slicesAligned"]
    (text,) = {row["text"] for row in rows}
    assert "slice 8 by 8.4 mm" in text
    for thin in (1, -1):
        path = tmp_path / "spine" / f"thin{thin}.nii"
        path.parent.mkdir(exist_ok=True)
        path.write_bytes(volume_files.nifti(vertebra(thin), np.eye(4)))
    surfaces = sp.read_label_volume(tmp_path / "spine", handle_repair="Cut").surfaces
    landmarks = sp.correspond(surfaces, frequency=8).landmarks
    assert np.linalg.norm(landmarks[0] - landmarks[1], axis=1).mean() < 1.0  # mm


def test_slices_of_different_bodies_are_moved_apart(tmp_path):
    """Another patient's files in one series: each has slices of its own out of line."""
    rng = np.random.default_rng(3)
    breaths = [dict(enumerate(rng.integers(-7, 8, 13).tolist())) for _ in range(2)]
    labels = tubes([breaths[0], breaths[0], breaths[1], breaths[1]], 4)
    for p in range(4):
        (tmp_path / f"p_{p}.nii").write_bytes(volume_files.nifti(labels[..., p].copy(), THICK))
    together, said = aligned(tmp_path / "p_0.nii", file_series=True)
    parts = "aligned apart: p_0 label 1, p_1 label 1; p_2 label 1, p_3 label 1."
    ends = ": off the line through the two slices next to it: slice 2 by "
    assert [s.split(ends)[0] for s in said[:-1]] == ["p_0 label 1, p_1 label 1"]
    assert said[-1].endswith(parts)
    for first in (0, 2):
        (tmp_path / "own.nii").write_bytes(
            volume_files.nifti(labels[..., first : first + 2].copy(), THICK)
        )
        for a, b in zip(together[first : first + 2], aligned(tmp_path / "own.nii")[0]):
            assert np.array_equal(a.vertices, b.vertices)
    (tmp_path / "all.nii").write_bytes(volume_files.nifti(labels, THICK))
    parts = "aligned apart: all label 1 phases 00, 01; all label 1 phases 02, 03."
    assert any(s.endswith(parts) for s in aligned(tmp_path / "all.nii")[1])


def test_slices_that_lie_otherwise_in_some_phases_are_named(tmp_path):
    """Phase 1 has its slice in line, and the phase without the last slice says nothing of it."""
    x, y = np.indices((72, 64))
    labels = np.zeros((72, 64, 13, 3), np.uint8)
    for p in range(3):
        for k in range(9 - (p == 2)):
            aside = 8 * (k == 4 and p != 1)
            labels[:, :, 2 + k, p] = (x - 30 - aside) ** 2 + (y - 30) ** 2 < 14**2
    path = tmp_path / "some.nii"
    path.write_bytes(volume_files.nifti(labels, THICK))
    surfaces, said = aligned(path)
    assert len(said) == 1
    assert (
        "otherwise in some phases than in the others: slice 6 in some label 1 phase 01 (slices are "
        "counted from 0)" in said[0]
    )
    for surface in surfaces:
        assert np.ptp(surface.vertices[:, 0]) < 42  # in line
    labels[..., 1] = labels[..., 0]
    path.write_bytes(volume_files.nifti(labels, THICK))
    assert not aligned(path)[1]


def test_a_slow_drift_is_a_bend_and_stays(tmp_path):
    drift = [{k: round(0.09 * (k - 6) ** 2) for k in range(13)}] * 2
    (tmp_path / "drift.nii").write_bytes(volume_files.nifti(tubes(drift, 2), THICK))
    with warnings.catch_warnings():
        warnings.simplefilter("error", sp.SpherePropagationWarning)
        before = sp.read_label_volume(tmp_path / "drift.nii").surfaces
    after, said = aligned(tmp_path / "drift.nii")
    assert not said and off(after, before).max() == 0


def vertebra(thin):
    """A body with an arch that is thin in one place, on the side of this sign."""
    i, j, k = np.indices((60, 60, 30)).astype(float)
    off = np.hypot(i - 30, j - 38) - 12
    narrow = (abs(j - 40) < 2) & ((i - 30) * thin > 0)
    arch = (abs(off) < np.where(narrow, 1, 3)) & (abs(k - 15) < 5)
    body = ((i - 30) ** 2 / 196 + (j - 18) ** 2 / 121 < 1) & (abs(k - 15) < 9)
    return (body | arch).astype("u1")


def handle_warnings(caught):
    return [str(w.message) for w in caught if "since a sphere has none" in str(w.message)]


@pytest.mark.parametrize("repair, apart", [("Cut", 1.0), ("Fill", 0.5)])
def test_handles_of_a_sequence_are_removed_at_one_place(tmp_path, repair, apart):
    path = tmp_path / "spine.nii.gz"
    phases = np.stack([vertebra(1), vertebra(-1)], -1)
    path.write_bytes(gzip.compress(volume_files.nifti(phases, np.eye(4))))
    with pytest.warns(sp.SpherePropagationWarning) as caught:
        found = sp.read_label_volume(path, handle_repair=repair)
    assert [text.split(":")[0] for text in handle_warnings(caught)] == [
        "spine label 1 phase 00",
        "spine label 1 phase 01",
    ]
    landmarks = sp.correspond(found.surfaces, frequency=8).landmarks
    assert np.linalg.norm(landmarks[0] - landmarks[1], axis=1).mean() < apart  # mm


def test_the_command_passes_on_what_its_advice_names(tmp_path, capsys):
    """On other grids handles are cut at other places: a note says so, once, and what to do."""
    for i, thin in enumerate((1, -1)):
        path = tmp_path / f"spine_{i}.nii"
        path.write_bytes(volume_files.nifti(vertebra(thin), np.diag([1 + 0.1 * i] * 3 + [1])))
    out = tmp_path / "out"
    words = ["run", "-o", str(out), "--frequency", "2", "--no-pictures"]
    assert command.main([*words, str(tmp_path / "spine_0.nii"), str(tmp_path / "spine_1.nii")]) == 0
    said = capsys.readouterr().err
    assert said.count("Note: surfaces correspond there only where the same was done") == 1
    assert "(4D, or several files)" in said and "choose --handle-repair:" in said
    assert "handlesElsewhere" in (out / "warnings.csv").read_text()
    series = [*words, str(tmp_path / "spine_0.nii"), "--file-series", "--align-slices"]
    assert command.main([*series, "--handle-repair", "Fill", "--longest-gap", "3"]) == 0
    said = capsys.readouterr().err
    assert said.count("handle filled") == 2 and "handle cut" not in said
    assert "surfaces correspond there" not in said
    assert command.main([*words, str(tmp_path), "--file-series"]) == 2
    assert "error: --file-series reads" in capsys.readouterr().err


def test_handles_of_single_volumes_are_named_with_their_places(tmp_path):
    places = []
    for thin in (1, -1):
        path = tmp_path / f"spine_{thin}.nii"
        path.write_bytes(volume_files.nifti(vertebra(thin), np.eye(4)))
        with pytest.warns(sp.SpherePropagationWarning) as caught:
            found = sp.read_label_volume(path)
        (text,) = handle_warnings(caught)
        changed = int(found.figures["changed_voxels"][0])
        assert f"1 handle cut, since a sphere has none: {changed} working voxels" in text
        places.append([float(x) for x in re.search(r"at \((.*)\) mm", text)[1].split(",")])
    assert np.allclose(places, [[42, 40, 15], [18, 40, 15]], atol=2)


@pytest.mark.parametrize("labels", [1.5, [1, 2.5], float("nan"), [[1, 2]], {"a": 1}])
def test_labels_that_are_no_whole_numbers(volume, labels):
    with pytest.raises(sp.InputError, match="labels must be whole numbers, not"):
        sp.read_label_volume(volume, labels=labels)


# ---------------------------------------------------------------- the command

QUICKLY = ("--frequency", 2, "--no-pictures")


def run(*arguments):
    return command.main([str(argument) for argument in arguments])


def test_one_volume_has_no_phases(tmp_path, capsys):
    (tmp_path / "one.nii").write_bytes(volume_files.nifti(volume_files.egg()))
    assert run("run", tmp_path / "one.nii", "-o", tmp_path / "out") == 2
    error = capsys.readouterr().err
    assert (
        "one.nii gives one surface" in error
        and "One volume has no phases" in error
        and not (tmp_path / "out").exists()
    )
    assert run("run", tmp_path / "one.nii", "-o", tmp_path / "out", "--labels", "7") == 1
    assert "label 7" in (error := capsys.readouterr().err) and "skip" not in error


def test_pictures_number_the_phases_as_the_file_does(tmp_path, monkeypatch):
    """Phases that were skipped keep their numbers."""
    labels = beat(4)
    labels[..., 1] = 0
    (tmp_path / "gap.nii").write_bytes(volume_files.nifti(labels))
    shown = []
    monkeypatch.setattr(
        "sphere_propagation.gallery.show",
        lambda results, title, text, sections, *more: shown.extend(sections),
    )
    job = ("run", tmp_path / "gap.nii", "-o", tmp_path / "out", "--skip-incomplete-phases")
    assert run(*job, *QUICKLY) == 0
    assert shown[0].rows[0].numbers() == [0, 2, 3]


def test_from_a_label_volume_to_the_model(volume, tmp_path, capsys):
    out = tmp_path / "out"
    assert run("run", volume, "-o", out, "--frequency", 3, "--no-pictures") == 0
    name = "beat_1.5mm"
    assert f"3 meshes: {volume.name}" in capsys.readouterr().out
    landmarks = sorted((out / name / "landmarks").iterdir())
    assert [path.name for path in landmarks] == [
        f"{name}_label_1_phase_0{t}_landmarks.ply" for t in range(3)
    ]
    with np.load(out / name / "model.npz") as model:
        assert model["scores"].shape == (3, 2)
    with open(out / "figures.csv", newline="") as file:
        assert [row["root"] for row in csv.DictReader(file)] == ["1", "0", "0"]


def test_options_reach_the_import(volume, tmp_path, capsys):
    out = tmp_path / "out"
    options = ("--labels", "1,2", "--voxel-size", 3, "--coordinates", "lps", "--smoothing", 0.5)
    assert run("run", volume, "-o", out, *options, *QUICKLY) == 0
    surface = sp.read_mesh(next((out / "beat_1.5mm/surfaces").iterdir()))
    expected = sp.read_label_volume(
        volume, labels="1,2", voxel_size=3, coordinates="LPS", smoothing=0.5
    ).surfaces[0]
    assert surface.name == "beat_1.5mm_label_1+2_phase_00"
    # The file says that it is in LPS, and is turned back.
    assert np.abs(surface.vertices * [-1, -1, 1] - expected.vertices).max() < 1e-4


def test_one_file_per_phase(tmp_path, capsys):
    """In the order of their numbers, whether files or their folder are given; a folder's meshes
    come before its volumes."""
    folder = tmp_path / "scan"
    folder.mkdir()
    for t in range(3):
        (folder / f"t{9 + t}.mha").write_bytes(volume_files.meta(beat()[..., t].copy()))
    for given in ([folder], sorted(folder.iterdir())):
        assert run("run", *given, "-o", tmp_path / "out", *QUICKLY) == 0
        assert [path.name for path in sorted((tmp_path / "out/scan/surfaces").iterdir())] == [
            "t10_label_1.ply",
            "t11_label_1.ply",
            "t9_label_1.ply",
        ]
    assert "t9.mha to t11.mha" in capsys.readouterr().out
    (folder / "mesh.ply").touch()
    assert [path.name for path in files.input_files(folder)] == ["mesh.ply"]


def test_phases_without_the_label(tmp_path, capsys):
    labels = beat(4)
    labels[..., 1] = 0
    (tmp_path / "gap.nii").write_bytes(volume_files.nifti(labels))
    assert run("run", tmp_path / "gap.nii", "-o", tmp_path / "out", "--no-pictures") == 1
    assert "phase 1" in capsys.readouterr().err and not (tmp_path / "out").exists()
    job = ("run", tmp_path / "gap.nii", "-o", tmp_path / "out", "--skip-incomplete-phases")
    assert run(*job, *QUICKLY) == 0
    assert len(list((tmp_path / "out/gap/surfaces").iterdir())) == 3


def test_options_of_volumes_are_not_for_meshes(cycle, tmp_path, capsys):
    surface = cycle.surfaces[0]
    sp.write_ply(tmp_path / "mesh.ply", surface.vertices, surface.faces)
    assert run("run", tmp_path / "mesh.ply", "-o", tmp_path / "out", "--labels", "1") == 2
    assert (
        "no label volume among the files, to which --labels could apply" in capsys.readouterr().err
    )


# ---------------------------------------------------------------- without the plugin


def test_everything_else_works_without_the_volume_plugin(run_python, tmp_path):
    """As built with --without-volumes."""
    alone = tmp_path / plugin.LIBRARY
    shutil.copy(plugin.find(), alone)
    found = run_python(
        "import sphere_propagation as sp; print(len(sp.make_phantom(phases=2, voxel_size=4)))\n"
        "try: sp.read_label_volume('x.nii')\nexcept sp.PluginError as error: print(error)",
        SPHERE_PROPAGATION_PLUGIN=str(alone),
    )
    assert found.returncode == 0, found.stderr
    assert (
        found.stdout.startswith("2\nLabel volumes cannot be read here.")
        and "libfilter_label_volume.so beside" in found.stdout
    )


def test_a_missing_library_of_itk_is_named(run_python, tmp_path):
    for name in (plugin.LIBRARY, plugin.VOLUME_LIBRARY):
        shutil.copy(plugin.find(name), tmp_path / name)
    code = (tmp_path / plugin.VOLUME_LIBRARY).read_bytes()
    assert b"libITKIOMeta-" in code
    (tmp_path / plugin.VOLUME_LIBRARY).write_bytes(code.replace(b"libITKIOMeta-", b"libITKIOBeta-"))
    found = run_python(
        "import sphere_propagation as sp\n"
        "try: sp.read_label_volume('x.nii')\n"
        "except sp.PluginError as error: print(error)",
        SPHERE_PROPAGATION_PLUGIN=str(tmp_path / plugin.LIBRARY),
    )
    assert found.returncode == 0, found.stderr
    assert (
        "Missing on this system: libITKIOBeta-" in found.stdout
        and "apt-get install libinsighttoolkit" in found.stdout
    )


def test_what_macos_keeps_beside_files_is_no_input(tmp_path):
    double = b"\0\5\x16\7" + bytes(100)
    for number in (1, 2):
        (tmp_path / f"{number}.nii").write_bytes(volume_files.nifti(volume_files.egg()))
        (tmp_path / f"._{number}.nii").write_bytes(double)
    ours = [tmp_path / "1.nii", tmp_path / "2.nii"]
    assert files.input_files(tmp_path) == files.input_files(*tmp_path.glob("*.nii")) == ours
    with pytest.raises(sp.FilterError, match='choose "1.nii"'):
        sp.read_label_volume(tmp_path / "._1.nii")


@pytest.mark.parametrize("packed", ["", ".gz"])
def test_a_pair_is_one_input(tmp_path, packed):
    for number in (1, 2):
        header, voxels = volume_files.nifti_pair(volume_files.egg())
        (tmp_path / f"{number}.hdr").write_bytes(header)
        (tmp_path / f"{number}.img{packed}").write_bytes(
            gzip.compress(voxels) if packed else voxels
        )
    headers = [tmp_path / "1.hdr", tmp_path / "2.hdr"]
    assert files.input_files(tmp_path) == files.input_files(*tmp_path.iterdir()) == headers
    voxels = tmp_path / f"1.img{packed}"
    assert files.input_files(voxels) == [voxels] and files.stem_of(voxels) == "1"
    assert [s.name for s in sp.read_label_volume(voxels).surfaces] == ["1 label 1"]


@pytest.mark.parametrize("locale", ["C", "POSIX", "C.UTF-8"])
def test_names_beyond_ascii_in_every_locale(run_python, tmp_path, locale):
    folder = tmp_path / "h\u00e9rz \u6587"
    folder.mkdir()
    for name, write in (("nii", volume_files.nifti), ("nrrd", volume_files.nrrd)):
        (folder / f"\u00fc.{name}").write_bytes(write(volume_files.egg()))
    found = run_python(
        "import sys, pathlib\n"
        "import sphere_propagation as sp\n"
        "folder = pathlib.Path(sys.argv[1])\n"
        "for name in ('\\u00fc.nii', '\\u00fc.nrrd'):\n"
        "    surface = sp.read_label_volume(folder / name).surfaces[0]\n"
        "    sp.write_ply(folder / '\\u00e9.ply', surface.vertices, surface.faces)\n"
        "    print(ascii(surface.name), ascii(sp.read_mesh(folder / '\\u00e9.ply').name))\n"
        "try: sp.read_label_volume(folder / '\\u00e9.nii')\n"
        "except sp.FilterError as error: print(str(folder) in str(error))",
        str(folder),
        LC_ALL=locale,
    )
    assert found.stdout.splitlines() == ["'\\xfc label 1' '\\xe9'"] * 2 + ["True"], found.stderr


def test_skipping_phases_is_advised_where_some_have_the_label(tmp_path):
    x, y, z = np.indices((24, 24, 24)) - 12
    labels = np.zeros((24, 24, 24, 3), np.uint8)
    labels[(x**2 + y**2 + z**2 < 64)] = 1
    labels[..., 2][labels[..., 2] > 0] = 2
    path = tmp_path / "some.nii"
    path.write_bytes(volume_files.nifti(labels, np.eye(4)))
    series = [tmp_path / f"s_{p}.nii" for p in range(3)]
    for p, file in enumerate(series):
        file.write_bytes(volume_files.nifti(labels[..., p].copy(), np.eye(4)))
    for label, advised in (("1", True), ("2", True), ("3", False)):
        for file, more in ((path, {}), (series[0], {"file_series": True})):
            with pytest.raises(sp.FilterError, match="No voxel has label") as refused:
                sp.read_label_volume(file, labels=label, **more)
            assert ("skip_incomplete_phases" in str(refused.value)) == advised
