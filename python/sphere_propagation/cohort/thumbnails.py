# SPDX-License-Identifier: GPL-3.0-only
"""Small grey pictures of shapes that correspond, a millisecond or two each: thousands of them are
drawn where starting a renderer would take as long as a hundred.

Points that lie evenly on all faces are projected, nearest last: what is drawn last is seen.
"""

from __future__ import annotations

import struct
import zlib
from typing import List, Sequence

import numpy as np

from ..views import upright
from .merging import aligned

SIZE = 72  # pixels, across and down
PER_PIXEL = 5.0  # points of the shape that is in the middle of all
MARGIN = 1.3  # how much larger than the mean a shape may be
LIGHT = np.array([-0.4, 0.55, 0.73])
PAPER, DARK, BRIGHT = 255, 70, 225


class Studio:
    """mean: (landmarks, 3), the shape that all are laid on and that chooses side and scale."""

    def __init__(self, mean: np.ndarray, faces: np.ndarray, size: int = SIZE):
        self.size = size
        self._faces = np.asarray(faces, np.int64)
        self._mean = np.asarray(mean, float) - np.mean(mean, 0)
        self._rotation = upright(self._mean)
        seen = self._mean @ self._rotation.T
        self._middle = (seen.min(0) + seen.max(0)) / 2
        self._scale = size / (2 * MARGIN * np.abs(seen - self._middle)[:, :2].max())
        self._weights = self._on_faces(seen)

    def _on_faces(self, seen: np.ndarray) -> np.ndarray:
        """Places in a triangle, (points, 3): so many that the largest faces have no holes."""
        a, b, c = (seen[corner] for corner in self._faces.T)
        areas = np.linalg.norm(np.cross(b - a, c - a), axis=1) / 2 * self._scale**2
        steps = max(1, int(np.ceil(np.sqrt(PER_PIXEL * np.quantile(areas, 0.9)))))
        i, j = np.divmod(np.arange(steps * steps), steps)
        keep = i + j < steps
        u, v = (i[keep] + 1 / 3) / steps, (j[keep] + 1 / 3) / steps
        i, j = i[keep][(i + j)[keep] < steps - 1], j[keep][(i + j)[keep] < steps - 1]
        u, v = np.r_[u, (i + 2 / 3) / steps], np.r_[v, (j + 2 / 3) / steps]
        return np.stack([1 - u - v, u, v], 1).astype(np.float32)

    def picture(self, points: np.ndarray) -> np.ndarray:
        """(size, size) bytes. points: (landmarks, 3), wherever they lie."""
        laid = aligned(np.reshape(points, (1, -1, 3)), self._mean, "Rigid")[0]
        seen = ((laid @ self._rotation.T - self._middle) * self._scale).astype(np.float32)
        corners = seen[self._faces]  # (faces, 3, 3)
        normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        length = np.sqrt((normals**2).sum(1))
        shown = normals[:, 2] > 0
        corners, normals, length = corners[shown], normals[shown], length[shown]
        light = np.clip(normals @ (LIGHT / np.linalg.norm(LIGHT)) / np.maximum(length, 1e-12), 0, 1)
        grey = (DARK + (BRIGHT - DARK) * light).astype(np.uint8)
        image = np.full(self.size * self.size, PAPER, np.uint8)
        nearest = np.argsort(corners[:, :, 2].sum(1), kind="stable")  # the farthest face first
        corners, grey = corners[nearest], grey[nearest]
        half = self.size / 2
        x = np.floor(corners[:, :, 0] @ self._weights.T + half).astype(np.int32)
        y = np.floor(half - corners[:, :, 1] @ self._weights.T).astype(np.int32)
        inside = (x >= 0) & (x < self.size) & (y >= 0) & (y < self.size)
        image[(y * self.size + x)[inside]] = np.broadcast_to(grey[:, None], x.shape)[inside]
        return image.reshape(self.size, self.size)


def sheet(pictures: Sequence[np.ndarray], columns: int) -> np.ndarray:
    """All in one image, row by row."""
    size = pictures[0].shape[0]
    rows = -(-len(pictures) // columns)
    image = np.full((rows * size, columns * size), PAPER, np.uint8)
    for k, picture in enumerate(pictures):
        y, x = divmod(k, columns)
        image[y * size : (y + 1) * size, x * size : (x + 1) * size] = picture
    return image


def png(image: np.ndarray) -> bytes:
    """A grey image as a file."""
    height, width = image.shape
    lines = np.zeros((height, width + 1), np.uint8)  # each begins with its filter: none
    lines[:, 1:] = image
    parts: List[bytes] = [b"\x89PNG\r\n\x1a\n"]
    for kind, data in (
        (b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 0, 0, 0, 0)),
        (b"IDAT", zlib.compress(lines.tobytes(), 6)),
        (b"IEND", b""),
    ):
        parts += [struct.pack(">I", len(data)), kind, data]
        parts.append(struct.pack(">I", zlib.crc32(kind + data)))
    return b"".join(parts)
