# SPDX-License-Identifier: GPL-3.0-only
"""Where the plugin, the data and the yardstick are.

SPHERE_PROPAGATION_PLUGIN   the plugin's file; default: what `scripts/build pymeshlab` makes
SPHERE_PROPAGATION_DATA     folder of the data, the yardstick beside it; default: ../shared/data
                            beside the checkout
CI=true                     missing data is a failure, not a skip
"""

import importlib
import os
import sys
from pathlib import Path

import pytest

PROJECT = Path(__file__).resolve().parents[2]
PLUGIN = Path(
    os.environ.get("SPHERE_PROPAGATION_PLUGIN")
    or PROJECT / "build/pymeshlab/plugins/libfilter_sphere_propagation.so"
)
DATA = Path(os.environ.get("SPHERE_PROPAGATION_DATA") or PROJECT / "../shared/data").resolve()


def require(path):
    """The path if it exists; else the test is skipped, or fails where CI=true."""
    if not path.exists():
        (pytest.fail if os.environ.get("CI") == "true" else pytest.skip)(f"missing data: {path}")
    return path


def files_of(folder):
    """The meshes in a folder of the data, in order of time."""
    return sorted(require(DATA / folder).glob("*.ply"))


def yardstick(module):
    """The yardstick's measure.py or phantom.py."""
    folder = require(DATA.parent / "yardstick")
    if str(folder) not in sys.path:
        sys.path.insert(0, str(folder))
    return importlib.import_module(module)
