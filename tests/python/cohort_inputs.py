# SPDX-License-Identifier: GPL-3.0-only
"""Small studies: phantoms as subjects, and the steps without an engine."""

import os
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import sphere_propagation as sp
from sphere_propagation.cohort import plan, steps, store, study, subjects

STUDY = {"frequency": 4, "modes": 8, "cycle_phases": 6}
RESULTS = ("surfaces", "landmarks", "moments", "model", "scores", "cycle")


def write_subject(folder: Path, seed: int, phases: int = 3) -> None:
    folder.mkdir(parents=True)
    for phase, surface in enumerate(sp.make_phantom(phases=phases, voxel_size=4.0, seed=seed)):
        sp.write_ply(folder / f"phase_{phase}.ply", surface.vertices, surface.faces)


def make_input(folder: Path, count: int = 3) -> Path:
    """sub-00 and so on, and two that cannot be done: one with a file that is none, one with a
    surface that is open."""
    for seed in range(count):
        write_subject(folder / f"sub-{seed:02d}", seed)
    broken, opened = folder / "sub-90", folder / "sub-91"
    broken.mkdir()
    (broken / "phase_0.ply").write_bytes(b"no mesh")
    opened.mkdir()
    surface = sp.make_phantom(phases=3, voxel_size=4.0, seed=9)[0]
    sp.write_ply(opened / "phase_0.ply", surface.vertices, surface.faces[1:])
    return folder


def octahedron(rounds: int = 3):
    """A ball of triangles, (vertices, faces)."""
    v = np.array([[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1]], float)
    f = np.array(
        [[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4], [2, 0, 5], [1, 2, 5], [3, 1, 5], [0, 3, 5]]
    )
    for _ in range(rounds):
        edges = np.sort(np.concatenate([f[:, [0, 1]], f[:, [1, 2]], f[:, [2, 0]]]), axis=1)
        ends, at = np.unique(edges, axis=0, return_inverse=True)
        a, b, c = (len(v) + part for part in at.reshape(3, -1))
        middle = v[ends].mean(1)
        v = np.r_[v, middle / np.linalg.norm(middle, axis=1, keepdims=True)]
        corners = [(f[:, 0], a, c), (f[:, 1], b, a), (f[:, 2], c, b), (a, b, c)]
        f = np.concatenate([np.stack(one, 1) for one in corners])
    return v, f


def hand(seed: int) -> sp.Surface:
    """Three lobes of different size on an ellipsoid, which has a left and a right, mm."""
    draw = np.random.RandomState(seed)
    v, f = octahedron(4)
    radius = np.ones(len(v))
    lobes = ([0.8, 0.5, 0.3], 0.6), ([-0.6, 0.7, 0.4], 0.45), ([0.1, -0.6, 0.8], 0.3)
    for place, height in lobes:
        place = np.asarray(place) + 0.05 * draw.randn(3)
        place /= np.linalg.norm(place)
        radius += height * np.exp(0.1 * draw.randn()) * np.exp(4 * (v @ place - 1))
    size = 30 * np.exp(0.08 * draw.randn())
    points = size * radius[:, None] * v * [1.5, 1.0, 0.7]
    return sp.Surface(points + draw.randn(3), f, f"hand {seed}")


@contextmanager
def inside(folder: Path):
    before = os.getcwd()
    os.chdir(folder)
    try:
        yield
    finally:
        os.chdir(before)


def planned(where: Path, output: Path, **keys):
    """Writes the plan as the command does."""
    made = study.checked({**STUDY, **keys})
    base, found, remarks = subjects.find(where, made, where)
    output.mkdir(exist_ok=True)
    return plan.write(output, made, base, found, where, remarks)


def run_steps(output: Path) -> None:
    """All of them, as the Snakefile has them."""
    with inside(output):
        made = store.read_json(Path("plan/chunks.json"))
        orders = [("import", chunk) for chunk in made["chunks"]] + [("atlas",)]
        orders += [("landmarks", chunk) for chunk in made["chunks"]]
        orders += [("scatter", block) for block in made["levels"][0]]
        for level, blocks in list(enumerate(made["levels"]))[1:]:
            orders += [("merge", str(level), block) for block in blocks]
        orders += [("model",)] + [("scores", block) for block in made["levels"][0]]
        for step, *of in [*orders, ("cycle",), ("report",)]:
            steps.STEPS[step](*of)


def results(output: Path):
    """File -> content of all that must be the same from run to run."""
    found = [path for name in RESULTS for path in (output / name).rglob("*") if path.is_file()]
    found += [output / name for name in ("atlas.npz", "atlas.json", "subjects.csv")]
    return {path.relative_to(output).as_posix(): path.read_bytes() for path in found}
