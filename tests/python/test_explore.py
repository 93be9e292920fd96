# SPDX-License-Identifier: GPL-3.0-only
"""The page to explore a shape model: what it says, and in headless Chromium what it shows."""

import html
import shutil
import subprocess
import time

import browser
import numpy as np
import pytest
import sphere_propagation as sp
from PIL import Image
from sphere_propagation import command, explorer

needs_browser = pytest.mark.skipif(browser.program() is None, reason="Chromium is not installed")


def made_model(landmarks=42, shapes=6, modes=None, at=(120.0, -300.0, 40.0), lid=None, spheres=1):
    """The phantom, or several of it apart from each other, that vary at random."""
    chance = np.random.default_rng(7)
    frequency = round(((landmarks - 2) / 10) ** 0.5)
    ball = sp.make_phantom(phases=1, voxel_size=4.0)[0]
    positions = sp.parameterise_root(ball)
    one = sp.remesh([ball], [positions], frequency=frequency)
    points = np.concatenate([one.points[0] + [150 * k, 0, 0] for k in range(spheres)])
    faces = np.concatenate([one.faces + k * len(one.points[0]) for k in range(spheres)])
    modes = shapes - 1 if modes is None else modes
    basis = np.linalg.qr(chance.normal(size=(points.size, max(modes, 1))))[0].T[:modes]
    scores = chance.normal(size=(shapes, modes))
    scores -= scores.mean(0)
    sd = np.sqrt(points.size) * 2.0 / (1 + np.arange(modes))
    variances = (scores * sd).var(0, ddof=1) if shapes > 1 else sd**2
    share = np.cumsum(variances) / variances.sum() if modes else np.zeros(0)
    return sp.ShapeModel(
        points + at,
        basis.reshape(modes, *points.shape),
        variances,
        scores * sd,
        faces.astype(np.int32),
        [f"<shape> {k}" for k in range(shapes)],
        float(variances.sum()),
        {"compactness": np.cumsum(variances), "variance_share": share},
        lid,
    )


def written(model, path):
    np.savez(
        path,
        mean=model.mean,
        modes=model.modes,
        eigenvalues=model.eigenvalues,
        scores=model.scores,
        faces=model.faces,
    )
    return path


def directions(model, modes):
    return np.sqrt(model.eigenvalues[:modes])[:, None, None] * model.modes[:modes]


def posterior(model, fixed, noise, modes):
    """The mean of the scores, by numpy."""
    moves = directions(model, modes)
    d = np.concatenate([moves[:, j].T for j, _ in fixed])
    off = np.concatenate([np.asarray(target) - model.mean[j] for j, target in fixed])
    return np.linalg.solve(d.T @ d / noise**2 + np.eye(modes), d.T @ off / noise**2)


@pytest.fixture(scope="module")
def chromium(tmp_path_factory):
    if browser.program() is None:
        pytest.skip("Chromium is not installed")
    window = browser.Browser(tmp_path_factory.mktemp("profile"))
    yield window
    window.close()


@pytest.fixture
def opened(chromium, tmp_path):
    """Opens a model's page; in the end nothing must have been complained of, nor fetched."""

    def open_page(model, **options):
        path = sp.explore(model, **options).save(tmp_path / "page.html")
        chromium.open(path)
        return chromium

    chromium.complaints.clear()
    chromium.requests.clear()
    yield open_page
    assert chromium.complaints == []
    assert [url for url in chromium.requests if not url.startswith("file:")] == []


def test_a_slider_moves_vertices_to_what_numpy_says(opened):
    model = made_model()
    page = opened(model)
    page.run("document.querySelectorAll('#sliders input')[1].focus()")
    for _ in range(3):
        page.press("ArrowRight")
    assert page.run("explorer.scores()") == pytest.approx([0, 0.3, 0, 0, 0])
    assert np.array(page.run("explorer.vertices()")) == pytest.approx(model.along(1, 0.3), abs=1e-4)
    scores = [1.5, -2, 0.25, 3, -0.75]
    page.run(f"explorer.setScores({scores})")
    expected = model.shape(np.array(scores) * np.sqrt(model.eigenvalues))
    assert np.array(page.run("explorer.vertices()")) == pytest.approx(expected, abs=1e-4)
    assert page.run("explorer.mahalanobis()") == pytest.approx(np.linalg.norm(scores))
    page.run("explorer.show(4)")
    expected = model.shape(model.scores[4])
    assert np.array(page.run("explorer.vertices()")) == pytest.approx(expected, abs=1e-4)


def test_dragged_landmarks_give_the_posterior(opened):
    model = made_model()
    page = opened(model)
    for by in ((30, -20), (-12, 25)):
        index = page.run(
            "explorer.landmarkAt(440, 330)" if by[0] > 0 else "explorer.landmarkAt(430, 420)"
        )
        assert index >= 0
        x, y, _ = page.run(f"explorer.pixelOf({index})")
        page.drag((x, y), (x + by[0], y + by[1]), shift=True)
    fixed = page.run("explorer.fixed()")
    assert len(fixed) == 2
    expected = posterior(
        model, [(one["index"], one["target"]) for one in fixed], page.run("explorer.noise()"), 5
    )
    assert np.abs(expected).max() > 0.1
    assert page.run("explorer.scores()") == pytest.approx(expected, abs=1e-4)
    shape = model.shape(expected * np.sqrt(model.eigenvalues))
    assert np.array(page.run("explorer.vertices()")) == pytest.approx(shape, abs=1e-3)
    page.run("document.querySelector('#fixed button').click()")
    assert len(page.run("explorer.fixed()")) == 1
    page.run("explorer.release()")
    assert page.run("explorer.scores()") == pytest.approx(np.zeros(5))


def test_landmarks_are_found_where_they_are_before_they_are_drawn_there(opened):
    """Nothing is drawn within one expression, nor on a slow machine for a while."""
    page = opened(made_model())
    row = "[300, 340, 380].map((y) => explorer.landmarkAt(x, y))"
    found = f"[380, 400, 420, 440, 460].flatMap((x) => {row})"
    before, at_once = page.run(
        f"((before) => [before, (explorer.setScores([3, -3, 3, 0, 0]), {found})])({found})"
    )
    page.drawn()
    drawn = page.run(found)
    assert max(drawn) >= 0 and drawn != before
    assert at_once == drawn


def test_what_is_left_uncertain(opened):
    model = made_model()
    page = opened(model)
    page.run("explorer.fix(7, explorer.vertices()[7])")
    moves, noise = directions(model, 5), page.run("explorer.noise()")
    d = moves[:, 7].T
    covariance = np.linalg.inv(d.T @ d / noise**2 + np.eye(5))
    expected = np.sqrt(np.einsum("mja,mk,kja->j", moves, covariance, moves))
    assert page.run("explorer.uncertainty()") == pytest.approx(expected, rel=1e-4)


@pytest.mark.parametrize(
    "options",
    [{"modes": 1}, {"modes": 0, "shapes": 1}, {"modes": 30, "shapes": 31}, {"spheres": 3}],
    ids=["one mode", "no modes", "thirty modes", "three parts"],
)
def test_special_models(opened, options):
    model = made_model(**options)
    page = opened(model)
    assert page.run("explorer.modes") == len(model.modes)
    assert np.array(page.run("explorer.vertices()")) == pytest.approx(model.mean, abs=1e-4)
    for colours in ("along", "distance", "uncertainty", "none"):
        page.run(f"explorer.setColours('{colours}')")
    parts = page.run("document.querySelectorAll('#parts input').length")
    assert parts == options.get("spheres", 1)
    page.run("explorer.play()")
    page.run("explorer.stop()")
    assert page.run("document.getElementById('error').hidden")


def test_landmarks_keep_their_numbers_where_lids_were_left_out(opened):
    lid = np.zeros(44, bool)
    lid[[0, 9]] = True
    page = opened(made_model(lid=lid))
    page.run("document.getElementById('index').value = 10")
    page.run("document.getElementById('fix').click()")
    assert page.run("document.querySelector('#fixed b').textContent") == "10"
    assert [one["index"] for one in page.run("explorer.fixed()")] == [8]


def test_pages_are_small_and_fetch_nothing():
    for landmarks in (1002, 2562):
        page = sp.explore(made_model(landmarks, 31)).html
        assert len(page) < 5e6 and "http:" not in page and "https:" not in page
        assert "<shape>" not in page


def test_large_models_are_quantised(opened, monkeypatch):
    monkeypatch.setattr(explorer, "LARGEST", 1000)
    model = made_model()
    page = opened(model)
    page.run("explorer.setScores([1, -2, 0.5, 3, -0.75])")
    expected = model.shape(np.array([1, -2, 0.5, 3, -0.75]) * np.sqrt(model.eigenvalues))
    assert np.array(page.run("explorer.vertices()")) == pytest.approx(expected, abs=1e-2)


def test_the_command(tmp_path, capsys):
    path = written(made_model(), tmp_path / "model.npz")
    assert command.main(["explore", str(path)]) == 0
    assert "42 landmarks, 5 modes" in capsys.readouterr().out
    assert "<canvas" in (tmp_path / "explore.html").read_text()
    assert command.main(["explore", str(path), "-o", str(tmp_path / "p.html"), "--unit", "cm"]) == 0
    assert '"unit":"cm"' in (tmp_path / "p.html").read_text()
    (tmp_path / "bad.npz").write_text("text")
    assert command.main(["explore", str(tmp_path / "bad.npz")]) == 1
    assert "is no .npz file" in capsys.readouterr().err


def test_models_are_read_again(tmp_path):
    model = made_model()
    again = sp.read_model(written(model, tmp_path / "model.npz"))
    assert np.array_equal(again.modes, model.modes) and again.names[2] == "shape 2"
    np.savez(tmp_path / "less.npz", mean=model.mean)
    with pytest.raises(sp.FileError, match="not a shape model"):
        sp.read_model(tmp_path / "less.npz")


def test_jupyter_shows_it_inline():
    made = sp.explore(made_model())
    inline = made._repr_html_()
    assert inline.startswith("<iframe srcdoc=") and inline.count('"') == 6


@needs_browser
@pytest.mark.parametrize("sandbox", ["", 'sandbox="allow-scripts"'])
def test_what_jupyter_shows_is_drawn(tmp_path, sandbox):
    """As notebooks place it, in their own page or in a frame that may run scripts and no more. The
    frame's insides are read from a picture: no other origin can look into a sandbox."""
    page = tmp_path / "notebook.html"
    inline = sp.explore(made_model(162))._repr_html_()
    frame = (
        f'<iframe {sandbox} style="width: 1200px; height: 700px" srcdoc="{html.escape(inline)}">'
    )
    page.write_text(f"<!doctype html><title>notebook</title>{frame if sandbox else inline}")
    window = browser.Browser(tmp_path / "profile")
    try:
        window.open(page)

        def colors():
            window.drawn()
            window.picture(tmp_path / "page.png")
            with Image.open(tmp_path / "page.png") as picture:
                pixels = np.asarray(picture.convert("RGB"))
            return len(np.unique(pixels[150:500, 350:800].reshape(-1, 3), axis=0))

        given_up = time.monotonic() + window.timeout
        while colors() <= 50:  # until there is a shaded surface
            assert time.monotonic() < given_up, "nothing is drawn"
        assert window.complaints == []
        assert [url for url in window.requests if url.startswith("http")] == []
    finally:
        window.close()


def test_the_report_holds_it_folded(chromium, tmp_path):
    """It is not loaded before it is unfolded, and shows the model that was written beside it."""
    (tmp_path / "phases").mkdir()
    for k, ball in enumerate(sp.make_phantom(phases=3, voxel_size=4.0)):
        sp.write_ply(tmp_path / f"phases/{k}.ply", ball.vertices, ball.faces)
    out = tmp_path / "out"
    words = ["run", tmp_path / "phases", "-o", out, "--order", "cyclic", "--frequency", 2]
    assert command.main([str(word) for word in [*words, "--no-pictures"]]) == 0
    chromium.complaints.clear()
    chromium.requests.clear()
    chromium.open(out / "report.html")
    inside = "document.querySelector('iframe').contentWindow.explorer"
    assert chromium.run(f"{inside} === undefined")
    chromium.run(
        "new Promise((go) => { document.querySelector('iframe').addEventListener('load', go);"
        "document.querySelector('.explorer summary').click(); })"
    )
    chromium.run(f"{inside}.setScores([1, -2])")
    model = sp.read_model(out / "phases/model.npz")
    expected = model.shape(np.array([1, -2]) * np.sqrt(model.eigenvalues))
    assert np.array(chromium.run(f"{inside}.vertices()")) == pytest.approx(expected, abs=1e-4)
    assert chromium.run("document.documentElement.scrollWidth <= innerWidth")
    assert (out / "phases/explore.html").is_file()
    assert chromium.complaints == []
    assert [url for url in chromium.requests if not url.startswith(("file:", "about:"))] == []


@pytest.mark.skipif(shutil.which("node") is None, reason="node is not installed")
@pytest.mark.parametrize("name", explorer.SCRIPTS)
def test_scripts_are_javascript(name):
    subprocess.run(["node", "--check", explorer.SOURCES / name], check=True)
