#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-only
"""Prints what the engine itself costs for a cohort: the whole graph of jobs of docs/cohorts.md with
steps that do nothing but leave their files.

    cohort.py [SUBJECTS [PHASES [SECONDS]]]

    SUBJECTS, PHASES    of the study (default 50,000 and 50)
    SECONDS             of CPU that a phase takes, to compare with (default: as in docs/cohorts.md)

CPU seconds of Snakemake: until the first job runs, until the last has ended, for a run that has
nothing to do, and of what each job on a cluster starts before its step. The overhead is all of
these as a share of the study's own CPU seconds; the ceiling of jobs at a time is where handing out
jobs, one after the other, would take 5 % of the time that they run.
"""

import os
import re
import subprocess
import sys
import tempfile
import time
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent / "python"))

from sphere_propagation.cohort import engine, plan  # noqa: E402
from sphere_propagation.cohort.study import checked  # noqa: E402
from sphere_propagation.cohort.subjects import Subject  # noqa: E402

SLOTS = 500  # jobs at a time, as the profile for Slurm has it
SECONDS_PER_PHASE = 0.2
STUB = """#!/bin/sh
case $1 in
  import) : >surfaces/$2.npz; : >surfaces/$2.json ;;
  atlas) : >atlas.npz; : >atlas.json ;;
  landmarks) : >landmarks/$2.npy; : >landmarks/$2.json ;;
  scatter) : >moments/0/$2.npz ;;
  merge) : >moments/$2/$3.npz ;;
  model) : >model/basis.npz ;;
  scores) : >scores/$2.npy; : >scores/$2_cycle.npy; : >scores/$2.json ;;
  cycle) : >cycle/model.npz; : >cycle/model.json; : >cycle/scores.csv ;;
  report) : >report.html; : >subjects.csv
    for name in model.npz model.csv model.json measures.csv explore.html; do : >model/$name; done ;;
esac
"""


def main() -> None:
    given = [float(word) for word in sys.argv[1:]]
    subjects, phases, each = (
        given[k] if k < len(given) else default
        for k, default in enumerate((50000, 50, SECONDS_PER_PHASE))
    )
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        began = time.process_time()
        made = planned(folder, int(subjects), int(phases))
        print(f"plan of {int(subjects)} subjects, {int(phases)} phases each:", end=" ")
        print(f"{len(made['chunks'])} chunks, {time.process_time() - began:.1f} CPU s")
        stub = folder / "stub"
        stub.write_text(STUB)
        stub.chmod(0o755)
        start, whole, jobs = run(folder, stub)
        print(f"until the first job runs:  {start:7.1f} CPU s")
        apiece = (whole - start) / jobs
        print(f"{jobs} jobs handed out:    {whole:7.1f} CPU s, {1000 * apiece:.0f} ms each")
        again, _, _ = run(folder, stub)
        print(f"nothing to do:             {again:7.1f} CPU s")
        inside = 2 * of_one_job(folder, stub, sorted(made["chunks"])[len(made["chunks"]) // 2])
        print(
            f"inside of a cluster's job: {inside:7.1f} CPU s, twice Snakemake's start for one job"
        )
    work = subjects * phases * each
    overhead = whole + jobs * inside
    print(
        f"the study itself at {each:g} s a phase: {work:.0f} CPU s ({work / 3600:.0f} core-hours)"
    )
    print(f"overhead: {100 * overhead / work:.2f} %")
    print(f"jobs at a time until handing them out takes 5 %: {0.05 * work / jobs / apiece:.0f}")


def planned(folder: Path, subjects: int, phases: int):
    """As the command plans; the files are not there, and nobody reads them."""
    people = [
        Subject(f"sub-{s:05d}", [f"sub-{s:05d}/phase_{k:02d}.ply" for k in range(phases)])
        for s in range(subjects)
    ]
    return plan.write(folder, checked({}), folder, people)


def words_for(stub: Path) -> list:
    words = engine.command("group", SLOTS, None)
    return [word if not word.startswith("step=") else f"step={stub}" for word in words]


def run(folder: Path, stub: Path):
    """CPU seconds of Snakemake until the first job and until the end; how many jobs there were."""
    begin, first, jobs = cpu_of_children(), None, 0
    with subprocess.Popen(
        words_for(stub), cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True
    ) as process:
        said = []
        for line in process.stdout:
            said.append(line)
            if first is None and re.match(r"(local)?rule \w+:", line):
                first = cpu_of(process.pid)
            jobs += bool(re.match(r"(local)?rule \w+:", line))
    if process.returncode:
        sys.exit("".join(said[-40:]))
    whole = cpu_of_children() - begin
    return (whole if first is None else first), whole, jobs


def of_one_job(folder: Path, stub: Path, chunk: str) -> float:
    """What a job of a cluster does before its step: Snakemake once more, for one target."""
    words = words_for(stub)
    words = words[: words.index("--")]
    words = [word for word in words if word not in ("--keep-going", "--rerun-incomplete")]
    words += ["--target-jobs", f"landmarks:chunk={chunk}", "--allowed-rules", "landmarks"]
    words += ["--mode", "subprocess", "--force", "--ignore-incomplete", "--quiet"]
    begin = cpu_of_children()
    done = subprocess.run(words, cwd=folder, capture_output=True, text=True, check=False)
    if done.returncode:
        sys.exit(done.stdout + done.stderr)
    return cpu_of_children() - begin


def cpu_of_children() -> float:
    used = os.times()
    return used.children_user + used.children_system


def cpu_of(process: int) -> float:
    fields = Path(f"/proc/{process}/stat").read_text().rsplit(") ", 1)[1].split()
    return sum(map(int, fields[11:13])) / os.sysconf("SC_CLK_TCK")


if __name__ == "__main__":
    main()
