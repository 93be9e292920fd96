# SPDX-License-Identifier: GPL-3.0-only
"""Files of a study: written whole or not at all, the same bytes for the same content."""

from __future__ import annotations

import io
import json
import os
import zipfile
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Dict, Iterable, Iterator, List, Mapping

import numpy as np

from ..digest import digest
from ..errors import FileError

OF_STEPS = ("plan", "surfaces", "landmarks", "moments", "model", "scores", "cycle", "costs")
END_OF_ZIP = 22  # bytes, where no remark follows
EARLIEST = (1980, 1, 1, 0, 0, 0)  # that zip knows: files must not differ by the time


@contextmanager
def whole(path: Path) -> Iterator[Path]:
    """A name to write to; what is there in the end takes the place of `path`, at once."""
    path.parent.mkdir(parents=True, exist_ok=True)
    part = path.with_name(f".{path.name}.{os.getpid()}.part")
    try:
        yield part
        with open(part, "rb") as file:
            os.fsync(file.fileno())
        os.replace(part, path)
    finally:
        part.unlink(missing_ok=True)


def text_of(content: Any) -> str:
    """As JSON; the same content is the same text."""
    return json.dumps(content, indent=1, sort_keys=True, ensure_ascii=False) + "\n"


def write_json(path: Path, content: Any) -> None:
    write_text(path, text_of(content))


def write_text(path: Path, text: str) -> None:
    with whole(path) as part:
        part.write_text(text, encoding="utf-8")


def write_if_changed(path: Path, content: Any) -> bool:
    """As write_json, where it says something else; the engine goes by the time of files."""
    text = text_of(content)
    if path.is_file() and path.read_text(encoding="utf-8") == text:
        return False
    write_text(path, text)
    return True


def read_json(path: Path) -> Any:
    try:
        return json.loads(path.read_text(encoding="utf-8"))
    except ValueError as error:
        raise _unreadable(path, error) from error


def _unreadable(path: Path, error: Exception) -> FileError:
    return FileError(
        f"{path.resolve()} cannot be read ({error}). Delete it: the same command makes it again."
    )


def damaged(folder: Path) -> List[Path]:
    """The files of a study that are cut off, as copies of a study or a full disk leave them."""
    found = [folder / "atlas.npz", folder / "atlas.json"]
    for name in OF_STEPS:
        found += sorted((folder / name).rglob("*.*"))
    return [
        path
        for path in found
        if path.is_file() and not path.name.startswith(".") and not _is_whole(path)
    ]


def _is_whole(path: Path) -> bool:
    """By its end: a thousand archives of thousands of arrays take no time."""
    if path.suffix == ".npy":
        try:
            np.load(path, mmap_mode="r")
        except (ValueError, EOFError):
            return False
        return True
    with open(path, "rb") as file:
        file.seek(max(0, path.stat().st_size - END_OF_ZIP))
        end = file.read()
    if path.suffix == ".json":
        return end.endswith(b"}\n")
    return end.startswith(b"PK\x05\x06") if path.suffix == ".npz" else bool(end)


def origin(plan: Mapping[str, Any], inputs: Iterable[Path]) -> Dict[str, Any]:
    """What an output says of itself: its step's plan, and the digests of what it was made from."""
    return {
        **{key: plan[key] for key in ("step", "version", "parameters")},
        "inputs": {path.as_posix(): digest(path) for path in inputs},
    }


def as_array(said: Mapping[str, Any]) -> np.ndarray:
    """For archives: its JSON."""
    return np.array(text_of(said))


def sweep(folder: Path) -> None:
    """Takes away what writers that were killed have left, where none is at work."""
    for part in folder.rglob(".*.part"):
        part.unlink(missing_ok=True)


def figure(value: float) -> float:
    """As figures are kept: nine digits, of which nobody reads more."""
    return float(f"{float(value):.9g}")


class Archive:
    """An .npz file that is written array by array, so that only one of them is held."""

    def __init__(self, path: Path):
        self._zip = zipfile.ZipFile(path, "w", zipfile.ZIP_STORED, allowZip64=True)

    def add(self, name: str, array: np.ndarray) -> None:
        entry = zipfile.ZipInfo(f"{name}.npy", EARLIEST)
        with self._zip.open(entry, "w", force_zip64=True) as file:
            held = io.BytesIO()
            np.lib.format.write_array(held, np.asarray(array, order="C"), allow_pickle=False)
            file.write(held.getbuffer())

    def close(self) -> None:
        self._zip.close()


@contextmanager
def archive(path: Path) -> Iterator[Archive]:
    """Takes the place of `path` when all is in it."""
    with whole(path) as part:
        made = Archive(part)
        try:
            yield made
        finally:
            made.close()


def write_arrays(path: Path, arrays: Mapping[str, np.ndarray]) -> None:
    with archive(path) as made:
        for name, array in arrays.items():
            made.add(name, array)


def read_arrays(path: Path) -> Dict[str, np.ndarray]:
    try:
        with np.load(path, allow_pickle=False) as found:
            return {name: found[name] for name in found.files}
    except (zipfile.BadZipFile, ValueError, EOFError) as error:
        raise _unreadable(path, error) from error


class Rows:
    """A .npy file of rows of one length, written as they come: their number is known in the end."""

    HEADER = 128  # bytes; numpy's own header is padded to these

    def __init__(self, path: Path, width: int, kind: str):
        self._path, self.width, self.kind, self.count = path, width, np.dtype(kind), 0
        self._file = open(path, "wb")  # noqa: SIM115 - closed by close()
        self._file.write(b" " * self.HEADER)

    def add(self, rows: np.ndarray) -> None:
        rows = np.ascontiguousarray(rows, self.kind).reshape(-1, self.width)
        self._file.write(rows.tobytes())
        self.count += len(rows)

    def close(self) -> None:
        words = f"{{'descr': {self.kind.str!r}, 'fortran_order': False, "
        words += f"'shape': ({self.count}, {self.width}), }}"
        begin = b"\x93NUMPY\x01\x00" + (self.HEADER - 10).to_bytes(2, "little")
        self._file.seek(0)
        self._file.write(begin + words.encode().ljust(self.HEADER - 11) + b"\n")
        self._file.close()


@contextmanager
def rows(path: Path, width: int, kind: str = "<f4") -> Iterator[Rows]:
    """Takes the place of `path` when all is in it."""
    with whole(path) as part:
        made = Rows(part, width, kind)
        try:
            yield made
        finally:
            made.close()
