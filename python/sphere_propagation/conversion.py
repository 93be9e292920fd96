# SPDX-License-Identifier: GPL-3.0-only
"""Surface files of this field as files that MeshLab opens."""

from __future__ import annotations

from pathlib import Path
from typing import Callable, Dict, List, NamedTuple, Optional, Sequence

import numpy as np

from . import files, readers
from .attention import warn
from .errors import FileError, InputError
from .results import ResultFolder, require_apart
from .surface import Surface, count_others


class Job(NamedTuple):
    source: Path
    target: Path


class Plan(NamedTuple):
    jobs: List[Job]
    refused: Dict[Path, FileError]  # why these are left out


def plan(paths: Sequence, folder: Optional[str], format: str, overwrite: bool) -> Plan:
    """What is to be written, before any of it is: FileError where that would overwrite something.
    Without a folder each goes beside its source. Files that would become the same one are left
    out, all of them: which is meant is not known."""
    targets: Dict[Path, Path] = {}
    for source in files.files_of_any_name(*paths):
        home = source.parent if folder is None else Path(folder)
        targets[source] = home / f"{files.stem_of(source)}.{format}"
    places = {source: target.resolve() for source, target in targets.items()}
    found, refused = [], {}
    for source, target in targets.items():
        same = [other for other in targets if places[other] == places[source]]
        if len(same) > 1:
            refused[source] = FileError(
                f"{' and '.join(map(str, same))} would become one file, {target}: rename them, or "
                "convert them one by one to other folders (-o)."
            )
            continue
        if target.exists() and target.samefile(source):
            raise FileError(f"{source} would be overwritten by itself: choose a folder (-o).")
        if target.exists() and not overwrite:
            raise FileError(
                f"{target} exists: choose a folder (-o), or let it be replaced (--overwrite)."
            )
        found.append(Job(source, target))
    require_apart(targets, *(job.target for job in found))
    if folder is not None:
        ResultFolder(folder).require_folder()
    return Plan(found, refused)


def convert(jobs: Sequence[Job], space: str, say: Callable[[str], None]) -> Dict[Path, str]:
    """Reads and writes one after the other; returns what is wrong with those that cannot be read.
    space: RAS or LPS, of files that do not say theirs; empty: RAS, with a warning."""
    failed: Dict[Path, str] = {}
    silent: List[Path] = []
    for source, target in jobs:
        try:
            surface, scalars = files.surface_in(source)
        except (FileError, InputError) as error:
            failed[source] = str(error)
            continue
        if not surface.space:
            silent.append(source)
            vertices = readers.turned(space, surface.vertices)
            surface = Surface(vertices, surface.faces, surface.name, "RAS")
        target.parent.mkdir(parents=True, exist_ok=True)
        WRITERS[target.suffix[1:]](target, surface, scalars)
        say(
            f"{source} -> {target}: {len(surface.vertices)} vertices, {len(surface.faces)} "
            f"triangles, {readers.state_of(surface)}"
        )
    if silent and not space:
        others = f" (and {count_others(len(silent) - 1)})" if len(silent) > 1 else ""
        warn(
            f"{silent[0]}{others} does not say whether it is in RAS or LPS, and is taken to be in "
            "RAS: --coordinates lps for the other."
        )
    return failed


def _write_ply(path: Path, surface: Surface, scalars: Dict[str, np.ndarray]) -> None:
    files.write_ply(path, surface.vertices, surface.faces, space=surface.space, scalars=scalars)


def _write_stl(path: Path, surface: Surface, scalars: Dict[str, np.ndarray]) -> None:
    corners = surface.vertices[surface.faces]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    lengths = np.linalg.norm(normals, axis=1, keepdims=True)
    facets = np.zeros(
        len(corners), [("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("_", "<u2")]
    )
    facets["normal"] = np.divide(normals, lengths, out=np.zeros_like(normals), where=lengths > 0)
    facets["corners"] = corners
    header = f"SPACE={surface.space}".encode().ljust(80)
    path.write_bytes(header + np.uint32(len(facets)).tobytes() + facets.tobytes())


def _write_obj(path: Path, surface: Surface, scalars: Dict[str, np.ndarray]) -> None:
    with open(path, "w", encoding="ascii") as file:
        file.write(f"# SPACE={surface.space}\n")
        np.savetxt(file, surface.vertices, "v %.9g %.9g %.9g")
        np.savetxt(file, surface.faces + 1, "f %d %d %d")


WRITERS = {"ply": _write_ply, "stl": _write_stl, "obj": _write_obj}
