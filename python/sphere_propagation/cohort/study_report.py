# SPDX-License-Identifier: GPL-3.0-only
"""Step `report`: what people open. The model as a file that the package and others read, a table of
subjects, and the page."""

from __future__ import annotations

import csv
import io
from pathlib import Path
from typing import Any, Dict, Iterator, List, Mapping, Tuple

import numpy as np

from .. import attention, filters
from ..explorer import explore
from ..model import ShapeModel
from ..model_files import MEASURED, name_arrays
from . import atlas, likeness, merging, quality, spatial, store, twins
from .columns import COLUMNS, FIT_COLUMNS
from .landmarks import LANDMARKS
from .plan import PLAN

MODEL = Path("model")
SAMPLE = 500  # subjects whose frames generalisation and specificity are measured with
TRAINING = 2000  # shapes whose scores the model's file has


def run() -> int:
    """Writes the files; returns how many subjects are in the model."""
    plan = store.read_json(PLAN / "model.json")
    why = store.read_json(PLAN / "report.json")["why"]
    table = list(rows_of_subjects(plan, why))
    store.write_text(Path("subjects.csv"), _as_csv(table))
    model = _model(plan)
    unit, cyclic = plan["parameters"]["unit"], False
    with store.whole(MODEL / "explore.html") as part:
        explore(model, title="cohort", unit=unit, cyclic=cyclic).save(part)
    quality.write(Path("."))
    return sum(row["status"] == "done" for row in table)


def rows_of_subjects(plan: Mapping[str, Any], why: Mapping[str, str]) -> Iterator[Dict[str, Any]]:
    """As subjects.csv has them, one chunk in memory at a time. why: whom somebody excluded."""
    blocks = merging.blocks_of(0)
    same = twins.found_in(Path("."), [c for those in blocks.values() for c in those], plan)
    for block, chunks in blocks.items():
        scores = store.read_json(spatial.SCORES / f"{block}.json")["subjects"]
        in_model = {one["subject"]: one for one in scores}
        for chunk in chunks:
            for record in store.read_json(LANDMARKS / f"{chunk}.json")["subjects"]:
                name, failed = record["subject"], record["failed"]
                row = {**record["groups"], "subject": name, "chunk": chunk, "status": "done"}
                if failed:
                    row.update(status="failed", step=failed["step"], reason=failed["reason"])
                else:
                    odd = [likeness.words_of(record), same.get(name, "")]
                    row["reason"] = "; ".join(filter(None, odd))
                    if likeness.left_out(record, plan["parameters"]):
                        row.update(status="left out", step="model")
                    row.update(_figures(record, in_model.get(name)))
                if name in why:
                    row.update(status="excluded", why_excluded=why[name])
                yield row


def _figures(record: Mapping[str, Any], scored) -> Dict[str, Any]:
    row = {
        "phases": record["phases"],
        "root": record["root"],
        "volume_max": max(record["volume"]),
        "volume_min": min(record["volume"]),
        "flipped_faces": sum(record["flipped_faces"]),
        "repaired_faces": sum(record["repaired_faces"]),
        "residual_mean": float(np.mean(record["residual_mean"])),
        "residual_max": max(record["residual_mean"]),
        "area_ratio_sd": max(record["area_ratio_sd"]),
        "surface_distance": max(record["surface_distance_mean"]),
        "branch_distance": record.get("branch_distance", ""),
        "warnings": " ".join(sorted({one["message"] for one in record["warnings"]})),
        "warning_texts": " ".join(quality.warnings_of(record)),
    }
    row.update({f"fit_{name}": record["fit"].get(name, "") for name in FIT_COLUMNS})
    if scored:
        row["model_deviation"] = max(scored["deviation"])
        row["model_residual"] = max(scored["residual"])
    return row


def _as_csv(table: List[Dict[str, Any]]) -> str:
    groups = list(dict.fromkeys(key for row in table for key in row if key not in COLUMNS))
    text = io.StringIO()
    writer = csv.DictWriter(text, [*COLUMNS, *groups], lineterminator="\n", restval="")
    writer.writeheader()
    for row in table:
        writer.writerow(
            {
                key: f"{value:.6g}" if isinstance(value, float) else value
                for key, value in row.items()
            }
        )
    return text.getvalue()


def _training(plan: Mapping[str, Any]) -> Tuple[List[str], np.ndarray]:
    """Names and scores of up to TRAINING shapes, evenly spread."""
    total = 0
    blocks = list(merging.blocks_of(0))
    for block in blocks:
        total += len(np.load(spatial.SCORES / f"{block}.npy", mmap_mode="r"))
    count = min(total, TRAINING)
    wanted = [i * total // count for i in range(count)]
    names, rows, first = [], [], 0
    for block in blocks:
        scores = np.load(spatial.SCORES / f"{block}.npy", mmap_mode="r")
        called = [
            f"{one['subject']} {phase}" if one["phases"] > 1 else one["subject"]
            for one in store.read_json(spatial.SCORES / f"{block}.json")["subjects"]
            for phase in one["names"]
        ]
        here = [i - first for i in wanted if first <= i < first + len(scores)]
        names += [called[i] for i in here]
        rows.append(np.asarray(scores[here]))
        first += len(scores)
    return names, np.concatenate(rows)


def _model(plan: Mapping[str, Any]) -> ShapeModel:
    """model/model.npz, model.csv and measures.csv."""
    basis = store.read_arrays(spatial.BASIS)
    names, scores = _training(plan)
    values, total = basis["eigenvalues"], float(basis["total_variance"])
    left = basis["mean"].size - len(values)
    noise = max(0.0, total - values.sum()) / left if left else 0.0
    made = atlas.read()
    faces = made.faces
    measured = _measures(plan, faces)
    store.write_arrays(
        MODEL / "model.npz",
        {
            "mean": basis["mean"],
            "modes": basis["modes"],
            "eigenvalues": values,
            "scores": scores,
            "faces": np.asarray(faces, np.int32),
            "noise_variance": np.float64(noise),
            "names": np.array(names),
            "shapes": basis["count"],
            "total_variance": basis["total_variance"],
            **measured,
            **name_arrays(made.model.landmark_names),
        },
    )
    _write_origin(plan)
    share = np.cumsum(values) / (total or 1.0)
    lines = ["modes,eigenvalue,compactness,variance_share"]
    for m, value in enumerate(values):
        lines.append(f"{m + 1},{value:.17g},{np.cumsum(values)[m]:.10g},{share[m]:.10g}")
    store.write_text(MODEL / "model.csv", "\n".join(lines) + "\n")
    figures = {"compactness": np.cumsum(values), "variance_share": share, **measured}
    return ShapeModel(
        basis["mean"], basis["modes"], values, scores, faces, names, total, figures, None, noise
    )


def _write_origin(plan: Mapping[str, Any]) -> None:
    """model/model.json; the digests of landmarks are those that the scores were made from."""
    said = store.origin(plan, [PLAN / "model.json", atlas.ATLAS, spatial.BASIS])
    for block in merging.blocks_of(0):
        said["inputs"].update(store.read_json(spatial.SCORES / f"{block}.json")["inputs"])
    store.write_json(MODEL / "model.json", {**said, "exclude": plan["exclude"]})


def _measures(plan: Mapping[str, Any], faces: np.ndarray) -> Dict[str, np.ndarray]:
    """model/measures.csv: generalisation (a subject left out) and specificity of the frames of up
    to SAMPLE subjects, evenly spread, as the package's model has them; none of two subjects."""
    subjects = [
        (chunk, record)
        for chunks in merging.blocks_of(0).values()
        for chunk in chunks
        for record in merging.used(chunk, plan)
    ]
    count = min(len(subjects), SAMPLE)
    picked = [subjects[i * len(subjects) // count] for i in range(count)]
    figures: Dict[str, np.ndarray] = {name: np.zeros(0) for name in MEASURED}
    if count > 2:
        points = np.stack(
            [
                np.load(LANDMARKS / f"{chunk}.npy", mmap_mode="r")[record["row"] + record["root"]]
                for chunk, record in picked
            ]
        )
        with attention.silenced():
            found = filters.shape_model(
                points.reshape(count, -1, 3).astype(float),
                faces,
                [record["subject"] for _, record in picked],
                alignment=plan["parameters"]["alignment"],
            ).figures
        figures = {name: np.asarray(found[name], float) for name in MEASURED}
    lines = [",".join(["modes", *MEASURED])]
    for m, row in enumerate(zip(*figures.values())):
        lines.append(",".join([str(m + 1), *(f"{value:.6g}" for value in row)]))
    store.write_text(MODEL / "measures.csv", "\n".join(lines) + "\n")
    return {name: values for name, values in figures.items() if len(values)}
