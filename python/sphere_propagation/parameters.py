# SPDX-License-Identifier: GPL-3.0-only
"""The parameters of the whole job, with their choices and defaults; tests compare them with the
filters'."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path
from typing import List, Mapping, Optional, Sequence, Union

import numpy as np

from .errors import InputError

INITIAL_MAPS = ("Automatic", "Brechbuehler", "Harmonic")
METHODS = ("Robust", "As published")
ORDERS = ("Time", "Cyclic time", "Similarity tree", "Star", "Given")

# What else the choices of a parameter may be called, in Python and on the command line: the short
# words that the command has always had.
SHORT = {
    "published": "As published",
    "cyclic": "Cyclic time",
    "similarity": "Similarity tree",
    "icosphere": "Common icosphere",
    "union": "Union of both connectivities",
    "model": "Shape model",
}
# The parameters that have choices, of all filters and of correspond.
NAMED = {
    "initial_map": INITIAL_MAPS,
    "method": METHODS,
    "order": ORDERS,
    "alignment": ("Similarity", "Rigid", "None", "Anchors", "Scaled anchors"),
    "objective": ("Population model", "Description length"),
    "pattern": ("Checkerboard", "Latitude and longitude", "Direction", "Area ratio"),
    "part": ("Cavity", "Wall"),
    "pose": ("Search", "As it lies", "Anchors"),
    "connectivity": ("Common icosphere", "Union of both connectivities"),
    "along": ("Linear", "Shape model"),
    "coordinates": ("RAS", "LPS"),
    "handle_repair": ("Whichever changes less", "Cut", "Fill"),
    "lid": ("Curved", "Flat"),
    "leave_out_lids": ("Most shapes", "Any shape", "Never"),
}

Parents = Union[str, Sequence[int]]  # as "-1, 0, 1", or a list of numbers

# A folder of files with anchors, called as the surfaces are; or per surface a dictionary, name ->
# (x, y, z), or None.
Anchors = Union[None, str, Path, Sequence[Optional[Mapping[str, Sequence[float]]]]]


# A file of places on the sphere, or name -> (x, y, z) or (longitude, latitude) in degrees.
AnchorPositions = Union[None, str, Path, Mapping[str, Sequence[float]]]


# The parameters that are on or off, of all filters.
FLAGS = (
    "align_slices",
    "all_visible",
    "anchor_pose",
    "anchor_snap",
    "anisotropic_scaling",
    "area_weights",
    "close_openings",
    "closed",
    "color_landmarks",
    "cut_handles",
    "ends",
    "file_series",
    "fill_holes",
    "join_shells",
    "keep_largest_component",
    "local_deviation",
    "mirror_layers",
    "most_central",
    "orient",
    "remove_duplicate_faces",
    "remove_fins",
    "remove_handles",
    "residual_quality",
    "root_error_quality",
    "skip_incomplete_phases",
    "surface_measures",
    "uncertainty_quality",
    "weld",
)


MOST_CENTRAL = "most central"  # the surface that is the most like all others

# The number of a surface, MOST_CENTRAL, or None: the largest.
Root = Union[None, int, str]


@dataclass(frozen=True, eq=False)
class CorrespondenceParameters:
    """What correspond() can be told beside its surfaces, where it says what each means."""

    root: Root = None
    method: str = "Robust"
    order: str = "Time"
    parents: Parents = ""
    frequency: int = 10
    initial_map: str = "Automatic"
    area_weight: float = 0.9
    area_restoration: float = 0.0
    mirror_layers: bool = False
    groupwise: bool = False
    anchors: Anchors = None
    anchor_sd: float = 0.0
    exact: bool = False
    anchor_snap: bool = False
    anchor_pose: bool = False
    anchor_positions: AnchorPositions = None
    uncertainty: bool = False


DEFAULTS = CorrespondenceParameters()


def whole_numbers(name: str, values) -> List[int]:
    """One or several, of any type; 1.5 is not taken for 1, nor is True."""
    try:
        numbers = np.atleast_1d(np.asarray(values, dtype=float))
        if any(isinstance(value, (bool, np.bool_)) for value in np.ravel(np.array(values, object))):
            raise TypeError
    except (TypeError, ValueError):
        numbers = np.array([np.nan])
    if numbers.ndim != 1 or not np.isfinite(numbers).all() or (numbers != np.floor(numbers)).any():
        raise InputError(f"{name} must be whole numbers, not {values!r}.")
    return [int(number) for number in numbers]


def whole_number(name: str, value) -> int:
    """One, of any type."""
    numbers = whole_numbers(name, value)
    if len(numbers) != 1:
        raise InputError(f"{name} must be a whole number, not {value!r}.")
    return numbers[0]


def real_number(name: str, value, finite: bool = True) -> float:
    """One, of any type; True is not taken for 1."""
    try:
        if isinstance(value, (bool, np.bool_)):
            raise TypeError
        number = float(value)
    except (TypeError, ValueError, OverflowError):
        raise InputError(f"{name} must be a number, not {value!r}.") from None
    if finite and not np.isfinite(number):
        raise InputError(f"{name} must be a number, not {value!r}.")
    return number


def in_full(name: str, value):
    """A choice as the filters spell it, from any case and from the short words; anything else as it
    is."""
    choices = NAMED.get(name, ())
    if not isinstance(value, str) or value in choices:
        return value
    word = re.sub(r"[\s_-]+", " ", value.strip()).lower()
    words = (word, SHORT.get(word, word).lower())
    return next((choice for choice in choices if choice.lower() in words), value)


def require_choice(name: str, value, choices: Sequence[str]) -> None:
    """InputError where it is none of them."""
    if not isinstance(value, str) or value not in choices:
        raise InputError(f"{name} must be one of {', '.join(map(repr, choices))}, not {value!r}.")


def listed(name: str, values) -> list:
    """Several of something, as a list."""
    try:
        return list(values)
    except TypeError:
        raise InputError(f"{name} must be a list, not {type(values).__name__}.") from None


def path_of(path) -> Path:
    """A path, from a text or a path."""
    try:
        return Path(path)
    except TypeError as error:
        raise InputError(f"A path must be a text, not {type(path).__name__}.") from error


def parent_numbers(parents: Parents) -> List[int]:
    """The numbers of parents; in a text, as the filter reads it, between commas, semicolons and
    blanks."""
    if not isinstance(parents, str):
        return whole_numbers("parents", parents)
    words = re.split(r"[,;\s]+", parents.strip(",; \t\n\r\f\v"))
    if not all(re.fullmatch(r"[+-]?[0-9]+", word) for word in words):
        raise InputError(f'parents must be whole numbers, as "-1,0,1", not {parents!r}.')
    return [int(word) for word in words]
