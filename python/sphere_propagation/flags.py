# SPDX-License-Identifier: GPL-3.0-only
"""What filters and functions say, in the words of the command line."""

from __future__ import annotations

import re

# Parameters of the filters that the command has as options, --mirror-layers; those of one word are
# left alone, since they are words.
PARAMETERS = (
    "align_slices",
    "area_restoration",
    "area_weight",
    "file_series",
    "handle_repair",
    "initial_map",
    "longest_gap",
    "mirror_layers",
    "skip_incomplete_phases",
    "voxel_size",
)
CALLS = {
    "sp.prepare(surface, remove_handles=True)": "run --prepare --remove-handles",
    "sp.prepare(surface)": "run --prepare",
}
# Not within paths; the label that dialogs have may follow.
_parameter = re.compile(
    r"(?<![\w/\\.-])(" + "|".join(PARAMETERS) + r')(?![\w/\\-]|\.\w)(?: \("[A-Z][^"]*"\))?'
)


def by_flags(text: str) -> str:
    """With --mirror-layers in place of mirror_layers ("Mirror layers"), and the command's way to
    prepare a mesh in place of Python's."""
    for call, flags in CALLS.items():
        text = text.replace(call, flags)
    return _parameter.sub(lambda found: "--" + found[1].replace("_", "-"), text)
