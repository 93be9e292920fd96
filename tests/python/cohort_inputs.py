# SPDX-License-Identifier: GPL-3.0-only
"""Small studies: phantoms as subjects, and the steps without an engine."""

import os
from contextlib import contextmanager
from pathlib import Path

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
    base, found = subjects.find(where, made, where)
    output.mkdir(exist_ok=True)
    return plan.write(output, made, base, found, where)


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
