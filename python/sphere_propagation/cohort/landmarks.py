# SPDX-License-Identifier: GPL-3.0-only
"""Step `landmarks`: the atlas fitted to each subject's frame, which gives it a certified map; that
propagated through its phases; landmarks of all of them."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any, Dict, List, Mapping, Sequence, Tuple

import numpy as np

from .. import attention, filters
from ..errors import SpherePropagationError
from ..fitting import fit
from ..sphere_map import SphereMap
from ..surface import Surface
from . import atlas, frames, likeness, store, worker
from .importing import words_of
from .plan import PLAN
from .worker import Failed

LANDMARKS = Path("landmarks")
FIT_FIGURES = (
    "surface_distance",
    "noise",
    "deviation",
    "percentile",
    "unseen",
    "unexplained",
    "residual_mean",
    "residual_p95",
)
COUNTS = ("flipped_faces", "repaired_faces", "route")
PHASE_FIGURES = (
    "residual_mean",
    "residual_p95",
    *COUNTS,
    "area_ratio_sd",
    "area_log_mean",
    "angle_error_mean",
)


def run(chunk: str) -> int:
    """Writes landmarks/CHUNK.npy and .json; returns how many phases there are."""
    plan = store.read_json(PLAN / "landmarks.json")
    imported = frames.import_records(chunk)
    made = atlas.read()
    records: List[Dict[str, Any]] = []
    width = 3 * len(made.reference)
    with (
        np.load(frames.SURFACES / f"{chunk}.npz") as archive,
        store.rows(LANDMARKS / f"{chunk}.npy", width) as rows,
    ):
        work = partial(_work, archive, made, plan["parameters"])
        for place, result, reason in worker.each(work, imported):
            said = {key: imported[place][key] for key in ("subject", "groups", "files", "anchors")}
            if result is None:
                before = imported[place]["failed"]
                failed = before or {"step": "landmarks", "reason": reason}
                records.append({**said, "failed": failed})
                continue
            figures, points = result
            records.append({**said, "failed": None, "row": rows.count, **figures})
            rows.add(points.reshape(len(points), -1))
    inputs = [
        PLAN / "landmarks.json",
        frames.SURFACES / f"{chunk}.json",
        frames.SURFACES / f"{chunk}.npz",
        atlas.ATLAS,
    ]
    store.write_json(
        LANDMARKS / f"{chunk}.json",
        {
            **store.origin(plan, inputs),
            "shapes": sum(record.get("phases", 0) for record in records),
            "subjects": records,
        },
    )
    return sum(record.get("phases", 0) for record in records)


def _work(archive, made: atlas.Atlas, parameters: Mapping[str, Any], record: Mapping[str, Any]):
    if record["failed"]:
        raise Failed(record["failed"]["reason"])
    return subject_landmarks(
        frames.read(archive, record), record, made, parameters, record["anchors"]
    )


def subject_landmarks(
    surfaces: Sequence[Surface],
    record: Mapping[str, Any],
    made: atlas.Atlas,
    parameters: Mapping[str, Any],
    anchors=None,
) -> Tuple[Dict[str, Any], np.ndarray]:
    """Figures, and landmarks (phases, landmarks, 3) where the surfaces lie."""
    phases = len(surfaces)
    chosen = parameters["root_phase"]
    if chosen != "largest" and chosen >= phases:
        raise Failed(frames.no_such_phase(chosen, phases))
    root = frames.root_of(surfaces, chosen)
    frame = replace(surfaces[root], name=record["subject"])
    odd = likeness.judge(frame, made.known(), made.reference_map, made.sided)
    with attention.collected() as said:
        root_map, fitted = _map_of_frame(frame, made, parameters, anchors)
        maps, figures, more = [root_map], {}, {}
        if phases > 1:
            found = filters.propagate(
                surfaces,
                root_map,
                root_layer=root,
                order=parameters["order"],
                area_restoration=parameters["area_restoration"],
                threads=1,
            )
            maps, figures = found.maps, found.figures
            for name in ("branch_distance", "branch_angle"):
                value = getattr(found, name)
                if value is not None:
                    more[name] = store.figure(np.ravel(value)[0])
        made_here = filters.remesh(surfaces, maps, frequency=parameters["frequency"], threads=1)
    if not np.isfinite(made_here.points).all():
        raise Failed("Its landmarks are not finite numbers.")
    table = {}
    for name in PHASE_FIGURES:
        if name in figures:
            values = np.asarray(figures[name], float).copy()
        else:
            values = np.array([one.figures.get(name, 0.0) for one in maps])
        if name in fitted:
            values[root] = fitted[name]
        table[name] = [int(v) if name in COUNTS else store.figure(v) for v in values]
    for name in ("surface_distance_mean", "surface_distance_max"):
        table[name] = [store.figure(value) for value in made_here.figures[name]]
    kinds = {one["kind"] for one in odd}
    of_atlas = [one for one in made.odd.get(record["subject"], ()) if one["kind"] not in kinds]
    return {
        "phases": phases,
        "names": list(record["names"]),
        "root": int(root),
        "fit": fitted,
        "volume": [store.figure(abs(surface.volume)) for surface in surfaces],
        "vertices": [len(surface.vertices) for surface in surfaces],
        **table,
        **more,
        "odd": [*odd, *of_atlas, *likeness.of_phases(said)],
        "warnings": [*record["warnings"], *words_of(said)],
    }, made_here.points


def _map_of_frame(
    frame: Surface, made: atlas.Atlas, parameters: Mapping[str, Any], anchors
) -> Tuple[SphereMap, Dict[str, float]]:
    """By the model's fit; where that makes no map, and where the model has no modes, by propagation
    from the atlas's root."""
    why: List[str] = []
    if len(made.model.modes):
        try:
            with atlas.anchor_folder({frame.name: anchors["file"]} if anchors else {}) as folder:
                marks = next(Path(folder).iterdir()) if folder else None
                found = fit(
                    made.model,
                    frame,
                    anchors=marks if made.model.landmark_names else None,
                    anchor_sd=parameters["anchor_sd"],
                    threads=1,
                )
            if found.map is not None:
                figures = {key: store.figure(found.figures[key]) for key in FIT_FIGURES}
                figures["repaired_faces"] = float(found.figures["repaired_faces"])
                return found.map, figures
        except SpherePropagationError as error:
            why.append(str(error))
    try:
        found = filters.propagate(
            [Surface(made.root.vertices, made.root.faces, "the atlas"), frame],
            made.root_map,
            root_layer=0,
            order="Star",
            threads=1,
        )
    except SpherePropagationError as error:
        raise Failed(" ".join(dict.fromkeys([*why, str(error)]))) from error
    names = ("residual_mean", "residual_p95", "repaired_faces")
    return found.maps[1], {key: store.figure(found.figures[key][1]) for key in names}
