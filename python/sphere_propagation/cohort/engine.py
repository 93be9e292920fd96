# SPDX-License-Identifier: GPL-3.0-only
"""Snakemake on a study's folder: its command line, and that one run at a time is at work there."""

from __future__ import annotations

import fcntl
import os
import re
import shlex
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
from contextlib import contextmanager
from functools import partial
from importlib.util import find_spec
from pathlib import Path
from typing import Callable, Iterator, List, NamedTuple, Optional, Sequence

from ..errors import InputError, SpherePropagationError
from .worker import die_with_parent

HERE = Path(__file__).resolve().parent
SNAKEFILE = HERE / "Snakefile"
PROFILES = HERE / "profiles"
LOCK = ".lock"
LEVELS = ("participant", "group")
NEEDED = ("snakemake", "snakemake_executor_plugin_slurm")
PROGRESS = re.compile(r"^(\d+) of (\d+) steps \((\d+)%\) done")
FAILED_LOG = re.compile(r"^\s+log: (\S+)")
SHOWN = 10  # lines of a log


class EngineError(SpherePropagationError):
    """Snakemake is missing, or a job of its failed for another reason than a subject."""


class Planned(NamedTuple):
    """A job that would run: its rule, and what it is of (a chunk, a block; empty)."""

    rule: str
    of: str


def require(profile: Optional[str] = None) -> None:
    """EngineError where Snakemake is missing, or its Slurm for our profile, with the line to
    type."""
    if sys.version_info < (3, 11):
        raise EngineError("cohort takes Python 3.11 or later, as Snakemake does.")
    if not _is_installed(NEEDED[0]):
        raise EngineError(
            "cohort runs its jobs through Snakemake, which is not installed: pip install "
            "'sphere-propagation[cohort]'"
        )
    if profile == "slurm" and not _is_installed(NEEDED[1]):
        raise EngineError(
            "Snakemake's plugin for Slurm is not installed: pip install "
            "'sphere-propagation[cohort]'"
        )


def _is_installed(name: str) -> bool:
    try:
        return find_spec(name) is not None
    except ValueError:  # somebody took it out of sys.modules
        return False


@contextmanager
def lock(output: Path) -> Iterator[int]:
    """InputError where another run is at work in the folder; let go of however this one ends."""
    path = output / LOCK
    file = open(path, "a+", encoding="utf-8")  # noqa: SIM115 - closed below
    try:
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError as error:
            file.seek(0)
            by = file.read().strip()
            raise InputError(
                f"Another run is at work in {output}{f' ({by})' if by else ''}: wait until it has "
                "ended, or choose another output folder."
            ) from error
        file.seek(0)
        file.truncate()
        file.write(f"process {os.getpid()} on {socket.gethostname()}\n")
        file.flush()
        yield file.fileno()
    finally:
        file.close()


def command(
    target: str, cores: Optional[int], profile: Optional[str], dry: bool = False
) -> List[str]:
    """Snakemake's command line, for a study's folder to be run in."""
    step = shlex.join([sys.executable, "-m", "sphere_propagation.cohort"])
    # Of a cluster's nodes nobody knows how many they have; what none has would wait for ever.
    threads = min(cores, 8) if cores and not profile else 2
    words = [
        sys.executable,
        "-m",
        "snakemake",
        "--snakefile",
        str(SNAKEFILE),
        "--nolock",  # ours is let go of when a run is killed
        "--rerun-incomplete",
        "--rerun-triggers",
        "mtime",
        "--keep-going",
        "--retries",
        "2",
        "--scheduler",
        "greedy",
    ]
    if profile:
        words += ["--profile", _profile(profile)]
        if cores:
            words += ["--jobs", str(cores)]
    else:
        words += ["--cores", str(cores)]
    words += ["--dry-run"] * dry
    words += [
        "--config",
        f"step={step}",
        f"atlas_threads={threads}",
        f"cluster={int(bool(profile))}",
    ]
    return [*words, "--", target]


def _profile(name: str) -> str:
    """Ours of this name, or a folder from where the user stands (the engine runs elsewhere), or
    what Snakemake knows by it."""
    for folder in (PROFILES / name, Path(name)):
        if folder.is_dir():
            return str(folder.resolve())
    return name


def run(
    output: Path,
    target: str,
    cores: Optional[int],
    profile: Optional[str],
    say: Callable[[str], None],
) -> None:
    """EngineError, with the ends of the logs, where a job fails."""
    failed: List[str] = []
    words = command(target, cores, profile)
    with subprocess.Popen(
        words,
        cwd=output,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        errors="replace",
        preexec_fn=partial(die_with_parent, os.getpid()),  # noqa: PLW1509 - no thread yet
    ) as process:
        tail: List[str] = []
        try:
            for line in process.stdout:
                progress, log = PROGRESS.match(line), FAILED_LOG.match(line)
                if progress:
                    done, jobs = int(progress[1]), int(progress[2]) - 1  # one stands for all
                    if done <= jobs:
                        say(f"{done} of {jobs} jobs done")
                elif log and "(check log file" in line:
                    failed.append(log[1])
                tail = [*tail, line.rstrip()][-40:]
        except KeyboardInterrupt:
            process.send_signal(signal.SIGINT)
            process.wait()
            raise
        code = process.wait()
    if code:
        raise EngineError(
            f"The study is not finished: {len(set(failed)) or 'some'} job(s) failed. The same "
            f"command goes on where it ended.\n{_ends_of(output, failed, tail)}"
        )


def _ends_of(output: Path, logs: Sequence[str], tail: Sequence[str]) -> str:
    """Of the jobs' logs, of the engine's where it names none."""
    shown = []
    for name in dict.fromkeys(logs):
        path = output / name
        text = path.read_text(errors="replace").strip() if path.is_file() else ""
        end = "\n".join(text.splitlines()[-SHOWN:])
        shown.append(f"{name}:\n{end}" if end else f"{name} is empty: the job was ended")
    return "\n".join(shown[:3] or tail[-SHOWN:])


def planned(output: Path, target: str) -> List[Planned]:
    """What would run, without running it."""
    words = command(target, 1, None, dry=True)
    ended = subprocess.run(
        words,
        cwd=output,
        capture_output=True,
        text=True,
        errors="replace",
        check=False,
    )
    if ended.returncode:
        raise EngineError((ended.stdout + ended.stderr).strip()[-2000:])
    jobs: List[Planned] = []
    rule = ""
    for line in (ended.stdout + ended.stderr).splitlines():
        found = re.match(r"^(?:local)?rule (\w+):", line)
        if found:
            rule = found[1]
            if rule in ("atlas", "model", "cycle", "report"):
                jobs.append(Planned(rule, ""))
        wild = re.match(r"^\s+wildcards: .*?(?:chunk|block)=(\d+)", line)
        if wild and rule:
            jobs.append(Planned("import" if rule == "import_chunk" else rule, wild[1]))
    return jobs


@contextmanager
def shadow(output: Path, without: Sequence[Path] = ()) -> Iterator[Path]:
    """A folder to plan in as if it were the output, which stays as it is, and lacked some files."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for path in output.iterdir() if output.is_dir() else ():
            if path.name == "plan":
                left = shutil.ignore_patterns(*(one.name for one in without if path in one.parents))
                shutil.copytree(path, folder / "plan", ignore=left)
            elif path.name == ".snakemake":
                (folder / ".snakemake").mkdir()
                for part in ("metadata", "incomplete"):
                    if (path / part).is_dir():
                        shutil.copytree(path / part, folder / ".snakemake" / part)
            elif path.name != LOCK:
                _link(path, folder / path.name, without)
        yield folder


def _link(path: Path, place: Path, without: Sequence[Path]) -> None:
    if any(path in one.parents for one in without):
        place.mkdir()
        for below in path.iterdir():
            _link(below, place / below.name, without)
    elif path not in without:
        place.symlink_to(path.resolve())
