# SPDX-License-Identifier: GPL-3.0-only
"""The volume plugin beside the other one, and the helpers of the filter tests."""

import os
import sys
from pathlib import Path

import pymeshlab
import pytest

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "filters"))

from environment import PLUGIN

VOLUME_PLUGIN = PLUGIN.with_name("libfilter_label_volume.so")


@pytest.fixture(scope="session", autouse=True)
def volume_plugin():
    if not VOLUME_PLUGIN.is_file():
        (pytest.fail if os.environ.get("CI") == "true" else pytest.skip)(
            f"built without the volume plugin: {VOLUME_PLUGIN}"
        )
    if "create_layers_from_label_volume" not in pymeshlab.filter_list():
        pymeshlab.load_plugin(str(VOLUME_PLUGIN))
