# SPDX-License-Identifier: GPL-3.0-only
"""What filters say to Python, in the words of somebody who has files and a study."""

from __future__ import annotations

import re
from typing import Dict

from ..errors import FOR_ARRAYS, MESSAGES_FOR_ARRAYS

PREPARE = 'MeshLab\'s filter "Prepare surface", or sp.prepare of the package, mends it.'
#: In place of the advice in errors.FOR_ARRAYS, by fault; a test says where one has none.
ADVICE: Dict[str, str] = {
    **dict.fromkeys(("Empty", "NoFaces"), "Give it a closed triangle mesh, or leave its file out."),
    **dict.fromkeys(
        (
            "NonFiniteCoordinate",
            "DegenerateFace",
            "NonManifoldEdge",
            "NotClosed",
            "InconsistentOrientation",
            "UnreferencedVertex",
            "NonManifoldVertex",
            "SeveralParts",
            "InwardOrientation",
        ),
        PREPARE,
    ),
    "NotWelded": f". {PREPARE}",
    "IndexOutOfRange": "The file is damaged: write it again.",
    "Handles": "Remove them before meshing, by filling the tunnels in the label image, as the "
    'import of label volumes does; or by "Prepare surface" with remove_handles.',
    "NoValidMap": ": make its triangles more even, as MeshLab's isotropic remeshing does.",
    "ZeroArea": "There is no surface to map: all vertices lie in one place, or on one line.",
    "Flat": "All its vertices lie in one plane.",
    **dict.fromkeys(
        ("CoordinateTooLarge", "ExtentTooSmall", "DifferentUnits"),
        "Bring its files to the unit of the others.",
    ),
    **dict.fromkeys(
        (
            "NoSurface",
            "LandmarkCount",
            "NonFiniteLandmark",
            "FewSharedAnchors",
            "AnchorsOnOneLine",
            "LandmarksInOnePlace",
        ),
        "Leave its files out, or mend them.",
    ),
}
MESSAGES: Dict[str, str] = {
    "mirrorImage": "Mirror its files where they were made.",
    "tooManyLandmarks": "Choose a lower frequency.",
}


#: Filters may reflect layers, cohorts do not.
OF_COHORTS: Dict[str, str] = {
    ", so none of them is reflected. Look at them, and reflect by hand.": ". Look at them.",
}


def for_files(text: str) -> str:
    """With advice for files in place of that for arrays."""
    for table, ours in ((FOR_ARRAYS, ADVICE), (MESSAGES_FOR_ARRAYS, MESSAGES)):
        for name, (_, advice) in table.items():
            if name in ours and advice in text:
                text = text.replace(advice, ours[name])
    for theirs, ours in OF_COHORTS.items():
        text = text.replace(theirs, ours)
    return re.sub(r"\bread_label_volume\b", "the import of label volumes", text)
