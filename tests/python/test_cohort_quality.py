# SPDX-License-Identifier: GPL-3.0-only
"""The page of a study: who stands out, why, and that thousands are no matter. The steps' outputs
are made up here; tests/cohort runs the steps."""

from __future__ import annotations

import json
import re
import zlib
from hashlib import sha256

import browser
import numpy as np
import pytest
from cohort_inputs import inside, octahedron
from sphere_propagation.cohort import cohort, quality, study_report
from sphere_propagation.cohort import study as study_file
from sphere_propagation.cohort.thumbnails import Studio, png, sheet
from sphere_propagation.errors import InputError

PHASES, CHUNK = 12, 50
WRITTEN = ("model", "report")


def record(name: str, row: int, draw: np.random.RandomState) -> dict:
    """A subject like all others: a cycle that is 100 cm³ at first and 45 at end-systole."""

    def about(value, spread=0.1):
        return [float(x) for x in value * np.exp(spread * draw.randn(PHASES))]

    time = np.arange(PHASES) / PHASES
    squeezed = np.where(
        time < 0.35, np.sin(np.pi * time / 0.7), np.cos(np.pi * (time - 0.35) / 1.3)
    )
    size, part = 1e5 * np.exp(0.2 * draw.randn()), 0.55 + 0.03 * draw.randn()
    return {
        "subject": name,
        "groups": {"sex": "f"},
        "files": [{"file": f"{name}/seg.nii.gz", "sha256": sha256(name.encode()).hexdigest()}],
        "failed": None,
        "row": row,
        "phases": PHASES,
        "names": [f"phase {k}" for k in range(PHASES)],
        "root": 0,
        "fit": {"surface_distance": about(0.4)[0]},
        "volume": [
            float(x) for x in size * (1 - part * squeezed**2) * np.exp(3e-3 * draw.randn(PHASES))
        ],
        "vertices": [9000] * PHASES,
        "residual_mean": about(0.3),
        "residual_p95": about(0.9),
        "flipped_faces": [0] * PHASES,
        "repaired_faces": [int(x) for x in draw.randint(0, 5, PHASES)],
        "area_ratio_sd": about(0.2),
        "angle_error_mean": about(12, 0.05),
        "surface_distance_mean": about(0.2),
        "surface_distance_max": about(1.0),
        "branch_distance": about(0.5)[0],
        "warnings": [],
        "odd": [],
        "deviation": about(1.0),  # these two are of scores/
        "residual": about(0.5),
    }


def study(folder, count: int, change=None, exclude=(), quality_table=None, seed: int = 0):
    """The folder of a study of so many subjects; change: name -> what is done to its record."""
    draw = np.random.RandomState(seed)
    mean, faces = octahedron()
    mean = mean * [25, 25, 40]
    for name in ("plan", "landmarks", "scores"):
        (folder / name).mkdir(parents=True)
    np.savez(folder / "atlas.npz", mean=mean, faces=faces)
    chunks = [f"{k:05d}" for k in range(-(-count // CHUNK))]
    levels = [{f"{i // 16:05d}": chunks[i : i + 16] for i in range(0, len(chunks), 16)}]
    for block, its in levels[0].items():
        scored = []
        for chunk in its:
            first = int(chunk) * CHUNK
            names = [f"sub-{k:05d}" for k in range(first, min(first + CHUNK, count))]
            records = [record(name, PHASES * k, draw) for k, name in enumerate(names)]
            for one in records:
                if change and one["subject"] in change:
                    change[one["subject"]](one)
            points = np.concatenate(
                [mean[None] * np.exp(0.1 * draw.randn(PHASES, 1, 3)) for _ in names]
            )
            np.save(
                folder / "landmarks" / f"{chunk}.npy", points.reshape(len(points), -1).astype("f4")
            )
            for one in records:
                if not one["failed"]:
                    deviation, residual = one.pop("deviation"), one.pop("residual")
                    scored.append(
                        {
                            **{"subject": one["subject"]},
                            "deviation": deviation,
                            "residual": residual,
                        }
                    )
            written(folder / "landmarks" / f"{chunk}.json", {"subjects": records})
        written(folder / "scores" / f"{block}.json", {"subjects": scored})
    written(folder / "plan" / "chunks.json", {"chunks": chunks, "levels": levels})
    written(
        folder / "plan" / "model.json",
        {
            "parameters": {"unit": "mm", "left_out": list(study_file.KINDS)},
            "exclude": list(exclude),
        },
    )
    why = exclude if isinstance(exclude, dict) else dict.fromkeys(exclude, "")
    settings = {"parameters": {"quality": quality_table or {}}, "why": why}
    written(folder / "plan" / "report.json", settings)
    written(folder / "atlas.json", {"warnings": []})
    return folder


def written(path, content):
    path.write_text(json.dumps(content), encoding="utf-8")


def rows(folder):
    """What the table of report.html has, in its order, by name."""
    page = (folder / "report.html").read_text(encoding="utf-8")
    data = json.loads(re.search(r'id="data">(.*?)</script>', page, re.S).group(1))
    return {row[0]: row for row in data["subjects"]}


def scaled(name: str, by: float, phase: int = 3):
    def change(one):
        one[name][phase] *= by

    return change


def put(name: str, value):
    return lambda one: one.update({name: value})


def swapped(one):
    volume = one["volume"]
    volume[1], volume[4] = volume[4], volume[1]


def still(one):
    one["volume"] = [max(one["volume"]) * (1 - 0.01 * k / PHASES) for k in range(PHASES)]


def backwards(one):
    one["volume"] = [one["volume"][0], *one["volume"][:0:-1]]


REASONS = {
    "fit to the atlas": put("fit", {"surface_distance": 3.0}),
    "residual 2.": scaled("residual_mean", 2.4 / 0.3),
    "residual, its worst 5 %": scaled("residual_p95", 6),
    "faces repaired": put("repaired_faces", [0] * (PHASES - 1) + [900]),
    "angle error": scaled("angle_error_mean", 2.0),
    "landmark mesh to surface": scaled("surface_distance_mean", 8),
    "largest volume": lambda one: one.update(volume=[v * 8 for v in one["volume"]]),
    "volume change": still,
    "volume jump": swapped,
    "volume curve": backwards,
    "closure of the cycle": put("branch_distance", 6.0),
    "deviation from the model": scaled("deviation", 6),
    "outside of the model": scaled("residual", 6),
    "3 faces flipped": put("flipped_faces", [0, 3] + [0] * (PHASES - 2)),
}


@pytest.mark.parametrize("reason", REASONS)
def test_the_subject_that_stands_out_is_first_and_says_why(tmp_path, reason):
    quality.write(study(tmp_path, 60, {"sub-00037": REASONS[reason]}))
    first = next(iter(rows(tmp_path).values()))
    assert first[0] == "sub-00037"
    assert reason in first[4]
    assert first[3] > quality.DEFAULTS["threshold"]
    own = (tmp_path / "reports" / "00000.html").read_text(encoding="utf-8")
    assert reason in own


def test_a_volume_much_too_small_stands_out_as_well(tmp_path):
    small = {"sub-00008": lambda one: one.update(volume=[v / 1000 for v in one["volume"]])}
    quality.write(study(tmp_path, 30, small))
    first = next(iter(rows(tmp_path).values()))
    assert (first[0], "largest volume" in first[4]) == ("sub-00008", True)


def test_failed_subjects_come_first_with_their_reason(tmp_path):
    def fail(one):
        one.update(failed={"step": "import", "reason": "label 3 is absent </script>"})

    folder = study(tmp_path, 20, {"sub-00011": fail, "sub-00002": REASONS["angle error"]})
    assert quality.write(folder) >= 2
    found = list(rows(folder).values())
    assert found[0][:3] == ["sub-00011", "00000", "failed"]
    assert found[0][4] == "import: label 3 is absent </script>"
    assert found[1][0] == "sub-00002"
    assert "Could not be done" in (folder / "reports" / "00000.html").read_text(encoding="utf-8")


def test_another_number_of_phases_is_said(tmp_path):
    def shorter(one):
        for key, value in one.items():
            if isinstance(value, list) and len(value) == PHASES:
                one[key] = value[:-2]
        one["phases"] = PHASES - 2

    quality.write(study(tmp_path, 20, {"sub-00005": shorter}))
    assert f"{PHASES - 2} phases, others have {PHASES}" in rows(tmp_path)["sub-00005"][4]


def test_excluded_subjects_are_shown_and_judge_nobody(tmp_path):
    bad = {f"sub-{k:05d}": REASONS["residual 2."] for k in range(12)}
    quality.write(study(tmp_path / "all", 20, bad))
    assert "residual 2" not in rows(tmp_path / "all")["sub-00000"][4]  # most are like that
    quality.write(study(tmp_path / "left", 20, bad, exclude=list(bad)))
    row = rows(tmp_path / "left")["sub-00000"]
    assert row[2] == "excluded" and "residual 2" in row[4]


def failing(one):
    one.update(failed={"step": "import", "reason": "it is open"})


def came_out(folder):
    """What the terminal says in the end, and whether all subjects are in the study."""
    said = []
    chunks = json.loads((folder / "plan/chunks.json").read_text())["chunks"]
    complete = cohort._say_what_came_out(folder, "participant", chunks, said.append)
    return "\n".join(said), complete


def of_table(folder):
    with inside(folder):
        plan, report = (json.loads((folder / f"plan/{n}.json").read_text()) for n in WRITTEN)
        return {row["subject"]: row for row in study_report.rows_of_subjects(plan, report["why"])}


def test_a_failed_subject_that_is_excluded_is_not_missing(tmp_path):
    bad = {"sub-00003": failing}
    folder = study(tmp_path / "failed", 12, bad)
    said, complete = came_out(folder)
    assert not complete and "sub-00003 (import): it is open" in said
    folder = study(tmp_path / "excluded", 12, bad, exclude={"sub-00003": "a test scan"})
    said, complete = came_out(folder)
    assert complete and "sub-00003 (import, excluded): it is open" in said
    quality.write(folder)
    row = rows(folder)["sub-00003"]
    assert row[2] == "excluded" and row[4] == "import: it is open" and row[10] == "a test scan"
    assert list(rows(folder))[0] != "sub-00003"
    row = of_table(folder)["sub-00003"]
    assert (row["status"], row["step"], row["reason"]) == ("excluded", "import", "it is open")
    assert row["why_excluded"] == "a test scan"
    own = (folder / "reports/00000.html").read_text(encoding="utf-8")
    assert "Excluded from the model (a test scan). import: it is open" in own


def test_files_that_are_copies_of_anothers_are_named(tmp_path):
    """On the terminal, the page and in subjects.csv; who is excluded is no pair any more."""

    def copy(one):
        one["files"][0]["sha256"] = sha256(b"sub-00002").hexdigest()

    folder = study(tmp_path / "both", 60, {"sub-00055": copy})
    said, complete = came_out(folder)
    words = "its file sub-00055/seg.nii.gz is the same, byte by byte, as sub-00002/seg.nii.gz of"
    assert complete and "2 subjects with the same files:" in said
    assert f"sub-00055: {words} sub-00002: " in said
    quality.write(folder)
    assert words in rows(folder)["sub-00055"][4] and "sub-00055" in rows(folder)["sub-00002"][4]
    assert set(list(rows(folder))[:2]) == {"sub-00002", "sub-00055"}
    found = of_table(folder)
    assert found["sub-00055"]["status"] == "done" and words in found["sub-00055"]["reason"]
    assert found["sub-00001"]["reason"] == ""
    folder = study(tmp_path / "one", 60, {"sub-00055": copy}, exclude={"sub-00055": "twice"})
    assert "same files" not in came_out(folder)[0]


def test_alike_subjects_do_not_stand_out(tmp_path):
    def same(one):
        one.update(record(one["subject"], one["row"], np.random.RandomState(5)))

    folder = study(tmp_path, 12, {f"sub-{k:05d}": same for k in range(12)})
    assert quality.write(folder) == 0
    assert {row[3] for row in rows(folder).values()} == {0}


def test_rounding_does_not_stand_out(tmp_path):
    """Where the modes show all shapes as they are, what is left is rounding, and a hundred times
    another's."""

    def shown(one):
        one["residual"] = [1e-9 * 10 ** (one["row"] // PHASES % 4)] * PHASES

    quality.write(study(tmp_path, 40, {f"sub-{k:05d}": shown for k in range(40)}))
    assert not any("outside of the model" in row[4] for row in rows(tmp_path).values())


def test_who_is_not_like_the_others_comes_first_and_judges_nobody(tmp_path):
    def like(kind):
        return lambda one: one.update(odd=[{"kind": kind, "text": f"it is of {kind}"}])

    odd = {
        "sub-00003": like("another unit"),
        "sub-00004": like("another size"),
        "sub-00005": lambda one: one.update(
            warnings=[{"message": "farOff", "layer": "p", "text": "p: it lies 9 edges off"}]
        ),
    }
    quality.write(study(tmp_path, 30, odd))
    found = rows(tmp_path)
    assert list(found)[:2] == ["sub-00003", "sub-00004"]
    assert found["sub-00003"][2] == "left out" and found["sub-00004"][2] == "done"
    assert found["sub-00003"][4].startswith("it is of another unit")
    assert found["sub-00005"][4].endswith("p: it lies 9 edges off")
    assert "1 are left out of the model" in (tmp_path / "report.html").read_text()


def test_few_of_many_normal_subjects_stand_out(tmp_path):
    found = quality.write(study(tmp_path, 400, seed=3))
    assert found <= 12
    assert 0.5 < quality.expected_by_chance(400, 3.5) < 3


def test_one_subject_of_one_phase_is_a_study(tmp_path):
    def single(one):
        for key, value in one.items():
            if isinstance(value, list) and len(value) == PHASES:
                one[key] = value[:1]
        one["phases"] = 1
        del one["branch_distance"]

    assert quality.write(study(tmp_path, 1, {"sub-00000": single})) == 0
    assert list(rows(tmp_path)) == ["sub-00000"]


def test_thresholds_are_on_the_page(tmp_path):
    quality.write(study(tmp_path, 20, quality_table={"threshold": 5, "pictures": 3}))
    page = (tmp_path / "report.html").read_text(encoding="utf-8")
    assert "beyond z = 5 (the" in page.replace("\n", " ")
    for measure in quality.MEASURES:
        assert measure.title in page and measure.means[:40] in page
    assert sorted(row[6] for row in rows(tmp_path).values())[-4:] == [-1, 0, 1, 2]
    assert (
        "http://" not in page.replace("http://www.w3.org/2000/svg", "") and "https://" not in page
    )


def test_two_thousand_subjects_are_one_page(tmp_path):
    bad = {"sub-01234": REASONS["residual 2."], "sub-00007": REASONS["volume curve"]}
    quality.write(study(tmp_path, 2000, bad))
    found = list(rows(tmp_path))
    assert len(found) == 2000
    assert {"sub-01234", "sub-00007"} <= set(found[:4])
    assert len(list((tmp_path / "reports").glob("*.html"))) == 40
    assert (tmp_path / "report.html").stat().st_size < 5e6


def test_pages_of_chunks_that_are_gone_go(tmp_path):
    folder = study(tmp_path, 10)
    (folder / "reports").mkdir()
    (folder / "reports" / "00009.html").write_text("old")
    quality.write(folder)
    assert [path.name for path in (folder / "reports").iterdir()] == ["00000.html"]


@pytest.mark.parametrize(
    ("table", "words"),
    [
        ({"treshold": 3}, "'treshold', which means nothing"),
        ({"threshold": 0.5}, "threshold of [quality] must be a number from 1 to 100, not 0.5"),
        ({"threshold": True}, "threshold"),
        ({"pictures": 2.5}, "pictures of [quality] must be a whole number"),
        ({"pictures": float("nan")}, "pictures"),
    ],
)
def test_settings_that_cannot_be_are_refused(table, words):
    with pytest.raises(InputError, match=re.escape(words)):
        quality.checked(table)


def test_a_picture_is_the_same_however_the_subject_lies():
    mean, faces = octahedron()
    mean = mean * [20, 28, 40] + np.abs(mean) * [9, 0, 0]
    studio = Studio(mean, faces)
    upright = studio.picture(mean)
    turn = np.linalg.qr(np.random.RandomState(1).randn(3, 3))[0]
    turn *= np.sign(np.linalg.det(turn))
    moved = studio.picture(mean @ turn.T + [300, -20, 5])
    assert (np.abs(moved.astype(int) - upright) > 8).mean() < 0.01
    inside = upright < 250
    assert 0.25 < inside.mean() < 0.7
    filled = [np.flatnonzero(line) for line in inside if line.any()]
    assert np.mean([len(line) == line[-1] - line[0] + 1 for line in filled]) > 0.95  # no holes


def test_pictures_are_files_of_portable_network_graphics():
    image = np.arange(35, dtype=np.uint8).reshape(5, 7)
    data = png(sheet([image[:5, :5], image[:5, 2:7]], 2))
    assert data[:8] == b"\x89PNG\r\n\x1a\n"
    at = data.index(b"IDAT")
    size = int.from_bytes(data[at - 4 : at], "big")
    lines = np.frombuffer(zlib.decompress(data[at + 4 : at + 4 + size]), np.uint8).reshape(5, 11)
    assert np.array_equal(lines[:, 1:6], image[:, :5]) and not lines[:, 0].any()


def test_the_study_checks_its_quality_table():
    made = study_file.checked({"quality": {"threshold": 4}})
    assert made.quality == {"threshold": 4.0, "pictures": 1000}
    assert study_file.checked({}).quality == quality.DEFAULTS
    with pytest.raises(InputError, match="treshold"):
        study_file.checked({"quality": {"treshold": 4}})
    with pytest.raises(InputError, match="a table"):
        study_file.checked({"quality": 4})


@pytest.mark.skipif(browser.program() is None, reason="Chromium is not installed")
def test_the_table_is_sorted_searched_and_ticked_in_a_browser(tmp_path):
    bad = {"sub-00120": REASONS["residual 2."], "sub-00007": REASONS["volume curve"]}
    quality.write(study(tmp_path / "study", 150, bad, exclude={"sub-00003": "moved"}))
    window = browser.Browser(tmp_path / "profile")
    try:
        window.open(tmp_path / "study" / "report.html")

        def names():
            return window.run(
                "[...document.querySelectorAll('#subjects td.words')].map(td => td.textContent)"
            )

        def click(title):
            window.run(
                "[...document.querySelectorAll('#subjects th')]"
                f".find(th => th.textContent === {json.dumps(title)}).click()"
            )

        assert len(names()) == 100 and names()[:2] == list(rows(tmp_path / "study"))[:2]
        window.run("document.getElementById('more').click()")
        assert len(names()) == 150
        click("residual")
        assert names()[0] == "sub-00120"
        click("subject")
        assert names()[:2] == ["sub-00000", "sub-00001"]
        click("subject")
        assert names()[0] == "sub-00149"
        window.run(
            "const box = document.getElementById('search'); box.value = 'VOLUME CURVE';"
            "box.dispatchEvent(new Event('input'))"
        )
        assert "sub-00007" in names() and len(names()) < 10
        link = window.run("document.querySelector('#subjects td.words a').getAttribute('href')")
        assert (tmp_path / "study" / link.split("#")[0]).is_file()
        assert window.run("document.getElementById('save').disabled")
        window.run("box.value = 'sub-00003'; box.dispatchEvent(new Event('input'))")
        assert "excluded (moved)" in window.run("document.querySelector('td.why').textContent")
        tick = "document.querySelector('#subjects tbody input')"
        assert window.run(f"{tick}.checked")
        window.run(f"{tick}.click()")
        assert not window.run("document.getElementById('save').disabled")
        window.run(f"{tick}.click()")
        assert window.run("document.getElementById('save').disabled")
        window.run("document.querySelector('#subjects tbody input').click()")
        assert not window.run("document.getElementById('save').disabled")
        assert window.complaints == []
        assert all(not one.startswith("http") for one in window.requests)
    finally:
        window.close()
