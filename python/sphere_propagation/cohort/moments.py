# SPDX-License-Identifier: GPL-3.0-only
"""Count, mean and scatter of rows that are never all held: T. F. Chan, G. H. Golub, R. J. LeVeque,
Updating formulae and a pairwise algorithm for computing sample variances, 1979, in its form for
vectors.

The scatter is kept as a factor F with F^T F = scatter while that has few rows: exact, and cheaper
for few shapes than the matrix. Beyond RANK rows, or as many as there are
coordinates, it becomes the matrix where that is small enough
(WIDEST coordinates); where it is not, the factor is cut down to RANK rows by its singular value
decomposition, and `lost` is the sum of squares that went: no eigenvalue of the scatter is off by
more.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Dict, Iterable, Optional, Tuple

import numpy as np

from . import store

RANK = 1000
WIDEST = 6006  # coordinates (2002 landmarks): a matrix of 289 MB


@dataclass(frozen=True, eq=False)
class Moments:
    """count rows with this mean; exactly one of factor (r, d) and scatter (d, d)."""

    count: int
    mean: np.ndarray
    factor: Optional[np.ndarray] = None
    scatter: Optional[np.ndarray] = None
    lost: float = 0.0

    @classmethod
    def of(cls, rows: np.ndarray, rank: int = RANK, widest: int = WIDEST) -> Moments:
        """Of rows that are at hand."""
        rows = np.asarray(rows, float)
        if not len(rows):
            return cls(0, np.zeros(rows.shape[1]), np.zeros((0, rows.shape[1])))
        mean = rows.mean(0)
        return _reduced(cls(len(rows), mean, rows - mean), rank, widest)

    def plus(self, other: Moments, rank: int = RANK, widest: int = WIDEST) -> Moments:
        """Of the rows of both."""
        if not self.count or not other.count:
            return other if not self.count else self
        count = self.count + other.count
        delta = other.mean - self.mean
        mean = self.mean + delta * (other.count / count)
        between = np.sqrt(self.count * (other.count / count)) * delta
        lost = self.lost + other.lost
        if self.factor is not None and other.factor is not None:
            factor = np.concatenate([self.factor, other.factor, between[None]])
            return _reduced(Moments(count, mean, factor, lost=lost), rank, widest)
        scatter = self.as_matrix() + other.as_matrix()
        scatter += np.outer(between, between)
        return Moments(count, mean, scatter=scatter, lost=lost)

    def as_matrix(self) -> np.ndarray:
        return self.scatter if self.factor is None else self.factor.T @ self.factor

    def principal(self, most: int) -> Tuple[np.ndarray, np.ndarray, float]:
        """Variances (divisor count - 1) in falling order, directions (k, d) with the sign that
        makes their largest coordinate positive, and the total variance. Directions without variance
        are left out."""
        divisor = max(1, self.count - 1)
        if self.factor is not None:
            _, singular, directions = np.linalg.svd(self.factor, full_matrices=False)
            values = singular**2 / divisor
            total = float((self.factor**2).sum() + self.lost) / divisor
        else:
            values, vectors = np.linalg.eigh(self.scatter)
            values, directions = values[::-1] / divisor, vectors[:, ::-1].T
            total = float(np.trace(self.scatter) + self.lost) / divisor
        floor = 1e-12 * (values[0] if len(values) else 0.0)
        kept = min(most, self.count - 1, int((values > floor).sum()))
        kept = max(0, kept)
        directions = directions[:kept].copy()
        largest = np.abs(directions).argmax(1)
        directions *= np.where(directions[np.arange(kept), largest] < 0, -1.0, 1.0)[:, None]
        return values[:kept].copy(), directions, total


def _reduced(moments: Moments, rank: int, widest: int) -> Moments:
    factor = moments.factor
    rank = min(rank, factor.shape[1])
    if len(factor) <= rank:
        return moments
    if factor.shape[1] <= widest:
        return Moments(moments.count, moments.mean, scatter=factor.T @ factor, lost=moments.lost)
    _, singular, directions = np.linalg.svd(factor, full_matrices=False)
    lost = moments.lost + float((singular[rank:] ** 2).sum())
    kept = singular[:rank, None] * directions[:rank]
    return Moments(moments.count, moments.mean, kept, lost=lost)


def merged(these: Iterable[Moments]) -> Moments:
    """All of them, one after the other."""
    whole: Optional[Moments] = None
    for one in these:
        whole = one if whole is None else whole.plus(one)
    if whole is None:
        raise ValueError
    return whole


def write(path: Path, moments: Moments, **more: np.ndarray) -> None:
    arrays: Dict[str, np.ndarray] = {
        "count": np.int64(moments.count),
        "mean": moments.mean,
        "lost": np.float64(moments.lost),
    }
    for name in ("factor", "scatter"):
        if getattr(moments, name) is not None:
            arrays[name] = getattr(moments, name)
    store.write_arrays(path, {**arrays, **more})


def read(path: Path) -> Moments:
    found = store.read_arrays(path)
    return Moments(
        int(found["count"]),
        found["mean"],
        found.get("factor"),
        found.get("scatter"),
        float(found["lost"]),
    )
