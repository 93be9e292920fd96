# SPDX-License-Identifier: GPL-3.0-only
"""The command line: what it leaves behind, what it says, how it ends."""

import base64
import csv
import html
import io
import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
import pyvista
import sphere_propagation as sp
from sphere_propagation import (
    command,
    errors,
    files,
    flags,
    model_pictures,
    pictures,
    plugin,
    progress,
)
from sphere_propagation.surface import as_surface

PYTHON = Path(__file__).resolve().parents[2] / "python"
FRAME = r'<iframe [^>]*data-page="([^"]+)"'  # the report's explorer


def write(folder, surfaces):
    folder.mkdir(exist_ok=True)
    for surface in surfaces:
        sp.write_ply(folder / f"{surface.name}.ply", surface.vertices, surface.faces)
    return folder


@pytest.fixture
def heart(cycle, tmp_path):
    return write(tmp_path / "heart", cycle.surfaces[:3])


def run(*arguments):
    return command.main([str(argument) for argument in arguments])


def rows(folder):
    with open(folder / "figures.csv", newline="") as file:
        return list(csv.DictReader(file))


def test_a_folder_of_meshes(heart, tmp_path, capsys):
    out = tmp_path / "out"
    assert run("run", heart, "-o", out, "--frequency", 3) == 0
    said = capsys.readouterr().out
    assert str(out) in said and re.search(r"heart +Robust +3 +0 ", said)
    # The largest volume is end-diastole.
    assert [row["root"] for row in rows(out)] == ["1", "0", "0"]
    made = (
        "landmarks.png",
        "checkerboard.png",
        "map.png",
        "modes.png",
        "model.png",
        "scores.png",
        "volume.png",
    )
    assert sorted(path.name for path in out.glob("*.png")) == sorted(made)
    for name in (*made, "heart/heart.mlp", "heart/heart_overview.mlp"):
        assert (out / name).stat().st_size > 1000
    page = (out / "report.html").read_text()
    assert [
        base64.b64decode(data) for data in re.findall(r'src="data:image/png;base64,([^"]+)"', page)
    ] == [(out / name).read_bytes() for name in made]
    assert_that_it_is_one_file(page)


def assert_that_it_is_one_file(page):
    """Nothing is fetched: every source is data, and no sheet, script or link leads out. The page to
    explore the model is the only frame; by its policy it can fetch nothing either."""
    for frame in re.findall(FRAME, page):
        assert "default-src 'none'; style-src 'unsafe-inline'" in html.unescape(frame)
    page = re.sub(FRAME, "", page)
    assert set(re.findall(r'src="(.{5})', page)) <= {"data:"}
    assert not re.search(
        r"<(script|link|iframe)|url\(|href=|https?://", re.sub(r'src="data:[^"]+"', "", page)
    )


def test_it_builds_the_shape_model(heart, tmp_path, capsys):
    out = tmp_path / "out"
    assert run("run", heart, "-o", out, "--frequency", 3, "--no-pictures") == 0
    said = capsys.readouterr().out
    assert re.search(
        r"heart: shape model: 2 modes, the first with [\d.]+ % of the variance, [12] for 95 %", said
    )
    assert "heart/model.npz" in said
    landmarks = [
        sp.read_mesh(path).vertices for path in sorted((out / "heart/landmarks").iterdir())
    ]
    with np.load(out / "heart/model.npz") as file:
        model = dict(file)
    assert model["scores"].shape == (3, 2) and model["mean"].shape == (92, 3)
    again = sp.shape_model(np.array(landmarks), model["faces"])
    assert again.eigenvalues == pytest.approx(model["eigenvalues"], rel=1e-4)  # files hold floats
    with open(out / "heart/scores.csv", newline="") as file:
        table = list(csv.reader(file))
    assert table[0] == ["shape", "mode_1", "mode_2"] and [line[0] for line in table[1:]] == [
        path.stem for path in sorted(heart.iterdir())
    ]
    assert np.array_equal(np.array([line[1:] for line in table[1:]], float), model["scores"])
    with open(out / "heart/model.csv", newline="") as file:
        measures = list(csv.DictReader(file))
    assert [line["modes"] for line in measures] == ["1", "2"] and float(
        measures[1]["variance_share"]
    ) == pytest.approx(1)
    assert [float(line["eigenvalue"]) for line in measures] == pytest.approx(
        model["eigenvalues"], rel=1e-9
    )


@pytest.mark.parametrize("name", ["../evil", "a/b", "..", ""])
def test_a_name_that_is_a_path_is_refused_before_any_work(heart, tmp_path, capsys, name):
    assert run("run", heart, "-o", tmp_path / "out" / "sub", "--name", name) == 2
    assert "plain name" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


def test_options_reach_the_filters(heart, tmp_path, capsys):
    out = tmp_path / "out"
    files = sorted(heart.iterdir())
    assert (
        run(
            "run",
            *files,
            "-o",
            out,
            "--name",
            "given",
            "--parents",
            "2,0,-1",
            "--method",
            "published",
            "--frequency",
            2,
            "--area-weight",
            0.5,
            "--no-pictures",
        )
        == 0
    )
    found = rows(out)
    assert [row["parent"] for row in found] == ["2", "0", "-1"] and {
        row["method"] for row in found
    } == {"As published"}
    assert {row["data"] for row in found} == {"given"} and not list(out.glob("*.png"))
    assert len(sp.read_mesh(next((out / "given/landmarks").iterdir())).vertices) == 42
    softer = float(found[2]["area_ratio_sd"])
    assert run("run", *files, "-o", out, "--root", 2, "--method", "published", "--no-pictures") == 0
    assert softer > 2 * float(rows(out)[2]["area_ratio_sd"])
    # Nothing of the first run is left.
    assert not (out / "given").exists() and (out / "heart").exists()


def test_notes_of_what_was_not_said(heart, tmp_path, capsys):
    """The unit where nobody named it, and what shapes in no order gain by."""
    for given, told in (
        ([], (True, False)),
        (["--unit", "cm"], (False, False)),
        (["--order", "similarity"], (True, True)),
        (["--order", "star", "--groupwise", "--unit", "mm"], (False, False)),
    ):
        more = ("--frequency", 2, "--no-pictures")
        assert run("run", heart, "-o", tmp_path / "out", *given, *more) == 0
        said = capsys.readouterr().out
        assert ("--unit says another one" in said, "gain by --groupwise" in said) == told


def test_the_phantom(tmp_path, capsys):
    assert (
        run(
            "demo",
            tmp_path,
            "--phases",
            3,
            "--voxel-size",
            4,
            "--seed",
            1,
            "--frequency",
            2,
            "--no-pictures",
        )
        == 0
    )
    found = rows(tmp_path)
    assert len(found) == 15 and {(row["data"], row["method"]) for row in found} == {
        ("scan", "Robust"),
        *((data, method) for data in ("cavity", "wall") for method in ("Robust", "As published")),
    }
    assert all(
        row["error_mm"] == "" if row["data"] == "scan" else 0 <= float(row["error_mm"]) < 12
        for row in found
    )
    assert len(sp.read_label_volume(tmp_path / "scan/scan.nii.gz").surfaces) == 3
    with np.load(tmp_path / "scan/model.npz") as model:
        assert model["scores"].shape == (3, 2)
    page = (tmp_path / "report.html").read_text()
    assert_that_it_is_one_file(page)
    assert re.findall("<h2>(.*?)</h2>", page) == [
        "From a label volume to a shape model",
        "How right is it? Fine surfaces whose truth is known",
        "How this was made",
    ]
    assert len(re.findall(FRAME, page)) == 1
    page = re.sub(FRAME, "", page)
    assert (
        page.count("phantom wall 02") == 2
        and page.count("scan label 1 phase 02") == 1
        and "<img" not in page
    )


def test_the_phantom_in_pictures(tmp_path, capsys):
    assert run("demo", tmp_path, "--phases", 3, "--voxel-size", 4, "--frequency", 2) == 0
    made = sorted(path.name for path in tmp_path.glob("*.png"))
    of_the_scan = [
        "checkerboard.png",
        "landmarks.png",
        "map.png",
        "model.png",
        "modes.png",
        "scores.png",
        "volume.png",
    ]
    assert made == sorted(
        [
            *of_the_scan,
            "error.png",
            "truth_checkerboard.png",
            "truth_landmarks.png",
            "truth_map.png",
        ]
    )
    assert (tmp_path / "report.html").read_text().count("<img") == len(made)


def test_the_phantom_where_label_volumes_cannot_be_read(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr(plugin, "volume_failure", lambda: "ITK is missing.")
    assert (
        run("demo", tmp_path, "--phases", 2, "--voxel-size", 4, "--frequency", 2, "--no-pictures")
        == 0
    )
    assert "no scan: label volumes cannot be read here. ITK is missing." in capsys.readouterr().out
    assert {row["data"] for row in rows(tmp_path)} == {"cavity", "wall"} and not (
        tmp_path / "scan"
    ).exists()


def test_the_demos_input_is_the_same_as_run(heart, tmp_path, capsys):
    assert run("demo", tmp_path / "a", "--input", heart, "--no-pictures") == 0
    assert run("run", heart, "-o", tmp_path / "b", "--no-pictures") == 0
    for name in ("heart/heart.mlp", "heart/landmarks/phantom_cavity_01_landmarks.ply"):
        assert (tmp_path / "a" / name).read_bytes() == (tmp_path / "b" / name).read_bytes()


def test_without_the_packages_for_pictures(heart, tmp_path, capsys, monkeypatch):
    monkeypatch.setattr(pictures, "NEEDED", ("matplotlib", "no_such_package"))
    assert run("run", heart, "-o", tmp_path / "out") == 0
    said = capsys.readouterr().out
    assert "no pictures: no_such_package not installed" in said and "[pictures]" in said
    assert (tmp_path / "out/figures.csv").exists() and not list((tmp_path / "out").glob("*.png"))


def test_without_a_display(heart, tmp_path, capsys, monkeypatch):
    """VTK crashes where it finds neither a display nor EGL."""

    def load(name):
        raise OSError(name)

    monkeypatch.delenv("DISPLAY", raising=False)
    monkeypatch.setattr(pictures.ctypes, "CDLL", load)
    assert run("run", heart, "-o", tmp_path / "out") == 0
    assert "libEGL.so.1 is missing" in capsys.readouterr().out and not list(
        (tmp_path / "out").glob("*.png")
    )


def test_info(capsys):
    assert run("info") == 0
    said = capsys.readouterr().out
    assert re.search(r"pymeshlab +2025\.7", said) and re.search(
        rf"sphere-propagation +{sp.__version__}\n", said
    )


def test_warnings_are_lines(cycle, heart, tmp_path, capsys):
    big = cycle.surfaces[2]
    write(heart, [sp.Surface(big.vertices * 10, big.faces, big.name)])
    assert run("run", heart, "-o", tmp_path / "out", "--root", 0, "--no-pictures") == 0
    said = capsys.readouterr()
    lines = said.err.splitlines()
    assert lines and all(line.startswith(f"warning: {big.name}: ") for line in lines)
    assert "warning: " not in said.out
    with open(tmp_path / "out/warnings.csv", newline="") as file:
        listed = list(csv.DictReader(file))
    assert [f"warning: {row['layer']}: {row['text']}" for row in listed] == lines
    page = (tmp_path / "out/report.html").read_text()
    assert all(html.escape(row["text"]) in page for row in listed)


def refusal(capsys, *arguments, code=1):
    assert run(*arguments) == code
    said = capsys.readouterr().err
    assert said.startswith("error: ") and said.count("\n") == 1 and "Traceback" not in said
    return said


def test_refusals_name_what_is_wrong(cycle, heart, tmp_path, capsys):
    out = tmp_path / "out"
    assert "There is no file or folder" in refusal(capsys, "run", tmp_path / "nowhere", "-o", out)
    (tmp_path / "empty").mkdir()
    assert "holds no mesh" in refusal(capsys, "run", tmp_path / "empty", "-o", out)
    assert "choose another" in refusal(capsys, "run", heart, "-o", tmp_path, code=2)
    (tmp_path / "file").touch()
    said = refusal(capsys, "run", heart, "-o", tmp_path / "file", code=2)
    assert "file is a file: results go into a folder" in said
    opened = sp.Surface(
        cycle.surfaces[2].vertices, cycle.surfaces[2].faces[1:], cycle.surfaces[2].name
    )
    write(heart, [opened])
    assert (
        opened.name in refusal(capsys, "run", heart, "-o", out)
        and not (out / "figures.csv").exists()
    )
    (heart / "broken.ply").write_text("hello")
    assert "broken.ply cannot be read as a mesh" in refusal(capsys, "run", heart, "-o", out)
    (heart / "broken.stl").touch()
    assert "same name" in refusal(capsys, "run", heart, "-o", out)


def test_wrong_arguments_end_with_2(capsys):
    for arguments in (
        [],
        ["run"],
        ["run", "x"],
        ["run", "x", "-o", "y", "--order", "none"],
        ["nothing"],
    ):
        with pytest.raises(SystemExit) as end:
            command.main(arguments)
        assert end.value.code == 2


@pytest.mark.parametrize(
    "option, value, words",
    [
        ("--frequency", "0", "'0' is not a whole number of 1 or more"),
        ("--frequency", "ten", "'ten' is not a whole number of 1 or more"),
        ("--area-weight", "2", "'2' is not a number from 0 to 1"),
        ("--area-restoration", "-1", "'-1' is not a number from 0 to 1"),
        ("--area-restoration", "nan", "'nan' is not a number from 0 to 1"),
        ("--root", "-1", "'-1' is not a whole number of 0 or more, nor most-central"),
        ("--order", "none", "'none' is none of time, cyclic, similarity, star"),
        ("--export", "x", "'x' is none of h5, json, particles, ply, all"),
    ],
)
def test_values_that_options_do_not_take_end_with_2(capsys, option, value, words):
    """In the words of errors in files: what is meant, and what is wrong with it."""
    with pytest.raises(SystemExit) as end:
        run("run", "x", "-o", "y", option, value)
    said = capsys.readouterr().err
    assert end.value.code == 2 and said.splitlines()[0] == f"error: {option}: {words}"
    assert said.splitlines()[1:] == ["sphere-propagation run --help lists what there is."]


def test_choices_are_understood_as_the_filters_have_them_too():
    """Of every command; in any case."""
    parse = command.parser().parse_args
    for short, full in command.ORDERS.items():
        for word in (short, full, full.upper(), full.replace(" ", "-")):
            assert parse(["run", "x", "-o", "y", "--order", word]).order == full
            assert parse(["morph", "x", "--order", word]).order == full
            assert parse(["explore", "x", "--order", word]).order == full
    for option, names in (("connectivity", command.CONNECTIVITIES), ("along", command.PATHS)):
        for short, full in names.items():
            for word in (short, full):
                assert getattr(parse(["morph", "x", f"--{option}", word]), option) == full
    for word in ("as-it-lies", "As it lies", "AS IT LIES"):
        assert parse(["fit", "m", "x", "--pose", word]).pose == "as-it-lies"
    assert parse(["fit", "m", "x", "--alignment", "As the model"]).alignment == "as-the-model"
    # And older names of options.
    assert parse(["explore", "x", "--cyclic"]).order == command.ORDERS["cyclic"]
    for word in ("--labels", "--label"):
        assert parse(["fit", "m", "x", word, "2"]).label == "2"
    for words in (["-o", "y", "--coordinates", "LPS"], ["--to", "y", "--space", "lps"]):
        options = parse(["convert", "x", *words])
        assert (options.to, options.space) == ("y", "lps")


def test_an_option_that_there_is_not_is_looked_for_in_its_command(capsys):
    with pytest.raises(SystemExit) as end:
        run("run", "x", "-o", "y", "--ordr", "cyclic")
    assert end.value.code == 2
    assert capsys.readouterr().err.splitlines() == [
        "error: --ordr cyclic: there is no such option",
        "sphere-propagation run --help lists what there is.",
    ]


@pytest.mark.parametrize(
    "option, words",
    [
        ("--root=9", "Layer 9 cannot be the root"),
        ("--frequency=900", "frequency must lie between 1 and 816"),
        ("--parents=-1,0", "parents: 2 numbers for 3 surface layers"),
        ("--parents=-1,0,3", "from layer 3, which is not a visible surface layer"),
        ("--parents=-1,0,-1", "is marked as the root (-1), but so is layer 0"),
        ("--parents=-1,2,1", "would get its map from itself"),
        ("--parents=0,0,1", "No layer is marked as the root"),
        ("--parents=a,b,c", "whole numbers"),
    ],
)
def test_arguments_that_do_not_fit_the_meshes_end_with_2_before_any_work(
    heart, tmp_path, capsys, option, words
):
    (heart / "phantom cavity 00.ply").write_text("not read")
    assert words in refusal(capsys, "run", heart, "-o", tmp_path / "out", option, code=2)
    assert not (tmp_path / "out").exists() and capsys.readouterr().out == ""


@pytest.mark.parametrize(
    "given", [["--parents", "-1,0,1"], ["--parents=-1,0,1"], ["--parents", "-1, 0, 1"]]
)
def test_parents_that_begin_with_the_root(heart, tmp_path, given):
    """argparse by itself takes -1,0,1 for an option."""
    assert run("run", heart, "-o", tmp_path / "out", *given, "--frequency", 2, "--no-pictures") == 0
    assert [row["parent"] for row in rows(tmp_path / "out")] == ["-1", "0", "1"]


@pytest.fixture
def bars(monkeypatch):
    """The bars of the commands that run, which are drawn nowhere."""
    made = []

    def on_a_terminal(steps, stream=None):
        made.append(progress.Bar(steps, Terminal()))
        return made[-1]

    monkeypatch.setattr(progress, "for_stream", on_a_terminal)
    return made


@pytest.mark.parametrize("pictures_too", [True, False])
def test_a_bar_is_full_when_all_is_done(heart, tmp_path, bars, monkeypatch, pictures_too):
    for module, names in (
        (pictures, ("landmarks_on_surfaces", "maps_on_surfaces", "root_and_sphere")),
        (pictures, ("errors_over_phase",)),
        (model_pictures, ("modes", "measures", "scores", "volumes")),
    ):
        for name in names:
            monkeypatch.setattr(module, name, lambda *given, **more: None)
    more = [] if pictures_too else ["--no-pictures"]
    assert run("run", heart, "-o", tmp_path / "run", "--frequency", 2, *more) == 0
    demo = ("demo", tmp_path / "demo", "--phases", 3, "--voxel-size", 4, "--frequency", 2)
    assert run(*demo, *more) == 0
    assert [bar.finished for bar in bars] == [bar.steps for bar in bars] and len(bars) == 2


def test_the_phantoms_root_is_that_of_its_parents(tmp_path, capsys):
    demo = ("demo", tmp_path, "--phases", 3, "--voxel-size", 4, "--frequency", 2, "--no-pictures")
    assert run(*demo, "--parents=1,-1,1") == 0
    assert {(row["layer"][-2:], row["root"]) for row in rows(tmp_path)} == {
        ("00", "0"),
        ("01", "1"),
        ("02", "0"),
    }


def test_the_demo_has_all_options_of_run(heart, tmp_path, capsys):
    def options_of(name):
        actions = command.parser()._subparsers._group_actions[0].choices[name]._actions
        return {word for action in actions for word in action.option_strings}

    assert options_of("run") - options_of("demo") == {"-o", "--output"}
    out = tmp_path / "out"
    more = ("--name", "beat", "--unit", "cm", "--frequency", 2, "--no-pictures")
    assert run("demo", out, "--input", heart, *more) == 0
    assert (out / "beat/beat.mlp").is_file() and "cm" in (out / "figures.csv").read_text()


@pytest.mark.parametrize(
    "given, words",
    [
        (["--unit", "cm"], "--unit is for your own files"),
        (["--prepare"], "--prepare is for your own files"),
        (["--input", "x", "--seed", 0], "--seed is of the phantom"),
        (["--input", "x", "--phases", 9], "--phases is of the phantom"),
    ],
)
def test_what_the_demo_cannot_heed_is_refused(tmp_path, capsys, given, words):
    assert words in refusal(capsys, "demo", tmp_path / "out", *given, code=2)
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    "option, words",
    [
        ("--voxel-size=9", "voxel size in mm must lie between 0.25 and 4"),
        ("--phases=10001", "phases must lie between"),
    ],
)
def test_arguments_that_make_no_phantom_end_with_2(tmp_path, capsys, option, words):
    assert words in refusal(capsys, "demo", tmp_path / "out", option, "--frequency", 1, code=2)
    assert not (tmp_path / "out").exists()


def test_a_single_mesh(heart, tmp_path, capsys):
    assert "gives one surface" in refusal(
        capsys, "run", next(iter(heart.iterdir())), "-o", tmp_path / "out", code=2
    )


def test_interrupting_it(tmp_path):
    """Ctrl-C ends it when the filter that runs is done: one line, no traceback, 130."""
    program = (
        "import signal, sys, _sphere_propagation_command as command\n"
        "signal.signal(signal.SIGINT, signal.default_int_handler)\n"  # ignored in the background
        "sys.exit(command.main())"
    )
    process = subprocess.Popen(
        [sys.executable, "-c", program, "demo", tmp_path / "out", "--phases", "60"],
        cwd=PYTHON,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    process.stdout.readline()  # the first step is over
    process.send_signal(signal.SIGINT)
    said, errors = process.communicate(timeout=300)
    assert process.returncode == 130 and errors == "interrupted\n"


@pytest.mark.parametrize("arguments", [["info"], ["demo", "--help"]])
def test_a_reader_that_has_seen_enough(arguments, monkeypatch):
    monkeypatch.delenv("PYTHONUNBUFFERED", raising=False)
    process = subprocess.Popen(
        [sys.executable, "-m", "_sphere_propagation_command", *arguments],
        cwd=PYTHON,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
    )
    process.stdout.close()
    assert process.stderr.read() == b"" and process.wait(60) == 141
    process.stderr.close()


def test_what_goes_wrong_at_import_is_said_without_a_traceback(run_python, tmp_path):
    found = run_python(
        "import sys, _sphere_propagation_command as command; sys.exit(command.main())",
        "info",
        SPHERE_PROPAGATION_PLUGIN=str(tmp_path / "nothing.so"),
    )
    assert (
        found.returncode == 1
        and found.stderr.startswith("error: There is no plugin at")
        and "Traceback" not in found.stderr
    )


class Terminal(io.StringIO):
    def isatty(self):
        return True


def test_a_bar_on_a_terminal_lines_elsewhere():
    assert type(progress.for_stream(3, io.StringIO())) is progress.Lines
    screen = Terminal()
    bar = progress.for_stream(2, screen)
    bar.begin("first")
    bar.done("first is over")
    bar.begin("second")
    time.sleep(0.6)  # the clock ticks once
    bar.done("second is over")
    bar.close()
    bar.close()
    said = screen.getvalue()
    assert (
        "[....................] 1/2  first" in said and "[##########..........] 2/2  second" in said
    )
    assert said.count("2/2  second") >= 2
    assert re.search(r"\r\x1b\[K\[ +0\.\d s\] first is over\n", said) and said.endswith("\r\x1b[K")


def warned(folder):
    with open(folder / "warnings.csv", newline="") as file:
        return list(csv.DictReader(file))


def test_a_mirrored_mesh_gets_advice_in_the_commands_words(cycle, tmp_path, capsys):
    # Bent to one side, or it would be its own mirror image.
    bent = [
        sp.Surface(s.vertices + np.c_[0 * (x := s.vertices[:, 2]), x**2 / 60, 0 * x], s.faces, name)
        for s, name in zip(cycle.surfaces, "abc")
    ]
    bent = [
        sp.Surface(
            s.vertices + np.c_[s.vertices[:, 1] ** 2 / 90, 0 * s.vertices[:, :2]], s.faces, n
        )
        for s, n in zip(bent, "abc")
    ]
    bent[1] = sp.Surface(bent[1].vertices * [-1, 1, 1], bent[1].faces[:, ::-1], "b")
    folder, out = write(tmp_path / "bones", bent), tmp_path / "out"
    arguments = ["run", folder, "-o", out, "--root", 0, "--frequency", 2, "--no-pictures"]
    assert run(*arguments) == 0
    said = capsys.readouterr().err
    assert "--mirror-layers reflects it" in said and "mirror_layers" not in said
    texts = [row["text"] for row in warned(out) if row["message"] == "mirrorImage"]
    assert len(texts) == 1 and "--mirror-layers reflects" in texts[0]
    # Which morph has as well.
    words = ["morph", folder, "-o", tmp_path / "between", "--steps", 1, "--frequency", 2]
    assert run(*words) == 0 and "--mirror-layers reflects it" in capsys.readouterr().err
    assert run(*words, "--mirror-layers") == 0
    said = capsys.readouterr().err
    assert "--mirror-layers reflects it" not in said and "reflected" in said


def test_an_open_mesh_is_prepared_on_request(heart, tmp_path, capsys):
    """The advice names the option, which does what it says."""
    whole = sp.read_mesh(next(heart.glob("*.ply")))
    height = whole.vertices[whole.faces][:, :, 2].max(1)
    sp.write_ply(heart / "open.ply", whole.vertices, whole.faces[height < np.quantile(height, 0.8)])
    out = tmp_path / "out"
    arguments = ["run", heart, "-o", out, "--frequency", 2, "--no-pictures"]
    assert run(*arguments) == 1
    said = capsys.readouterr().err
    assert "run --prepare closes it" in said and "sp." not in said
    assert run(*arguments, "--prepare") == 0
    assert re.search(
        r"warning: open: it was prepared: .* 1 opening closed", capsys.readouterr().err
    )
    assert [row["layer"] for row in warned(out) if row["message"] == "prepared"] == ["open"]
    assert run(*arguments, "--remove-handles") == 2


def test_flags_are_options_and_paths_are_left_alone():
    options = {
        action.dest
        for action in command.parser()._subparsers._group_actions[0].choices["run"]._actions
    }
    assert set(flags.PARAMETERS) <= options
    for text in ("a/mirror_layers/x.ply", "mirror_layers.ply", "my_voxel_size", "C:\\voxel_size"):
        assert flags.by_flags(text) == text
    assert flags.by_flags('with align_slices ("Align slices").') == "with --align-slices."


def test_a_run_that_fails_leaves_no_empty_folder(cycle, tmp_path, capsys):
    files.write_ply(tmp_path / "a.ply", cycle.surfaces[0].vertices, cycle.surfaces[0].faces)
    files.write_ply(tmp_path / "b.ply", cycle.surfaces[1].vertices, cycle.surfaces[1].faces[1:])
    words = ["run", str(tmp_path / "a.ply"), str(tmp_path / "b.ply"), "--no-pictures", "-o"]
    assert command.main([*words, str(tmp_path / "results")]) == 1
    assert not (tmp_path / "results").exists()
    (tmp_path / "there").mkdir()
    assert command.main([*words, str(tmp_path / "there")]) == 1
    assert (tmp_path / "there").is_dir()


def test_no_output_takes_the_place_of_an_input(cycle, heart, tmp_path, capsys):
    """Whatever the command, and whatever the file is called: by a link, or as a folder above."""
    model = tmp_path / "m" / "model.npz"
    model.parent.mkdir()
    sp.shape_model(cycle.landmarks, cycle.landmark_faces, export_file=str(model))
    new = tmp_path / "new.ply"
    meshes = sorted(heart.glob("*.ply"))
    new.write_bytes(meshes[0].read_bytes())
    (tmp_path / "link.npz").symlink_to(model)
    (tmp_path / "ring.ply").symlink_to(meshes[1])
    (tmp_path / "out").mkdir()
    os.link(meshes[1], tmp_path / "out" / meshes[0].name)
    before = {path: path.read_bytes() for path in tmp_path.rglob("*") if path.is_file()}
    for words in (
        ["explore", model, "-o", model],
        ["explore", model, "-o", tmp_path / "link.npz"],
        ["fit", model, *meshes[:2], "-o", heart],
        ["fit", model, tmp_path / "ring.ply", "-o", heart],
        ["fit", model, new, "-o", model.parent],
        ["fit", model, new, "-o", tmp_path],
        ["fit", model, new, "--anchors", tmp_path / "m", "-o", tmp_path / "m"],
        ["morph", heart, "-o", heart],
        ["morph", *meshes, "-o", tmp_path],
        ["run", heart, "-o", heart],
        ["run", heart, "--anchors", model.parent, "-o", model.parent],
        ["run", heart, "--anchor-positions", model, "-o", model.parent],
        ["demo", heart, "--input", heart],
        ["demo", model.parent, "--anchors", model.parent],
        ["convert", *meshes[:2], "--to", tmp_path / "out", "--overwrite"],
    ):
        assert run(*words) == 2, words
        assert re.search("lies in the output|cannot be the output", capsys.readouterr().err), words
        assert {p: p.read_bytes() for p in tmp_path.rglob("*") if p.is_file()} == before


def test_an_output_that_cannot_be_written_is_found_before_the_work(
    cycle, heart, tmp_path, capsys, monkeypatch
):
    model = tmp_path / "model.npz"
    sp.shape_model(cycle.landmarks, cycle.landmark_faces, export_file=str(model))
    (tmp_path / "locked").mkdir()
    allowed = os.access  # which root is everywhere
    monkeypatch.setattr(
        os, "access", lambda path, *mode: Path(path).name != "locked" and allowed(path, *mode)
    )
    for name in ("read_mesh", "read_meshes", "surface_in"):
        monkeypatch.setattr(files, name, lambda *_: pytest.fail("it has begun"))
    out = tmp_path / "locked" / "out"
    for words in (
        ["run", heart, "-o", out],
        ["fit", model, heart, "-o", out],
        ["morph", heart, "-o", out],
        ["convert", heart, "--to", out],
        ["explore", model, "-o", tmp_path / "locked" / "page.html"],
    ):
        assert run(*words) == 1, words
        assert f"Nothing can be written to {tmp_path / 'locked'}" in capsys.readouterr().err
    assert run("explore", model, "-o", tmp_path / "locked") == 1
    assert "is a folder: name the page in it" in capsys.readouterr().err
    assert run("explore", model, "-o", tmp_path / "none" / "page.html") == 1
    assert "There is no folder" in capsys.readouterr().err


def test_advice_of_the_command_is_no_code():
    advice = [*errors.FOR_ARRAYS.values(), *errors.MESSAGES_FOR_ARRAYS.values()]
    for text in (flags.by_flags(ours) for _, ours in advice):
        assert not re.search(r"\[|\bnp\.|\bsp\.|pymeshlab|scipy|=True|=False", text), text


def test_what_the_command_advises_helps():
    """Of faults that it has words of its own for."""
    sphere = as_surface(pyvista.Sphere(theta_resolution=12, phi_resolution=12))
    vertices, faces = sphere.vertices, sphere.faces
    bare = vertices.copy()
    bare[50] = np.nan
    for v, f in (
        (vertices, faces[:, ::-1]),
        (bare, faces),
        (np.r_[vertices, [[5, 5, 5]]], faces),
        (vertices, np.r_[faces, [[1, 1, 2]]]),
        (vertices, faces[:-1]),
        (vertices[faces].reshape(-1, 3), np.arange(faces.size).reshape(-1, 3)),
        (np.r_[vertices, 0.1 * vertices + 3], np.r_[faces, faces + len(vertices)]),
    ):
        with pytest.raises(sp.FilterError) as refused:
            sp.parameterise_root(sp.Surface(v, f))
        assert "run --prepare" in flags.by_flags(str(refused.value))
        sp.parameterise_root(sp.prepare(sp.Surface(v, f)).surface)
