# SPDX-License-Identifier: GPL-3.0-only
"""Sequences whose material points are known, made otherwise than the yardstick's phantom: nothing
was chosen on them but what docs/propagation_robust.md says. Every phase is meshed anew (isotropic
remeshing, target length varied by 10 %), and each vertex moved along its normal by noise of a tenth
of the mean edge length.

Ventricle       a left ventricle between confocal prolate spheroids, whose wall keeps its volume
                (after T. Arts et al., 1992)
WarpedSurface   any closed surface under a smooth periodic warp of space: contraction along its axes
                and waves

Both: at(t) -> (vertices, faces), the same faces at all t; tissue: which vertices are material;
phases.
"""

import numpy as np
import pymeshlab

LEVELS, ANGLES = 90, 180  # of a sheet of the ventricle


def _orient(vertices, faces):
    p = vertices[faces]
    return (
        faces if np.einsum("ij,ij->", p[:, 0], np.cross(p[:, 1], p[:, 2])) > 0 else faces[:, ::-1]
    )


def _closed(rings, ends):
    """The surface through rings (count x ANGLES x 3), closed at each end by a point."""
    count, around = rings.shape[:2]
    i, j = np.meshgrid(np.arange(count - 1), np.arange(around), indexing="ij")
    a, b = i * around + j, i * around + (j + 1) % around
    sides = [
        np.stack(t, -1).reshape(-1, 3) for t in ((a, a + around, b), (b, a + around, b + around))
    ]
    k = np.arange(around)
    first = np.stack([np.full(around, count * around), k, (k + 1) % around], -1)
    last = np.stack(
        [
            np.full(around, count * around + 1),
            (count - 1) * around + (k + 1) % around,
            (count - 1) * around + k,
        ],
        -1,
    )
    vertices = np.vstack([rings.reshape(-1, 3), *ends])
    return vertices, _orient(vertices, np.vstack([*sides, first, last]))


class Ventricle:
    """part: cavity or wall; twist in degrees; lengths in mm."""

    def __init__(self, part, seed, phases=25, twist=8.0, ejection=0.55):
        r = np.random.RandomState(seed)
        self.part, self.phases, self.ejection = part, phases, ejection
        self.focus, self.inner = 35 * (1 + 0.08 * r.randn()), 0.42 * (1 + 0.1 * r.randn())
        self.outer = self.inner + 0.26 * (1 + 0.1 * r.randn())
        self.base = np.deg2rad(105 + 8 * r.randn())
        self.twist, self.shortening = (
            np.deg2rad(twist * (1 + 0.2 * r.randn())),
            0.13 * (1 + 0.2 * r.randn()),
        )
        self.weak_side, self.weakness = 2 * np.pi * r.rand(), 0.5 * r.rand()
        self.shape, self.tilt, self.drift = 0.06 * r.randn(3), 0.05 * r.randn(2), 3 * r.randn(3)
        self.systole = 0.38 + 0.03 * r.randn()

    def contraction(self, t):
        x = t / self.phases % 1
        return (
            np.sin(np.pi * x / self.systole / 2) ** 2
            if x < self.systole
            else np.cos(np.pi * (x - self.systole) / (1 - self.systole) / 2) ** 2
        )

    def sheet(self, depth, t):
        """LEVELS x ANGLES points at a depth of the wall: 0 inside, 1 outside."""
        nu, theta = (
            np.linspace(1e-3, self.base, LEVELS)[:, None],
            np.linspace(0, 2 * np.pi, ANGLES, endpoint=False)[None],
        )
        g = self.contraction(t)
        away = np.angle(np.exp(1j * (theta - self.weak_side)))
        contracted = g * (1 - self.weakness * np.exp(-(away**2) / 0.8))

        def volume(level):  # inside a spheroid, over that of the focal sphere
            return np.sinh(level) ** 2 * np.cosh(level)

        wanted = (
            volume(self.inner) * (1 - self.ejection * contracted)
            + volume(self.inner + (self.outer - self.inner) * depth)
            - volume(self.inner)
        ) / (1 - self.shortening * g)
        level = np.full_like(wanted, 0.6)
        for _ in range(30):
            level = level - (volume(level) - wanted) / (
                2 * np.sinh(level) * np.cosh(level) ** 2 + np.sinh(level) ** 3
            )
        turned = theta + self.twist * g * (1 - nu / self.base)
        outline = (
            1
            + self.shape[0] * np.cos(2 * theta)
            + self.shape[1] * np.cos(theta) * np.sin(nu)
            + self.shape[2] * np.sin(3 * theta) * np.sin(nu)
        )
        radius = self.focus * np.sinh(level) * np.sin(nu) * outline
        z = -self.focus * np.cosh(level) * np.cos(nu) * (1 - self.shortening * g)
        return (
            np.stack(
                [
                    radius * np.cos(turned) + self.tilt[0] * g * z,
                    radius * np.sin(turned) + self.tilt[1] * g * z,
                    z,
                ],
                -1,
            )
            + self.drift * g
        )

    def at(self, t):
        inside = self.sheet(0.0, t)
        if self.part == "cavity":
            rim, centre = inside[-1], inside[-1].mean(0)
            lid = centre + (rim - centre) * np.linspace(1, 0, 16)[1:-1, None, None]
            return _closed(np.concatenate([inside, lid]), (inside[0].mean(0), centre))
        outside = self.sheet(1.0, t)
        share = np.linspace(0, 1, 8)[1:-1, None, None]
        rings = np.concatenate(
            [inside, (1 - share) * inside[-1] + share * outside[-1], outside[::-1]]
        )
        return _closed(rings, (inside[0].mean(0), outside[0].mean(0)))

    @property
    def tissue(self):
        """All but the lid and the rim."""
        count = len(self.at(0)[0])
        tissue, kept = np.ones(count, bool), int(0.93 * LEVELS) * ANGLES
        tissue[kept : count - 2 if self.part == "cavity" else count - 2 - kept] = False
        tissue[count - 1] = self.part == "wall"
        return tissue


class WarpedSurface:
    """contraction: of the long axis and of the two others; waves: amplitude, in radii of
    gyration."""

    def __init__(self, surface, seed, phases=25, contraction=(0.12, 0.25), waves=0.06):
        self.vertices, self.faces = surface
        r = np.random.RandomState(seed)
        self.phases, self.contraction = (
            phases,
            np.array([contraction[0], contraction[1], 0.8 * contraction[1]]),
        )
        self.centre = self.vertices.mean(0)
        axes = np.linalg.svd(self.vertices - self.centre, full_matrices=False)[2]
        self.axes = axes * np.sign(np.linalg.det(axes))
        self.radius = np.sqrt(((self.vertices - self.centre) ** 2).sum(1).mean())
        self.waves = [
            (1.2 * r.randn(3), waves * r.randn(3), 2 * np.pi * r.rand()) for _ in range(6)
        ]

    def at(self, t):
        phase = 2 * np.pi * t / self.phases
        x = (
            (self.vertices - self.centre)
            @ self.axes.T
            / self.radius
            * (1 - self.contraction * (1 - np.cos(phase)) / 2)
        )
        moved = x + sum(
            (np.sin(x @ k + p + phase) - np.sin(x @ k + p))[:, None] * d for k, d, p in self.waves
        )
        return moved * self.radius, self.faces

    @property
    def tissue(self):
        return np.ones(len(self.vertices), bool)


def meshed(motion, t, count, random, noise=0.1):
    """Vertices and faces of a mesh of phase t with about `count` vertices."""
    v, f = motion.at(t)
    p = v[f]
    area = np.linalg.norm(np.cross(p[:, 1] - p[:, 0], p[:, 2] - p[:, 0]), axis=1).sum() / 2
    length = np.sqrt(2 / np.sqrt(3) * area / count) * (1 + 0.1 * random.rand())
    meshes = pymeshlab.MeshSet()
    meshes.add_mesh(pymeshlab.Mesh(v, f.astype(np.int32)))
    meshes.meshing_isotropic_explicit_remeshing(
        targetlen=pymeshlab.PureValue(length), iterations=6, featuredeg=60, checksurfdist=False
    )
    meshes.meshing_repair_non_manifold_edges()
    made = meshes.current_mesh()
    v, f, n = made.vertex_matrix(), made.face_matrix(), made.vertex_normal_matrix()
    edge = np.linalg.norm(v[f[:, 0]] - v[f[:, 1]], axis=1).mean()
    return v + n / np.linalg.norm(n, axis=1, keepdims=True) * (
        noise * edge * random.randn(len(v), 1)
    ), f


def distances(motion, landmarks, closest_points):
    """Which landmarks (one array a phase) are tissue; and, phase by phase, the distance of all from
    where the material points of phase 0 under them went."""
    first, faces = motion.at(0)
    face, weights, _ = closest_points(first, faces, landmarks[0])
    counted = motion.tissue[faces[face]].all(1)
    moved = [
        np.einsum("pk,pkj->pj", weights, motion.at(t)[0][faces[face]]) for t in range(motion.phases)
    ]
    away = [np.linalg.norm(found - true, axis=1) for found, true in zip(landmarks, moved)]
    return counted, away


def errors(motion, landmarks, closest_points):
    """Their means."""
    counted, away = distances(motion, landmarks, closest_points)
    return [of_phase[counted].mean() for of_phase in away]
