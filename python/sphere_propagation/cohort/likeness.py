# SPDX-License-Identifier: GPL-3.0-only
"""Whether a subject is of its study's kind: in the same unit, and on the same side.

It is judged by the filters' own rules for a layer among others (vcg_ext/sequence/surface_sizes.h,
mirroring.h): the frames of the atlas among each other, and every subject's frame among a few of
them, from the smallest to the largest.
"""

from __future__ import annotations

import re
import warnings
from typing import Any, Dict, List, Mapping, Optional, Sequence, Tuple

import numpy as np

from .. import attention, filters
from ..errors import SpherePropagationError, SpherePropagationWarning
from ..sphere_map import SphereMap
from ..surface import Surface
from .study import KINDS

UNIT, MIRRORED = KINDS  # what models can leave out
SIZE = "another size"
ASKED = {"mirrorCopy": "mirror image of another", "mirrorDoubt": "perhaps mirrored"}
UNSURE = 0.25  # part of the frames whose side may be unknown in a study that has sides
REFERENCES = 5  # frames of the atlas that a subject is compared with
OF_SIZE = ("anotherUnit", "anotherUnitThanRoot", "anotherSize", "anotherSizeThanRoot")
OF_SIZE += ("severalSizes",)
HALVES = "halfOfLayersLarger"

Oddity = Dict[str, str]  # kind, text


def has_sides(said: Sequence[SpherePropagationWarning], count: int) -> bool:
    """Whether the filter can tell the side of most of `count` frames: not of shapes that are nearly
    their own mirror images, as ventricles, of which it would call some mirrored."""
    unsure = {
        name
        for warning in said
        if warning.message in ("sidesDiffer", "sidesNotKnown")
        for name in warning.layers
    }
    return len(unsure) <= UNSURE * count


def found_in(said: Sequence[SpherePropagationWarning], count: int) -> Dict[str, List[Oddity]]:
    """Name of a frame -> what is odd about it among `count` of them."""
    odd: Dict[str, List[Oddity]] = {}
    messages = {warning.message for warning in said}
    sided = has_sides(said, count)
    for warning in said:
        if warning.message in OF_SIZE:
            one = _of_size(str(warning))
        elif (
            warning.message == "mirroredRoot"
            and sided
            or warning.message == "mirrorImage"
            and sided
            and "mirroredRoot" not in messages
        ):
            one = _mirrored()
        elif warning.message in ASKED:
            one = {"kind": ASKED[warning.message], "text": _asked(warning)}
        else:
            continue
        for name in warning.layers:
            odd.setdefault(name, []).append(one)
    return odd


def asked_of(said: Sequence[SpherePropagationWarning], count: int) -> Dict[str, List[Oddity]]:
    """What is odd, but may be right, and shows only where all are compared with each other."""
    found = {
        name: [one for one in its if one["kind"] in ASKED.values()]
        for name, its in found_in(said, count).items()
    }
    return {name: its for name, its in found.items() if its}


def _unit_and_factor(text: str) -> Tuple[str, str]:
    """What a warning says of the unit, empty where nothing, and how much larger than others."""
    unit = re.search(r"\(([^()]+ (?:among|beside) [^()]+)\?\)", text)
    times = re.search(r"([\d.e+]+) times (larger|smaller)", text)
    return unit[1] if unit else "", (
        f"{times[1]} times {times[2]} than" if times else "of another size than"
    )


def _of_size(text: str) -> Oddity:
    unit, how = _unit_and_factor(text)
    if unit:
        said = f"it is {how} the other subjects suggest, so it is in another unit ({unit}?): "
        return {"kind": UNIT, "text": said + "bring its files to the others' unit"}
    said = f"it is {how} the other subjects suggest: another shape, or another unit?"
    return {"kind": SIZE, "text": said}


def of_phases(said: Sequence[SpherePropagationWarning]) -> List[Oddity]:
    """What is odd about a subject whose phases are of several sizes, as propagation through them
    says."""
    odd: List[Oddity] = []
    for warning in said:
        if warning.message not in (*OF_SIZE, HALVES):
            continue
        unit, how = _unit_and_factor(str(warning))
        names = ", ".join(warning.layers)
        several = len(warning.layers) != 1
        text = f"its phase{'s' * several} {names}" if names else "half of its phases"
        text += f" {'are' if several else 'is'} {how} its others"
        if unit:
            text += f", so in another unit ({unit}?): bring all its files to one unit"
        one = {"kind": UNIT if unit else SIZE, "text": text}
        if one not in odd:
            odd.append(one)
    return odd


def _mirrored() -> Oddity:
    return {
        "kind": MIRRORED,
        "text": "it looks like a mirror image of the other subjects, a left one among right ones? "
        "Look at it; if it is, exclude it, or mirror its files where they were made",
    }


def _asked(warning: SpherePropagationWarning) -> str:
    """What a cohort's page says: of subjects, of which references are some."""
    said = re.sub(r'"reference \d+"', "another subject", warning.said.rstrip("."))
    said = said.replace("layers that it was compared with", "subjects that it was compared with")
    return said.replace(", and it is left as it is; look at it", ": look at it")


def references(frames: Sequence[Surface], landmarks: np.ndarray, root: int) -> np.ndarray:
    """Landmarks of REFERENCES frames, (frames, landmarks, 3): the root's, and evenly spread by
    size."""
    rest = [k for k in range(len(frames)) if k != root]
    picked = spread([frames[k] for k in rest], REFERENCES - 1)
    return np.asarray(landmarks)[[root, *(rest[k] for k in picked)]]


def spread(frames: Sequence[Surface], most: int = REFERENCES) -> List[int]:
    """Which of them, from the smallest to the largest, evenly."""
    order = np.argsort([abs(frame.volume) for frame in frames], kind="stable")
    count = min(len(order), most)
    return [int(order[i * (len(order) - 1) // max(count - 1, 1)]) for i in range(count)]


def as_surfaces(points: np.ndarray, faces: np.ndarray) -> List[Surface]:
    """With vertices in another order than landmarks have, which filters would know as such."""
    last = points.shape[1] - 1
    return [Surface(shape[::-1], last - faces, f"reference {k}") for k, shape in enumerate(points)]


def judge(
    frame: Surface, known: Sequence[Surface], root_map: Optional[SphereMap], sided: bool
) -> List[Oddity]:
    """known: references, the root's first, with its map; sided: whether sides can be told in this
    study."""
    if len(known) < 2 or root_map is None:
        return []
    with attention.collected() as said, warnings.catch_warnings():
        warnings.simplefilter("ignore")  # the log is of what is done with it
        try:
            filters.propagate([*known, frame], root_map, root_layer=0, order="Star", threads=1)
        except SpherePropagationError:
            return []  # what cannot be done is found by the steps after this one
    odd = found_in(said, len(known) + 1).get(frame.name, [])
    sided = sided and len(known) >= REFERENCES  # of few, one may look mirrored by chance
    return [one for one in odd if sided or one["kind"] != MIRRORED]


def words_of(record: Mapping[str, Any]) -> str:
    """What is odd about a subject; empty where nothing is."""
    return "; ".join(one["text"] for one in record.get("odd", ()))


def left_out(record: Mapping[str, Any], parameters: Mapping[str, Any]) -> str:
    """Why the models leave out a subject that was done; empty where they do not."""
    kinds = parameters["left_out"]
    return "; ".join(one["text"] for one in record.get("odd", ()) if one["kind"] in kinds)
