# SPDX-License-Identifier: GPL-3.0-only
"""Label volumes as NIfTI files."""

from __future__ import annotations

import gzip
import struct
from pathlib import Path

import numpy as np


def write_nifti(path, labels: np.ndarray, affine: np.ndarray, seconds: float = 0.0) -> None:
    """NIfTI-1 (.nii or .nii.gz): labels (x, y, z) or (x, y, z, time) of bytes; affine (4, 4):
    indices to RAS in mm; seconds per phase."""
    labels = np.asarray(labels, np.uint8)
    shape = (labels.shape + (1,))[:4]
    spacing = np.linalg.norm(affine[:3, :3], axis=0)
    header = bytearray(348)
    struct.pack_into("<i", header, 0, 348)
    struct.pack_into("<8h", header, 40, labels.ndim, *shape, 1, 1, 1)
    struct.pack_into("<hh", header, 70, 2, 8)  # bytes
    struct.pack_into("<8f", header, 76, 1, *spacing, seconds, 1, 1, 1)
    struct.pack_into("<f", header, 108, 352)  # where the voxels begin
    struct.pack_into("<f", header, 112, 1)
    header[123] = 2 | 8  # mm, seconds
    struct.pack_into("<hh", header, 252, 0, 1)  # the affine is the sform, in the scanner's frame
    struct.pack_into("<12f", header, 280, *np.asarray(affine, float)[:3].ravel())
    header[344:348] = b"n+1\0"
    content = bytes(header) + bytes(4) + labels.tobytes(order="F")
    path = Path(path)
    path.write_bytes(
        gzip.compress(content, mtime=0) if path.name.lower().endswith(".gz") else content
    )
