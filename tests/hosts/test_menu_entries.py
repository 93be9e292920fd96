# SPDX-License-Identifier: GPL-3.0-only
"""What our messages call MeshLab's filters is what MeshLab 2020.09 calls them."""

import sys
from pathlib import Path

from conftest import PREFIX
from environment import PROJECT

sys.path.insert(0, str(PROJECT / "tests/docs"))
from messages import catalogue


def plugins(prefix):
    """What the plugins of MeshLab's filters hold."""
    for file in Path(prefix).glob("lib/*/meshlab/plugins/libfilter_*.so"):
        if "sphere" not in file.name:
            yield file.read_bytes()


def test_menu_entries_are_those_of_meshlab_2020():
    words = list(plugins(PREFIX))
    assert words
    for entry in catalogue()["entries"]:
        name = b"\0" + entry["2020.09"].encode() + b"\0"  # the whole of it
        assert any(name in plugin for plugin in words), entry
