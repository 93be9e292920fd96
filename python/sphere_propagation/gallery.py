# SPDX-License-Identifier: GPL-3.0-only
"""The pictures of a finished job, and the page that shows them beside its figures."""

from __future__ import annotations

from typing import Callable, List, NamedTuple, Optional, Sequence

import numpy as np

from . import model_pictures, page, pictures, report
from .model import ShapeModel
from .progress import Lines
from .results import ResultFolder
from .views import Row

PAGE = "report.html"


class Section(NamedTuple):
    """What belongs together on the page: one sequence with its shape model, or several beside their
    truth."""

    rows: Sequence[Row]
    runs: Sequence[report.Run]
    title: str = ""
    text: str = ""
    prefix: str = ""  # of the pictures' names
    model: Optional[ShapeModel] = None  # of the first row
    true_volumes: Optional[np.ndarray] = None  # of the first row, where they are known
    errors: Optional[Sequence[dict]] = None  # per row: method -> mm per phase


class Drawing(NamedTuple):
    name: str
    what: str
    draw: Callable
    caption: str
    narrow: bool = False


def show(
    results: ResultFolder,
    title: str,
    text: str,
    sections: Sequence[Section],
    draw: bool,
    steps: Lines,
) -> None:
    """Draws everything, where that is wished and possible, and writes the page."""
    chapters = []
    for section in sections:
        made = []
        for drawing in _drawings(section) if draw else ():
            steps.begin(f"{drawing.name}: {drawing.what}")
            made.append(
                page.Picture(
                    results.write(drawing.name, drawing.draw), drawing.caption, drawing.narrow
                )
            )
            steps.done(f"{drawing.name}: {drawing.what}")
        tables = [page.summary_table(section.runs)]
        if section.model is not None and len(section.model.modes):
            tables.append(page.model_table(section.model))
        tables += [page.layer_table(run) for run in section.runs]
        chapters.append(page.Chapter(section.title, section.text, made, tables))
    results.write(PAGE, lambda path: page.write_page(path, title, text, chapters))


def picture_count(with_model: int = 0, with_errors: int = 0) -> int:
    """How many pictures so many sections of each kind have."""
    return 7 * with_model + 4 * with_errors


def _drawings(section: Section) -> List[Drawing]:
    rows, model, prefix = section.rows, section.model, section.prefix
    result = rows[0].result
    count = result.landmarks.shape[1]
    found = [
        Drawing(
            f"{prefix}landmarks.png",
            "landmarks over the cycle",
            lambda path: pictures.landmarks_over_cycle(rows, path),
            f"{count} landmarks on some phases. Landmark j has one colour on all of them: it is "
            "the same place.",
        ),
        Drawing(
            f"{prefix}checkerboard.png",
            "the maps over the cycle",
            lambda path: pictures.maps_over_cycle(rows, path),
            "One checkerboard of the sphere, drawn on the surfaces through their maps. A field "
            "that keeps its place on the organ shows that the maps correspond.",
        ),
        Drawing(
            f"{prefix}map.png",
            "the root and its sphere",
            lambda path: pictures.root_and_sphere(rows, path),
            "The surface that got the first map, beside the sphere: every field takes the same "
            "share of both.",
            len(rows) == 1,
        ),
    ]
    if section.errors:
        found.append(
            Drawing(
                "error.png",
                "error over the cycle",
                lambda path: pictures.errors_over_phase(rows, section.errors, path),
                "How far the landmarks lie from the material points that they began on, phase by "
                "phase: both methods.",
            )
        )
    if model is not None and len(model.modes):
        reach = float(np.abs(model.scores[:, 0]).max() / np.sqrt(model.eigenvalues[0]))
        unit, closed = rows[0].unit or "units", result.order == "Cyclic time"
        found += [
            Drawing(
                f"{prefix}modes.png",
                "mean shape and modes",
                lambda path: model_pictures.modes(model, path, unit=unit, up=rows[0].up),
                "The shape model: its mean, and three standard deviations along the first modes; "
                "red lies outside of the mean, blue inside. Along the first mode these shapes "
                f"themselves reach {reach:.1f} standard deviations: what lies beyond is the "
                "model's guess.",
            ),
            Drawing(
                f"{prefix}model.png",
                "how good the model is",
                lambda path: model_pictures.measures(model, path, unit=unit),
                "By number of modes: the share of the variance that they hold; how far a shape "
                "that the model has not seen lies from its best approximation; how far random "
                "shapes of the model lie from the nearest real one. Bands are standard errors.",
            ),
            Drawing(
                f"{prefix}scores.png",
                "scores over the phases",
                lambda path: model_pictures.scores(
                    model, path, closed=closed, phases=rows[0].numbers()
                ),
                "Where each phase lies along the first modes.",
            ),
            Drawing(
                f"{prefix}volume.png",
                "volume over the phases",
                lambda path: model_pictures.volumes(rows[0], path, section.true_volumes),
                "What the surfaces enclose."
                + (
                    " The dashed line is what is known of the phantom: the difference comes from "
                    "the slices."
                    if section.true_volumes is not None
                    else ""
                ),
                True,
            ),
        ]
    return found
