# SPDX-License-Identifier: GPL-3.0-only
"""Tests of the cohort's engine on a cluster: scripts/test cohort runs them inside of with_slurm."""

from __future__ import annotations

import os
from pathlib import Path

import pytest
import sphere_propagation as sp
from sphere_propagation.files import write_ply

SUBJECTS, PHASES, CHUNK = 24, 8, 6


@pytest.fixture(scope="session")
def cluster() -> Path:
    """The folder of a Slurm that is there for these tests only."""
    if "SLURM_SCRATCH" not in os.environ:
        pytest.skip("not inside of tests/cohort/with_slurm")
    return Path(os.environ["SLURM_SCRATCH"])


@pytest.fixture(scope="session")
def subjects(tmp_path_factory) -> Path:
    """A folder per subject, a file per phase: beating ventricles, small for the test's sake, as the
    study is (study.toml beside it): most of a small job on a cluster is the start of Snakemake."""
    root = tmp_path_factory.mktemp("study") / "input"
    root.mkdir()
    (root.parent / "study.toml").write_text(f"chunk = {CHUNK}\nfrequency = 6\n")
    for s in range(SUBJECTS):
        folder = root / f"sub-{s:02d}"
        folder.mkdir()
        phases = sp.make_phantom(part="Cavity", phases=PHASES, voxel_size=4, seed=s)
        for k, surface in enumerate(phases):
            write_ply(folder / f"phase_{k}.ply", surface.vertices, surface.faces)
    return root
