# SPDX-License-Identifier: GPL-3.0-only
"""Step `cycle`, the 4D model: a subject is its scores over one cycle, whose landmarks are
end-diastole (largest volume) and end-systole (smallest); a second principal component analysis over
subjects."""

from __future__ import annotations

from pathlib import Path
from typing import List, Optional

import numpy as np

from . import moments, store
from .plan import PLAN

CYCLE = Path("cycle")
MODES = 50


def resampled(
    scores: np.ndarray, volume: np.ndarray, count: int, systole: float, cyclic: bool
) -> Optional[np.ndarray]:
    """(count, modes) from (phases, modes), between phases linearly. Cyclic: from end-diastole on,
    end-systole at the share `systole` of the cycle; else from the first phase to the last. None
    where there are too few phases."""
    phases = len(scores)
    if phases < (3 if cyclic else 2):
        return None
    if not cyclic:
        at = np.linspace(0, phases - 1, count)
        knots, values = np.arange(phases), scores
    else:
        first = int(np.argmax(volume))
        order = (first + np.arange(phases + 1)) % phases
        values = scores[order]
        end = int(np.argmin(volume[order[:-1]]))
        if end == 0:  # all volumes are the same
            return None
        steps = np.arange(phases + 1)
        knots = np.where(
            steps <= end,
            steps / end * systole,
            systole + (steps - end) / (phases - end) * (1 - systole),
        )
        at = np.arange(count) / count
    return np.stack([np.interp(at, knots, column) for column in values.T], 1).reshape(count, -1)


def run() -> int:
    """Writes cycle/model.npz and scores.csv; returns how many subjects have a cycle."""
    plan = store.read_json(PLAN / "model.json")
    count = plan["parameters"]["cycle_phases"]
    blocks = list(store.read_json(PLAN / "chunks.json")["levels"][0])
    whole: Optional[moments.Moments] = None
    names: List[str] = []
    for block in blocks:
        rows = np.load(f"scores/{block}_cycle.npy", mmap_mode="r")
        said = store.read_json(Path(f"scores/{block}.json"))["subjects"]
        names += [one["subject"] for one in said if one["cycle"] is not None]
        for start in range(0, len(rows), moments.RANK):
            part = moments.Moments.of(rows[start : start + moments.RANK])
            whole = part if whole is None else whole.plus(part)
    width = np.load(f"scores/{blocks[0]}_cycle.npy", mmap_mode="r").shape[1]
    if whole is None:
        whole = moments.Moments.of(np.zeros((0, width)))
    values, directions, total = whole.principal(MODES)
    store.write_arrays(
        CYCLE / "model.npz",
        {
            "count": np.int64(whole.count),
            "mean": whole.mean.reshape(count, -1),
            "modes": directions.reshape(len(values), count, width // count),
            "eigenvalues": values,
            "total_variance": np.float64(total),
        },
    )
    inputs = [PLAN / "model.json", *(Path(f"scores/{block}_cycle.npy") for block in blocks)]
    said = {**store.origin(plan, inputs), "step": "cycle", "subjects": whole.count}
    store.write_json(CYCLE / "model.json", said)
    lines = [",".join(["subject", *(f"mode_{m + 1}" for m in range(len(values)))])]
    place = 0
    for block in blocks:
        rows = np.load(f"scores/{block}_cycle.npy", mmap_mode="r")
        for row in rows:
            scores = directions @ (np.asarray(row, float) - whole.mean)
            lines.append(",".join([names[place], *(f"{score:.9g}" for score in scores)]))
            place += 1
    store.write_text(CYCLE / "scores.csv", "\n".join(lines) + "\n")
    return whole.count
