# SPDX-License-Identifier: GPL-3.0-only
"""What a run tells: units, how it was made, landmarks in one file, pictures of phases and of
shapes; the same words everywhere."""

import csv
import hashlib
import json
import re
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import sphere_propagation as sp
from PIL import Image
from sphere_propagation import (
    citation,
    command,
    drawing,
    filters,
    gallery,
    model_pictures,
    parameters,
    pictures,
    plots,
)
from sphere_propagation.colors import place_colors, sphere_coordinates
from sphere_propagation.views import Row


def run(*arguments):
    return command.main([str(argument) for argument in arguments])


@pytest.fixture
def shapes(cycle, tmp_path):
    """Three meshes that are no phases, by their names."""
    folder = tmp_path / "shapes"
    folder.mkdir()
    for surface, name in zip(cycle.surfaces, ("ant", "bee", "fly")):
        sp.write_ply(folder / f"{name}.ply", surface.vertices, surface.faces)
    return folder


@pytest.fixture
def model(cycle):
    return sp.shape_model(cycle.landmarks, cycle.landmark_faces)


QUICKLY = ("--frequency", 2, "--no-pictures")


def test_the_report_says_how_it_was_made(shapes, tmp_path, monkeypatch):
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "86400")
    out = tmp_path / "out"
    words = ("run", shapes, "-o", out, "--order", "Star", "--root", 1, "--alignment", "rigid")
    assert run(*words, *QUICKLY) == 0
    made = json.loads((out / "run.json").read_text())
    assert made["command"].startswith("sphere-propagation run ") and "--root 1" in made["command"]
    assert made["date"] == "1970-01-02T00:00:00+00:00"
    assert made["root"] == "bee (--root 1)" and made["order"] == "Star"
    assert made["alignment"] == "Rigid" and made["frequency"] == "2 (42 landmarks)"
    assert sp.__version__ in made["version"] and sp.__version__ in made["cite the program"]
    assert [Path(given["file"]).name for given in made["inputs"]] == [
        "ant.ply",
        "bee.ply",
        "fly.ply",
    ]
    digest = hashlib.sha256((shapes / "ant.ply").read_bytes()).hexdigest()
    assert made["inputs"][0]["sha256"] == digest
    page = (out / "report.html").read_text()
    for words in ("How this was made", digest, made["date"], "Kirschner", "bee (--root 1)"):
        assert words in page


def test_the_alignment_and_exports_reach_the_model(shapes, tmp_path):
    out = tmp_path / "out"
    words = ("run", shapes, "-o", out, "--alignment", "none", "--export", "h5,json,.ply,particles")
    assert run(*words, *QUICKLY) == 0
    with np.load(out / "shapes/landmarks.npz") as file:
        landmarks = dict(file)
    with np.load(out / "shapes/model.npz") as file:
        found = file["mean"]
    assert found == pytest.approx(landmarks["landmarks"].mean(0))  # nothing was aligned
    made = {path.name for path in (out / "shapes").iterdir() if path.is_file()}
    assert made >= {
        f"model.{ending}" for ending in ("npz", "h5", "json", "ply", "particles", "csv")
    }
    assert {f"model_00{k}.particles" for k in range(3)} <= made
    listed = (out / ".sphere-propagation.sha256").read_text()
    assert "shapes/model_002.particles" in listed
    assert run("run", shapes, "-o", out, *QUICKLY) == 0  # the next run takes them all away
    assert not list((out / "shapes").glob("*.particles"))
    with pytest.raises(SystemExit) as end:
        run("run", shapes, "-o", out, "--export", "vtk")
    assert end.value.code == 2


def test_landmarks_are_one_file(cycle, tmp_path):
    sp.write_landmarks(tmp_path / "all.npz", cycle)
    with np.load(tmp_path / "all.npz") as file:
        assert np.array_equal(file["landmarks"], cycle.landmarks)
        assert np.array_equal(file["faces"], cycle.landmark_faces)
        assert list(file["names"]) == [surface.name for surface in cycle.surfaces]
        assert file["root"] == cycle.root and file["unit"] == "mm"
    sp.write_landmarks(tmp_path / "all.csv", cycle)
    with open(tmp_path / "all.csv", newline="") as file:
        table = list(csv.DictReader(file))
    assert len(table) == cycle.landmarks[..., 0].size
    row = table[cycle.landmarks.shape[1] + 5]
    assert row["shape"] == cycle.surfaces[1].name and row["landmark"] == "5"
    assert [float(row[k]) for k in "xyz"] == pytest.approx(cycle.landmarks[1, 5])
    with pytest.raises(sp.InputError, match=r"as \.npz or \.csv"):
        sp.write_landmarks(tmp_path / "all.txt", cycle)


def test_the_unit_is_a_word_everywhere(shapes, tmp_path, capsys):
    out = tmp_path / "out"
    assert run("run", shapes, "-o", out, "--unit", "cm", *QUICKLY) == 0
    said = capsys.readouterr().out
    assert "residual, cm" in said and "cm from the surfaces" in said and " mm" not in said
    page = (out / "report.html").read_text()
    assert "residual, cm" in page and "specificity, cm" in page and ", mm" not in page
    with open(out / "figures.csv", newline="") as file:
        assert {row["unit"] for row in csv.DictReader(file)} == {"cm"}
    with np.load(out / "shapes/landmarks.npz") as file:
        assert file["unit"] == "cm"
    assert run("run", shapes, "-o", out, "--unit", "square mm", *QUICKLY) == 2
    assert "error: --unit must be a short word" in capsys.readouterr().err
    assert run("run", shapes, "-o", out, "--unit", "", *QUICKLY) == 2


def test_volumes_and_meshes_are_not_mixed_unless_it_is_said(shapes, tmp_path, capsys):
    volume = tmp_path / "scan.nii.gz"
    sp.write_nifti(volume, *sp.Ventricle("Cavity", 2).scan())
    out = tmp_path / "out"
    given = ("run", shapes, volume, "-o", out, *QUICKLY)
    assert run(*given) == 2
    said = capsys.readouterr().err
    assert "label volumes (scan.nii.gz) and meshes (ant.ply and 2 others)" in said
    assert "--mixed" in said and not out.exists()
    assert run(*given, "--mixed") == 0
    with open(out / "figures.csv", newline="") as file:
        assert len(list(csv.DictReader(file))) == 5
    assert run("run", volume, "-o", out, "--unit", "cm") == 2
    assert "--unit cm is for meshes" in capsys.readouterr().err


def test_volumes_of_one_name_are_called_by_their_folders(tmp_path):
    for name in ("p1", "p2"):
        (tmp_path / "in" / name).mkdir(parents=True)
        scan = sp.Ventricle("Cavity", 1, int(name[1])).scan()
        sp.write_nifti(tmp_path / "in" / name / "seg.nii", *scan)
    assert run("run", tmp_path / "in", "-o", tmp_path / "out", *QUICKLY) == 0
    made = sorted(path.name for path in (tmp_path / "out/in/surfaces").iterdir())
    assert [name[:2] for name in made] == ["p1", "p2"] and "seg" not in made[0]


def test_one_other_is_no_others(shapes, tmp_path, capsys):
    volume = tmp_path / "scan.nii.gz"
    sp.write_nifti(volume, *sp.Ventricle("Cavity", 2).scan())
    (shapes / "fly.ply").unlink()
    assert run("run", shapes, volume, "-o", tmp_path / "out", *QUICKLY) == 2
    assert "meshes (ant.ply and 1 other)" in capsys.readouterr().err


def test_the_module_ends_quietly_when_nobody_reads_on():
    """As the command: `python -m sphere_propagation ... | head`."""
    command = f"'{sys.executable}' -m sphere_propagation info | true"
    found = subprocess.run(["sh", "-c", command], stderr=subprocess.PIPE, text=True, check=False)
    assert "Traceback" not in found.stderr and "Error" not in found.stderr


def words_of(said, monkeypatch):
    """All texts of the pages that are saved within."""
    monkeypatch.setattr(drawing.Drawing, "save", lambda page, path: said.extend(page.words))


def test_pictures_of_shapes_speak_of_shapes(cycle, model, tmp_path, monkeypatch):
    said = []
    words_of(said, monkeypatch)
    named = [replace(s, name=name) for s, name in zip(cycle.surfaces, "ABCDEF")]
    row = Row("insects", replace(cycle, surfaces=named, order="Similarity tree"))
    model = replace(model, names=list("ABCDEF"))
    section = gallery.Section([row], [], model=model)
    captions = [each.caption(section) for each in gallery._drawings(section.kinds)]
    for each in gallery._drawings(section.kinds):
        each.draw(section, tmp_path / "x.png")
    whole = "\n".join(said + captions)
    assert not re.search(r"phase|cycle|eject|way through", whole)
    assert set("ABCDEF") <= set(said) and "Volume of the shapes" in said
    for words in ("root sd", "upside down"):
        assert words in whole


def test_phases_have_a_key_to_their_colours(cycle, model, tmp_path, monkeypatch):
    said = []
    words_of(said, monkeypatch)
    model_pictures.scores(Row("heart", cycle), model, tmp_path / "x.png")
    assert said.count("phase") == 2  # below the curves, and beside the colours
    assert Row("heart", cycle).timed and Row("heart", cycle).caption(2).endswith(" ml")
    assert not Row("heart", replace(cycle, order="Given")).timed


def test_names_beside_points_do_not_overlap():
    generator = np.random.default_rng(3)
    for count, spread in ((10, 1.0), (40, 1.0), (40, 0.02), (1, 1.0)):
        points = spread * generator.normal(size=(count, 2))
        names = [f"specimen number {k}" for k in range(count)]
        page, (plot,) = plots.panels(600, 500)
        plot.x, plot.y = (plots.room(points[:, k], 0.16) for k in range(2))
        far = np.argsort(-np.hypot(*points.T))
        model_pictures._name_points(plot, points, names, far, 9)
        assert names[far[0]] in page.words and len(page.words) >= min(count, 8)
        boxes = [box_of(text) for text in page.parts]
        for k, (low, high) in enumerate(boxes):
            assert not any((low < up).all() and (down < high).all() for down, up in boxes[:k])
            assert plot.left <= low[0] and high[0] <= plot.left + plot.width


def box_of(text):
    """Upper left and lower right corner of what is written."""
    wide, high = drawing.extent_of(text.words, text.size, text.bold)
    if text.upwards:
        low = np.array([text.x - high / 2, text.y - (1 - text.across) * wide])
        return low, low + [high, wide]
    low = np.array([text.x - text.across * wide, text.y - high / 2])
    return low, low + [wide, high]


def test_margins_have_room_for_labels():
    """They are fixed, so that no layout is needed, and hold what is written beside the frames."""
    for top in (1e-4, 1.0, 12345.0):
        page, found = plots.panels(1360, 430, (2, 1, 1))
        end = 0
        for plot in found:
            page.parts.clear()
            plot.x, plot.y = (0, 30), (-top, top)
            plot.curve([0, 30], [-top, top], "#000000", 2)
            plot.finish("Generalisation", "modes", "distance of a shape left out")
            assert len(page.words) > 8
            boxes = [box_of(part) for part in page.parts if isinstance(part, drawing.Text)]
            low = np.min([box[0] for box in boxes], 0)
            high = np.max([box[1] for box in boxes], 0)
            assert low[0] >= end and low[1] >= 0 and high[1] <= page.height
            end = high[0]
        assert end <= page.width


@pytest.mark.parametrize(
    "low, high, most, whole, expected",
    [
        (0, 1, 5, False, ["0.0", "0.2", "0.4", "0.6", "0.8", "1.0"]),
        (-1.6, 2.1, 6, False, ["\N{MINUS SIGN}1", "0", "1", "2"]),
        (0, 105, 6, False, ["0", "20", "40", "60", "80", "100"]),
        (0, 3e-4, 4, False, ["0.0000", "0.0001", "0.0002", "0.0003"]),
        (0, 3e-8, 4, False, ["0.00000000", "0.00000001", "0.00000002", "0.00000003"]),
        (-0.5, 4.5, 8, True, ["0", "1", "2", "3", "4"]),
        (-0.5, 29.5, 8, True, ["0", "5", "10", "15", "20", "25"]),
        (7, 8, 9, True, ["7", "8"]),
    ],
)
def test_ticks_are_round_numbers(low, high, most, whole, expected):
    assert plots.labels(plots.ticks(low, high, most, whole)) == expected


def test_images_keep_their_pixels(tmp_path):
    page = drawing.Drawing(200, 100)
    image = np.random.default_rng(0).integers(0, 255, (50, 200, 3), np.uint8)
    page.image(image, 0, 0)  # the upper half
    page.save([tmp_path / "x.png", tmp_path / "x.svg"])
    with Image.open(tmp_path / "x.png") as found:
        assert (np.asarray(found)[:50] == image).all() and (np.asarray(found)[50:] == 255).all()
        assert found.info["dpi"] == pytest.approx((100, 100), abs=0.1)
    assert "<image" in (tmp_path / "x.svg").read_text()


@pytest.mark.parametrize(
    "draw",
    [
        lambda page: page.line([(20, 20), (120, 20), (120, 90)], "#0f766e", 5),
        lambda page: page.line([(20, 180), (132, 180)], "#c2410c", 5, (20, 12)),
        lambda page: page.area([(160, 20), (220, 20), (190, 80)], "#6d4aad"),
        lambda page: page.dots([(250, 40), (270, 100)], 9, ["#1c2530", "#0f766e"]),
        lambda page: page.text(20, 130, "to the right", 20),
        lambda page: page.text(150, 130, "in the middle", 20, bold=True, across=0.5),
        lambda page: page.text(280, 150, "to the left", 20, color="#5b6570", across=1.0),
        lambda page: page.text(240, 100, "from below", 14, across=0.5, upwards=True),
        lambda page: page.text(240, 190, "up to the top", 14, upwards=True),
        lambda page: page.text(240, 10, "below the top", 14, across=1.0, upwards=True),
        lambda page: page.image(np.full((30, 50, 3), 99, np.uint8), 60, 70),
    ],
)
def test_pages_are_the_same_in_all_formats(tmp_path, draw):
    """As Pillow draws them, and as Matplotlib does, which writes SVG and PDF: what is drawn takes
    the same place, in the same colour."""
    page = drawing.Drawing(300, 200)
    draw(page)
    page.save(tmp_path / "x.png")
    drawing._Vector(page).write(tmp_path / "y.png")
    found = []
    for name in ("x.png", "y.png"):
        with Image.open(tmp_path / name) as image:
            pixels = np.asarray(image.convert("RGB"), float)
        down, across = np.nonzero(pixels.min(2) < 200)
        inked = pixels[down, across]
        ends = [across.min(), across.max(), down.min(), down.max()]
        found.append((ends, inked.mean(0), np.median(inked, 0)))
    assert found[0][0] == pytest.approx(found[1][0], abs=4)
    for k in (1, 2):  # mean and median: edges are as sharp, but for a pixel
        assert found[0][k] == pytest.approx(found[1][k], abs=45)


@pytest.mark.parametrize("count", [1, 2, 6])
def test_all_texts_of_a_picture_are_on_it(cycle, model, tmp_path, monkeypatch, count):
    """Also where it has few surfaces, or one mode."""
    pages = []
    monkeypatch.setattr(drawing.Drawing, "save", lambda page, path: pages.append(page))
    few = replace(
        cycle,
        surfaces=cycle.surfaces[:count],
        maps=cycle.maps[:count],
        landmarks=cycle.landmarks[:count],
        root=0,
    )
    row = Row("heart", few)
    pictures.landmarks_on_surfaces([row], tmp_path / "x.png")
    pictures.root_and_sphere([row], tmp_path / "x.png")
    model_pictures.modes(model, tmp_path / "x.png", shown=min(count, 3))
    model_pictures.volumes(row, tmp_path / "x.png")
    assert len(pages) == 4
    for page in pages:
        texts = [part for part in page.parts if isinstance(part, drawing.Text)]
        boxes = [box_of(text) for text in texts]
        for text, (low, high) in zip(texts, boxes):
            assert low.min() >= 0 and high[0] <= page.width and high[1] <= page.height, text.words
        for k, (low, high) in enumerate(boxes):
            for text, (down, up) in zip(texts, boxes[:k]):
                assert not ((low < up).all() and (down < high).all()), (texts[k].words, text.words)


def test_names_with_line_breaks_are_drawn(tmp_path):
    page = drawing.Drawing(200, 40)
    page.text(10, 20, "two\nlines", 15)
    page.save([tmp_path / "x.png", tmp_path / "x.svg"])
    assert page.words == ["two lines"] and drawing.extent_of("a\nb", 10)[0] > 0


def test_png_needs_no_matplotlib(tmp_path, run_python):
    """Which takes as long to load as half of the pictures."""
    code = (
        "import sys\n"
        "from sphere_propagation import drawing\n"
        "page = drawing.Drawing(90, 40)\n"
        "page.text(5, 20, 'words', 20)\n"
        "page.line([(0, 0), (90, 40)], '#000000', 2)\n"
        "page.save(sys.argv[1])\n"
        "assert 'matplotlib' not in sys.modules\n"
    )
    assert run_python(code, tmp_path / "x.png").returncode == 0
    with Image.open(tmp_path / "x.png") as image:
        assert image.size == (90, 40)


def test_pictures_are_as_large_as_the_page_shows_them(cycle, tmp_path):
    for draw in (pictures.maps_on_surfaces, pictures.root_and_sphere):
        draw([Row("heart", cycle)], tmp_path / "x.png")
        with Image.open(tmp_path / "x.png") as image:
            assert image.width < 1500 and image.mode == "RGB"  # opaque


def test_files_of_two_folders_are_no_range_of_one(cycle, tmp_path, capsys):
    for name in ("p1", "p2"):
        (tmp_path / "in" / name).mkdir(parents=True)
        for k, surface in enumerate(cycle.surfaces[:2]):
            sp.write_ply(tmp_path / f"in/{name}/0{k}.ply", surface.vertices, surface.faces)
    assert run("run", tmp_path / "in", "-o", tmp_path / "out", *QUICKLY) == 0
    where = "p1_00 to p2_01, from 2 folders"
    said = capsys.readouterr()
    assert where in said.out + said.err and where in (tmp_path / "out/report.html").read_text()


def test_many_shapes_have_histograms(cycle, tmp_path):
    count = 60
    generator = np.random.default_rng(0)
    points = cycle.landmarks[0] + generator.normal(size=(count, *cycle.landmarks[0].shape))
    model = sp.shape_model(points, cycle.landmark_faces, specificity_samples=1)
    many = replace(cycle, surfaces=cycle.surfaces * 10, order="Star")
    for draw in (
        lambda path: model_pictures.scores(Row("many", many), model, path),
        lambda path: model_pictures.volumes(Row("many", many), path),
    ):
        draw(tmp_path / "x.png")
        assert (tmp_path / "x.png").stat().st_size > 1000


def test_one_window_draws_all_pictures(cycle, tmp_path, monkeypatch):
    made, window = [], pictures._Window
    monkeypatch.setattr(pictures, "_Window", lambda: made.append(1) or window())
    pictures._window.cache_clear()
    for draw in (pictures.maps_on_surfaces, pictures.landmarks_on_surfaces):
        draw([Row("heart", cycle)], tmp_path / "x.png")
    assert len(made) == 1


def test_the_checkerboard_shows_the_maps_own_places(cycle, tmp_path):
    """The colour in the middle of a face is the pattern's there, in all three charts."""
    surface = cycle.surfaces[0]
    size = 400
    for up in ([0, 0, 1], [1, 0, 0], [0, 0, -1]):
        # The sphere of the map itself, seen from `up`.
        other = np.linalg.svd(np.array([up], float))[2][1:]
        rotation = np.array([other[0], np.cross(up, other[0]), up])
        scene = pictures.Scene(size, size)
        panel = scene.panel((0, 0, size, size), rotation, np.zeros(3), 180)
        positions = cycle.maps[0].positions
        panel.checkerboard(positions, surface.faces, positions, normals=positions)
        image = scene.parts([(0, 0, size, size)])[0].astype(float)
        x, y = (grid.ravel() for grid in np.meshgrid(*2 * [np.linspace(-0.6, 0.6, 61)]))
        seen = np.c_[x, y, np.sqrt(1 - x**2 - y**2)] @ rotation
        colors = pictures.map_colors(*pictures.sphere_coordinates(seen))
        found = image[np.round(199.5 - 180 * y).astype(int), np.round(199.5 + 180 * x).astype(int)]
        # Light changes how bright they are, not their hue nor which of two is darker.
        share = found.sum(1) / colors.sum(1)
        near = np.abs(share / np.median(share) - 1) < 0.6
        assert near.mean() > 0.9
        hue = found / found.sum(1, keepdims=True) - colors / colors.sum(1, keepdims=True)
        assert np.median(np.abs(hue)) < 0.03


def test_pictures_are_drawings_too_on_request(shapes, tmp_path):
    out = tmp_path / "out"
    words = ("run", shapes, "-o", out, "--frequency", 2, "--picture-format", "svg,pdf")
    assert run(*words) == 0
    stems = {path.stem for path in out.glob("*.png")}
    assert {path.stem for path in out.glob("*.svg")} == stems == {p.stem for p in out.glob("*.pdf")}
    assert (out / "volume.pdf").read_bytes().startswith(b"%PDF")
    assert "<svg" in (out / "volume.svg").read_text()


@pytest.mark.parametrize("word", ["cyclic", "Cyclic time", "CYCLIC", "cyclic-time"])
def test_orders_have_the_same_names_everywhere(word, cycle, shapes, tmp_path):
    assert sp.correspond(cycle.surfaces[:3], order=word, frequency=2).order == "Cyclic time"
    found = sp.propagate(cycle.surfaces[:3], cycle.root_map, order=word)
    assert found.branch_distance is not None
    out = tmp_path / "out"
    assert run("run", shapes, "-o", out, "--order", word, *QUICKLY) == 0
    assert json.loads((out / "run.json").read_text())["order"] == "Cyclic time"


def test_every_choice_is_understood_in_any_case():
    for name, choices in parameters.NAMED.items():
        for choice in choices:
            assert parameters.in_full(name, choice.lower()) == choice
            assert parameters.in_full(name, choice.upper().replace(" ", "_")) == choice
        assert parameters.in_full(name, "nothing") == "nothing"
    assert parameters.in_full("method", "published") == "As published"
    assert parameters.in_full("labels", "similarity") == "similarity"


@pytest.mark.parametrize("command_name", ["run", "demo", "convert", "info", None])
def test_help_has_an_example(command_name, capsys):
    with pytest.raises(SystemExit) as end:
        run(*filter(None, [command_name]), "--help")
    assert end.value.code == 0
    said = capsys.readouterr().out
    assert re.search(r"^examples?:\n  sphere-propagation \w+", said, re.M)


def test_results_are_one_line(cycle, model):
    phantom = sp.read_label_volume(sp.Ventricle("Cavity", 1).scan())
    landmarks = sp.remesh(cycle.surfaces[:1], cycle.maps[:1], frequency=2)
    for result, words in (
        (cycle, "6 surfaces, 162 landmarks"),
        (cycle.surfaces[0], "'phantom cavity 00'"),
        (cycle.maps[0], "0 flipped"),
        (model, "6 shapes, 162 landmarks, 5 modes"),
        (sp.propagate(cycle.surfaces[:2], cycle.root_map), "2 maps"),
        (landmarks, "1 x 42 points"),
        (phantom, "1 surface, "),
        (sp.prepare(cycle.surfaces[0]), "PreparedSurface(Surface("),
    ):
        text = repr(result)
        assert words in text and "\n" not in text and len(text) < 160, text


def test_the_citation_is_that_of_the_file():
    text = (Path(__file__).resolve().parents[2] / "CITATION.cff").read_text()
    assert f"\nversion: {sp.__version__}\n" in text
    assert "cff-version: 1.2.0" in text and "Kirschner" in text
    title = re.search(r'title: "(Propagation of shape[^"]+)"', text)[1]
    assert title in citation.PAPER


def test_landmarks_are_coloured_by_their_place(cycle):
    """As the filter colours surfaces: the pattern Direction of what lies there."""
    places = filters.landmark_places(cycle.surfaces[0], cycle.maps[0], 162)
    nearest = np.argmax(places @ cycle.maps[0].positions.T, axis=1)
    expected = sp.map_colors(cycle.surfaces[:1], cycle.maps[:1], pattern="Direction")[0][nearest]
    found = pictures.colors_of_landmarks(cycle)
    assert np.abs(found - expected).max() < 0.25 and np.abs(found - expected).mean() < 0.05
    # Icosphere: all faces alike, up to a few per cent of their size.
    corners = places[cycle.landmark_faces]
    areas = np.linalg.norm(
        np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1
    )
    assert areas.max() / areas.min() < 2.5
    exact = map_colors_of(cycle)
    assert np.abs(exact - place_colors(*sphere_coordinates(cycle.maps[0].positions))).max() < 0.005


def map_colors_of(cycle):
    return sp.map_colors(cycle.surfaces[:1], cycle.maps[:1], pattern="Direction")[0]


def test_a_second_picture_is_its_own(cycle, tmp_path):
    """What draws the pictures is used again: nothing of the first is left in the second."""
    row = Row("heart", cycle)
    for name in ("first", "second"):
        pictures.maps_on_surfaces([row], tmp_path / f"{name}.png")
        pictures.landmarks_on_surfaces([row], tmp_path / f"{name}_landmarks.png")
    assert (tmp_path / "first.png").read_bytes() == (tmp_path / "second.png").read_bytes()
    assert (tmp_path / "first.png").stat().st_size > 50_000
    found = [(tmp_path / f"{name}_landmarks.png").read_bytes() for name in ("first", "second")]
    assert found[0] == found[1] and len(found[0]) > 50_000
