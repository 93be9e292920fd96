# SPDX-License-Identifier: GPL-3.0-only
"""What filters and functions say, in the words of the command line."""

from __future__ import annotations

import re

from .errors import FOR_ARRAYS

# Parameters of the filters that the command has as options, --mirror-layers; those of one word are
# left alone, since they are words.
PARAMETERS = (
    "align_slices",
    "anchor_pose",
    "anchor_positions",
    "anchor_sd",
    "anchor_snap",
    "area_restoration",
    "area_weight",
    "file_series",
    "handle_repair",
    "initial_map",
    "join_shells",
    "longest_gap",
    "mirror_layers",
    "remove_handles",
    "skip_incomplete_phases",
    "voxel_size",
)
# The same of one word, where a message begins with it.
WORDS = (
    "alignment",
    "anchors",
    "frequency",
    "method",
    "order",
    "parents",
    "phases",
    "pose",
    "seed",
    "smoothing",
    "unit",
)
OTHERWISE = {"exact": "--exact-anchors"}  # what the command calls by a word of its own
CALLS = {
    "sp.prepare(surface, remove_handles=True)": "run --prepare --remove-handles",
    "sp.prepare(surface)": "run --prepare",
    # What is on anyway.
    "Keep both by keep_largest_component=False, or prepare": "Prepare",
    ", or keep all sheets by remove_fins=False": "",
}
# What to do about a fault (errors.FOR_ARRAYS), where our advice there is code.
ADVICE = {
    "Empty": "Give a closed triangle mesh, or leave the file out.",
    "NonFiniteCoordinate": "run --prepare drops them and closes what opens; whatever wrote them "
    "went wrong.",
    "IndexOutOfRange": "The file is damaged: write it again.",
    "DegenerateFace": "run --prepare leaves them out.",
    "NotClosed": "run --prepare closes it by lids that are marked.",
    "NotWelded": ": unify them by run --prepare, which also closes what is still open.",
    "UnreferencedVertex": "run --prepare leaves them out.",
    "SeveralParts": "run --prepare keeps the largest. Where another one is meant, make it a file "
    "of its own.",
    "InwardOrientation": "run --prepare turns them round.",
    "NoValidMap": ": make its triangles more even, as MeshLab's isotropic explicit remeshing does.",
    "NonFiniteLandmark": "Leave the shape out, or make its landmarks again.",
}
# Not within paths; the label that dialogs have may follow.
_parameter = re.compile(
    r"(?<![\w/\\.-])("
    + "|".join(PARAMETERS)
    + r')(?![\w/\\-]|\.\w)(?:=True\b)?(?: \("[A-Z][^"]*"\))?'
)

_word = re.compile(rf"^(?:The )?({'|'.join(WORDS)})(?= must\b|: )")


def option(name: str) -> str:
    """What the command calls a parameter."""
    return "--" + name.replace("_", "-")


def by_flags(text: str) -> str:
    """With --mirror-layers in place of mirror_layers ("Mirror layers"), and the command's way to
    prepare a mesh in place of Python's."""
    for fault, advice in ADVICE.items():
        text = text.replace(FOR_ARRAYS[fault][1], advice)
    for call, flags in CALLS.items():
        text = text.replace(call, flags)
    text = _word.sub(r"--\1", text)
    text = re.sub(
        r"^(exact|anchor_\w+) needs anchors: give them",
        lambda found: f"{OTHERWISE.get(found[1], option(found[1]))} needs --anchors: give them",
        text,
    )
    text = re.sub(r"^(Layer -?\d+ cannot be the root): parents say", r"\1: --parents say", text)
    text = re.sub(r"^(Layer -?\d+ cannot be the root):", r"\1 (--root):", text)
    text = re.sub(
        r"^(?:The )?voxel size in mm must", "--voxel-size, the voxel size in mm must", text
    )
    return _parameter.sub(lambda found: option(found[1]), text)
