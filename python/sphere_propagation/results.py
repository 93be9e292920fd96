# SPDX-License-Identifier: GPL-3.0-only
"""The folder that a run leaves behind. It lists its files, so that the next run can take away what
this one made and nothing else."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Callable, Dict, Iterable, List, Optional, Sequence, Set

from .digest import digest as digest_of
from .errors import FileError, InputError

LIST = ".sphere-propagation.sha256"  # as sha256sum writes it; lies in the folder


def require_apart(inputs: Iterable, *outputs) -> None:
    """InputError where an output, a file or a folder, is an input, or a folder that one lies in:
    what is read would be replaced."""
    given = {_identity(Path(path)): path for path in inputs}
    for output in map(Path, outputs):
        if _identity(output) in given:
            raise InputError(
                f"{given[_identity(output)]} is to be read, and cannot be the output as well: "
                "choose another one."
            )
        if not output.is_dir():
            continue
        home = output.resolve()
        for path in map(Path, given.values()):
            # A link lies where it is, too.
            if home in path.resolve().parents or home in (path.parent.resolve() / "_").parents:
                raise InputError(f"{path} lies in the output folder {output}: choose another one.")


def _identity(path: Path):
    """The same for all names of a file."""
    try:
        found = path.stat()
    except OSError:
        return path.resolve()
    return found.st_dev, found.st_ino


def require_writable(folder: Path) -> None:
    """FileError where nothing can be written to a folder, or it cannot be made."""
    there = next((path for path in (folder, *folder.parents) if path.exists()), folder)
    if not os.access(there, os.W_OK | os.X_OK):
        raise FileError(f"Nothing can be written to {there}: choose another place (-o).")


class ResultFolder:
    """Writes files and lists them. The first one written takes the files of an earlier run away.

    What was changed since then, and what others put there, is never lost: it stays, and moves aside
    (name.bak) where its name is needed.
    """

    def __init__(self, folder):
        self.folder = Path(folder)
        self.kept: List[Path] = []  # of an earlier run but changed since, or in the way
        self._written: Optional[Set[Path]] = None  # None: nothing yet

    def create(self) -> None:
        """Makes the folder, so that what is wrong with it is said before there is something to
        write."""
        self.require_folder()
        self.folder.mkdir(parents=True, exist_ok=True)

    def require_folder(self) -> None:
        """InputError where a file has its name, or that of a folder above it; FileError where
        nothing can be written."""
        for path in (self.folder, *self.folder.parents):
            if path.exists() and not path.is_dir():
                raise InputError(
                    f"{path} is a file: results go into a folder, which is made where there is "
                    "none. Choose another name (-o)."
                )
        require_writable(self.folder)

    def write(self, name: str, writer: Callable[[Path], object]) -> Path:
        """Calls writer(path) for a file of that name (with / between folders) and lists it; returns
        the path."""
        return self.write_all([name], lambda paths: writer(paths[0]))[0]

    def write_all(
        self,
        names: Sequence[str],
        writer: Callable[[List[Path]], object],
        beside: Callable[[Path], Sequence[Path]] = lambda path: (),
    ) -> List[Path]:
        """The same for several files that are made together. beside: what the writer makes beside
        a file."""
        if self._written is None:
            self._clear()
            self._written = set()
        paths = [self.folder / name for name in names]
        for path in paths:
            path.parent.mkdir(parents=True, exist_ok=True)
            if path.exists() and path not in self._written:
                self._move_aside(path)
            self._written.add(path)
        try:
            writer(paths)
        finally:
            with open(self.folder / LIST, "a", encoding="utf-8") as file:
                for path in [*paths, *(more for made in paths for more in beside(made))]:
                    if path.is_file():  # half a file is ours, too
                        self._written.add(path)
                        name = path.relative_to(self.folder).as_posix()
                        file.write(f"{digest_of(path)}  {name}\n")
        return paths

    def _clear(self) -> None:
        self.create()
        folders: Set[Path] = set()
        for name, digest in self._listed().items():
            path = self.folder / name
            if not path.is_file() or path.is_symlink():
                continue
            if digest_of(path) != digest:
                self.kept.append(path)
                continue
            path.unlink()
            folders.update(parent for parent in path.parents if self.folder in parent.parents)
        for folder in sorted(folders, key=lambda folder: -len(folder.parts)):
            if not any(folder.iterdir()):
                folder.rmdir()
        (self.folder / LIST).write_text("", encoding="utf-8")

    def _move_aside(self, path: Path) -> None:
        aside = path.with_name(path.name + ".bak")
        number = 1
        while aside.exists():
            number += 1
            aside = path.with_name(f"{path.name}.bak{number}")
        path.rename(aside)
        self.kept = [kept for kept in self.kept if kept != path] + [aside]

    def _listed(self) -> Dict[str, str]:
        """Name -> digest of what an earlier run wrote, if it lies in this folder."""
        try:
            lines = (self.folder / LIST).read_text(encoding="utf-8").splitlines()
        except FileNotFoundError:
            return {}
        pairs = (line.split("  ", 1) for line in lines if "  " in line)
        home = self.folder.resolve()
        return {
            name: digest for digest, name in pairs if home in (self.folder / name).resolve().parents
        }
