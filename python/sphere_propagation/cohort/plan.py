# SPDX-License-Identifier: GPL-3.0-only
"""What is to be done, as files in OUTPUT/plan that are written only where they say something new:
the engine does again what depends on these.

Chunks are the jobs: a subject stays in its chunk from run to run, new ones fill the last chunk and
then make others; so is the choice of the atlas kept, while all its subjects take part.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any, Dict, List, Mapping, Optional, Sequence

from ..errors import InputError
from ..version import version
from . import memory, store
from .study import EXCLUDE, Study
from .subjects import NAME, Subject, rows_of

PLAN = Path("plan")
BLOCK = 16  # chunks whose moments are one job, and moments that are merged in one
CHUNK = 50  # subjects of a job where the study does not say it, and
FEWEST_CHUNKS = 16  # where there are enough: a study of 32 is to use more than one core
IMPORT_KEYS = (
    "labels",
    "voxel_size",
    "smoothing",
    "coordinates",
    "align_slices",
    "handle_repair",
    "longest_gap",
    "skip_incomplete_phases",
)
ATLAS_KEYS = ("root_phase", "groupwise", "initial_map", "area_weight", "frequency", "alignment")
LANDMARK_KEYS = ("root_phase", "order", "area_restoration", "frequency")
ANCHOR_KEYS = ("anchor_sd",)
MODEL_KEYS = ("left_out", "alignment", "modes", "cycle_phases", "systole", "order", "unit")
YES = ("1", "x", "y", "yes", "true", "exclude")
NO = ("", "0", "-", "n", "no", "false", "include")


def number(n: int) -> str:
    return f"{n:05d}"


def write(
    output: Path,
    study: Study,
    base: Path,
    subjects: Sequence[Subject],
    home: Optional[Path] = None,
    remarks: Sequence[str] = (),
) -> Dict[str, Any]:
    """Writes the plan and returns chunks.json. base: the folder that files are relative to; home:
    what the study's paths are relative to; remarks: on the input, for the report."""
    folder = output / PLAN
    names = [subject.name for subject in subjects]
    for name in names:
        if NAME.search(name) or name.startswith("."):
            raise InputError(
                f"The subject {name!r} becomes the name of files: letters, digits, _ . + and - "
                "are allowed. Rename its file or folder, or give a table."
            )
    members = _members(folder, names, study.chunk)
    present = set(names)
    chunks = {
        chunk: [name for name in those if name in present] for chunk, those in members.items()
    }
    chunks = {chunk: those for chunk, those in chunks.items() if those}
    of = {subject.name: subject for subject in subjects}
    asked: Dict[str, Dict[str, int]] = {}
    for chunk, those in chunks.items():
        entries = _entries(output, chunk, base, [of[name] for name in those])
        store.write_if_changed(
            folder / "import" / f"{chunk}.json",
            {**_header("import", study.part(*IMPORT_KEYS)), "subjects": entries},
        )
        asked[chunk] = memory.of_chunk(base, entries, output / "surfaces" / f"{chunk}.json")
    for old in folder.glob("import/*.json"):
        if old.stem not in chunks:
            old.unlink()
    at = {name: chunk for chunk, those in chunks.items() for name in those}
    store.write_if_changed(
        folder / "atlas.json",
        {
            **_header("atlas", study.part(*ATLAS_KEYS, *ANCHOR_KEYS)),
            "subjects": _atlas(folder, [s for s in subjects if not s.failed], study, at),
        },
    )
    store.write_if_changed(
        folder / "landmarks.json",
        _header("landmarks", study.part(*LANDMARK_KEYS, *ANCHOR_KEYS)),
    )
    marked = excluded(output, study, home, subjects)
    store.write_if_changed(
        folder / "model.json",
        {**_header("model", study.part(*MODEL_KEYS)), "exclude": list(marked)},
    )
    store.write_if_changed(
        folder / "report.json",
        {**_header("report", study.part("quality")), "remarks": list(remarks), "why": marked},
    )
    store.write_if_changed(folder / "members.json", members)
    atlas = [chunk for _, chunk in store.read_json(folder / "atlas.json")["subjects"]]
    landmarks = 10 * study.frequency**2 + 2
    store.write_if_changed(
        folder / "memory.json", memory.of_study(asked, atlas, landmarks)
    )  # of no step: what is asked for changes no result
    blocks = tree(sorted(chunks))
    plan = {
        "chunks": {chunk: len(those) for chunk, those in sorted(chunks.items())},
        "atlas": sorted(
            {at[name] for name, _ in store.read_json(folder / "atlas.json")["subjects"]}
        ),
        "levels": blocks,
        "keep_surfaces": study.keep_surfaces,
    }
    store.write_if_changed(folder / "chunks.json", plan)
    store.write_if_changed(
        folder / "study.json",
        {
            "version": version(),
            "input": str(base),
            "study": study.as_dict(),
            "subjects": len(subjects),
        },
    )
    return plan


def _header(step: str, parameters: Mapping[str, Any]) -> Dict[str, Any]:
    return {"step": step, "version": version(), "parameters": dict(parameters)}


def tree(chunks: Sequence[str]) -> List[Dict[str, List[str]]]:
    """By level what is merged into what: at level 0 chunks, at the others what is one below; the
    last level has one."""
    levels: List[Dict[str, List[str]]] = []
    below = list(chunks)
    while not levels or len(levels[-1]) > 1:
        groups = [below[i : i + BLOCK] for i in range(0, len(below), BLOCK)]
        levels.append({number(i): group for i, group in enumerate(groups)})
        below = list(levels[-1])
    return levels


def _members(folder: Path, names: Sequence[str], size: int) -> Dict[str, List[str]]:
    """Chunk -> the subjects that were ever in it. size: 0 for what suits their number."""
    path = folder / "members.json"
    members: Dict[str, List[str]] = store.read_json(path) if path.is_file() else {}
    known = {name for those in members.values() for name in those}
    if not known & set(names):  # another study, or the first run
        members = {}
        size = size or min(CHUNK, -(-len(names) // FEWEST_CHUNKS))
    elif members:
        size = min(size or CHUNK, max(map(len, members.values())))
    known = {name for those in members.values() for name in those}
    last = number(len(members) - 1)
    for name in names:
        if name in known:
            continue
        if not members or len(members[last]) >= size:
            last = number(len(members))
            members[last] = []
        members[last].append(name)
    return members


def _atlas(
    folder: Path, subjects: Sequence[Subject], study: Study, at: Mapping[str, str]
) -> List[List[str]]:
    """Names and chunks: those of the run before where all still take part, else evenly spread."""
    names = [subject.name for subject in subjects]
    path = folder / "atlas.json"
    if path.is_file():
        before = [name for name, _ in store.read_json(path)["subjects"]]
        enough = len(before) <= study.atlas_subjects and before
        if enough and set(before) <= set(names) and (folder / "members.json").is_file():
            return [[name, at[name]] for name in before]
    count = min(len(names), study.atlas_subjects)
    picked = [names[i * len(names) // count] for i in range(count)] if count else []
    return [[name, at[name]] for name in picked]


def _entries(
    output: Path, chunk: str, base: Path, subjects: Sequence[Subject]
) -> List[Dict[str, Any]]:
    """As the import reads them. A file whose time alone has changed keeps its entry."""
    path = output / PLAN / "import" / f"{chunk}.json"
    before: Dict[str, Dict[str, Any]] = {}
    if path.is_file():
        for entry in store.read_json(path)["subjects"]:
            for file in [*entry["files"], *([entry["anchors"]] if entry["anchors"] else [])]:
                before[file["file"]] = file
    sums: Dict[str, str] = {}
    done = output / "surfaces" / f"{chunk}.json"
    if done.is_file():
        for record in store.read_json(done)["subjects"]:
            for file in [*record["files"], *([record["anchors"]] if record["anchors"] else [])]:
                sums[file["file"]] = file["sha256"]

    def entry(name: str) -> Dict[str, Any]:
        try:
            found = (base / name).stat()
        except OSError:
            return {"file": name, "bytes": -1, "mtime_ns": 0}
        now = {"file": name, "bytes": found.st_size, "mtime_ns": found.st_mtime_ns}
        old = before.get(name)
        same = old and old["bytes"] == now["bytes"]
        if same and (old == now or sums.get(name) == store.digest(base / name)):
            return old
        return now

    return [
        {
            "subject": subject.name,
            "files": [entry(name) for name in subject.files],
            "anchors": entry(subject.anchors) if subject.anchors else None,
            "groups": subject.groups,
            "failed": subject.failed,
        }
        for subject in subjects
    ]


def excluded(
    output: Path, study: Study, home: Optional[Path], subjects: Sequence[Subject]
) -> Dict[str, str]:
    """Whom the study's table leaves out of the models, and why."""
    return excluded_in(_exclude_file(output, study, home), [one.name for one in subjects])


def _exclude_file(output: Path, study: Study, home: Optional[Path]) -> Path:
    if study.exclude == EXCLUDE or home is None:
        return output / study.exclude
    path = home / study.exclude
    if not path.is_file():
        raise InputError(f"exclude: there is no file {path}.")
    return path


def excluded_in(path: Path, names: Sequence[str]) -> Dict[str, str]:
    """Subjects that a table (subject, exclude, why) marks, and what its column why says of each;
    all that it names where it has no column exclude."""
    if not path.is_file():
        return {}
    rows = rows_of(path.resolve())
    shown = path.resolve()  # a dry run plans elsewhere
    if rows and "subject" not in rows[0]:
        raise InputError(f"{shown} lacks the column subject.")
    known = set(names)
    marked: Dict[str, str] = {}
    for number, row in enumerate(rows, 2):
        name, word = row["subject"], row.get("exclude", "yes")
        if word.lower() not in (*YES, *NO):
            raise InputError(
                f"{shown}: line {number} says {word!r} in the column exclude of {name}: it is yes "
                "or no."
            )
        if word.lower() in NO:
            continue
        if name not in known:
            raise InputError(f"{shown}: there is no subject {name!r}.")
        marked[name] = row.get("why", "")
    return dict(sorted(marked.items()))
