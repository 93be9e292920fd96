# SPDX-License-Identifier: GPL-3.0-only
"""Step `atlas`: one frame of each of up to 200 subjects, mapped along a similarity tree, together
if asked for, and their shape model, which is fitted to everybody's frame."""

from __future__ import annotations

import contextlib
import os
import re
import tempfile
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Dict, List, Mapping, Optional, Sequence, Tuple

import numpy as np

from .. import attention, filters
from ..correspondence import correspond
from ..errors import FilterError, SpherePropagationError, SpherePropagationWarning
from ..fitting import ANCHOR_FILES
from ..model import ShapeModel
from ..sphere_map import SphereMap
from ..surface import Surface
from . import frames, likeness, store
from .importing import words_of
from .plan import PLAN
from .worker import Failed, reason

ATLAS = Path("atlas.npz")


@dataclass(frozen=True, eq=False)
class Atlas:
    """model: of the frames' landmarks, without modes where there is one frame; root: the frame
    whose map was handed on; faces: of the landmarks. The model's landmarks that anchors became
    have their names. references: of a few frames, what subjects are compared with (likeness), with
    the first one's map; sided: whether sides can be told; odd: frames that were left out as they
    are not like the others."""

    model: ShapeModel
    root: Surface
    root_map: SphereMap
    faces: np.ndarray
    references: np.ndarray
    reference_map: Optional[SphereMap]
    sided: bool = True
    odd: Mapping[str, List[likeness.Oddity]] = field(default_factory=dict)

    def known(self) -> List[Surface]:
        """The references as surfaces."""
        return likeness.as_surfaces(self.references, self.faces)

    @property
    def reference(self) -> np.ndarray:
        """What every shape is laid on, (landmarks, 3)."""
        return self.model.mean


def run() -> int:
    """Writes atlas.npz and atlas.json; returns how many frames there are."""
    plan = store.read_json(PLAN / "atlas.json")
    parameters = plan["parameters"]
    left_out: Dict[str, str] = {}
    found: List[Surface] = []
    anchors: Dict[str, str] = {}
    for chunk in sorted({chunk for _, chunk in plan["subjects"]}):
        records = frames.import_records(chunk)
        with np.load(frames.SURFACES / f"{chunk}.npz") as archive:
            for name in [name for name, its in plan["subjects"] if its == chunk]:
                record = frames.record_of(records, name)
                if record is None or record["failed"]:
                    why = record["failed"]["reason"] if record else "It was not imported."
                    left_out[name] = why
                    continue
                try:
                    found.append(_frame(archive, record, parameters["root_phase"]))
                except Failed as error:
                    left_out[name] = str(error)
                    continue
                if record["anchors"]:
                    anchors[name] = record["anchors"]["file"]
    if not found:
        reasons = "".join(f"\n  {name}: {why}" for name, why in list(left_out.items())[:10])
        raise Failed(f"No subject can be in the atlas.{reasons}")
    made, said = _made(found, parameters, left_out, anchors)
    _write(made, found, plan, left_out, said)
    return len(found)


def _frame(archive, record: Mapping[str, Any], root_phase) -> Surface:
    phases = record["phases"]
    if root_phase == "largest":
        phase = int(np.argmax(record["volume"]))
    elif root_phase < phases:
        phase = root_phase
    else:
        raise Failed(frames.no_such_phase(root_phase, phases))
    surface = frames.read_frame(archive, record, phase)
    return Surface(surface.vertices, surface.faces, record["subject"])


def _made(
    found: List[Surface],
    parameters: Mapping[str, Any],
    left_out: Dict[str, str],
    anchors: Mapping[str, str],
) -> Tuple[Atlas, List[SpherePropagationWarning]]:
    """Leaves out, and takes from `found`, what the filters say no to by name, and what is not like
    the others: in another unit, or mirrored."""
    odd: Dict[str, List[likeness.Oddity]] = {}
    while True:
        try:
            with attention.collected() as said:
                made = _of(found, parameters, anchors)
        except FilterError as error:
            named = next((one for one in found if f'"{one.name}"' in str(error)), None)
            if named is None or len(found) == 1:
                raise
            left_out[named.name] = reason(error)
            found.remove(named)
            continue
        unlike = _unlike(found, said)
        if not unlike or 2 * len(unlike) >= len(found):  # the half accuses nobody
            odd.update(likeness.asked_of(said, len(found)))
            return replace(made, sided=likeness.has_sides(said, len(found)), odd=odd), said
        odd.update(unlike)
        for name, its in unlike.items():
            left_out[name] = "; ".join(one["text"] for one in its)
        found[:] = [one for one in found if one.name not in unlike]


def _unlike(
    found: Sequence[Surface], said: Sequence[SpherePropagationWarning]
) -> Dict[str, List[likeness.Oddity]]:
    """Frame -> in what it is not like the others, so that the atlas is made without it."""
    return {
        name: its
        for name, its in likeness.found_in(said, len(found)).items()
        if any(one["kind"] in likeness.KINDS for one in its)
    }


def _of(
    surfaces: Sequence[Surface], parameters: Mapping[str, Any], anchors: Mapping[str, str]
) -> Atlas:
    frequency = parameters["frequency"]
    if len(surfaces) == 1:
        root = surfaces[0]
        root_map = filters.parameterise_root(
            root, initial_map=parameters["initial_map"], area_weight=parameters["area_weight"]
        )
        made = filters.remesh([root], [root_map], frequency=frequency)
        model = ShapeModel(
            made.points[0],
            np.zeros((0, made.points.shape[1], 3)),
            np.zeros(0),
            np.zeros((1, 0)),
            np.asarray(made.faces, np.int32),
            [root.name],
            0.0,
            {},
        )
        return Atlas(model, root, root_map, model.faces, made.points[:1], None)
    marked = [k for k, one in enumerate(surfaces) if one.name in anchors]
    root = max(marked, key=lambda k: abs(surfaces[k].volume)) if marked else None
    with anchor_folder({surfaces[k].name: anchors[surfaces[k].name] for k in marked}) as folder:
        result = correspond(
            surfaces,
            root=root,
            order="Similarity tree",
            frequency=frequency,
            initial_map=parameters["initial_map"],
            area_weight=parameters["area_weight"],
            groupwise=parameters["groupwise"],
            anchors=folder,
            anchor_sd=parameters["anchor_sd"],
            anchor_snap=bool(marked),
        )
    alignment = parameters["alignment"]
    model = filters.shape_model(
        result.landmarks,
        result.landmark_faces,
        [surface.name for surface in surfaces],
        alignment="Rigid" if alignment == "None" else alignment,
        specificity_samples=1,
        landmark_names=_names(result.anchors),
    )
    root = result.surfaces[result.root]
    faces = np.asarray(model.faces, np.int32)
    compared = likeness.references(result.surfaces, result.landmarks, result.root)
    first = likeness.as_surfaces(compared[:1], faces)[0]
    its_map = filters.parameterise_root(first)
    return Atlas(model, root, result.maps[result.root], faces, compared, its_map)


def _names(found: Optional[filters.AnchorFit]) -> Dict[str, int]:
    if found is None or found.landmarks is None:
        return {}
    return {name: int(landmark) for name, landmark in zip(found.names, found.landmarks)}


@contextlib.contextmanager
def anchor_folder(of: Mapping[str, str]):
    """A folder where the files of anchors are called as the surfaces; None where there is none.
    of: surface -> file."""
    if not of:
        yield None
        return
    base = Path(store.read_json(PLAN / "study.json")["input"])
    with tempfile.TemporaryDirectory() as folder:
        theirs = {}
        for name, file in of.items():
            path = base / file
            ending = next((one for one in ANCHOR_FILES if path.name.endswith(one)), path.suffix)
            (Path(folder) / f"{name}{ending}").symlink_to(path.resolve())
            theirs[f"{name}{ending}"] = file
        with _naming(folder, theirs):
            yield folder


@contextlib.contextmanager
def _naming(folder: str, of: Mapping[str, str]):
    """Errors name the user's file, not the one here. of: name here -> file."""
    try:
        yield
    except SpherePropagationError as error:
        text = re.sub(
            rf"(?:{re.escape(folder)}|{re.escape(os.path.realpath(folder))})/([\w.+-]+)",
            lambda found: of.get(found[1], found[1]),
            str(error),
        )
        error.args = (text, *error.args[1:])
        raise


def _write(
    made: Atlas,
    used: Sequence[Surface],
    plan: Mapping[str, Any],
    left_out: Mapping[str, str],
    said,
) -> None:
    model = made.model
    store.write_arrays(
        ATLAS,
        {
            "mean": np.asarray(model.mean, float),
            "modes": np.asarray(model.modes, float),
            "eigenvalues": np.asarray(model.eigenvalues, float),
            "scores": np.asarray(model.scores, float),
            "faces": np.asarray(model.faces, np.int32),
            "noise_variance": np.float64(model.noise_variance),
            "root_vertices": made.root.vertices,
            "root_faces": made.root.faces,
            "root_map": made.root_map.positions,
            "references": np.asarray(made.references, float),
            **({"reference_map": made.reference_map.positions} if made.reference_map else {}),
        },
    )
    chunks = sorted({chunk for _, chunk in plan["subjects"]})
    inputs = [PLAN / "atlas.json", *(frames.SURFACES / f"{chunk}.json" for chunk in chunks)]
    store.write_json(
        ATLAS.with_suffix(".json"),
        {
            **store.origin(plan, inputs),
            "root": made.root.name,
            "landmark_names": {name: int(j) for name, j in model.landmark_names.items()},
            "subjects": [surface.name for surface in used],
            "left_out": dict(left_out),
            "odd": dict(made.odd),
            "sided": made.sided,
            "warnings": words_of(said),
        },
    )


def read() -> Atlas:
    found = store.read_arrays(ATLAS)
    said = store.read_json(ATLAS.with_suffix(".json"))
    model = ShapeModel(
        found["mean"],
        found["modes"],
        found["eigenvalues"],
        found["scores"],
        found["faces"],
        said["subjects"],
        float(found["eigenvalues"].sum()),
        {},
        None,
        float(found["noise_variance"]),
        said["landmark_names"],
    )
    root = Surface(found["root_vertices"], found["root_faces"], said["root"])
    its_map = SphereMap(found["reference_map"]) if "reference_map" in found else None
    return Atlas(
        model,
        root,
        SphereMap(found["root_map"]),
        found["faces"],
        found["references"],
        its_map,
        said["sided"],
        said["odd"],
    )
