# SPDX-License-Identifier: GPL-3.0-only
"""Fixtures of the tests with MeshLab 2020.09 itself: meshlabserver and the GUI, with the plugin in
a private prefix.

    MESHLAB_2020_PREFIX   what scripts/install-plugin --prefix made
    GUI_AGENT             the library built from gui_agent.cpp

scripts/test hosts sets them.
"""

import os
import sys
from pathlib import Path

import pytest

sys.path.insert(1, str(Path(__file__).resolve().parents[1] / "filters"))  # this folder is first
sys.path.insert(2, str(Path(__file__).resolve().parents[1] / "volumes"))
sys.path.insert(3, str(Path(__file__).resolve().parents[2] / "sample_projects"))

import gui
import pymeshlab
from environment import PLUGIN, PROJECT, files_of, yardstick
from server import Server

BUILD = PROJECT / "build/meshlab-2020.09"
PREFIX = Path(os.environ.get("MESHLAB_2020_PREFIX") or BUILD / "installed")
AGENT = Path(os.environ.get("GUI_AGENT") or BUILD / "tests/libgui_agent.so")
PICTURES = PROJECT / "build/test-results/screenshots"
SAMPLE = PROJECT / "sample_projects/ventricle"


@pytest.fixture(scope="session", autouse=True)
def plugin():
    if not (PREFIX / "bin/meshlabserver").exists():
        pytest.exit(
            f"There is no MeshLab 2020.09 in {PREFIX}: call `scripts/test hosts`.", returncode=1
        )
    pymeshlab.load_plugin(str(PLUGIN))
    pymeshlab.load_plugin(str(PLUGIN.with_name("libfilter_label_volume.so")))


@pytest.fixture(scope="session")
def measure():
    """The yardstick's measure.py, which shares nothing with the plugin."""
    return yardstick("measure")


@pytest.fixture(scope="session")
def server():
    """server(*arguments): a run of meshlabserver; see server.py."""
    return Server(PREFIX / "bin/meshlabserver")


@pytest.fixture
def meshlab(tmp_path, request):
    """meshlab(*files): MeshLab's GUI, to be used in a with statement; see gui.py."""

    def start(*files, **more):
        name = request.node.name.split("[")[0].removeprefix("test_")
        return gui.MeshLab(
            PREFIX / "bin/meshlab", tmp_path / "home", AGENT, files, PICTURES / name, **more
        )

    return start


@pytest.fixture
def surfaces():
    """The five phases of the sample."""
    return sorted((SAMPLE / "surfaces").glob("*.ply"))


def heart(folder, count):
    """`count` phases of a heart of the data, spread over the cycle."""
    files = files_of(folder)
    return files[:: max(1, len(files) // count)][:count]
