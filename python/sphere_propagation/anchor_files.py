# SPDX-License-Identifier: GPL-3.0-only
"""Folders of files with anchors: which surface each belongs to, and what is missing. The files
themselves are read by the filters (vcg_ext/anchors/anchor_file.h)."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Iterable, List, Optional, Sequence

from .attention import warn
from .errors import FileError, SpherePropagationWarning
from .surface import count_others

# Of a folder the first that is there, as anchorFilesIn has them.
ENDINGS = ("_picked_points.pp", ".mrk.json", ".csv", ".fcsv", ".pp", ".json", ".tsv", ".txt")
ENDINGS += (".pts", ".xyz", ".particles")
BESIDE = ("_picked_points.pp", ".mrk.json", ".fcsv", ".pp")  # a mesh, what can be nothing else
NAMED_AT_MOST = 10


def file_in(folder, name: str) -> Optional[Path]:
    """The file of a folder that holds the anchors of what is called so; None where there is
    none."""
    for stem in dict.fromkeys((name, Path(name).stem)):
        for ending in ENDINGS:
            path = Path(folder) / f"{stem}{ending}"
            if path.is_file():
                return path
    return None


def looked_for(folder, name: str) -> str:
    return f"{Path(folder) / name}{ENDINGS[0]}, {', '.join(ENDINGS[1:])}"


def require_readable(folder) -> List[Path]:
    """What lies in a folder; FileError where that cannot be told."""
    try:
        return sorted(Path(folder).iterdir())
    except OSError as error:
        raise FileError(
            f"The folder of anchors {folder} cannot be read: {error.strerror or error}."
        ) from error


def require_points(files: Iterable[Optional[Path]]) -> None:
    """FileError that names the first file which has no point, not even one without a place."""
    for path in files:
        if path is None:
            continue
        try:
            text = path.read_text(encoding="utf-8", errors="replace")
        except OSError:
            continue  # the filter says why
        if not _has_points(path.name.lower(), text):
            raise FileError(
                f"{path} holds no anchor: write it again, or take it away where there are none."
            )


def _has_points(name: str, text: str) -> bool:
    if name.endswith((".json", ".pp")):
        return bool(text.strip())  # what has no points is no file of anchors for the filter
    rows = [
        line
        for line in text.lstrip("\ufeff").splitlines()
        if line.strip() and not line.lstrip().startswith("#")
    ]
    columns = set(re.split(r'[,;\s"]+', rows[0].strip().lower())) if rows else set()
    return len(rows) > int({"x", "y", "z"} <= columns)


def warn_of_folder(folder, names: Sequence[str]) -> None:
    """Warns of surfaces that the folder has no file for, and of files that belong to none of them;
    where each surface has one that is a note, since folders may serve many runs."""
    there = require_readable(folder)
    without = [name for name in names if file_in(folder, name) is None]
    if without:
        warn(
            SpherePropagationWarning(
                f"The folder of anchors {folder} has no file for {listed(without)}: "
                f"{'it is' if len(without) == 1 else 'they are'} taken without anchors.",
                layers=without,
                message="withoutAnchorFile",
            )
        )
    stems = {stem for name in names for stem in (name, Path(name).stem)}
    others = [
        path.name
        for path in there
        if path.is_file()
        and not path.name.startswith(".")
        and any(path.name.lower().endswith(ending) for ending in ENDINGS)
        and not any(
            path.name.endswith(ending) and path.name[: -len(ending)] in stems for ending in ENDINGS
        )
    ]
    if others:
        warn(
            SpherePropagationWarning(
                f"The folder of anchors {folder} has files that belong to no surface, as they are "
                f"called otherwise: {listed(others)}.",
                kind="Warning" if without else "Note",
                message="anchorFileOfNone",
            )
        )


def beside(paths: Sequence[Path], stems: Sequence[str]) -> List[Path]:
    """Files of anchors that lie beside meshes."""
    return [
        file
        for path, stem in zip(paths, stems)
        for file in [path.with_name(stem + ending) for ending in BESIDE]
        if file.is_file()
    ]


def listed(names: Sequence[str]) -> str:
    """At most so many of them."""
    more = len(names) - NAMED_AT_MOST
    return ", ".join(names[:NAMED_AT_MOST]) + (f" and {count_others(more)}" if more > 0 else "")
