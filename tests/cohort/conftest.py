# SPDX-License-Identifier: GPL-3.0-only
"""Tests of the cohort's engine on a cluster: scripts/test cohort runs them inside of with_slurm."""

from __future__ import annotations

import os
from pathlib import Path

import pytest
import sphere_propagation as sp
from sphere_propagation.files import write_ply

SUBJECTS, PHASES = 24, 8


@pytest.fixture(scope="session")
def cluster() -> Path:
    """The folder of a Slurm that is there for these tests only."""
    if "SLURM_SCRATCH" not in os.environ:
        pytest.skip("not inside of tests/cohort/with_slurm")
    return Path(os.environ["SLURM_SCRATCH"])


@pytest.fixture(scope="session")
def subjects(tmp_path_factory) -> Path:
    """A folder per subject, a file per phase: beating ventricles, small for the test's sake."""
    root = tmp_path_factory.mktemp("input")
    for s in range(SUBJECTS):
        folder = root / f"sub-{s:02d}"
        folder.mkdir()
        phases = sp.make_phantom(part="Cavity", phases=PHASES, voxel_size=3, seed=s)
        for k, surface in enumerate(phases):
            write_ply(folder / f"phase_{k}.ply", surface.vertices, surface.faces)
    return root
