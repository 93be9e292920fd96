# SPDX-License-Identifier: GPL-3.0-only
"""The steps of a study, called one by one, without an engine."""

import csv
import faulthandler
import json
import os
import re
import signal
from pathlib import Path

import numpy as np
import pytest
import sphere_propagation as sp
from cohort_inputs import hand, inside, make_input, planned, results, run_steps
from sphere_propagation import errors
from sphere_propagation.cohort import (
    atlas,
    cycles,
    importing,
    landmarks,
    likeness,
    merging,
    store,
    wording,
    worker,
)


@pytest.fixture(scope="module")
def done(tmp_path_factory):
    """Input and output of a study of three subjects, and two that cannot be done."""
    folder = tmp_path_factory.mktemp("study")
    where = make_input(folder / "in")
    planned(where, folder / "out")
    run_steps(folder / "out")
    return where, folder / "out"


def records(output):
    return {
        record["subject"]: record
        for path in sorted((output / "landmarks").glob("*.json"))
        for record in json.loads(path.read_text())["subjects"]
    }


def stacked(output):
    """Of all subjects that were done, (shapes, landmarks, 3)."""
    found = [np.load(path) for path in sorted((output / "landmarks").glob("*.npy"))]
    return np.concatenate(found).reshape(-1, found[0].shape[1] // 3, 3)


def test_landmarks_lie_on_each_subjects_own_surfaces(done):
    where, output = done
    found = records(output)
    assert [name for name, record in found.items() if not record["failed"]] == [
        "sub-00",
        "sub-01",
        "sub-02",
    ]
    record = found["sub-01"]
    assert record["phases"] == 3 and record["flipped_faces"] == [0, 0, 0]
    assert record["names"] == ["phase_0", "phase_1", "phase_2"]
    assert record["root"] == int(np.argmax(record["volume"]))
    assert max(record["residual_mean"]) < 1 and record["fit"]["surface_distance"] < 0.5
    shapes = stacked(output)
    assert shapes.shape == (9, 162, 3) and shapes.dtype == np.float32
    for phase in range(3):
        surface = sp.read_mesh(where / f"sub-01/phase_{phase}.ply")
        away = np.linalg.norm(shapes[3 + phase][:, None] - surface.vertices, axis=2).min(1)
        assert (
            away.max() < 4 and abs(shapes[3 + phase].mean(0) - surface.vertices.mean(0)).max() < 5
        )


def test_what_cannot_be_done_is_listed_with_its_reason_and_left_out(done):
    _, output = done
    found = records(output)
    assert found["sub-90"]["failed"]["step"] == "import"
    assert "cannot be read as a mesh" in found["sub-90"]["failed"]["reason"]
    assert str(output.parent) not in found["sub-90"]["failed"]["reason"]
    assert "open" in found["sub-91"]["failed"]["reason"]
    with open(output / "subjects.csv", newline="", encoding="utf-8") as file:
        rows = {row["subject"]: row for row in csv.DictReader(file)}
    assert [row["status"] for row in rows.values()] == ["done"] * 3 + ["failed"] * 2
    assert rows["sub-91"]["reason"] == found["sub-91"]["failed"]["reason"]
    atlas = json.loads((output / "atlas.json").read_text())
    assert atlas["subjects"] == ["sub-00", "sub-01", "sub-02"]
    assert set(atlas["left_out"]) == {"sub-90", "sub-91"}


def test_the_model_is_that_of_all_shapes_at_once(done):
    _, output = done
    reference = np.load(output / "atlas.npz")["mean"]
    rows = merging.aligned(stacked(output), reference, "Similarity").reshape(9, -1)
    away = rows - rows.mean(0)
    direct = np.linalg.svd(away, compute_uv=False) ** 2 / 8
    model = sp.read_model(output / "model/model.npz")
    assert np.allclose(model.eigenvalues, direct[:8], rtol=1e-8)
    assert np.allclose(model.mean.ravel(), rows.mean(0), atol=1e-9)
    assert np.allclose(
        model.mean + np.tensordot(model.scores, model.modes, 1), rows.reshape(9, -1, 3), atol=1e-6
    )
    assert model.noise_variance < 1e-9
    fitted = sp.fit(model, sp.make_phantom(phases=3, voxel_size=4.0, seed=1)[0])
    assert fitted.figures["surface_distance"] < 0.5


def test_the_models_file_has_names_and_measures(done):
    _, output = done
    model = sp.read_model(output / "model/model.npz")
    assert model.names[:4] == [
        "sub-00 phase_0",
        "sub-00 phase_1",
        "sub-00 phase_2",
        "sub-01 phase_0",
    ]
    with open(output / "model/measures.csv", newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert np.allclose(model.generalisation, [float(row["generalisation"]) for row in rows], 1e-4)
    assert len(model.specificity) == len(rows) == 2 and model.total_variance > 0


@pytest.fixture(scope="module")
def hands(tmp_path_factory):
    """Ten hands; of three more one is in cm, one mirrored, one three times as large. The atlas is
    of nine of the 13, so that some of these are in it and some are not."""
    folder = tmp_path_factory.mktemp("hands")
    (folder / "in").mkdir()
    changes = {2: lambda v: v / 10, 7: lambda v: v * [-1, 1, 1], 11: lambda v: 3 * v}
    for seed in range(13):
        surface = hand(seed)
        vertices = changes.get(seed, lambda v: v)(surface.vertices)
        faces = surface.faces[:, ::-1] if seed == 7 else surface.faces
        sp.write_ply(folder / f"in/h{seed:02d}.ply", vertices, faces)
    planned(folder / "in", folder / "out", atlas_subjects=9)
    run_steps(folder / "out")
    return folder


def rows_of(output):
    with open(output / "subjects.csv", newline="", encoding="utf-8") as file:
        return {row["subject"]: row for row in csv.DictReader(file)}


def test_who_is_in_another_unit_is_left_out_and_who_looks_mirrored_is_named(hands):
    rows = rows_of(hands / "out")
    status = {name: row["status"] for name, row in rows.items() if row["status"] != "done"}
    assert status == {"h02": "left out"}
    assert "times smaller" in rows["h02"]["reason"] and "another unit" in rows["h02"]["reason"]
    assert "mirror image" in rows["h07"]["reason"]
    found = records(hands / "out").items()
    kinds = {name: [one["kind"] for one in of["odd"]] for name, of in found if of["odd"]}
    assert kinds == {"h02": ["another unit"], "h07": ["mirrored"], "h11": ["another size"]}
    atlas = json.loads((hands / "out/atlas.json").read_text())
    assert atlas["sided"] and not {"h02", "h07"} & set(atlas["subjects"])
    with np.load(hands / "out/model/model.npz") as model:
        assert int(model["shapes"]) == 12 and "h02" not in model["names"]


def test_who_is_not_like_the_others_may_be_kept(hands):
    output = hands / "out"
    before = {path: path.stat().st_mtime_ns for path in output.glob("landmarks/*")}
    planned(hands / "in", output, atlas_subjects=9, left_out=["mirrored"])
    with inside(output):
        assert (
            sum(
                len(merging.used(chunk, store.read_json(Path("plan/model.json"))))
                for chunk in store.read_json(Path("plan/chunks.json"))["chunks"]
            )
            == 12
        )
    assert all(path.stat().st_mtime_ns == then for path, then in before.items())


def test_a_subject_with_a_phase_in_another_unit_is_named_and_left_out(done):
    surfaces = sp.make_phantom(phases=3, voxel_size=4.0, seed=1)
    small = surfaces[2]
    surfaces[2] = sp.Surface(small.vertices / 10, small.faces, small.name)
    record = {"subject": "s", "names": [one.name for one in surfaces], "warnings": []}
    with inside(done[1]):
        parameters = store.read_json(Path("plan/landmarks.json"))["parameters"]
        found, _ = landmarks.subject_landmarks(surfaces, record, atlas.read(), parameters)
    (one,) = found["odd"]
    assert one["kind"] == "another unit" and f"its phase {small.name} is" in one["text"]
    assert "times smaller than its others, so in another unit (cm among mm?)" in one["text"]
    assert likeness.left_out(found, {"left_out": ["another unit"]}) == one["text"]


def test_one_whose_side_nobody_can_tell_does_not_hide_the_mirrored():
    def warning(message, *names):
        return sp.SpherePropagationWarning("it is so", message=message, layers=names)

    said = [warning("mirrorImage", "a"), warning("sidesNotKnown", "b", "c")]
    assert likeness.found_in(said, 8)["a"][0]["kind"] == "mirrored"
    assert likeness.found_in(said, 7) == {}
    said = [warning("mirrorImage", "b"), warning("mirrorImage", "c"), warning("mirroredRoot", "a")]
    assert list(likeness.found_in(said, 3)) == ["a"]


def test_the_mirror_image_of_another_subject_and_doubts_are_named():
    others = [hand(seed) for seed in range(5)]
    known = [sp.Surface(h.vertices, h.faces, f"reference {k}") for k, h in enumerate(others)]
    image = sp.Surface(others[2].vertices * [-1, 1, 1], others[2].faces[:, ::-1], "h05")
    found = likeness.judge(image, known, sp.parameterise_root(known[0]), True)
    assert (
        {"mirror image of another"}
        <= {one["kind"] for one in found}
        <= {
            "mirror image of another",
            "mirrored",
        }
    )
    assert any(
        "the exact mirror image of another subject: the same" in one["text"] for one in found
    )
    said = (
        "its mirror image is nearer than itself to 3 of the 5 layers that it was compared with, "
        "while the others agree: is it a left one among right ones? That is not certain, and it "
        "is left as it is; look at it."
    )
    doubt = sp.SpherePropagationWarning.of("a", said, ["a"], "mirrorDoubt")
    other = sp.SpherePropagationWarning.of("b", "it is so.", ["b"], "mirrorImage")
    ((one,),) = likeness.asked_of([doubt, other], 8).values()
    assert one["kind"] == "perhaps mirrored" and "5 subjects that" in one["text"]
    assert one["text"].endswith("That is not certain: look at it") and "left as" not in one["text"]


def test_where_sides_cannot_be_told_nobody_is_called_mirrored(done):
    """Phantoms of ventricles are nearly their own mirror images."""
    assert not any(of.get("odd") for of in records(done[1]).values())


def test_a_surface_that_is_inside_out_fails_at_its_import(tmp_path):
    one = sp.make_phantom(phases=1, voxel_size=4.0, seed=1)[0]
    sp.write_ply(tmp_path / "a.ply", one.vertices, one.faces[:, ::-1])
    entry = {"subject": "a", "files": [{"file": "a.ply"}], "groups": {}, "anchors": None}
    with pytest.raises(worker.Failed, match="inward") as failed:
        importing.import_subject(tmp_path, {**entry, "failed": ""}, {})
    assert str(failed.value).count("inward") == 1


def test_nothing_is_said_of_reflecting():
    """The filter may have done it; a cohort does not."""
    text = next(iter(wording.OF_COHORTS))
    source = Path(__file__).parents[2] / "filter_sphere_propagation/messages.def"
    assert text in re.sub(r'"\s*"', "", source.read_text(encoding="utf-8"))
    assert wording.for_files(f"They differ{text}") == "They differ. Look at them."


def test_advice_is_for_files():
    for table, ours in (
        (errors.FOR_ARRAYS, wording.ADVICE),
        (errors.MESSAGES_FOR_ARRAYS, wording.MESSAGES),
    ):
        for name, (_, advice) in table.items():
            said = wording.for_files(f"There is something. {advice}")
            if name in ours or table is errors.FOR_ARRAYS:
                assert not re.search(r"sp\.prepare\(|np\.|=True|\bfaces\[|scipy", said), name


def test_the_model_of_motion_gives_back_the_cycles(done):
    _, output = done
    found = np.load(output / "cycle/model.npz")
    assert found["mean"].shape == (6, 8) and found["count"] == 3
    with open(output / "cycle/scores.csv", newline="", encoding="utf-8") as file:
        rows = list(csv.reader(file))[1:]
    scores = np.array([[float(word) for word in row[1:]] for row in rows])
    made = found["mean"] + np.tensordot(scores, found["modes"], 1)
    cycle = np.concatenate([np.load(path) for path in sorted(output.glob("scores/*_cycle.npy"))])
    assert np.allclose(made.reshape(3, -1), cycle, atol=1e-3)


def test_another_run_gives_the_same_bits(done, tmp_path):
    where, output = done
    planned(where, tmp_path / "out")
    run_steps(tmp_path / "out")
    assert results(tmp_path / "out") == results(output)


def test_every_output_says_what_it_came_from(done):
    where, output = done
    said = json.loads(next((output / "landmarks").glob("*.json")).read_text())
    assert said["version"] == sp.__version__ and said["parameters"]["frequency"] == 4
    assert said["inputs"]["atlas.npz"] == store.digest(output / "atlas.npz")
    of_model = json.loads((output / "model/model.json").read_text())
    assert of_model["inputs"]["landmarks/00000.npy"] == store.digest(output / "landmarks/00000.npy")
    with np.load(output / "moments/0/00000.npz") as found:
        assert json.loads(str(found["said"]))["parameters"]["alignment"] == "Similarity"
    file = said["subjects"][0]["files"][0]
    assert file["sha256"] == store.digest(where / file["file"])


def test_a_subject_that_crashes_the_program_is_listed_and_the_next_goes_on():
    def work(item):
        if item == "crash":
            faulthandler.disable()
            os.kill(os.getpid(), signal.SIGSEGV)
        if item == "error":
            raise ValueError("no\ngood")
        return item.upper()

    found = list(worker.each(work, ["a", "crash", "error", "b"]))
    assert [place for place, _, _ in found] == [0, 1, 2, 3]
    assert [result for _, result, _ in found] == ["A", None, None, "B"]
    assert "SIGSEGV" in found[1][2] and found[2][2] == "ValueError: no good"


def test_one_that_was_killed_is_tried_again(tmp_path):
    def work(item):
        mark = tmp_path / item
        if item == "b" and not mark.exists():
            mark.touch()
            os.kill(os.getpid(), signal.SIGKILL)
        if item == "c":
            os.kill(os.getpid(), signal.SIGKILL)
        return item

    found = list(worker.each(work, "abcd"))
    assert [result for _, result, _ in found] == ["a", "b", None, "d"]
    assert "SIGKILL" in found[2][2] and "memory" in found[2][2]


def test_a_step_does_not_outlive_who_started_it(run_python):
    """Not even where that one ended before the step began."""
    code = (
        "import os, sys\n"
        "from sphere_propagation.cohort import worker\n"
        "worker.die_with_parent(int(sys.argv[1]) or os.getppid())\n"
        "print('at work')"
    )
    assert run_python(code, "0").stdout == "at work\n"
    ended = run_python(code, "999999999")
    assert ended.returncode == -signal.SIGKILL and not ended.stdout


def test_what_is_the_machines_fault_is_no_subjects():
    def work(item):
        raise OSError(28, "No space left on device")

    with pytest.raises(OSError, match="No space left"):
        list(worker.each(work, "a"))


def test_label_volumes_lack_labels(egg_file):
    entry = {
        "subject": "egg",
        "files": [{"file": egg_file.name}],
        "groups": {},
        "anchors": None,
        "failed": "",
    }
    with pytest.raises(sp.FilterError, match="7"):
        importing.import_subject(egg_file.parent, entry, {"labels": "7"})
    record, surfaces = importing.import_subject(egg_file.parent, entry, {"labels": "1"})
    assert record["phases"] == len(surfaces) == 1 and record["volume"][0] > 0


def test_files_are_written_whole_or_not_at_all(tmp_path):
    path = tmp_path / "a.json"
    store.write_json(path, [1])
    with pytest.raises(RuntimeError), store.whole(path) as part:
        part.write_text("half")
        raise RuntimeError
    assert json.loads(path.read_text()) == [1] and list(tmp_path.iterdir()) == [path]


def test_files_that_are_cut_off_are_found_by_their_ends(tmp_path):
    store.write_json(tmp_path / "plan/a.json", {"a": [1]})
    store.write_arrays(tmp_path / "surfaces/a.npz", {"x": np.zeros((4, 3))})
    for name, count in (("a", 5), ("none", 0)):
        with store.rows(tmp_path / f"landmarks/{name}.npy", 3) as rows:
            rows.add(np.zeros((count, 3)))
    (tmp_path / "cycle").mkdir()
    (tmp_path / "cycle/scores.csv").write_text("subject\n")
    assert store.damaged(tmp_path) == []
    there = sorted(path for path in tmp_path.rglob("*.*") if path.is_file())
    for path in there:
        whole = path.read_bytes()
        for end in (0, len(whole) // 2, len(whole) - 1):
            if path.suffix != ".csv" or end == 0:
                path.write_bytes(whole[:end])
                assert store.damaged(tmp_path) == [path], end
        path.write_bytes(whole)


def test_what_killed_writers_left_is_swept_away(tmp_path):
    (tmp_path / "model").mkdir()
    for name in (".a.npz.7.part", "model/.b.npy.8.part", "kept.part", ".lock"):
        (tmp_path / name).touch()
    store.sweep(tmp_path)
    left = sorted(path.name for path in tmp_path.rglob("*") if path.is_file())
    assert left == [".lock", "kept.part"]


def test_rows_and_archives_are_numpys(tmp_path):
    table = np.arange(12.0).reshape(4, 3)
    with store.rows(tmp_path / "rows.npy", 3) as rows:
        rows.add(table[:1])
        rows.add(table[1:])
    assert np.array_equal(np.load(tmp_path / "rows.npy", mmap_mode="r"), table)
    store.write_arrays(tmp_path / "a.npz", {"x/y": table.T, "n": np.float64(3)})
    found = store.read_arrays(tmp_path / "a.npz")
    assert np.array_equal(found["x/y"], table.T) and found["n"].shape == ()
    before = (tmp_path / "a.npz").read_bytes()
    store.write_arrays(tmp_path / "a.npz", {"x/y": table.T, "n": np.float64(3)})
    assert (tmp_path / "a.npz").read_bytes() == before


def test_a_cycle_begins_at_end_diastole_and_has_end_systole_at_its_share():
    volume = np.array([70.0, 100.0, 80.0, 50.0, 60.0])
    scores = np.stack([volume, np.arange(5.0)], 1)
    found = cycles.resampled(scores, volume, 20, 0.35, True)
    assert found.shape == (20, 2)
    assert found[0, 0] == 100 and found[7, 0] == 50  # 0.35 of 20
    assert np.all(np.diff(found[:8, 0]) < 0) and np.all(np.diff(found[7:, 0]) > 0)
    turned = cycles.resampled(np.roll(scores, 2, 0), np.roll(volume, 2), 20, 0.35, True)
    assert np.allclose(turned, found)
    assert cycles.resampled(scores[:2], volume[:2], 20, 0.35, True) is None
    line = cycles.resampled(scores, volume, 9, 0.35, False)
    assert np.allclose(line[:, 1], np.linspace(0, 4, 9))


def test_one_subject_makes_an_atlas_and_one_shape_no_model(tmp_path):
    where = tmp_path / "in"
    where.mkdir()
    surface = sp.make_phantom(phases=1, voxel_size=4.0)[0]
    sp.write_ply(where / "a.ply", surface.vertices, surface.faces)
    planned(where, tmp_path / "out")
    with pytest.raises(worker.Failed, match="1 shape cannot make a model"):
        run_steps(tmp_path / "out")
    with inside(tmp_path / "out"):
        assert np.load(Path("landmarks/00000.npy")).shape == (1, 486)


def test_errors_of_anchors_name_the_users_file(tmp_path):
    (tmp_path / "plan").mkdir()
    store.write_json(tmp_path / "plan/study.json", {"input": str(tmp_path)})
    of = {"sub-1": "marks/one.csv", "sub-10": "marks/ten.csv"}
    with (
        inside(tmp_path),
        pytest.raises(sp.FileError, match="^marks/ten.csv is no table$"),
        atlas.anchor_folder(of) as folder,
    ):
        raise sp.FileError(f"{folder}/sub-10.csv is no table")


def test_anchors_become_landmarks_of_the_atlas_and_of_everybody(tmp_path):
    """Frames with two anchors, the apex and a place beside it; one subject lacks them."""
    where, marks = tmp_path / "in", tmp_path / "in/marks"
    marks.mkdir(parents=True)
    apex = {}
    for seed in range(3):
        surface = sp.make_phantom(phases=1, voxel_size=4.0, seed=seed)[0]
        name = f"s{seed}"
        sp.write_ply(where / f"{name}.ply", surface.vertices, surface.faces)
        low = surface.vertices[surface.vertices[:, 2].argmin()]
        side = surface.vertices[surface.vertices[:, 0].argmax()]
        apex[name] = low
        if seed < 2:
            rows = [f"{n},{','.join(map(repr, map(float, p)))}" for n, p in zip("as", (low, side))]
            (marks / f"{name}.csv").write_text("\n".join(["name,x,y,z", *rows]) + "\n")
    planned(where, tmp_path / "out", anchors="marks", frequency=10)
    run_steps(tmp_path / "out")
    model = sp.read_model(tmp_path / "out/model/model.npz")
    assert sorted(model.landmark_names) == ["a", "s"]
    found, shapes = records(tmp_path / "out"), stacked(tmp_path / "out")
    assert found["s0"]["anchors"]["sha256"] and found["s2"]["anchors"] is None
    for name, shape in zip(apex, shapes):
        away = np.linalg.norm(shape[model.landmark_names["a"]] - apex[name])
        assert away < (4 if found[name]["anchors"] else 12), name
