# SPDX-License-Identifier: GPL-3.0-only
"""What `sphere-propagation cohort` does: reads the study, plans, has the engine run, says what came
out."""

from __future__ import annotations

import gzip
from collections import Counter
from dataclasses import replace
from pathlib import Path
from typing import Any, Callable, Dict, Iterator, List, Optional, Sequence, Tuple, Union

from .. import files
from ..errors import InputError
from . import atlas, cycles, engine, likeness, memory, plan, store, subjects, twins
from .frames import no_such_phase
from .landmarks import LANDMARKS
from .steps import COSTS
from .study import LARGEST, read_study
from .subjects import counted

# CPU seconds, measured: landmarks of 60 hippocampi of 2,500 vertices, and label volumes of two
# hearts of 25 and 30 phases (docs/cohorts.md); a study that has begun is reckoned by its own.
PER_PHASE = {"import": 0.07, "landmarks": 0.17}
PER_SUBJECT = {"import": 0.03, "landmarks": 3.0, "atlas": 0.3}
PER_JOB = 0.8  # a Python that loads the package, and the engine's share
LISTED = 10  # subjects
OF_THE_STUDY = ("sidesDiffer", "sidesNotKnown", "halfOfLayersLarger")  # warnings
LEFT_OUT = 3  # an exit code: the study is done, and subjects are not in it
SAMPLED = 50  # files whose phases are counted


def run(
    where: Path,
    output: Path,
    level: str,
    *,
    config: Optional[Path] = None,
    labels: Sequence[str] = (),
    cores: Optional[int] = None,
    profile: Optional[str] = None,
    dry: bool = False,
    say: Callable[[str], None] = print,
) -> int:
    """The command's exit code: 0 where all subjects are done, but those that somebody excluded; 3
    where the study is done, and others were left out. A dry run's is the same, as far as names and
    tables tell."""
    study, home = read_study(config)
    engine.require(profile)
    _require_folders(where, output)
    base, found, remarks = subjects.find(where, study, home)
    if labels:
        found, remarks = subjects.chosen(found, labels), []
        _require_no_fewer(output, found)
    found = _with_root_phases(base, found, study.root_phase)
    excluded = plan.excluded(output, study, home, found)
    _require_enough(found, list(excluded) if level == "group" else (), level)
    if dry:
        damaged = store.damaged(output)
        with engine.shadow(output, damaged) as folder:
            _say_damaged(output, damaged, say)
            made = plan.write(folder, study, base, found, home, remarks)
            _say_what_would_run(folder, output, level, base, found, made, say)
            _say_remarks(remarks, say)
        return LEFT_OUT if any(one.failed and one.name not in excluded for one in found) else 0
    output.mkdir(parents=True, exist_ok=True)
    with engine.lock(output):
        if not profile:  # jobs on this machine have ended with the run that started them
            store.sweep(output)
        damaged = store.damaged(output)
        for path in damaged:
            path.unlink()
        _say_damaged(output, damaged, say)
        made = plan.write(output, study, base, found, home, remarks)
        _say_remarks(remarks, say)
        say(
            f"{counted(len(found), 'subject')} in {counted(len(made['chunks']), 'chunk')}, "
            f"up to {len(store.read_json(output / plan.PLAN / 'atlas.json')['subjects'])} in the "
            "atlas"
        )
        engine.run(output, level, cores or (None if profile else 1), profile, say)
        complete = _say_what_came_out(output, level, list(made["chunks"]), say)
    return 0 if complete else LEFT_OUT


def _require_enough(found: Sequence[subjects.Subject], excluded: Sequence[str], level: str) -> None:
    """Two subjects, before hours are spent on what cannot be a model; one for landmarks."""
    left = [one for one in found if not one.failed and one.name not in excluded]
    if len(left) >= (2 if level == "group" else 1):
        return
    if level != "group":
        raise InputError(f"No subject can take part. {found[0].name}: {found[0].failed}")
    why = f" {found[0].name}: {found[0].failed}" if found[0].failed else ""
    raise InputError(
        f"{counted(len(left), 'subject')} of {len(found)} can take part, and models are made of "
        f"two or more.{why} Landmarks of one are what the level participant makes; "
        '"sphere-propagation run" makes a model of its phases.'
    )


def _say_remarks(remarks: Sequence[str], say: Callable[[str], None]) -> None:
    for remark in remarks:
        say(f"note: {remark}")


def _say_damaged(output: Path, damaged: Sequence[Path], say: Callable[[str], None]) -> None:
    if damaged:
        names = [path.relative_to(output).as_posix() for path in damaged]
        say(
            f"note: {counted(len(names), 'file')} of this study that cannot be read, since cut "
            f"off, {'is' if len(names) == 1 else 'are'} made again where needed: "
            f"{subjects.some(names)}"
        )


def _with_root_phases(
    base: Path, found: Sequence[subjects.Subject], root_phase: Union[str, int]
) -> List[subjects.Subject]:
    """Those fail that have no phase of this number, as far as names and headers tell."""
    if root_phase == LARGEST:
        return list(found)
    checked = []
    for one in found:
        phases = 0 if one.failed else len(one.files)
        if phases == 1 and files.is_label_volume(base / one.files[0]):
            header = memory.header_of_nifti(base / one.files[0])
            phases = header[0] if header else 0
        if 0 < phases <= root_phase:
            one = replace(one, failed=no_such_phase(root_phase, phases))
        checked.append(one)
    return checked


def _require_no_fewer(output: Path, found: Sequence[subjects.Subject]) -> None:
    """A study that is there would become one of the subjects chosen."""
    chosen = {one.name for one in found}
    others = [
        entry["subject"]
        for path in sorted((output / plan.PLAN / "import").glob("*.json"))
        for entry in store.read_json(path)["subjects"]
        if entry["subject"] not in chosen
    ]
    if others:
        raise InputError(
            f"{output} is a study that has {others[0]}, too, in all "
            f"{counted(len(others), 'subject')} that --participant-label does not name: they "
            "would be left out of it. Choose another folder, or leave the option out; subjects of "
            "one study are done side by side by --cores or --profile."
        )


def _require_folders(where: Path, output: Path) -> None:
    for path in (output, *output.parents):
        if path.exists() and not path.is_dir():
            raise InputError(f"{path} is a file: the output is a folder. Choose another name.")
    here, there = where.resolve(), output.resolve()
    if here == there or there in here.parents:
        raise InputError(f"The input {where} lies in the output {output}: choose another folder.")
    ours = (output / plan.PLAN / "study.json").is_file()
    if output.is_dir() and not ours and any(output.iterdir()):
        others = [path.name for path in output.iterdir() if path.name not in (engine.LOCK,)]
        if others and others != [plan.EXCLUDE]:
            raise InputError(
                f"{output} is not empty and no study's output ({sorted(others)[0]} lies in it): "
                "choose a new folder."
            )


def _say_some(lines: Sequence[Tuple[str, str]], say: Callable[[str], None]) -> None:
    for name, why in lines[:LISTED]:
        say(f"  {name}: {why}")
    if len(lines) > LISTED:
        say(f"  and {len(lines) - LISTED} more")


def _say_what_came_out(
    output: Path, level: str, chunks: Sequence[str], say: Callable[[str], None]
) -> bool:
    """Whether all subjects are in it, but those that somebody excluded."""
    done, phases, failed, odd, missing = 0, 0, [], [], 0
    model = store.read_json(output / plan.PLAN / "model.json")
    for chunk in chunks:
        for record in store.read_json(output / LANDMARKS / f"{chunk}.json")["subjects"]:
            name = record["subject"]
            excluded = name in model["exclude"]
            if record["failed"]:
                where = record["failed"]["step"] + (", excluded" if excluded else "")
                failed.append((f"{name} ({where})", record["failed"]["reason"]))
                missing += not excluded
                continue
            done, phases = done + 1, phases + record["phases"]
            if record["odd"] and not excluded:
                left = bool(likeness.left_out(record, model["parameters"]))
                missing += left
                where = f"{name} ({'left out of' if left else 'in'} the models)"
                odd.append((where, likeness.words_of(record)))
    say(f"\n{counted(done, 'subject')} done, {counted(phases, 'surface')}; {len(failed)} failed")
    _say_some(failed, say)
    if odd:
        say(f"{counted(len(odd), 'subject')} not like the others:")
        _say_some(odd, say)
    same = list(twins.found_in(output, chunks, model).items())
    if same:
        say(f"{counted(len(same), 'subject')} with the same files:")
        _say_some(same, say)
    for one in store.read_json(output / atlas.ATLAS.with_suffix(".json"))["warnings"]:
        if one["message"] in OF_THE_STUDY:
            say(f"note: of the subjects in the atlas, {one['text']}")
    say(f"\nIn {output.resolve()}:")
    say("  landmarks/*.npy, *.json: a chunk of subjects each, and what was measured of them")
    if level == "group":
        say(
            "  report.html: subjects by what stands out, with a report of each; exclude.csv from it"
        )
        say("  subjects.csv: a row for each subject, with the reason where it failed")
        say("  model/model.npz, model.csv, measures.csv, explore.html: the spatial model")
        if store.read_json(output / cycles.CYCLE / "model.json")["subjects"]:
            say("  cycle/model.npz, scores.csv: the model of the motion (4D)")
    spent = sum(cost["cpu_seconds"] for _, cost in _costs(output))
    say(f"{spent:.0f} CPU s, as costs/*.json say")
    return not missing


def _costs(output: Path) -> Iterator[Tuple[str, Dict[str, Any]]]:
    for path in sorted((output / COSTS).glob("*.json")):
        yield path.stem, store.read_json(path)


def _say_what_would_run(
    folder: Path,
    output: Path,
    level: str,
    base: Path,
    found: Sequence[subjects.Subject],
    made: Dict[str, Any],
    say: Callable[[str], None],
) -> None:
    jobs = engine.planned(folder, level)
    failing = [one for one in found if one.failed]
    say(f"{counted(len(found), 'subject')} from {base}, for {output}:")
    for one in found[:LISTED]:
        words = one.failed or counted(len(one.files), "file")
        say(f"  {one.name}: {words}")
    if len(found) > LISTED:
        say(f"  and {len(found) - LISTED} more")
    if failing:
        say(f"{counted(len(failing), 'subject')} cannot be done")
    counts = Counter(job.rule for job in jobs)
    say(f"\n{counted(len(jobs), 'job')} would run{':' if jobs else ': everything is there'}")
    for rule, count in counts.items():
        say(f"  {rule}: {count}")
    seconds, words = _reckoned(output, jobs, base, found, made)
    if jobs:
        say(f"about {seconds:.0f} CPU s ({words})")


def _reckoned(
    output: Path,
    jobs: List[engine.Planned],
    base: Path,
    found: Sequence[subjects.Subject],
    made: Dict[str, Any],
) -> Tuple[float, str]:
    """CPU seconds, and where the figures are from."""
    spent: Dict[str, List[float]] = {}
    for name, cost in _costs(output):
        step = name.split("-")[0]
        spent.setdefault(step, []).append(cost["cpu_seconds"] / max(1, cost["count"]))
    phases = _phases(base, found)
    seconds = 0.0
    own = False
    for job in jobs:
        size = made["chunks"].get(job.of, 0) if job.rule in PER_PHASE else 0
        if job.rule in ("import", "landmarks") and job.rule in spent:
            seconds += size * phases * sum(spent[job.rule]) / len(spent[job.rule])
            own = True
            continue
        if job.rule in PER_PHASE:
            seconds += size * (PER_SUBJECT[job.rule] + phases * PER_PHASE[job.rule])
        elif job.rule == "atlas":
            seconds += PER_SUBJECT["atlas"] * len([1 for one in found if not one.failed][:200])
        seconds += PER_JOB
    source = "this study's own jobs, costs/" if own else "figures of docs/cohorts.md"
    return seconds, f"{phases:.3g} phases a subject; by {source}"


def _phases(base: Path, found: Sequence[subjects.Subject]) -> float:
    """Of a subject, on average; 4D files are looked into, some of them."""
    fit = [one for one in found if not one.failed]
    if not fit:
        return 0.0
    picked = [fit[i * len(fit) // min(len(fit), SAMPLED)] for i in range(min(len(fit), SAMPLED))]
    return sum(sum(_phases_in(base / name) for name in one.files) for one in picked) / len(picked)


def _phases_in(path: Path) -> int:
    """Of a NIfTI file what its header says; 1 for others."""
    name = path.name.lower()
    if not files.is_label_volume(path) or not name.endswith((".nii", ".nii.gz", ".hdr")):
        return 1
    try:
        with gzip.open(path) if name.endswith(".gz") else open(path, "rb") as file:
            header = file.read(56)
    except OSError:
        return 1
    order = "little" if int.from_bytes(header[:4], "little") in (348, 540) else "big"
    count = int.from_bytes(header[48:50], order)
    return count if int.from_bytes(header[40:42], order) >= 4 and 0 < count < 10000 else 1
