# SPDX-License-Identifier: GPL-3.0-only
"""`sphere-propagation cohort`, with Snakemake: a whole study, one that is killed, and what is done
again."""

import os
import re
import shutil
import subprocess
import sys
import time
from pathlib import Path

import pytest
import sphere_propagation as sp
from cohort_inputs import make_input, results, write_subject
from sphere_propagation.cohort import engine, store

PYTHON = Path(sp.__file__).parents[1]
pytestmark = pytest.mark.skipif(
    sys.version_info < (3, 11), reason="Snakemake takes Python 3.11 or later"
)


def command(*words):
    return [sys.executable, "-m", "sphere_propagation", "cohort", *map(str, words)]


def environment():
    return {**os.environ, "PYTHONPATH": str(PYTHON)}


def run(*words, code=0):
    """What it says; its errors where it is to fail."""
    ended = subprocess.run(
        command(*words), capture_output=True, text=True, timeout=600, check=False, env=environment()
    )
    assert ended.returncode == code, ended.stdout + ended.stderr
    return ended.stderr if code in (1, 2) else ended.stdout


@pytest.fixture(scope="module")
def study(tmp_path_factory):
    """Input, study and output of a run that nothing disturbed."""
    pytest.importorskip("snakemake")
    folder = tmp_path_factory.mktemp("cohort")
    make_input(folder / "in", 2)
    (folder / "study.toml").write_text(
        "frequency = 4\nmodes = 8\ncycle_phases = 6\natlas_subjects = 2\n"
    )
    words = folder / "in", folder / "out", "group", "--config", folder / "study.toml"
    said = run(*words, "--cores", 2, code=3)
    return folder, words, said


def until(condition, seconds=120):
    end = time.time() + seconds
    while not condition():
        assert time.time() < end
        time.sleep(0.05)


def test_a_study_from_files_to_models(study):
    folder, _, said = study
    assert "4 subjects in 4 chunks, up to 2 in the atlas" in said
    assert "2 subjects done, 6 surfaces; 2 failed" in said
    assert "sub-90 (import):" in said and "subjects.csv" in said
    model = sp.read_model(folder / "out/model/model.npz")
    assert model.mean.shape == (162, 3) and len(model.scores) == 6
    assert "CPU s" in said and list((folder / "out/costs").glob("landmarks-*.json"))


def test_a_run_that_was_killed_goes_on_to_the_same_bits(study, tmp_path):
    """With its jobs; by another number of cores."""
    folder, words, _ = study
    out = tmp_path / "out"
    words = words[0], out, *words[2:]
    with subprocess.Popen(
        command(*words, "--cores", 2), stdout=subprocess.PIPE, text=True, env=environment()
    ) as killed:
        until((out / "atlas.npz").exists)
        killed.kill()
    time.sleep(0.2)
    assert not (out / "subjects.csv").exists()
    with subprocess.Popen(
        command(*words, "--cores", 1), stdout=subprocess.PIPE, text=True, env=environment()
    ) as resumed:
        until(lambda: (out / ".lock").read_text().startswith(f"process {resumed.pid} "))
        refused = run(*words, "--cores", 1, code=2)
        assert "Another run is at work" in refused and f"process {resumed.pid} on" in refused
        said, _ = resumed.communicate()
    assert resumed.returncode == 3 and "2 subjects done" in said
    assert results(out) == results(folder / "out")
    assert not list(out.rglob("*.part"))


def test_only_what_depends_on_a_change_is_done_again(study):
    folder, words, _ = study
    out = folder / "out"
    assert "0 jobs would run: everything is there" in run(*words, "--dry-run")
    (out / "exclude.csv").write_text("subject\nsub-90\n")
    excluded = run(*words, "--dry-run")
    assert "scatter: 1" in excluded and "landmarks" not in excluded and "import" not in excluded
    (out / "exclude.csv").unlink()
    write_subject(folder / "in/sub-99", 7)
    planned = run(*words, "--dry-run")
    assert "import: 1\n" in planned and "landmarks: 1\n" in planned and "atlas" not in planned
    before = {path: path.stat().st_mtime_ns for path in out.glob("landmarks/*.npy")}
    run(*words, "--cores", 2, code=3)
    assert all(path.stat().st_mtime_ns == then for path, then in before.items())
    assert len(list(out.glob("landmarks/*.npy"))) == len(before) + 1
    assert "sub-99" in (out / "subjects.csv").read_text()


@pytest.mark.parametrize("name", ["landmarks/00000.npy", "report.html", "model/measures.csv"])
def test_a_result_that_was_deleted_is_made_again(study, name):
    folder, words, _ = study
    kept = folder / "kept"
    (folder / "out" / name).rename(kept)
    try:
        assert "everything is there" not in run(*words, "--dry-run")
    finally:
        kept.rename(folder / "out" / name)
    assert "everything is there" in run(*words, "--dry-run")


def test_results_that_are_cut_off_are_made_again(study, tmp_path):
    """As copies of a study and full disks leave them; a dry run changes nothing."""
    out = tmp_path / "out"
    shutil.copytree(study[0] / "out", out)
    words = (study[0] / "in", out, *study[1][2:])
    before = results(out)
    cut, empty = out / "surfaces/00000.npz", out / "landmarks/00001.json"
    whole = cut.read_bytes()
    cut.write_bytes(whole[: len(whole) // 2])
    (out / "landmarks/00000.npy").write_bytes(b"")
    empty.write_bytes(b"")
    says = "3 files of this study that cannot be read, since cut off, are made again where needed: "
    dry = run(*words, "--dry-run")
    assert says + "surfaces/00000.npz, landmarks/00000.npy, landmarks/00001.json" in dry
    assert "import: 1\n" in dry and "landmarks: " in dry and not empty.stat().st_size
    assert says in run(*words, "--cores", 2, code=3)
    assert results(out) == before


def test_a_study_does_not_become_that_of_one_subject(study):
    folder, words, _ = study
    name = sorted(path.name for path in (folder / "in").iterdir())[0]
    said = run(*words, "--participant-label", name, "--dry-run", code=2)
    assert "--participant-label does not name" in said
    words = (words[0], folder / "one", "participant", *words[3:], "--participant-label", name)
    assert run(*words, "--dry-run")


def test_one_subject_makes_no_model(study, tmp_path):
    said = run(study[1][0], tmp_path / "out", "group", "--participant-label", "00", code=2)
    assert "1 subject of 1 can take part" in said and "level participant" in said
    assert not (tmp_path / "out").exists()


def test_a_dry_run_names_whom_the_run_would_leave_out_and_counts_its_jobs(study, tmp_path):
    rows = [f"sub-0{s},{study[0]}/in/sub-0{s}/phase_0.ply" for s in range(2)]
    table = tmp_path / "t.csv"
    table.write_text("\n".join(["subject,file", *rows, "sub-07,none.ply"]) + "\n")
    words = table, tmp_path / "out", *study[1][2:]
    dry = run(*words, "--dry-run", code=3)
    assert "sub-07: There is no file none.ply, which line 4 of t.csv names." in dry
    counted = int(re.search(r"(\d+) jobs would run", dry)[1])
    assert f"{counted} of {counted} jobs done" in run(*words, "--cores", 2, code=3)


def test_errors_name_the_users_files(study):
    """A dry run plans in a folder of its own, of which nobody need know."""
    folder, words, _ = study
    table = folder / "out/exclude.csv"
    table.write_text("subject,exclude\nsub-00,maybe\n")
    try:
        said = run(*words, "--dry-run", code=2)
    finally:
        table.unlink()
    assert f"{table}: line 2 says 'maybe' in the column exclude of sub-00" in said


def test_messages_call_keys_as_the_file_does(study, tmp_path):
    (tmp_path / "study.toml").write_text("voxel_size = -1\n")
    said = run(*study[1][:3], "--config", tmp_path / "study.toml", "--dry-run", code=2)
    assert "voxel_size must be a number" in said and "--voxel-size" not in said


def test_what_is_wrong_is_said_before_anything_runs(study, tmp_path):
    folder, words, _ = study
    (tmp_path / "study.toml").write_text("frequncy = 3\n")
    said = run(
        folder / "in", tmp_path / "out", "group", "--config", tmp_path / "study.toml", code=2
    )
    assert "'frequncy'" in said and "is 'frequency' meant" in said
    assert not (tmp_path / "out").exists()
    none = run(folder / "in", tmp_path / "out", "group", "--config", "nosuch.toml", code=2)
    assert "--config: there is no file nosuch.toml" in none
    assert "choose a new folder" in run(folder / "in", tmp_path, "group", code=2)
    assert "lies in the output" in run(folder / "in", folder / "in", "group", code=2)
    assert "--cores" in run(folder / "in", tmp_path / "out", "group", "--cores", 0, code=2)


def test_without_snakemake_the_line_to_type_is_said(run_python, tmp_path):
    code = (
        "import sys; sys.modules['snakemake'] = None\n"
        "from sphere_propagation.command import main\n"
        "sys.exit(main(['cohort', sys.argv[1], sys.argv[1] + '/out', 'group']))"
    )
    ended = run_python(code, str(tmp_path))
    assert ended.returncode == 1
    assert "pip install 'sphere-propagation[cohort]'" in ended.stderr


def test_a_job_that_fails_says_why(tmp_path):
    log = tmp_path / "logs/atlas.log"
    log.parent.mkdir()
    log.write_text("first\nlast\n")
    assert engine._ends_of(tmp_path, ["logs/atlas.log", "logs/x.log"], []).endswith(
        "last\nlogs/x.log is empty: the job was ended"
    )


def test_a_profile_is_looked_for_where_the_user_stands(tmp_path, monkeypatch):
    (tmp_path / "mine").mkdir()
    monkeypatch.chdir(tmp_path)
    words = engine.command("group", 3, "mine")
    assert words[words.index("--profile") + 1] == str(tmp_path / "mine")
    assert "cluster=1" in words and "cluster=0" in engine.command("group", 3, None)
    assert engine._profile("slurm").endswith("profiles/slurm") and engine._profile("x") == "x"


def test_the_lock_is_let_go_of(tmp_path):
    with (
        engine.lock(tmp_path),
        pytest.raises(sp.InputError, match="Another run"),
        engine.lock(tmp_path),
    ):
        pass
    with engine.lock(tmp_path):
        pass


def test_planning_in_the_shadow_leaves_the_output_as_it_is(tmp_path):
    store.write_json(tmp_path / "plan/a.json", 1)
    with engine.shadow(tmp_path) as folder:
        store.write_json(folder / "plan/a.json", 2)
    assert store.read_json(tmp_path / "plan/a.json") == 1
