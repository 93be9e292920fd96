# SPDX-License-Identifier: GPL-3.0-only
"""One HTML page with everything that a run has to show: pictures and tables inside, nothing from
the network."""

from __future__ import annotations

import base64
import html
from pathlib import Path
from typing import List, NamedTuple, Optional, Sequence, Tuple

from . import report
from .explorer import Explorer
from .model import ShapeModel
from .provenance import Provenance
from .version import version

STYLE = """
:root { color-scheme: light; }
body {
  margin: 0; background: #f5f6f8; color: #1c2530;
  font: 16px/1.55 system-ui, "Segoe UI", "DejaVu Sans", sans-serif;
}
main { max-width: 1180px; margin: 0 auto; padding: 40px 28px 64px; }
h1 { font-size: 30px; line-height: 1.2; margin: 0 0 8px; }
h2 { font-size: 23px; margin: 52px 0 6px; padding-top: 22px; border-top: 2px solid #d8dce2; }
h3 { font-size: 17px; margin: 30px 0 8px; }
p { margin: 6px 0 14px; max-width: 82ch; }
.muted, figcaption, footer { color: #5b6570; }
figure { margin: 20px 0 28px; }
figure img {
  display: block; width: 100%; height: auto;
  background: #fff; border-radius: 8px; box-shadow: 0 1px 4px rgba(20, 30, 45, .14);
}
figure.narrow img { max-width: 760px; }
figcaption { font-size: 14.5px; margin-top: 8px; max-width: 96ch; }
.scroll {
  overflow-x: auto; margin: 12px 0 24px;
  background: #fff; border-radius: 8px; box-shadow: 0 1px 4px rgba(20, 30, 45, .14);
}
table {
  border-collapse: collapse; width: 100%; font-size: 14px; font-variant-numeric: tabular-nums;
}
th, td {
  padding: 6px 12px; text-align: right; white-space: nowrap; border-bottom: 1px solid #e8ebef;
}
th { color: #5b6570; font-weight: 600; }
td.words, th.words { text-align: left; }
td.words:last-child { white-space: normal; }
details { margin: 12px 0; }
summary { cursor: pointer; font-weight: 600; }
.explorer summary {
  display: inline-block; padding: 6px 16px; border-radius: 6px; background: #0b63a5; color: #fff;
}
.explorer iframe {
  display: block; width: 100%; height: 700px; max-height: 92vh; margin-top: 12px;
  border: 1px solid #d8dce2; border-radius: 8px; box-sizing: border-box;
}
dl { font-size: 14px; margin: -12px 0 24px; }
dt { float: left; clear: left; font-weight: 600; margin-right: 8px; }
dd { margin: 0 0 4px; max-width: 96ch; }
.box { margin-top: 52px; padding: 4px 24px 8px; border: 2px solid #d8dce2; border-radius: 8px; }
.box h2 { margin: 12px 0 0; padding: 0; border: 0; }
.box td { white-space: normal; overflow-wrap: anywhere; }
.box > .scroll td.words:first-child { white-space: nowrap; font-weight: 600; color: #5b6570; }
footer { margin-top: 56px; font-size: 14px; }
"""


class Picture(NamedTuple):
    path: Path
    caption: str
    narrow: bool = False


class Table(NamedTuple):
    title: str
    header: Sequence[str]  # empty: none
    rows: Sequence[Sequence[str]]
    words: int = 1  # columns from the left that are text
    folded: bool = False
    key: Sequence[Tuple[str, str]] = ()  # words of the header, and what they mean


class Chapter(NamedTuple):
    title: str
    text: str
    pictures: Sequence[Picture]
    tables: Sequence[Table]
    box: bool = False  # set apart from the others
    explorer: Optional[Explorer] = None  # of its shape model


def write_page(path, title: str, text: str, chapters: Sequence[Chapter]) -> None:
    """Pictures that are not there are left out."""
    parts = [f"<h1>{html.escape(title)}</h1>", f'<p class="muted">{html.escape(text)}</p>']
    for chapter in chapters:
        parts.append('<section class="box">' if chapter.box else "")
        parts.append(f"<h2>{html.escape(chapter.title)}</h2>" if chapter.title else "")
        parts.append(f"<p>{html.escape(chapter.text)}</p>" if chapter.text else "")
        parts += [_figure(picture) for picture in chapter.pictures if picture.path.is_file()]
        parts.append(_explorer(chapter.explorer) if chapter.explorer else "")
        parts += [_table(table) for table in chapter.tables]
        parts.append("</section>" if chapter.box else "")
    parts.append(
        f"<footer>Made by sphere-propagation {html.escape(version())}. Pictures and tables are "
        "inside this file.</footer>"
    )
    body = "\n".join(filter(None, parts))
    Path(path).write_text(
        '<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n<meta '
        'name="viewport" content="width=device-width, initial-scale=1">\n'
        f"<title>{html.escape(title)}</title>\n<style>{STYLE}</style>\n</head>\n<body>\n<main>\n"
        f"{body}\n</main>\n</body>\n</html>\n",
        encoding="utf-8",
    )


WORDS_OF_LAYERS = (
    (
        "area ratio sd",
        "of the layer's own map: only the root's map preserves areas, the others follow "
        "the correspondence",
    ),
    ("angle error", "mean difference of the faces' angles on the sphere and on the surface"),
    (
        "landmark mesh to surface",
        "mean distance of points of the landmarks' mesh from the surface: what so many landmarks "
        "leave out",
    ),
    ("s", "seconds that the layer's map took"),
)  # of layer_table, beside those of the summary
WORDS_OF_MODELS = (
    (
        "eigenvalue",
        "variance of the mode, summed over all landmarks; the share of the variance is that of all "
        "modes up to this one",
    ),
    (
        "generalisation",
        "distance of a shape that was left out from its best approximation by the others' model",
    ),
    ("specificity", "distance of random shapes of the model from the nearest given one"),
)


def summary_table(runs: Sequence[report.Run]) -> Table:
    """One row per run."""
    header, *rows = report.summary_rows(runs)
    return Table(
        "Figures of the runs", header, rows, report.TEXTS, key=report.words_of_summary(runs)
    )


def provenance_chapter(made: Provenance) -> Chapter:
    """How to make it again, and how to cite it."""
    tables = [Table("", [], made.rows(), words=2)]
    if made.inputs:
        rows = [[str(path), digest] for path, digest in made.inputs]
        title = f"Inputs and their SHA-256: {len(rows)} file{'s' * (len(rows) > 1)}"
        tables.append(Table(title, ["file", "SHA-256"], rows, words=2, folded=True))
    text = "What it takes to make this again; run.json holds the same for programs."
    return Chapter("How this was made", text, [], tables, box=True)


def warning_tables(runs: Sequence[report.Run]) -> List[Table]:
    """What deserves a look, a row each; no table where there is nothing."""
    rows = [
        [data, method, layer, text]
        for data, method, layer, _, text in report.warning_rows(runs, shortly=True)
    ]
    header = ["data", "method", "layer", "what the filters say"]
    return [Table("What deserves a look", header, rows, words=len(header))] if rows else []


def layer_table(run: report.Run) -> Table:
    """One row per layer."""
    unit = run.result.unit
    columns = [
        ("layer", "layer"),
        ("vertices", "vertices"),
        ("flipped_faces", "flips"),
        ("area_ratio_sd", "area ratio sd"),
        ("angle_error_mean", "angle error, °"),
        ("repaired_faces", "repaired"),
        ("residual_mean", f"residual, {unit}"),
        ("surface_distance_mean", f"landmark mesh to surface, {unit}"),
        ("error_mm", "error, mm"),
        ("seconds", "s"),
    ]
    rows = report.rows(run)
    columns = [
        (key, words) for key, words in columns if any(row.get(key, "") != "" for row in rows)
    ]
    cells = [
        [
            _short(row.get(key, "")) + (" (root)" if key == "layer" and row["root"] else "")
            for key, _ in columns
        ]
        for row in rows
    ]
    return Table(
        f"Every layer: {run.data}, {run.result.method.lower()}",
        [words for _, words in columns],
        cells,
        folded=True,
        key=WORDS_OF_LAYERS,
    )


def model_table(model: ShapeModel, unit: str, max_modes: int = 10) -> Table:
    """One row per number of modes."""

    def with_error(name: str, m: int) -> str:
        return f"{model.figures[name][m]:.3f} ± {model.figures[name + '_error'][m]:.3f}"

    rows = [
        [
            str(m + 1),
            f"{model.eigenvalues[m]:.4g}",
            f"{100 * model.figures['variance_share'][m]:.2f} %",
            with_error("generalisation", m),
            with_error("specificity", m),
        ]
        for m in range(min(max_modes, len(model.modes)))
    ]
    return Table(
        "The shape model by number of modes",
        [
            "modes",
            f"eigenvalue, {unit}²",
            "share of the variance",
            f"generalisation, {unit}",
            f"specificity, {unit}",
        ],
        rows,
        words=0,
        key=WORDS_OF_MODELS,
    )


def _short(value) -> str:
    try:
        return str(value) if isinstance(value, int) else f"{float(value):.4g}"
    except ValueError:
        return str(value)


def _figure(picture: Picture) -> str:
    data = base64.b64encode(picture.path.read_bytes()).decode()
    caption = html.escape(picture.caption)
    return (
        f"<figure{' class=narrow' if picture.narrow else ''}>"
        f'<img src="data:image/png;base64,{data}" alt="{caption}">'
        f"<figcaption>{caption}</figcaption></figure>"
    )


def _explorer(explorer: Explorer) -> str:
    """Folded and not loaded before somebody wants it: where it lies it takes the wheel."""
    load = "const frame = this.querySelector('iframe'); frame.srcdoc ||= frame.dataset.page"
    return (
        f'<details class="explorer" ontoggle="{load}"><summary>Explore the shape model</summary>'
        f'<iframe title="{html.escape(explorer.about)}" '
        f'data-page="{html.escape(explorer.html)}"></iframe></details>'
        '<p class="muted">Sliders for the modes, the shapes played one after another, distances as '
        "colours, landmarks to drag: inside this page, for browsers with WebGL 2.</p>"
    )


def _table(table: Table) -> str:
    def row(cells: Sequence[str], tag: str) -> str:
        return (
            "<tr>"
            + "".join(
                f"<{tag}{' class=words' if k < table.words else ''}>{html.escape(cell)}</{tag}>"
                for k, cell in enumerate(cells)
            )
            + "</tr>"
        )

    lines: List[str] = [
        '<div class="scroll"><table>',
        f"<thead>{row(table.header, 'th')}</thead>" if table.header else "",
        "<tbody>",
        *(row(cells, "td") for cells in table.rows),
        "</tbody></table></div>",
    ]
    if table.key:
        lines += [
            "<dl>",
            *(
                f"<dt>{html.escape(word)}</dt><dd>{html.escape(text)}</dd>"
                for word, text in table.key
            ),
            "</dl>",
        ]
    content = "\n".join(filter(None, lines))
    title = html.escape(table.title)
    if table.folded:
        return f"<details><summary>{title}</summary>{content}</details>"
    return f"<h3>{title}</h3>{content}" if title else content
