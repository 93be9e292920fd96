# SPDX-License-Identifier: GPL-3.0-only
"""The filter scripts in sample_projects/ hold what the plugin has."""

import make_scripts
from server import SCRIPTS


def test_the_scripts_hold_the_plugins_parameters_and_defaults():
    written = make_scripts.scripts()
    assert set(written) == {path.name for path in SCRIPTS.glob("*.mlx")}
    for name, text in written.items():
        assert (SCRIPTS / name).read_text() == text, (
            f"{name} is out of date: run sample_projects/make_scripts.py"
        )
