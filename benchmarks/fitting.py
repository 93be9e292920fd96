#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-only
"""A shape model fitted to shapes that it was not built from, one left out after the other: how far
landmarks are from where correspondence put them, and whether the standard deviations are right.

    scripts/measure --fitting [SET ...]     heart, skulls

Cases: closed (as it lies); closed, pose searched for; 30 % cut off by a plane; pose + cut + noise
of a quarter edge. Inside: share of landmarks whose error along each axis is within 1.96 standard
deviations. Times are CPU seconds of the process.
"""

import argparse
import os
import time
import warnings
from pathlib import Path

import numpy as np
import sphere_propagation as sp

DATA = Path(os.environ.get("SPHERE_PROPAGATION_DATA", "../shared/data"))


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


def sets(names):
    if "heart" in names:
        files = sorted((DATA / "heart_truth" / "mc").glob("*.ply"))
        yield "heart", files, {"order": "Cyclic time"}, "Rigid"
    if "skulls" in names:
        yield (
            "skulls",
            sorted((DATA / "finch_skulls").glob("*.ply")),
            {"order": "Similarity tree", "groupwise": True},
            "Rigid",
        )


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("sets", nargs="*", default=["heart", "skulls"])
    parser.add_argument("--every", type=int, default=4, help="leave out every so many-th shape")
    options = parser.parse_args()
    warnings.simplefilter("ignore", sp.SpherePropagationWarning)
    print("set      case                    error  surface  inside   sd   failed  CPU s")
    for name, files, how, alignment in sets(options.sets or ["heart", "skulls"]):
        surfaces = [sp.read_mesh(file) for file in files]
        found = sp.correspond(surfaces, **how)
        rows = {}
        for k in range(0, len(surfaces), options.every):
            others = [i for i in range(len(surfaces)) if i != k]
            model = sp.shape_model(
                found.landmarks[others], found.landmark_faces, alignment=alignment
            )
            truth = found.landmarks[k]
            whole = found.surfaces[k] if hasattr(found, "surfaces") else surfaces[k]
            whole = (np.asarray(whole.vertices), np.asarray(whole.faces))
            # As it lies: near the model's frame, as Procrustes would put it.
            r, t = kabsch(truth, model.mean)
            here = (whole[0] @ r.T + t, whole[1])
            turn, shift = rotation(100 + k), np.array([30.0, -20, 50])
            moved = (whole[0] @ turn.T + shift, whole[1])
            truths = truth @ r.T + t, truth @ turn.T + shift
            cases = {
                "closed, as it lies": (here, truths[0], "As it lies"),
                "closed, searched": (moved, truths[1], "Search"),
                "cut 30 %, as it lies": (cut(here, k), truths[0], "As it lies"),
                "cut 30 %, searched": (cut(moved, k), truths[1], "Search"),
                "cut, noisy, searched": (noisy(cut(moved, k), k), truths[1], "Search"),
            }
            for case, (surface, right, pose) in cases.items():
                begin = time.process_time()
                fit = sp.fit(model, surface, pose=pose, threads=1)
                spent = time.process_time() - begin
                error = np.linalg.norm(fit.points - right, axis=1)
                axis = np.sqrt(np.einsum("jii->ji", fit.covariance))
                inside = (np.abs(fit.points - right) < 1.96 * axis).mean()
                radius = np.linalg.norm(model.mean - model.mean.mean(0), axis=1).mean()
                rows.setdefault(case, []).append(
                    (
                        error.mean(),
                        fit.figures["surface_distance"],
                        inside,
                        fit.sd.mean(),
                        error.mean() > 0.3 * radius,
                        spent,
                    )
                )
        for case, values in rows.items():
            e, d, i, s, bad, cpu = np.mean(values, 0)
            median = np.median([v[0] for v in values])
            print(
                f"{name:8} {case:22} {median:6.2f} {d:8.3f} {i:7.2f} {s:5.2f} "
                f"{sum(v[4] for v in values):4.0f}/{len(values)} {cpu:6.2f}",
                flush=True,
            )


def kabsch(x, y):
    cx, cy = x.mean(0), y.mean(0)
    u, _, vt = np.linalg.svd((x - cx).T @ (y - cy))
    d = np.diag([1, 1, np.sign(np.linalg.det(u @ vt))])
    r = (u @ d @ vt).T
    return r, cy - r @ cx


if __name__ == "__main__":
    main()
