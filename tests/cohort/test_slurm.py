# SPDX-License-Identifier: GPL-3.0-only
"""A study on a cluster that loses a job and its daemons comes to the bits of an undisturbed one on
this machine."""

from __future__ import annotations

import contextlib
import csv
import hashlib
import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Callable, Dict, Iterable, List

import numpy as np
from conftest import CHUNK, PHASES, SUBJECTS

PROFILE = Path(__file__).with_name("profile")
PATIENCE = 1800  # seconds, on machines that have other things to do
NOT_RESULTS = ("costs", "logs", ".snakemake", ".lock")


def cohort(*words) -> List[str]:
    return [sys.executable, "-m", "sphere_propagation", "cohort", *map(str, words)]


def asked(*words) -> str:
    """What one of Slurm's commands says; nothing while the controller is away."""
    return subprocess.run(words, capture_output=True, text=True, check=False).stdout


def until(condition: Callable[[], object], what: str, run: subprocess.Popen) -> object:
    """The condition's value, once it is true; the run must be at work meanwhile."""
    limit = time.monotonic() + PATIENCE
    while time.monotonic() < limit:
        found = condition()
        if found:
            return found
        assert run.poll() is None, f"the run ended before {what}"
        time.sleep(0.2)
    raise AssertionError(f"{what} did not come")


def running(rule: str) -> List[str]:
    """Numbers of jobs of a rule that run now."""
    lines = asked("squeue", "-h", "-t", "R", "-o", "%i %k").splitlines()
    return [line.split()[0] for line in lines if f"rule_{rule}" in line]


def state(job: str) -> str:
    found = re.search(r"JobState=(\w+)", asked("scontrol", "show", "job", job))
    return found[1] if found else ""


def step_of(job: str) -> List[int]:
    """The processes of a job that do its step; none as long as Snakemake is on its way to it."""
    found = []
    for folder in Path("/proc").glob("[0-9]*"):
        try:
            words = (folder / "cmdline").read_bytes().split(b"\0")
            settings = (folder / "environ").read_bytes().split(b"\0")
        except OSError:  # it has ended
            continue
        if (
            words[1:3] == [b"-m", b"sphere_propagation.cohort"]
            and f"SLURM_JOB_ID={job}".encode() in settings
        ):
            found.append(int(folder.name))
    return found


def kill(processes: Iterable[int]) -> None:
    for process in processes:
        with contextlib.suppress(ProcessLookupError):
            os.kill(process, signal.SIGKILL)


def killed(pid_file: Path) -> None:
    process = int(pid_file.read_text())
    kill([process])
    while Path(f"/proc/{process}").exists():
        time.sleep(0.05)


def is_up() -> bool:
    return asked("sinfo", "-h", "-o", "%T").strip() in ("idle", "mixed", "allocated")


def tended(run: subprocess.Popen) -> int:
    """How the run ends, on a cluster that is looked after: a controller that was killed may give a
    job to a node that has it already, whereupon the node is drained and the job held, until
    somebody says that all is well."""
    limit = time.monotonic() + PATIENCE
    while run.poll() is None and time.monotonic() < limit:
        if "drain" in asked("sinfo", "-h", "-o", "%T"):
            asked("scontrol", "update", "NodeName=loopback", "State=RESUME")
        for line in asked("squeue", "-h", "-t", "PD", "-o", "%i %r").splitlines():
            if "held" in line:
                asked("scontrol", "release", line.split()[0])
        time.sleep(2)
    return run.wait(1)


def results(folder: Path) -> Dict[str, str]:
    """Every file of a study's output that says what came out, by its SHA-256."""
    found = {}
    for path in sorted(folder.rglob("*")):
        name = path.relative_to(folder)
        if path.is_file() and name.parts[0] not in NOT_RESULTS:
            found[name.as_posix()] = hashlib.sha256(path.read_bytes()).hexdigest()
    return found


def test_a_cluster_that_loses_a_job_and_daemons_comes_to_the_same_bits(cluster, subjects, tmp_path):
    here, there = tmp_path / "cores", tmp_path / "slurm"
    study = ("--config", subjects.parent / "study.toml")
    subprocess.run(cohort(subjects, here, "group", "--cores", 2, *study), check=True)
    with subprocess.Popen(cohort(subjects, there, "group", "--profile", PROFILE, *study)) as run:
        # A job in the middle of its work is killed, as one that takes too much memory is.
        lost = until(lambda: running("landmarks"), "a job with landmarks", run)[0]
        kill(until(lambda: step_of(lost), "its step", run))
        until(lambda: state(lost) == "FAILED", "its end", run)
        # Then the daemon of the node, which leaves its jobs alone, and comes back ...
        until(lambda: running("landmarks"), "another job with landmarks", run)
        killed(cluster / "slurmd.pid")
        time.sleep(1)
        subprocess.run(["slurmd"], check=True)
        until(is_up, "the node", run)
        # ... and the controller, which remembers its jobs.
        until(lambda: running("landmarks"), "a job with landmarks after that", run)
        killed(cluster / "slurmctld.pid")
        time.sleep(1)
        subprocess.run(["slurmctld"], check=True)
        assert tended(run) == 0

    # What the lost job is called now, nobody promises: a controller that was killed goes on from
    # what it had written, and may have given the job to a node again.
    jobs = re.split(r"\n(?=JobId=)", asked("scontrol", "show", "jobs"))
    # Every step ran there, at least once, and said how much memory it wants; what follows on the
    # landmarks of few subjects is one job.
    rules = [re.search(r"Comment=rule_(\w+)", job)[1] for job in jobs]
    wanted = ["import_chunk", "atlas", "landmarks", "models"]
    assert all(any(rule.startswith(one) for rule in rules) for one in wanted), rules
    last = {rule for rule in rules if rule.startswith("models")}
    assert all(step in one for one in last for step in ("scatter", "scores", "cycle", "report"))
    assert all(re.search(r"TRES=.*mem=\d", job) for job in jobs)

    expected = results(here)
    assert (
        len([name for name in expected if name.startswith("landmarks/")]) == 2 * SUBJECTS // CHUNK
    )
    assert results(there) == expected
    with np.load(here / "model" / "model.npz") as model:
        assert int(model["shapes"]) == SUBJECTS * PHASES
    with open(here / "subjects.csv", newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == SUBJECTS
    assert {(row["status"], row["flipped_faces"]) for row in rows} == {("done", "0")}
