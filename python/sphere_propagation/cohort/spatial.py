# SPDX-License-Identifier: GPL-3.0-only
"""Steps `model` and `scores`: the modes of all shapes of all phases, and everybody's scores along
them."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Dict, List

import numpy as np

from . import atlas, merging, moments, store
from .cycles import resampled
from .plan import PLAN
from .worker import Failed

BASIS = Path("model/basis.npz")
SCORES = Path("scores")
SHARE = 0.95  # of the variance: modes that a deviation counts


def run_model() -> int:
    """Writes model/basis.npz; returns how many shapes it is of."""
    plan = store.read_json(PLAN / "model.json")
    levels = store.read_json(PLAN / "chunks.json")["levels"]
    top = merging.MOMENTS / str(len(levels) - 1) / f"{next(iter(levels[-1]))}.npz"
    whole = moments.read(top)
    if whole.count < 2:
        raise Failed(
            f"{whole.count} shape{'s' * (whole.count != 1)} cannot make a model: two or more are "
            "needed. landmarks/*.json say of each subject why it was left out."
        )
    values, directions, total = whole.principal(plan["parameters"]["modes"])
    landmarks = len(whole.mean) // 3
    store.write_arrays(
        BASIS,
        {
            "count": np.int64(whole.count),
            "mean": whole.mean.reshape(landmarks, 3),
            "modes": directions.reshape(-1, landmarks, 3),
            "eigenvalues": values,
            "total_variance": np.float64(total),
            "said": store.as_array(store.origin(plan, [PLAN / "model.json", top])),
            "lost_variance": np.float64(whole.lost / max(1, whole.count - 1)),
        },
    )
    return whole.count


def run_scores(block: str) -> int:
    """Writes scores/BLOCK.npy and .json, and BLOCK_cycle.npy, a row for each subject that has a
    cycle; returns how many shapes there are."""
    plan = store.read_json(PLAN / "model.json")
    parameters = plan["parameters"]
    basis = store.read_arrays(BASIS)
    reference = atlas.read().reference
    mean, values = basis["mean"].ravel(), basis["eigenvalues"]
    modes = basis["modes"].reshape(len(values), -1)
    counted = deviation_modes(values, float(basis["total_variance"]))
    records: List[Dict[str, Any]] = []
    with (
        store.rows(SCORES / f"{block}.npy", len(values), "<f8") as rows,
        store.rows(
            SCORES / f"{block}_cycle.npy", parameters["cycle_phases"] * len(values)
        ) as cycles,
    ):
        for chunk in merging.blocks_of(0)[block]:
            for record, shapes in merging.aligned_subjects(chunk, plan, reference):
                away = shapes - mean
                scores = away @ modes.T
                left = np.maximum((away**2).sum(1) - (scores**2).sum(1), 0)
                far = (scores[:, :counted] ** 2 / values[:counted]).mean(1) if counted else left * 0
                cycle = resampled(
                    scores,
                    np.array(record["volume"]),
                    parameters["cycle_phases"],
                    parameters["systole"],
                    parameters["order"] == "Cyclic time",
                )
                records.append(
                    {
                        "subject": record["subject"],
                        "chunk": chunk,
                        "row": rows.count,
                        "phases": record["phases"],
                        "names": record["names"],
                        "root": record["root"],
                        "cycle": None if cycle is None else cycles.count,
                        "deviation": [store.figure(x) for x in np.sqrt(far)],
                        "residual": [store.figure(x) for x in np.sqrt(left / len(reference))],
                    }
                )
                rows.add(scores)
                if cycle is not None:
                    cycles.add(cycle.reshape(1, -1))
        shapes_done = rows.count
    inputs = [PLAN / "model.json", BASIS]
    inputs += [merging.LANDMARKS / f"{chunk}.npy" for chunk in merging.blocks_of(0)[block]]
    store.write_json(
        SCORES / f"{block}.json",
        {
            **store.origin(plan, inputs),
            "step": "scores",
            "subjects": records,
        },
    )
    return shapes_done


def deviation_modes(values: np.ndarray, total: float) -> int:
    """How many modes hold SHARE of the variance."""
    if not len(values):
        return 0
    enough = np.flatnonzero(np.cumsum(values) >= SHARE * total)
    return int(enough[0]) + 1 if len(enough) else len(values)
