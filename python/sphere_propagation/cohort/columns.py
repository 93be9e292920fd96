# SPDX-License-Identifier: GPL-3.0-only
"""The columns of subjects.csv, which groups cannot be called after."""

from __future__ import annotations

FIT_COLUMNS = ("surface_distance", "deviation", "percentile", "residual_mean", "unexplained")
COLUMNS = (
    "subject",
    "chunk",
    "status",
    "step",
    "reason",
    "why_excluded",
    "phases",
    "root",
    "volume_max",
    "volume_min",
    "flipped_faces",
    "repaired_faces",
    "residual_mean",
    "residual_max",
    "area_ratio_sd",
    "surface_distance",
    "branch_distance",
    *(f"fit_{name}" for name in FIT_COLUMNS),
    "model_deviation",
    "model_residual",
    "warnings",
    "warning_texts",
)
