# SPDX-License-Identifier: GPL-3.0-only
"""Who takes part, what the study may say, and what is done again when something changes."""

import os
import struct
from pathlib import Path

import pytest
import sphere_propagation as sp
from cohort_inputs import planned
from sphere_propagation.cohort import cohort, memory, plan, store, study, subjects

STUDY = study.Study()


def touched(folder: Path, *names: str) -> Path:
    for name in names:
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(b"x")
    return folder


def found_in(folder, **keys):
    _, found, _ = subjects.find(folder, study.checked(keys), folder)
    return {one.name: one.files for one in found}


def test_a_bids_like_tree(tmp_path):
    touched(
        tmp_path,
        "sub-02/anat/sub-02_dseg.nii.gz",
        "sub-02/anat/sub-02_T1w.nii.gz",
        "sub-10/ses-1/anat/sub-10_ses-1_dseg.nii.gz",
        "sub-10/ses-2/anat/sub-10_ses-2_dseg.nii.gz",
        "sub-1/surf/phase_10.ply",
        "sub-1/surf/phase_2.ply",
        "derivatives/x/sub-1/a.ply",
        "code/a.ply",
    )
    (tmp_path / "sub-3").mkdir()
    (tmp_path / "participants.tsv").write_text("participant_id\tsex\nsub-02\tf\nsub-10\tm\n")
    assert found_in(tmp_path) == {
        "sub-1": ["sub-1/surf/phase_2.ply", "sub-1/surf/phase_10.ply"],
        "sub-02": ["sub-02/anat/sub-02_dseg.nii.gz"],
        "sub-3": [],
        "sub-10_ses-1": ["sub-10/ses-1/anat/sub-10_ses-1_dseg.nii.gz"],
        "sub-10_ses-2": ["sub-10/ses-2/anat/sub-10_ses-2_dseg.nii.gz"],
    }
    _, found, _ = subjects.find(tmp_path, STUDY, tmp_path)
    of = {one.name: one for one in found}
    assert of["sub-02"].groups == {"sex": "f"} and of["sub-10_ses-1"].groups == {"sex": "m"}
    assert "no label volume" in of["sub-3"].failed
    pattern = found_in(tmp_path, files="anat/*_T1w.nii.gz")
    assert pattern["sub-02"] == ["sub-02/anat/sub-02_T1w.nii.gz"]


def test_a_folder_per_subject_and_one_folder_of_files(tmp_path):
    touched(tmp_path / "a", "anna/1.ply", "anna/2.ply", "bob/heart.nii", "readme.txt")
    assert found_in(tmp_path / "a") == {
        "anna": ["anna/1.ply", "anna/2.ply"],
        "bob": ["bob/heart.nii"],
    }
    touched(tmp_path / "b", "h10.nii.gz", "h2.nii.gz", "notes.txt")
    assert found_in(tmp_path / "b") == {"h2": ["h2.nii.gz"], "h10": ["h10.nii.gz"]}


def remarks_on(folder, **keys):
    return "\n".join(subjects.find(folder, study.checked(keys), folder).remarks)


def test_what_is_not_taken_is_named(tmp_path):
    """Beside subjects' folders, in them, and where most subjects' files are chosen otherwise."""
    touched(
        tmp_path,
        *(f"sub-{s}/anat/sub-{s}_dseg.nii.gz" for s in range(4)),
        "sub-0/anat/sub-0_T1w.nii.gz",
        "sub-0/anat/sub-0_dseg.json",
        "sub-4/anat/sub-4_label.nii.gz",
        "sub-5/ses-1/sub-5_dseg.nii.gz",
        "sub-5/anat/sub-5_dseg.nii.gz",
        "sub-3/anat/sub-3_dseg.mgz",
        "derivatives/x/a.nii.gz",
        "others/a.nii.gz",
        "mean.nii.gz",
    )
    (tmp_path / "participants.tsv").write_text(
        "participant_id\tsex\tstatus\n" + "".join(f"sub-{s}\tf\t\n" for s in (0, 1, 2, 3, 5, 77))
    )
    said = remarks_on(tmp_path)
    for words in (
        "1 folder not called sub-… is left out: others",
        "1 file beside the folders of subjects is left out: mean.nii.gz",
        "1 file beside segmentations (_dseg, _mask, _probseg) is left out: "
        "sub-0/anat/sub-0_T1w.nii.gz",
        "1 file beside sessions (ses-…) is left out: sub-5/anat/sub-5_dseg.nii.gz",
        "1 subject has no segmentations (_dseg, _mask, _probseg), as others have, and label "
        "volumes are taken: sub-4",
        "1 file of a kind that is not read is left out: sub-3/anat/sub-3_dseg.mgz",
        "1 column of participants.tsv is left out, because subjects.csv has one of that name: "
        "status",
        "1 subject of participants.tsv is not among the files: sub-77",
        "1 subject is not in participants.tsv, and in no group: sub-4",
    ):
        assert words in said
    assert said.count("\n") == 8


def test_of_files_and_folders_the_more_are_subjects(tmp_path):
    touched(tmp_path / "a", "anna/1.ply", "bob/1.ply", "template.ply")
    assert sorted(found_in(tmp_path / "a")) == ["anna", "bob"]
    assert "beside the folders of subjects is left out: template.ply" in remarks_on(tmp_path / "a")
    touched(tmp_path / "b", "a.ply", "b.ply", "old/a.ply")
    assert sorted(found_in(tmp_path / "b")) == ["a", "b"]
    assert "1 folder beside the 2 files of subjects is left out: old" in remarks_on(tmp_path / "b")
    touched(tmp_path / "c", "a.ply", "b.ply", "readme.txt")
    assert remarks_on(tmp_path / "c") == ""


def test_what_is_not_taken_is_in_the_plan_of_the_report(tmp_path):
    where = touched(tmp_path / "in", "anna/1.ply", "bob/1.ply", "template.ply")
    planned(where, tmp_path / "out")
    assert "template.ply" in store.read_json(tmp_path / "out/plan/report.json")["remarks"][0]


def test_one_file_is_no_two_shapes(tmp_path):
    touched(tmp_path, "in/anna/1.ply", "in/bob/2.ply")
    os.symlink(tmp_path / "in/anna/1.ply", tmp_path / "in/bob/1.ply")
    with pytest.raises(sp.InputError, match="bob: the file bob/1.ply is given and is of anna, too"):
        subjects.find(tmp_path / "in", STUDY, tmp_path)


def test_files_that_are_missing_are_said_before_anything_runs(tmp_path):
    touched(tmp_path, "a.ply")
    (tmp_path / "t.csv").write_text("subject,file\na,a.ply\nb,b.ply\n")
    found = subjects.find(tmp_path / "t.csv", STUDY, tmp_path).subjects
    assert [one.failed for one in found] == [
        "",
        "There is no file b.ply, which line 3 of t.csv names.",
    ]


def test_a_folder_in_a_table_is_called_one(tmp_path):
    touched(tmp_path, "a.ply", "b/1.ply")
    (tmp_path / "t.csv").write_text("subject,file\na,a.ply\nb,b\n")
    found = subjects.find(tmp_path / "t.csv", STUDY, tmp_path).subjects
    assert found[1].failed == "b, which line 3 of t.csv names, is a folder: a row names a file."


def test_participants_without_sub_are_the_same_and_what_is_missing_is_no_group(tmp_path):
    touched(tmp_path, "sub-01/1.ply", "sub-02/1.ply", "sub-03/1.ply")
    (tmp_path / "participants.tsv").write_text("participant_id\tsex\n01\tf\nsub-02\tn/a\n03\tN/A\n")
    _, found, remarks = subjects.find(tmp_path, STUDY, tmp_path)
    assert [one.groups for one in found] == [{"sex": "f"}, {"sex": ""}, {"sex": ""}]
    assert remarks == []


def test_links_to_what_is_not_there_are_named(tmp_path):
    touched(tmp_path, "sub-01/1.ply", "sub-02/1.ply")
    os.symlink(tmp_path / "gone.ply", tmp_path / "sub-02/2.ply")
    os.symlink(tmp_path / "gone", tmp_path / "sub-03")
    said = remarks_on(tmp_path)
    assert said == "2 links to what is not there are left out: sub-02/2.ply, sub-03"


def test_a_table(tmp_path):
    (tmp_path / "study.csv").write_text(
        "subject,phase,file,group,anchors\nb,10,b10.ply,ill,\nb,9,b9.ply,ill,b.csv\n"
        f"a,,{tmp_path}/a.nii,well,\nc,,,ill,\n"
    )
    touched(tmp_path, "a.nii", "b9.ply", "b10.ply", "b.csv")
    base, found, _ = subjects.find(tmp_path / "study.csv", STUDY, tmp_path)
    of = {one.name: one for one in found}
    assert base == tmp_path and list(of) == ["a", "b", "c"]
    assert of["b"].files == ["b9.ply", "b10.ply"] and of["b"].anchors == "b.csv"
    assert of["a"].files == ["a.nii"] and of["a"].groups == {"group": "well"}
    assert "names no file" in of["c"].failed


@pytest.mark.parametrize(
    "text, says",
    [
        ("subject,phase\na,1\n", "lacks the column 'file'"),
        ("subject,file\n", "t.csv has no rows: below the columns' names"),
        ("subject,file\n,a.ply\n", "line 2 says no subject"),
        ("subject,file\na/b,a.ply\n", "becomes the name of files"),
        ("subject,phase,file\na,1,x.ply\na,01,y.ply\n", "line 3 gives a the phase '01' once more"),
        ("subject,file,sex\na,x.ply,f\na,y.ply,m\n", "line 3 says 'm' in the column sex of a"),
        ("subject,file,status\na,x.ply,f\n", "cannot be called 'status'"),
        ("subject,file\na,x.ply\nb,./x.ply\n", "b: the file x.ply is given and is of a, too"),
        ("subject,file\na,x.ply\na,x.ply\n", "a: the file x.ply is given twice"),
        ("subject,file\na,x,y.ply\n", "line 2 has more cells than there are columns"),
    ],
)
def test_tables_that_say_too_little(tmp_path, text, says):
    (tmp_path / "t.csv").write_text(text)
    with pytest.raises(sp.InputError, match=says):
        subjects.find(tmp_path / "t.csv", STUDY, tmp_path)


def test_inputs_that_are_none(tmp_path):
    for where, says in (
        (tmp_path / "none", "There is no file or folder"),
        (tmp_path, "holds no subject"),
        (touched(tmp_path, "a.txt") / "a.txt", "the input is a folder, or a table"),
    ):
        with pytest.raises(sp.InputError, match=says):
            subjects.find(where, STUDY, tmp_path)


def test_some_subjects():
    found = [subjects.Subject("sub-1"), subjects.Subject("sub-2")]
    assert [one.name for one in subjects.chosen(found, ["2"])] == ["sub-2"]
    assert len(subjects.chosen(found, [])) == 2
    with pytest.raises(sp.InputError, match="no subject '3'"):
        subjects.chosen(found, ["3"])


def test_subjects_without_the_root_phase_are_named_before_anything_runs(tmp_path):
    """Meshes are counted; of a NIfTI file the header is read, of others nobody knows."""
    names = [f"a/{k}.ply" for k in range(4)] + ["b/0.ply", "b/1.ply", "d/scan.mha"]
    touched(tmp_path, *names)
    header = bytearray(352)
    header[:4], header[40:50] = (348).to_bytes(4, "little"), struct.pack("<5h", 4, 8, 8, 8, 3)
    (tmp_path / "c").mkdir()
    (tmp_path / "c/scan.nii").write_bytes(header)
    base, found, _ = subjects.find(tmp_path, STUDY, tmp_path)
    failed = {one.name: one.failed for one in cohort._with_root_phases(base, found, 3)}
    assert failed["a"] == failed["d"] == ""
    assert failed["b"] == "root_phase is 3, and it has the phases 0 to 1."
    assert failed["c"] == "root_phase is 3, and it has the phases 0 to 2."
    assert cohort._with_root_phases(base, found, "largest") == found


def test_every_key_has_a_default_that_it_takes():
    assert study.checked({}) == STUDY == study.checked(STUDY.as_dict())
    assert set(study.CHECKS) == set(STUDY.as_dict())


@pytest.mark.parametrize(
    "key, value, says",
    [
        ("labels", "one", "labels must be a label"),
        ("labels", [0], "labels must be a label"),
        ("labels", True, "labels must be a label"),
        ("voxel_size", -1, "voxel_size must be a number of 0 or more"),
        ("smoothing", 7, "smoothing must be a number from 0 to 5"),
        ("order", "alphabetical", 'order must be one of "time", "cyclic time"'),
        ("alignment", 3, 'alignment must be one of "similarity", "rigid", "none"'),
        ("frequency", 2.5, "frequency must be a whole number from 1 to 100"),
        ("frequency", True, "frequency must be a whole number"),
        ("groupwise", "yes", "groupwise must be true or false"),
        ("root_phase", "ED", 'root_phase must be "largest", or the number of a phase'),
        ("atlas_subjects", 500, "atlas_subjects must be a whole number from 1 to 200"),
        ("unit", "a b", "unit must be a short word"),
        ("frequncy", 3, "is 'frequency' meant"),
    ],
)
def test_wrong_keys_and_values_are_named_with_what_is_allowed(tmp_path, key, value, says):
    with pytest.raises(sp.InputError, match=says):
        study.checked({key: value})


def test_a_study_as_a_file(tmp_path):
    path = tmp_path / "study.toml"
    path.write_text('labels = [1, 3]\norder = "cyclic"\nroot_phase = 2\nvoxel_size = 2\n')
    pytest.importorskip("tomllib")
    found, home = study.read_study(path)
    assert found.labels == "1,3" and found.order == "Cyclic time" and found.voxel_size == 2.0
    assert home == tmp_path
    path.write_text("labels = ")
    with pytest.raises(sp.InputError, match="is no TOML file"):
        study.read_study(path)


def times(output):
    return {
        path.relative_to(output).as_posix(): path.stat().st_mtime_ns
        for path in output.rglob("plan/**/*.json")
    }


def changed(output, before):
    now = times(output)
    return sorted(name for name in now if now[name] != before.get(name))


def test_memory_grows_with_the_largest_subject_of_a_chunk(tmp_path):
    where = touched(tmp_path / "in", *(f"s{i:02d}.ply" for i in range(32)))
    (where / "s05.ply").write_bytes(b"x" * 60_000_000)  # 2 million vertices
    planned(where, tmp_path / "out", frequency=20)
    asked = store.read_json(tmp_path / "out/plan/memory.json")
    assert asked["landmarks"]["00000"] == asked["import"]["00000"] == 600
    assert 4000 < asked["landmarks"]["00002"] < 5000 and 6000 < asked["atlas"] < 13000
    assert asked["sums"] > 3 * 8e-6 * (3 * 4002) * 2000
    done = {"subjects": [{"subject": "s05", "vertices": [100_000, 200_000]}]}
    for one in done["subjects"]:
        one.update(files=[], anchors=None)
    store.write_json(tmp_path / "out/surfaces/00002.json", done)
    planned(where, tmp_path / "out", frequency=20)
    asked = store.read_json(tmp_path / "out/plan/memory.json")
    assert 900 <= asked["landmarks"]["00002"] < 1000


def test_how_many_phases_and_voxels_a_file_has(egg_file):
    found = memory.extent(egg_file, egg_file.stat().st_size)
    assert found.phases == 1 and found.voxels > 1000


def test_how_many_subjects_a_job_has_may_be_said(tmp_path):
    where = touched(tmp_path / "in", *(f"s{i:02d}.ply" for i in range(40)))
    assert list(planned(where, tmp_path / "out", chunk=30)["chunks"].values()) == [30, 10]


def test_only_what_changes_is_written_again(tmp_path):
    where = touched(tmp_path / "in", *(f"s{i:02d}.ply" for i in range(40)))
    out = tmp_path / "out"
    made = planned(where, out)
    assert list(made["chunks"].values()) == [3] * 13 + [1] and len(made["levels"]) == 1
    before = times(out)
    planned(where, out)
    assert changed(out, before) == []
    planned(where, out, frequency=5)
    assert changed(out, before) == ["plan/atlas.json", "plan/landmarks.json", "plan/study.json"]
    before = times(out)
    planned(where, out, frequency=5, alignment="rigid")
    assert "plan/landmarks.json" not in changed(out, before)
    planned(where, out, frequency=5)
    before = times(out)
    (out / "exclude.csv").write_text("subject,exclude,why\ns03,yes,moved\ns04,no,\n")
    planned(where, out, frequency=5)
    assert changed(out, before) == ["plan/model.json", "plan/report.json"]
    assert store.read_json(out / "plan/report.json")["why"] == {"s03": "moved"}
    assert store.read_json(out / "plan/model.json")["exclude"] == ["s03"]
    before = times(out)
    (where / "s07.ply").write_bytes(b"xyz")
    planned(where, out, frequency=5)
    assert changed(out, before) == ["plan/import/00002.json"]


def test_new_subjects_leave_the_others_where_they_are(tmp_path):
    where = touched(tmp_path / "in", *(f"s{i:02d}.ply" for i in range(32)))
    out = tmp_path / "out"
    planned(where, out)
    before = times(out)
    touched(where, "a.ply")
    made = planned(where, out)
    assert list(made["chunks"].values()) == [2] * 16 + [1]
    again = changed(out, before)
    assert "plan/import/00016.json" in again and "plan/atlas.json" not in again
    assert not any(name.startswith("plan/import/") for name in again if "00016" not in name)
    os.unlink(where / "s00.ply")  # of the atlas
    planned(where, out)
    assert "s00" not in [name for name, _ in store.read_json(out / "plan/atlas.json")["subjects"]]


def test_fifty_thousand_subjects_are_a_thousand_jobs(tmp_path):
    levels = plan.tree([plan.number(i) for i in range(1000)])
    assert [len(level) for level in levels] == [63, 4, 1]
    names = [f"s{i}" for i in range(50_000)]
    members = plan._members(tmp_path, names, 50)
    assert len(members) == 1000 and {len(those) for those in members.values()} == {50}


def test_a_file_whose_time_alone_has_changed_is_the_same(tmp_path):
    where = touched(tmp_path / "in", "a.ply", "b.ply")
    out = tmp_path / "out"
    planned(where, out)
    file = {"file": "a.ply", "sha256": store.digest(where / "a.ply")}
    store.write_json(
        out / "surfaces/00000.json",
        {"subjects": [{"subject": "a", "files": [file], "anchors": None}]},
    )
    before = times(out)
    os.utime(where / "a.ply", (1, 1))
    planned(where, out)
    assert changed(out, before) == []
    (where / "a.ply").write_bytes(b"y")
    planned(where, out)
    assert changed(out, before) == ["plan/import/00000.json"]


@pytest.mark.parametrize(
    "text, says",
    [
        ("name\na\n", "lacks the column subject"),
        ("subject\nz\n", "no subject 'z'"),
        ("subject,exclude\na,maybe\n", "line 2 says 'maybe' in the column exclude of a: it is yes"),
    ],
)
def test_tables_of_the_excluded(tmp_path, text, says):
    (tmp_path / "x.csv").write_text(text)
    with pytest.raises(sp.InputError, match=says):
        plan.excluded_in(tmp_path / "x.csv", ["a"])
