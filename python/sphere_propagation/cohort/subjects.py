# SPDX-License-Identifier: GPL-3.0-only
"""Who takes part: a BIDS-like tree, a folder per subject, one folder of files, or a table."""

from __future__ import annotations

import csv
import re
from dataclasses import dataclass, field
from pathlib import Path
from typing import Dict, List, Mapping, Sequence, Tuple

from .. import attention, files
from ..errors import FileError, InputError
from ..fitting import ANCHOR_FILES
from .study import Study

TABLES = (".csv", ".tsv")
PARTICIPANTS = "participants.tsv"  # of BIDS: columns beside participant_id are groups
SEGMENTATION = re.compile(r"_(dseg|mask|probseg)\.", re.IGNORECASE)
STUDY_OUTPUT = Path("plan/study.json")  # of one that lies in its input
NAME = re.compile(r"[^\w.+-]+")


@dataclass(frozen=True)
class Subject:
    """files: of its phases in order, relative to the study's input; groups: columns of a table;
    anchors: a file of them for the root phase, empty where there is none; failed: why it cannot
    take part, where that is known from the names alone."""

    name: str
    files: List[str] = field(default_factory=list)
    groups: Dict[str, str] = field(default_factory=dict)
    anchors: str = ""
    failed: str = ""


def find(where: Path, study: Study, home: Path) -> Tuple[Path, List[Subject]]:
    """The folder that files are relative to, and the subjects in natural order. home: what the
    study's own paths are relative to."""
    if not where.exists():
        raise InputError(f"There is no file or folder {where}.")
    if where.is_file():
        if where.suffix.lower() not in TABLES:
            raise InputError(
                f"{where} is a file: the input is a folder, or a table (.csv, .tsv) with the "
                "columns subject and file."
            )
        base, found = where.resolve().parent, _of_table(where)
    else:
        base, found = where.resolve(), _of_folder(where.resolve(), study)
    if not found:
        raise InputError(f"{where} holds no subject: no folder and no file that can be read.")
    found.sort(key=lambda subject: files._natural(subject.name))
    if study.anchors:
        folder = home / study.anchors
        if not folder.is_dir():
            raise InputError(f"anchors: {folder} is no folder.")
        found = [_with_anchors(subject, folder, base) for subject in found]
    return base, found


def chosen(subjects: Sequence[Subject], labels: Sequence[str]) -> List[Subject]:
    """Those with these names, with or without sub-, with all of their sessions; all where no name
    is given."""
    if not labels:
        return list(subjects)
    names = {subject.name for subject in subjects}
    wanted = set()
    for label in labels:
        match = {
            name
            for name in names
            for one in (label, f"sub-{label}")
            if name == one or name.startswith(f"{one}_ses-")
        }
        if not match:
            raise InputError(
                f"There is no subject {label!r} (--participant-label); there are "
                f"{', '.join(sorted(names)[:5])}{', …' if len(names) > 5 else ''}."
            )
        wanted |= match
    return [subject for subject in subjects if subject.name in wanted]


def _of_folder(folder: Path, study: Study) -> List[Subject]:
    below = [
        path
        for path in folder.iterdir()
        if path.is_dir()
        and not path.name.startswith((".", "_"))
        and path.name != "derivatives"
        and not (path / STUDY_OUTPUT).is_file()
    ]
    bids = [path for path in below if path.name.startswith("sub-")]
    groups = _participants(folder / PARTICIPANTS)
    homes: List[Tuple[str, Path]] = []
    for path in bids or below:
        sessions = sorted(one for one in path.iterdir() if one.name.startswith("ses-"))
        if bids and sessions:
            homes += [(f"{path.name}_{one.name}", one) for one in sessions if one.is_dir()]
        else:
            homes.append((path.name, path))
    if homes and not (bids or _files_in(folder, study)):
        bids = below
    if not bids:  # one folder of files
        return [
            Subject(name, [path.relative_to(folder).as_posix()], groups.get(name, {}))
            for path, name in _named(_files_in(folder, study))
        ]
    found = []
    for name, path in homes:
        its = _files_in(path, study, deep=True)
        what = f"no file that fits {study.files!r}" if study.files else "no mesh, no label volume"
        found.append(
            Subject(
                name,
                [file.relative_to(folder).as_posix() for file in its],
                groups.get(name, groups.get(name.split("_ses-")[0], {})),
                failed="" if its else f"There is {what} in its folder {path.name}.",
            )
        )
    return found


def _named(paths: Sequence[Path]) -> List[Tuple[Path, str]]:
    return list(zip(paths, files.names_of(paths))) if paths else []


def _files_in(folder: Path, study: Study, deep: bool = False) -> List[Path]:
    """A subject's files in natural order; of several kinds segmentations, else meshes."""
    pattern = study.files or ("**/*" if deep else "*")
    found = [
        path
        for path in folder.glob(pattern)
        if path.is_file() and not path.name.startswith(".") and _is_read(path)
    ]
    found.sort(key=lambda path: files._natural(path.relative_to(folder).as_posix()))
    with attention.silenced():
        found = files._inputs(found)
    if study.files:
        return found
    drawn = [path for path in found if SEGMENTATION.search(path.name)]
    meshes = [path for path in found if not files.is_label_volume(path)]
    return drawn or meshes or found


def _is_read(path: Path) -> bool:
    name = path.name.lower()
    return name.endswith((*files.SUFFIXES, *files.VOLUME_SUFFIXES))


def _participants(path: Path) -> Dict[str, Dict[str, str]]:
    if not path.is_file():
        return {}
    rows = rows_of(path)
    return {
        row["participant_id"]: {key: value for key, value in row.items() if key != "participant_id"}
        for row in rows
        if row.get("participant_id")
    }


def rows_of(path: Path) -> List[Dict[str, str]]:
    """Of a table, whatever stands between its columns."""
    try:
        text = path.read_text(encoding="utf-8-sig")
    except UnicodeDecodeError as error:
        raise InputError(f"{path} is no table in UTF-8: {error}") from error
    first = text.split("\n", 1)[0]
    delimiter = max("\t;,", key=first.count)
    rows = csv.DictReader(text.splitlines(), delimiter=delimiter)
    return [
        {(key or "").strip(): (value or "").strip() for key, value in row.items() if key}
        for row in rows
    ]


def _of_table(path: Path) -> List[Subject]:
    """Columns: subject, file; phase (their order), anchors (a file); all others are groups."""
    rows = rows_of(path)
    columns = list(rows[0]) if rows else []
    for needed in ("subject", "file"):
        if needed not in columns:
            raise InputError(
                f"{path} lacks the column {needed!r}: it has "
                f"{', '.join(columns) or 'none'}. Needed are subject and file, with one row per "
                "subject and phase; phase, anchors and columns of groups may be there."
            )
    by_subject: Dict[str, List[Mapping[str, str]]] = {}
    for number, row in enumerate(rows, 2):
        if not row["subject"]:
            raise InputError(f"{path}: line {number} says no subject.")
        by_subject.setdefault(row["subject"], []).append(row)
    found = []
    base = path.resolve().parent
    for name, its in by_subject.items():
        if NAME.search(name):
            raise InputError(
                f"{path}: the subject {name!r} becomes the name of files: letters, digits, "
                "_ . + and - are allowed."
            )
        if "phase" in columns:
            its = sorted(its, key=lambda row: files._natural(row["phase"]))
        groups = {
            key: its[0][key]
            for key in columns
            if key not in ("subject", "file", "phase", "anchors")
        }
        anchors = next((row["anchors"] for row in its if row.get("anchors")), "")
        empty = any(not row["file"] for row in its)
        found.append(
            Subject(
                name,
                [_relative(base, row["file"]) for row in its if row["file"]],
                groups,
                _relative(base, anchors) if anchors else "",
                "Its row of the table names no file." if empty else "",
            )
        )
    return found


def _relative(base: Path, name: str) -> str:
    path = Path(name)
    if path.is_absolute():
        try:
            return path.relative_to(base).as_posix()
        except ValueError:
            return path.as_posix()
    return path.as_posix()


def _with_anchors(subject: Subject, folder: Path, base: Path) -> Subject:
    from dataclasses import replace

    for ending in ANCHOR_FILES:
        path = folder / f"{subject.name}{ending}"
        if path.is_file() and not subject.anchors:
            return replace(subject, anchors=_relative(base, str(path.resolve())))
    return subject


__all__ = ["FileError", "Subject", "chosen", "find"]
