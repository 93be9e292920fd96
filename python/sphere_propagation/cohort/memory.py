# SPDX-License-Identifier: GPL-3.0-only
"""What jobs ask the engine for, MB, reckoned from the files of their largest subject: a chunk has
one subject in memory at a time.

Measured (docs/cohorts.md): 95 MB are Python with the plugin; an import keeps 0.3 kB of a vertex and
5 bytes of a voxel, propagation 0.9 kB of a vertex; the atlas 1.6 kB of a vertex of its frames.
Asked for is about twice that, and more at every other attempt.
"""

from __future__ import annotations

import gzip
import struct
from pathlib import Path
from typing import Any, Dict, Mapping, NamedTuple, Sequence, Tuple, Union

from .. import files
from . import moments, store

OF_CHUNK = ("import", "landmarks")
LEAST = 600
OF_VERTEX, OF_FRAME, OF_VOXEL = 2e-3, 3e-3, 1e-5  # MB
BYTES_OF_VERTEX = 30.0  # at least, in a file: binary PLY has 12, and 13 for each of two faces
ZIPPED = 30.0  # voxels of a byte, where a header cannot be read


class Extent(NamedTuple):
    """Of a file: phases; voxels of all of them; vertices of their surfaces, about."""

    phases: int
    voxels: float
    vertices: float


def extent(path: Path, size: int) -> Extent:
    """size: in bytes. Of label volumes NIfTI says what is in it; of others the bytes tell."""
    if not files.is_label_volume(path):
        return Extent(1, 0.0, max(size, 0) / BYTES_OF_VERTEX)
    phases, voxels = header_of_nifti(path) or (1, ZIPPED * max(size, 0))
    # A surface that goes through the grid as the faces of its box do, of which there are three.
    return Extent(phases, phases * voxels, 2 * phases * voxels ** (2 / 3))


def of_chunk(base: Path, entries: Sequence[Mapping[str, Any]], done: Path) -> Dict[str, int]:
    """Of its import and its landmarks. entries: as the plan has them; done: what its import has
    left, where it has: then vertices are known."""
    sizes = [sum(max(file["bytes"], 0) for file in entry["files"]) for entry in entries]
    largest = entries[sizes.index(max(sizes))] if sizes else {"files": ()}
    found = [extent(base / file["file"], file["bytes"]) for file in largest["files"]]
    voxels, vertices = sum(one.voxels for one in found), sum(one.vertices for one in found)
    made = vertices
    if done.is_file():
        records = store.read_json(done)["subjects"]
        made = max((sum(one.get("vertices", ())) for one in records), default=0)
    return {
        "import": _whole(OF_VERTEX * vertices + OF_VOXEL * voxels),
        "landmarks": _whole(OF_VERTEX * made),
        "frame": _whole(OF_FRAME * vertices / max(1, sum(one.phases for one in found)), 0),
    }


def of_study(chunks: Mapping[str, Mapping[str, int]], at: Sequence[str], landmarks: int):
    """chunks: as of_chunk says; at: the chunk of each frame of the atlas."""
    wide = 3 * landmarks
    sums = wide * (wide if wide <= moments.WIDEST else 2 * moments.RANK)
    return {
        **{step: {chunk: of[step] for chunk, of in chunks.items()} for step in OF_CHUNK},
        "atlas": _whole(sum(chunks[chunk]["frame"] for chunk in at)),
        "sums": _whole(4 * 8e-6 * sums),
    }


def _whole(more: float, least: int = LEAST) -> int:
    return max(least, int(more + (least and LEAST / 2)) + 1)


def header_of_nifti(path: Path) -> Union[Tuple[()], Tuple[int, float]]:
    """Phases, and voxels of a phase as fine as its finest direction; nothing of other files."""
    name = path.name.lower()
    if not name.endswith((".nii", ".nii.gz", ".hdr", ".hdr.gz")):
        return ()
    try:
        with gzip.open(path) if name.endswith(".gz") else open(path, "rb") as file:
            header = file.read(108)
    except (OSError, EOFError):
        return ()
    order = "little" if int.from_bytes(header[:4], "little") in (348, 540) else "big"
    if len(header) < 108 or int.from_bytes(header[:4], order) != 348:
        return ()
    numbers = [int.from_bytes(header[i : i + 2], order) for i in range(40, 56, 2)]
    counts = [max(1, n) for n in numbers[1:4]]
    spacing = struct.unpack_from(f"{'<' if order == 'little' else '>'}3f", header, 80)
    voxels = float(counts[0] * counts[1] * counts[2])
    if all(1e-6 < step < 1e6 for step in spacing):
        voxels *= spacing[0] * spacing[1] * spacing[2] / min(spacing) ** 3
    phases = numbers[4] if numbers[0] >= 4 and 0 < numbers[4] < 10000 else 1
    return phases, voxels
