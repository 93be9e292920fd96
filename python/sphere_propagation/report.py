"""Figures per layer as CSV, and the small table at the end."""
from __future__ import annotations

import csv
from typing import Dict, List, NamedTuple, Optional, Sequence

import numpy as np

from .correspondence import Correspondence

COLUMNS = ("data", "method", "layer", "root", "parent", "vertices", "faces", "flipped_faces", "repaired_faces", "area_ratio_sd",
           "area_log_mean", "angle_error_mean", "residual_mean", "residual_p95", "surface_distance_mean", "surface_distance_max",
           "seconds", "remeshing_seconds", "error_mm")
COUNTS = ("parent", "flipped_faces", "repaired_faces")


class Run(NamedTuple):
    """One method on one sequence, and its error per layer where the truth is known."""

    data: str
    result: Correspondence
    errors: Optional[np.ndarray] = None


def rows(run: Run) -> List[Dict[str, object]]:
    """One row per layer, with the names of COLUMNS."""
    table = []
    for i, surface in enumerate(run.result.surfaces):
        row = {"data": run.data, "method": run.result.method, "layer": surface.name, "root": int(i == run.result.root),
               "vertices": len(surface.vertices), "faces": len(surface.faces),
               "error_mm": "" if run.errors is None else f"{run.errors[i]:.4f}"}
        for name, values in run.result.figures.items():
            row[name] = int(values[i]) if name in COUNTS else f"{values[i]:.6g}"
        table.append(row)
    return table


def write_csv(path, runs: Sequence[Run]) -> None:
    with open(path, "w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, COLUMNS, extrasaction="ignore", lineterminator="\n")
        writer.writeheader()
        for run in runs:
            writer.writerows(rows(run))


def summary(runs: Sequence[Run]) -> str:
    """One line per run."""
    head = ["data", "method", "layers", "flips", "repaired", "root sd", "residual"]
    known = any(run.errors is not None for run in runs)
    if known:
        head += ["worst error", "mean error"]
    lines = [head]
    for data, result, errors in runs:
        figures = result.figures
        line = [data, result.method, str(len(result.surfaces)), f"{figures['flipped_faces'].sum():.0f}",
                f"{figures['repaired_faces'].sum():.0f}", f"{figures['area_ratio_sd'][result.root]:.4f}",
                f"{figures['residual_mean'].mean():.2f}"]
        if known:
            line += ["", ""] if errors is None else [f"{errors.max():.2f} mm", f"{errors.mean():.2f} mm"]
        lines.append(line)
    widths = [max(len(line[k]) for line in lines) for k in range(len(head))]
    pad = lambda text, k: text.ljust(widths[k]) if k < 2 else text.rjust(widths[k])
    return "\n".join("  ".join(pad(text, k) for k, text in enumerate(line)).rstrip() for line in lines)
