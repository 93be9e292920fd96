# SPDX-License-Identifier: GPL-3.0-only
"""Steps `scatter` and `merge`: from landmarks to count, mean and scatter, a block of chunks at a
time, and these into one, level by level, always in the same order.

Every shape is laid on the atlas's mean as one step of the package's Procrustes analysis lays it on
the mean (vcg_ext/model/procrustes.h): generalised analysis would need all shapes again and again.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any, Dict, Iterator, List, Mapping, Tuple

import numpy as np

from . import atlas, likeness, moments, store
from .landmarks import LANDMARKS
from .plan import PLAN

MOMENTS = Path("moments")
AT_ONCE = 500  # shapes that are held


def aligned(shapes: np.ndarray, reference: np.ndarray, alignment: str) -> np.ndarray:
    """shapes: (n, landmarks, 3); each moved to where it is closest to the reference in the sense of
    least squares, by rotation, translation and, for Similarity, scale."""
    shapes = np.asarray(shapes, float)
    if alignment == "None":
        return shapes
    centre = reference.mean(0)
    goal = reference - centre
    here = shapes - shapes.mean(1, keepdims=True)
    left, singular, right = np.linalg.svd(np.einsum("nji,jk->nik", here, goal))
    sign = np.ones((len(shapes), 3))
    sign[:, 2] = np.sign(np.linalg.det(left @ right))
    turn = (left * sign[:, None]) @ right
    moved = here @ turn
    if alignment == "Similarity":
        moved *= ((singular * sign).sum(1) / (here**2).sum((1, 2)))[:, None, None]
    return moved + centre


def blocks_of(level: int) -> Dict[str, List[str]]:
    return store.read_json(PLAN / "chunks.json")["levels"][level]


def used(chunk: str, plan: Mapping[str, Any]) -> List[Dict[str, Any]]:
    """The records of a chunk's subjects that are in the model."""
    excluded = set(plan["exclude"])
    return [
        one
        for one in store.read_json(LANDMARKS / f"{chunk}.json")["subjects"]
        if not one["failed"]
        and one["subject"] not in excluded
        and not likeness.left_out(one, plan["parameters"])
    ]


def aligned_subjects(
    chunk: str, plan: Mapping[str, Any], reference: np.ndarray
) -> Iterator[Tuple[Dict[str, Any], np.ndarray]]:
    """Record and aligned shapes (phases, 3 x landmarks) of those in the model, one at a time."""
    stored = np.load(LANDMARKS / f"{chunk}.npy", mmap_mode="r")
    for record in used(chunk, plan):
        shapes = stored[record["row"] : record["row"] + record["phases"]]
        moved = aligned(
            shapes.reshape(record["phases"], -1, 3), reference, plan["parameters"]["alignment"]
        )
        yield record, moved.reshape(record["phases"], -1)


def run_scatter(block: str) -> int:
    """Writes moments/0/BLOCK.npz; returns how many shapes there are."""
    plan = store.read_json(PLAN / "model.json")
    reference = atlas.read().reference
    whole = moments.Moments.of(np.zeros((0, reference.size)))
    held: List[np.ndarray] = []

    def add() -> None:
        nonlocal whole
        if held:
            whole = whole.plus(moments.Moments.of(np.concatenate(held)))
            held.clear()

    for chunk in blocks_of(0)[block]:
        for _, shapes in aligned_subjects(chunk, plan, reference):
            held.append(shapes)
            if sum(map(len, held)) >= AT_ONCE:
                add()
    add()
    inputs = [PLAN / "model.json", atlas.ATLAS]
    inputs += [LANDMARKS / f"{chunk}.npy" for chunk in blocks_of(0)[block]]
    said = store.as_array({**store.origin(plan, inputs), "step": "scatter"})
    moments.write(MOMENTS / "0" / f"{block}.npz", whole, said=said)
    return whole.count


def run_merge(level: int, place: str) -> int:
    """Writes moments/LEVEL/PLACE.npz; returns how many shapes there are."""
    below = [MOMENTS / str(level - 1) / f"{one}.npz" for one in blocks_of(level)[place]]
    whole = moments.merged(moments.read(path) for path in below)
    plan = store.read_json(PLAN / "model.json")
    said = store.as_array({**store.origin(plan, below), "step": "merge"})
    moments.write(MOMENTS / str(level) / f"{place}.npz", whole, said=said)
    return whole.count
