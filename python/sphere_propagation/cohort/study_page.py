# SPDX-License-Identifier: GPL-3.0-only
"""The pages of a study: report.html, a table of all subjects, those that stand out first, and
reports/CHUNK.html, where each subject has its own report. Everything is inside them, nothing comes
from the network.

A chunk is in memory at a time. The table is data that the page's script shows by pieces, because a
browser takes minutes to lay out 50,000 rows; subjects.csv has the same figures for programs.
"""

from __future__ import annotations

import base64
import html
import json
from pathlib import Path
from typing import Any, Dict, Iterator, List, Mapping, Optional, Sequence, Tuple

import numpy as np

from ..page import STYLE as PAGE_STYLE
from ..version import version
from ..views import chosen_phases
from . import likeness, quality, store, twins
from .quality import MEASURES, Reference, Subject
from .thumbnails import Studio, png, sheet

REPORT, REPORTS = Path("report.html"), Path("reports")
SCRIPT = Path(__file__).with_name("study_page.js")
COLUMNS = 25  # of the sheet of pictures
STRIP = 4  # phases that a subject's own report shows
WORDS = 160  # characters of a warning in the table
SHOWN = 56  # pixels across of a picture in the table
STYLE = """
main { max-width: 1560px; }
#subjects th { cursor: pointer; position: sticky; top: 0; background: #fff; }
#subjects th.sorted { color: #0b63a5; }
#subjects td.why { white-space: normal; text-align: left; min-width: 30ch; }
#subjects td.out { color: #c2410c; font-weight: 600; }
#subjects tr.excluded, #subjects tr.left, #subjects tr.failed { color: #5b6570; }
#subjects tr.excluded, #subjects tr.left, #subjects tr.failed { background: #f5f6f8; }
#subjects td, #subjects th { padding: 3px 8px; }
.scroll.tall { max-height: 86vh; overflow: auto; }
.picture { display: block; background-repeat: no-repeat; }
.curve { display: block; }
.controls { display: flex; flex-wrap: wrap; gap: 18px; align-items: center; margin: 12px 0; }
.controls input[type="search"] { font: inherit; padding: 3px 8px; width: 22ch; }
button { font: inherit; padding: 3px 12px; }
pre { overflow-x: auto; background: #fff; padding: 10px 14px; border-radius: 8px; }
.strip img { background: #fff; border-radius: 8px; vertical-align: middle; }
"""
PHASE_COLUMNS = (
    ("phase", "names", "{}"),
    ("volume", "volume", "{:.5g}"),
    ("vertices", "vertices", "{}"),
    ("flips", "flipped_faces", "{}"),
    ("repaired", "repaired_faces", "{}"),
    ("residual", "residual_mean", "{:.3g}"),
    ("its p95", "residual_p95", "{:.3g}"),
    ("area ratio sd", "area_ratio_sd", "{:.3g}"),
    ("angle error", "angle_error_mean", "{:.3g}"),
    ("mesh to surface", "surface_distance_mean", "{:.3g}"),
    ("deviation", "deviation", "{:.3g}"),
    ("outside of the model", "residual", "{:.3g}"),
)  # of a subject's own report


def write(folder: Path) -> int:
    """Both; returns how many subjects stand out."""
    plan = store.read_json(folder / "plan" / "report.json")
    settings = quality.checked(plan["parameters"]["quality"])
    model = store.read_json(folder / "plan" / "model.json")
    of_model, why = model["parameters"], plan.get("why", {})
    unit = of_model["unit"]
    same = twins.found_in(folder, [chunk for chunk, _ in _chunks(folder)], model)
    subjects: List[Subject] = []
    curves: Dict[str, List[float]] = {}
    for chunk, records in _records(folder):
        for record, scored, excluded in records:
            unlike = likeness.left_out(record, of_model)
            one = _subject(record, scored, chunk, excluded, unlike, same.get(record["subject"], ""))
            one.why = why.get(one.name, "")
            subjects.append(one)
            if not record["failed"]:
                curves[one.name] = quality.curve_of(record["volume"])
    middle = quality.compare_curves(subjects, curves)
    references = quality.judge(subjects, settings["threshold"], unit)
    ordered = quality.in_order(subjects)
    studio = _studio(folder)
    shown = {one.name: k for k, one in enumerate(_with_pictures(ordered, settings["pictures"]))}
    pictures: Dict[int, np.ndarray] = {}
    of = {one.name: one for one in subjects}
    for chunk, records in _records(folder):
        _write_chunk(folder, chunk, records, of, shown, studio, pictures, unit)
    _drop_old_pages(folder, {one.chunk for one in subjects})
    if pictures:
        ready = sheet([pictures[k] for k in range(len(pictures))], COLUMNS)
    else:
        ready = np.zeros((0, 0), np.uint8)
    remarks = plan.get("remarks", [])
    page = _page(folder, ordered, references, settings, unit, middle, shown, ready, remarks)
    store.write_text(folder / REPORT, page)
    return sum(quality.stands_out(one, settings["threshold"]) for one in subjects)


# ---------------------------------------------------------------- what the steps left

Entry = Tuple[Mapping[str, Any], Optional[Mapping[str, Any]], bool]


def _chunks(folder: Path) -> Iterator[Tuple[str, str]]:
    """Chunk and block, in order."""
    blocks = store.read_json(folder / "plan" / "chunks.json")["levels"][0]
    return ((chunk, block) for block, chunk in quality.batches(blocks))


def _records(folder: Path) -> Iterator[Tuple[str, List[Entry]]]:
    """By chunk: each subject's record, what the scores say of it, whether it is excluded."""
    excluded = set(store.read_json(folder / "plan" / "model.json").get("exclude", []))
    last, scored = "", {}
    for chunk, block in _chunks(folder):
        if block != last:
            last, path = block, folder / "scores" / f"{block}.json"
            entries = store.read_json(path)["subjects"] if path.is_file() else []
            scored = {one["subject"]: one for one in entries}
        records = store.read_json(folder / "landmarks" / f"{chunk}.json")["subjects"]
        yield (
            chunk,
            [(one, scored.get(one["subject"]), one["subject"] in excluded) for one in records],
        )


def _subject(record, scored, chunk: str, excluded: bool, unlike: str, same: str) -> Subject:
    """unlike: why it is left out; same: of whose files its own are copies."""
    one = Subject(record["subject"], chunk, "done")
    failed = record["failed"]
    if failed:
        one.status = "excluded" if excluded else "failed"
        one.score = 0.0 if excluded else float("inf")
        one.reasons = [f"{failed['step']}: {failed['reason']}"]
        return one
    one.status = "excluded" if excluded else "left out" if unlike else "done"
    one.phases = int(record["phases"])
    one.warnings = [_short(text) for text in quality.warnings_of(record)]
    one.figures = quality.figures_of(record, scored)
    volume = np.asarray(record["volume"], float)
    if len(volume) > 1 and volume.max() > 0:
        one.curve = list(volume[chosen_phases(len(volume), 25)] / volume.max())
    wrong = quality.flipped(record)
    if wrong:
        one.score, one.reasons = float("inf"), wrong
    odd = [*filter(None, [likeness.words_of(record), same])]
    if odd:
        one.reasons = odd + one.reasons
        one.score = float("inf")
    return one


def _short(text: str) -> str:
    """For the table; the subject's own report has all of it."""
    return text if len(text) <= WORDS else text[:WORDS].rsplit(" ", 1)[0] + " …"


def _studio(folder: Path) -> Optional[Studio]:
    path = folder / "atlas.npz"
    if not path.is_file():
        return None
    with np.load(path, allow_pickle=False) as found:
        return Studio(found["mean"], found["faces"])


def _with_pictures(ordered: Sequence[Subject], most: int) -> List[Subject]:
    return [one for one in ordered if one.phases][:most]


# ---------------------------------------------------------------- a subject's own report


def _write_chunk(folder, chunk, records, of, shown, studio, pictures, unit) -> None:
    path = folder / "landmarks" / f"{chunk}.npy"
    points = np.load(path, mmap_mode="r") if studio and path.is_file() else None
    parts = [f'<p><a href="../{REPORT.name}">All subjects</a></p>']
    for record, scored, _ in records:
        one = of[record["subject"]]
        parts.append(f'<h2 id="{html.escape(one.name, quote=True)}">{html.escape(one.name)}</h2>')
        parts.append(f"<p>{_said_of(one)}</p>")
        if one.phases:
            if points is not None:
                first = record["row"]
                places = chosen_phases(one.phases, STRIP)
                drawn = [studio.picture(points[first + place]) for place in places]
                parts.append(_strip(drawn, [record["names"][place] for place in places]))
                if one.name in shown:
                    root = record.get("root", 0)
                    at = places.index(root) if root in places else -1
                    pictures[shown[one.name]] = (
                        drawn[at] if at >= 0 else studio.picture(points[first + root])
                    )
            parts.append(_phase_table({**record, **(scored or {})}, unit))
            said = [w["text"] for w in record["warnings"]]
            parts += [f"<p>{html.escape(text)}</p>" for text in said]
        parts.append(_facts(record))
    title = f"Subjects of chunk {chunk}"
    store.write_text(folder / REPORTS / f"{chunk}.html", _whole(title, "\n".join(parts)))


def _drop_old_pages(folder: Path, chunks) -> None:
    for path in (folder / REPORTS).glob("*.html"):
        if path.stem not in chunks:
            path.unlink()


def _said_of(one: Subject) -> str:
    words = {
        "done": "",
        "excluded": f"Excluded from the model{f' ({one.why})' if one.why else ''}. ",
        "left out": "Left out of the model. ",
        "failed": "Could not be done. ",
    }
    reasons = "; ".join(one.reasons)
    return html.escape(words[one.status] + (reasons or "Nothing stands out."))


def _strip(drawn: Sequence[np.ndarray], names: Sequence[str]) -> str:
    image = _embedded(sheet(drawn, len(drawn)))
    words = html.escape("Phases " + ", ".join(map(str, names)), quote=True)
    return f'<p class="strip"><img src="{image}" alt="{words}" title="{words}"></p>'


def _phase_table(record: Mapping[str, Any], unit: str) -> str:
    columns = [
        [title] + [form.format(value) for value in record[key]]
        for title, key, form in PHASE_COLUMNS
        if record.get(key)
    ]
    widths = [max(map(len, column)) for column in columns]
    lines = [
        "  ".join(text.rjust(width) for text, width in zip(line, widths)) for line in zip(*columns)
    ]
    lines[0] += f"   ({unit}, {unit}³, °)"
    return (
        f"<details><summary>Every phase</summary><pre>{html.escape(chr(10).join(lines))}</pre>"
        "</details>"
    )


def _facts(record: Mapping[str, Any]) -> str:
    lines = [f"{key}: {value}" for key, value in (record.get("groups") or {}).items()]
    lines += [f"{one.get('sha256', '')}  {one['file']}" for one in record.get("files") or ()]
    if not lines:
        return ""
    text = html.escape("\n".join(lines))
    return f"<details><summary>Groups, files and their SHA-256</summary><pre>{text}</pre></details>"


# ---------------------------------------------------------------- the table of all


def _page(folder, ordered, references, settings, unit, middle, shown, ready, remarks) -> str:
    threshold = settings["threshold"]
    measures = [m for m in MEASURES if any(m.name in one.figures for one in ordered)]
    failed = sum(one.status == "failed" for one in ordered)
    unlike = sum(one.status == "left out" for one in ordered)
    out = sum(quality.stands_out(one, threshold) for one in ordered)
    data = {
        "threshold": threshold,
        "size": SHOWN,
        "across": COLUMNS,
        "subjects": [_row(one, measures, references, shown) for one in ordered],
        "measures": [
            {"title": m.title, "percent": m.kind == quality.PART, "means": m.means}
            for m in measures
        ],
        "middle": [round(float(value), 3) for value in middle],
    }
    told = json.dumps(data, ensure_ascii=False, separators=(",", ":"), allow_nan=False)
    told = told.replace("<", "\\u003c")  # nothing in it can end the element
    about = (
        f"{len(ordered)} subjects, {failed} of which could not be done and {unlike} are left out "
        f"of the model, since they are not like the others; {out} stand out. "
        "Those come first; every subject's name leads to its own report."
    )
    model = (
        '<p><a href="model/explore.html">Explore the model</a> · '
        '<a href="subjects.csv">The table as CSV</a></p>'
        if (folder / "model" / "explore.html").is_file()
        else ""
    )
    size = f"{SHOWN * COLUMNS}px"
    sprite = (
        f".picture {{ width: {SHOWN}px; height: {SHOWN}px; background-size: {size} auto; "
        f'background-image: url("{_embedded(ready)}"); }}'
        if ready.size
        else ""
    )
    body = "\n".join(
        [
            f'<p class="muted">{html.escape(about)}</p>{model}',
            '<div class="controls"><label><input type="search" id="search" placeholder="subject or '
            'reason"></label><label><input type="checkbox" id="only"> only what stands out</label>'
            '<span id="count" class="muted"></span><button id="save" disabled>Save '
            "exclude.csv</button></div>",
            '<div class="scroll tall"><table id="subjects"><thead></thead><tbody></tbody></table>'
            '</div><p><button id="more">More</button></p>'
            "<noscript><p>The table takes JavaScript; subjects.csv has the same figures.</p>"
            "</noscript>",
            _remarks(remarks),
            _how(ordered, measures, references, threshold, unit),
            f'<script type="application/json" id="data">{told}</script>',
            f"<script>{SCRIPT.read_text(encoding='utf-8')}</script>",
        ]
    )
    return _whole(f"Study of {len(ordered)} subjects: what stands out", body, sprite)


def _row(one: Subject, measures, references, shown) -> List[Any]:
    """name, chunk, status, score, reasons, phases, picture, curve, figures, their z, why it is
    excluded: study_page.js has the same order."""
    figures = [_rounded(one.figures.get(m.name)) for m in measures]
    beyond = [
        round(references[m.name].z(m, one.figures[m.name]), 1)
        if m.name in references and m.name in one.figures
        else 0
        for m in measures
    ]
    score = 1e9 if np.isinf(one.score) else round(one.score, 2)
    curve = [int(round(99 * value)) for value in one.curve]
    return [
        one.name,
        one.chunk,
        one.status,
        score,
        "; ".join([*one.reasons, *one.warnings]),
        one.phases,
        shown.get(one.name, -1),
        curve,
        figures,
        beyond,
        one.why,
    ]


def _remarks(remarks: Sequence[str]) -> str:
    if not remarks:
        return ""
    lines = "".join(f"<li>{html.escape(remark)}</li>" for remark in remarks)
    return f"<h2>What of the input was not taken</h2><ul>{lines}</ul>"


def _rounded(value: Optional[float]) -> Optional[float]:
    return None if value is None or not np.isfinite(value) else float(f"{value:.4g}")


def _how(ordered, measures, references: Mapping[str, Reference], threshold, unit) -> str:
    """What is compared, by what limits, and what to do about it."""
    done = sum(one.status == "done" for one in ordered)
    chance = quality.expected_by_chance(done, threshold)
    parts = [
        "<h2>What stands out, and why</h2>",
        "<p>Each figure is compared with the study's median: z = 0.6745 (x − median) / MAD, MAD "
        "the median distance from the median (Iglewicz and Hoaglin 1993), so that z counts "
        "standard deviations of what is usual and a few bad subjects do not move it. Lengths, "
        "volumes and deviations are compared by their logarithm, and a spread smaller than the "
        "least is not believed. A subject stands out beyond "
        f"z = {threshold:g} (the study's [quality] threshold); if all figures were spread "
        f"normally, about {chance:.2g} of {done} subjects would do so by chance. Whatever the "
        "others are like, a subject stands out that could not be done, whose map has flipped "
        "faces, or whose number of phases is not that of at least nine in ten. "
        f"With fewer than {quality.FEWEST} subjects nothing is compared.</p>",
        "<p>To leave subjects out of the model, tick them and save exclude.csv into the study's "
        "folder (columns: subject, exclude, why), or write it by hand; the next run leaves them "
        "out and does again what depends on them. What stands out need not be wrong: look at its "
        "own report first.</p>",
        '<div class="scroll"><table><thead><tr><th class="words">figure</th><th>median</th><th>'
        "limit</th><th>least spread</th><th>stand out</th>"
        '<th class="words">what it is</th></tr></thead><tbody>',
    ]
    for m in measures:
        known = references.get(m.name)
        median = limit = count = "–"
        if known:
            median = quality.value_of(m, known.median, unit)
            limit = quality.value_of(m, known.limit(m, threshold), unit)
            if m.both:
                limit = f"{quality.value_of(m, known.limit(m, -threshold), unit)} to {limit}"
            count = str(
                sum(
                    known.z(m, one.figures[m.name]) > threshold
                    for one in ordered
                    if m.name in one.figures
                )
            )
        least = f"{100 * m.least:.3g} %"
        if m.kind == quality.ANGLE:
            least = f"{m.least:g}°"
        parts.append(
            f'<tr><td class="words">{html.escape(m.title)}</td><td>{median}</td><td>{limit}</td>'
            f'<td>{least}</td><td>{count}</td><td class="words">{html.escape(m.means)}</td></tr>'
        )
    parts.append("</tbody></table></div>")
    return "\n".join(parts)


def _embedded(image: np.ndarray) -> str:
    return "data:image/png;base64," + base64.b64encode(png(image)).decode()


def _whole(title: str, body: str, style: str = "") -> str:
    return (
        '<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n<meta name="viewport" '
        'content="width=device-width, initial-scale=1">\n'
        f"<title>{html.escape(title)}</title>\n<style>{PAGE_STYLE}{STYLE}{style}</style>\n</head>\n"
        f"<body>\n<main>\n<h1>{html.escape(title)}</h1>\n{body}\n<footer>Made by "
        f"sphere-propagation {html.escape(version())}.</footer>\n</main>\n</body>\n</html>\n"
    )
