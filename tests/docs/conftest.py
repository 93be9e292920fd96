# SPDX-License-Identifier: GPL-3.0-only
"""Fixtures of the tests of the pages. They need the plugins for PyMeshLab; everything else is in
the checkout."""

import os
import sys
from pathlib import Path

import pymeshlab
import pytest
from pages import PROJECT

sys.path.insert(0, str(PROJECT / "python"))


@pytest.fixture(scope="session")
def plugin():
    """The plugin's file, loaded into PyMeshLab."""
    file = Path(
        os.environ.get("SPHERE_PROPAGATION_PLUGIN")
        or PROJECT / "build/pymeshlab/plugins/libfilter_sphere_propagation.so"
    )
    if not file.is_file():
        pytest.exit(
            f"There is no plugin {file}: build it with `scripts/build pymeshlab`.", returncode=1
        )
    if (
        "compute_spherical_parameterisation_root" not in pymeshlab.filter_list()
    ):  # tests of the Python package load it, too
        pymeshlab.load_plugin(str(file))
    return file


@pytest.fixture(scope="session")
def plugins(plugin):
    """The folder of both plugins, loaded into PyMeshLab."""
    file = plugin.with_name("libfilter_label_volume.so")
    if not file.is_file():
        (pytest.fail if os.environ.get("CI") == "true" else pytest.skip)(
            f"built without the volume plugin: {file}"
        )
    if "create_layers_from_label_volume" not in pymeshlab.filter_list():
        pymeshlab.load_plugin(str(file))
    return plugin.parent
