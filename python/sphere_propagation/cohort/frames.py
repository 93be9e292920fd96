# SPDX-License-Identifier: GPL-3.0-only
"""The surfaces of subjects on disk, and which of a subject's phases is its frame in the atlas."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Dict, List, Mapping, Optional, Sequence, Union

import numpy as np

from .. import filters
from ..surface import Surface, largest
from . import store
from .study import LARGEST
from .worker import Failed

SURFACES = Path("surfaces")


def arrays_of(name: str, surfaces: Sequence[Surface]) -> Dict[str, np.ndarray]:
    """What a subject's surfaces are in an archive; float32, which files of meshes have, too."""
    found = {}
    for phase, surface in enumerate(surfaces):
        found[f"{name}/{phase}/vertices"] = surface.vertices.astype(np.float32)
        found[f"{name}/{phase}/faces"] = surface.faces
    return found


def read(archive: Mapping[str, np.ndarray], record: Mapping[str, Any]) -> List[Surface]:
    """A subject's surfaces; record: that of the import."""
    return [_surface(archive, record, phase) for phase in range(record["phases"])]


def read_frame(archive: Mapping[str, np.ndarray], record: Mapping[str, Any], phase: int) -> Surface:
    return _surface(archive, record, phase)


def _surface(archive, record, phase: int) -> Surface:
    name = record["subject"]
    called = record["names"][phase] if record["phases"] > 1 else name
    return Surface(archive[f"{name}/{phase}/vertices"], archive[f"{name}/{phase}/faces"], called)


def root_of(surfaces: Sequence[Surface], root_phase: Union[str, int]) -> int:
    return largest(surfaces) if root_phase == LARGEST else int(root_phase)


def no_such_phase(chosen: int, phases: int) -> str:
    has = f"the phases 0 to {phases - 1}" if phases > 1 else "the phase 0 alone"
    return f"root_phase is {chosen}, and it has {has}."


def require_sphere(surface: Surface) -> None:
    """Failed, in the filters' own words, where it is not a closed surface of genus 0."""
    if _is_sphere(surface):
        return
    try:
        filters.parameterise_root(surface, threads=1)
    except Exception as error:
        raise Failed(str(error)) from error


def _is_sphere(surface: Surface) -> bool:
    """Whether every edge has two faces that agree, in one part that looks outward, and Euler's
    number is 2."""
    faces, count = surface.faces.astype(np.int64), len(surface.vertices)
    if not np.isfinite(surface.vertices).all() or len(faces) != 2 * count - 4:
        return False
    if len(faces) and (faces.min() < 0 or faces.max() >= count or surface.volume <= 0):
        return False
    edges = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
    codes, back = edges[:, 0] * count + edges[:, 1], edges[:, 1] * count + edges[:, 0]
    if len(np.unique(codes)) != len(codes) or not np.array_equal(np.sort(codes), np.sort(back)):
        return False
    return _is_connected(edges, count)


def _is_connected(edges: np.ndarray, count: int) -> bool:
    """By the smallest number that reaches each vertex."""
    label = np.arange(count)
    while True:
        least = label.copy()
        np.minimum.at(least, edges[:, 0], label[edges[:, 1]])
        least = least[least]
        if np.array_equal(least, label):
            return bool((label == 0).all())
        label = least


def import_records(chunk: str, folder: Path = Path(".")) -> List[Dict[str, Any]]:
    return store.read_json(folder / SURFACES / f"{chunk}.json")["subjects"]


def record_of(records: Sequence[Dict[str, Any]], name: str) -> Optional[Dict[str, Any]]:
    return next((record for record in records if record["subject"] == name), None)
