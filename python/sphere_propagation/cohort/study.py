# SPDX-License-Identifier: GPL-3.0-only
"""What a study is to be made like: one TOML file, all of it optional."""

from __future__ import annotations

from dataclasses import asdict, dataclass, field, fields
from pathlib import Path
from typing import Any, Callable, Dict, List, Mapping, Optional, Tuple, Union

from ..correspondence import SNAP_FREQUENCY
from ..errors import InputError
from ..parameters import DEFAULTS, NAMED, in_full, whole_numbers
from ..units import DEFAULT_UNIT, unit_named
from . import quality

ALIGNMENTS = ("Similarity", "Rigid", "None")  # by all landmarks
PHASE_ORDERS = ("Time", "Cyclic time", "Star", "Similarity tree")
LARGEST = "largest"
EXCLUDE = "exclude.csv"  # in the output folder
KINDS = ("another unit", "mirrored")  # of subjects that are not like the others


@dataclass(frozen=True)
class Study:
    """Every key of the TOML file with its default; docs/cohorts.md says what each means."""

    # label volumes, as sp.read_label_volume has them
    labels: Union[str, int, List[int]] = "1"
    voxel_size: float = 0.0
    smoothing: float = 1.0
    coordinates: str = "RAS"
    align_slices: bool = False
    handle_repair: str = NAMED["handle_repair"][0]
    longest_gap: int = 10
    skip_incomplete_phases: bool = False
    # input
    files: str = ""  # which of a subject's, as "anat/*_dseg.nii.gz"; empty: all that can be read
    unit: str = DEFAULT_UNIT  # of meshes
    exclude: str = EXCLUDE
    left_out: List[str] = field(default_factory=lambda: list(KINDS[:1]))  # the certain one
    # the atlas
    atlas_subjects: int = 200
    groupwise: bool = False
    initial_map: str = DEFAULTS.initial_map
    area_weight: float = DEFAULTS.area_weight
    # a subject
    root_phase: Union[str, int] = LARGEST
    order: str = "Cyclic time"
    area_restoration: float = 0.0
    frequency: int = 10
    anchors: str = ""
    anchor_sd: float = 0.0
    # the models
    alignment: str = ALIGNMENTS[0]
    modes: int = 100
    cycle_phases: int = 20
    systole: float = 0.35
    # jobs
    chunk: int = 0
    keep_surfaces: bool = True
    quality: Dict[str, Any] = field(default_factory=lambda: quality.checked({}))

    def part(self, *names: str) -> Dict[str, Any]:
        """Some of its keys, for the steps that depend on them."""
        return {name: getattr(self, name) for name in names}

    def as_dict(self) -> Dict[str, Any]:
        return asdict(self)


Check = Callable[[str, Any], Any]


def _wrong(key: str, allowed: str, value: Any) -> InputError:
    return InputError(f"{key} must be {allowed}, not {value!r}.")


def _number(minimum: float, maximum: Optional[float] = None, *, whole: bool = False) -> Check:
    kind = "a whole number" if whole else "a number"
    limits = f"of {minimum:g} or more" if maximum is None else f"from {minimum:g} to {maximum:g}"

    def check(key: str, value: Any):
        kinds = (int,) if whole else (int, float)
        fits = isinstance(value, kinds) and not isinstance(value, bool) and value >= minimum
        if not fits or (maximum is not None and value > maximum):
            raise _wrong(key, f"{kind} {limits}", value)
        return int(value) if whole else float(value)

    return check


def _flag(key: str, value: Any) -> bool:
    if not isinstance(value, bool):
        raise _wrong(key, "true or false", value)
    return value


def _text(key: str, value: Any) -> str:
    if not isinstance(value, str):
        raise _wrong(key, "a text in quotation marks", value)
    return value


def _choice(*choices: str) -> Check:
    def check(key: str, value: Any) -> str:
        words = in_full(key, value)
        if words not in choices:
            raise _wrong(key, "one of " + ", ".join(f'"{one.lower()}"' for one in choices), value)
        return words

    return check


def _labels(key: str, value: Any) -> str:
    fits = isinstance(value, (str, int, list)) and not isinstance(value, bool)
    try:
        if isinstance(value, str):
            value = [int(word) for word in value.replace(";", ",").split(",")]
        numbers = whole_numbers(key, value) if fits else []
    except (InputError, ValueError):
        numbers = []
    if not numbers or min(numbers) < 1:
        raise _wrong(key, 'a label, 1 or "1", or several that are united, [1, 2] or "1,2"', value)
    return ",".join(map(str, numbers))


def _root_phase(key: str, value: Any) -> Union[str, int]:
    if isinstance(value, str) and value.lower() == LARGEST:
        return LARGEST
    if not isinstance(value, int) or isinstance(value, bool) or value < 0:
        raise _wrong(key, f'"{LARGEST}", or the number of a phase, from 0', value)
    return value


def _unit(key: str, value: Any) -> str:
    return unit_named(value)


def _kinds(key: str, value: Any) -> List[str]:
    if not isinstance(value, list) or any(one not in KINDS for one in value):
        raise _wrong(key, "a list of " + " and ".join(f'"{one}"' for one in KINDS), value)
    return list(value)


def _quality(key: str, value: Any) -> Dict[str, Any]:
    if not isinstance(value, Mapping):
        raise _wrong(key, f"a table, [{key}]", value)
    return quality.checked(value)


CHECKS: Dict[str, Check] = {
    "labels": _labels,
    "voxel_size": _number(0),
    "smoothing": _number(0, 5),
    "coordinates": _choice(*NAMED["coordinates"]),
    "align_slices": _flag,
    "handle_repair": _choice(*NAMED["handle_repair"]),
    "longest_gap": _number(0, whole=True),
    "skip_incomplete_phases": _flag,
    "files": _text,
    "unit": _unit,
    "exclude": _text,
    "left_out": _kinds,
    "atlas_subjects": _number(1, 200, whole=True),
    "groupwise": _flag,
    "initial_map": _choice(*NAMED["initial_map"]),
    "area_weight": _number(0, 1),
    "root_phase": _root_phase,
    "order": _choice(*PHASE_ORDERS),
    "area_restoration": _number(0, 1),
    "frequency": _number(1, 100, whole=True),
    "anchors": _text,
    "anchor_sd": _number(0),
    "alignment": _choice(*ALIGNMENTS),
    "modes": _number(1, 1000, whole=True),
    "cycle_phases": _number(2, 200, whole=True),
    "systole": _number(0.05, 0.95),
    "chunk": _number(0, 1000, whole=True),
    "keep_surfaces": _flag,
    "quality": _quality,
}


def checked(given: Mapping[str, Any]) -> Study:
    """InputError, naming the key and what is allowed, where something cannot be what is meant."""
    known = [one.name for one in fields(Study)]
    for key in given:
        if key not in known:
            near = _nearest(key, known)
            raise InputError(
                f"The study has a key {key!r}, which means nothing"
                + (f"; is {near!r} meant?" if near else ".")
                + f" Keys that there are: {', '.join(known)}."
            )
    defaults = Study().as_dict()
    made = Study(**{key: CHECKS[key](key, given.get(key, defaults[key])) for key in known})
    if made.anchors and made.frequency % SNAP_FREQUENCY:
        raise _wrong("frequency", f"a multiple of {SNAP_FREQUENCY}, for anchors", made.frequency)
    return made


def _nearest(key: str, known: List[str]) -> str:
    from difflib import get_close_matches

    found = get_close_matches(key.lower().replace("-", "_"), known, 1)
    return found[0] if found else ""


def read_study(path: Union[None, str, Path]) -> Tuple[Study, Path]:
    """The study that a TOML file describes, and the folder that its paths are relative to."""
    if path is None:
        return checked({}), Path.cwd()
    path = Path(path)
    if not path.is_file():
        raise InputError(f"--config: there is no file {path}.")
    try:
        import tomllib
    except ImportError as error:
        raise InputError("cohort takes Python 3.11 or later, as Snakemake does.") from error
    try:
        with open(path, "rb") as file:
            given = tomllib.load(file)
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise InputError(f"{path} is no TOML file: {error}") from error
    try:
        return checked(given), path.resolve().parent
    except InputError as error:
        raise InputError(f"{path}: {error}") from error
