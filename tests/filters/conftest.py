# SPDX-License-Identifier: GPL-3.0-only
"""Fixtures of the filter tests. The plugin is loaded into the PyMeshLab that pip installed."""

import cycles
import pymeshlab
import pytest
from environment import PLUGIN, files_of, yardstick


@pytest.fixture(scope="session", autouse=True)
def plugin():
    if not PLUGIN.is_file():
        pytest.exit(
            f"There is no plugin {PLUGIN}: build it with `scripts/build pymeshlab`.", returncode=1
        )
    if (
        "compute_spherical_parameterisation_root" not in pymeshlab.filter_list()
    ):  # importing the Python package loads it, too
        pymeshlab.load_plugin(str(PLUGIN))


@pytest.fixture(scope="session")
def measure():
    """The yardstick's measure.py."""
    return yardstick("measure")


@pytest.fixture(scope="session")
def ventricle():
    """The yardstick's phantom: Ventricle(part, seed, phases, voxel, twist)."""
    yardstick("measure")
    return yardstick("phantom").Ventricle


@pytest.fixture(scope="session")
def truth(measure):
    """The surfaces of heart_truth with one face list: list of (vertices, faces)."""
    read = [measure.read_ply(path) for path in files_of("heart_truth/truth")]
    return [(measure.points(v), f) for v, f in read]


@pytest.fixture(params=cycles.SEQUENCES)
def sequence(request):
    """The name of a heart cycle; see cycles.project_of."""
    return request.param


RUNS = [(s, m, o) for s in cycles.SEQUENCES for m in cycles.METHODS for o in cycles.ORDERS]


@pytest.fixture(params=RUNS, ids=" / ".join, scope="session")
def run(request):
    """The Run of each cycle, by both methods, in both orders of time."""
    return cycles.run_pipeline(*request.param)
