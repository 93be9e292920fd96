#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-only
"""A shape model fitted to shapes that it was not built from, one left out after the other: how far
landmarks are from where they should be, and whether the standard deviations are right.

    scripts/measure --fitting [SET ...] [--every N] [--mirrors | --curve FILE.png]

SET: heart (25 phases), skulls (12 species), hippocampus and head (one surface each under 16 smooth
warps of a population and one of each shape's own, half as fine and a fifth as large), wall (the
phantom's, 12 phases of another seed). Where landmarks should be: where correspondence of all shapes
puts them, or where the warps do. Frames and alignments: rigid.

Cases: closed or 30 % cut off by a plane; as it lies (as Procrustes would put it) or in any pose,
which is searched for; noise of a quarter edge; a leak, 0.3 radii high and 0.5 wide, out of the
surface. Inside: share of coordinates whose error is within 1.96 standard deviations. Failed: errors
of more than 0.3 radii. Times are CPU seconds of one thread. --curve draws the share inside for
every promise, not for 95 % alone, as calibrated and before. --mirrors counts instead which surfaces
are called mirror images, of those that are right and of those that were reflected.
"""

import argparse
import os
import time
import warnings
from pathlib import Path

import numpy as np
import sphere_propagation as sp
from matplotlib.figure import Figure
from scipy.special import erfinv
from sphere_propagation.drawing import GREY

DATA = Path(os.environ.get("SPHERE_PROPAGATION_DATA", "../shared/data"))
SETS = ("heart", "skulls", "hippocampus", "head", "wall")
DRAWN = ("closed, as it lies", "cut 30 %, as it lies", "cut, noisy, leak, searched")


def rotation(seed):
    q, r = np.linalg.qr(np.random.RandomState(seed).normal(size=(3, 3)))
    q *= np.sign(np.diag(r))
    return q * np.sign(np.linalg.det(q))


def cut(surface, seed, share=0.3):
    """Without the faces beyond a plane that a share of the area lies beyond."""
    n = rotation(seed)[0]
    v, f = surface
    height = v[f].mean(1) @ n
    area = np.linalg.norm(np.cross(v[f[:, 1]] - v[f[:, 0]], v[f[:, 2]] - v[f[:, 0]]), axis=1)
    order = np.argsort(height)
    kept = order[np.cumsum(area[order]) < (1 - share) * area.sum()]
    return v, f[kept]


def noisy(surface, seed):
    v, f = surface
    edge = np.linalg.norm(v[f[:, 0]] - v[f[:, 1]], axis=1).mean()
    return v + 0.25 * edge * np.random.RandomState(seed).normal(size=v.shape), f


def leaking(surface, seed):
    """With a bump outwards around a vertex of its own."""
    v, f = surface
    corners = v[f]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    radius = np.sqrt(np.linalg.norm(normal, axis=1).sum() / 8 / np.pi)
    where = v[f[np.random.RandomState(seed).randint(len(f)), 0]]
    outwards = np.zeros_like(v)
    for k in range(3):
        np.add.at(outwards, f[:, k], normal)
    outwards /= np.maximum(np.linalg.norm(outwards, axis=1, keepdims=True), 1e-300)
    height = np.maximum(0, 1 - ((v - where) ** 2).sum(1) / (0.25 * radius) ** 2) ** 2
    return v + 0.3 * radius * height[:, None] * outwards, f


def warped(file, seed, shapes=16, modes=4, size=0.15):
    """Vertices of each shape, and the faces."""
    random = np.random.RandomState(seed)
    surface = sp.read_mesh(DATA / file)
    v = surface.vertices
    centre = v.mean(0)
    radius = np.sqrt(((v - centre) ** 2).sum(1).mean())
    x = (v - centre) / radius

    def field(length):
        total = np.zeros_like(x)
        for _ in range(2):
            wave, direction = length * random.randn(3), random.randn(3)
            total += np.sin(x @ wave + 2 * np.pi * random.rand())[:, None] * direction
        return total / np.sqrt((total**2).sum(1).mean())

    population = [size * radius * 0.75**m * field(1.6) for m in range(modes)]
    own = [0.2 * size * radius * field(3.2) for _ in range(shapes)]
    return [v + sum(random.randn() * f for f in population) + mine for mine in own], surface.faces


def population(name):
    """Surfaces as (vertices, faces), their landmarks and the faces of these."""
    if name in ("hippocampus", "head"):
        file, seed = {"hippocampus": ("hippocampus", 3), "head": ("maxplanck", 4)}[name]
        shapes, faces = warped(f"classic/{file}.ply", seed)
        surfaces = [(v, faces) for v in shapes]
        root = sp.parameterise_root(surfaces[0])
        found = sp.remesh(surfaces, [root] * len(surfaces), frequency=10)
        return surfaces, found.points, found.faces
    if name == "heart":
        files = sorted((DATA / "heart_truth" / "mc").glob("*.ply"))
        found = sp.correspond([sp.read_mesh(file) for file in files], order="Cyclic time")
    elif name == "skulls":
        files = sorted((DATA / "finch_skulls").glob("*.ply"))
        found = sp.correspond(
            [sp.read_mesh(file) for file in files], order="Similarity tree", groupwise=True
        )
    else:
        phases = sp.make_phantom(part="Wall", phases=12, voxel_size=3.0, seed=5)
        found = sp.correspond(phases, order="Cyclic time")
    surfaces = [(np.asarray(s.vertices), np.asarray(s.faces)) for s in found.surfaces]
    return surfaces, found.landmarks, found.landmark_faces


def cases_of(surface, truth, mean, seed):
    """Name -> the surface, where its landmarks should be, and the pose."""
    v, f = surface
    r, t = kabsch(truth, mean)
    here, right = (v @ r.T + t, f), truth @ r.T + t
    turn, shift = rotation(100 + seed), np.array([30.0, -20, 50])
    moved, there = (v @ turn.T + shift, f), truth @ turn.T + shift
    return {
        "closed, as it lies": (here, right, "As it lies"),
        "closed, searched": (moved, there, "Search"),
        "cut 30 %, as it lies": (cut(here, seed), right, "As it lies"),
        "cut 30 %, searched": (cut(moved, seed), there, "Search"),
        "cut, noisy, searched": (noisy(cut(moved, seed), seed), there, "Search"),
        "cut, noisy, leak, searched": (
            noisy(cut(leaking(moved, seed), seed), seed),
            there,
            "Search",
        ),
    }


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("sets", nargs="*", metavar="SET", help=", ".join(SETS))
    parser.add_argument("--every", type=int, default=4, help="leave out every so many-th shape")
    parser.add_argument("--mirrors", action="store_true", help="who is called a mirror image")
    parser.add_argument("--curve", metavar="FILE.png", help="draw promised and found shares")
    options = parser.parse_args()
    warnings.simplefilter("ignore", sp.SpherePropagationWarning)
    if options.mirrors:
        count_mirror_images(options.sets or SETS, options.every)
        return
    print("set         case                         error  surface  inside   sd   failed  CPU s")
    ratios = {}  # (set, case) -> errors over standard deviations; and over those before calibration
    for name in options.sets or SETS:
        surfaces, landmarks, faces = population(name)
        rows = {}
        for k in range(0, len(surfaces), options.every):
            others = [i for i in range(len(surfaces)) if i != k]
            model = sp.shape_model(landmarks[others], faces, alignment="Rigid")
            radius = np.linalg.norm(model.mean - model.mean.mean(0), axis=1).mean()
            for case, (surface, right, pose) in cases_of(
                surfaces[k], landmarks[k], model.mean, k
            ).items():
                begin = time.process_time()
                fit = sp.fit(model, surface, pose=pose, threads=1)
                spent = time.process_time() - begin
                error = np.linalg.norm(fit.points - right, axis=1).mean()
                axis = np.sqrt(np.einsum("jii->ji", fit.covariance))
                ratio = (np.abs(fit.points - right) / axis).ravel()
                ratios.setdefault((name, case), []).append(
                    (ratio, ratio * fit.figures["calibration"])
                )
                rows.setdefault(case, []).append(
                    (
                        error,
                        fit.figures["surface_distance"],
                        (ratio < 1.96).mean(),
                        fit.sd.mean(),
                        error > 0.3 * radius,
                        spent,
                    )
                )
        for case, values in rows.items():
            _, distance, inside, sd, failed, cpu = np.mean(values, 0)
            median = np.median([value[0] for value in values])
            print(
                f"{name:11} {case:27} {median:6.2f} {distance:8.3f} {inside:7.2f} {sd:5.2f} "
                f"{failed * len(values):4.0f}/{len(values)} {cpu:6.2f}",
                flush=True,
            )
    if options.curve:
        draw_calibration(ratios, options.curve)


def count_mirror_images(sets, every):
    print("set         case                       right ones called  mirror images named")
    for name in sets:
        surfaces, landmarks, faces = population(name)
        called = {}
        for k in range(0, len(surfaces), every):
            others = [i for i in range(len(surfaces)) if i != k]
            model = sp.shape_model(landmarks[others], faces, alignment="Rigid")
            cases = cases_of(surfaces[k], landmarks[k], model.mean, k)
            for case, ((v, f), _, pose) in cases.items():
                if pose == "Search":
                    image = v * [-1, 1, 1], f[:, [0, 2, 1]]
                    called.setdefault(case, []).append(
                        [is_called_mirror_image(model, surface) for surface in ((v, f), image)]
                    )
        for case, values in called.items():
            right, mirrored = np.sum(values, 0)
            print(
                f"{name:11} {case:27} {right:9}/{len(values)} {mirrored:18}/{len(values)}",
                flush=True,
            )


def is_called_mirror_image(model, surface):
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        sp.fit(model, surface)
    return any(str(w.message.message) == "mirrorImageFitsBetter" for w in said)


def draw_calibration(ratios, file):
    """For each case the share of coordinates inside intervals over the share that they promise, a
    line a set; dotted where nothing had been calibrated."""
    promised = np.linspace(0.02, 0.99, 98)
    bounds = np.sqrt(2) * erfinv(promised)  # in standard deviations
    figure = Figure(figsize=(11, 4.4), dpi=100)
    axes = figure.subplots(1, len(DRAWN), sharey=True)
    for ax, case in zip(axes, DRAWN):
        ax.plot([0, 1], [0, 1], color="0.8", lw=1)
        for color, name in enumerate(dict.fromkeys(name for name, _ in ratios)):
            after, before = (np.concatenate(r) for r in zip(*ratios[name, case]))
            for values, style, label in ((before, ":", None), (after, "-", name)):
                inside = (values[:, None] < bounds).mean(0)
                ax.plot(promised, inside, style, color=f"C{color}", lw=1.6, label=label)
        ax.set_title(case, fontsize=11, color=GREY)
        ax.set_xlabel("share promised", color=GREY)
        ax.set(xlim=(0, 1), ylim=(0, 1), aspect="equal")
    axes[0].set_ylabel("share of coordinates inside", color=GREY)
    axes[0].legend(frameon=False, loc="upper left", fontsize=9)
    figure.tight_layout()
    figure.savefig(file)


def kabsch(x, y):
    cx, cy = x.mean(0), y.mean(0)
    u, _, vt = np.linalg.svd((x - cx).T @ (y - cy))
    d = np.diag([1, 1, np.sign(np.linalg.det(u @ vt))])
    r = (u @ d @ vt).T
    return r, cy - r @ cx


if __name__ == "__main__":
    main()
