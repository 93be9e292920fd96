# SPDX-License-Identifier: GPL-3.0-only
"""Label volumes as NIfTI files."""

from __future__ import annotations

import gzip
import struct

import numpy as np

from .errors import InputError
from .parameters import path_of, real_number

CODES = {"u1": 2, "i2": 4, "i4": 8, "f4": 16, "f8": 64, "i1": 256, "u2": 512, "u4": 768}
CODES.update({"i8": 1024, "u8": 1280})


def write_nifti(path, labels: np.ndarray, affine: np.ndarray, seconds: float = 0.0) -> None:
    """NIfTI-1 (.nii or .nii.gz): labels (x, y, z) or (x, y, z, time), as bytes where they are from
    0 to 255; affine (4, 4): indices to RAS in mm; seconds per phase."""
    labels, affine = np.asarray(labels), np.asarray(affine)
    seconds = real_number("seconds", seconds)
    if labels.dtype.kind not in "biuf" or labels.ndim not in (3, 4) or affine.shape != (4, 4):
        raise InputError(
            "A label volume is written from numbers of shape (x, y, z) or (x, y, z, time) and an "
            f"affine (4, 4), not from {labels.dtype} of shape {labels.shape} and {affine.shape}."
        )
    labels = _stored(labels)
    shape = (labels.shape + (1,))[:4]
    spacing = np.linalg.norm(affine[:3, :3], axis=0)
    header = bytearray(348)
    struct.pack_into("<i", header, 0, 348)
    struct.pack_into("<8h", header, 40, labels.ndim, *shape, 1, 1, 1)
    struct.pack_into("<hh", header, 70, CODES[labels.dtype.str[1:]], 8 * labels.itemsize)
    struct.pack_into("<8f", header, 76, 1, *spacing, seconds, 1, 1, 1)
    struct.pack_into("<f", header, 108, 352)  # where the voxels begin
    struct.pack_into("<f", header, 112, 1)
    header[123] = 2 | 8  # mm, seconds
    struct.pack_into("<hh", header, 252, 0, 1)  # the affine is the sform, in the scanner's frame
    struct.pack_into("<12f", header, 280, *np.asarray(affine, float)[:3].ravel())
    header[344:348] = b"n+1\0"
    content = bytes(header) + bytes(4) + labels.tobytes(order="F")
    path = path_of(path)
    path.write_bytes(
        gzip.compress(content, mtime=0) if path.name.lower().endswith(".gz") else content
    )


def _stored(labels: np.ndarray) -> np.ndarray:
    """The same numbers in a type that NIfTI has."""
    if labels.dtype.kind in "fc":
        whole = bool(np.isfinite(labels).all()) and np.array_equal(labels, np.floor(labels))
    else:
        whole = True
    if whole and (not labels.size or (labels.min() >= 0 and labels.max() <= 255)):
        return labels.astype(np.uint8)
    kind = {"f2": "f4", "f16": "f8"}.get(labels.dtype.str[1:], labels.dtype.str[1:])
    return labels.astype("<" + kind)
