# SPDX-License-Identifier: GPL-3.0-only
"""Figures per layer and of shape models as CSV, and the small table at the end."""

from __future__ import annotations

import csv
from typing import Dict, List, NamedTuple, Optional, Sequence, Tuple

import numpy as np

from .correspondence import Correspondence
from .errors import SpherePropagationWarning
from .flags import by_flags
from .model import ShapeModel

COLUMNS = (
    "data",
    "method",
    "layer",
    "root",
    "parent",
    "route",
    "vertices",
    "faces",
    "flipped_faces",
    "repaired_faces",
    "area_ratio_sd",
    "area_log_mean",
    "angle_error_mean",
    "residual_mean",
    "residual_p95",
    "surface_distance_mean",
    "surface_distance_max",
    "unit",
    "seconds",
    "remeshing_seconds",
    "error_mm",
    "warnings",
)
COUNTS = ("parent", "route", "flipped_faces", "repaired_faces")
TEXTS = 2  # columns of the summary that are words: data and method


class Run(NamedTuple):
    """One method on one sequence, its error per layer where the truth is known, and what deserves a
    look."""

    data: str
    result: Correspondence
    errors: Optional[np.ndarray] = None
    warnings: Sequence[SpherePropagationWarning] = ()


def rows(run: Run) -> List[Dict[str, object]]:
    """One row per layer, with the names of COLUMNS."""
    table = []
    for i, surface in enumerate(run.result.surfaces):
        row = {
            "data": run.data,
            "method": run.result.method,
            "layer": surface.name,
            "root": int(i == run.result.root),
            "vertices": len(surface.vertices),
            "faces": len(surface.faces),
            "unit": run.result.unit,
            "error_mm": "" if run.errors is None else f"{run.errors[i]:.4f}",
            "warnings": " ".join(w.message for w in run.warnings if surface.name in w.layers),
        }
        for name, values in run.result.figures.items():
            row[name] = int(values[i]) if name in COUNTS else f"{values[i]:.6g}"
        table.append(row)
    return table


def write_csv(path, runs: Sequence[Run]) -> None:
    known = any(run.errors is not None for run in runs)
    columns = [name for name in COLUMNS if known or name != "error_mm"]
    with open(path, "w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, columns, extrasaction="ignore", lineterminator="\n")
        writer.writeheader()
        for run in runs:
            writer.writerows(rows(run))


def warning_rows(runs: Sequence[Run], shortly: bool = False) -> List[List[str]]:
    """One row per warning: data, method, its layers (none where it is about the result as a whole;
    shortly: as it calls them), its name, what it says of them."""
    return [
        [
            run.data,
            run.result.method,
            warning.subject if shortly else "; ".join(warning.layers),
            warning.message,
            by_flags(warning.said),
        ]
        for run in runs
        for warning in run.warnings
    ]


def write_warnings(path, runs: Sequence[Run]) -> None:
    """The header alone where there are none."""
    with open(path, "w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(["data", "method", "layer", "message", "text"])
        writer.writerows(warning_rows(runs))


def write_scores(path, model: ShapeModel) -> None:
    """One row per shape, as the filter's own .csv."""
    with open(path, "w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(["shape", *(f"mode_{m + 1}" for m in range(len(model.modes)))])
        for name, scores in zip(model.names, model.scores):
            writer.writerow([name, *(f"{score:.17g}" for score in scores)])


def write_measures(path, model: ShapeModel) -> None:
    """One row per number of modes."""
    with open(path, "w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(["modes", "eigenvalue", *model.figures])
        for m, eigenvalue in enumerate(model.eigenvalues):
            writer.writerow(
                [
                    m + 1,
                    f"{eigenvalue:.10g}",
                    *(f"{values[m]:.6g}" for values in model.figures.values()),
                ]
            )


def model_summary(model: ShapeModel, share: float = 0.95) -> str:
    """A line about how the variance spreads over the modes."""
    if not len(model.modes):
        return "all shapes are identical once aligned"
    found = model.figures["variance_share"]
    enough = int(np.argmax(found >= share)) + 1
    return (
        f"{len(model.modes)} mode{'s' * (len(model.modes) > 1)}, the first with "
        f"{100 * found[0]:.1f} % of the variance, {enough} for {100 * share:.0f} %"
    )


def summary_rows(runs: Sequence[Run]) -> List[List[str]]:
    """One row per run, and the header before them."""
    units = list(dict.fromkeys(run.result.unit for run in runs))
    length = f", {units[0]}" if len(units) == 1 else ""
    header = ["data", "method", "layers", "flips", "repaired", "root sd", f"residual{length}"]
    known = any(run.errors is not None for run in runs)
    if known:
        header += [f"worst error{length}", f"mean error{length}"]
    lines = [header]
    for data, result, errors, _ in runs:
        figures = result.figures
        line = [
            data,
            result.method,
            str(len(result.surfaces)),
            f"{figures['flipped_faces'].sum():.0f}",
            f"{figures['repaired_faces'].sum():.0f}",
            f"{figures['area_ratio_sd'][result.root]:.4f}",
            f"{figures['residual_mean'].mean():.3g}",
        ]
        if known:
            line += ["", ""] if errors is None else [f"{errors.max():.2f}", f"{errors.mean():.2f}"]
        lines.append(line)
    return lines


SUMMARY_WORDS = (
    ("layers", "how many surfaces, the root among them"),
    (
        "flips",
        "faces of all maps that lie upside down on the sphere, counted by the certificate: 0 in a "
        "valid map",
    ),
    (
        "repaired",
        "faces that were flipped when a map arrived on its surface, and that were put right by "
        "moving the vertices around them: many of them, on one layer, deserve a look",
    ),
    (
        "root sd",
        "standard deviation of the root map's area ratio, which is a face's share of the sphere "
        "over its share of the surface: 0 where areas are preserved",
    ),
    (
        "residual",
        "mean distance of the surfaces' vertices from the root's surface as it was deformed to fit "
        "them: it measures the fit, not the correspondence",
    ),
    (
        "error",
        "distance of the landmarks from the material points that they marked on the root, the mean "
        "over each layer",
    ),
)  # of summary_rows, as captions have them


def words_of_summary(runs: Sequence[Run]) -> List[Tuple[str, str]]:
    """What the columns of the summary mean."""
    known = any(run.errors is not None for run in runs)
    return [pair for pair in SUMMARY_WORDS if known or pair[0] != "error"]


def summary(runs: Sequence[Run]) -> str:
    """One line per run."""
    lines = summary_rows(runs)
    widths = [max(map(len, column)) for column in zip(*lines)]

    def aligned(line: Sequence[str]) -> str:
        words = [text.ljust(width) for text, width in zip(line[:TEXTS], widths)]
        numbers = [text.rjust(width) for text, width in zip(line[TEXTS:], widths[TEXTS:])]
        return "  ".join(words + numbers).rstrip()

    return "\n".join(map(aligned, lines))
