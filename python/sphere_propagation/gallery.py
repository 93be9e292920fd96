# SPDX-License-Identifier: GPL-3.0-only
"""The pictures of a finished job, and the page that shows them beside its figures."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import Callable, List, NamedTuple, Optional, Sequence, Set

import numpy as np

from . import model_pictures, page, pictures, report
from .explorer import Explorer
from .model import ShapeModel
from .progress import Lines
from .provenance import Provenance
from .results import ResultFolder
from .views import Row, chosen_phases

PAGE = "report.html"


MODEL, ERRORS = "model", "errors"  # what a section may have beside rows and runs


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
    explorer: Optional[Explorer] = None  # of the model

    @property
    def kinds(self) -> Set[str]:
        """Which of MODEL and ERRORS there is something to be drawn of."""
        has_modes = self.model is not None and len(self.model.modes) > 0
        return {kind for kind, has in ((MODEL, has_modes), (ERRORS, bool(self.errors))) if has}


class Drawing(NamedTuple):
    """One picture of a section, where that has what it needs: MODEL, ERRORS or nothing more."""

    name: str  # of its file; {prefix} is the section's
    what: str
    needs: Optional[str]
    draw: Callable[[Section, Sequence[Path]], object]
    caption: Callable[[Section], str]
    narrow: Callable[[Section], bool] = lambda section: False


def show(
    results: ResultFolder,
    title: str,
    text: str,
    sections: Sequence[Section],
    draw: bool,
    steps: Lines,
    formats: Sequence[str],
    made_by: Provenance,
) -> None:
    """Draws everything, where that is wished and possible, and writes the page. formats: of
    pictures, beside png."""
    chapters = []
    for section in sections:
        made = []
        for drawing in _drawings(section.kinds) if draw else ():
            name = drawing.name.format(prefix=section.prefix)
            steps.begin(f"{name}: {drawing.what}")
            names = [name, *(f"{name[:-4]}.{ending}" for ending in formats)]
            path = results.write_all(names, partial(drawing.draw, section))[0]
            made.append(page.Picture(path, drawing.caption(section), drawing.narrow(section)))
            steps.done(f"{name}: {drawing.what}")
        tables = [page.summary_table(section.runs), *page.warning_tables(section.runs)]
        if MODEL in section.kinds:
            tables.append(page.model_table(section.model, _unit(section)))
        tables += [page.layer_table(run) for run in section.runs]
        chapters.append(
            page.Chapter(section.title, section.text, made, tables, explorer=section.explorer)
        )
    chapters.append(page.provenance_chapter(made_by))
    results.write(PAGE, lambda path: page.write_page(path, title, text, chapters))


def picture_count(kinds: Set[str]) -> int:
    """How many pictures a section of these kinds has."""
    return len(_drawings(kinds))


def _drawings(kinds: Set[str]) -> List[Drawing]:
    return [drawing for drawing in DRAWINGS if drawing.needs is None or drawing.needs in kinds]


def _unit(section: Section) -> str:
    return section.rows[0].result.unit


def _modes_caption(section: Section) -> str:
    model = section.model
    reach = float(np.abs(model.scores[:, 0]).max() / np.sqrt(model.eigenvalues[0]))
    return (
        "The shape model: its mean, and three standard deviations along the first modes; red lies "
        "outside of the mean, blue inside. Along the first mode these shapes themselves reach "
        f"{reach:.1f} standard deviations: what lies beyond is the model's guess."
    )


def _volume_caption(section: Section) -> str:
    if section.true_volumes is None:
        return f"The volume that the surface of each {section.rows[0].noun} encloses."
    return (
        "The volume that the surfaces enclose. The dashed line is the phantom's own volume: the "
        "difference comes from the thick slices."
    )


def _landmarks_caption(section: Section) -> str:
    row = section.rows[0]
    count = len(row.result.surfaces)
    shown = len(chosen_phases(count, pictures.COLUMNS, 2 if len(section.rows) == 1 else 1))
    some = f"all {row.noun}s" if shown == count else f"{shown} of {count} {row.noun}s"
    return (
        f"{row.result.landmarks.shape[1]} landmarks on {some}. Landmark j has the same colour on "
        "each of them and marks the same place. The hue is the longitude on the sphere; the north "
        "is light, the south dark, so that drift shows in any direction."
    )


def _map_caption(section: Section) -> str:
    return (
        "The surface that got the first map, the root, beside the sphere: every field covers the "
        "same share of both. Flips are faces that lie upside down on the sphere, of which a valid "
        "map has none; the area ratio of a face is its share of the sphere over its share of the "
        "surface, and the standard deviation of that (root sd in the table) is 0 where areas are "
        "preserved."
    )


def _scores_caption(section: Section) -> str:
    row = section.rows[0]
    if not row.timed:
        return (
            "Left: the scores of each shape along the first modes, in standard deviations. Right: "
            "the plane of the first two, in which similar shapes lie close together."
        )
    back = " and the first follows the last" if row.result.order == "Cyclic time" else ""
    return (
        "Left: the scores of each phase along the first modes, in standard deviations. Right: the "
        f"path of the phases in the plane of the first two; the colour is the phase{back}."
    )


DRAWINGS = (  # in their order on the page
    Drawing(
        "{prefix}landmarks.png",
        "landmarks on the surfaces",
        None,
        lambda section, paths: pictures.landmarks_on_surfaces(section.rows, paths),
        _landmarks_caption,
    ),
    Drawing(
        "{prefix}checkerboard.png",
        "the maps on the surfaces",
        None,
        lambda section, paths: pictures.maps_on_surfaces(section.rows, paths),
        lambda section: (
            "One checkerboard of the sphere, drawn on the surfaces through their maps. Where these "
            f"correspond, each field keeps its anatomical place on every {section.rows[0].noun}."
        ),
    ),
    Drawing(
        "{prefix}map.png",
        "the root and its sphere",
        None,
        lambda section, paths: pictures.root_and_sphere(section.rows, paths),
        _map_caption,
        narrow=lambda section: len(section.rows) == 1,
    ),
    Drawing(
        "error.png",
        "error over the cycle",
        ERRORS,
        lambda section, paths: pictures.errors_over_phase(section.rows, section.errors, paths),
        lambda section: (
            "Mean distance of the landmarks from the material points that they marked on the root, "
            "phase by phase, for both methods."
        ),
    ),
    Drawing(
        "{prefix}modes.png",
        "mean shape and modes",
        MODEL,
        lambda section, paths: model_pictures.modes(
            section.model, paths, unit=_unit(section), up=section.rows[0].up
        ),
        _modes_caption,
    ),
    Drawing(
        "{prefix}model.png",
        "how good the model is",
        MODEL,
        lambda section, paths: model_pictures.measures(section.model, paths, unit=_unit(section)),
        lambda section: (
            "By number of modes: the share of the variance that they hold; how far a shape that "
            "the model has not seen lies from its best approximation; how far random shapes of "
            "the model lie from the nearest real one. Bands are standard errors."
        ),
    ),
    Drawing(
        "{prefix}scores.png",
        "scores of the model",
        MODEL,
        lambda section, paths: model_pictures.scores(section.rows[0], section.model, paths),
        _scores_caption,
    ),
    Drawing(
        "{prefix}volume.png",
        "volumes",
        MODEL,
        lambda section, paths: model_pictures.volumes(section.rows[0], paths, section.true_volumes),
        _volume_caption,
        narrow=lambda section: True,
    ),
)
