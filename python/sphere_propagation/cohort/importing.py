# SPDX-License-Identifier: GPL-3.0-only
"""Step `import`: the files of a chunk's subjects to closed surfaces, one per phase."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any, Dict, List, Mapping, Tuple

from .. import attention, files, filters
from ..surface import Surface
from . import frames, store, worker
from .plan import PLAN
from .wording import for_files
from .worker import Failed


def run(chunk: str) -> int:
    """Writes surfaces/CHUNK.npz and .json; returns how many phases there are."""
    path = PLAN / "import" / f"{chunk}.json"
    plan = store.read_json(path)
    base = Path(store.read_json(PLAN / "study.json")["input"])
    records: List[Dict[str, Any]] = []

    def work(entry: Mapping[str, Any]):
        return import_subject(base, entry, plan["parameters"])

    with store.archive(frames.SURFACES / f"{chunk}.npz") as archive:
        for place, result, reason in worker.each(work, plan["subjects"]):
            entry = plan["subjects"][place]
            if result is None:
                records.append(_failed(base, entry, reason))
                continue
            record, surfaces = result
            for name, array in frames.arrays_of(record["subject"], surfaces).items():
                archive.add(name, array)
            records.append(record)
    store.write_json(
        frames.SURFACES / f"{chunk}.json",
        {
            **store.origin(plan, [path]),
            "subjects": records,
        },
    )
    return sum(record.get("phases", 0) for record in records)


def _said(base: Path, entry: Mapping[str, Any]) -> Dict[str, Any]:
    def sums(file: Mapping[str, Any]) -> Dict[str, Any]:
        path = base / file["file"]
        return {"file": file["file"], "sha256": store.digest(path) if path.is_file() else ""}

    return {
        "subject": entry["subject"],
        "groups": entry["groups"],
        "files": [sums(file) for file in entry["files"]],
        "anchors": sums(entry["anchors"]) if entry["anchors"] else None,
    }


def _failed(base: Path, entry: Mapping[str, Any], reason: str) -> Dict[str, Any]:
    said = _said(base, entry)
    return {**said, "failed": {"step": "import", "reason": reason.replace(f"{base}/", "")}}


def import_subject(
    base: Path, entry: Mapping[str, Any], parameters: Mapping[str, Any]
) -> Tuple[Dict[str, Any], List[Surface]]:
    """Its record and its surfaces; Failed or an error of the package's where it cannot be done."""
    if entry["failed"]:
        raise Failed(entry["failed"])
    paths = [base / file["file"] for file in entry["files"]]
    for path in paths + ([base / entry["anchors"]["file"]] if entry["anchors"] else []):
        if not path.is_file():
            raise Failed(f"There is no file {path}.")
    with attention.collected() as said:
        surfaces = _surfaces(paths, parameters)
        files.warn_of_frames(surfaces)
    for surface in surfaces:
        frames.require_sphere(
            replace(surface, name=surface.name if len(surfaces) > 1 else entry["subject"])
        )
    record = {
        **_said(base, entry),
        "failed": None,
        "phases": len(surfaces),
        "names": [surface.name for surface in surfaces],
        "vertices": [len(surface.vertices) for surface in surfaces],
        "volume": [store.figure(abs(surface.volume)) for surface in surfaces],
        "warnings": words_of(said),
    }
    return record, surfaces


def words_of(said) -> List[Dict[str, str]]:
    return [
        {"message": warning.message, "layer": warning.layer, "text": for_files(str(warning))}
        for warning in said
    ]


def _surfaces(paths: List[Path], parameters: Mapping[str, Any]) -> List[Surface]:
    volumes = [path for path in paths if files.is_label_volume(path)]
    if volumes and len(volumes) < len(paths):
        raise Failed(
            f"There are label volumes ({volumes[0].name}) and meshes among its files: the study's "
            "key files says which are to be taken."
        )
    if not volumes:
        names = files.names_of(paths)
        return [replace(files.read_mesh(path), name=name) for path, name in zip(paths, names)]
    given = volumes[0] if len(volumes) == 1 else volumes
    return filters.read_label_volume(given, **parameters).surfaces
