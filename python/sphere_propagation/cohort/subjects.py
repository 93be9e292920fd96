# SPDX-License-Identifier: GPL-3.0-only
"""Who takes part: a BIDS-like tree, a folder per subject, one folder of files, or a table."""

from __future__ import annotations

import csv
import os
import re
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Dict, List, Mapping, NamedTuple, Sequence, Tuple

from .. import attention, errors, files
from ..errors import FileError, InputError
from ..fitting import ANCHOR_FILES
from .columns import COLUMNS
from .study import Study

TABLES = (".csv", ".tsv")
OF_TABLE = ("subject", "file", "phase", "anchors")  # columns; all others are groups
PARTICIPANTS, ID = "participants.tsv", "participant_id"  # of BIDS: its other columns are groups
MISSING = "n/a"  # a value, in BIDS
OF_BIDS = ("derivatives", "code", "sourcedata", "phenotype", "stimuli")  # folders of no subject
SESSION = "ses-"
DRAWN = "segmentations (_dseg, _mask, _probseg)"
TEXTS = (".txt", ".md", ".json", ".tsv", ".csv", ".toml", ".yaml", ".pdf", ".html", ".log")
TEXTS += (".bval", ".bvec", ".mtl", ".png", ".jpg", ".raw", ".zraw")  # parts of others
PAPERS = ("README", "LICENSE", "CHANGES", "CITATION")
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


class Input(NamedTuple):
    """base: the folder that files are relative to; subjects: in natural order; remarks: what was
    found there and is not taken, in words."""

    base: Path
    subjects: List[Subject]
    remarks: List[str]


def find(where: Path, study: Study, home: Path) -> Input:
    """home: what the study's own paths are relative to."""
    if not where.exists():
        raise InputError(f"There is no file or folder {where}.")
    remarks: List[str] = []
    if where.is_file():
        if where.suffix.lower() not in TABLES:
            raise InputError(
                f"{where} is a file: the input is a folder, or a table (.csv, .tsv) with the "
                "columns subject and file."
            )
        base, found = where.resolve().parent, _of_table(where)
    else:
        base, found = where.resolve(), _of_folder(where.resolve(), study, remarks)
    if not found:
        raise InputError(f"{where} holds no subject: no folder and no file that can be read.")
    found.sort(key=lambda subject: files._natural(subject.name))
    if study.anchors:
        folder = home / study.anchors
        if not folder.is_dir():
            raise InputError(f"anchors: {folder} is no folder.")
        found = [_with_anchors(subject, folder, base) for subject in found]
    _require_distinct(base, found)
    return Input(base, found, remarks)


def _require_distinct(base: Path, found: Sequence[Subject]) -> None:
    """One file is one shape of one subject, by whatever names it is given."""
    seen: Dict[str, str] = {}
    for subject in found:
        for name in subject.files:
            path = str(base / name)
            path = os.path.realpath(path) if os.path.islink(path) else os.path.normpath(path)
            if path in seen:
                whose = "twice" if seen[path] == subject.name else f"and is of {seen[path]}, too"
                raise InputError(
                    f"{subject.name}: the file {name} is given {whose}: a shape that counts twice "
                    "is a wrong model. Name it once."
                )
            seen[path] = subject.name


def some(names: Sequence[str]) -> str:
    return errors.some(names, 3)


def counted(count: int, noun: str) -> str:
    return f"{count} {noun}{'' if count == 1 else 's'}"


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


@dataclass
class _Seen:
    """What of a folder's files was not taken, by the rule that left it out; names are relative to
    the input. rules: subject -> by what its files were chosen."""

    root: Path
    beside: Dict[str, List[str]] = field(default_factory=dict)
    unread: List[str] = field(default_factory=list)
    dangling: List[str] = field(default_factory=list)
    rules: Dict[str, List[str]] = field(default_factory=dict)

    def name(self, path: Path) -> str:
        return path.relative_to(self.root).as_posix()


def _of_folder(folder: Path, study: Study, remarks: List[str]) -> List[Subject]:
    below = sorted(
        (
            path
            for path in folder.iterdir()
            if path.is_dir()
            and not path.name.startswith((".", "_"))
            and path.name not in OF_BIDS
            and not (path / STUDY_OUTPUT).is_file()
        ),
        key=lambda path: files._natural(path.name),
    )
    seen, aside = _Seen(folder), _Seen(folder)
    bids = [path for path in below if path.name.startswith("sub-")]
    here = [path for path in _files_in(folder, study, aside, "") if path.parent == folder]
    of = {path: _homes(path, study, seen, bool(bids)) for path in bids or below}
    full = [path for path, homes in of.items() if any(its for _, _, its in homes)]
    if not bids and here and len(here) > len(full):  # one folder of files
        if full:
            remarks.append(
                f"{counted(len(full), 'folder')} beside the {len(here)} files of subjects "
                f"{_are(full)} left out: {some([path.name for path in full])}"
            )
        _say_what_was_left(aside, remarks)
        named = list(zip(here, files.names_of(here)))
        groups = _participants(folder / PARTICIPANTS, [name for _, name in named], remarks)
        _compare_with_participants(groups, [name for _, name in named], remarks)
        return [Subject(name, [path.name], groups.get(name, {})) for path, name in named]
    seen.dangling += [path.name for path in folder.iterdir() if _leads_nowhere(path)]
    others = [path.name for path in below if bids and path not in bids]
    if others:
        remarks.append(
            f"{counted(len(others), 'folder')} not called sub-… {_are(others)} left out: "
            f"{some(others)}"
        )
    if here and of:
        remarks.append(
            f"{counted(len(here), 'file')} beside the folders of subjects {_are(here)} left out: "
            f"{some([path.name for path in here])}"
        )
    _say_what_was_left(seen, remarks)
    names = [name for path, homes in of.items() for name in (path.name, homes[0][0])]
    groups = _participants(folder / PARTICIPANTS, names, remarks)
    found = []
    for path, homes in of.items():
        for name, where, its in homes:
            what = (
                f"no file that fits {study.files!r}" if study.files else "no mesh, no label volume"
            )
            found.append(
                Subject(
                    name,
                    [seen.name(file) for file in its],
                    groups.get(name, groups.get(path.name, {})),
                    failed="" if its else f"There is {what} in its folder {seen.name(where)}.",
                )
            )
    _compare_with_participants(groups, names, remarks)
    return found


def _are(things: Sequence[Any]) -> str:
    return "is" if len(things) == 1 else "are"


def _homes(path: Path, study: Study, seen: _Seen, bids: bool) -> List[Tuple[str, Path, List[Path]]]:
    """The subjects of a folder, its sessions where it has some: name, folder and files of each."""
    sessions = sorted(
        one
        for one in (path.iterdir() if bids else ())
        if one.is_dir() and one.name.startswith(SESSION)
    )
    if not sessions:
        return [(path.name, path, _files_in(path, study, seen, path.name, deep=True))]
    found = [
        (name, one, _files_in(one, study, seen, name, deep=True))
        for one, name in ((one, f"{path.name}_{one.name}") for one in sessions)
    ]
    inside = tuple(f"{one}{os.sep}" for one in sessions)
    stray = [
        seen.name(one)
        for one in sorted(path.rglob("*"))
        if one.is_file() and _is_read(one) and not str(one).startswith(inside)
    ]
    seen.beside.setdefault("sessions (ses-…)", []).extend(stray)
    return found


def _files_in(
    folder: Path, study: Study, seen: _Seen, subject: str, deep: bool = False
) -> List[Path]:
    """A subject's files in natural order; of several kinds segmentations, else meshes."""
    pattern = study.files or ("**/*" if deep else "*")
    matching = [path for path in folder.glob(pattern) if path.name[0] != "."]
    seen.dangling += [seen.name(path) for path in matching if _leads_nowhere(path)]
    there = [path for path in matching if path.is_file()]
    there.sort(key=lambda path: files._natural(path.relative_to(folder).as_posix()))
    found = [path for path in there if _is_read(path)]
    seen.unread += [seen.name(path) for path in there if not _is_read(path) and _may_be_meant(path)]
    with attention.silenced():
        found = files._inputs(found)
    if study.files or not found:
        return found
    drawn = [path for path in found if SEGMENTATION.search(path.name)]
    meshes = [path for path in found if not files.is_label_volume(path)]
    rule, taken = next(
        (rule, taken)
        for rule, taken in ((DRAWN, drawn), ("meshes", meshes), ("label volumes", found))
        if taken
    )
    seen.rules.setdefault(rule, []).append(subject)
    left = set(found) - set(taken)
    if left:
        seen.beside.setdefault(rule, []).extend(seen.name(one) for one in found if one in left)
    return taken


def _leads_nowhere(path: Path) -> bool:
    return path.is_symlink() and not path.exists()


def _say_what_was_left(seen: _Seen, remarks: List[str]) -> None:
    which = "the study's key files says which are taken"
    for rule, names in seen.beside.items():
        if names:
            remarks.append(
                f"{counted(len(names), 'file')} beside {rule} {_are(names)} left out: "
                f"{some(names)} ({which})"
            )
    if len(seen.rules) > 1:
        usual = max(seen.rules, key=lambda rule: len(seen.rules[rule]))
        for rule, names in seen.rules.items():
            if rule != usual:
                remarks.append(
                    f"{counted(len(names), 'subject')} {'has' if len(names) == 1 else 'have'} no "
                    f"{usual}, as others have, and {rule} are taken: {some(names)} ({which})"
                )
    if seen.dangling:
        remarks.append(
            f"{counted(len(seen.dangling), 'link')} to what is not there "
            f"{_are(seen.dangling)} left out: {some(sorted(seen.dangling))}"
        )
    if seen.unread:
        remarks.append(
            f"{counted(len(seen.unread), 'file')} of a kind that is not read "
            f"{_are(seen.unread)} left out: {some(seen.unread)}"
        )


def _is_read(path: Path) -> bool:
    name = path.name.lower()
    return name.endswith((*files.SUFFIXES, *files.VOLUME_SUFFIXES))


def _may_be_meant(path: Path) -> bool:
    """For a shape: no text beside it, no anchors."""
    name = path.name.lower()
    return not name.endswith((*TEXTS, *ANCHOR_FILES)) and path.stem.upper() not in PAPERS


def _participants(
    path: Path, names: Sequence[str], remarks: List[str]
) -> Dict[str, Dict[str, str]]:
    """Groups by subject; names: the subjects', which a row may have without sub-."""
    known = set(names)
    if not path.is_file():
        return {}
    rows = rows_of(path)
    if rows and ID not in rows[0]:
        remarks.append(f"{PARTICIPANTS} lacks the column {ID}: nobody is in a group")
    taken = [key for key in (rows[0] if rows else ()) if key in COLUMNS]
    if taken:
        remarks.append(
            f"{counted(len(taken), 'column')} of {PARTICIPANTS} {_are(taken)} left out, because "
            f"subjects.csv has one of that name: {some(taken)}"
        )
    groups: Dict[str, Dict[str, str]] = {}
    for number, row in enumerate(rows, 2):
        name = row.get(ID, "")
        if not name:
            continue
        if name not in known and f"sub-{name}" in known:
            name = f"sub-{name}"
        its = {
            key: "" if value.lower() == MISSING else value
            for key, value in row.items()
            if key not in (ID, "", *taken)
        }
        if groups.setdefault(name, its) != its:
            raise InputError(
                f"{path}: line {number} says of {name} something else than a line before: which "
                "is right?"
            )
    return groups


def _compare_with_participants(
    groups: Mapping[str, Any], names: Sequence[str], remarks: List[str]
) -> None:
    """names: of folders and of subjects, which differ where there are sessions."""
    if not groups:
        return
    absent = [name for name in groups if name not in set(names)]
    if absent:
        remarks.append(
            f"{counted(len(absent), 'subject')} of {PARTICIPANTS} {_are(absent)} not among the "
            f"files: {some(absent)}"
        )
    bare = [name for name in dict.fromkeys(names) if name not in groups]
    bare = [name for name in bare if name.split("_ses-")[0] not in groups]
    if bare:
        remarks.append(
            f"{counted(len(bare), 'subject')} {_are(bare)} not in {PARTICIPANTS}, and in no "
            f"group: {some(bare)}"
        )


def rows_of(path: Path) -> List[Dict[str, str]]:
    """Of a table, whatever stands between its columns."""
    try:
        text = path.read_text(encoding="utf-8-sig")
    except UnicodeDecodeError as error:
        raise InputError(f"{path} is no table in UTF-8: {error}") from error
    first = text.split("\n", 1)[0]
    delimiter = max("\t;,", key=first.count)
    rows = []
    for number, row in enumerate(csv.DictReader(text.splitlines(), delimiter=delimiter), 2):
        if None in row:
            raise InputError(
                f"{path}: line {number} has more cells than there are columns: a cell with a "
                f"{delimiter!r} in it takes quotation marks."
            )
        rows.append({key.strip(): (value or "").strip() for key, value in row.items()})
    return rows


def _of_table(path: Path) -> List[Subject]:
    """Columns: subject, file; phase (their order), anchors (a file); all others are groups."""
    rows = rows_of(path)
    if not rows:
        raise InputError(
            f"{path} has no rows: below the columns' names, subject and file, there is one for "
            "each subject and phase."
        )
    columns = list(rows[0])
    for needed in ("subject", "file"):
        if needed not in columns:
            raise InputError(
                f"{path} lacks the column {needed!r}: it has {', '.join(columns)}. Needed are "
                "subject and file, with one row per "
                "subject and phase; phase, anchors and columns of groups may be there."
            )
    named = [key for key in columns if key not in OF_TABLE and key]
    taken = [key for key in named if key in COLUMNS]
    if taken:
        raise InputError(
            f"{path}: a column of groups cannot be called {taken[0]!r}, as one of subjects.csv is: "
            "rename it."
        )
    by_subject: Dict[str, List[Tuple[int, Mapping[str, str]]]] = {}
    for number, row in enumerate(rows, 2):
        if not row["subject"]:
            raise InputError(f"{path}: line {number} says no subject.")
        by_subject.setdefault(row["subject"], []).append((number, row))
    base = path.resolve().parent
    return [_of_rows(path, base, name, its, named) for name, its in by_subject.items()]


def _of_rows(
    path: Path,
    base: Path,
    name: str,
    its: List[Tuple[int, Mapping[str, str]]],
    named: Sequence[str],
) -> Subject:
    """its: lines and their cells; named: the columns of groups."""
    if NAME.search(name):
        raise InputError(
            f"{path}: the subject {name!r} becomes the name of files: letters, digits, "
            "_ . + and - are allowed."
        )
    if "phase" in its[0][1]:
        its = sorted(its, key=lambda line: files._natural(line[1]["phase"]))
        for (_, before), (number, row) in zip(its, its[1:]):
            if files._natural(before["phase"]) == files._natural(row["phase"]):
                raise InputError(
                    f"{path}: line {number} gives {name} the phase {row['phase']!r} once more."
                )
    groups = {key: its[0][1][key] for key in named}
    for key in (*named, "anchors"):
        said = {row.get(key, ""): number for number, row in its}
        said = {value: number for value, number in said.items() if value or key != "anchors"}
        if len(said) > 1:
            (one, _), (other, number) = list(said.items())[:2]
            raise InputError(
                f"{path}: line {number} says {other!r} in the column {key} of {name}, and another "
                f"{one!r}: a subject has one."
            )
    anchors = next((row["anchors"] for _, row in its if row.get("anchors")), "")
    failed = ""
    if any(not row["file"] for _, row in its):
        failed = "Its row of the table names no file."
    for number, row in reversed(its):
        for file in filter(None, (row.get("anchors"), row["file"])):
            said = f"which line {number} of {path.name} names"
            if (base / file).is_dir():
                failed = f"{file}, {said}, is a folder: a row names a file."
            elif not (base / file).is_file():
                failed = f"There is no file {file}, {said}."
    return Subject(
        name,
        [_relative(base, row["file"]) for _, row in its if row["file"]],
        groups,
        _relative(base, anchors) if anchors else "",
        failed,
    )


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


__all__ = ["FileError", "Input", "Subject", "chosen", "find"]
