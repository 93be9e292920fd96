# SPDX-License-Identifier: GPL-3.0-only
"""The truth of the phantom: where each material point of the beating ventricle is at each phase.

The motion is the plugin's (vcg_ext/volume/ventricle_phantom.h), written again in numpy with the
same constants and the same random numbers. Landmarks are judged against this function and not
against the per-vertex attribute `material_coordinate`: that one is known at the layers' vertices
only, which lie up to half a voxel off the ventricle's own surface; the function is exact
everywhere.
"""

from __future__ import annotations

from typing import NamedTuple, Tuple

import numpy as np

from .errors import InputError
from .parameters import real_number, require_choice, whole_number
from .surface import array_of

# u at which the surface ends for measurements: above, the base is cut where the voxels end
RIM = 0.93
TRUSTED = 1.2  # mm: a landmark farther from that surface is not on it


SCAN_SPACING = (1.4, 1.4, 10.0)  # mm: that of a clinical cine scan


class MaterialPoints(NamedTuple):
    """Coordinates of tissue: u from apex 0 to base 1, theta round the long axis, m from inner 0 to
    outer surface 1."""

    u: np.ndarray
    theta: np.ndarray
    m: np.ndarray
    distance: np.ndarray  # mm, from the points asked for


class Ventricle:
    def __init__(self, part: str = "Cavity", phases: int = 25, seed: int = 0, twist: float = 0.0):
        """Twist in degrees. `part` says which sheets are its surface: Cavity the inner one, Wall
        both."""
        require_choice("part", part, ("Cavity", "Wall"))
        phases, seed = whole_number("phases", phases), whole_number("seed", seed)
        twist = real_number("twist", twist)
        if phases < 1 or not 0 <= seed < 2**32:
            raise InputError("A phantom needs a phase or more, and a seed from 0 to 2^32 - 1.")
        draw = np.random.RandomState(seed)  # the order of the draws matters
        self.phases, self.twist = phases, np.radians(twist)
        self.sheets = (0.0,) if part == "Cavity" else (0.0, 1.0)
        self.width = 25.0
        self.depth = 25.0 * (1 + 0.1 * draw.randn())
        self.length = 80.0 * (1 + 0.05 * draw.randn())
        self.infarct_theta = 2 * np.pi * draw.rand()
        self.infarct_u = 0.35 + 0.3 * draw.rand()
        self.bulges = 0.05 * draw.randn(4)
        self.bend = 6 * draw.randn()

    def contraction(self, phase: float) -> float:
        """From 0 at end-diastole (phase 0) to 1 at end-systole (0.35 of the cycle)."""
        time = phase / self.phases
        return (
            np.sin(np.pi * time / 0.7) ** 2
            if time < 0.35
            else np.cos(np.pi * (time - 0.35) / 1.3) ** 2
        )

    def position(self, u, theta, m, phase: float) -> np.ndarray:
        """Where material points are, (..., 3) in mm; u, theta and m broadcast."""
        contraction = self.contraction(phase)
        away = np.remainder(theta - self.infarct_theta + np.pi, 2 * np.pi) - np.pi
        infarct = np.exp(-0.5 * (away / 0.5) ** 2 - 0.5 * ((u - self.infarct_u) / 0.18) ** 2)
        local = contraction * (1 - 0.9 * infarct)
        radius = (1 - 0.36 * local) * (
            1
            + self.bulges[0] * np.cos(2 * theta)
            + u * (self.bulges[1] * np.sin(3 * theta) + self.bulges[2] * np.cos(theta))
        )
        outward = 9 * (1 + 0.45 * local) * m
        phi, turned = 0.625 * np.pi * u, theta + self.twist * contraction * (1 - u)
        x = (self.width * radius + outward) * np.sin(phi) * np.cos(turned)
        y = (self.depth * radius + outward) * np.sin(phi) * np.sin(turned)
        z = -(0.55 * self.length * (1 - 0.16 * contraction) + 0.9 * outward) * np.cos(phi)
        x = x + self.bend * np.sin(np.pi * (z / self.length + 0.6) / 1.2)
        return np.stack(np.broadcast_arrays(x, y, z), -1)

    def scan(
        self, spacing: Tuple[float, float, float] = SCAN_SPACING
    ) -> Tuple[np.ndarray, np.ndarray]:
        """What a scanner and somebody who draws outlines leave of it: labels (x, y, z, phase), 1
        the cavity and 2 the wall, below the plane of the base; and the affine matrix (4, 4) from
        indices to mm. A voxel has the label of the tissue at its centre. The slices lie where as
        few as possible leave the cavity or come into it during the cycle, as one plans a scan.
        """
        u, theta = np.linspace(0, 1, 241), np.linspace(0, 2 * np.pi, 181)
        sheets = [
            [self.position(u[:, None], theta, m, phase) for m in (1.0, 0.0)]
            for phase in range(self.phases)
        ]
        outer = np.concatenate([sheet[0].reshape(-1, 3) for sheet in sheets])
        spacing = np.asarray(spacing, float)
        origin = np.floor(outer.min(0) / spacing - 1) * spacing
        origin[2] += self._slice_offset(spacing[2])
        size = np.ceil((outer.max(0) - origin) / spacing).astype(int) + 2
        x, y, z = (origin[k] + spacing[k] * np.arange(size[k]) for k in range(3))
        labels = np.zeros((*size, self.phases), np.uint8)
        for phase, both in enumerate(sheets):
            base = both[1][-1, :, 2].min()
            for label, sheet in zip((2, 1), both):
                for k in np.flatnonzero(z <= base):
                    if z[k] > sheet[0, 0, 2]:
                        labels[:, :, k, phase][_inside(x, y, _outline(sheet, z[k]))] = label
        affine = np.diag([*spacing, 1.0])
        affine[:3, 3] = origin
        return labels, affine

    def _slice_offset(self, gap: float) -> float:
        """0 to gap: where the slices of a scan lie best."""
        ends = np.array(
            [
                self.position(np.array([0.0, 1.0]), 0.0, 0.0, phase)[:, 2]
                for phase in range(self.phases)
            ]
        )
        offsets = np.linspace(0, gap, 41)[:-1]
        first, last = (np.floor((ends[:, end, None] - offsets) / gap) for end in (0, 1))
        changes = np.ptp(first, 0) + np.ptp(last, 0)
        depth = np.mod(offsets - ends[:, :1], gap).min(0)  # of the first slice behind the apex
        return float(offsets[np.lexsort((-depth, changes))[0]])

    def material_points(self, points: np.ndarray, phase: float) -> MaterialPoints:
        """The tissue at points (n, 3) of a surface: the closest points of the ventricle's sheets up
        to the rim.

        Gauss-Newton in (u cos theta, u sin theta), where the apex is nothing special, from the
        closest of some samples.
        """
        sheets = []
        for m in self.sheets:
            u, theta = (
                grid.ravel()
                for grid in np.meshgrid(
                    np.linspace(0, RIM, 60), np.linspace(0, 2 * np.pi, 121)[:-1], indexing="ij"
                )
            )
            start = _nearest(points, self.position(u, theta, m, phase))
            q = np.stack([u[start] * np.cos(theta[start]), u[start] * np.sin(theta[start])], -1)
            sheets.append(self._closest(points, q, m, phase))
        best = sheets[0]
        for found in sheets[1:]:
            best = MaterialPoints(
                *(
                    np.where(found.distance < best.distance, new, old)
                    for new, old in zip(found, best)
                )
            )
        return best

    def _closest(self, points, q, m, phase):
        def at(q):
            return self.position(np.hypot(q[:, 0], q[:, 1]), np.arctan2(q[:, 1], q[:, 0]), m, phase)

        distance = np.linalg.norm(points - at(q), axis=1)
        length, h = np.ones(len(q)), 1e-6
        for _ in range(30):
            columns = [(at(q + h * axis) - at(q - h * axis)) / (2 * h) for axis in np.eye(2)]
            jacobian = np.stack(columns, -1)
            step = np.einsum("nij,nj->ni", np.linalg.pinv(jacobian), points - at(q))
            trial = q + length[:, None] * step
            trial /= np.maximum(1, np.linalg.norm(trial, axis=1) / RIM)[:, None]  # u <= RIM
            found = np.linalg.norm(points - at(trial), axis=1)
            better = found < distance
            q, distance = np.where(better[:, None], trial, q), np.where(better, found, distance)
            length = np.where(better, 1.0, length / 2)
        return MaterialPoints(
            np.hypot(q[:, 0], q[:, 1]), np.arctan2(q[:, 1], q[:, 0]), np.full(len(q), m), distance
        )

    def errors(self, landmarks: np.ndarray, root: int = 0) -> np.ndarray:
        """Mean distance (mm), phase by phase, of landmarks (phases, n, 3) from the tissue that they
        lie on at the root's phase.

        Landmarks at the rim of the base and on the lid are left out: no tissue can be followed
        there.
        """
        landmarks, root = array_of("landmarks", landmarks), whole_number("root", root)
        if landmarks.ndim != 3 or landmarks.shape[2] != 3 or landmarks.dtype.kind not in "iuf":
            raise InputError(
                f"Landmarks must be numbers of shape (phases, n, 3), not {landmarks.dtype} of "
                f"shape {landmarks.shape}."
            )
        if not 0 <= root < len(landmarks):
            raise InputError(
                f"Layer {root} cannot be the root: layers are numbered from 0 to "
                f"{len(landmarks) - 1}."
            )
        tissue = self.material_points(landmarks[root], root)
        known = tissue.distance < TRUSTED
        u, theta, m = tissue.u[known], tissue.theta[known], tissue.m[known]
        return np.array(
            [
                np.linalg.norm(points[known] - self.position(u, theta, m, phase), axis=1).mean()
                for phase, points in enumerate(landmarks)
            ]
        )


def _nearest(points, samples):
    """Index of the sample that is closest to each point."""
    squares = (samples**2).sum(1)
    return np.concatenate(
        [
            (squares - 2 * chunk @ samples.T).argmin(1)
            for chunk in np.array_split(points, 1 + len(points) // 500)
        ]
    )


def _outline(sheet, height):
    """Where a sheet, rows of points from apex to base, meets a plane z = height: a closed polygon,
    x and y."""
    return np.array(
        [
            [np.interp(height, column[:, 2], column[:, k]) for k in range(2)]
            for column in sheet.transpose(1, 0, 2)
        ]
    )


def _inside(x, y, polygon):
    """Which points of the grid x by y a closed polygon surrounds (even-odd rule)."""
    inside = np.zeros((len(x), len(y)), bool)
    for (ax, ay), (bx, by) in zip(polygon[:-1], polygon[1:]):
        crosses = (ay > y) != (by > y)
        if crosses.any():
            inside[:, crosses] ^= x[:, None] < (bx - ax) * (y[crosses] - ay) / (by - ay) + ax
    return inside
